//! The output of `inbye plan` as text and JSON.

use inbye::geometry::Point;
use inbye::global::{Path, StageTimes};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::curvature_check::CurvatureCheck;
use super::multi_leg_plan::{Leg, MultiLegPlan};

/// The JSON object.
pub fn object(plan: &MultiLegPlan, config: &Config) -> Value {
    let stage = |path: &Path| {
        json!({
            "length_m": path.length_m(),
            "points": path.points().len(),
            "turns": path.turns(),
        })
    };
    let smoothed = plan.stage(|plan| &plan.smoothed);
    let points: Vec<[f64; 2]> = smoothed.points().iter().map(pair).collect();
    json!({
        "found": true,
        "path": points,
        "length_m": smoothed.length_m(),
        "turns": smoothed.turns(),
        "raw": stage(&plan.stage(|plan| &plan.raw)),
        "pruned": stage(&plan.stage(|plan| &plan.pruned)),
        "min_clearance_m": finite(plan.clearance_m()),
        "expanded": plan.expanded(),
        "exact": config.global.is_optimal(),
        "time_ms": times(&plan.time_s()),
        "curvature": CurvatureCheck::new(&plan.curvature(), &config.robot).object(),
        "legs": plan.legs.iter().map(leg).collect::<Vec<Value>>(),
    })
}

fn leg(leg: &Leg) -> Value {
    json!({
        "from": pair(&leg.from),
        "to": pair(&leg.to),
        "length_m": leg.plan.smoothed.length_m(),
        "turns": leg.plan.smoothed.turns(),
        "min_clearance_m": finite(leg.clearance_m),
        "expanded": leg.plan.expanded,
        "time_ms": times(&leg.plan.time_s),
    })
}

/// A point as a JSON array.
pub fn pair(point: &Point) -> [f64; 2] {
    [point.x, point.y]
}

/// A number, or null for an infinite distance.
fn finite(number: f64) -> Value {
    if number.is_finite() { json!(number) } else { Value::Null }
}

fn times(of: &StageTimes) -> Value {
    json!({
        "search": of.search * 1e3,
        "prune": of.prune * 1e3,
        "smooth": of.smooth * 1e3,
        "total": total_ms(of),
    })
}

fn total_ms(of: &StageTimes) -> f64 {
    (of.search + of.prune + of.smooth) * 1e3
}

/// The lines of text.
pub fn lines(plan: &MultiLegPlan, config: &Config) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, path) in [
        ("searched", plan.stage(|plan| &plan.raw)),
        ("pruned", plan.stage(|plan| &plan.pruned)),
        ("smoothed", plan.stage(|plan| &plan.smoothed)),
    ] {
        lines.push(format!(
            "{name:9} {:8.2} m  {:5} points  {:3} turns",
            path.length_m(),
            path.points().len(),
            path.turns(),
        ));
    }
    let times = plan.time_s();
    lines.push(format!("clearance {:8.3} m at the narrowest", plan.clearance_m()));
    lines.push(CurvatureCheck::new(&plan.curvature(), &config.robot).line());
    let optimality =
        if config.global.is_optimal() { "a shortest path" } else { "near a shortest path" };
    lines.push(format!(
        "search {:.2} ms ({} cells expanded, {optimality}), prune {:.2} ms, smooth {:.2} ms",
        times.search * 1e3,
        plan.expanded(),
        times.prune * 1e3,
        times.smooth * 1e3,
    ));
    if plan.legs.len() > 1 {
        lines.push(String::new());
        lines.extend(table(&plan.legs));
    }
    lines
}

/// A header and a line for each leg.
fn table(legs: &[Leg]) -> impl Iterator<Item = String> {
    let place = |at: &Point| format!("({:.2}, {:.2})", at.x, at.y);
    let head = format!(
        "{:>3}  {:20} {:20} {:>10} {:>5} {:>11} {:>9} {:>9}",
        "leg", "from", "to", "length, m", "turns", "clear, m", "expanded", "time, ms"
    );
    let lines = legs.iter().enumerate().map(move |(index, leg)| {
        format!(
            "{:3}  {:20} {:20} {:10.2} {:5} {:11.3} {:9} {:9.2}",
            index + 1,
            place(&leg.from),
            place(&leg.to),
            leg.plan.smoothed.length_m(),
            leg.plan.smoothed.turns(),
            leg.clearance_m,
            leg.plan.expanded,
            total_ms(&leg.plan.time_s),
        )
    });
    core::iter::once(head).chain(lines)
}
