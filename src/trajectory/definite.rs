//! Relations whose times are precise enough for a log.

use super::by_time::ByTime;
use super::{Relation, TimedPose};
use crate::geometry::{Pose, wrap_angle};

/// Poses nearer to each other than this are the same, metres and radians.
const SAME_M: f64 = 0.01;
const SAME_RAD: f64 = 0.01;

/// The relations whose times name one pose each of a log, by its odometry. `offset_s` is the time of the relations minus that of
/// the log, seconds.
///
/// Logs print times with few digits. Of several records with the same time, or with neighbouring ones, none is surely the one
/// that a relation means. Their relations are left out, unless the robot stood.
#[must_use]
pub fn definite_relations(
    odometry: &[TimedPose],
    relations: &[Relation],
    offset_s: f64,
) -> Vec<Relation> {
    let digits = odometry.iter().map(|it| significant_digits(it.time_s)).max().unwrap_or(0);
    let ordered = ByTime::new(odometry, 0.0);
    let is_definite = |time_s: f64| {
        // In the log's own times, whose digits count.
        let time_s = time_s - offset_s;
        let Some((nearest, gap_s)) = ordered.nearest(time_s) else {
            return false;
        };
        let reach_s = gap_s + resolution_s(time_s, digits);
        ordered.within(time_s, reach_s).all(|it| is_same(&it.pose, &nearest.pose))
    };
    let all = relations.iter().copied();
    all.filter(|relation| relation.times_s.iter().all(|&time_s| is_definite(time_s))).collect()
}

fn is_same(one: &Pose, other: &Pose) -> bool {
    (one.position() - other.position()).norm() <= SAME_M
        && wrap_angle(one.yaw - other.yaw).abs() <= SAME_RAD
}

/// Number of decimal digits from the first that is not zero to the last.
fn significant_digits(number: f64) -> i32 {
    let text = format!("{number:e}");
    let digits = text.split('e').next().unwrap_or_default();
    digits.bytes().filter(u8::is_ascii_digit).count() as i32
}

/// The last of this many significant digits of a time, seconds.
fn resolution_s(time_s: f64, digits: i32) -> f64 {
    let first = libm::floor(libm::log10(time_s.abs().max(f64::MIN_POSITIVE))) as i32;
    libm::pow(10.0, f64::from(first + 1 - digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn driving(times_s: &[f64]) -> Vec<TimedPose> {
        let pose = |(step, &time_s): (usize, &f64)| TimedPose {
            time_s,
            pose: Pose::new(0.1 * step as f64, 0.0, 0.0),
        };
        times_s.iter().enumerate().map(pose).collect()
    }

    fn between(from_s: f64, to_s: f64) -> Relation {
        Relation { times_s: [from_s, to_s], motion: Pose::default() }
    }

    /// Six digits: thousandths before 1,000 s, hundredths after.
    #[test]
    fn relation_is_definite_where_the_digits_tell_its_records_apart() {
        let log = driving(&[998.113, 998.119, 1998.11, 1998.12, 1998.31, 1998.31, 1998.51]);
        let relations = [
            between(1998.113, 1998.508), // The third or the fourth record, and the last.
            between(1998.508, 998.1132), // The last and the first.
            between(998.1132, 998.1188), // The first and the second.
            between(998.1132, 1998.31),  // Two records have the second time.
            between(998.1132, 1998.7),   // No record has it, but the last one is nearest.
        ];
        let offset = 1000.0;
        let shifted = relations
            .map(|it| Relation { times_s: it.times_s.map(|time_s| time_s + offset), ..it });
        let kept = definite_relations(&log, &shifted, offset);
        assert_eq!(kept, [shifted[1], shifted[2], shifted[4]]);
    }

    #[test]
    fn records_of_a_robot_that_stood_are_the_same() {
        let mut log = driving(&[1998.11, 1998.12, 1998.31]);
        let relation = [between(1998.113, 1998.31)];
        assert_eq!(definite_relations(&log, &relation, 0.0), []);
        log[1].pose = log[0].pose;
        assert_eq!(definite_relations(&log, &relation, 0.0), relation);
        assert_eq!(definite_relations(&[], &relation, 0.0), []);
    }

    #[test]
    fn digits_are_counted_from_the_first_that_is_not_zero() {
        assert_eq!([0.0, 0.000_246, 32.9, 976_052_857.34].map(significant_digits), [1, 3, 3, 11]);
        assert!((resolution_s(1998.1, 6) - 0.01).abs() < 1e-12);
        assert!((resolution_s(998.1, 6) - 0.001).abs() < 1e-12);
    }
}
