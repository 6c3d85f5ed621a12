//! The protocols by name.

use core::fmt;
use core::str::FromStr;

use serde::{Deserialize, Serialize};

use super::arduino::{ArduinoPeer, ArduinoSession};
use super::native::{NativePeer, NativeSession};
use super::roboclaw::{RoboClawPeer, RoboClawSession};
use super::wheeltec::{WheeltecPeer, WheeltecSession};
use super::{BaseError, BaseSettings, Peer, Session};

/// A language that bases speak.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// Our own frames: see [`super::native`].
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
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Native, Self::Wheeltec, Self::Roboclaw, Self::Arduino];

    /// Its name, as typed.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::Wheeltec => "wheeltec",
            Self::Roboclaw => "roboclaw",
            Self::Arduino => "arduino",
        }
    }

    /// A conversation with a base, as its host.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn session(self, settings: BaseSettings) -> Result<Box<dyn Session>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativeSession::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecSession::new(settings)?),
            Self::Roboclaw => Box::new(RoboClawSession::new(settings)?),
            Self::Arduino => Box::new(ArduinoSession::new(settings)?),
        })
    }

    /// A lower controller that was just switched on, of a machine that is as the settings say.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn peer(self, settings: BaseSettings) -> Result<Box<dyn Peer>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativePeer::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecPeer::new(&settings)?),
            Self::Roboclaw => Box::new(RoboClawPeer::new(settings)?),
            Self::Arduino => Box::new(ArduinoPeer::new(settings)?),
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
        let named = Self::ALL.into_iter().find(|known| known.name() == text);
        named.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            let text = text.escape_debug();
            format!("`{text}` is no protocol: it is one of {names}")
        })
    }
}
