//! What a driver must know of a base: its tracks, its wiring, and the manners of its protocol.

use serde::{Deserialize, Serialize};

use super::arduino::ArduinoSettings;
use super::roboclaw::RoboClawSettings;
use super::{BaseError, Faults, finite};
use crate::documented::documented;
use crate::geometry::Twist;
use crate::robot::{PerTrack, TrackLimits, TrackSpeeds, TrackedDrive};

documented! {
    /// A tracked base, as its driver sees it.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseSettings {
        /// Distance between the tracks' centre lines, metres, above zero. Default 0.5 m, a small inspection robot.
        pub track_width_m: f64,
        /// Effective track width over the geometric one, 0.5 to 5: tracks turn by slipping sideways, and so as if they were
        /// farther apart. Default 1, no slip. To calibrate: turn on the spot ten times by the encoders, count the turns
        /// that were made, and divide ten by them.
        pub effective_width_ratio: f64,
        /// Encoder ticks of a metre of each track, above zero. Default 10,000. Of no use to WHEELTEC's frames.
        pub ticks_per_m: PerTrack<f64>,
        /// Whether the first channel of the controller drives the right track. Default false. Of no use to WHEELTEC's frames.
        pub swap_tracks: bool,
        /// Whether motor and encoder of a track both count backwards; left and right as the robot has them. Default false.
        pub reversed: PerTrack<bool>,
        /// What each track can do.
        pub tracks: TrackLimits,
        /// Battery voltage below which to stop, above zero, such as 21.0 for seven lithium cells at 3 V each; none where it
        /// is not watched. Default none: it is a matter of the cells.
        pub min_battery_v: Option<f64>,
        /// The manners of a `RoboClaw`.
        pub roboclaw: RoboClawSettings,
        /// The manners of a `ROSArduinoBridge`.
        pub arduino: ArduinoSettings,
    }
}

impl Default for BaseSettings {
    fn default() -> Self {
        Self {
            track_width_m: 0.5,
            effective_width_ratio: 1.0,
            ticks_per_m: PerTrack::both(10_000.0),
            swap_tracks: false,
            reversed: PerTrack::both(false),
            tracks: TrackLimits::default(),
            min_battery_v: None,
            roboclaw: RoboClawSettings::default(),
            arduino: ArduinoSettings::default(),
        }
    }
}

impl BaseSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        above_zero("track_width_m", self.track_width_m)?;
        require(
            (0.5..=5.0).contains(&self.effective_width_ratio),
            "effective_width_ratio",
            self.effective_width_ratio,
            "from 0.5 to 5",
        )?;
        above_zero("ticks_per_m.left", self.ticks_per_m.left)?;
        above_zero("ticks_per_m.right", self.ticks_per_m.right)?;
        if let Some(volts) = self.min_battery_v {
            above_zero("min_battery_v", volts)?;
        }
        self.tracks.validate()?;
        self.roboclaw.validate()?;
        self.arduino.validate()
    }

    /// The drive with its effective width: what turns a motion into track speeds and back.
    #[must_use]
    pub fn drive(&self) -> TrackedDrive {
        TrackedDrive {
            track_width_m: self.track_width_m * self.effective_width_ratio,
        }
    }

    /// A command within what the tracks can do, its curvature kept.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`].
    pub(super) fn possible(&self, wanted: &Twist) -> Result<Twist, BaseError> {
        let wanted = finite(wanted)?;
        let tracks = self.drive().tracks(wanted);
        let within = self.tracks.within(&tracks);
        // What is possible as it is must not lose its last bits on the way there and back.
        Ok(if within == tracks {
            *wanted
        } else {
            self.drive().twist(&within)
        })
    }

    /// Speeds of the tracks, m/s, as ticks per second of the controller's two channels.
    pub(super) fn channel_rates(&self, speeds: &TrackSpeeds) -> [f64; 2] {
        let rates = PerTrack::from(*speeds)
            .zip(self.ticks_per_m, |speed, per_m| speed * per_m)
            .zip(
                self.reversed,
                |rate, reversed| if reversed { -rate } else { rate },
            );
        array(self.wired(rates))
    }

    /// Ticks per second of the controller's two channels as speeds of the tracks, m/s.
    pub(super) fn track_speeds(&self, rates: [f64; 2]) -> TrackSpeeds {
        self.wired(PerTrack::new(rates[0], rates[1]))
            .zip(
                self.reversed,
                |rate, reversed| if reversed { -rate } else { rate },
            )
            .zip(self.ticks_per_m, |rate, per_m| rate / per_m)
            .into()
    }

    /// Counts of the controller's two channels as those of the tracks.
    pub(super) fn track_ticks(&self, counts: [u32; 2]) -> PerTrack<u32> {
        self.wired(PerTrack::new(counts[0], counts[1]))
            .zip(self.reversed, turned)
    }

    /// Counts of the tracks as those of the controller's two channels.
    pub(super) fn channel_counts(&self, ticks: PerTrack<u32>) -> [u32; 2] {
        array(self.wired(ticks.zip(self.reversed, turned)))
    }

    /// The fault of the motor on a channel, the first or the second.
    pub(super) const fn motor_fault(&self, second: bool) -> Faults {
        if second == self.swap_tracks {
            Faults::MOTOR_LEFT
        } else {
            Faults::MOTOR_RIGHT
        }
    }

    /// Tracks as channels, or channels as tracks.
    fn wired<T>(&self, sides: PerTrack<T>) -> PerTrack<T> {
        if self.swap_tracks {
            sides.swapped()
        } else {
            sides
        }
    }
}

fn array<T>(sides: PerTrack<T>) -> [T; 2] {
    [sides.left, sides.right]
}

const fn turned(count: u32, reversed: bool) -> u32 {
    if reversed {
        count.wrapping_neg()
    } else {
        count
    }
}

/// Refuses a setting that is not good.
pub(super) const fn require(
    good: bool,
    name: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), BaseError> {
    if good {
        Ok(())
    } else {
        Err(BaseError::BadSetting {
            name,
            value,
            expected,
        })
    }
}

/// Refuses a setting that is not finite and above zero.
pub(super) const fn above_zero(name: &'static str, value: f64) -> Result<(), BaseError> {
    let good = value.is_finite() && value > 0.0;
    require(good, name, value, "finite and above zero")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wiring_there_and_back_is_the_same_for_every_wiring() {
        for wiring in 0..8 {
            let settings = BaseSettings {
                swap_tracks: wiring & 1 != 0,
                reversed: PerTrack::new(wiring & 2 != 0, wiring & 4 != 0),
                ticks_per_m: PerTrack::new(1000.0, 2000.0),
                ..BaseSettings::default()
            };
            let speeds = TrackSpeeds {
                left: 0.5,
                right: -0.25,
            };
            let channels = settings.channel_rates(&speeds);
            assert_eq!(settings.track_speeds(channels), speeds, "{wiring}");
            let ticks = PerTrack::new(7, u32::MAX);
            let counts = settings.channel_counts(ticks);
            assert_eq!(settings.track_ticks(counts), ticks, "{wiring}");
        }
    }

    #[test]
    fn a_swapped_and_reversed_track_is_the_other_channel_backwards() {
        let settings = BaseSettings {
            swap_tracks: true,
            reversed: PerTrack::new(true, false),
            ..BaseSettings::default()
        };
        let speeds = TrackSpeeds {
            left: 0.5,
            right: 0.1,
        };
        assert_eq!(settings.channel_rates(&speeds), [1000.0, -5000.0]);
        assert_eq!(settings.motor_fault(true), Faults::MOTOR_LEFT);
    }

    #[test]
    fn a_command_beyond_a_track_keeps_its_curvature() {
        let settings = BaseSettings::default();
        let possible = settings
            .possible(&Twist::new(2.0, 2.0))
            .expect("a finite motion and sound settings");
        // The right track would run at 2.5 m/s, twice its highest speed.
        assert!((possible.linear - 1.0).abs() < 1e-12 && (possible.angular - 1.0).abs() < 1e-12);
        let slow = Twist::new(0.3, -0.1);
        assert_eq!(settings.possible(&slow), Ok(slow));
    }

    #[test]
    fn bad_settings_are_refused_by_name() {
        let fine = BaseSettings::default();
        fine.validate().expect("a finite motion and sound settings");
        let blind = PerTrack::new(0.0, 1.0);
        for (settings, words) in [
            (
                BaseSettings {
                    track_width_m: -1.0,
                    ..fine
                },
                "track_width_m is -1",
            ),
            (
                BaseSettings {
                    effective_width_ratio: 6.0,
                    ..fine
                },
                "effective_width_ratio is 6",
            ),
            (
                BaseSettings {
                    ticks_per_m: blind,
                    ..fine
                },
                "ticks_per_m.left is 0",
            ),
            (
                BaseSettings {
                    min_battery_v: Some(f64::NAN),
                    ..fine
                },
                "min_battery_v is NaN",
            ),
        ] {
            let message = settings.validate().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
