//! Figs. 12 and 13: the planned path, its key nodes and the way driven, and who was where at some moments.

use maud::{Markup, html};

use super::encounters::Encounters;
use super::figure::{area_mark, line_mark};
use super::map_figure::{MapFigure, MapPanel};
use super::map_furniture::{goal_mark, start_mark, strip};
use super::map_layers::{ground, path};
use super::map_motion::{contacts, has_trails, track, trails};
use super::map_picture::{RASTER_SIDE, STRIP};
use super::number::{coordinate, fixed};
use super::paper_maps::enlarged;
use super::simplify::TOLERANCE;
use super::viewport::{MAP_WIDTH, Viewport};
use crate::experiment::paper_drives::Course;
use crate::geometry::Point;
use crate::robot::Footprint;
use crate::runtime::Trace;

/// Marks are drawn so many times larger: three maps share the width of one.
const MARKS: f64 = 2.2;

/// A drive as a map shows it.
struct Drawn<'a> {
    course: &'a Course,
    trace: &'a Trace,
    footprint: &'a Footprint,
    view: Viewport,
    encounters: Encounters,
}

/// One drive on each course.
pub(super) fn side_by_side<'a>(
    [name, title]: [&str; 2],
    courses: &'a [Course],
    shown: impl Iterator<Item = &'a Trace>,
    footprint: &'a Footprint,
) -> MapFigure {
    let drawn: Vec<Drawn> = courses
        .iter()
        .zip(shown)
        .map(|(course, trace)| Drawn::new(course, trace, footprint))
        .collect();
    let panels = ["a", "b", "c"].iter().zip(&drawn);
    MapFigure {
        name: name.to_owned(),
        title: title.to_owned(),
        panels: panels.map(|(letter, drawn)| drawn.panel(letter)).collect(),
        keys: keys(&drawn),
    }
}

impl<'a> Drawn<'a> {
    fn new(course: &'a Course, trace: &'a Trace, footprint: &'a Footprint) -> Self {
        let driven = trace.rows.iter().map(|row| row.pose.position());
        let points = driven.chain(course.plan.smoothed.points().iter().copied());
        let view = Viewport::around(points, course.map.frame());
        // Where nobody moves the moments would tell nothing that the track does not.
        let encounters = if trace.moving_radii.is_empty() {
            Encounters::default()
        } else {
            Encounters::of(trace, footprint, &view)
        };
        Self {
            course,
            trace,
            footprint,
            view,
            encounters,
        }
    }

    fn panel(&self, letter: &str) -> MapPanel {
        let (view, course, trace) = (&self.view, self.course, self.trace);
        let height = view.height();
        let mark = |mark: &Markup, at: Point| enlarged(view.at(&at), MARKS, mark);
        let content = html! {
            rect class="outside" width=(MAP_WIDTH) height=(coordinate(height)) {}
            (ground(&course.map, view, RASTER_SIDE))
            (trails(trace, view))
            (path(view, "smoothed", course.plan.smoothed.points(), TOLERANCE))
            @for replanned in trace.paths.iter().skip(1) { (path(view, "replanned", replanned, TOLERANCE)) }
            @for node in &course.key_nodes { (square(view.at(node), 5.0)) }
            (track(&trace.rows, view))
            (self.encounters.draw(self.footprint, view))
            @for node in course.plan.pruned.points() { (square(view.at(node), 13.0)) }
            (contacts(&trace.rows, view))
            (mark(&start_mark([0.0, 0.0], course.start.yaw), course.start.position()))
            (mark(&goal_mark([0.0, 0.0]), course.goal.position))
            (self.encounters.draw_numbers())
            (strip(view, height))
        };
        let moments = self.encounters.in_words();
        MapPanel {
            content,
            height: height + STRIP,
            alternative: self.alternative(),
            words: format!(
                "({letter}) {}: {}{moments}",
                course.title,
                self.in_figures()
            ),
        }
    }

    fn in_figures(&self) -> String {
        let rows = &self.trace.rows;
        let gap_m = rows
            .iter()
            .map(|row| row.gap_m)
            .fold(f64::INFINITY, f64::min);
        let time_s = rows.last().map_or(0.0, |row| row.time_s);
        let people = match self.trace.moving_radii.len() {
            0 => String::new(),
            1 => "one person, ".to_owned(),
            people => format!("{people} people, "),
        };
        let plans = match self.trace.paths.len() {
            0 | 1 => "one plan".to_owned(),
            plans => format!("{plans} plans"),
        };
        format!(
            "{people}{} s, smallest gap {} m, {plans}.",
            fixed(time_s, 1),
            fixed(gap_m, 2),
        )
    }

    fn alternative(&self) -> String {
        format!(
            "Map of {} with the planned path, its {} key nodes and the way driven: {}",
            self.course.title,
            self.course.key_nodes.len(),
            self.in_figures()
        )
    }
}

/// A key node, of so many drawing units.
fn square([x, y]: [f64; 2], side: f64) -> Markup {
    let (x, y) = (coordinate(x - side / 2.0), coordinate(y - side / 2.0));
    html! { rect class="node" x=(x) y=(y) width=(side) height=(side) {} }
}

fn keys(drawn: &[Drawn]) -> Vec<(Markup, String)> {
    let driven = html! {
        line class="track speed-0" x1="1" x2="8" y1="7" y2="7" {}
        line class="track speed-1" x1="8" x2="14" y1="7" y2="7" {}
        line class="track speed-2" x1="14" x2="20" y1="7" y2="7" {}
        line class="track speed-3" x1="20" x2="27" y1="7" y2="7" {}
    };
    let is_replanned = drawn.iter().any(|drawn| drawn.trace.paths.len() > 1);
    let has_trails = drawn
        .iter()
        .any(|drawn| has_trails(drawn.trace, &drawn.view));
    let own = |mark: Markup, meaning: &str| (mark, meaning.to_owned());
    let mut keys = vec![
        own(start_mark([12.0, 7.0], 0.0), "start"),
        own(goal_mark([14.0, 7.0]), "goal"),
        own(line_mark("smoothed"), "planned"),
        own(square([14.0, 7.0], 8.0), "key node: left by pruning"),
        own(square([14.0, 7.0], 4.0), "key node between, or the goal"),
    ];
    if is_replanned {
        keys.push(own(line_mark("replanned"), "planned again on the way"));
    }
    keys.push(own(driven, "driven, from standing to the top speed"));
    let encounters = drawn.iter().map(|drawn| drawn.encounters.keys());
    keys.extend(encounters.max_by_key(Vec::len).unwrap_or_default());
    if has_trails {
        keys.push(own(line_mark("trail"), "way of a moving obstacle"));
    }
    keys.push(own(area_mark("rock"), "obstacle"));
    keys
}
