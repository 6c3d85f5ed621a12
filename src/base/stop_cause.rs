//! Why a base is stopped.

use thiserror::Error;

use super::Faults;
use crate::geometry::Twist;
use crate::robot::Side;

/// Why a stop is latched. Speeds in m/s, forward positive.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StopCause {
    /// The caller requested the stop.
    #[error("a stop was requested")]
    Requested,
    /// The base is at its own emergency stop.
    #[error(
        "the base is at its emergency stop: check its surroundings, release the button, then release the stop with `inbye base send --release`"
    )]
    EmergencyStop,
    /// Faults found by the base or its driver.
    #[error("{}", fault_text(*.0))]
    Fault(Faults),
    /// A bumper is pressed.
    #[error(
        "the {} bumper is pressed: clear what the robot touches, then release the stop", if *.left { "left" } else { "right" }
    )]
    Bumper {
        /// Whether the left half is pressed; else only the right half.
        left: bool,
    },
    /// A cliff sensor sees no ground.
    #[error(
        "a cliff sensor sees no ground: move the robot away from the edge, then release the stop"
    )]
    Cliff,
    /// The base is tilted.
    #[error(
        "the base is tilted (roll {roll:.2} rad, pitch {pitch:.2} rad, at most {max:.2} rad): put it on level ground, then release the stop"
    )]
    Tilt {
        /// Roll, rad.
        roll: f64,
        /// Pitch, rad.
        pitch: f64,
        /// Configured maximum, rad.
        max: f64,
    },
    /// Both tracks stand although motion is commanded, or keep their speed although their commands change.
    #[error("{}", ignored_text(&Twist::new(*.linear, *.angular), .measured))]
    IgnoresCommands {
        /// Commanded speed, m/s.
        linear: f64,
        /// Commanded turn rate, rad/s.
        angular: f64,
        /// Measured motion.
        measured: Twist,
    },
    /// The measured motion is NaN or infinite.
    #[error("the base reports a motion that is not finite")]
    NotFinite,
    /// A track stands although it is commanded to move.
    #[error(
        "the {side} track stands (measured {measured:.2} m/s) while commanded {commanded:.2} m/s: it is stuck, or its motor or encoder is not connected"
    )]
    Stuck {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// A track runs against its command.
    #[error(
        "the {side} track runs at {measured:.2} m/s while commanded {commanded:.2} m/s: its motor or encoder is wired in reverse, or the tracks are swapped"
    )]
    Reversed {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// A track is faster than every recent command.
    #[error(
        "the {side} track runs at {measured:.2} m/s while commanded {commanded:.2} m/s: it has run away; cut the motors' power if it does not stop"
    )]
    Runaway {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// Gyro and tracks disagree on the turn rate.
    #[error(
        "the turn rate is {tracks:.2} rad/s by the tracks and {gyro:.2} rad/s by the gyro: the tracks slip or are swapped, or the effective track width is wrong"
    )]
    Slip {
        /// Turn rate by the tracks, rad/s.
        tracks: f64,
        /// Turn rate by the gyro, rad/s.
        gyro: f64,
    },
    /// The battery is low.
    #[error("the battery has {volts:.1} V, less than {min:.1} V: charge it")]
    LowBattery {
        /// Measured voltage.
        volts: f64,
        /// Configured minimum.
        min: f64,
    },
    /// The base accepts commands too late.
    #[error(
        "the base is {delay_s:.2} s behind with its commands: its controller reads them too slowly, or the serial line delays them"
    )]
    CommandDelay {
        /// Age of the oldest command not yet accepted, seconds.
        delay_s: f64,
    },
}

fn fault_text(faults: Faults) -> String {
    if faults == Faults::ENCODER {
        // Found by the base, or by its driver on this side of the line.
        return "an encoder is silent, or its count jumps: check the encoder's cable and the line to the base, then release the stop"
            .to_owned();
    }
    format!("the base reports: {faults}")
}

/// Speed below which a base that ignores its commands stands, m/s and rad/s.
const STANDSTILL: f64 = 0.1;

fn ignored_text(commanded: &Twist, measured: &Twist) -> String {
    let Twist { linear, angular } = commanded;
    let commanded = format!("while commanded {linear:.2} m/s and {angular:.2} rad/s");
    if measured.is_below(STANDSTILL) {
        return format!(
            "the base stands {commanded}: it ignores its commands, or its motors have no power"
        );
    }
    let Twist { linear, angular } = measured;
    format!(
        "the base keeps {linear:.2} m/s and {angular:.2} rad/s {commanded}: it ignores its commands; cut the motors' power, then check \
         the line to the base"
    )
}
