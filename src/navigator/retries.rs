//! How often a robot without a path looks for one again.

use crate::geometry::Point;

/// The robot looks for a path again at most this many times after none remained, at places this far apart, metres, without having
/// come nearer to its goal (Nav2: `number_of_retries`). Otherwise it could drive for ever between two blocked paths.
const RETRIES: u32 = 6;
const RETRY_APART_M: f64 = 3.0;

/// Counts the places at which no path remained, since the robot was nearest to its goal.
#[derive(Clone, Debug, Default)]
pub(super) struct Retries {
    /// Least length left on any path so far, metres.
    least_left_m: Option<f64>,
    count: u32,
    place: Option<Point>,
}

impl Retries {
    /// Begins again once the robot has come nearer to its goal, along the path, by this much, metres.
    pub fn advance(&mut self, left_m: f64, radius_m: f64) {
        if self.least_left_m.is_none_or(|least_m| left_m <= least_m - radius_m) {
            *self = Self { least_left_m: Some(left_m), ..Self::default() };
        }
    }

    /// Counts a place. A robot that waits at one place has tried once.
    pub fn add(&mut self, robot: &Point) {
        if self.place.is_none_or(|place| (robot - place).norm() > RETRY_APART_M) {
            self.count += 1;
            self.place = Some(*robot);
        }
    }

    /// Whether it is time to give up, if the last plan found no path.
    pub const fn are_used_up(&self) -> bool {
        self.count > RETRIES
    }
}
