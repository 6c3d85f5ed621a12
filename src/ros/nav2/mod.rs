//! What a Nav2 parameter file would say here: DWB, MPPI, the rotation shim, the velocity smoother, the local costmap's
//! footprint and the goal and progress checkers, as settings of ours.
//!
//! Names and meanings are those of Nav2's configuration guide (docs.nav2.org, 2026) and of the parameter files in
//! `nav2_bringup`. What has another meaning here, or none, is not guessed at: every parameter of a node that is read is either
//! mapped or listed with the reason.

mod controller_server;
mod controllers;
mod draft;
mod dwb;
mod error;
mod footprint;
mod leftovers;
mod local_costmap;
mod mppi;
mod parameters;
mod plugins;
mod rotation_shim;
mod section;
mod velocity_smoother;

pub use error::Nav2Error;

use core::fmt::{Display, Formatter};

use serde::Serialize;

use draft::Draft;
use parameters::Nodes;
use section::Section;

/// What became of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Import {
    /// TOML for `--config`: the settings that the file gives, each with where it comes from. All else is at its default.
    pub config: String,
    /// TOML for `--base-config`, likewise; empty when the file gives none.
    pub base_config: String,
    /// Parameters that were taken over, by their places in the file.
    pub mapped: Vec<Mapped>,
    /// Parameters that were not, by their places in the file.
    pub not_mapped: Vec<NotMapped>,
    /// Nodes that were not read.
    pub ignored: Vec<String>,
}

/// A parameter that was taken over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mapped {
    /// Its place in the file, such as `controller_server.FollowPath.max_vel_x`.
    pub key: String,
    /// The settings that it gives.
    pub to: Vec<Target>,
}

/// A setting that a parameter gives, alone or together with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Its path, such as `robot.limits.max_vel_x`.
    pub key: &'static str,
    /// Its value.
    pub value: toml::Value,
    /// What was made of the parameter; nothing where its value is the setting's.
    pub how: String,
}

/// A parameter that was not taken over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NotMapped {
    /// Its place in the file.
    pub key: String,
    /// Of what kind the reason is.
    pub why: Why,
    /// The reason.
    pub reason: String,
}

/// Why a parameter is not taken over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// There is no such thing here.
    NoSuchThing,
    /// There is something like it that means something else.
    OtherMeaning,
    /// There could be.
    NotYet,
    /// Another parameter takes its place.
    NotInForce,
    /// Not a parameter that is known here.
    Unknown,
}

impl Display for Why {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::NoSuchThing => "no such thing here",
            Self::OtherMeaning => "another meaning here",
            Self::NotYet => "not yet",
            Self::NotInForce => "not in force",
            Self::Unknown => "unknown",
        })
    }
}

/// Reads the parameters of one node.
type Reader = fn(Section, &mut Draft) -> Result<(), Nav2Error>;

/// The nodes that are read.
const NODES: [(&str, Reader); 3] = [
    ("controller_server", controller_server::read),
    ("velocity_smoother", velocity_smoother::read),
    ("local_costmap", local_costmap::read),
];

/// Takes over the text of a `nav2_params.yaml`: the parameters of the robot in a namespace, or of the only robot there is.
///
/// The configuration returned is valid, and differs from the default in nothing that the file does not give.
///
/// # Errors
/// Where the text is no such file, does not say which robot is meant, or has values that cannot be ours.
pub fn import(text: &str, namespace: Option<&str>) -> Result<Import, Nav2Error> {
    let nodes = Nodes::parse(text)?;
    let names = NODES.map(|(name, _)| name);
    let namespace = nodes.namespace(namespace, &names)?;
    let mut draft = Draft::default();
    for (name, read) in NODES {
        let Some((section, overridden)) = nodes.of(&namespace, name) else {
            continue;
        };
        for (place, by) in overridden {
            draft.leave(place, Why::NotInForce, format!("{by} takes its place"));
        }
        read(section, &mut draft)?;
    }
    draft.finish(nodes.others(&namespace, &names))
}
