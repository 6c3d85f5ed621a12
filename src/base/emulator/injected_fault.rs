//! Faults injected into an emulated base.

use core::fmt;
use core::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::base::Protocol;
use crate::settings::parse_choice;

/// A fault of an emulated base or its serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum InjectedFault {
    /// The left track is blocked.
    StuckLeft,
    /// The right track is blocked.
    StuckRight,
    /// The driver of the left motor is broken and applies full forward voltage. Only the button stops it.
    Runaway,
    /// The leads of the left motor are swapped, those of its encoder are not: the speed control accelerates it in the wrong
    /// direction until the set speed is zero.
    Reversed,
    /// The emergency button is pressed: the controller reports it and the motors have no power.
    Button,
    /// The base sends nothing; it still receives.
    Silence,
    /// The host's bytes are read 0.3 s late.
    SlowReads,
    /// Bursts of random bytes on the line in both directions, ten per second.
    Garbage,
    /// One of two hundred bytes has one bit flipped, in both directions.
    BitFlips,
    /// One bit of each write of the base is flipped.
    CorruptReports,
    /// The base keeps its set speeds, whatever it receives. It reports and acknowledges commands.
    IgnoredCommands,
    /// The controller hangs: it neither reads nor writes nor changes its set speeds. What it receives is lost.
    Wedge,
    /// One report shows a pressed emergency button.
    StopGlitch,
    /// The belts turn, but the robot stands.
    Bogged,
    /// The base lies on its side: a roll of 0.6 rad.
    Tilt,
    /// The left bumper is pressed.
    Bumper,
    /// A cliff sensor sees no ground.
    Cliff,
    /// The encoder of the left track counts no more.
    EncoderStuck,
    /// The gyro reads 0.8 rad/s too much.
    GyroBiased,
    /// The battery reads 15 V.
    LowBattery,
    /// Both tracks get the mean of their set speeds: the base drives, but does not turn.
    IgnoredTurns,
    /// The motors follow their set speeds 0.3 s late. The base acknowledges commands at once.
    LateMotors,
    /// The controller has no power. It restarts when the fault ends.
    Reboot,
    /// No byte passes in either direction; the port stays open.
    LineCut,
    /// Another device takes the name of the port. Only `base emulate` does this.
    PortReplaced,
    /// The robot stands at another place of the world. Only `base emulate` does this.
    Carried,
    /// The lidar repeats its last revolution with new time stamps.
    LidarFrozen,
    /// The lidar receives no echo.
    LidarBlind,
    /// The lidar receives no echo from 45 degrees to both sides of its front.
    LidarSectorBlind,
    /// The lidar's packets arrive 1 s late.
    LidarLate,
    /// One bit of each packet of the lidar is flipped.
    LidarCorrupt,
    /// One of two hundred bytes of the lidar has one bit flipped.
    LidarBitFlips,
    /// The lidar's motor stands. It measures in one direction.
    LidarStalled,
    /// The lidar sends nothing; its port stays open.
    LidarSilent,
}

impl InjectedFault {
    /// Whether it is a fault of the lidar.
    #[must_use]
    pub const fn is_of_lidar(self) -> bool {
        matches!(
            self,
            Self::LidarFrozen
                | Self::LidarBlind
                | Self::LidarSectorBlind
                | Self::LidarLate
                | Self::LidarCorrupt
                | Self::LidarBitFlips
                | Self::LidarStalled
                | Self::LidarSilent
        )
    }

    /// Whether it happens once, at its start, so that it has no end.
    #[must_use]
    pub const fn is_instant(self) -> bool {
        matches!(self, Self::PortReplaced | Self::Carried)
    }

    /// The protocols with which the fault has an effect: those that report its sensor. Other faults have one with every
    /// protocol.
    #[must_use]
    pub const fn protocols(self) -> &'static [Protocol] {
        use Protocol::{Native, Roboclaw, Wheeltec};
        match self {
            Self::Tilt => &[Wheeltec],
            Self::Bumper | Self::Cliff => &[Native],
            Self::GyroBiased => &[Native, Wheeltec],
            Self::LowBattery => &[Native, Roboclaw, Wheeltec],
            _ => &Protocol::ALL,
        }
    }

    /// Every fault.
    pub const ALL: [Self; 34] = [
        Self::StuckLeft,
        Self::StuckRight,
        Self::Runaway,
        Self::Reversed,
        Self::Button,
        Self::Silence,
        Self::SlowReads,
        Self::Garbage,
        Self::BitFlips,
        Self::CorruptReports,
        Self::IgnoredCommands,
        Self::Wedge,
        Self::StopGlitch,
        Self::Bogged,
        Self::Tilt,
        Self::Bumper,
        Self::Cliff,
        Self::EncoderStuck,
        Self::GyroBiased,
        Self::LowBattery,
        Self::IgnoredTurns,
        Self::LateMotors,
        Self::Reboot,
        Self::LineCut,
        Self::PortReplaced,
        Self::Carried,
        Self::LidarFrozen,
        Self::LidarBlind,
        Self::LidarSectorBlind,
        Self::LidarLate,
        Self::LidarCorrupt,
        Self::LidarBitFlips,
        Self::LidarStalled,
        Self::LidarSilent,
    ];
}

impl fmt::Display for InjectedFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(formatter)
    }
}

/// A fault with its start and end, seconds since power-on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScheduledFault {
    /// The fault.
    pub fault: InjectedFault,
    /// Start time.
    pub from_s: f64,
    /// End time; infinite if it never ends.
    pub to_s: f64,
}

impl ScheduledFault {
    /// A fault that starts at a time and never ends.
    #[must_use]
    pub const fn from(fault: InjectedFault, from_s: f64) -> Self {
        Self { fault, from_s, to_s: f64::INFINITY }
    }

    /// Whether the fault is active at a time.
    pub(super) fn is_active(&self, now_s: f64) -> bool {
        (self.from_s..self.to_s).contains(&now_s)
    }
}

impl FromStr for ScheduledFault {
    type Err = String;

    /// Parses `NAME`, `NAME@FROM` or `NAME@FROM..TO`, times in seconds.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, times) = text.split_once('@').unwrap_or((text, "0"));
        let fault = parse_choice("a fault", name)?;
        let (from, to) =
            times.split_once("..").map_or((times, None), |(from, to)| (from, Some(to)));
        let seconds = |text: &str| text.parse().ok().filter(|time: &f64| time.is_finite());
        let from_s = seconds(from);
        let to_s = to.map_or(Some(f64::INFINITY), seconds);
        match from_s.zip(to_s) {
            Some((from_s, to_s)) if from_s >= 0.0 && to_s > from_s => {
                Ok(Self { fault, from_s, to_s })
            }
            _ => Err(format!(
                "`{}` is not a time: write {name}@SECONDS or {name}@FROM..TO, such as {name}@2 or {name}@2..3.5",
                times.escape_debug()
            )),
        }
    }
}
