//! The result of an import.

use core::fmt::{Display, Formatter};

use serde::Serialize;

/// The result of an import.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Import {
    /// The imported settings in TOML, each with its source as a comment. All others have their defaults.
    pub config: String,
    /// The imported settings of the base, likewise; empty if there are none.
    pub base_config: String,
    /// Mapped parameters by their paths in the file.
    pub mapped: Vec<Mapped>,
    /// Unmapped parameters by their paths in the file.
    pub unmapped: Vec<Unmapped>,
    /// Nodes that are not imported.
    pub ignored_nodes: Vec<String>,
}

/// A mapped parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mapped {
    /// Path in the file, such as `controller_server.FollowPath.max_vel_x`.
    pub parameter: String,
    /// The settings that depend on it.
    pub settings: Vec<MappedSetting>,
}

/// A setting that depends on a parameter, alone or together with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MappedSetting {
    /// Path of the setting, such as `robot.limits.max_vel_x`.
    pub setting: &'static str,
    /// Value of the setting.
    pub value: serde_json::Value,
    /// How the value follows from the parameter; empty if both are equal.
    pub note: String,
}

/// An unmapped parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unmapped {
    /// Path in the file.
    pub parameter: String,
    /// Kind of the reason.
    pub reason: UnmappedReason,
    /// Explanation of the reason.
    pub explanation: String,
}

/// Why a parameter is not mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum UnmappedReason {
    /// No setting has the same purpose.
    NoEquivalent,
    /// The setting with the same purpose has another meaning.
    DifferentMeaning,
    /// The import does not support it.
    NotSupported,
    /// Another parameter overrides it.
    NotInEffect,
    /// The parameter is unknown.
    Unknown,
}

impl Display for UnmappedReason {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::NoEquivalent => "no equivalent",
            Self::DifferentMeaning => "different meaning",
            Self::NotSupported => "not supported",
            Self::NotInEffect => "not in effect",
            Self::Unknown => "unknown",
        })
    }
}
