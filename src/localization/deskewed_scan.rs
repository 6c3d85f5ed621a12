//! Motion compensation of a lidar revolution by a short history of poses.

use core::f64::consts::TAU;
use std::collections::VecDeque;

use crate::geometry::{Point, Pose, Vector, wrap_angle};
use crate::map::{Scan, TimedScan};

/// Length of the history, seconds: a few lidar revolutions.
const HISTORY_S: f64 = 1.0;

/// Largest number of poses, whatever their times.
const MAX_POSES: usize = 1024;

/// A lidar that measures in all directions leaves no wider angle between two beams, radians, or than twice the mean one: a lost
/// packet leaves such a gap.
const WIDEST_GAP: f64 = 0.26;
/// Narrowest field of view of a lidar, radians.
const NARROWEST_FIELD: f64 = 0.1;

/// The poses of the last second, or of a whole log.
#[derive(Clone, Debug, Default)]
pub struct PoseHistory {
    rows: VecDeque<(f64, Pose)>,
    keeps_all: bool,
}

impl PoseHistory {
    /// Creates an empty history with preallocated memory.
    #[must_use]
    pub fn new() -> Self {
        Self { rows: VecDeque::with_capacity(MAX_POSES), keeps_all: false }
    }

    /// Creates an empty history that keeps all poses, for logs.
    #[must_use]
    pub fn of_log() -> Self {
        Self { keeps_all: true, ..Self::default() }
    }

    /// Records a pose at a time, seconds. A pose at the same time as the last replaces it; an earlier time clears the
    /// history; values that are not finite are ignored.
    pub fn record(&mut self, time_s: f64, pose: &Pose) {
        if !(time_s.is_finite() && pose.is_finite()) {
            return;
        }
        match self.rows.back().map(|(last_s, _)| *last_s) {
            Some(last_s) if time_s < last_s => self.rows.clear(),
            Some(last_s) if time_s == last_s => {
                self.rows.pop_back();
            }
            _ => {}
        }
        // One pose older than the limit is kept for interpolation.
        while !self.keeps_all
            && (self.rows.len() >= MAX_POSES
                || self.rows.get(1).is_some_and(|(next_s, _)| time_s - next_s > HISTORY_S))
        {
            self.rows.pop_front();
        }
        self.rows.push_back((time_s, *pose));
    }

    /// The oldest time and pose.
    #[must_use]
    pub fn oldest(&self) -> Option<(f64, Pose)> {
        self.rows.front().copied()
    }

    /// The newest time and pose.
    #[must_use]
    pub fn newest(&self) -> Option<(f64, Pose)> {
        self.rows.back().copied()
    }

    /// The pose at a time, seconds, interpolated along an arc between the adjacent poses. Times outside the history give its
    /// first or last pose. None if it is empty.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<Pose> {
        let after = self.rows.partition_point(|(row_s, _)| *row_s <= time_s);
        let Some(&(before_s, before)) = after.checked_sub(1).and_then(|row| self.rows.get(row))
        else {
            return self.rows.front().map(|(_, pose)| *pose);
        };
        let Some(&(after_s, after)) = self.rows.get(after) else {
            return Some(before);
        };
        Some(before.interpolate(&after, (time_s - before_s) / (after_s - before_s)))
    }

    /// Distance and turn between the newest pose and the one this many seconds before it, metres and radians.
    pub(super) fn motion_within(&self, time_s: f64) -> [f64; 2] {
        let Some((now_s, now)) = self.newest() else {
            return [0.0; 2];
        };
        let before = self.at(now_s - time_s).unwrap_or(now);
        let distance_m = (before.position() - now.position()).norm();
        [distance_m, wrap_angle(now.yaw - before.yaw).abs()]
    }
}

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
    /// Place of the lidar at the time of the scan, in the robot's frame.
    pub(crate) origin: Point,
    /// Longest range of the sensor, metres.
    pub range_max: f64,
    /// For each beam its direction in the robot's frame at its own time, and the heading of that frame in this one, radians.
    pub(crate) directions: Vec<(f64, f64)>,
    /// The beams of `hits` and `open` in the order of the scan: the index of the hit, or `None` for an open beam.
    pub(crate) order: Vec<Option<usize>>,
}

/// A beam with a return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position of the lidar at the time of the beam.
    pub from: Point,
    /// End of the beam.
    pub end: Point,
    /// Whether it is on an object as narrow as a person that stands alone.
    pub is_alone: bool,
}

impl Hit {
    /// Length of the beam, metres.
    pub(super) fn range_m(&self) -> f64 {
        (self.end - self.from).norm()
    }
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
        (self.unmeasured, self.range_max, self.origin) = (0, scan.range_max, scan.origin);
        self.directions.clear();
        self.order.clear();
        let newest = history.newest();
        let here = newest.map_or_else(Pose::default, |(_, pose)| pose);
        self.time_s = newest.map_or_else(|| scan.end_s().unwrap_or_default(), |(time_s, _)| time_s);
        let (sin_here, cos_here) = libm::sincos(here.yaw);
        for beam in &scan.beams {
            if !beam.angle.is_finite() {
                self.unmeasured += 1;
                continue;
            }
            let then = history.at(beam.time_s).unwrap_or(here);
            let (x, y) = (then.x - here.x, then.y - here.y);
            let robot = Pose::new(
                cos_here * x + sin_here * y,
                cos_here * y - sin_here * x,
                wrap_angle(then.yaw - here.yaw),
            );
            self.directions.push((wrap_angle(beam.angle), robot.yaw));
            let is_hit = beam.is_return(scan.range_max);
            if !(is_hit || beam.range == f64::INFINITY) {
                self.unmeasured += 1;
                continue;
            }
            let from = robot.transform(&scan.origin);
            let (sin, cos) = libm::sincos(robot.yaw + beam.angle);
            let direction = Vector::new(cos, sin);
            if is_hit {
                let end = from + direction * beam.range;
                self.order.push(Some(self.hits.len()));
                self.hits.push(Hit { from, end, is_alone: false });
            } else {
                self.order.push(None);
                self.open.push(Ray { from, direction });
            }
        }
    }

    /// The first direction of the lidar's field of view at the time of the scan, and its angle counter-clockwise from there, radians.
    /// `None` where it is a full turn.
    fn field_of_view(&self) -> Option<(f64, f64)> {
        let mut directions = self.directions.clone();
        directions.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        let (first, last) = (*directions.first()?, *directions.last()?);
        let pairs = directions.windows(2).map(|pair| (pair[0], pair[1], pair[1].0 - pair[0].0));
        let around = (last, first, first.0 + TAU - last.0);
        let (last, first, gap) =
            pairs.fold(around, |widest, pair| if pair.2 > widest.2 { pair } else { widest });
        let mean = TAU / directions.len() as f64;
        let is_fan = gap > WIDEST_GAP.max(2.0 * mean) && TAU - gap >= NARROWEST_FIELD;
        // The first and the last beam are from different times.
        let turn = TAU - gap + last.1 - first.1;
        (is_fan && turn > 0.0 && turn < TAU).then_some((first.0 + first.1, turn))
    }

    /// Resamples the beams to a scan of `beams` equal angles within the lidar's field of view, with the nearest return in each
    /// direction.
    #[must_use]
    pub fn to_scan(&self, beams: usize) -> Scan {
        let open = |ray: &Ray| (libm::atan2(ray.direction.y, ray.direction.x), f64::INFINITY);
        let along = |hit: &Hit| hit.end - self.origin;
        let hit = |along: Vector| (libm::atan2(along.y, along.x), along.norm());
        // Robot motion can increase a range beyond the sensor's.
        let max_hit_m = self.hits.iter().map(|hit| along(hit).norm());
        let range_max = max_hit_m.fold(self.range_max, f64::max);
        let measured = self.open.iter().map(open).chain(self.hits.iter().map(along).map(hit));
        let scan = match self.field_of_view() {
            Some(field) => Scan::from_measurements_within(field, beams, range_max, measured),
            None => Scan::from_measurements(beams, range_max, measured),
        };
        Scan { origin: self.origin, ..scan }
    }
}
