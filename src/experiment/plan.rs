//! The plan of a sweep, a TOML file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::SamplingGrid;
use crate::documented::{Keys, commented_toml, documented};
use crate::local::Weights;

documented! {
    /// A plan. Every combination of the listed values is a cell.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Plan {
        /// Title of the report.
        pub title: String,
        /// Seeds of noise and moving obstacles, at least one.
        pub seeds: Vec<u64>,
        /// Samplings of the dynamic window, forward speeds by turn rates, as "16x64". Empty: that of the settings.
        pub sampling: Vec<SamplingGrid>,
        /// Engines: "cpu", "gpu", or "gpu:NAME" for an adapter whose name contains NAME.
        pub engines: Vec<String>,
        /// Threads of a CPU engine whose latency is measured, 1 to 1024; it has one elsewhere.
        pub latency_threads: usize,
        /// Sets of weights by their names, each with the keys of `[local.weights]`; those left out are the paper's. Empty: the
        /// weights of the settings.
        pub weights: BTreeMap<String, Weights>,
        /// Changes of settings by their names, each a table with the keys of `inbye drive --config`. Empty: the worlds'
        /// own settings.
        pub configs: BTreeMap<String, Table>,
        /// The worlds, in any number of tables.
        pub worlds: Vec<PlanWorlds>,
    }
}

documented! {
    /// Worlds of one kind.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PlanWorlds {
        /// Kind: "scenes", built in, each with its people; "map", routes on a map; "missions", a random one for each seed, on a
        /// map or on the built-in ones; "barn" and "dynabarn", worlds of these benchmarks by their rules.
        pub kind: WorldKind,
        /// The folder of "barn" and "dynabarn", the map of "map" and "missions". It is relative to the plan's folder, such as
        /// "maps/mine.yaml".
        pub path: Option<PathBuf>,
        /// Only these worlds of "barn" and "dynabarn", by their numbers. Empty: all.
        pub only: Vec<u32>,
        /// Highest speed in "barn", m/s, above zero and at most 10.
        pub max_speed_m_s: f64,
        /// Side of a cell of a .map or text map, metres, above zero.
        pub resolution_m: f64,
        /// Routes of "map": tables of `start`, x, y and yaw, and `goal`, x, y and optionally yaw; metres and radians.
        pub routes: Vec<PlanRoute>,
        /// Number of moving obstacles on each route of "map", and their largest number in each of "missions", 0 to 100.
        pub people: usize,
        /// Simulated time after which a route of "map" or "scenes" ends, seconds, above zero.
        pub time_limit_s: f64,
        /// Longest path of "missions", metres, 4 to 10000.
        pub longest_m: f64,
        /// Share of "missions", 0 to 1, with obstacles on the path that the map does not show.
        pub unmapped_share: f64,
        /// Whether latency is measured here: such cells run one at a time, with the machine to themselves.
        pub latency: bool,
    }
}

/// Kinds of worlds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WorldKind {
    /// The built-in scenes.
    #[default]
    Scenes,
    /// Routes on a map.
    Map,
    /// Random missions.
    Missions,
    /// BARN.
    Barn,
    /// `DynaBARN`.
    DynaBarn,
}

impl WorldKind {
    /// Its name in plans and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scenes => "scenes",
            Self::Map => "map",
            Self::Missions => "missions",
            Self::Barn => "barn",
            Self::DynaBarn => "dynabarn",
        }
    }
}

/// A start and a goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanRoute {
    /// Start: x and y in metres, yaw in radians.
    pub start: [f64; 3],
    /// Goal: x and y in metres, and optionally the final yaw in radians.
    pub goal: Vec<f64>,
}

impl Default for Plan {
    /// The built-in scenes, once each, with the default settings.
    fn default() -> Self {
        Self {
            title: "inbye: a sweep".to_owned(),
            seeds: vec![0],
            sampling: Vec::new(),
            engines: vec!["cpu".to_owned()],
            latency_threads: 1,
            weights: BTreeMap::new(),
            configs: BTreeMap::new(),
            worlds: vec![PlanWorlds::default()],
        }
    }
}

impl Default for PlanWorlds {
    fn default() -> Self {
        Self {
            kind: WorldKind::default(),
            path: None,
            only: Vec::new(),
            max_speed_m_s: 2.0,
            resolution_m: 1.0,
            routes: Vec::new(),
            people: 0,
            time_limit_s: 3600.0,
            longest_m: 60.0,
            unmapped_share: 0.0,
            latency: false,
        }
    }
}

/// First comment of a plan's text.
const HEADING: &str = "A plan of `inbye sweep`, with all keys and their defaults: leave out what keeps its default. Each \
    combination of seeds, samplings, engines, weights, settings and worlds is a cell.";

impl Plan {
    /// The default plan as TOML, each key with a comment.
    #[must_use]
    pub fn documented() -> String {
        let tables: [(&str, Keys); 2] = [("", Self::KEYS), ("worlds", PlanWorlds::KEYS)];
        // Numbers and texts always serialise.
        let mut defaults = Table::try_from(Self::default()).unwrap_or_default();
        if let Some(Value::Array(worlds)) = defaults.remove("worlds") {
            defaults.extend(worlds.into_iter().map(|one| ("worlds".to_owned(), one)));
        }
        commented_toml(HEADING, &tables, &defaults).replace("\n[worlds]\n", "\n[[worlds]]\n")
    }
}
