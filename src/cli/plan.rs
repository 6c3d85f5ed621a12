//! `inbye plan`.

use anyhow::anyhow;
use inbye::geometry::Point;
use inbye::global::{self, Ground, Path, Plan, PlanError, Searcher, min_clearance_m};
use inbye::map::{FreeSpace, ObstacleGrid, OccupancyGrid, UNKNOWN, UnknownPolicy};
use inbye::sim::Config;
use serde_json::{Value, json};

use super::arguments::{MapArguments, PlanArguments};
use super::clock::wall_clock;
use super::{map_file, output};

/// Finds a path. False when there is none.
pub fn run(arguments: &PlanArguments, json: bool) -> anyhow::Result<bool> {
    let (map, config) = map_file::read(&arguments.map)?;
    let obstacles = map.obstacles(config.unknown);
    match search(arguments, &config, &obstacles) {
        Ok(plan) => {
            let clearance_m = min_clearance_m(&plan.smoothed, &obstacles);
            if json {
                output::json(&object(&plan, clearance_m))?;
            } else {
                print(&plan, clearance_m);
            }
            Ok(true)
        }
        Err(error @ PlanError::NoValidPath { .. }) => {
            refuse(&error, json.then(|| refusal(&error)))?;
            Ok(false)
        }
        Err(error) => Err(unusable(&error, &arguments.map, &map, &config)),
    }
}

/// That there is no path, and why, as scripts read it.
pub fn refusal(error: &PlanError) -> Value {
    let expanded = match error {
        PlanError::NoValidPath { expanded, .. } => Some(expanded),
        _ => None,
    };
    json!({
        "found": false,
        "path": [],
        "length_m": null,
        "expanded": expanded,
        "error": error.code(),
        "reason": error.to_string(),
    })
}

/// Says that there is no path: the answer, and why.
pub fn refuse(error: &PlanError, object: Option<Value>) -> anyhow::Result<()> {
    if let Some(object) = object {
        return output::json(&object);
    }
    output::line(error.to_string());
    Ok(())
}

/// An end that no path can have, with the map that it is on.
pub fn unusable(
    error: &PlanError,
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
    anyhow!("{}: {error}{hint}", arguments.map.display())
}

fn search(
    arguments: &PlanArguments,
    config: &Config,
    obstacles: &ObstacleGrid,
) -> Result<Plan, PlanError> {
    let (start, goal) = (arguments.start.position, arguments.goal.position);
    let mut clock = wall_clock();
    if let Some(radius_m) = arguments.radius {
        let space = FreeSpace::new(obstacles, radius_m);
        let costs = config.global.costs(obstacles);
        let ground = Ground {
            search: &space,
            proof: &space,
            costs: costs.as_ref(),
        };
        return global::plan(
            &mut Searcher::default(),
            &ground,
            start,
            goal,
            &config.global,
            &mut clock,
        );
    }
    let resolution_m = obstacles.frame().resolution_m;
    config
        .route_planner(resolution_m)
        .plan(obstacles, start, goal, &mut clock)
}

fn object(plan: &Plan, clearance_m: f64) -> Value {
    let stage = |path: &Path| {
        json!({
            "length_m": path.length_m(),
            "points": path.points().len(),
            "turns": path.turns(),
        })
    };
    let points: Vec<[f64; 2]> = plan
        .smoothed
        .points()
        .iter()
        .map(|point: &Point| [point.x, point.y])
        .collect();
    let times = &plan.time_s;
    json!({
        "found": true,
        "path": points,
        "length_m": plan.smoothed.length_m(),
        "turns": plan.smoothed.turns(),
        "raw": stage(&plan.raw),
        "pruned": stage(&plan.pruned),
        "min_clearance_m": if clearance_m.is_finite() { json!(clearance_m) } else { Value::Null },
        "expanded": plan.expanded,
        "time_ms": {
            "search": times.search * 1e3,
            "prune": times.prune * 1e3,
            "smooth": times.smooth * 1e3,
            "total": (times.search + times.prune + times.smooth) * 1e3,
        },
    })
}

fn print(plan: &Plan, clearance_m: f64) {
    for (name, path) in [
        ("searched", &plan.raw),
        ("pruned", &plan.pruned),
        ("smoothed", &plan.smoothed),
    ] {
        output::line(format!(
            "{name:9} {:8.2} m  {:5} points  {:3} turns",
            path.length_m(),
            path.points().len(),
            path.turns(),
        ));
    }
    let times = &plan.time_s;
    output::line(format!("clearance {clearance_m:8.3} m at the narrowest"));
    output::line(format!(
        "search {:.2} ms ({} cells expanded), prune {:.2} ms, smooth {:.2} ms",
        times.search * 1e3,
        plan.expanded,
        times.prune * 1e3,
        times.smooth * 1e3,
    ));
}
