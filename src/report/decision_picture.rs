//! Picture of one decision: the sampled trajectories by their score, and the chosen one.

use maud::html;

use super::map::{
    STANDALONE_RASTER, STANDALONE_TOLERANCE, StandaloneMap, Viewport, goal_mark, ground,
    ground_legend, path, start_mark,
};
use super::number::{coordinate, fixed};
use super::svg::LegendEntry;
use crate::geometry::Point;
use crate::local::{FanArc, TrajectoryFan};
use crate::map::OccupancyGrid;
use crate::robot::Footprint;

/// Points of a trajectory.
const PARTS: u32 = 16;

/// Classes of the score, each with its colour.
const CLASSES: [&str; 4] = ["arc speed-0", "arc speed-1", "arc speed-2", "arc speed-3"];

const STYLE: &str = ".arc { stroke-width: 1.1; fill: none; } .rejected { stroke: var(--bad); stroke-width: .9; opacity: .3; } \
    .chosen { stroke: var(--command); stroke-width: 4; } .body { fill: var(--robot); opacity: .6; } \
    .person { fill: var(--moving); opacity: .55; } ";

/// One decision on its map.
#[derive(Clone, Debug)]
pub struct DecisionView<'a> {
    /// Headline. It may hold any characters, and is cut if it is too long.
    pub title: &'a str,
    /// The decision, in a line.
    pub caption: &'a str,
    /// The map.
    pub map: &'a OccupancyGrid,
    /// The robot's shape.
    pub footprint: &'a Footprint,
    /// The target.
    pub target: Point,
    /// The samples that are drawn, with the winner.
    pub fan: &'a TrajectoryFan,
}

/// Returns an SVG file with the map, the robot, its sampled trajectories coloured by score, the rejected and the chosen one,
/// moving obstacles, a scale bar and a legend.
#[must_use]
pub fn decision_svg(decision: &DecisionView) -> String {
    let DecisionView { title, caption, map, footprint, target, fan } = *decision;
    let ends = fan.arcs.iter().flat_map(|arc| fan.points(arc, PARTS));
    let robot = fan.from.position();
    let view = &Viewport::around(ends.chain([robot, target]), map.frame());
    let drawn = |class: &str, points: &[Point]| path(view, class, points, STANDALONE_TOLERANCE);
    let disc = |class: &str, center: &Point, radius_m: f64| {
        let [x, y] = view.at(center);
        let radius = coordinate(radius_m * view.scale());
        html! { circle class=(class) cx=(coordinate(x)) cy=(coordinate(y)) r=(radius) {} }
    };
    let layers = html! {
        (ground(map, view, STANDALONE_RASTER))
        @for obstacle in &fan.obstacles { (disc("person", &obstacle.center(), obstacle.radius)) }
        @for arc in fan.arcs.iter().filter(|arc| arc.score.is_none()) {
            (drawn("rejected", &fan.points(arc, PARTS)))
        }
        @for (class, arc) in by_score(fan) { (drawn(class, &fan.points(arc, PARTS))) }
        @for (center, radius_m) in footprint.at(&fan.from) { (disc("body", &center, radius_m)) }
        @if fan.winner.is_some() { (drawn("chosen", &fan.winner_points(PARTS))) }
        (start_mark(view.at(&robot), fan.from.yaw))
        (goal_mark(view.at(&target)))
    };
    let legend = legend(fan).into_iter().chain(ground_legend(map, view)).collect();
    StandaloneMap { title, caption, style: STYLE, layers, legend }.svg(view)
}

/// The admissible arcs with the classes of their scores, the best last.
fn by_score(fan: &TrajectoryFan) -> Vec<(&'static str, &FanArc)> {
    let mut scored: Vec<(f64, &FanArc)> = fan
        .relative_scores()
        .zip(&fan.arcs)
        .filter_map(|(share, arc)| Some((share?, arc)))
        .collect();
    scored.sort_by(|one, other| one.0.total_cmp(&other.0));
    let class = |share: f64| CLASSES[((share * 4.0) as usize).min(CLASSES.len() - 1)];
    scored.into_iter().map(|(share, arc)| (class(share), arc)).collect()
}

fn legend(fan: &TrajectoryFan) -> Vec<LegendEntry> {
    let horizon = fixed(fan.horizon_s, 1);
    let mut legend = vec![
        LegendEntry::circle("body", 6.0, "robot"),
        LegendEntry::new(goal_mark([14.0, 7.0]), "target"),
        LegendEntry::line(CLASSES[0], format!("lowest scores, {horizon} s")),
        LegendEntry::line(CLASSES[3], "highest scores"),
        LegendEntry::line("rejected", "rejected"),
        LegendEntry::line("chosen", "chosen"),
    ];
    if !fan.obstacles.is_empty() {
        legend.push(LegendEntry::circle("person", 6.0, "moving obstacle"));
    }
    legend
}
