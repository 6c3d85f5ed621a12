//! What a revolution saw, as from one moment: each beam moved by what the robot drove since.

use super::PoseHistory;
use crate::geometry::{Point, Pose, Vector};
use crate::map::{Scan, TimedScan};

/// A revolution without the skew that motion gave it. Points are in the robot's frame at the time of the view.
#[derive(Clone, Debug, Default)]
pub struct DeskewedScan {
    /// The moment from which it is seen, seconds.
    pub time_s: f64,
    /// Where beams ended.
    pub hits: Vec<Hit>,
    /// Where beams that met nothing within the sensor's longest range began and went.
    pub open: Vec<Ray>,
    /// Beams without a measurement.
    pub unmeasured: usize,
    /// Longest range of the sensor, metres.
    pub range_max: f64,
}

/// The end of a beam, and where the lidar was when it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where the lidar was.
    pub from: Point,
    /// Where the beam ended.
    pub end: Point,
}

/// A beam without an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the lidar was.
    pub from: Point,
    /// Its direction, of unit length.
    pub direction: Vector,
}

impl DeskewedScan {
    /// Looks at a sweep from where the odometry of a track was at its newest pose. Where the track is empty the robot has not moved.
    ///
    /// Memory is used again: a view that has seen as many beams before allocates nothing.
    pub fn take(&mut self, sweep: &TimedScan, track: &PoseHistory) {
        self.hits.clear();
        self.open.clear();
        self.hits.reserve(sweep.beams.len());
        self.open.reserve(sweep.beams.len());
        (self.unmeasured, self.range_max) = (0, sweep.range_max);
        let newest = track.newest();
        let here = newest.map_or_else(Pose::default, |(_, pose)| pose);
        self.time_s =
            newest.map_or_else(|| sweep.end_s().unwrap_or_default(), |(time_s, _)| time_s);
        let (sin_here, cos_here) = libm::sincos(here.yaw);
        for beam in &sweep.beams {
            let is_hit = (0.0..=sweep.range_max).contains(&beam.range);
            if !(is_hit || beam.range == f64::INFINITY) || !beam.angle.is_finite() {
                self.unmeasured += 1;
                continue;
            }
            let then = track.at(beam.time_s).unwrap_or(here);
            let (x, y) = (then.x - here.x, then.y - here.y);
            let from = Point::new(cos_here * x + sin_here * y, cos_here * y - sin_here * x);
            let (sin, cos) = libm::sincos(then.yaw - here.yaw + beam.angle);
            let direction = Vector::new(cos, sin);
            if is_hit {
                let end = from + beam.range * direction;
                self.hits.push(Hit { from, end });
            } else {
                self.open.push(Ray { from, direction });
            }
        }
    }

    /// The same as a scan of so many equal angles over a full turn: in each direction the nearest of what was hit.
    #[must_use]
    pub fn scan(&self, beams: usize) -> Scan {
        let open = |ray: &Ray| (libm::atan2(ray.direction.y, ray.direction.x), f64::INFINITY);
        let hit = |hit: &Hit| (libm::atan2(hit.end.y, hit.end.x), hit.end.coords.norm());
        // What the robot drove since may have made a way longer.
        let farthest = self.hits.iter().map(|hit| hit.end.coords.norm());
        let range_max = farthest.fold(self.range_max, f64::max);
        let measured = self.open.iter().map(open);
        Scan::from_measurements(beams, range_max, measured.chain(self.hits.iter().map(hit)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::map::Beam;

    /// A robot that drives a curve while its lidar turns sees a post at the same place all the while.
    #[test]
    fn motion_does_not_smear_a_post() {
        let (mut track, twist) = (PoseHistory::new(), Twist::new(1.0, 0.8));
        let start = Pose::new(4.0, 2.0, -1.0);
        (0..=10).for_each(|tick| {
            let time_s = 0.01 * f64::from(tick);
            track.record(time_s, &start.after(&twist, time_s));
        });
        let post = Point::new(6.0, 1.0);
        let beam = |index: u32| {
            let time_s = 0.001 * f64::from(index);
            let seen = start.after(&twist, time_s).inverse_transform(&post);
            Beam {
                angle: libm::atan2(seen.y, seen.x),
                range: seen.coords.norm(),
                time_s,
            }
        };
        let mut sweep = TimedScan {
            beams: (0..=100).map(beam).collect(),
            range_max: 10.0,
        };
        sweep.beams[50].range = f64::INFINITY;
        sweep.beams[51].range = f64::NAN;
        sweep.beams[52].range = -1.0;
        let mut view = DeskewedScan::default();
        view.take(&sweep, &track);
        assert_eq!(
            (view.hits.len(), view.open.len(), view.unmeasured),
            (98, 1, 2)
        );
        let here = start.after(&twist, 0.1);
        for hit in &view.hits {
            assert!((here.transform(&hit.end) - post).norm() < 1e-9);
        }
        // As it was measured it is smeared over centimetres.
        let raw = &sweep.beams[0];
        let (sin, cos) = libm::sincos(raw.angle);
        let smeared = here.transform(&Point::new(raw.range * cos, raw.range * sin));
        assert!((smeared - post).norm() > 0.05);
        let scan = view.scan(360);
        let ends: Vec<Point> = scan.hits(&here).collect();
        assert!(!ends.is_empty());
        // Within half a beam's angle.
        assert!(
            ends.iter().all(|end| (end - post).norm() < 0.03),
            "{ends:?}"
        );
    }
}
