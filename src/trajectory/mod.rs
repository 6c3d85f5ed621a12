//! Accuracy of estimated trajectories.
//!
//! Absolute and relative errors follow Sturm, Engelhard, Endres, Burgard and Cremers, "A Benchmark for the Evaluation of RGB-D
//! SLAM Systems", IROS 2012. Errors of relations follow Kuemmerle, Steder, Dornhege, Ruhnke, Grisetti, Stachniss and Kleiner,
//! "On Measuring the Accuracy of SLAM Algorithms", Autonomous Robots, 2009.

mod bridge;
mod by_time;
mod definite;
mod errors;
mod relations;

pub use bridge::{LoggedPose, bridge};
pub use definite::definite_relations;
pub use errors::{AbsoluteError, RelativeError, absolute_error, relative_error};
pub use relations::{Relation, RelationError, RelationFileError, read_relations, relation_error};

use crate::geometry::Pose;

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedPose {
    /// Time, seconds.
    pub time_s: f64,
    /// The pose, metres and radians.
    pub pose: Pose,
}

/// Mean, standard deviation, root mean square, median and largest value of errors that are zero or more.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ErrorStatistics {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of all values about the mean.
    pub sd: f64,
    /// Root of the mean square.
    pub rmse: f64,
    /// Median; the mean of the two in the middle of an even number.
    pub median: f64,
    /// Largest value.
    pub max: f64,
}

impl ErrorStatistics {
    /// The statistics of values; none without values.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|value| value * value).sum::<f64>() / count;
        let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
        values.sort_by(f64::total_cmp);
        Some(Self {
            mean,
            sd: (variance / count).sqrt(),
            rmse: squares.sqrt(),
            median: f64::midpoint(values[(values.len() - 1) / 2], values[values.len() / 2]),
            max: values[values.len() - 1],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, and as `statistics.median` and `statistics.pstdev` of Python.
    #[test]
    fn statistics_of_an_odd_and_an_even_number_of_values() {
        let odd = ErrorStatistics::of(vec![3.0, 0.0, 1.0]).expect("values");
        assert_eq!((odd.median, odd.max), (1.0, 3.0));
        let even = ErrorStatistics::of(vec![1.0, 7.0, 1.0, 3.0]).expect("values");
        assert_eq!((even.mean, even.median, even.max), (3.0, 2.0, 7.0));
        assert_eq!((even.sd, even.rmse), (6.0_f64.sqrt(), 15.0_f64.sqrt()));
        assert_eq!(ErrorStatistics::of(Vec::new()), None);
    }
}
