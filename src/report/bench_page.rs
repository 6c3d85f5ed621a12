//! The pages of benchmarks: charts with their tables, and the data of each chart in files next to the page.

use maud::{Markup, html};

use super::chart::{Chart, standalone_svg};
use super::figure::file_links;
use super::mission_set_charts::{self, missed_missions};
use super::number::{fixed, optional};
use super::page::{ReportFile, Tile, document, json_text, page_header, reproduction, tiles};
use super::run_charts::{Worlds, robot_contacts};
use super::sample_charts::{NO_LATENCY, SampleRows, density_notes, density_tiles};
use super::sweep_charts;
use crate::bench::{Columns, DensityRow, QualityRow, SkippedCell, csv_text};
use crate::experiment::barn::OverWorlds;
use crate::experiment::{Group, RunRow, by_settings, grouped};

/// The content of a page on benchmarks. A section without rows is left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct BenchReport<'a> {
    /// The title.
    pub title: &'a str,
    /// The introduction. An empty line starts a new paragraph.
    pub intro: &'a str,
    /// Processor and system of the measurements; empty: unknown.
    pub machine: &'a str,
    /// The command that repeats the benchmark.
    pub command: &'a str,
    /// Latencies.
    pub density: &'a [DensityRow],
    /// The cells without a latency.
    pub skipped: &'a [SkippedCell],
    /// Regrets.
    pub quality: &'a [QualityRow],
    /// Missions with several samplings.
    pub closed_loop: &'a [Group],
    /// Runs through the worlds of BARN.
    pub barn: &'a [RunRow],
    /// Runs through the worlds of `DynaBARN`.
    pub dynabarn: &'a [RunRow],
    /// Missions of a soak.
    pub soak: &'a [RunRow],
    /// Missions of wrong planners; the settings of a row say whether the protective layer was on.
    pub protection: &'a [RunRow],
    /// Variants of the navigator, each with one part more than the one before.
    pub ablation: &'a [Group],
    /// Groups of a sweep.
    pub sweep: &'a [Group],
    /// Latencies of a sweep.
    pub sweep_latency: &'a [RunRow],
}

/// Charts of the same rows, and the files of these rows.
struct Section {
    /// Name of the files without their extension.
    name: &'static str,
    tiles: Vec<Tile>,
    charts: Vec<Chart>,
    /// HTML after the charts.
    notes: Markup,
    csv: String,
    json: String,
}

impl Section {
    /// A section of rows; none without rows.
    fn new<R: Columns>(
        name: &'static str,
        rows: &[R],
        charts: impl FnOnce(&[R]) -> Vec<Chart>,
    ) -> Option<Self> {
        (!rows.is_empty()).then(|| Self {
            name,
            tiles: Vec::new(),
            charts: charts(rows),
            notes: Markup::default(),
            csv: csv_text(rows),
            json: json_text(rows),
        })
    }

    fn with_notes(self, notes: Markup) -> Self {
        Self { notes, ..self }
    }

    fn with_tiles(self, tiles: Vec<Tile>) -> Self {
        Self { tiles, ..self }
    }

    /// The files: the rows, and a picture if any chart has data.
    fn files(&self) -> Vec<ReportFile> {
        let has_picture = self.charts.iter().any(Chart::has_data);
        let svg = has_picture.then(|| ("svg", standalone_svg(&self.charts, NO_LATENCY)));
        let data = [("csv", self.csv.clone()), ("json", self.json.clone())];
        let file = |(extension, text)| ReportFile::new(format!("{}.{extension}", self.name), text);
        data.into_iter().chain(svg).map(file).collect()
    }

    /// The charts with links to the files. Several charts use the full width of the page.
    fn markup(&self, files: &[ReportFile]) -> Markup {
        let has_several = self.charts.len() > 1;
        html! {
            div class=[has_several.then_some("full-row")] {
                div class=[has_several.then_some("charts")] {
                    @for chart in &self.charts { (chart.figure()) }
                }
                (file_links(files))
            }
            (self.notes)
        }
    }
}

/// Returns the charts of all rows as one SVG file.
#[must_use]
pub fn bench_svg(report: &BenchReport) -> String {
    standalone_svg(sections(report).iter().flat_map(|section| &section.charts), NO_LATENCY)
}

/// Returns the files of a report: `index.html`, and for each section its charts as SVG and its rows as CSV and JSON. The
/// page needs none of the other files.
#[must_use]
pub fn bench_files(report: &BenchReport) -> Vec<ReportFile> {
    let mut files = Vec::new();
    let content = html! {
        (page_header(report.title, report.intro, report.machine, &html! {}))
        section {
            @let sections = sections(report);
            (tiles(&sections.iter().flat_map(|section| section.tiles.clone()).collect::<Vec<_>>()))
            div class="charts" {
                @for section in &sections {
                    @let of_section = section.files();
                    (section.markup(&of_section))
                    @let () = files.extend(of_section);
                }
            }
            @if files.is_empty() { p class="nothing" { (NO_LATENCY) } }
        }
        (reproduction(report.command))
    };
    let page = document(report.title, "", "", &content);
    files.insert(0, ReportFile::new("index.html", page));
    files
}

fn sections(report: &BenchReport) -> Vec<Section> {
    let BenchReport { density, quality, closed_loop, .. } = *report;
    let samples = SampleRows { density, quality, closed_loop };
    let sections = [
        Section::new("latency", density, |_| vec![samples.latency()])
            .map(|section| section.with_notes(density_notes(density, report.skipped)))
            .map(|section| section.with_tiles(density_tiles(density))),
        Section::new("quality", quality, |_| vec![samples.quality()]),
        Section::new("closed_loop", closed_loop, |_| vec![samples.closed_loop()]),
        Section::new("barn", report.barn, |rows| vec![barn_worlds(rows).chart()])
            .map(|section| section.with_tiles(barn_tiles(report.barn))),
        Section::new("dynabarn", report.dynabarn, |rows| vec![dynabarn_worlds(rows).chart()])
            .map(|section| section.with_tiles(run_tiles("DynaBARN", report.dynabarn))),
        Section::new("soak", report.soak, mission_set_charts::soak)
            .map(|section| section.with_notes(missed_missions(report.soak)))
            .map(|section| section.with_tiles(run_tiles("soak", report.soak))),
        Section::new("protection", report.protection, mission_set_charts::protection)
            .map(|section| section.with_tiles(protection_tiles(report.protection))),
        Section::new("ablation", report.ablation, mission_set_charts::ablation),
    ];
    let by_kind = grouped(report.sweep.iter().cloned(), |group| group.kind);
    let sweeps = by_kind.into_iter().filter_map(|(kind, groups)| {
        let (file, title) = sweep_charts::names(kind);
        Section::new(file, &groups, |groups| vec![sweep_charts::groups(title, groups)])
    });
    let latency = Section::new("latency-groups", report.sweep_latency, |rows| {
        vec![sweep_charts::latency(rows)]
    });
    sections.into_iter().flatten().chain(sweeps).chain(latency).collect()
}

/// Runs, the share that reached its goal, and contacts that the robot caused.
fn run_tiles(of: &str, rows: &[RunRow]) -> Vec<Tile> {
    let all = Group::of("", rows);
    vec![
        (format!("{of}: runs"), all.runs.to_string(), ""),
        (format!("{of}: goal reached"), fixed(100.0 * all.reached_share, 1), "%"),
        (format!("{of}: contacts by the robot"), robot_contacts(&all).to_string(), ""),
        (format!("{of}: sign changes of omega"), optional(all.omega_sign_changes_per_m, 2), "1/m"),
    ]
}

/// Missions and contacts that the robot caused, for each of the settings.
fn protection_tiles(rows: &[RunRow]) -> Vec<Tile> {
    let of_settings = |group: Group| {
        let (name, missions) = (&group.name, group.runs.to_string());
        [
            (format!("{name}: missions"), missions, ""),
            (format!("{name}: contacts by the robot"), robot_contacts(&group).to_string(), ""),
        ]
    };
    by_settings(rows).into_iter().flat_map(of_settings).collect()
}

fn barn_tiles(rows: &[RunRow]) -> Vec<Tile> {
    let (score, all) = (OverWorlds::of(rows).score, Group::of("", rows));
    let mut tiles = run_tiles("BARN", rows);
    tiles.extend([
        ("BARN: score".to_owned(), fixed(score, 4), "of 0.5"),
        ("BARN: mean time over optimal".to_owned(), optional(all.mean_time_over_optimal, 2), ""),
        (
            "BARN: 5th percentile of the smallest gaps".to_owned(),
            optional(all.clearance_p05_m, 3),
            "m",
        ),
    ]);
    tiles
}

fn barn_worlds(rows: &[RunRow]) -> Worlds<'_> {
    let (all, means) = (Group::of("", rows), OverWorlds::of(rows));
    Worlds {
        title: "BARN by world",
        time_title: "Time over the optimal time, runs that reached the goal (logarithmic)",
        level: Some((2.0, "full score up to here")),
        caption: format!(
            "{} worlds, {} runs: success {}, {} collisions, score {} of 0.5. The score of a run is OT / clip(T, 2 OT, 8 OT) if \
             it reached the goal, else 0. OT is the time of the path of the benchmark at 2 m/s.",
            all.worlds,
            all.runs,
            fixed(means.success, 3),
            all.contacts,
            fixed(means.score, 4),
        ),
        runs: rows,
        charted_time: |row| row.time_s / row.optimal_time_s.unwrap_or(f64::NAN),
    }
}

fn dynabarn_worlds(rows: &[RunRow]) -> Worlds<'_> {
    let all = Group::of("", rows);
    Worlds {
        title: "DynaBARN by world",
        time_title: "Time of the runs that reached the goal, s (logarithmic)",
        level: None,
        caption: format!(
            "{} worlds, {} runs: success {}, {} contacts. Every contact is a failure. The robot caused a contact if it closed the \
             gap itself. A contact was avoidable if a constant command from 2.5 s before it keeps clear.",
            all.worlds,
            all.runs,
            fixed(all.reached_share, 3),
            all.contacts,
        ),
        runs: rows,
        charted_time: |row| row.time_s,
    }
}
