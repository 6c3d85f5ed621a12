//! Motion compensation of a lidar revolution.

use super::PoseHistory;
use crate::geometry::{Point, Pose, Vector};
use crate::map::{Scan, TimedScan};

/// A revolution without motion distortion. Points are in the robot's frame at the time of the scan.
#[derive(Clone, Debug, Default)]
pub struct DeskewedScan {
    /// Reference time, seconds.
    pub time_s: f64,
    /// Beams with a return.
    pub hits: Vec<Hit>,
    /// Beams with nothing within the sensor's range.
    pub open: Vec<Ray>,
    /// Beams without a measurement.
    pub unmeasured: usize,
    /// Longest range of the sensor, metres.
    pub range_max: f64,
}

/// A beam with a return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position of the lidar at the time of the beam.
    pub from: Point,
    /// End of the beam.
    pub end: Point,
}

/// A beam without a return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Position of the lidar at the time of the beam.
    pub from: Point,
    /// Direction, of unit length.
    pub direction: Vector,
}

impl DeskewedScan {
    /// Transforms all beams to the robot's frame at the newest pose of an odometry history. With an empty history, the
    /// robot has not moved.
    ///
    /// Reuses its memory: no allocation for at most as many beams as before.
    pub fn deskew(&mut self, scan: &TimedScan, history: &PoseHistory) {
        self.hits.clear();
        self.open.clear();
        self.hits.reserve(scan.beams.len());
        self.open.reserve(scan.beams.len());
        (self.unmeasured, self.range_max) = (0, scan.range_max);
        let newest = history.newest();
        let here = newest.map_or_else(Pose::default, |(_, pose)| pose);
        self.time_s = newest.map_or_else(|| scan.end_s().unwrap_or_default(), |(time_s, _)| time_s);
        let (sin_here, cos_here) = libm::sincos(here.yaw);
        for beam in &scan.beams {
            let is_hit = (0.0..=scan.range_max).contains(&beam.range);
            if !(is_hit || beam.range == f64::INFINITY) || !beam.angle.is_finite() {
                self.unmeasured += 1;
                continue;
            }
            let then = history.at(beam.time_s).unwrap_or(here);
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

    /// Resamples the beams to a full-turn scan of `beams` equal angles, with the nearest return in each direction.
    #[must_use]
    pub fn to_scan(&self, beams: usize) -> Scan {
        let open = |ray: &Ray| (libm::atan2(ray.direction.y, ray.direction.x), f64::INFINITY);
        let hit = |hit: &Hit| (libm::atan2(hit.end.y, hit.end.x), hit.end.coords.norm());
        // Robot motion can increase a range beyond the sensor's.
        let max_hit_m = self.hits.iter().map(|hit| hit.end.coords.norm());
        let range_max = max_hit_m.fold(self.range_max, f64::max);
        let measured = self.open.iter().map(open);
        Scan::from_measurements(beams, range_max, measured.chain(self.hits.iter().map(hit)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::map::Beam;

    /// A robot drives a curve while its lidar turns; a post stays at the same place in every beam.
    #[test]
    fn deskewing_removes_motion_distortion_of_a_post() {
        let (mut history, twist) = (PoseHistory::new(), Twist::new(1.0, 0.8));
        let start = Pose::new(4.0, 2.0, -1.0);
        (0..=10).for_each(|tick| {
            let time_s = 0.01 * f64::from(tick);
            history.record(time_s, &start.after(&twist, time_s));
        });
        let post = Point::new(6.0, 1.0);
        let beam = |index: u32| {
            let time_s = 0.001 * f64::from(index);
            let seen = start.after(&twist, time_s).inverse_transform(&post);
            Beam { angle: libm::atan2(seen.y, seen.x), range: seen.coords.norm(), time_s }
        };
        let mut timed = TimedScan { beams: (0..=100).map(beam).collect(), range_max: 10.0 };
        timed.beams[50].range = f64::INFINITY;
        timed.beams[51].range = f64::NAN;
        timed.beams[52].range = -1.0;
        let mut deskewed = DeskewedScan::default();
        deskewed.deskew(&timed, &history);
        assert_eq!((deskewed.hits.len(), deskewed.open.len(), deskewed.unmeasured), (98, 1, 2));
        let here = start.after(&twist, 0.1);
        for hit in &deskewed.hits {
            assert!((here.transform(&hit.end) - post).norm() < 1e-9);
        }
        // Without deskewing, the ends are spread over centimetres.
        let raw = &timed.beams[0];
        let (sin, cos) = libm::sincos(raw.angle);
        let smeared = here.transform(&Point::new(raw.range * cos, raw.range * sin));
        assert!((smeared - post).norm() > 0.05);
        let scan = deskewed.to_scan(360);
        let ends: Vec<Point> = scan.hits(&here).collect();
        assert!(!ends.is_empty());
        // Within half a beam's angle.
        assert!(ends.iter().all(|end| (end - post).norm() < 0.03), "{ends:?}");
    }
}
