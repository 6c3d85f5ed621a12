//! `inbye plan`.

use anyhow::anyhow;
use inbye::global::PlanError;
use inbye::map::{OccupancyGrid, UNKNOWN, UnknownPolicy};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::arguments::{MapArguments, PlanArguments};
use super::plan_drawing::Drawing;
use super::tour::Refused;
use super::{map_file, output, plan_words, tour, unknown_words};

/// Finds a path. False when there is none.
pub fn run(arguments: &PlanArguments, json: bool) -> anyhow::Result<bool> {
    let (map, config) = map_file::read(&arguments.map)?;
    let drawing = Drawing::create(arguments)?;
    let obstacles = map.obstacles(config.unknown);
    let tour = match tour::plan(arguments, &config, &obstacles) {
        Ok(tour) => tour,
        Err(refused) => {
            drawing.of_refused(&refused, &map)?;
            return no_path(&refused, arguments, &map, &config, json);
        }
    };
    drawing.of_tour(&tour, &map)?;
    if json {
        let mut object = plan_words::object(&tour, &config);
        object["unknown"] = unknown_words::object(&map, config.unknown);
        output::json(&object)?;
    } else {
        if let Some(fact) = unknown_words::fact(&map, config.unknown) {
            output::line(format!("unknown   {fact}"));
        }
        plan_words::lines(&tour, &config)
            .iter()
            .for_each(output::line);
    }
    Ok(true)
}

/// No way is an answer; an end that cannot be is unusable input.
fn no_path(
    refused: &Refused,
    arguments: &PlanArguments,
    map: &OccupancyGrid,
    config: &Config,
    json: bool,
) -> anyhow::Result<bool> {
    let reason = refused.reason();
    if !matches!(refused.error, PlanError::NoValidPath { .. }) {
        let error = &refused.error;
        return Err(unusable(error, &reason, &arguments.map, map, config));
    }
    let mut object = refusal(&refused.error);
    object["reason"] = json!(reason);
    object["stop"] = json!(refused.stop);
    refuse(&reason, json.then_some(object))?;
    Ok(false)
}

/// That there is no path, and why, as scripts read it.
pub fn refusal(error: &PlanError) -> Value {
    let (expanded, nearest) = match error {
        PlanError::NoValidPath {
            expanded, nearest, ..
        } => (Some(expanded), nearest.as_ref()),
        _ => (None, None),
    };
    json!({
        "found": false,
        "path": [],
        "length_m": null,
        "expanded": expanded,
        "error": error.code(),
        "reason": error.to_string(),
        "nearest_reachable": nearest.map(plan_words::pair),
    })
}

/// Says that there is no path: the answer, and why.
pub fn refuse(reason: &str, object: Option<Value>) -> anyhow::Result<()> {
    if let Some(object) = object {
        return output::json(&object);
    }
    output::line(reason);
    Ok(())
}

/// An end that no path can have, in words, with the map that it is on.
pub fn unusable(
    error: &PlanError,
    reason: &str,
    arguments: &MapArguments,
    map: &OccupancyGrid,
    config: &Config,
) -> anyhow::Error {
    let place = match error {
        PlanError::StartOccupied { place, .. } | PlanError::GoalOccupied { place, .. } => {
            map.frame().cell_of(place)
        }
        _ => None,
    };
    let unknown = config.unknown == UnknownPolicy::Blocked
        && place.is_some_and(|cell| map.cells()[map.frame().index(cell)] == UNKNOWN);
    let hint = if unknown {
        "; the map does not know this ground: --unknown free counts such ground as free"
    } else {
        ""
    };
    anyhow!("{}: {reason}{hint}", arguments.map.display())
}
