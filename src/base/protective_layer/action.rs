//! What the protective layer does to a command, for diagnostics.

use serde::Serialize;
use thiserror::Error;

/// What the protective layer does to a command, and why. Points are in the robot's frame, metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Error)]
#[serde(tag = "action", rename_all = "snake_case")]
#[non_exhaustive]
pub enum ProtectiveAction {
    /// The command passes unchanged.
    #[default]
    #[error("the command passes")]
    Pass,
    /// The robot stands: it is not armed.
    #[error("not armed")]
    NotArmed,
    /// The robot stands: the operator stopped it.
    #[error("the operator stopped the robot: arm it to go on")]
    OperatorStop,
    /// The robot stops: there is no scan.
    #[error("no scan")]
    NoScan,
    /// The robot stops: the scan is too old, or stamped ahead.
    #[error("the scan is {age_s:.2} s old")]
    StaleScan {
        /// Age by its stamp, seconds.
        age_s: f64,
    },
    /// The robot stops: the lidar returns nothing.
    #[error("the lidar is blind: {share:.3} of its beams have a return")]
    BlindScan {
        /// Share of the beams with a return.
        share: f64,
    },
    /// The robot stops: the lidar repeats a scan while the base moves.
    #[error("the lidar is frozen: {scans} identical scans while the base moves")]
    FrozenScan {
        /// Number of identical scans.
        scans: usize,
    },
    /// The robot stops: its stopping motion would touch a return.
    #[error("stop: a return at ({x:.2}, {y:.2}) m, {gap_m:.2} m from the body")]
    Stop {
        /// The first return that the motion touches.
        x: f64,
        /// The first return that the motion touches.
        y: f64,
        /// Its present distance from the body, metres.
        gap_m: f64,
    },
    /// The robot is slower, so that it can stop before a return.
    #[error("approach: {factor:.2} of the command, a return at ({x:.2}, {y:.2}) m")]
    Approach {
        /// Factor of the command.
        factor: f64,
        /// The first return that the motion touches.
        x: f64,
        /// The first return that the motion touches.
        y: f64,
    },
    /// The robot is slower: its stopping motion is longer than the layer looks ahead.
    #[error("the base would not stand within {within_s:.1} s: {factor:.2} of the command")]
    NoStandstill {
        /// Factor of the command; zero for a stop.
        factor: f64,
        /// Length of the motion that was checked, seconds.
        within_s: f64,
    },
    /// The robot is slower: a return lies near its stopping motion.
    #[error("slow: at most {limit:.2} m/s, a return at ({x:.2}, {y:.2}) m")]
    Slow {
        /// Highest speed of a point of the body, m/s.
        limit: f64,
        /// A return in the zone.
        x: f64,
        /// A return in the zone.
        y: f64,
    },
    /// The robot moves slowly away from a return within its body.
    #[error("escape: at most {limit:.2} m/s, a return {depth_m:.2} m within the body")]
    Escape {
        /// Highest speed of a point of the body, m/s.
        limit: f64,
        /// Depth of the return in the body, metres.
        depth_m: f64,
    },
    /// The robot is slower: it would move into a direction without measurements.
    #[error("blind at {direction_rad:.2} rad: at most {limit:.2} m/s in that direction")]
    BlindSector {
        /// The direction in the robot's frame, radians.
        direction_rad: f64,
        /// Highest speed with which the body enters that direction, m/s.
        limit: f64,
    },
    /// A fixed zone acts.
    #[error("the zone {name}: {factor:.2} of the command")]
    Zone {
        /// Name of the zone.
        name: String,
        /// Factor of the command.
        factor: f64,
    },
    /// The robot stops: the command is not finite.
    #[error("the command is not finite")]
    NotFinite,
}

impl ProtectiveAction {
    /// Whether the command passes unchanged.
    #[must_use]
    pub const fn passes(&self) -> bool {
        matches!(self, Self::Pass)
    }

    /// Whether the robot stands until an operator arms it.
    #[must_use]
    pub const fn awaits_operator(&self) -> bool {
        matches!(self, Self::NotArmed | Self::OperatorStop)
    }

    /// Name of the action, as in JSON.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::NotArmed => "not_armed",
            Self::OperatorStop => "operator_stop",
            Self::NoScan => "no_scan",
            Self::StaleScan { .. } => "stale_scan",
            Self::BlindScan { .. } => "blind_scan",
            Self::FrozenScan { .. } => "frozen_scan",
            Self::Stop { .. } => "stop",
            Self::Approach { .. } => "approach",
            Self::NoStandstill { .. } => "no_standstill",
            Self::Slow { .. } => "slow",
            Self::Escape { .. } => "escape",
            Self::BlindSector { .. } => "blind_sector",
            Self::Zone { .. } => "zone",
            Self::NotFinite => "not_finite",
        }
    }
}
