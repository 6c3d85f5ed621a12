//! Selects a wire protocol by name.

use core::fmt;
use core::str::FromStr;

use serde::{Deserialize, Serialize};

use super::arduino::{ArduinoDevice, ArduinoSession};
use super::native::{NativeDevice, NativeSession};
use super::roboclaw::{RoboClawDevice, RoboClawSession};
use super::wheeltec::{WheeltecDevice, WheeltecSession};
use super::{BaseError, BaseSettings, DeviceProtocol, Session};

/// A wire protocol of bases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// This crate's own frames: see [`super::native`].
    #[default]
    Native,
    /// WHEELTEC's STM32 controllers: see [`super::wheeltec`].
    Wheeltec,
    /// `RoboClaw` motor controllers: see [`super::roboclaw`].
    Roboclaw,
    /// `ROSArduinoBridge`: see [`super::arduino`].
    Arduino,
}

impl Protocol {
    /// Every protocol.
    pub const ALL: [Self; 4] = [Self::Native, Self::Wheeltec, Self::Roboclaw, Self::Arduino];

    /// The name on the command line and in settings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::Wheeltec => "wheeltec",
            Self::Roboclaw => "roboclaw",
            Self::Arduino => "arduino",
        }
    }

    /// Creates a session: the host's side of the protocol.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn session(self, settings: BaseSettings) -> Result<Box<dyn Session>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativeSession::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecSession::new(settings)?),
            Self::Roboclaw => Box::new(RoboClawSession::new(settings)?),
            Self::Arduino => Box::new(ArduinoSession::new(settings)?),
        })
    }

    /// Creates a lower controller at power-on: the base's side of the protocol.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn device(self, settings: BaseSettings) -> Result<Box<dyn DeviceProtocol>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativeDevice::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecDevice::new(&settings)?),
            Self::Roboclaw => Box::new(RoboClawDevice::new(settings)?),
            Self::Arduino => Box::new(ArduinoDevice::new(settings)?),
        })
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Protocol {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|known| known.name() == text);
        known.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            let text = text.escape_debug();
            format!("`{text}` is not a protocol: use one of {names}")
        })
    }
}
