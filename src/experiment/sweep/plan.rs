//! What a sweep compares: the plan, a TOML file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::SamplingGrid;
use crate::documented::{Keys, commented_toml, documented};
use crate::local::Weights;

documented! {
    /// A plan: every combination of what its keys list is a cell.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct SweepPlan {
        /// What the report is called.
        pub title: String,
        /// Seeds of noise and people, at least one.
        pub seeds: Vec<u64>,
        /// Samplings of the dynamic window, forward speeds by turn rates, as "16x64". Empty: that of the settings.
        pub sampling: Vec<SamplingGrid>,
        /// Engines: "cpu", "gpu", or "gpu:NAME" for an adapter whose name contains NAME.
        pub engines: Vec<String>,
        /// Threads of a CPU engine whose latency is measured, 1 to 1024; everywhere else it has one.
        pub latency_threads: usize,
        /// Sets of weights by their names, each with the keys of `[local.weights]`; those left out are the paper's. Empty: the
        /// weights of the settings.
        pub weights: BTreeMap<String, Weights>,
        /// Changes of settings by their names, each a table with the keys of `inbye drive --config`. Empty: the settings of
        /// the worlds as they are.
        pub configs: BTreeMap<String, Table>,
        /// What is driven in, as often as wanted.
        pub worlds: Vec<SweepWorlds>,
    }
}

documented! {
    /// Worlds of one kind.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct SweepWorlds {
        /// Which: "scenes", built in, each with its people; "map", routes on a map; "missions", for each seed a random one, on a
        /// map or on the built-in ones; "barn" and "dynabarn", worlds of these benchmarks by their rules.
        pub kind: WorldKind,
        /// The folder of "barn" and "dynabarn", the map of "map" and "missions". It counts from the plan's own folder, such as
        /// "maps/mine.yaml".
        pub path: Option<PathBuf>,
        /// Only these worlds of "barn" and "dynabarn", by their numbers. Empty: all.
        pub only: Vec<u32>,
        /// Highest speed in "barn", m/s, above zero and at most 10.
        pub max_speed_m_s: f64,
        /// Side of a cell of a .map or text map, metres, above zero.
        pub resolution_m: f64,
        /// Routes of "map": tables of `start`, x, y and yaw, and `goal`, x, y and where wanted yaw; metres and radians.
        pub routes: Vec<Route>,
        /// Moving obstacles on each route of "map", and at most so many in each of "missions", 0 to 100.
        pub people: usize,
        /// Simulated time after which a route of "map" or "scenes" ends, seconds, above zero.
        pub time_limit_s: f64,
        /// Longest path of "missions", metres, 4 to 10000.
        pub longest_m: f64,
        /// Share of "missions", 0 to 1, with things on the way that the map does not show.
        pub unmapped_share: f64,
        /// Whether latencies are measured here: such cells run one at a time, with the machine to themselves.
        pub latency: bool,
    }
}

/// What worlds there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Its word in plans and tables.
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

/// From where to where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Start: x and y, metres, and yaw, radians.
    pub start: [f64; 3],
    /// Goal: x and y, metres, and the yaw to park with where one is given.
    pub goal: Vec<f64>,
}

impl Default for SweepPlan {
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
            worlds: vec![SweepWorlds::default()],
        }
    }
}

impl Default for SweepWorlds {
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

/// What the text of a plan begins with.
const HEADING: &str = "A plan of `inbye sweep`, with all keys and their defaults: leave out what is to stay as it is. Each \
    combination of seeds, samplings, engines, weights, settings and worlds is a cell.";

impl SweepPlan {
    /// As TOML: every key with its default, and in a comment what it does. Read again it is the default.
    #[must_use]
    pub fn documented() -> String {
        let tables: [(&str, Keys); 2] = [("", Self::KEYS), ("worlds", SweepWorlds::KEYS)];
        // Plain numbers and words, which TOML has no trouble with.
        let mut defaults = Table::try_from(Self::default()).unwrap_or_default();
        if let Some(Value::Array(worlds)) = defaults.remove("worlds") {
            defaults.extend(worlds.into_iter().map(|one| ("worlds".to_owned(), one)));
        }
        commented_toml(HEADING, &tables, &defaults).replace("\n[worlds]\n", "\n[[worlds]]\n")
    }
}
