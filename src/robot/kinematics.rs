//! Kinematics of the tracked drive: twist and track speeds (paper, eqs. 1-12).

use serde::{Deserialize, Serialize};

use super::{Limits, PerTrack};
use crate::geometry::Twist;

/// Speeds of the two tracks, metres per second, forward positive.
pub type TrackSpeeds = PerTrack<f64>;

/// A base steered by the speed difference of its tracks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackedDrive {
    /// Distance between the tracks' centre lines, metres, above zero. The paper once prints it as omega.
    pub track_width_m: f64,
}

impl TrackedDrive {
    /// The twist of two track speeds without slip (eqs. 1 and 2).
    #[must_use]
    pub fn twist(&self, tracks: &TrackSpeeds) -> Twist {
        Twist {
            linear: f64::midpoint(tracks.left, tracks.right),
            angular: (tracks.right - tracks.left) / self.track_width_m,
        }
    }

    /// The track speeds of a twist without slip: the inverse of eqs. 1 and 2.
    #[must_use]
    pub fn tracks(&self, twist: &Twist) -> TrackSpeeds {
        let half = twist.angular * self.track_width_m / 2.0;
        TrackSpeeds { left: twist.linear - half, right: twist.linear + half }
    }

    /// Turning radius, metres, positive to the left (eq. 9); infinite for equal track speeds.
    #[must_use]
    pub fn turning_radius_m(&self, tracks: &TrackSpeeds) -> f64 {
        let twist = self.twist(tracks);
        if twist.angular == 0.0 { f64::INFINITY } else { twist.linear / twist.angular }
    }

    /// The largest curvature, 1/m, at a forward speed above zero: the smaller of eq. 12, with the outer track at
    /// `max_track_speed`, and the limit by the turn rate.
    #[must_use]
    pub fn max_curvature(&self, speed: f64, max_track_speed: f64, max_vel_theta: f64) -> f64 {
        let by_tracks = 2.0 / self.track_width_m * (max_track_speed / speed - 1.0);
        by_tracks.max(0.0).min(max_vel_theta / speed)
    }

    /// The largest forward speed, m/s, for a curvature, 1/m and above zero: the inverse of [`Self::max_curvature`].
    #[must_use]
    pub fn max_speed(&self, curvature: f64, max_track_speed: f64, max_vel_theta: f64) -> f64 {
        let by_tracks = max_track_speed / (1.0 + curvature * self.track_width_m / 2.0);
        by_tracks.min(max_vel_theta / curvature)
    }

    /// The speed of the outer track, m/s, at the largest forward speed and turn rate. The limits allow both at once, so this is
    /// the top speed of a track.
    #[must_use]
    pub fn top_track_speed(&self, limits: &Limits) -> f64 {
        let top = Twist::new(limits.max_vel_x, limits.max_vel_theta);
        self.tracks(&top).right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

    #[test]
    fn twist_and_tracks_are_inverse() {
        let twist = Twist::new(0.7, -0.4);
        let back = DRIVE.twist(&DRIVE.tracks(&twist));
        assert!((back.linear - 0.7).abs() < 1e-15 && (back.angular + 0.4).abs() < 1e-15);
    }

    #[test]
    fn equal_track_speeds_have_an_infinite_radius() {
        let radius = DRIVE.turning_radius_m(&TrackSpeeds { left: 0.3, right: 0.3 });
        assert_eq!(radius, f64::INFINITY);
    }

    #[test]
    fn max_curvature_is_the_smaller_of_eq_12_and_the_turn_rate_limit() {
        // 2 / 0.5 * (1.0 / 0.9 - 1) = 0.444..; at 0.5 m/s the rate 1.0 rad/s allows only 2.0, eq. 12 would give 4.0.
        assert!((DRIVE.max_curvature(0.9, 1.0, 1.0) - 4.0 / 9.0).abs() < 1e-12);
        assert!((DRIVE.max_curvature(0.5, 1.0, 1.0) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn max_speed_is_the_inverse_of_max_curvature() {
        for curvature in [0.01, 0.4, 1.0, 3.0, 50.0] {
            for max_vel_theta in [0.2, 1.0, 1e9] {
                let speed = DRIVE.max_speed(curvature, 1.2, max_vel_theta);
                let back = DRIVE.max_curvature(speed, 1.2, max_vel_theta);
                assert!((back / curvature - 1.0).abs() < 1e-12, "{back} of {curvature}");
            }
        }
    }

    #[test]
    fn top_track_speed_combines_both_limits() {
        let limits = Limits { max_vel_x: 0.8, max_vel_theta: 1.2, ..Limits::default() };
        let top = DRIVE.top_track_speed(&limits);
        assert!((top - (0.8 + 1.2 * 0.25)).abs() < 1e-15);
        assert!((DRIVE.max_curvature(0.8, top, 1.2) - 1.5).abs() < 1e-12);
    }
}
