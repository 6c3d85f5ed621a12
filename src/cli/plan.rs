//! `inbye plan`.

use anyhow::anyhow;
use inbye::global::PlanError;
use inbye::map::{OccupancyGrid, UNKNOWN, UnknownPolicy};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::arguments::{MapArguments, PlanArguments};
use super::multi_leg_plan::LegFailure;
use super::plan_drawing::Drawing;
use super::{map_file, multi_leg_plan, output, plan_text};

/// Finds a path. Returns false if there is none.
pub fn run(arguments: &PlanArguments, json: bool) -> anyhow::Result<bool> {
    let (map, config) = map_file::read(&arguments.map)?;
    let drawing = Drawing::create(arguments)?;
    let obstacles = map.obstacles(config.unknown);
    let plan = match multi_leg_plan::plan(arguments, &config, &obstacles) {
        Ok(plan) => plan,
        Err(failure) => {
            drawing.draw_failure(&failure, &map)?;
            return no_path(&failure, arguments, &map, &config, json);
        }
    };
    drawing.draw_plan(&plan, &map)?;
    if json {
        let mut object = plan_text::object(&plan, &config);
        object["unknown"] = map_file::unknown_cells_json(&map, config.unknown);
        output::json(&object)?;
    } else {
        if let Some(text) = map_file::unknown_cells_text(&map, config.unknown) {
            output::line(format!("unknown   {text}"));
        }
        plan_text::lines(&plan, &config).iter().for_each(output::line);
    }
    Ok(true)
}

/// Prints that there is no path, which is an answer; an invalid start or goal is unusable input.
fn no_path(
    failure: &LegFailure,
    arguments: &PlanArguments,
    map: &OccupancyGrid,
    config: &Config,
    json: bool,
) -> anyhow::Result<bool> {
    let reason = failure.reason();
    if !matches!(failure.error, PlanError::NoValidPath { .. }) {
        let error = &failure.error;
        return Err(unusable(error, &reason, &arguments.map, map, config));
    }
    let mut object = no_path_json(&failure.error);
    object["reason"] = json!(reason);
    object["stop"] = json!(failure.stop);
    print_no_path(&reason, json.then_some(object))?;
    Ok(false)
}

/// The JSON object for a missing path.
pub fn no_path_json(error: &PlanError) -> Value {
    let (expanded, nearest) = match error {
        PlanError::NoValidPath { expanded, nearest, .. } => (Some(expanded), nearest.as_ref()),
        _ => (None, None),
    };
    json!({
        "found": false,
        "path": [],
        "length_m": null,
        "expanded": expanded,
        "error": error.code(),
        "reason": error.to_string(),
        "nearest_reachable": nearest.map(plan_text::pair),
    })
}

/// Prints why there is no path, as an object or as text.
pub fn print_no_path(reason: &str, object: Option<Value>) -> anyhow::Result<()> {
    if let Some(object) = object {
        return output::json(&object);
    }
    output::line(reason);
    Ok(())
}

/// The error for an invalid start or goal, with the name of the map.
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
        "; this cell is unknown in the map: --unknown free counts unknown cells as free"
    } else {
        ""
    };
    anyhow!("{}: {reason}{hint}", arguments.map.display())
}
