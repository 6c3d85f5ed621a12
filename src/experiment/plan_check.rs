//! Checks of a plan's values.

use core::fmt::Display;
use std::collections::BTreeSet;

use super::{ExperimentError, Plan, PlanRoute, PlanWorlds, WorldKind};
use crate::local::EngineChoice;

impl Plan {
    /// Checks every value without opening a file.
    ///
    /// # Errors
    /// [`ExperimentError::BadKey`] names the first key whose value cannot be used, and what is accepted.
    pub fn check(&self) -> Result<(), ExperimentError> {
        listed("seeds", &self.seeds)?;
        listed("engines", &self.engines)?;
        require(!self.worlds.is_empty(), "worlds", "empty", "at least one")?;
        let samplings: Vec<String> = self.sampling.iter().map(ToString::to_string).collect();
        distinct("sampling", &samplings)?;
        for engine in &self.engines {
            let known = engine.parse::<EngineChoice>();
            let is_one = known.is_ok_and(|engine| engine != EngineChoice::Auto);
            let expected = "cpu, gpu or gpu:ADAPTER-NAME: a cell must name its engine";
            require(is_one, "engines", engine, expected)?;
        }
        let threads = self.latency_threads;
        require((1..=1024).contains(&threads), "latency_threads", threads, "1 to 1024")?;
        self.worlds.iter().try_for_each(PlanWorlds::check)
    }
}

impl PlanWorlds {
    fn check(&self) -> Result<(), ExperimentError> {
        use WorldKind::{Barn, DynaBarn, Localization, Map, Paper, Scenes};
        let kind = self.kind;
        let is = |kinds: &[WorldKind]| kinds.contains(&kind);
        let path = self.path.as_ref().map_or("missing", |_| "given");
        let needs = is(&[Map, Barn, DynaBarn]);
        require(!needs || self.path.is_some(), "worlds.path", path, "given for this kind")?;
        require(
            !is(&[Scenes, Localization, Paper]) || self.path.is_none(),
            "worlds.path",
            path,
            "left out: worlds of this kind are built in",
        )?;
        let only = self.only.len();
        let expected = "left out: only barn and dynabarn have numbered worlds";
        require(only == 0 || is(&[Barn, DynaBarn]), "worlds.only", only, expected)?;
        let routes = self.routes.len();
        let expected = "at least one route for \"map\", none for other kinds";
        require((routes > 0) == is(&[Map]), "worlds.routes", routes, expected)?;
        let ends = |route: &PlanRoute| {
            let numbers = || route.start.iter().chain(&route.goal);
            (2..=3).contains(&route.goal.len()) && numbers().all(|number| number.abs() <= 1e9)
        };
        let expected = "start = [x, y, yaw], goal = [x, y] or [x, y, yaw], each -1e9 to 1e9";
        require(self.routes.iter().all(ends), "worlds.routes", "malformed", expected)?;
        for (name, value, fits, expected) in [
            (
                "worlds.max_speed_m_s",
                self.max_speed_m_s,
                self.max_speed_m_s > 0.0 && self.max_speed_m_s <= 10.0,
                "above zero and at most 10",
            ),
            (
                "worlds.resolution_m",
                self.resolution_m,
                self.resolution_m > 0.0 && self.resolution_m <= 1e9,
                "above zero and at most 1e9",
            ),
            (
                "worlds.time_limit_s",
                self.time_limit_s,
                self.time_limit_s > 0.0 && self.time_limit_s <= 1e9,
                "above zero and at most 1e9",
            ),
            (
                "worlds.longest_m",
                self.longest_m,
                (4.0..=1e4).contains(&self.longest_m),
                "4 to 10000",
            ),
            (
                "worlds.unmapped_share",
                self.unmapped_share,
                (0.0..=1.0).contains(&self.unmapped_share),
                "0 to 1",
            ),
        ] {
            require(fits, name, value, expected)?;
        }
        let people = self.people;
        require(people <= 100, "worlds.people", people, "0 to 100")
    }
}

/// Checks that a list is not empty and has no value twice.
fn listed<T: Display>(name: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    require(!values.is_empty(), name, "empty", "at least one")?;
    distinct(name, values)
}

fn distinct<T: Display>(name: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    let mut seen = BTreeSet::new();
    for value in values {
        let is_new = seen.insert(value.to_string());
        require(is_new, name, value, "named once")?;
    }
    Ok(())
}

fn require(
    fits: bool,
    key: &'static str,
    value: impl Display,
    expected: &'static str,
) -> Result<(), ExperimentError> {
    if fits {
        return Ok(());
    }
    Err(ExperimentError::BadKey {
        key,
        value: value.to_string().escape_debug().to_string(),
        expected,
    })
}
