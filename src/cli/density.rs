//! `inbye bench density`: sampling density against latency, quality of the command, and success in a closed loop.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use inbye::bench::{
    BatchRow, Density, DensityPlan, DensityRow, LostEngine, QualityPlan, QualityRow, crossovers,
    measure_batches, measure_density, measure_quality, named_sampler, text_table, usual_shape,
};
use inbye::experiment::missions::Rules;
use inbye::experiment::{Grid, Group, RunRow, built_in_maps, groups, sampling_setups};
use inbye::local::{CpuEngine, CpuEngines, Engine, LocalSettings, Sampler};
use inbye::report::{BenchReport, bench_svg};
use inbye::runtime::Config;
use serde_json::json;

use super::arguments::{duration, whole};
use super::files::{Output, ReportFolder, all_written};
use super::machine::{self, is_interrupted, wall_clock};
use super::missions::sort;
use super::output;
use super::runs::run_grid;

const TITLE: &str = "inbye: sampling density";
const INTRO: &str = "One decision of the dynamic window with more and more samples, on every engine of this machine: its time from \
    end to end, the regret of its command against the densest sampling, and the effect in a closed loop. All engines return \
    the same bits, which is checked before they are timed.";

/// Number of samples of the reference sampling, unless more are measured.
const DENSEST: usize = 1 << 20;
/// Windows in which commands are compared, seconds: that of a control loop at 10 Hz, and a wide one.
const WINDOWS_S: [f64; 2] = [0.1, 1.0];
/// Samplers in closed loop, with ratios of forward speeds to turn rates.
const CLOSED_LOOP_SAMPLERS: [(Sampler, f64); 3] = [
    (Sampler::Arcs, 1.0),
    (Sampler::Arcs, 0.25),
    (Sampler::TwoSegments, usual_shape(Sampler::TwoSegments)),
];
/// Steps of the horizon in which commands are compared, 0.1 s each.
const QUALITY_STEPS: u32 = 20;

/// Smallest and largest number of samples in a closed loop: with fewer no robot arrives, with more a mission takes too long.
const CLOSED_LOOP_SAMPLES: (usize, usize) = (64, 16_384);
/// Longest path of a mission, metres.
const LONGEST_M: f64 = 30.0;
/// Seed of the first mission.
const SEED: u64 = 1;

/// Columns of the text table of the closed loop.
const CLOSED_LOOP: &str = "config samples vx_samples vtheta_samples runs reached contacts mean_time_ratio \
    mean_clearance_reached_m omega_sign_changes_per_m time_lost_per_person_s tick_p50_ms tick_p99_ms";

/// `inbye bench density`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench density --max-samples 16384 --seconds 0.1 --ticks 10 --missions 0 --chart density.svg\n\n\
    Latency is that of a decision from end to end; the engines' answers are compared bit for bit first. An engine that is too slow \
    for a density is skipped there, and listed. A GPU that fails is listed as `lost`; the others are still measured.\n\
    Batches: the decisions of 1, 8, 64, 256 and 1,024 robots in one call, 1,024 arcs each.\n\
    Quality: the regret is the loss of score against the densest sampling (1,048,576 samples of two segments, or --max-samples \
    if larger), as a share of the best sample's gain over the mean admissible one. It is measured over a horizon of 2 s, with \
    windows of 0.1 s and 1 s.\n\
    Closed loop: the same random missions of at most 30 m on built-in maps with 64, 256... samples, up to 16,384 or \
    --max-samples. The tick time is that of the whole navigator (scan, local field and decision) on one core; the 99th \
    percentile includes waiting for new paths.\n\
    Exit status 1: a GPU was lost, or Ctrl-C came. The finished measurements are written."
)]
pub struct DensityArguments {
    /// Steps of the horizon.
    #[arg(long, default_value_t = 40, allow_negative_numbers = true, value_parser = whole::<u32>(1, 1023))]
    pub steps: u32,
    /// Smallest number of samples; the others are 4, 16, 64... times this number.
    #[arg(long, default_value_t = 256, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub min_samples: usize,
    /// Largest number of samples.
    #[arg(long, default_value_t = 1_048_576, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub max_samples: usize,
    /// Measuring time per engine and density, seconds; slow engines take up to 20 times as long.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = duration)]
    pub seconds: f64,
    /// Decisions whose commands are compared with those of the densest sampling; 0 skips the comparison.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub ticks: usize,
    /// Random missions driven with each sampling, one after the other on one core; 0 skips them.
    #[arg(long, default_value_t = 12, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100_000))]
    pub missions: usize,
    /// Do not measure batches of 1 to 1,024 decisions.
    #[arg(long)]
    pub no_batches: bool,
    /// Write the latency rows into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write the regret rows into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record_quality: Option<PathBuf>,
    /// Write a row for each mission and sampling into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record_missions: Option<PathBuf>,
    /// Draw latency, regret, and closed-loop success and time over the number of samples into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub chart: Option<PathBuf>,
    /// Write `index.html` into this folder, with each chart as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Measures latency and quality over sampling density.
pub fn run(arguments: &DensityArguments) -> anyhow::Result<bool> {
    let (least, most) = (arguments.min_samples, arguments.max_samples);
    if least > most {
        bail!(
            "--min-samples {least} is above --max-samples {most}: lower the one or raise the other"
        );
    }
    let record = Output::of_rows::<DensityRow>("--record", arguments.record.as_deref())?;
    let losses =
        Output::of_rows::<QualityRow>("--record-quality", arguments.record_quality.as_deref())?;
    let missions = arguments.record_missions.as_deref();
    if let Some(name) = missions.filter(|_| arguments.missions == 0) {
        let name = name.display();
        bail!("--record-missions {name}: --missions 0 drives none: raise it or leave one out");
    }
    let missions = Output::of_rows::<RunRow>("--record-missions", missions)?;
    let chart = Output::create("--chart", arguments.chart.as_deref(), &["svg"])?;
    let folder = ReportFolder::create(arguments.report.as_deref())?;
    let plan = DensityPlan {
        samplers: Sampler::ALL.to_vec(),
        ..DensityPlan::powers_of_four(arguments.steps, least, most, arguments.seconds)
    };
    let mut all = machine::engines(CpuEngines::Doubling)?.open;
    machine::interrupt_flag()?;
    let mut density = measure(&mut all, &plan)?;
    let batches = if arguments.no_batches || is_interrupted() {
        Vec::new()
    } else {
        measure_batches(&mut all, &plan, &mut density.lost, &mut wall_clock(), next)?
    };
    let quality = compare(&plan, most.max(DENSEST), arguments.ticks)?;
    let (driven, closed_loop) = drive(arguments.missions, most)?;
    let object = json!({
        "rows": density.rows,
        "skipped": density.skipped,
        "lost": density.lost,
        "crossover": crossovers(&density.rows),
        "batches": batches,
        "quality": quality,
        "closed_loop": closed_loop,
    });
    let mut lines = text(&density, &quality);
    if !batches.is_empty() {
        let title = "Batches: the decisions of many robots in one call.";
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(text_table(&batches, BatchRow::SUMMARY));
    }
    if !closed_loop.is_empty() {
        let title = "The same missions in closed loop; a tick is scan, local field and decision, on one core.";
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(text_table(&closed_loop, CLOSED_LOOP));
    }
    output::result(&object, lines)?;
    let report = BenchReport {
        title: TITLE,
        intro: INTRO,
        density: &density.rows,
        skipped: &density.skipped,
        quality: &quality,
        closed_loop: &closed_loop,
        ..BenchReport::default()
    };
    let written = all_written([
        record.write_rows(&density.rows),
        losses.write_rows(&quality),
        missions.write_rows(&driven),
        chart.write(|| bench_svg(&report)),
        folder.write_bench(report),
    ]);
    if is_interrupted() {
        output::warn("interrupted: measurements are missing; the finished ones are written");
    }
    written?;
    Ok(density.lost.is_empty() && !is_interrupted())
}

/// Whether the next measurement begins: Ctrl-C ends a benchmark after the one in progress.
fn next() -> ControlFlow<()> {
    if is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Measures with a progress bar.
pub fn measure(all: &mut [Box<dyn Engine>], plan: &DensityPlan) -> anyhow::Result<Density> {
    let cells = plan.samplers.len() * plan.samples.len() * all.len();
    let bar = output::progress(cells as u64, "density", "measurements");
    let density = measure_density(all, plan, &mut wall_clock(), |_| {
        bar.inc(1);
        next()
    })?;
    bar.finish_and_clear();
    Ok(density)
}

/// Compares the commands of the plan's densities with those of a denser sampling, with a progress bar. Only the CPU engine
/// is used, since [`measure_density`] checks that all engines return the same bits. Without decisions there are no rows.
pub fn compare(
    plan: &DensityPlan,
    densest: usize,
    ticks: usize,
) -> anyhow::Result<Vec<QualityRow>> {
    let mut samples = plan.samples.clone();
    samples.retain(|samples| *samples < densest);
    if ticks == 0 || samples.is_empty() || is_interrupted() {
        return Ok(Vec::new());
    }
    let bar = output::progress((ticks * WINDOWS_S.len()) as u64, "quality", "decisions");
    let plan = QualityPlan {
        steps: QUALITY_STEPS,
        densest,
        samples,
        samplers: Sampler::ALL.map(|sampler| (sampler, usual_shape(sampler))).to_vec(),
        windows_s: WINDOWS_S.to_vec(),
        ticks,
    };
    let mut engine = CpuEngine::with_threads(machine::cores())?;
    let rows = measure_quality(&mut engine, &plan, || {
        bar.inc(1);
        next()
    })?;
    bar.finish_and_clear();
    Ok(rows)
}

/// Drives this many missions with each sampling of at most `most` samples, one at a time, since ticks are timed. Without
/// missions there are no rows and no groups.
fn drive(missions: usize, most: usize) -> anyhow::Result<(Vec<RunRow>, Vec<Group>)> {
    if missions == 0 || is_interrupted() {
        return Ok((Vec::new(), Vec::new()));
    }
    let config = Config::default();
    let (least, most) = (CLOSED_LOOP_SAMPLES.0.min(most), CLOSED_LOOP_SAMPLES.1.min(most));
    let samples = DensityPlan::powers_of_four(config.local.steps(), least, most, 1.0).samples;
    let worlds = built_in_maps(Rules { longest_m: LONGEST_M, ..Rules::default() });
    let setups = sampling_setups(&config, &samples, &CLOSED_LOOP_SAMPLERS);
    let grid = Grid::of_missions("closed loop", &worlds, &setups, missions, SEED)?;
    let mut rows = run_grid(&grid, None, 1)?;
    sort(&mut rows);
    let mut groups = groups(&rows);
    groups.sort_by_key(|group| {
        let is_own = |local: &LocalSettings| {
            let name = (local.sampler != Sampler::Arcs).then(|| local.sampler.name());
            (local.vx_samples, local.vtheta_samples) == (group.vx_samples, group.vtheta_samples)
                && name == group.config.as_deref()
        };
        setups.iter().position(|setup| is_own(&setup.config.local))
    });
    Ok((rows, groups))
}

/// The table of latencies, the skipped cells, the GPUs that failed, where GPUs overtake the CPU, and the table of regrets if commands
/// were compared.
pub fn text(Density { rows, skipped, lost, .. }: &Density, quality: &[QualityRow]) -> Vec<String> {
    let mut lines = text_table(rows, DensityRow::SUMMARY);
    lines.extend(skipped.iter().map(|cell| {
        let (samples, reason) = (cell.samples, &cell.reason);
        let name = named_sampler(&cell.name, &cell.sampler);
        format!("not measured: {name} with {samples} samples: {reason}")
    }));
    lines.extend(lost.iter().map(|LostEngine { name, reason }| format!("LOST: {name}: {reason}")));
    lines.extend(crossovers(rows).iter().map(ToString::to_string));
    if let Some(QualityRow { densest, decisions, .. }) = quality.first() {
        lines.push(String::new());
        lines.push(format!(
            "The command compared with the one chosen from {densest} samples, {decisions} decisions: regret 0 is equally good, \
             1 no better than a random admissible sample; then the differences of v and omega."
        ));
        lines.extend(text_table(quality, QualityRow::SUMMARY));
    }
    lines
}
