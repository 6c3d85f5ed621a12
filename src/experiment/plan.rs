//! The plan of a sweep, a TOML file, and the check of its values.

use core::fmt::{self, Display};
use core::str::FromStr;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::json;
use toml::Table;

use super::ExperimentError;
use crate::local::{EngineChoice, Weights};
use crate::map::has_own_resolution;
use crate::runtime::Config;
use crate::settings::{choices, commented_toml, setting_schema, settings, words};

settings! {
    /// A plan. Every combination of the listed values is a cell.
    ///
    /// [`Plan::check`] checks every value. [`Plan::validate`] is a part of it: it checks only the ranges of the numbers.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Plan {
        /// Title of the report.
        pub title: String = "inbye: a sweep".to_owned();
        /// Seeds of noise and moving obstacles, at least one.
        pub seeds: Vec<u64> = vec![0];
        /// Samplings of the dynamic window, forward speeds by turn rates, as "16x64". Empty: that of the settings.
        pub sampling: Vec<SamplingGrid> = Vec::new();
        /// Engines: "cpu", "gpu", or "gpu:NAME" for an adapter whose name contains NAME.
        pub engines: Vec<String> = vec!["cpu".to_owned()];
        /// Threads of a CPU engine whose latency is measured; it has one elsewhere.
        pub latency_threads: usize = 1, ["", 1 to 1024];
        /// Sets of weights by their names, each with the keys of `[local.weights]`; those left out are the paper's.
        /// Empty: the weights of the settings.
        pub weights: BTreeMap<String, Weights> = BTreeMap::new();
        /// Changes of the worlds' own settings for all planners, with the keys of `inbye drive --config`, such as those of your own
        /// robot. The ideal time is that of this robot.
        pub config: Changes = Changes::default();
        /// Changes of settings by their names, each a table with the keys of `inbye drive --config`. Empty: the
        /// worlds' own settings.
        pub configs: BTreeMap<String, Changes> = BTreeMap::new();
        /// The worlds, in any number of tables.
        pub worlds: Vec<PlanWorlds> = vec![PlanWorlds::default()];
    }
}

settings! {
    /// Worlds of one kind.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PlanWorlds {
        /// Kind: "scenes", the built-in `roadway`, `crossing` and `dead_end`, each with its people; "map", routes on a map; "missions", a random one for each
        /// seed, on a map or on the built-in ones; "barn" and "dynabarn", worlds of these benchmarks by their rules;
        /// "localization", the cases of `inbye bench localization`; "paper", the drives of `inbye bench paper`; "mrpb", the
        /// worlds of MRPB 1.0.
        pub kind: WorldKind = WorldKind::default();
        /// The folder of "barn", "dynabarn" and "mrpb", the map of "map" and "missions". It is relative to the plan's folder,
        /// such as "maps/mine.yaml".
        pub path: Option<PathBuf> = None;
        /// Only these worlds of "barn" and "dynabarn", by their numbers. Empty: all.
        pub only: Vec<u32> = Vec::new();
        /// Highest speed in "barn".
        pub max_speed_m_s: f64 = 2.0, ["m/s", above 0 to 10];
        /// Side of a cell of a .map or text map of "map" and "missions".
        pub resolution_m: f64 = 1.0, ["m", above 0 to 1e9];
        /// Routes of "map", such as [{ start = [1, 1, 0], goal = [5, 1] }]: `start` is x, y and yaw, and `goal` x, y and optionally yaw;
        /// metres and radians.
        pub routes: Vec<PlanRoute> = Vec::new();
        /// Number of moving obstacles on each route of "map" and in the dynamic worlds of "mrpb", and their largest number in
        /// each of "missions".
        pub people: usize = 0, ["", 0 to 100];
        /// Simulated time after which a route of "map" or "scenes" ends.
        pub time_limit_s: f64 = 3600.0, ["s", above 0 to 1e9];
        /// Longest path of "missions".
        pub longest_m: f64 = 60.0, ["m", 4 to 10000];
        /// Share of "missions" with obstacles on the path that the map does not show.
        pub unmapped_share: f64 = 0.0, ["", 0 to 1];
        /// Whether latency is measured here: such cells run one at a time, with the machine to themselves.
        pub latency: bool = false;
    }
}

setting_schema! {
    WorldKind: choices::<Self>();
    SamplingGrid: json!({ "type": "string" });
    Changes: json!({ "type": "object" });
    PlanRoute: json!({
        "type": "object",
        "properties": {
            "start": { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 },
            "goal": { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 3 },
        },
        "required": ["start", "goal"],
        "additionalProperties": false,
    });
}

words! {
    /// Kinds of worlds.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[non_exhaustive]
    pub enum WorldKind {
        /// The built-in scenes.
        #[default]
        Scenes = "scenes",
        /// Routes on a map.
        Map = "map",
        /// Random missions.
        Missions = "missions",
        /// BARN.
        Barn = "barn",
        /// `DynaBARN`.
        DynaBarn = "dynabarn",
        /// Cases of localization.
        Localization = "localization",
        /// Drives of the paper.
        Paper = "paper",
        /// MRPB 1.0.
        Mrpb = "mrpb",
    }
}

/// Numbers of forward speeds and turn rates, written as `16x64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub struct SamplingGrid {
    /// Number of forward speeds, at least one.
    pub vx_samples: u32,
    /// Number of turn rates, at least one.
    pub vtheta_samples: u32,
}

impl TryFrom<String> for SamplingGrid {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let count = |text: &str| text.parse().ok().filter(|&count: &u32| count > 0);
        let counts = text.split_once('x').and_then(|(v, omega)| {
            Some(Self { vx_samples: count(v)?, vtheta_samples: count(omega)? })
        });
        counts.ok_or_else(|| {
            let text = text.escape_debug();
            format!("`{text}` is no sampling: write forward speeds x turn rates, such as \"16x64\"")
        })
    }
}

impl From<SamplingGrid> for String {
    fn from(grid: SamplingGrid) -> Self {
        grid.to_string()
    }
}

impl Display for SamplingGrid {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}x{}", self.vx_samples, self.vtheta_samples)
    }
}

/// Changes of settings: TOML with the keys of `inbye drive --config`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Changes(pub(super) Table);

impl Changes {
    /// Settings with the changes of this key of a plan.
    pub(super) fn applied(&self, key: &str, settings: &Config) -> Result<Config, ExperimentError> {
        settings
            .with_table(&self.0)
            .map_err(|error| ExperimentError::BadSettings { place: key.to_owned(), error })
    }
}

impl FromStr for Changes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().map(Self).map_err(|error: toml::de::Error| error.message().to_owned())
    }
}

/// A start and a goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct PlanRoute {
    /// Start: x and y in metres, yaw in radians.
    pub start: [f64; 3],
    /// Goal: x and y in metres, and optionally the final yaw in radians.
    pub goal: Vec<f64>,
}

/// First comment of a plan's text.
const HEADING: &str = "A plan of `inbye sweep`, with all keys and their defaults: leave out what keeps its default. Each \
    combination of seeds, samplings, engines, weights, settings and worlds is a cell.";

impl Plan {
    /// The default plan as TOML, each key with a comment.
    #[must_use]
    pub fn documented() -> String {
        commented_toml(HEADING, &Self::default())
    }

    /// Checks every value without opening a file: lists, names, worlds, and the ranges of [`Plan::validate`].
    ///
    /// # Errors
    /// The error names the first key whose value cannot be used, and what is accepted.
    pub fn check(&self) -> Result<(), ExperimentError> {
        listed("seeds", &self.seeds)?;
        listed("engines", &self.engines)?;
        let samplings: Vec<String> = self.sampling.iter().map(ToString::to_string).collect();
        distinct("sampling", &samplings)?;
        for (key, name) in self
            .configs
            .keys()
            .map(|name| ("configs", name))
            .chain(self.weights.keys().map(|name| ("weights", name)))
        {
            // Tables and the terminal show it.
            let is_shown = !name.chars().any(char::is_control);
            require(is_shown, key, name, "a name without control characters")?;
        }
        for engine in &self.engines {
            let is_one = engine.parse::<EngineChoice>().is_ok();
            let expected = "cpu, gpu or gpu:ADAPTER-NAME: a cell must name its engine";
            require(is_one, "engines", engine, expected)?;
        }
        self.validate()?;
        PlanWorlds::check_all("worlds", &self.worlds)
    }
}

impl PlanWorlds {
    /// Checks the tables of a key, at least one, whose numbers are within their ranges.
    pub(super) fn check_all(key: &'static str, all: &[Self]) -> Result<(), ExperimentError> {
        require(!all.is_empty(), key, "empty", "at least one")?;
        all.iter().enumerate().try_for_each(|(index, worlds)| {
            worlds.check().map_err(|error| error.in_table(&format!("{key}.{index}")))
        })
    }

    fn check(&self) -> Result<(), ExperimentError> {
        use WorldKind::{Barn, DynaBarn, Localization, Map, Mrpb, Paper, Scenes};
        let kind = self.kind;
        let is = |kinds: &[WorldKind]| kinds.contains(&kind);
        let path = self.path.as_ref().map_or("missing", |_| "given");
        let needs = is(&[Map, Barn, DynaBarn, Mrpb]);
        require(!needs || self.path.is_some(), "path", path, "given for this kind")?;
        require(
            !is(&[Scenes, Localization, Paper]) || self.path.is_none(),
            "path",
            path,
            "left out: worlds of this kind are built in",
        )?;
        let may_have_only = self.only.is_empty() || is(&[Barn, DynaBarn]);
        let expected = "left out: only barn and dynabarn have numbered worlds";
        require(may_have_only, "only", "given", expected)?;
        let has_routes = !self.routes.is_empty();
        let expected = "a list of at least one route for kind = \"map\", such as [{ start = [1, 1, 0], goal = [5, 1] }]";
        require(has_routes || !is(&[Map]), "routes", "missing or empty", expected)?;
        let expected = "left out: only worlds of kind = \"map\" have routes";
        require(!has_routes || is(&[Map]), "routes", "given", expected)?;
        self.check_unused(&is)?;
        let is_needed = !self.path.as_deref().is_some_and(has_own_resolution);
        let is_default = self.resolution_m.total_cmp(&Self::default().resolution_m).is_eq();
        let expected = "left out: a .yaml map states its own";
        require(is_needed || is_default, "resolution_m", self.resolution_m, expected)?;
        let ends = |route: &PlanRoute| {
            let numbers = || route.start.iter().chain(&route.goal);
            (2..=3).contains(&route.goal.len()) && numbers().all(|number| number.abs() <= 1e9)
        };
        let expected = "start = [x, y, yaw], goal = [x, y] or [x, y, yaw], each -1e9 to 1e9";
        require(self.routes.iter().all(ends), "routes", "malformed", expected)
    }

    /// Checks that keys without an effect on worlds of this kind have their defaults.
    fn check_unused(&self, is: &dyn Fn(&[WorldKind]) -> bool) -> Result<(), ExperimentError> {
        use WorldKind::{Barn, Map, Missions, Mrpb, Scenes};
        let default = Self::default();
        let number = |key, kinds: &[WorldKind], [value, default]: [f64; 2], expected| {
            require(is(kinds) || value.total_cmp(&default).is_eq(), key, value, expected)
        };
        number(
            "max_speed_m_s",
            &[Barn],
            [self.max_speed_m_s, default.max_speed_m_s],
            "left out: it is for barn; set robot.limits.max_vel_x in [configs]",
        )?;
        number(
            "resolution_m",
            &[Map, Missions],
            [self.resolution_m, default.resolution_m],
            "left out: it is for the maps of map and missions",
        )?;
        number(
            "time_limit_s",
            &[Map, Scenes],
            [self.time_limit_s, default.time_limit_s],
            "left out: it is for map and scenes; worlds of other kinds have their own limit",
        )?;
        number(
            "longest_m",
            &[Missions],
            [self.longest_m, default.longest_m],
            "left out: it is for missions",
        )?;
        number(
            "unmapped_share",
            &[Missions],
            [self.unmapped_share, default.unmapped_share],
            "left out: it is for missions",
        )?;
        let expected = "left out: it is for map, missions and mrpb; worlds of other kinds have their own people";
        require(is(&[Map, Missions, Mrpb]) || self.people == 0, "people", self.people, expected)
    }
}

/// Checks that a list is not empty and has no value twice.
pub(super) fn listed<T: Display>(name: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    require(!values.is_empty(), name, "empty", "at least one")?;
    distinct(name, values)
}

fn distinct<T: Display>(name: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    let mut seen = BTreeSet::new();
    for value in values {
        let value = value.to_string();
        if !seen.insert(value.clone()) {
            let value = value.escape_debug().to_string();
            return Err(ExperimentError::Repeated { key: name.to_owned(), value });
        }
    }
    Ok(())
}

pub(super) fn require(
    fits: bool,
    key: &str,
    value: impl Display,
    expected: &'static str,
) -> Result<(), ExperimentError> {
    if fits {
        return Ok(());
    }
    Err(ExperimentError::BadValue {
        key: key.to_owned(),
        value: value.to_string().escape_debug().to_string(),
        expected,
    })
}
