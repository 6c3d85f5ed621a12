//! Marks that make a map readable: start, goal and stops, the scale bar and the axes.

use maud::{Markup, html};

use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::Point;
use crate::report::chart::round_number_below;
use crate::report::number::coordinate;
use crate::report::svg::LegendEntry;

/// Height of the strip below a map with the scale bar and the axes, drawing units.
pub(crate) const STRIP: f64 = 44.0;

/// Largest length of the scale bar, drawing units.
const SCALE_BAR: f64 = 150.0;

/// An arrowhead that points along a heading.
pub(crate) fn start_mark([x, y]: [f64; 2], yaw: f64) -> Markup {
    let degrees = if yaw.is_finite() { -yaw.to_degrees() } else { 0.0 };
    html! {
        path class="start" d="M11 0l-17 7l4 -7l-4 -7z"
            transform=(format!("translate({} {}) rotate({})", coordinate(x), coordinate(y), coordinate(degrees))) {}
    }
}

/// A target.
pub(crate) fn goal_mark([x, y]: [f64; 2]) -> Markup {
    let (x, y) = (coordinate(x), coordinate(y));
    html! {
        circle class="goal" cx=(x) cy=(y) r="6.5" {}
        circle class="goal-center" cx=(x) cy=(y) r="2.2" {}
    }
}

/// A node of a path with a side in drawing units.
pub(crate) fn node_mark([x, y]: [f64; 2], side: f64) -> Markup {
    let (x, y) = (coordinate(x - side / 2.0), coordinate(y - side / 2.0));
    html! { rect class="node" x=(x) y=(y) width=(side) height=(side) {} }
}

/// The legend of start and goal.
pub(crate) fn end_legend() -> Vec<LegendEntry> {
    vec![
        LegendEntry::new(start_mark([12.0, 7.0], 0.0), "start"),
        LegendEntry::new(goal_mark([14.0, 7.0]), "goal"),
    ]
}

/// A numbered stop.
pub(crate) fn stop_mark([x, y]: [f64; 2], number: usize) -> Markup {
    let (x, y) = (coordinate(x), coordinate(y));
    html! {
        circle class="stop" cx=(x) cy=(y) r="9" {}
        text class="middle stop-number" x=(x) y=(y) dy=".36em" { (number) }
    }
}

/// A cross in a ring: the nearest point that can be reached.
pub(crate) fn nearest_mark([x, y]: [f64; 2]) -> Markup {
    let (x, y) = (coordinate(x), coordinate(y));
    html! {
        circle class="nearest" cx=(x) cy=(y) r="6.5" {}
        path class="nearest" d=(format!("M{x} {y}m-3 -3l6 6m0 -6l-6 6")) {}
    }
}

/// A mark that is drawn at the origin, scaled and moved to a position.
pub(crate) fn scaled([x, y]: [f64; 2], factor: f64, mark: &Markup) -> Markup {
    let (x, y) = (coordinate(x), coordinate(y));
    html! { g transform=(format!("translate({x} {y}) scale({factor})")) { (mark) } }
}

/// The words "start" and "goal", above the upper and below the lower one.
pub(crate) fn labels(view: &Viewport, start: &Point, goal: &Point) -> Markup {
    let start_is_above = start.y > goal.y;
    html! {
        (label(view, start, "start", start_is_above))
        (label(view, goal, "goal", !start_is_above))
    }
}

fn label(view: &Viewport, point: &Point, word: &str, above: bool) -> Markup {
    let [x, y] = view.at(point);
    let class = if x > MAP_WIDTH * 0.85 {
        "end halo strong"
    } else if x < MAP_WIDTH * 0.15 {
        "halo strong"
    } else {
        "middle halo strong"
    };
    let (y, shift) = if above { (y - 12.0, "0") } else { (y + 12.0, ".8em") };
    html! {
        @if view.shows(point) {
            text class=(class) x=(coordinate(x)) y=(coordinate(y)) dy=(shift) { (word) }
        }
    }
}

/// The strip below a map: the scale bar, and the directions of the axes.
pub(crate) fn strip(view: &Viewport) -> Markup {
    let map_height = view.height();
    let metres = round_number_below(SCALE_BAR / view.scale());
    let end = 12.0 + metres * view.scale();
    let y = map_height + STRIP / 2.0 + 2.0;
    let (x, foot) = (MAP_WIDTH - 70.0, map_height + STRIP - 9.0);
    html! {
        rect class="strip" x="0" y=(coordinate(map_height)) width=(MAP_WIDTH) height=(STRIP) {}
        path class="scale" d=(format!(
            "M12 {y0}v8m0 -4H{end}m0 -4v8", y0 = coordinate(y - 4.0), end = coordinate(end)
        )) {}
        text x=(coordinate(end + 9.0)) y=(coordinate(y)) dy=".35em" { (metres) " m" }
        path class="scale" d=(format!(
            "M{x} {foot}h26m-5 -4l5 4l-5 4M{x} {foot}v-26m-4 5l4 -5l4 5", x = coordinate(x), foot = coordinate(foot)
        )) {}
        text x=(coordinate(x + 33.0)) y=(coordinate(foot)) dy=".3em" { "x" }
        text class="end" x=(coordinate(x - 8.0)) y=(coordinate(foot - 20.0)) dy=".35em" { "y" }
    }
}
