//! Poses between the scans of a log.

use super::TimedPose;
use crate::geometry::{Pose, wrap_angle};

/// A turn of one radian moves as far as this distance, metres, when an error is distributed along a path.
const TURN_M_PER_RAD: f64 = 0.3;

/// A pose by odometry, and the estimated pose where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedPose {
    /// Time, seconds.
    pub time_s: f64,
    /// Pose by odometry.
    pub odometry: Pose,
    /// Estimated pose.
    pub estimate: Option<Pose>,
}

/// The trajectory at all times between the first and the last estimate. Between two estimates it follows odometry from both,
/// and moves from the one to the other in proportion to the distance travelled.
#[must_use]
pub fn bridge(poses: &[LoggedPose]) -> Vec<TimedPose> {
    let mut bridged = Vec::new();
    let known: Vec<(usize, Pose)> = poses
        .iter()
        .enumerate()
        .filter_map(|(index, logged)| logged.estimate.map(|pose| (index, pose)))
        .collect();
    for ends in known.windows(2) {
        let [(from, start), (to, end)] = [ends[0], ends[1]];
        let mut travelled = vec![0.0; to - from + 1];
        for step in 1..travelled.len() {
            let (before, now) = (&poses[from + step - 1].odometry, &poses[from + step].odometry);
            let moved_m = (now.position() - before.position()).norm();
            let turned = wrap_angle(now.yaw - before.yaw).abs();
            travelled[step] = travelled[step - 1] + moved_m + TURN_M_PER_RAD * turned;
        }
        let whole = travelled[to - from];
        for (step, travelled) in travelled.iter().enumerate().take(to - from) {
            let logged = &poses[from + step];
            let along = |from: &LoggedPose, pose: &Pose| {
                pose.transform_pose(&from.odometry.inverse_transform_pose(&logged.odometry))
            };
            let (forward, backward) = (along(&poses[from], &start), along(&poses[to], &end));
            let fraction = if whole > 0.0 { travelled / whole } else { 0.0 };
            let pose = forward.interpolate(&backward, fraction);
            bridged.push(TimedPose { time_s: logged.time_s, pose });
        }
    }
    if let Some(&(last, pose)) = known.last() {
        bridged.push(TimedPose { time_s: poses[last].time_s, pose });
    }
    bridged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bridge_follows_odometry_and_meets_both_estimates() {
        let logged = |step: usize, estimate| LoggedPose {
            time_s: step as f64,
            odometry: Pose::new(step as f64, 0.0, 0.0),
            estimate,
        };
        let poses = [
            logged(0, None),
            logged(1, Some(Pose::new(5.0, 0.0, 0.0))),
            logged(2, None),
            logged(3, Some(Pose::new(7.0, 0.4, 0.0))),
            logged(4, None),
        ];
        let bridged = bridge(&poses);
        let times: Vec<f64> = bridged.iter().map(|it| it.time_s).collect();
        assert_eq!(times, [1.0, 2.0, 3.0]);
        assert_eq!(bridged[0].pose, Pose::new(5.0, 0.0, 0.0));
        assert_eq!(bridged[2].pose, Pose::new(7.0, 0.4, 0.0));
        let middle = bridged[1].pose;
        assert!((middle.x - 6.0).abs() < 1e-12 && (middle.y - 0.2).abs() < 1e-12, "{middle:?}");
        assert_eq!(bridge(&poses[..1]), []);
    }
}
