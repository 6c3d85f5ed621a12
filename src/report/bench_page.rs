//! The pages of the benchmarks: each chart with its table, and its rows in files beside the page.

use maud::{Markup, html};

use super::curves::Plot;
use super::figure::files_beside;
use super::own_picture::own_picture;
use super::page::{Extras, document};
use super::report_files::{ReportFile, json_text};
use super::samples_axis::samples_axis;
use super::world_runs::{of_barn, of_dynabarn};
use super::{
    ablation_chart, closed_loop_chart, density_chart, quality_chart, row_chart, soak_chart,
    sweep_chart, sweep_latency_chart, worlds_chart,
};
use crate::bench::{Columns, DensityRow, QualityRow, SkippedCell, csv_text};
use crate::experiment::{Group, RunRow};

/// Files of the first chart.
const LATENCY: &str = "latency";
/// Files of those of a soak.
const SOAK: &str = "soak";

const NOTHING: &str = "No engine was timed at any density.";

/// All that such a page shows. Without rows a section is left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct BenchReport<'a> {
    /// The page's title.
    pub title: &'a str,
    /// What a reader should know first.
    pub intro: &'a str,
    /// Where it was measured: processor, system.
    pub machine: &'a str,
    /// What repeats it.
    pub command: &'a str,
    /// Latencies.
    pub density: &'a [DensityRow],
    /// What was left out of them.
    pub skipped: &'a [SkippedCell],
    /// Regrets.
    pub quality: &'a [QualityRow],
    /// Missions with several samplings.
    pub closed_loop: &'a [Group],
    /// Runs through BARN's worlds.
    pub barn: &'a [RunRow],
    /// Runs through `DynaBARN`'s.
    pub dynabarn: &'a [RunRow],
    /// Missions of a soak.
    pub soak: &'a [RunRow],
    /// What each part of the navigator buys, from the least variant to the whole.
    pub ablation: &'a [Group],
    /// What came of a sweep.
    pub sweep: &'a [Group],
    /// Latencies that it measured.
    pub sweep_latency: &'a [RunRow],
}

/// Charts of the same rows on the page, and what their files are made of.
struct Chart {
    /// Name of its files without their endings.
    name: &'static str,
    figures: Vec<Markup>,
    plots: Vec<Plot>,
    csv: String,
    json: String,
}

/// The charts of all rows as one picture, an SVG file. It holds everything it needs.
#[must_use]
pub fn bench_svg(report: &BenchReport) -> String {
    let plots: Vec<Plot> = charts(report)
        .into_iter()
        .flat_map(|chart| chart.plots)
        .collect();
    own_picture(&plots, NOTHING)
}

/// The files of a report: `index.html`, and for each chart a picture and its rows as CSV and JSON. The page holds all it
/// shows, and can go without the others.
#[must_use]
pub fn bench_files(report: &BenchReport) -> Vec<ReportFile> {
    let charts = charts(report);
    let mut files = vec![ReportFile::new("index.html", page(report, &charts))];
    for chart in charts {
        let file = |ending: &str, text| ReportFile::new(format!("{}.{ending}", chart.name), text);
        files.extend([file("csv", chart.csv), file("json", chart.json)]);
        if !chart.plots.is_empty() {
            files.push(file("svg", own_picture(&chart.plots, NOTHING)));
        }
    }
    files
}

fn charts(report: &BenchReport) -> Vec<Chart> {
    let samples = samples_axis(report.density, report.quality, report.closed_loop);
    let (density, quality, closed_loop) = (report.density, report.quality, report.closed_loop);
    let (barn, dynabarn) = (of_barn(report.barn), of_dynabarn(report.dynabarn));
    let charts = [
        chart(LATENCY, density, |rows| {
            one(
                density_chart::figure(rows, samples),
                density_chart::plot(rows, samples),
            )
        }),
        chart("quality", quality, |rows| {
            one(
                quality_chart::figure(rows, samples),
                quality_chart::plot(rows, samples),
            )
        }),
        chart("closed_loop", closed_loop, |rows| {
            one(
                closed_loop_chart::figure(rows, samples),
                closed_loop_chart::plot(rows, samples),
            )
        }),
        chart("barn", report.barn, |_| {
            one(worlds_chart::figure(&barn), worlds_chart::plot(&barn))
        }),
        chart("dynabarn", report.dynabarn, |_| {
            one(
                worlds_chart::figure(&dynabarn),
                worlds_chart::plot(&dynabarn),
            )
        }),
        chart(SOAK, report.soak, |rows| {
            (soak_chart::figures(rows), soak_chart::plots(rows))
        }),
        chart("ablation", report.ablation, |rows| {
            (ablation_chart::figures(rows), ablation_chart::plots(rows))
        }),
    ];
    let sweeps = sweep_chart::by_kind(report.sweep);
    let sweeps = sweeps.iter().filter_map(|of| {
        let draw = |_: &[Group]| one(of.figure(), of.plot());
        chart(of.file(), &of.rows(), draw)
    });
    let times = chart("latency-groups", report.sweep_latency, |rows| {
        one(
            sweep_latency_chart::figure(rows),
            sweep_latency_chart::plot(rows),
        )
    });
    charts
        .into_iter()
        .flatten()
        .chain(sweeps)
        .chain(times)
        .collect()
}

fn one(figure: Markup, plot: Option<Plot>) -> (Vec<Markup>, Vec<Plot>) {
    (vec![figure], plot.into_iter().collect())
}

fn chart<R: Columns>(
    name: &'static str,
    rows: &[R],
    draw: impl Fn(&[R]) -> (Vec<Markup>, Vec<Plot>),
) -> Option<Chart> {
    if rows.is_empty() {
        return None;
    }
    let (figures, plots) = draw(rows);
    Some(Chart {
        name,
        figures,
        plots,
        csv: csv_text(rows),
        json: json_text(rows),
    })
}

fn page(report: &BenchReport, charts: &[Chart]) -> String {
    let content = html! {
        header {
            h1 { (report.title) }
            @if !report.intro.is_empty() { p { (report.intro) } }
            @if !report.machine.is_empty() { p class="machine" { "Measured on: " (report.machine) } }
        }
        section {
            div class="charts" {
                @for chart in charts {
                    // Several figures of the same rows stand beside one another, their files below all.
                    div class=[(chart.figures.len() > 1).then_some("whole-row")] {
                        div class=[(chart.figures.len() > 1).then_some("charts")] {
                            @for figure in &chart.figures { (figure) }
                        }
                        (files_beside(chart.name, if chart.plots.is_empty() { &["csv", "json"] } else { &["csv", "json", "svg"] }))
                    }
                    @if chart.name == SOAK { (soak_chart::missed(report.soak)) }
                    @if chart.name == LATENCY { (density_chart::beside(report.density, report.skipped)) }
                }
            }
            @if charts.is_empty() { p class="nothing" { (NOTHING) } }
        }
        section {
            h2 { "The same again" }
            pre tabindex="0" { code { (report.command) } }
        }
    };
    document(report.title, &Extras::of_style(row_chart::STYLE), &content)
}
