//! All settings of a base, its supervisor and its lidar, each with a documented default. The file format is TOML.

use serde::{Deserialize, Serialize};

use super::arduino::ArduinoSettings;
use super::ld19::LidarSettings;
use super::roboclaw::RoboClawSettings;
use super::{BaseError, Faults, SupervisorSettings, require_finite};
use crate::geometry::Twist;
use crate::robot::{PerTrack, TrackLimits, TrackSpeeds, TrackedDrive};
use crate::settings::settings;

settings! {
    /// Settings of a base, its supervisor and its lidar.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseConfig {
        /// Tracks, wiring and protocol of the base.
        pub base: BaseSettings = BaseSettings::default();
        /// Command rate, timeouts and fault detection.
        pub supervisor: SupervisorSettings = SupervisorSettings::default();
        /// Mounting and timeout of an LD19 lidar on the base, for `drive --lidar`.
        pub lidar: LidarSettings = LidarSettings::default();
    }
    heading "Settings of a base with their defaults: leave out every key that keeps its default. SI units."
}

settings! {
    /// Tracks, wiring and protocol of a tracked base.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseSettings {
        /// Distance between the tracks' centre lines. Default 0.5 m, a small inspection robot.
        pub track_width_m: f64 = 0.5, ["m", above 0 to 100];
        /// Effective over geometric track width: tracks slip sideways in a turn, and so turn as if they were farther
        /// apart. Default 1, no slip. To calibrate: turn on the spot ten times by the encoders, count the real turns,
        /// and divide ten by them.
        pub effective_width_ratio: f64 = 1.0, ["", 0.5 to 5];
        /// Encoder ticks per metre of each track. Default 10,000. Not used by the WHEELTEC protocol.
        pub ticks_per_m: PerTrack<f64> = PerTrack::both(10_000.0), ["1/m", above 0 to 10_000_000];
        /// Whether the first channel of the controller drives the right track. Default false. Not used by the
        /// WHEELTEC protocol.
        pub swap_tracks: bool = false;
        /// Whether motor and encoder of a track are both reversed; left and right are the robot's. Default false.
        pub reversed: PerTrack<bool> = PerTrack::both(false);
        /// Speed and acceleration limits of each track.
        pub tracks: TrackLimits = TrackLimits::default();
        /// Battery voltage below which the base is stopped, such as 21.0 for seven lithium cells at 3 V each. Default
        /// none, not monitored: it depends on the cells.
        pub min_battery_v: Option<f64> = None, ["V", above 0 to 1000];
        /// Whether the firmware of the base stops the motors by itself when commands cease, although its protocol is known
        /// for firmware that does not: WHEELTEC's. Default false. Test it: kill the program with SIGKILL while the base
        /// turns its tracks in the air.
        pub has_watchdog: bool = false;
        /// Largest speed of a track of a base without a watchdog. Default 0.3 m/s, a fifth of a walking speed: if the
        /// host fails, a person catches up with the base and reaches its button.
        pub max_speed_without_watchdog_m_s: f64 = 0.3, ["m/s", above 0 to 10];
        /// Protocol settings of a `RoboClaw`.
        pub roboclaw: RoboClawSettings = RoboClawSettings::default();
        /// Protocol settings of a `ROSArduinoBridge`.
        pub arduino: ArduinoSettings = ArduinoSettings::default();
    }
}

impl BaseSettings {
    /// The kinematics with the effective track width.
    #[must_use]
    pub fn drive(&self) -> TrackedDrive {
        TrackedDrive { track_width_m: self.track_width_m * self.effective_width_ratio }
    }

    /// Limits a command to the tracks' highest speed at constant curvature.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`].
    pub fn limit(&self, twist: &Twist) -> Result<Twist, BaseError> {
        let twist = require_finite(twist)?;
        let tracks = self.drive().tracks(twist);
        let within = self.tracks.scale_to_max(&tracks);
        // A command within the limits must not lose its last bits in the conversion to tracks and back.
        Ok(if within == tracks { *twist } else { self.drive().twist(&within) })
    }

    /// Converts track speeds, m/s, to ticks per second of the controller's two channels.
    pub(super) fn channel_rates(&self, speeds: &TrackSpeeds) -> [f64; 2] {
        let rates = speeds
            .zip(self.ticks_per_m, |speed, per_m| speed * per_m)
            .zip(self.reversed, |rate, reversed| if reversed { -rate } else { rate });
        array(self.swapped(rates))
    }

    /// Converts ticks per second of the controller's two channels to track speeds, m/s.
    pub(super) fn track_speeds(&self, rates: [f64; 2]) -> TrackSpeeds {
        self.swapped(PerTrack::new(rates[0], rates[1]))
            .zip(self.reversed, |rate, reversed| if reversed { -rate } else { rate })
            .zip(self.ticks_per_m, |rate, per_m| rate / per_m)
    }

    /// Converts counts of the controller's two channels to counts of the tracks.
    pub(super) fn track_counts(&self, counts: [u32; 2]) -> PerTrack<u32> {
        self.swapped(PerTrack::new(counts[0], counts[1])).zip(self.reversed, negated)
    }

    /// Converts counts of the tracks to counts of the controller's two channels.
    pub(super) fn channel_counts(&self, counts: PerTrack<u32>) -> [u32; 2] {
        array(self.swapped(counts.zip(self.reversed, negated)))
    }

    /// The motor fault of the first or the second channel.
    pub(super) const fn motor_fault(&self, second: bool) -> Faults {
        if second == self.swap_tracks { Faults::MOTOR_LEFT } else { Faults::MOTOR_RIGHT }
    }

    /// Converts the order of tracks to that of channels, or back.
    fn swapped<T>(&self, sides: PerTrack<T>) -> PerTrack<T> {
        if self.swap_tracks { sides.swapped() } else { sides }
    }
}

fn array<T>(sides: PerTrack<T>) -> [T; 2] {
    [sides.left, sides.right]
}

const fn negated(count: u32, reversed: bool) -> u32 {
    if reversed { count.wrapping_neg() } else { count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channel_conversion_round_trips_for_every_wiring() {
        for wiring in 0..8 {
            let settings = BaseSettings {
                swap_tracks: wiring & 1 != 0,
                reversed: PerTrack::new(wiring & 2 != 0, wiring & 4 != 0),
                ticks_per_m: PerTrack::new(1000.0, 2000.0),
                ..BaseSettings::default()
            };
            let speeds = TrackSpeeds { left: 0.5, right: -0.25 };
            let channels = settings.channel_rates(&speeds);
            assert_eq!(settings.track_speeds(channels), speeds, "{wiring}");
            let counts = PerTrack::new(7, u32::MAX);
            let channels = settings.channel_counts(counts);
            assert_eq!(settings.track_counts(channels), counts, "{wiring}");
        }
    }

    #[test]
    fn swapped_and_reversed_track_is_other_channel_negated() {
        let settings = BaseSettings {
            swap_tracks: true,
            reversed: PerTrack::new(true, false),
            ..BaseSettings::default()
        };
        let speeds = TrackSpeeds { left: 0.5, right: 0.1 };
        assert_eq!(settings.channel_rates(&speeds), [1000.0, -5000.0]);
        assert_eq!(settings.motor_fault(true), Faults::MOTOR_LEFT);
    }

    #[test]
    fn limit_scales_command_at_constant_curvature() {
        let settings = BaseSettings::default();
        let limited = settings.limit(&Twist::new(2.0, 2.0)).expect("a finite command");
        // The right track would run at 2.5 m/s, twice its highest speed.
        assert!((limited.linear - 1.0).abs() < 1e-12 && (limited.angular - 1.0).abs() < 1e-12);
        let slow = Twist::new(0.3, -0.1);
        assert_eq!(settings.limit(&slow), Ok(slow));
    }
}
