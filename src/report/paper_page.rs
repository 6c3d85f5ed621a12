//! The page of the paper's experiments, repeated.

use maud::{Markup, html};

use super::curves::Plot;
use super::figure::linked_files;
use super::map_figure::MapFigure;
use super::mission::badge;
use super::own_picture::own_picture;
use super::page::{Extras, document};
use super::paper_charts::{figures, plots};
use super::paper_drives;
use super::paper_maps::{overview, side_by_side};
use super::paper_tables::{findings, path_table, reduction_table, step_table};
use super::report_files::{ReportFile, json_text};
use crate::bench::paper::{AblationTable, PathTable, Site, TaskRuns};
use crate::experiment::paper_drives::{Course, Drives, PaperTable as Table};
use crate::robot::Footprint;

const OWN_STYLE: &str = concat!(
    include_str!("paper.css"),
    include_str!("paper_maps.css"),
    include_str!("paper_charts.css")
);

/// Figures of the paper that show the scenes.
const FIRST_SCENE_FIGURE: usize = 9;
/// Paths of fig. 16.
const CLOSE_UPS: usize = 2;

const INTRO: [&str; 4] = [
    "The paper's experiments (Gu, Liu, Li, Yuan and Bao: hybrid path planning of an underground \
     inspection robot by improved A* and DWA), run here beside its printed values. Its maps are not published: the scenes \
     are this project's own, of the same size.",
    "Traditional is A* from the textbook with the Manhattan or the Euclidean distance, its path as searched. Improved is the \
     paper's: octile distance with a pull to the start-goal line (eq. 19 made scale-free), redundant nodes removed by line of \
     sight, a B-spline. Literal is the same with eq. 19 as printed. Jump points is ours: an exact search \
     in place of A*.",
    "All variants search the same free cells, at the comfortable distance of the default robot from every obstacle, and a \
     smoothed path is proved to keep the least distance. Turns are counted before smoothing. Times are medians, all variants in \
     turn.",
    "Then the three scenes are driven in closed loop, from a yaw of pi/4 to a goal with the same yaw: simulated lidar, base and \
     people, who are on no map. Deviations are those of the true final pose, along the axes of the start pose. Every \
     number of a drive follows from its seed.",
];

/// All that the page shows.
#[derive(Clone, Debug)]
pub struct PaperReport<'a> {
    /// Where the times were measured: processor, system.
    pub machine: &'a str,
    /// What repeats the run.
    pub command: &'a str,
    /// The scenes of Table 1, each with its one task.
    pub roadways: Vec<(&'a Site, &'a TaskRuns)>,
    /// The mine of Table 2.
    pub mine: (&'a Site, &'a [TaskRuns]),
    /// The scenes as they are driven through; none without drives.
    pub courses: &'a [Course],
    /// The drives, those of each kind of traffic together.
    pub drives: &'a [Drives],
    /// The shape of the robot that drove.
    pub footprint: &'a Footprint,
    /// The tables.
    pub tables: &'a [Table],
    /// What must not be, a sentence each.
    pub faults: &'a [String],
}

/// The page, `paper.html`, which holds everything it needs; each of its tables, the paper's values among ours, as CSV and
/// with all its digits as JSON; and its maps and charts as SVG pictures.
#[must_use]
pub fn paper_files(report: &PaperReport) -> Vec<ReportFile> {
    let shown: Vec<Shown> = report
        .tables
        .iter()
        .map(|table| Shown::of(report, table))
        .collect();
    let mut files = vec![ReportFile::new("paper.html", page(report, &shown))];
    for shown in &shown {
        let table = shown.table;
        let csv = match table {
            Table::Paths(table) => path_table(table),
            Table::Ablation(table) => step_table(table),
            Table::Drives(table) => paper_drives::run_table(table),
        }
        .csv();
        let file = |ending: &str, text| ReportFile::new(format!("{}.{ending}", table.name()), text);
        files.extend([file("csv", csv), file("json", json_text(table))]);
        files.extend(shown.pictures());
    }
    files
}

fn page(report: &PaperReport, shown: &[Shown]) -> String {
    let title = "inbye: the paper's experiments, repeated";
    let content = html! {
        header {
            h1 { (title) }
            @for paragraph in INTRO { p { (paragraph) } }
            p class="machine" { "Measured on: " (report.machine) }
        }
        (verdict(report))
        @for shown in shown {
            (shown.section())
            (shown.files())
        }
        section {
            h2 { "The same again" }
            pre tabindex="0" { code { (report.command) } }
        }
    };
    document(title, &Extras::of_style(OWN_STYLE), &content)
}

/// Whether paths and drives are what they should be, and whether the paper's reductions are reached.
fn verdict(report: &PaperReport) -> Markup {
    let is_sound = report.faults.is_empty();
    html! {
        section id="verdict" {
            h2 { "In short" }
            p { (badge(is_sound, if is_sound {
                "every path keeps its distance from obstacles, every exact search found a shortest one, \
                 no drive ran into anything or got stuck"
            } else {
                "there are paths or drives that should not be"
            })) }
            @if !is_sound { (findings(report.faults)) }
            @for table in report.tables {
                @if let Table::Paths(table) = table {
                    @if !table.reductions.is_empty() {
                        h3 { (table.title) }
                        (reduction_table(table))
                    }
                }
            }
            p class="machine" { "✓ at least the paper's reduction; where one of its tables prints none, that of the other." }
            @for table in report.tables {
                @if let Table::Ablation(table) = table {
                    h3 { (table.title) }
                    (findings(&table.findings))
                }
            }
            (paper_drives::in_short(report))
        }
    }
}

/// A table of the paper, and the pictures that belong to it.
struct Shown<'a> {
    table: &'a Table,
    maps: Vec<MapFigure>,
    charts: Vec<Plot>,
}

impl<'a> Shown<'a> {
    fn of(report: &PaperReport, table: &'a Table) -> Self {
        let maps = match table {
            Table::Paths(table) if table.name == "table_1" => scenes(report),
            Table::Paths(table) if table.name == "table_2" => mine(report),
            Table::Drives(table) => vec![paper_drives::maps(report, table)],
            Table::Paths(_) | Table::Ablation(_) => Vec::new(),
        };
        Self {
            table,
            maps,
            charts: plots(table),
        }
    }

    /// Names and texts of the SVG files.
    fn pictures(&self) -> impl Iterator<Item = ReportFile> {
        let maps = self
            .maps
            .iter()
            .map(|map| (map.name.as_str(), map.picture()));
        let charts =
            (!self.charts.is_empty()).then(|| (self.table.name(), own_picture(&self.charts, "")));
        maps.chain(charts)
            .map(|(name, text)| ReportFile::new(format!("{name}.svg"), text))
    }

    fn section(&self) -> Markup {
        // Maps of one table have the same marks: one legend, below the last.
        let last = self.maps.len().saturating_sub(1);
        let pictures = html! {
            @for (index, map) in self.maps.iter().enumerate() { (map.markup(index == last)) }
            (figures(&self.charts))
        };
        match self.table {
            Table::Paths(table) => paths(table, &pictures),
            Table::Ablation(table) => steps(table, &pictures),
            Table::Drives(table) => paper_drives::section(table, &pictures),
        }
    }

    /// Links to all files.
    fn files(&self) -> Markup {
        let name = self.table.name();
        let mut files = vec![format!("{name}.csv"), format!("{name}.json")];
        files.extend(self.maps.iter().map(|map| format!("{}.svg", map.name)));
        if !self.charts.is_empty() {
            files.push(format!("{name}.svg"));
        }
        linked_files(&files)
    }
}

fn scenes(report: &PaperReport) -> Vec<MapFigure> {
    let scenes = report.roadways.iter().enumerate();
    scenes
        .map(|(index, (site, task))| {
            let number = FIRST_SCENE_FIGURE + index;
            let title = format!("Fig. {number}, environment {}: {}", index + 1, site.title);
            side_by_side(&format!("figure_{number}"), title, site, task)
        })
        .collect()
}

fn mine(report: &PaperReport) -> Vec<MapFigure> {
    let (site, tasks) = report.mine;
    let all = "All five ways: traditional, Manhattan, and jump points with pruning and spline";
    let close_ups = tasks
        .iter()
        .take(CLOSE_UPS)
        .enumerate()
        .map(|(index, task)| {
            let title = format!("Fig. 16: {}", task.task.name);
            side_by_side(&format!("figure_16_{}", index + 1), title, site, task)
        });
    [overview("mine", all, site, tasks)]
        .into_iter()
        .chain(close_ups)
        .collect()
}

fn paths(table: &PathTable, pictures: &Markup) -> Markup {
    html! {
        section id=(table.name) {
            h2 { (table.title) }
            (pictures)
            div class="whole" { (path_table(table).markup()) }
            // Those of the others stand at the top, as a table of reductions.
            @if table.reductions.is_empty() { (findings(&table.findings)) }
        }
    }
}

fn steps(table: &AblationTable, pictures: &Markup) -> Markup {
    html! {
        section id=(table.name) {
            h2 { (table.title) }
            (pictures)
            div class="whole steps" { (step_table(table).markup()) }
        }
    }
}
