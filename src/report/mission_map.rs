//! The map of a mission: the grid, the planned paths, the driven track and the moving obstacles.

use maud::{Markup, html};

use super::figure::{Table, figure as page_figure};
use super::map::{
    Encounters, MapPanel, PAGE_RASTER, Viewport, contacts, end_legend, goal_mark, ground,
    ground_legend, labels, path, stage_legend, stages, start_mark, top_speed, track, track_legend,
    trail_legend, trails,
};
use super::mission_charts::closest;
use super::mission_page::MissionView;
use super::number::{coordinate, fixed};
use super::svg::{LegendEntry, TOLERANCE};

/// The figure of a map.
pub(super) fn figure(mission: &MissionView, view: &Viewport) -> Markup {
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
    let layers = layers(mission, view, &encounters);
    let picture = MapPanel::new(view, &layers, alt_text(mission), "").picture();
    page_figure("Map", &picture, &legend(mission, view, &encounters), &caption, &table)
}

/// The part of the map that the pictures of a mission show.
pub(super) fn viewport(view: &MissionView) -> Viewport {
    let (mission, trace) = (view.mission, &view.result.trace);
    let driven = trace.rows.iter().map(|row| row.pose.position());
    let points = driven
        .chain(view.stages().points())
        .chain(trace.paths.iter().flatten().copied())
        .chain([mission.start.position(), mission.goal.position]);
    Viewport::around(points, mission.map.frame())
}

fn layers(of: &MissionView, view: &Viewport, encounters: &Encounters) -> Markup {
    let (mission, trace) = (of.mission, &of.result.trace);
    let (start, goal) = (mission.start.position(), mission.goal.position);
    html! {
        (ground(&mission.map, view, PAGE_RASTER))
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

fn legend(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Vec<LegendEntry> {
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
    legend.extend(ground_legend(&mission.mission.map, view));
    legend
}

fn alt_text(view: &MissionView) -> String {
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
