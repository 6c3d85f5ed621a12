//! A global plan as one picture, to be looked at without a page.

use maud::{Markup, PreEscaped, html};

use super::figure::{drawn_legend, legend_height};
use super::map_furniture::{goal_mark, labels, nearest_mark, start_mark, stop_mark, strip};
use super::map_layers::{Stages, ground, ground_keys, stage_keys, stages};
use super::map_picture::STRIP;
use super::number::{coordinate, fixed};
use super::plain_style::plain;
use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;

const STYLE: &str = concat!(include_str!("drawing.css"), include_str!("map.css"));

/// What only a picture of its own needs. No robot is drawn over the smoothed path, so that need not be wide and pale.
const OWN_STYLE: &str = "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; font-size: 13px; } \
    .paper { fill: var(--panel); } .headline { font-size: 16px; font-weight: 700; } .caption { fill: var(--muted); } \
    .frame { fill: none; stroke: var(--rule); stroke-width: 1; } \
    .smoothed { stroke: var(--path); stroke-width: 6; opacity: .6; } .pruned { stroke-width: 1; }";

/// Pixels of the ground's longer side, at most: twice those of a picture of 1440, so that nothing is blurred, and no
/// cell of a large mine is lost between two pixels.
const RASTER_SIDE: i32 = 2880;

/// How far a drawn line may lie from the data, drawing units: less than on a page, whose lines are not drawn twice as
/// large.
const TOLERANCE: f64 = 0.1;

/// Height of the headline and caption above the map.
const HEAD: f64 = 58.0;
/// Space beside the texts, and around the legend.
const MARGIN: f64 = 14.0;
/// Columns of the legend.
const COLUMNS: usize = 3;
/// Letters of the headline that fit beside one another, of the widest usual ones.
const HEADLINE_LETTERS: usize = 64;

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
    let map_height = view.height();
    let keys = keys(plan, &view);
    let legend_top = HEAD + map_height + STRIP + MARGIN;
    let height = legend_top + legend_height(keys.len(), COLUMNS) + MARGIN;
    let (width, height) = (coordinate(MAP_WIDTH), coordinate(height.ceil()));
    let caption = caption(plan);
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(format!("{}. {caption}", plan.title))
            width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
            style { (PreEscaped(plain(STYLE))) (PreEscaped(plain(OWN_STYLE))) }
            rect class="paper" width=(width) height=(height) {}
            text class="headline" x=(coordinate(MARGIN)) y="25" { (cut(plan.title)) }
            text class="caption" x=(coordinate(MARGIN)) y="45" { (caption) }
            // A picture within the picture: what lies off the map's part stays inside its frame.
            svg y=(coordinate(HEAD)) width=(width) height=(coordinate(map_height + STRIP))
                viewBox=(format!("0 0 {width} {}", coordinate(map_height + STRIP))) {
                (map(plan, &view))
                (strip(&view, map_height))
            }
            rect class="frame" x=".5" y=(coordinate(HEAD)) width=(coordinate(MAP_WIDTH - 1.0))
                height=(coordinate(map_height)) {}
            (drawn_legend(&keys, [MARGIN, legend_top], MAP_WIDTH - MARGIN, COLUMNS))
        }
    }
    .into_string()
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

/// As much of a headline as fits.
fn cut(title: &str) -> String {
    if title.chars().count() <= HEADLINE_LETTERS {
        return title.to_owned();
    }
    let kept: String = title.chars().take(HEADLINE_LETTERS - 1).collect();
    kept + "…"
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
