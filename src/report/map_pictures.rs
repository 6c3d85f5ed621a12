//! Pictures of maps: of a mission on a page, and of a plan and a drive as SVG files.

use maud::{Markup, html};

use super::figure::{Table, figure};
use super::map::{
    Areas, Encounters, MapPanel, PAGE_RASTER, PLAYER_RASTER, PathStages, STANDALONE_RASTER,
    STANDALONE_TOLERANCE, StandaloneMap, Viewport, contacts, end_legend, goal_mark, ground,
    ground_legend, labels, nearest_mark, path, stage_legend, stages, start_mark, stop_mark,
    top_speed, track, track_legend, trail_legend, trails,
};
use super::mission_charts::closest;
use super::mission_page::MissionView;
use super::number::{coordinate, fixed};
use super::player::PlaybackRecorder;
use super::svg::{LegendEntry, TOLERANCE};
use crate::geometry::{Point, Pose};
use crate::map::{OccupancyGrid, Zones};
use crate::runtime::Trace;

/// A plan shows no robot on its smoothed path, so the path is narrower than in other maps.
const PLAN_STYLE: &str =
    ".smoothed { stroke: var(--path); stroke-width: 6; opacity: .6; } .pruned { stroke-width: 1; }";

const DRIVE_STYLE: &str = ".planned { stroke: var(--path); stroke-width: 1.2; opacity: .35; } .track { stroke-width: 2.5; }";

/// A global plan. Points that are not finite are left out.
#[derive(Clone, Debug)]
pub struct PlanView<'a> {
    /// Headline. It may hold any characters, and is cut if it is too long.
    pub title: &'a str,
    /// The map.
    pub map: &'a OccupancyGrid,
    /// Its zones, if there are any.
    pub zones: Option<&'a Zones>,
    /// The start pose.
    pub start: Pose,
    /// The stops, in their order.
    pub stops: &'a [Point],
    /// The goal.
    pub goal: Point,
    /// The path; empty stages: no path.
    pub stages: PathStages<'a>,
    /// The outcome.
    pub outcome: PlanOutcome<'a>,
}

/// The outcome of planning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlanOutcome<'a> {
    /// A path.
    Found(PlanMetrics),
    /// No path.
    NotFound {
        /// Which point cannot be reached, and the reason; the caption of the picture.
        reason: &'a str,
        /// The nearest point that can be reached.
        nearest: Option<Point>,
    },
}

/// The metrics of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanMetrics {
    /// Length of the smoothed path, m.
    pub length_m: f64,
    /// Number of direction changes before smoothing.
    pub turns: usize,
    /// Number of direction changes of the smoothed path at a corner, not along a curve.
    pub sharp_turns: usize,
    /// Smallest distance between the smoothed path and an obstacle, m; infinite without obstacles.
    pub min_clearance_m: f64,
}

/// A drive. Points that are not finite are left out.
#[derive(Clone, Debug)]
pub struct DriveView<'a> {
    /// Headline. It may hold any characters, and is cut if it is too long.
    pub title: &'a str,
    /// The result, in a line.
    pub caption: &'a str,
    /// The map.
    pub map: &'a OccupancyGrid,
    /// Its zones, if there are any.
    pub zones: Option<&'a Zones>,
    /// The start pose.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
    /// The run.
    pub trace: &'a Trace,
}

/// Returns an SVG file with the map, the plan in its stages, a scale bar and a legend. It needs no page, and of CSS only
/// classes.
#[must_use]
pub fn plan_svg(plan: &PlanView) -> String {
    let (nearest, caption) = match plan.outcome {
        PlanOutcome::NotFound { nearest, reason } => (nearest, reason.to_owned()),
        PlanOutcome::Found(metrics) => (None, metrics_text(&metrics, plan.stops.len())),
    };
    let points = plan
        .stages
        .points()
        .chain([plan.start.position(), plan.goal])
        .chain(plan.stops.iter().copied())
        .chain(nearest);
    let view = Viewport::around(points, plan.map.frame());
    StandaloneMap {
        title: plan.title,
        caption: &caption,
        style: PLAN_STYLE,
        layers: plan_layers(plan, nearest, &view),
        legend: plan_legend(plan, nearest.is_some(), &view),
    }
    .svg(&view)
}

fn plan_layers(plan: &PlanView, nearest: Option<Point>, view: &Viewport) -> Markup {
    html! {
        (ground(plan.map, view, STANDALONE_RASTER))
        (Areas::of_zones(plan.zones).draw(view))
        (stages(view, &plan.stages, STANDALONE_TOLERANCE))
        @for (index, stop) in plan.stops.iter().enumerate().filter(|(_, stop)| view.shows(stop)) {
            (stop_mark(view.at(stop), index + 1))
        }
        @if let Some(nearest) = nearest.filter(|nearest| view.shows(nearest)) {
            (nearest_mark(view.at(&nearest)))
        }
        (start_mark(view.at(&plan.start.position()), plan.start.yaw))
        (goal_mark(view.at(&plan.goal)))
        (labels(view, &plan.start.position(), &plan.goal))
    }
}

fn plan_legend(plan: &PlanView, has_nearest: bool, view: &Viewport) -> Vec<LegendEntry> {
    let mut legend = end_legend();
    if !plan.stops.is_empty() {
        legend.push(LegendEntry::new(stop_mark([14.0, 7.0], 1), "stop"));
    }
    if plan.stages.smoothed.len() > 1 {
        legend.extend(stage_legend());
    }
    if has_nearest {
        legend.push(LegendEntry::new(nearest_mark([14.0, 7.0]), "nearest reachable point"));
    }
    legend.extend(Areas::of_zones(plan.zones).legend());
    legend.extend(ground_legend(plan.map, view));
    legend
}

/// The metrics in a line.
fn metrics_text(metrics: &PlanMetrics, stops: usize) -> String {
    let count = |count: usize, noun: &str| match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    };
    let sharp = match metrics.sharp_turns {
        0 => "none sharp".to_owned(),
        sharp => format!("{sharp} sharp"),
    };
    let turns = match metrics.turns {
        0 => "no turn".to_owned(),
        turns => format!("{} before smoothing, {sharp} after it", count(turns, "turn")),
    };
    let stops = match stops {
        0 => String::new(),
        stops => format!(", {}", count(stops, "stop")),
    };
    let clearance = if metrics.min_clearance_m.is_finite() {
        format!("clearance at least {} m", fixed(metrics.min_clearance_m, 2))
    } else {
        "no obstacle on the map".to_owned()
    };
    format!("{} m long{stops}, {turns}, {clearance}", fixed(metrics.length_m, 2))
}

/// Returns an SVG file with the map, every planned path, the driven track coloured by speed, a scale bar and a legend.
#[must_use]
pub fn drive_svg(drive: &DriveView) -> String {
    let trace = drive.trace;
    let (start, goal) = (drive.start.position(), drive.goal);
    let driven = trace.rows.iter().map(|row| row.pose.position());
    let points = driven.chain(trace.paths.iter().flatten().copied()).chain([start, goal]);
    let view = &Viewport::around(points, drive.map.frame());
    let zones = Areas::of_zones(drive.zones);
    let layers = html! {
        (ground(drive.map, view, STANDALONE_RASTER))
        (zones.draw(view))
        (trails(trace, view))
        @for planned in &trace.paths { (path(view, "planned", planned, STANDALONE_TOLERANCE)) }
        (track(&trace.rows, view))
        (contacts(&trace.rows, view))
        (start_mark(view.at(&start), drive.start.yaw))
        (goal_mark(view.at(&goal)))
        (labels(view, &start, &goal))
    };
    let fastest = fixed(top_speed(&trace.rows), 2);
    let mut legend = end_legend();
    legend.extend([
        LegendEntry::line("planned", "planned path"),
        LegendEntry::line("track speed-0", "track, slowest quarter"),
        LegendEntry::line("track speed-3", format!("track, up to {fastest} m/s")),
    ]);
    legend.extend(trail_legend(trace, view));
    legend.extend(zones.legend());
    legend.extend(ground_legend(drive.map, view));
    let (title, caption) = (drive.title, drive.caption);
    StandaloneMap { title, caption, style: DRIVE_STYLE, layers, legend }.svg(view)
}

/// The figure of the map of a mission: the grid, the planned paths, the driven track and the moving obstacles.
pub(super) fn mission_figure(mission: &MissionView, view: &Viewport) -> Markup {
    let trace = &mission.result.trace;
    let encounters = Encounters::new(trace, &mission.config.robot.footprint, view);
    let caption = format!(
        "Shown is x {} to {} m and y {} to {} m of the map frame.{}",
        fixed(view.low.x, 1),
        fixed(view.high.x, 1),
        fixed(view.low.y, 1),
        fixed(view.high.y, 1),
        encounters.times_text()
    );
    let table = Table::of_ticks(
        "track",
        &trace.rows,
        &[
            ("time, s", |row| fixed(row.time_s, 2)),
            ("x, m", |row| fixed(row.pose.x, 3)),
            ("y, m", |row| fixed(row.pose.y, 3)),
            ("yaw, rad", |row| fixed(row.pose.yaw, 3)),
            ("local target x, m", |row| fixed(row.local_target.x, 2)),
            ("local target y, m", |row| fixed(row.local_target.y, 2)),
        ],
    );
    let layers = mission_layers(mission, view, &encounters);
    let picture = MapPanel::new(view, &layers, mission_alt_text(mission), "").picture();
    figure("Map", &picture, &mission_legend(mission, view, &encounters), &caption, &table)
}

/// The part of the map that the pictures of a mission show. With a player it has everything within range of the lidar.
pub(super) fn mission_viewport(view: &MissionView) -> Viewport {
    let (mission, trace) = (view.mission, &view.result.trace);
    let driven = || trace.rows.iter().map(|row| row.pose.position());
    let reach_m = view.playback.map(PlaybackRecorder::lidar_range_m);
    let seen =
        reach_m.and_then(|reach_m| Viewport::within_reach(driven(), reach_m, mission.map.frame()));
    let points = driven()
        .chain(seen.iter().flat_map(Viewport::corners))
        .chain(view.stages().points())
        .chain(trace.paths.iter().flatten().copied())
        .chain([mission.start.position(), mission.goal.position]);
    Viewport::around(points, mission.map.frame())
}

fn mission_layers(of: &MissionView, view: &Viewport, encounters: &Encounters) -> Markup {
    let (mission, trace) = (of.mission, &of.result.trace);
    let (start, goal) = (mission.start.position(), mission.goal.position);
    let raster_side = if of.playback.is_some() { PLAYER_RASTER } else { PAGE_RASTER };
    html! {
        (ground(&mission.map, view, raster_side))
        (Areas::of_zones(mission.zones.as_deref()).draw(view))
        (map_changes(of).draw(view))
        (trails(trace, view))
        (stages(view, &of.stages(), TOLERANCE))
        @for replanned in trace.paths.iter().skip(1) { (path(view, "replanned", replanned, TOLERANCE)) }
        (track(&trace.rows, view))
        (encounters.draw(&of.config.robot.footprint, view))
        @if let Some(row) = closest(&trace.rows) {
            @let [x, y] = view.at(&row.pose.position());
            circle class="closest" cx=(coordinate(x)) cy=(coordinate(y)) r="6" {}
        }
        (contacts(&trace.rows, view))
        (start_mark(view.at(&start), mission.start.yaw))
        (goal_mark(view.at(&goal)))
        (encounters.draw_numbers())
        (labels(view, &start, &goal))
    }
}

fn mission_legend(
    mission: &MissionView,
    view: &Viewport,
    encounters: &Encounters,
) -> Vec<LegendEntry> {
    let trace = &mission.result.trace;
    let mut legend = end_legend();
    legend.extend(stage_legend());
    if trace.paths.len() > 1 {
        legend.push(LegendEntry::line("replanned", "replanned path"));
    }
    if !trace.rows.is_empty() {
        let speed = fixed(top_speed(&trace.rows), 2);
        legend.push(track_legend(format!("driven track, speed 0 to {speed} m/s")));
    }
    legend.extend(encounters.legend());
    legend.extend(trail_legend(trace, view));
    if closest(&trace.rows).is_some() {
        legend.push(LegendEntry::circle("closest", 6.0, "smallest gap"));
    }
    if trace.rows.iter().any(|row| row.gap_m <= 0.0) {
        let mark = html! { path class="contact-mark" d="M9 2l10 10m0 -10l-10 10" {} };
        legend.push(LegendEntry::new(mark, "contact"));
    }
    legend.extend(Areas::of_zones(mission.mission.zones.as_deref()).legend());
    legend.extend(map_changes(mission).legend());
    legend.extend(ground_legend(&mission.mission.map, view));
    legend
}

/// What has changed on the map of a mission.
fn map_changes(view: &MissionView) -> Areas {
    Areas::of_changes(view.result.map_changes.as_ref(), view.mission.map.frame())
}

fn mission_alt_text(view: &MissionView) -> String {
    let (start, goal, result) = (view.mission.start, view.mission.goal.position, view.result);
    format!(
        "Map with the planned paths and the driven track from ({}, {}) to the goal ({}, {}), metres. The goal was {}, \
         {}. {} moving obstacles, {} plans.",
        fixed(start.x, 1),
        fixed(start.y, 1),
        fixed(goal.x, 1),
        fixed(goal.y, 1),
        if result.reached { "reached" } else { "not reached" },
        if result.collided { "with contact" } else { "without contact" },
        result.trace.moving_radii.len(),
        result.trace.paths.len().max(1)
    )
}
