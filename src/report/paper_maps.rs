//! The maps of the paper's experiments: paths of the search variants (figs. 9 to 11 and 16), and drives (figs. 12 and 13).

use maud::{Markup, html};

use super::map::{
    Encounters, MAP_WIDTH, MapPanel, MapsSideBySide, PAGE_RASTER, Viewport, contacts, end_legend,
    goal_mark, ground, node_mark, path, scaled, start_mark, track, track_legend, trail_legend,
    trails,
};
use super::number::{coordinate, fixed};
use super::svg::{LegendEntry, TOLERANCE};
use crate::bench::paper::{Run, Search, Site, Stage, TaskRuns};
use crate::experiment::paper_drives::Course;
use crate::geometry::{Point, bearing};
use crate::robot::Footprint;
use crate::runtime::Trace;

/// Scale of the marks: three maps share the width of one.
const MARK_SCALE: f64 = 2.2;

/// The paths on maps side by side: search, class of the line, and name.
const SHOWN: [(Search, &str, &str); 3] = [
    (Search::MANHATTAN, "traditional-path", "traditional A*, Manhattan"),
    (Search::IMPROVED, "improved-path", "improved"),
    (Search::JUMP_POINTS, "jump-path", "jump points, pruning, spline"),
];

/// The searches on the overview map.
const OVERVIEW: [Search; 2] = [Search::MANHATTAN, Search::JUMP_POINTS];

/// The final path of a run, and the nodes that remain after pruning.
fn final_path(run: &Run) -> (&[Point], &[Point]) {
    let is_pruned = run.search.last_stage > Stage::Raw;
    let nodes = if is_pruned { run.at(Stage::Pruned).path.points() } else { &[] };
    (run.at(run.search.last_stage).path.points(), nodes)
}

/// One task with the traditional and the improved paths.
pub(super) fn variants(name: &str, title: String, site: &Site, task: &TaskRuns) -> MapsSideBySide {
    let points = task.runs.iter().flat_map(|run| final_path(run).0).copied();
    let view = Viewport::around(points, site.map.frame());
    let shown = ["a", "b", "c"].iter().zip(SHOWN);
    let panels = shown.filter_map(|(letter, (search, class, name))| {
        let run = task.of(search)?;
        let caption = format!("({letter}) {name}: {}", path_text(run));
        Some(one_map(site, &view, &[(task, run, class)], false, caption))
    });
    MapsSideBySide {
        name: name.to_owned(),
        title,
        panels: panels.collect(),
        legend: path_legend(|_| true, true),
    }
}

fn path_text(run: &Run) -> String {
    let last = run.at(run.search.last_stage);
    let turns = match run.search.last_stage {
        Stage::Raw => format!("{} turns", last.path.turns()),
        _ => format!("{} turns before smoothing", run.at(Stage::Pruned).path.turns()),
    };
    format!(
        "{} m, {turns}, {} m from obstacles",
        fixed(last.path.length_m(), 2),
        fixed(last.min_clearance_m, 2)
    )
}

/// All tasks of a site on its whole map, the traditional path below that of the jump points.
pub(super) fn overview(name: &str, title: &str, site: &Site, tasks: &[TaskRuns]) -> MapsSideBySide {
    let view = Viewport::around(site.map.frame().corners(), site.map.frame());
    let drawn: Vec<(&TaskRuns, &Run, &str)> = OVERVIEW
        .into_iter()
        .zip(["traditional-path", "jump-path"])
        .flat_map(|(search, class)| {
            tasks.iter().filter_map(move |task| Some((task, task.of(search)?, class)))
        })
        .collect();
    MapsSideBySide {
        name: name.to_owned(),
        title: title.to_owned(),
        panels: vec![one_map(site, &view, &drawn, true, String::new())],
        legend: path_legend(|search| OVERVIEW.contains(&search), false),
    }
}

/// The legend of maps with some of the paths.
fn path_legend(has_path: impl Fn(Search) -> bool, has_nodes: bool) -> Vec<LegendEntry> {
    let paths = SHOWN.into_iter().filter(|(search, ..)| has_path(*search));
    let mut legend = end_legend();
    legend.extend(paths.map(|(_, class, name)| LegendEntry::line(class, name)));
    if has_nodes {
        legend.push(LegendEntry::new(node_mark([14.0, 7.0], 7.0), "node after pruning"));
    }
    legend.push(LegendEntry::area("rock", "obstacle"));
    legend
}

fn one_map(
    site: &Site,
    view: &Viewport,
    drawn: &[(&TaskRuns, &Run, &str)],
    with_numbers: bool,
    caption: String,
) -> MapPanel {
    // On a map with many paths, nodes would hide them.
    let nodes = drawn.iter().filter(|_| !with_numbers).flat_map(|(_, run, _)| final_path(run).1);
    let layers = html! {
        (ground(&site.map, view, PAGE_RASTER))
        @for (_, run, class) in drawn { (path(view, class, final_path(run).0, TOLERANCE)) }
        @for node in nodes { (node_mark(view.at(node), 10.0)) }
        @for (index, (task, run, _)) in drawn.iter().enumerate() { (ends(site, view, task, run, with_numbers.then_some(index))) }
    };
    let paths = drawn.iter().map(|(task, run, _)| {
        format!("{}, {}: {}", task.task.name, run.search.label, path_text(run))
    });
    let paths = paths.collect::<Vec<_>>().join("; ");
    MapPanel::new(view, &layers, format!("Map of {} with paths. {paths}.", site.title), caption)
}

/// Start and goal; with an index, also the number of the task at both.
fn ends(site: &Site, view: &Viewport, task: &TaskRuns, run: &Run, index: Option<usize>) -> Markup {
    let frame = site.map.frame();
    let [start, goal] = [task.task.start, task.task.goal].map(|end| frame.center_of(end));
    let yaw = match final_path(run).0 {
        [first, second, ..] => bearing(first, second),
        _ => 0.0,
    };
    let scale = if index.is_some() { 1.0 } else { MARK_SCALE };
    let number = task.task.name.trim_start_matches("Path ");
    html! {
        (scaled(view.at(&start), scale, &start_mark([0.0, 0.0], yaw)))
        (scaled(view.at(&goal), scale, &goal_mark([0.0, 0.0])))
        @if index.is_some() {
            @for [x, y] in [start, goal].map(|end| view.at(&end)) {
                @let (x, class) = if x > MAP_WIDTH / 2.0 { (x - 11.0, "end halo strong") } else { (x + 11.0, "halo strong") };
                text class=(class) x=(coordinate(x)) y=(coordinate(y)) dy=".35em" { (number) }
            }
        }
    }
}

/// A drive on its map.
struct DriveMap<'a> {
    course: &'a Course,
    trace: &'a Trace,
    footprint: &'a Footprint,
    view: Viewport,
    encounters: Encounters,
}

/// One drive on each course.
pub(super) fn drives<'a>(
    [name, title]: [&str; 2],
    courses: &'a [Course],
    shown: impl Iterator<Item = &'a Trace>,
    footprint: &'a Footprint,
) -> MapsSideBySide {
    let maps: Vec<DriveMap> = courses
        .iter()
        .zip(shown)
        .map(|(course, trace)| DriveMap::new(course, trace, footprint))
        .collect();
    let panels = ["a", "b", "c"].iter().zip(&maps);
    MapsSideBySide {
        name: name.to_owned(),
        title: title.to_owned(),
        panels: panels.map(|(letter, map)| map.panel(letter)).collect(),
        legend: drive_legend(&maps),
    }
}

impl<'a> DriveMap<'a> {
    fn new(course: &'a Course, trace: &'a Trace, footprint: &'a Footprint) -> Self {
        let driven = trace.rows.iter().map(|row| row.pose.position());
        let points = driven.chain(course.plan.smoothed.points().iter().copied());
        let view = Viewport::around(points, course.map.frame());
        // Without moving obstacles, moments add nothing to the track.
        let encounters = if trace.moving_radii.is_empty() {
            Encounters::default()
        } else {
            Encounters::new(trace, footprint, &view)
        };
        Self { course, trace, footprint, view, encounters }
    }

    fn panel(&self, letter: &str) -> MapPanel {
        let (view, course, trace) = (&self.view, self.course, self.trace);
        let mark = |mark: &Markup, at: Point| scaled(view.at(&at), MARK_SCALE, mark);
        let layers = html! {
            (ground(&course.map, view, PAGE_RASTER))
            (trails(trace, view))
            (path(view, "smoothed", course.plan.smoothed.points(), TOLERANCE))
            @for replanned in trace.paths.iter().skip(1) { (path(view, "replanned", replanned, TOLERANCE)) }
            @for node in &course.key_nodes { (node_mark(view.at(node), 5.0)) }
            (track(&trace.rows, view))
            (self.encounters.draw(self.footprint, view))
            @for node in course.plan.pruned.points() { (node_mark(view.at(node), 13.0)) }
            (contacts(&trace.rows, view))
            (mark(&start_mark([0.0, 0.0], course.start.yaw), course.start.position()))
            (mark(&goal_mark([0.0, 0.0]), course.goal.position))
            (self.encounters.draw_numbers())
        };
        let (title, result, moments) =
            (&course.title, self.result_text(), self.encounters.times_text());
        let alt_text = format!(
            "Map of {title} with the planned path, its {} key nodes and the driven track: {result}",
            course.key_nodes.len()
        );
        MapPanel::new(view, &layers, alt_text, format!("({letter}) {title}: {result}{moments}"))
    }

    fn result_text(&self) -> String {
        let rows = &self.trace.rows;
        let gap_m = rows.iter().map(|row| row.gap_m).fold(f64::INFINITY, f64::min);
        let time_s = rows.last().map_or(0.0, |row| row.time_s);
        let pedestrians = match self.trace.moving_radii.len() {
            0 => String::new(),
            1 => "one pedestrian, ".to_owned(),
            count => format!("{count} pedestrians, "),
        };
        let plans = match self.trace.paths.len() {
            0 | 1 => "one plan".to_owned(),
            plans => format!("{plans} plans"),
        };
        format!("{pedestrians}{} s, smallest gap {} m, {plans}.", fixed(time_s, 1), fixed(gap_m, 2))
    }
}

fn drive_legend(maps: &[DriveMap]) -> Vec<LegendEntry> {
    let mut legend = end_legend();
    legend.extend([
        LegendEntry::line("smoothed", "planned path"),
        LegendEntry::new(node_mark([14.0, 7.0], 8.0), "key node after pruning"),
        LegendEntry::new(node_mark([14.0, 7.0], 4.0), "intermediate key node, or goal"),
    ]);
    if maps.iter().any(|map| map.trace.paths.len() > 1) {
        legend.push(LegendEntry::line("replanned", "replanned path"));
    }
    legend.push(track_legend("driven track, from standstill to top speed".to_owned()));
    let encounters = maps.iter().map(|map| map.encounters.legend());
    legend.extend(encounters.max_by_key(Vec::len).unwrap_or_default());
    legend.extend(maps.iter().find_map(|map| trail_legend(map.trace, &map.view)));
    legend.push(LegendEntry::area("rock", "obstacle"));
    legend
}
