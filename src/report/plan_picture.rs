//! A global plan as one picture, to be looked at without a page.

use maud::{Markup, html};

use super::map_furniture::{goal_mark, labels, nearest_mark, start_mark, stop_mark};
use super::map_layers::{Stages, ground, ground_keys, stage_keys, stages};
use super::number::{coordinate, fixed};
use super::sheet::{RASTER_SIDE, Sheet, TOLERANCE};
use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;

/// No robot is drawn over the smoothed path, so that need not be wide and pale.
const OWN_STYLE: &str =
    ".smoothed { stroke: var(--path); stroke-width: 6; opacity: .6; } .pruned { stroke-width: 1; }";

/// A global plan as its picture shows it. Points that are not finite are left out.
#[derive(Clone, Debug)]
pub struct PlanView<'a> {
    /// Headline. It may hold any characters; it is escaped, and cut where it is too long.
    pub title: &'a str,
    /// The ground.
    pub map: &'a OccupancyGrid,
    /// Where the path begins.
    pub start: Pose,
    /// Where it is to pass, in this order.
    pub stops: &'a [Point],
    /// Where it ends.
    pub goal: Point,
    /// The path as the search returned it. Empty: none was found.
    pub searched: &'a [Point],
    /// The same without redundant nodes.
    pub pruned: &'a [Point],
    /// The same, smoothed.
    pub smoothed: &'a [Point],
    /// What came of it.
    pub outcome: PlanOutcome<'a>,
}

/// What came of planning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanOutcome<'a> {
    /// A path.
    Found(PlanFigures),
    /// No path.
    NotFound {
        /// What stands in place of the figures: which place cannot be reached, and why.
        why: &'a str,
        /// The nearest point to it that can be.
        nearest: Option<Point>,
    },
}

/// What is said of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanFigures {
    /// Length of the smoothed path, metres.
    pub length_m: f64,
    /// Places where the path changes its direction.
    pub turns: usize,
    /// Those of them where it does so at once, not along a curve.
    pub sharp_turns: usize,
    /// Smallest distance between the smoothed path and an obstacle, metres; infinite without obstacles.
    pub min_clearance_m: f64,
}

/// An SVG file: the map with the plan on it, a scale bar and a legend. It holds everything it needs, and no style in it
/// asks more of a program than CSS classes.
#[must_use]
pub fn plan_svg(plan: &PlanView) -> String {
    let view = viewport(plan);
    Sheet {
        title: plan.title,
        caption: &caption(plan),
        style: OWN_STYLE,
        map: map(plan, &view),
        keys: keys(plan, &view),
    }
    .svg(&view)
}

fn map(plan: &PlanView, view: &Viewport) -> Markup {
    html! {
        rect class="outside" width=(MAP_WIDTH) height=(coordinate(view.height())) {}
        (ground(plan.map, view, RASTER_SIDE))
        (stages(view, &plan.stages(), TOLERANCE))
        @for (index, stop) in plan.stops.iter().enumerate().filter(|(_, stop)| view.shows(stop)) {
            (stop_mark(view.at(stop), index + 1))
        }
        @if let Some(nearest) = plan.nearest().filter(|nearest| view.shows(nearest)) {
            (nearest_mark(view.at(&nearest)))
        }
        (start_mark(view.at(&plan.start.position()), plan.start.yaw))
        (goal_mark(view.at(&plan.goal)))
        (labels(view, &plan.start.position(), &plan.goal))
    }
}

fn viewport(plan: &PlanView) -> Viewport {
    let ends = [plan.start.position(), plan.goal];
    let points = plan
        .stages()
        .points()
        .chain(ends)
        .chain(plan.stops.iter().copied())
        .chain(plan.nearest());
    Viewport::around(points, plan.map.frame())
}

fn keys(plan: &PlanView, view: &Viewport) -> Vec<(Markup, String)> {
    let mut keys = vec![
        (start_mark([12.0, 7.0], 0.0), "start".to_owned()),
        (goal_mark([14.0, 7.0]), "goal".to_owned()),
    ];
    if !plan.stops.is_empty() {
        keys.push((stop_mark([14.0, 7.0], 1), "stop on the way".to_owned()));
    }
    if plan.smoothed.len() > 1 {
        keys.extend(stage_keys());
    }
    if plan.nearest().is_some() {
        let mark = nearest_mark([14.0, 7.0]);
        keys.push((mark, "nearest that can be reached".to_owned()));
    }
    keys.extend(ground_keys(plan.map, view));
    keys
}

fn caption(plan: &PlanView) -> String {
    let figures = match plan.outcome {
        PlanOutcome::Found(figures) => figures,
        PlanOutcome::NotFound { why, .. } => return why.to_owned(),
    };
    let count = |count: usize, what: &str| match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    };
    let sharp = match figures.sharp_turns {
        0 => "none sharp".to_owned(),
        sharp => format!("{sharp} sharp"),
    };
    let turns = match figures.turns {
        0 => "no turn".to_owned(),
        turns => format!("{} ({sharp})", count(turns, "turn")),
    };
    let stops = match plan.stops.len() {
        0 => String::new(),
        stops => format!(", {} on the way", count(stops, "stop")),
    };
    let clear = if figures.min_clearance_m.is_finite() {
        format!(
            "{} m from obstacles at the narrowest",
            fixed(figures.min_clearance_m, 2)
        )
    } else {
        "no obstacle on the map".to_owned()
    };
    format!(
        "{} m long{stops}, {turns}, {clear}",
        fixed(figures.length_m, 2)
    )
}

impl<'a> PlanView<'a> {
    const fn nearest(&self) -> Option<Point> {
        match self.outcome {
            PlanOutcome::NotFound { nearest, .. } => nearest,
            PlanOutcome::Found(_) => None,
        }
    }

    const fn stages(&self) -> Stages<'a> {
        Stages {
            searched: self.searched,
            pruned: self.pruned,
            smoothed: self.smoothed,
        }
    }
}
