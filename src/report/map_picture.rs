//! The map of a mission: the ground, the planned paths, the driven track and what moved.

use maud::{Markup, html};

use super::MissionView;
use super::encounters::Encounters;
use super::figure::{Figure, Table, key, line_key};
use super::gap_chart::closest;
use super::map_furniture::{goal_mark, labels, start_mark, strip};
use super::map_layers::{Stages, ground, ground_keys, path, stage_keys, stages};
use super::map_motion::{contacts, has_trails, top_speed, track, trails};
use super::number::{coordinate, fixed};
use super::simplify::TOLERANCE;
use super::viewport::{MAP_WIDTH, Viewport};

/// Height of the strip below the map with the scale bar and the axes.
pub(super) const STRIP: f64 = 44.0;

/// Pixels of the ground's longer side, at most: pages hold several maps and stay small.
pub(super) const RASTER_SIDE: i32 = 900;

impl<'a> MissionView<'a> {
    const fn stages(&self) -> Stages<'a> {
        Stages {
            searched: self.searched,
            pruned: self.pruned,
            smoothed: self.smoothed,
        }
    }
}

pub(super) fn figure(mission: &MissionView, view: &Viewport) -> Markup {
    let encounters = Encounters::of(mission.trace, mission.footprint, view);
    Figure {
        title: "Where it went",
        picture: picture(mission, view, &encounters),
        legend: legend(mission, view, &encounters),
        caption: caption(view, &encounters),
        table: table(mission),
    }
    .markup()
}

/// The part of the ground that a mission's pictures show.
pub(super) fn viewport(mission: &MissionView) -> Viewport {
    let driven = mission.trace.rows.iter().map(|row| row.pose.position());
    let points = driven
        .chain(mission.stages().points())
        .chain(mission.trace.paths.iter().flatten().copied())
        .chain([mission.start.position(), mission.goal]);
    Viewport::around(points, mission.map.frame())
}

fn picture(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Markup {
    let trace = mission.trace;
    let height = view.height();
    html! {
        svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img"
            aria-label=(alternative(mission)) viewBox=(format!("0 0 {MAP_WIDTH} {}", coordinate(height + STRIP))) {
            rect class="outside" width=(MAP_WIDTH) height=(coordinate(height)) {}
            (ground(mission.map, view, RASTER_SIDE))
            (trails(trace, view))
            (stages(view, &mission.stages(), TOLERANCE))
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

fn legend(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Vec<Markup> {
    let trace = mission.trace;
    let mut legend = vec![
        key(&start_mark([12.0, 7.0], 0.0), "start"),
        key(&goal_mark([14.0, 7.0]), "goal"),
    ];
    legend.extend(in_page(stage_keys()));
    if trace.paths.len() > 1 {
        legend.push(line_key("replanned", "planned again on the way"));
    }
    if !trace.rows.is_empty() {
        legend.push(key(
            &html! {
                line class="track speed-0" x1="1" x2="8" y1="7" y2="7" {}
                line class="track speed-1" x1="8" x2="14" y1="7" y2="7" {}
                line class="track speed-2" x1="14" x2="20" y1="7" y2="7" {}
                line class="track speed-3" x1="20" x2="27" y1="7" y2="7" {}
            },
            &format!(
                "driven, from standing to {} m/s in quarters",
                fixed(top_speed(&trace.rows), 2)
            ),
        ));
    }
    legend.extend(
        encounters
            .keys()
            .iter()
            .map(|(mark, meaning)| key(mark, meaning)),
    );
    if has_trails(trace, view) {
        legend.push(line_key("trail", "way of a moving obstacle"));
    }
    if closest(&trace.rows).is_some() {
        legend.push(key(
            &html! { circle class="closest" cx="14" cy="7" r="6" {} },
            "smallest gap",
        ));
    }
    if trace.rows.iter().any(|row| row.gap_m <= 0.0) {
        legend.push(key(
            &html! { path class="contact-mark" d="M9 2l10 10m0 -10l-10 10" {} },
            "contact",
        ));
    }
    legend.extend(in_page(ground_keys(mission.map, view)));
    legend
}

/// Entries of the page's legend.
fn in_page(keys: Vec<(Markup, String)>) -> impl Iterator<Item = Markup> {
    keys.into_iter().map(|(mark, meaning)| key(&mark, &meaning))
}

fn caption(view: &Viewport, encounters: &Encounters) -> String {
    let mut caption = format!(
        "Shown is x {} to {} m and y {} to {} m of the map frame.",
        fixed(view.low.x, 1),
        fixed(view.high.x, 1),
        fixed(view.low.y, 1),
        fixed(view.high.y, 1)
    );
    caption += &encounters.in_words();
    caption
}

fn alternative(mission: &MissionView) -> String {
    let outcome = &mission.outcome;
    format!(
        "Map with the planned paths and the driven track from ({}, {}) to the goal ({}, {}), metres. The goal was {}; \
         {}. {} moving obstacles, {} plans.",
        fixed(mission.start.x, 1),
        fixed(mission.start.y, 1),
        fixed(mission.goal.x, 1),
        fixed(mission.goal.y, 1),
        if outcome.reached {
            "reached"
        } else {
            "not reached"
        },
        if outcome.collided {
            "there was contact"
        } else {
            "there was no contact"
        },
        mission.trace.moving_radii.len(),
        mission.trace.paths.len().max(1)
    )
}

fn table(mission: &MissionView) -> Table<'static> {
    let heads = &[
        "time, s",
        "x, m",
        "y, m",
        "yaw, rad",
        "local target x, m",
        "local target y, m",
    ];
    Table::of_ticks("track", heads, &mission.trace.rows, |_, row| {
        vec![
            fixed(row.time_s, 2),
            fixed(row.pose.x, 3),
            fixed(row.pose.y, 3),
            fixed(row.pose.yaw, 3),
            fixed(row.local_target.x, 2),
            fixed(row.local_target.y, 2),
        ]
    })
}
