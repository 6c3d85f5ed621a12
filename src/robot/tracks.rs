//! Values of the two tracks, kinematics of the tracked drive and odometry from encoders (paper, eqs. 1-12).

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Limits;
use crate::geometry::{Pose, Twist};
use crate::settings::{Range, Setting, SettingError};

/// One of the two tracks, in the direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The left track.
    Left,
    /// The right track.
    Right,
}

/// One value for each track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerTrack<T> {
    /// Value of the left track.
    pub left: T,
    /// Value of the right track.
    pub right: T,
}

impl<T: Setting> Setting for PerTrack<T> {
    fn schema() -> Value {
        json!({
            "type": "object",
            "properties": { "left": T::schema(), "right": T::schema() },
            "required": ["left", "right"],
            "additionalProperties": false,
        })
    }

    fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
        self.left.check(name, range)?;
        self.right.check(name, range)
    }
}

impl<T> PerTrack<T> {
    /// Creates a pair from its values.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// Applies a function to both values.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerTrack<U> {
        PerTrack::new(change(self.left), change(self.right))
    }

    /// Combines both values with those of another pair.
    pub fn zip<U, V>(self, other: PerTrack<U>, mut join: impl FnMut(T, U) -> V) -> PerTrack<V> {
        PerTrack::new(join(self.left, other.left), join(self.right, other.right))
    }

    /// Returns the pair with left and right exchanged.
    #[must_use]
    pub fn swapped(self) -> Self {
        Self::new(self.right, self.left)
    }
}

impl<T: Copy> PerTrack<T> {
    /// Creates a pair of equal values.
    pub const fn both(value: T) -> Self {
        Self::new(value, value)
    }

    /// The value of one track.
    pub const fn of(&self, side: Side) -> T {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }
}

impl core::fmt::Display for Side {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

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

    /// The pose after uniform travel of each track, metres: the exact arc of eqs. 6 to 8. Its yaw is in (-pi, pi].
    #[must_use]
    pub fn after(&self, pose: &Pose, travel_m: &PerTrack<f64>) -> Pose {
        pose.after(&self.twist(travel_m), 1.0)
    }
}

/// Dead reckoning from encoder readings.
#[derive(Clone, Debug)]
pub struct TrackOdometry {
    drive: TrackedDrive,
    ticks_per_m: PerTrack<f64>,
    last: Option<PerTrack<u32>>,
    pose: Pose,
}

impl TrackOdometry {
    /// Creates odometry that starts at a pose. The drive's width is the effective one.
    #[must_use]
    pub fn new(drive: TrackedDrive, ticks_per_m: PerTrack<f64>, pose: Pose) -> Self {
        Self { drive, ticks_per_m, last: None, pose }
    }

    /// Adds a reading and returns the motion since the last one, metres and radians; zero for the first.
    pub fn update(&mut self, ticks: PerTrack<u32>) -> Twist {
        let last = self.last.replace(ticks).unwrap_or(ticks);
        let travel_m = travel_m(&last, &ticks, &self.ticks_per_m);
        self.pose = self.drive.after(&self.pose, &travel_m);
        self.drive.twist(&travel_m)
    }

    /// The estimated pose.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Discards the last reading and keeps the pose, for counters that may have been reset.
    pub fn reset_counters(&mut self) {
        self.last = None;
    }
}

/// Travel of each track between two readings of 32-bit counters, metres, across their wrap-around.
///
/// Correct for less than 2^31 ticks: half a day at 50,000 ticks per second.
#[must_use]
pub fn travel_m(
    before: &PerTrack<u32>,
    now: &PerTrack<u32>,
    ticks_per_m: &PerTrack<f64>,
) -> PerTrack<f64> {
    let ticks = before.zip(*now, |before, now| f64::from(now.wrapping_sub(before) as i32));
    ticks.zip(*ticks_per_m, |ticks, per_m| ticks / per_m)
}
