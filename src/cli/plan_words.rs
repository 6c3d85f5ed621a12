//! What `inbye plan` tells people and scripts.

use inbye::geometry::Point;
use inbye::global::{Path, StageTimes};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::followed::Followed;
use super::tour::{Leg, Tour};

/// The plan as scripts read it.
pub fn object(tour: &Tour, config: &Config) -> Value {
    let stage = |path: &Path| {
        json!({
            "length_m": path.length_m(),
            "points": path.points().len(),
            "turns": path.turns(),
        })
    };
    let smoothed = tour.stage(|plan| &plan.smoothed);
    let points: Vec<[f64; 2]> = smoothed.points().iter().map(pair).collect();
    json!({
        "found": true,
        "path": points,
        "length_m": smoothed.length_m(),
        "turns": smoothed.turns(),
        "raw": stage(&tour.stage(|plan| &plan.raw)),
        "pruned": stage(&tour.stage(|plan| &plan.pruned)),
        "min_clearance_m": finite(tour.clearance_m()),
        "expanded": tour.expanded(),
        "exact": config.global.is_optimal(),
        "time_ms": times(&tour.time_s()),
        "curvature": Followed::new(&tour.curvature(), &config.robot).object(),
        "legs": tour.legs.iter().map(leg).collect::<Vec<Value>>(),
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

/// A point as scripts read it.
pub fn pair(point: &Point) -> [f64; 2] {
    [point.x, point.y]
}

/// A number, or null where it is none: a distance to nothing.
fn finite(number: f64) -> Value {
    if number.is_finite() {
        json!(number)
    } else {
        Value::Null
    }
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

/// The plan as people read it.
pub fn lines(tour: &Tour, config: &Config) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, path) in [
        ("searched", tour.stage(|plan| &plan.raw)),
        ("pruned", tour.stage(|plan| &plan.pruned)),
        ("smoothed", tour.stage(|plan| &plan.smoothed)),
    ] {
        lines.push(format!(
            "{name:9} {:8.2} m  {:5} points  {:3} turns",
            path.length_m(),
            path.points().len(),
            path.turns(),
        ));
    }
    let times = tour.time_s();
    lines.push(format!(
        "clearance {:8.3} m at the narrowest",
        tour.clearance_m()
    ));
    lines.push(Followed::new(&tour.curvature(), &config.robot).line());
    let promise = if config.global.is_optimal() {
        "a shortest path"
    } else {
        "near a shortest path"
    };
    lines.push(format!(
        "search {:.2} ms ({} cells expanded, {promise}), prune {:.2} ms, smooth {:.2} ms",
        times.search * 1e3,
        tour.expanded(),
        times.prune * 1e3,
        times.smooth * 1e3,
    ));
    if tour.legs.len() > 1 {
        lines.push(String::new());
        lines.extend(table(&tour.legs));
    }
    lines
}

/// A line for each leg, below a line of heads.
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
