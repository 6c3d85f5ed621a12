//! The page of the paper's experiments.

use maud::{Markup, html};

use super::chart::{Chart, standalone_svg};
use super::figure::file_links;
use super::map::MapsSideBySide;
use super::page::{ReportFile, badge, document, json_text, page_header, reproduction};
use super::paper_charts::charts;
use super::paper_maps::{self, overview, variants};
use super::paper_tables::{
    findings, path_table, reduction_table, run_table, step_table, summary_table,
};
use crate::bench::paper::{Site, TaskRuns};
use crate::experiment::TrafficKind;
use crate::experiment::paper_drives::{
    Course, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD, PaperTable,
};
use crate::robot::Footprint;
use crate::runtime::Trace;

const TITLE: &str = "inbye: the paper's experiments";

/// The first figure of the paper that shows a scene.
const FIRST_SCENE_FIGURE: usize = 9;
/// Paths of fig. 16.
const CLOSE_UPS: usize = 2;

const INTRO: &str = "The experiments of the paper (Gu, Liu, Li, Yuan and Bao: hybrid path planning of an underground inspection \
    robot by improved A* and DWA), with its published values for comparison. Its maps are not published: the scenes are this \
    project's own, of the same size.\n\n\
    Traditional is textbook A* with the Manhattan or the Euclidean distance, its path as searched. Improved is the paper's: \
    octile distance with a pull to the start-goal line (eq. 19 made scale-free), redundant nodes removed by line of sight, a \
    B-spline. Literal is the improved variant with eq. 19 as published. Jump points is this project's: an exact search in place \
    of A*.\n\n\
    All variants search the same free cells, which are farther from every obstacle than the preferred distance of the default \
    robot. A smoothed path is proved to keep the least distance. Turns are counted before smoothing. Times are medians; the \
    variants run alternately.\n\n\
    Then the robot drives through the three scenes in closed loop, from a yaw of pi/4 to a goal with the same yaw. Lidar, base \
    and pedestrians are simulated; the pedestrians are on no map. Deviations are those of the true final pose, along the axes of \
    the start pose. Every number of a drive follows from its seed.";

/// The content of the page.
#[derive(Clone, Debug)]
pub struct PaperReport<'a> {
    /// A paragraph before the introduction, such as that runs are missing; empty for none.
    pub note: &'a str,
    /// Processor and system of the measurements.
    pub machine: &'a str,
    /// The command that repeats the experiments.
    pub command: &'a str,
    /// The scenes of Table 1, each with its task.
    pub roadways: Vec<(&'a Site, &'a TaskRuns)>,
    /// The mine of Table 2.
    pub mine: (&'a Site, &'a [TaskRuns]),
    /// The scenes of the drives; empty without drives.
    pub courses: &'a [Course],
    /// One drive on each course for each kind of traffic.
    pub traces: &'a [(TrafficKind, Trace)],
    /// The footprint of the robot.
    pub footprint: &'a Footprint,
    /// The tables.
    pub tables: &'a [PaperTable],
    /// Violations of what every path and drive must satisfy, a sentence each.
    pub faults: &'a [String],
}

/// A table of the paper with its maps and charts.
struct Section<'a> {
    table: &'a PaperTable,
    maps: Vec<MapsSideBySide>,
    charts: Vec<Chart>,
}

/// Returns the files of a report: the page `paper.html`; each table as CSV with the published values, and as JSON with all
/// digits; the maps and charts as SVG. The page needs none of the other files.
#[must_use]
pub fn paper_files(report: &PaperReport) -> Vec<ReportFile> {
    let mut files = Vec::new();
    let content = html! {
        (page_header(TITLE, &format!("{}\n\n{INTRO}", report.note), report.machine, &html! {}))
        (summary(report))
        @for section in report.tables.iter().map(|table| Section::new(report, table)) {
            @let of_section = section.files();
            (section.markup())
            (file_links(&of_section))
            @let () = files.extend(of_section);
        }
        (reproduction(report.command))
    };
    let page = document(TITLE, include_str!("paper.css"), "", &content);
    files.insert(0, ReportFile::new("paper.html", page));
    files
}

/// Whether paths and drives are sound, and whether they reach the reductions of the paper.
fn summary(report: &PaperReport) -> Markup {
    let is_sound = report.faults.is_empty();
    let verdict = if is_sound {
        "every path keeps its distance from obstacles, every exact search found a shortest path, and every drive ended at its \
         goal without contact"
    } else {
        "some paths or drives violate their conditions"
    };
    html! {
        section id="verdict" {
            h2 { "Summary" }
            p { (badge(is_sound, verdict)) }
            @if !is_sound { (findings(report.faults)) }
            @for table in report.tables {
                @if let PaperTable::Paths(table) = table {
                    @if !table.reductions.is_empty() { h3 { (table.title) } (reduction_table(table)) }
                }
            }
            p class="machine" {
                "✓: at least the reduction of the paper. Where one of its tables has none, that of the other counts."
            }
            @for table in report.tables {
                @match table {
                    PaperTable::Paths(_) => {}
                    PaperTable::Ablation(table) => { h3 { (table.title) } (findings(&table.findings)) }
                    PaperTable::Drives(table) => { (drive_summary(table)) }
                }
            }
        }
    }
}

fn drive_summary(table: &DriveTable) -> Markup {
    let acceptance = &table.acceptance;
    let choose = |is_met, met, unmet| badge(is_met, if is_met { met } else { unmet });
    let within = if acceptance.means_within_limits { "within" } else { "not within" };
    let means = format!(
        "mean deviations {within} {MEAN_LIMIT_M} m and {MEAN_LIMIT_RAD} rad in every scene"
    );
    html! {
        h3 { (table.title) }
        p {
            (choose(acceptance.all_reached, "every drive reached its goal", "not every drive reached its goal")) " "
            (choose(acceptance.no_contact, "no contact", "contact")) " "
            (badge(acceptance.means_within_limits, &means))
        }
        (findings(&table.findings))
    }
}

impl<'a> Section<'a> {
    fn new(report: &PaperReport, table: &'a PaperTable) -> Self {
        let maps = match table {
            PaperTable::Paths(table) if table.name == "table_1" => scene_maps(report),
            PaperTable::Paths(table) if table.name == "table_2" => mine_maps(report),
            PaperTable::Drives(table) => vec![drive_maps(report, table)],
            PaperTable::Paths(_) | PaperTable::Ablation(_) => Vec::new(),
        };
        Self { table, maps, charts: charts(table) }
    }

    /// The table, the maps and the charts.
    fn files(&self) -> Vec<ReportFile> {
        let name = self.table.name();
        let csv = match self.table {
            PaperTable::Paths(table) => path_table(table),
            PaperTable::Ablation(table) => step_table(table),
            PaperTable::Drives(table) => run_table(table),
        }
        .csv();
        let maps = self.maps.iter().map(|map| (map.name.as_str(), "svg", map.standalone_svg()));
        let charts =
            (!self.charts.is_empty()).then(|| (name, "svg", standalone_svg(&self.charts, "")));
        let files = [(name, "csv", csv), (name, "json", json_text(self.table))];
        let files = files.into_iter().chain(maps).chain(charts);
        files
            .map(|(name, ending, text)| ReportFile::new(format!("{name}.{ending}"), text))
            .collect()
    }

    fn markup(&self) -> Markup {
        // The maps of a table share the legend of the last one.
        let last = self.maps.len().saturating_sub(1);
        let (title, tables) = match self.table {
            PaperTable::Paths(table) => {
                let tables = html! {
                    div class="tall" { (path_table(table).markup()) }
                    // The findings of the other tables are a table of reductions in the summary.
                    @if table.reductions.is_empty() { (findings(&table.findings)) }
                };
                (&table.title, tables)
            }
            PaperTable::Ablation(table) => {
                (&table.title, html! { div class="tall steps" { (step_table(table).markup()) } })
            }
            PaperTable::Drives(table) => {
                let tables = html! {
                    div class="tall steps" { (summary_table(table).markup()) }
                    div class="tall steps narrow" { (run_table(table).markup()) }
                };
                (&table.title, tables)
            }
        };
        html! {
            section id=(self.table.name()) {
                h2 { (title) }
                @for (index, map) in self.maps.iter().enumerate() { (map.figure(index == last)) }
                @if !self.charts.is_empty() {
                    div class="charts" { @for chart in &self.charts { (chart.figure()) } }
                }
                (tables)
            }
        }
    }
}

fn scene_maps(report: &PaperReport) -> Vec<MapsSideBySide> {
    let scenes = report.roadways.iter().enumerate();
    scenes
        .map(|(index, (site, task))| {
            let number = FIRST_SCENE_FIGURE + index;
            let title = format!("Fig. {number}, environment {}: {}", index + 1, site.title);
            variants(&format!("figure_{number}"), title, site, task)
        })
        .collect()
}

fn mine_maps(report: &PaperReport) -> Vec<MapsSideBySide> {
    let (site, tasks) = report.mine;
    let all = "All five paths: traditional with Manhattan distance, and jump points with pruning and spline";
    let close_ups = tasks.iter().take(CLOSE_UPS).enumerate().map(|(index, task)| {
        let title = format!("Fig. 16: {}", task.task.name);
        variants(&format!("figure_16_{}", index + 1), title, site, task)
    });
    [overview("mine", all, site, tasks)].into_iter().chain(close_ups).collect()
}

/// The drives with one kind of traffic.
fn drive_maps(report: &PaperReport, table: &DriveTable) -> MapsSideBySide {
    let of_table = report.traces.iter().filter(|(traffic, _)| *traffic == table.traffic);
    let shown = of_table.map(|(_, trace)| trace);
    let names = match table.traffic {
        TrafficKind::None => ["figure_12", "Fig. 12: no pedestrians"],
        TrafficKind::Yielding
        | TrafficKind::Appearing
        | TrafficKind::Starting
        | TrafficKind::SteppingOut => ["figure_13", "Fig. 13: pedestrians that stop for the robot"],

        TrafficKind::NonYielding => {
            ["figure_13_non_yielding", "Fig. 13 again: pedestrians that ignore the robot"]
        }
    };
    paper_maps::drives(names, report.courses, shown, report.footprint)
}
