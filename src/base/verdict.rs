//! Why a base is stopped, in plain words.

use thiserror::Error;

use super::Faults;
use crate::robot::Side;

/// A reason to stop. Speeds in m/s, forward positive.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Verdict {
    /// The base's own emergency stop.
    #[error(
        "the base is at its emergency stop: look around it, release the button, then release the stop"
    )]
    EmergencyStop,
    /// What the base or its driver found.
    #[error("the base reports: {0}")]
    Fault(Faults),
    /// Feedback that is not a number.
    #[error("the base reports a motion that is not a number")]
    NotFinite,
    /// A track that stands though it is told to move.
    #[error(
        "the {side} track stands (measured {measured:.2} m/s) though it is told {told:.2} m/s: it is stuck, or its motor or encoder is not connected"
    )]
    Stuck {
        /// Which track.
        side: Side,
        /// As commanded.
        told: f64,
        /// As measured.
        measured: f64,
    },
    /// A track that runs against its command.
    #[error(
        "the {side} track runs at {measured:.2} m/s though it is told {told:.2} m/s: its motor or its encoder is wired the wrong way round, or the tracks are swapped"
    )]
    Reversed {
        /// Which track.
        side: Side,
        /// As commanded.
        told: f64,
        /// As measured.
        measured: f64,
    },
    /// A track that is faster than it was told at any time lately.
    #[error(
        "the {side} track runs at {measured:.2} m/s though it is told {told:.2} m/s: it has run away; cut the motors' power if it does not stop"
    )]
    Runaway {
        /// Which track.
        side: Side,
        /// As commanded.
        told: f64,
        /// As measured.
        measured: f64,
    },
    /// Gyro and tracks disagree on the turn.
    #[error(
        "the tracks turn the base at {tracks:.2} rad/s and the gyro measures {gyro:.2} rad/s: it slips, the tracks are swapped, or the effective track width is far off"
    )]
    Slip {
        /// By the tracks, rad/s.
        tracks: f64,
        /// By the gyro, rad/s.
        gyro: f64,
    },
    /// The battery is low.
    #[error("the battery has {volts:.1} V, less than {least:.1} V: charge it")]
    LowBattery {
        /// As measured.
        volts: f64,
        /// As set.
        least: f64,
    },
    /// The base is behind with obeying.
    #[error(
        "the base is {behind_s:.2} s behind with its commands: its controller reads them too slowly, or the line holds them back"
    )]
    Late {
        /// Age of the oldest command that it had not taken, seconds.
        behind_s: f64,
    },
}
