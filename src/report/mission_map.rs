//! The map of a mission: the grid, the planned paths, the driven track and the moving obstacles.

use maud::{Markup, html};

use super::figure::{Figure, Table};
use super::map::{
    Encounters, MAP_WIDTH, PAGE_RASTER, STRIP, Stages, Viewport, contacts, goal_mark, ground,
    ground_legend, has_trails, labels, path, stage_legend, stages, start_mark, strip, top_speed,
    track, track_legend, trails,
};
use super::mission_charts::closest;
use super::number::{coordinate, fixed};
use super::svg::{LegendEntry, TOLERANCE};
use super::views::MissionView;

/// The figure of a map.
pub(super) fn figure(mission: &MissionView, view: &Viewport) -> Markup {
    let encounters = Encounters::new(mission.trace, mission.footprint, view);
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
        &mission.trace.rows,
        &[
            ("time, s", |row| fixed(row.time_s, 2)),
            ("x, m", |row| fixed(row.pose.x, 3)),
            ("y, m", |row| fixed(row.pose.y, 3)),
            ("yaw, rad", |row| fixed(row.pose.yaw, 3)),
            ("local target x, m", |row| fixed(row.local_target.x, 2)),
            ("local target y, m", |row| fixed(row.local_target.y, 2)),
        ],
    );
    Figure {
        title: "Map",
        picture: picture(mission, view, &encounters),
        legend: &legend(mission, view, &encounters),
        caption: &caption,
        table: &table,
    }
    .markup()
}

/// The part of the map that the pictures of a mission show.
pub(super) fn viewport(mission: &MissionView) -> Viewport {
    let driven = mission.trace.rows.iter().map(|row| row.pose.position());
    let points = driven
        .chain(path_stages(mission).points())
        .chain(mission.trace.paths.iter().flatten().copied())
        .chain([mission.start.position(), mission.goal]);
    Viewport::around(points, mission.map.frame())
}

const fn path_stages<'a>(mission: &MissionView<'a>) -> Stages<'a> {
    Stages { searched: mission.searched, pruned: mission.pruned, smoothed: mission.smoothed }
}

fn picture(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Markup {
    let trace = mission.trace;
    let height = view.height();
    html! {
        svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img"
            aria-label=(alt_text(mission)) viewBox=(format!("0 0 {MAP_WIDTH} {}", coordinate(height + STRIP))) {
            rect class="outside" width=(MAP_WIDTH) height=(coordinate(height)) {}
            (ground(mission.map, view, PAGE_RASTER))
            (trails(trace, view))
            (stages(view, &path_stages(mission), TOLERANCE))
            @for replanned in trace.paths.iter().skip(1) { (path(view, "replanned", replanned, TOLERANCE)) }
            (track(&trace.rows, view))
            (encounters.draw(mission.footprint, view))
            @if let Some(row) = closest(&trace.rows) {
                @let [x, y] = view.at(&row.pose.position());
                circle class="closest" cx=(coordinate(x)) cy=(coordinate(y)) r="6" {}
            }
            (contacts(&trace.rows, view))
            (start_mark(view.at(&mission.start.position()), mission.start.yaw))
            (goal_mark(view.at(&mission.goal)))
            (encounters.draw_numbers())
            (labels(view, &mission.start.position(), &mission.goal))
            (strip(view, height))
        }
    }
}

fn legend(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Vec<LegendEntry> {
    let trace = mission.trace;
    let mut legend = vec![
        LegendEntry::new(start_mark([12.0, 7.0], 0.0), "start"),
        LegendEntry::new(goal_mark([14.0, 7.0]), "goal"),
    ];
    legend.extend(stage_legend());
    if trace.paths.len() > 1 {
        legend.push(LegendEntry::line("replanned", "replanned path"));
    }
    if !trace.rows.is_empty() {
        let speed = fixed(top_speed(&trace.rows), 2);
        legend.push(track_legend(format!("driven track, speed 0 to {speed} m/s")));
    }
    legend.extend(encounters.legend());
    if has_trails(trace, view) {
        legend.push(LegendEntry::line("trail", "trail of a moving obstacle"));
    }
    if closest(&trace.rows).is_some() {
        legend.push(LegendEntry::circle("closest", 6.0, "smallest gap"));
    }
    if trace.rows.iter().any(|row| row.gap_m <= 0.0) {
        let mark = html! { path class="contact-mark" d="M9 2l10 10m0 -10l-10 10" {} };
        legend.push(LegendEntry::new(mark, "contact"));
    }
    legend.extend(ground_legend(mission.map, view));
    legend
}

fn alt_text(mission: &MissionView) -> String {
    let outcome = &mission.outcome;
    format!(
        "Map with the planned paths and the driven track from ({}, {}) to the goal ({}, {}), metres. The goal was {}, \
         {}. {} moving obstacles, {} plans.",
        fixed(mission.start.x, 1),
        fixed(mission.start.y, 1),
        fixed(mission.goal.x, 1),
        fixed(mission.goal.y, 1),
        if outcome.reached { "reached" } else { "not reached" },
        if outcome.collided { "with contact" } else { "without contact" },
        mission.trace.moving_radii.len(),
        mission.trace.paths.len().max(1)
    )
}
