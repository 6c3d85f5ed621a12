//! Search of settings: candidates on some worlds, and the best one judged on others.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use serde_json::json;
use toml::Value;

use super::plan::{listed, require};
use super::{Changes, ExperimentError, Plan, PlanWorlds, WorldSettings};
use crate::base::standard_normal;
use crate::runtime::merge_tables;
use crate::settings::{commented_toml, setting_schema, settings};

settings! {
    /// A plan of `inbye tune`.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct TuningPlan {
        /// Title of the report.
        pub title: String = "inbye: tuned settings".to_owned();
        /// Seeds of noise and moving obstacles, at least one.
        pub seeds: Vec<u64> = vec![0];
        /// Rounds of the search: the first one draws candidates from the whole space, each further one near the best so far.
        pub rounds: u32 = 3, ["", 1 to 100];
        /// Candidates of a round, in addition to the settings without changes in the first one.
        pub candidates: u32 = 12, ["", 1 to 1000];
        /// Seed of the search.
        pub search_seed: u64 = 0;
        /// Changes of the worlds' own settings, with the keys of `inbye drive --config`, such as those of your own robot. The search
        /// starts from these settings, and its gain is that over them.
        pub config: Changes = Changes::default();
        /// What is searched: keys of `inbye drive --config`, such as "local.weights.path", each with `from` and `to`, and `log = true`
        /// for a logarithmic scale, or with `values`. Whole numbers give whole numbers.
        pub space: BTreeMap<String, SearchRange> = BTreeMap::new();
        /// Worlds of the search, as in a plan of `inbye sweep`.
        pub train: Vec<PlanWorlds> = vec![PlanWorlds::default()];
        /// Other worlds, which judge the best candidate, with the same seeds.
        pub judge: Vec<PlanWorlds> = Vec::new();
    }
}

/// The values of a setting that are searched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SearchRange {
    /// Least value.
    pub from: Option<Value>,
    /// Largest value.
    pub to: Option<Value>,
    /// Whether the scale is logarithmic.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub log: bool,
    /// The values, in place of a range.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Value>,
}

setting_schema! {
    SearchRange: json!({
        "type": "object",
        "properties": {
            "from": { "type": "number" },
            "to": { "type": "number" },
            "log": { "type": "boolean" },
            "values": { "type": "array" },
        },
        "additionalProperties": false,
    });
}

/// First comment of a plan's text.
const HEADING: &str =
    "A plan of `inbye tune`, with all keys and their defaults: leave out what keeps its default.";
/// Parents of a round: the best candidates so far.
const PARENTS: usize = 3;
/// Standard deviation of a step from a parent in the second round, in parts of the range, and its factor in each further round.
const STEP: f64 = 0.15;
const STEP_FACTOR: f64 = 0.6;
/// Chance that a step takes another one of the values of a list.
const OTHER_VALUE: f64 = 0.2;

/// A point of the space: a coordinate from 0 to below 1 for each key, in their order.
pub type Point = Vec<f64>;

impl TuningPlan {
    /// The default plan as TOML, each key with a comment.
    #[must_use]
    pub fn documented() -> String {
        commented_toml(HEADING, &Self::default().judge(vec![PlanWorlds::default()]))
    }

    /// Checks every value without opening a file.
    ///
    /// # Errors
    /// The error names the first key whose value cannot be used, and what is accepted.
    pub fn check(&self) -> Result<(), ExperimentError> {
        self.validate()?;
        require(!self.space.is_empty(), "space", "empty", "at least one key with its range")?;
        require(!self.judge.is_empty(), "judge", "empty", "other worlds than those of train")?;
        for (key, range) in &self.space {
            let expected = "{ from = LESS, to = MORE } with numbers, both above zero where log = true, or { values = [...] }";
            let value = Value::try_from(range).map_or_else(|_| String::new(), |it| it.to_string());
            // A list without values is not written.
            let value = if value == "{}" { "without values".to_owned() } else { value };
            let key = format!("space.{}", key.escape_debug());
            require(range.is_usable(), &key, value, expected)?;
        }
        listed("seeds", &self.seeds)?;
        PlanWorlds::check_all("train", &self.train)?;
        PlanWorlds::check_all("judge", &self.judge)
    }

    /// The settings of the plan with changes of them, as TOML for `inbye drive --config`.
    ///
    /// # Errors
    /// The changes are no TOML.
    pub fn settings_with(&self, changes: &str) -> Result<String, String> {
        let (mut table, changes) = (self.config.0.clone(), changes.parse::<Changes>()?);
        merge_tables(&mut table, changes.0);
        Ok(table.to_string())
    }

    /// Checks that each value of a list and both ends of a range are valid with some settings, those of
    /// [`Self::settings_of_worlds`]. A search leaves out settings that are not valid together, and so it would leave out such a
    /// value without a word.
    ///
    /// # Errors
    /// The error names the first key and value that is not valid, alone or with a value of another key.
    pub fn check_values(&self, settings: &[Arc<WorldSettings>]) -> Result<(), ExperimentError> {
        // What the error names is a key of the plan, and no line of these changes.
        let error_of = |changes: &str| match changes.parse::<Changes>() {
            Ok(changes) => settings.iter().find_map(|one| {
                let applied = one.with_table(&changes.0);
                applied.err().map(|error| error.to_string())
            }),
            Err(error) => Some(error),
        };
        let line = |key: &str, value: &Value| format!("{key} = {value}\n");
        for (key, range) in &self.space {
            for value in range.extremes() {
                let own = line(key, value);
                let Some(error) = error_of(&own) else {
                    continue;
                };
                let others = self.space.iter().filter(|(other, _)| *other != key);
                let is_valid = others
                    .flat_map(|(other, range)| range.extremes().map(|value| line(other, value)))
                    .any(|other| error_of(&format!("{own}{other}")).is_none());
                if !is_valid {
                    return Err(ExperimentError::Unusable {
                        place: format!("space.{}", key.escape_debug()),
                        reason: format!("{value}: {error}"),
                    });
                }
            }
        }
        Ok(())
    }

    /// The settings of all worlds with those of the plan, each once: kinds of worlds have settings of their own, and a candidate
    /// must be valid with all of them. Paths are relative to this folder.
    ///
    /// # Errors
    /// The error names a world of the judgement that is one of the search too, since both have the same seeds; or a world that
    /// cannot be read.
    pub fn settings_of_worlds(
        &self,
        folder: &Path,
    ) -> Result<Vec<Arc<WorldSettings>>, ExperimentError> {
        let read = |worlds| self.plan(worlds, BTreeMap::new()).read_worlds(folder);
        let (train, judge) = (read(&self.train)?, read(&self.judge)?);
        let trained: BTreeSet<&String> = train.iter().map(|world| &world.digest).collect();
        if let Some(world) = judge.iter().find(|world| trained.contains(&world.digest)) {
            return Err(ExperimentError::Unusable {
                place: "judge".to_owned(),
                reason: format!(
                    "world {} of {} is in train too, with the same seeds: name other worlds",
                    world.name.escape_debug(),
                    world.kind.name()
                ),
            });
        }
        let all = train.into_iter().chain(judge).map(|world| world.settings);
        let distinct: BTreeMap<String, _> = all.map(|one| (one.digest.clone(), one)).collect();
        Ok(distinct.into_values().collect())
    }

    /// The plan of `inbye sweep` that drives some worlds with these settings.
    #[must_use]
    pub fn plan(&self, worlds: &[PlanWorlds], configs: BTreeMap<String, Changes>) -> Plan {
        Plan {
            title: self.title.clone(),
            seeds: self.seeds.clone(),
            worlds: worlds.to_vec(),
            config: self.config.clone(),
            configs,
            ..Plan::default()
        }
    }

    /// The settings at a point, as TOML with the keys of `inbye drive --config`.
    #[must_use]
    pub fn changes(&self, point: &[f64]) -> String {
        let line = |((key, range), at): ((&String, &SearchRange), &f64)| {
            format!("{key} = {}\n", range.value(*at))
        };
        self.space.iter().zip(point).map(line).collect()
    }

    /// The points of a round, from those so far in the order of their success, the best first. `is_usable` says whether settings
    /// are valid together; points that are not are drawn again, and left out after many attempts.
    #[must_use]
    pub fn round(
        &self,
        round: u32,
        best_first: &[Point],
        is_usable: impl Fn(&str) -> bool,
    ) -> Vec<Point> {
        /// Draws of a point.
        const ATTEMPTS: u32 = 100;
        let mut random = Pcg64Mcg::seed_from_u64(self.search_seed ^ u64::from(round) << 32);
        let parents = &best_first[..best_first.len().min(PARENTS)];
        let mut points: Vec<Point> = Vec::new();
        for _ in 0..self.candidates {
            let drawn = (0..ATTEMPTS).map(|_| match parents {
                [] => self.space.iter().map(|_| random.random_range(0.0..1.0)).collect(),
                parents => {
                    let parent = &parents[random.random_range(0..parents.len())];
                    self.near(parent, STEP * STEP_FACTOR.powi(round as i32 - 1), &mut random)
                }
            });
            let mut drawn = drawn.filter(|point: &Point| is_usable(&self.changes(point)));
            points.extend(drawn.next());
        }
        points
    }

    /// A point at about this distance from another one.
    fn near(&self, parent: &[f64], step: f64, random: &mut Pcg64Mcg) -> Point {
        let ranges = self.space.values().zip(parent);
        ranges
            .map(|(range, &at)| {
                if range.values.is_empty() {
                    // Reflected at the ends, so that they are not drawn more often.
                    let moved = (at + step * standard_normal(random)).rem_euclid(2.0);
                    (if moved < 1.0 { moved } else { 2.0 - moved }).min(1.0 - f64::EPSILON)
                } else if random.random_range(0.0..1.0) < OTHER_VALUE {
                    random.random_range(0.0..1.0)
                } else {
                    at
                }
            })
            .collect()
    }
}

impl SearchRange {
    fn ends(&self) -> Option<(f64, f64)> {
        let number =
            |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
        let (from, to) = (number(self.from.as_ref()?)?, number(self.to.as_ref()?)?);
        (from.is_finite() && to.is_finite() && from < to).then_some((from, to))
    }

    /// The values of a list, or both ends.
    fn extremes(&self) -> impl Iterator<Item = &Value> {
        self.values.iter().chain(&self.from).chain(&self.to)
    }

    fn is_usable(&self) -> bool {
        if !self.values.is_empty() {
            return self.from.is_none() && self.to.is_none() && !self.log;
        }
        self.ends().is_some_and(|(from, _)| !self.log || from > 0.0)
    }

    /// The value at a coordinate, 0 to below 1.
    fn value(&self, at: f64) -> Value {
        let Some((from, to)) = self.ends() else {
            let index = (at * self.values.len() as f64) as usize;
            let value = self.values.get(index.min(self.values.len().saturating_sub(1)));
            return value.cloned().unwrap_or_else(|| Value::String(String::new()));
        };
        let is_whole =
            matches!((&self.from, &self.to), (Some(Value::Integer(_)), Some(Value::Integer(_))));
        // Each whole number has the same share of the range.
        let to = if is_whole { to + 1.0 } else { to };
        let value =
            if self.log { from * libm::pow(to / from, at) } else { from + (to - from) * at };
        if is_whole { Value::Integer(value.floor() as i64) } else { Value::Float(value) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::barn::barn_config;
    use super::*;
    use crate::runtime::Config;

    fn plan(space: &str) -> TuningPlan {
        toml::from_str(&format!("candidates = 40\n[[judge]]\n[space]\n{space}")).expect("a plan")
    }

    #[test]
    fn values_cover_their_range_and_keep_its_type() {
        let plan = plan(
            "\"a.log\" = { from = 0.01, to = 1.0, log = true }\n\"b.whole\" = { from = 2, to = 4 }\n\
             c = { values = [\"x\", true] }\n",
        );
        assert_eq!(plan.check(), Ok(()));
        assert_eq!(plan.changes(&[0.5, 0.0, 0.0]), "a.log = 0.1\nb.whole = 2\nc = \"x\"\n");
        assert_eq!(plan.changes(&[0.0, 0.999, 0.999]), "a.log = 0.01\nb.whole = 4\nc = true\n");
    }

    #[test]
    fn unusable_ranges_are_rejected_by_their_key() {
        for range in [
            "{}",
            "{ from = 1, to = 1 }",
            "{ from = 0.0, to = 1.0, log = true }",
            "{ from = 1, to = 2, values = [1] }",
            "{ from = \"a\", to = \"b\" }",
        ] {
            let error = plan(&format!("key = {range}\n")).check().expect_err(range).to_string();
            assert!(error.starts_with("space.key is "), "{error}");
        }
        assert!(plan("").check().is_err(), "nothing is searched");
    }

    #[test]
    fn number_out_of_range_in_a_list_of_tables_is_rejected_by_its_index() {
        let mut plan = plan("key = { from = 1, to = 2 }\n");
        plan.train.push(PlanWorlds::default().people(101));
        let error = plan.validate().expect_err("too many people").to_string();
        assert!(error.starts_with("[train.1] people is 101: it must be 0 to 100"), "{error}");
    }

    /// Default settings, and those of BARN, which let the robot pass obstacles nearer.
    #[test]
    fn values_that_are_not_valid_are_rejected_by_key_and_value() {
        let settings = [Config::default(), barn_config(1.0)].map(|config| Arc::new(config.into()));
        for (space, place) in [
            (
                "\"local.sampler\" = { values = [\"arcs\", \"spirals\"] }",
                "space.local.sampler: \"spirals\": unknown variant",
            ),
            (
                "\"local.vx_samples\" = { from = 0, to = 8 }",
                "space.local.vx_samples: 0: [local] vx_samples is 0",
            ),
            (
                "\"local.vx_sample\" = { from = 1, to = 8 }",
                "space.local.vx_sample: 1: unknown field",
            ),
            (
                "\"collision_monitor.margin_m\" = { from = 0.005, to = 0.02 }",
                "space.collision_monitor.margin_m: 0.02: [navigator] safety_margin_m is 0.01",
            ),
        ] {
            let error = plan(space).check_values(&settings).expect_err(space).to_string();
            assert!(error.starts_with(place), "{error}");
        }
        let valid = "\"local.sampler\" = { values = [\"arcs\", \"ramps\"] }\n\"local.vx_samples\" = { from = 8, to = 40 }";
        assert_eq!(plan(valid).check_values(&settings), Ok(()));
    }

    /// With a success that grows towards 0.8 the rounds come near it; the same seed gives the same points.
    #[test]
    fn rounds_come_nearer_to_the_best_point() {
        let plan = plan("x = { from = 0.0, to = 1.0 }\ny = { from = 0.0, to = 1.0 }\n");
        let error = |point: &Point| libm::hypot(point[0] - 0.8, point[1] - 0.8);
        let mut all: Vec<Point> = Vec::new();
        let mut best = Vec::new();
        for round in 0..4 {
            let points = plan.round(round, &all, |_| true);
            assert_eq!(points, plan.round(round, &all, |_| true));
            assert!(points.iter().flatten().all(|at| (0.0..1.0).contains(at)));
            all.extend(points);
            all.sort_by(|one, other| error(one).total_cmp(&error(other)));
            best.push(error(&all[0]));
        }
        assert!(best[3] < 0.03 && best[3] < best[0], "{best:?}");
    }

    #[test]
    fn points_with_unusable_settings_are_drawn_again() {
        let plan = plan("x = { from = 0.0, to = 1.0 }\n");
        let points = plan.round(0, &[], |changes| !changes.starts_with("x = 0.0"));
        assert!(points.len() == 40 && points.iter().all(|point| point[0] >= 0.1), "{points:?}");
        assert_eq!(plan.round(0, &[], |_| false), Vec::<Point>::new());
    }

    #[test]
    fn world_of_the_search_cannot_judge() {
        let plan = |judge: &str| -> TuningPlan {
            let text = format!("[[train]]\nkind = \"scenes\"\n[[judge]]\n{judge}");
            toml::from_str(&text).expect("a plan")
        };
        let error = plan("kind = \"scenes\"").settings_of_worlds(Path::new("")).expect_err("equal");
        let text = "judge: world roadway of scenes is in train too, with the same seeds";
        assert!(error.to_string().starts_with(text), "{error}");
        let settings = plan("kind = \"missions\"").settings_of_worlds(Path::new(""));
        assert_eq!(settings.expect("other worlds").len(), 1);
    }
}
