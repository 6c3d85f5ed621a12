//! Figs. 9 to 11 and 16: paths of the variants on their maps.

use maud::{Markup, html};

use super::figure::{area_mark, line_mark};
use super::map_figure::{MapFigure, MapPanel};
use super::map_furniture::{goal_mark, start_mark, strip};
use super::map_layers::{ground, path};
use super::map_picture::{RASTER_SIDE, STRIP};
use super::number::{coordinate, fixed};
use super::simplify::TOLERANCE;
use super::viewport::{MAP_WIDTH, Viewport};
use crate::bench::paper::{Run, Search, Site, Stage, TaskRuns};
use crate::geometry::{Point, bearing};

/// What is drawn side by side: the search, the class of its line, and its name.
const SHOWN: [(Search, &str, &str); 3] = [
    (
        Search::Manhattan,
        "traditional-path",
        "traditional A*, Manhattan",
    ),
    (Search::Improved, "improved-path", "improved"),
    (
        Search::JumpPoints,
        "jump-path",
        "jump points, pruning, spline",
    ),
];

/// What is drawn on one map of all ways.
const OVERVIEW: [Search; 2] = [Search::Manhattan, Search::JumpPoints];

/// The path that a run hands out, and the nodes that pruning left.
fn handed_out(run: &Run) -> (&[Point], &[Point]) {
    let is_pruned = run.search.last_stage() > Stage::Raw;
    let nodes = if is_pruned {
        run.at(Stage::Pruned).path.points()
    } else {
        &[]
    };
    (run.at(run.search.last_stage()).path.points(), nodes)
}

/// One task, the traditional path beside the improved ones.
pub(super) fn side_by_side(name: &str, title: String, site: &Site, task: &TaskRuns) -> MapFigure {
    let points = task.runs.iter().flat_map(|run| handed_out(run).0).copied();
    let view = Viewport::around(points, site.map.frame());
    let shown = ["a", "b", "c"].iter().zip(SHOWN);
    let panel = |(letter, (search, class, name)): (&&str, (Search, &str, &str))| {
        let run = task.of(search)?;
        Some(MapPanel {
            words: format!("({letter}) {name}: {}", in_figures(run)),
            ..one_map(site, &view, &[(task, run, class)], false)
        })
    };
    MapFigure {
        name: name.to_owned(),
        title,
        panels: shown.filter_map(panel).collect(),
        keys: keys(|_| true, true),
    }
}

fn in_figures(run: &Run) -> String {
    let worked = run.at(run.search.last_stage());
    let turns = match run.search.last_stage() {
        Stage::Raw => format!("{} turns", worked.path.turns()),
        _ => format!(
            "{} turns before smoothing",
            run.at(Stage::Pruned).path.turns()
        ),
    };
    format!(
        "{} m, {turns}, {} m from obstacles",
        fixed(worked.path.length_m(), 2),
        fixed(worked.min_clearance_m, 2)
    )
}

/// All tasks of a site on its whole map, the traditional path under that by jump points.
pub(super) fn overview(name: &str, title: &str, site: &Site, tasks: &[TaskRuns]) -> MapFigure {
    let view = Viewport::around(site.map.frame().corners(), site.map.frame());
    let drawn: Vec<(&TaskRuns, &Run, &str)> = OVERVIEW
        .into_iter()
        .zip(["traditional-path", "jump-path"])
        .flat_map(|(search, class)| {
            tasks
                .iter()
                .filter_map(move |task| Some((task, task.of(search)?, class)))
        })
        .collect();
    MapFigure {
        name: name.to_owned(),
        title: title.to_owned(),
        panels: vec![one_map(site, &view, &drawn, true)],
        keys: keys(|search| OVERVIEW.contains(&search), false),
    }
}

/// What the lines and marks of maps with these paths mean; on a map of many the nodes are left out.
fn keys(has_path: impl Fn(Search) -> bool, has_nodes: bool) -> Vec<(Markup, String)> {
    let node = html! { rect class="node" x="10.5" y="3.5" width="7" height="7" {} };
    let paths = SHOWN.into_iter().filter(|(search, ..)| has_path(*search));
    let mut keys = vec![
        (start_mark([12.0, 7.0], 0.0), "start"),
        (goal_mark([14.0, 7.0]), "goal"),
    ];
    keys.extend(paths.map(|(_, class, name)| (line_mark(class), name)));
    if has_nodes {
        keys.push((node, "node left by pruning"));
    }
    keys.push((area_mark("rock"), "obstacle"));
    keys.into_iter()
        .map(|(mark, meaning)| (mark, meaning.to_owned()))
        .collect()
}

fn one_map(
    site: &Site,
    view: &Viewport,
    drawn: &[(&TaskRuns, &Run, &str)],
    with_numbers: bool,
) -> MapPanel {
    let height = view.height();
    // On a map of many paths the nodes would hide them.
    let nodes: Vec<&Point> = drawn
        .iter()
        .filter(|_| !with_numbers)
        .flat_map(|(_, run, _)| handed_out(run).1)
        .collect();
    let content = html! {
        rect class="outside" width=(MAP_WIDTH) height=(coordinate(height)) {}
        (ground(&site.map, view, RASTER_SIDE))
        @for (_, run, class) in drawn { (path(view, class, handed_out(run).0, TOLERANCE)) }
        @for [x, y] in nodes.into_iter().map(|node| view.at(node)) {
            rect class="node" x=(coordinate(x - 5.0)) y=(coordinate(y - 5.0)) width="10" height="10" {}
        }
        @for (index, (task, run, _)) in drawn.iter().enumerate() { (ends(site, view, task, run, with_numbers.then_some(index))) }
        (strip(view, height))
    };
    MapPanel {
        content,
        height: height + STRIP,
        alternative: alternative(site, drawn),
        words: String::new(),
    }
}

/// Start and goal, and with an index the task's number at both.
fn ends(site: &Site, view: &Viewport, task: &TaskRuns, run: &Run, index: Option<usize>) -> Markup {
    let frame = site.map.frame();
    let [start, goal] = [task.task.start, task.task.goal].map(|end| frame.center_of(end));
    let yaw = match handed_out(run).0 {
        [first, second, ..] => bearing(first, second),
        _ => 0.0,
    };
    // Three maps share the width of one.
    let size = if index.is_some() { 1.0 } else { 2.2 };
    let number = task.task.name.trim_start_matches("Path ");
    html! {
        (enlarged(view.at(&start), size, &start_mark([0.0, 0.0], yaw)))
        (enlarged(view.at(&goal), size, &goal_mark([0.0, 0.0])))
        @if index.is_some() {
            @for [x, y] in [start, goal].map(|end| view.at(&end)) {
                @let (x, shift) = if x > MAP_WIDTH / 2.0 { (x - 11.0, "end halo strong") } else { (x + 11.0, "halo strong") };
                text class=(shift) x=(coordinate(x)) y=(coordinate(y)) dy=".35em" { (number) }
            }
        }
    }
}

/// A mark drawn about the origin, at a place of the drawing.
pub(super) fn enlarged([x, y]: [f64; 2], size: f64, mark: &Markup) -> Markup {
    let (x, y) = (coordinate(x), coordinate(y));
    html! { g transform=(format!("translate({x} {y}) scale({size})")) { (mark) } }
}

fn alternative(site: &Site, drawn: &[(&TaskRuns, &Run, &str)]) -> String {
    let paths: Vec<String> = drawn
        .iter()
        .map(|(task, run, _)| {
            let label = run.search.label();
            format!("{}, {label}: {}", task.task.name, in_figures(run))
        })
        .collect();
    format!("Map of {} with paths. {}.", site.title, paths.join("; "))
}
