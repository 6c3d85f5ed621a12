//! `inbye bench`.

use anyhow::bail;
use inbye::bench::{
    Density, DensityPlan, QualityPlan, QualityRow, crossovers, measure_density, measure_quality,
};
use inbye::local::{CpuEngine, Engine};
use inbye::report::{BenchReport, bench_files, bench_svg};
use serde_json::json;

use super::arguments::DensityArguments;
use super::output_file::Output;
use super::process::wall_clock;
use super::{closed_loop, density_text, engines, output, output_file, report_file};

const TITLE: &str = "inbye: sampling density";
const INTRO: &str = "One decision of the dynamic window with more and more samples, on every engine of this machine: its time from \
    end to end, the regret of its command against the densest sampling, and the effect in a closed loop. All engines return \
    the same bits, which is checked before they are timed.";

/// Number of samples of the reference sampling, unless more are measured.
const DENSEST: usize = 1 << 20;
/// Windows in which commands are compared, seconds: that of a control loop at 10 Hz, and a wide one.
const WINDOWS_S: [f64; 2] = [0.1, 1.0];
/// Ratios of forward speeds to turn rates.
const SHAPES: [f64; 2] = [1.0, 0.25];

/// Measures latency and quality over sampling density.
pub fn density(arguments: &DensityArguments, json: bool) -> anyhow::Result<bool> {
    let (least, most) = (arguments.min_samples, arguments.max_samples);
    if least > most {
        bail!(
            "--min-samples {least} is above --max-samples {most}: lower the one or raise the other"
        );
    }
    let table = Output::create("--record", arguments.record.as_deref(), &["csv", "json"])?;
    let losses =
        Output::create("--record-quality", arguments.record_quality.as_deref(), &["csv", "json"])?;
    let chart = Output::create("--chart", arguments.chart.as_deref(), &["svg"])?;
    if let Some(folder) = &arguments.report {
        report_file::create_folder(folder)?;
    }
    let plan = DensityPlan::powers_of_four(arguments.steps, least, most, arguments.seconds);
    let mut all = with_every_thread_count(engines::all()?, engines::cores())?;
    let Density { rows, skipped } = measure(&mut all, &plan)?;
    let quality = compare(&plan, most.max(DENSEST), arguments.ticks)?;
    let closed_loop = closed_loop::drive(
        arguments.missions,
        most,
        &SHAPES,
        arguments.record_missions.as_deref(),
    )?;
    let crossovers = crossovers(&rows);
    if let Some(table) = table {
        output_file::write_rows(table, &rows)?;
    }
    if let Some(losses) = losses {
        output_file::write_rows(losses, &quality)?;
    }
    if let Some(chart) = chart {
        chart.write(bench_svg(&BenchReport {
            density: &rows,
            quality: &quality,
            closed_loop: &closed_loop,
            ..BenchReport::default()
        }))?;
    }
    if let Some(folder) = &arguments.report {
        let files = bench_files(&BenchReport {
            title: TITLE,
            intro: INTRO,
            machine: &engines::machine(),
            command: &report_file::command_line(),
            density: &rows,
            skipped: &skipped,
            quality: &quality,
            closed_loop: &closed_loop,
            ..BenchReport::default()
        });
        report_file::write_files(folder, &files)?;
    }
    if json {
        output::json(&json!({
            "rows": rows,
            "skipped": skipped,
            "crossover": crossovers,
            "quality": quality,
            "closed_loop": closed_loop,
        }))?;
        return Ok(true);
    }
    density_text::density(&rows, &skipped, &crossovers)
        .iter()
        .chain(&density_text::quality(&quality))
        .chain(&closed_loop::text(&closed_loop))
        .for_each(output::line);
    Ok(true)
}

/// Adds CPU engines of 2, 4, 8... threads, fewer than cores, after the single-threaded one.
fn with_every_thread_count(
    mut all: Vec<Box<dyn Engine>>,
    cores: usize,
) -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let doubled = std::iter::successors(Some(2_usize), |threads| threads.checked_mul(2));
    for (place, threads) in doubled.take_while(|&threads| threads < cores).enumerate() {
        let engine = CpuEngine::with_threads(threads)?;
        all.insert((place + 1).min(all.len()), Box::new(engine));
    }
    Ok(all)
}

/// Measures with a progress bar.
pub fn measure(all: &mut [Box<dyn Engine>], plan: &DensityPlan) -> anyhow::Result<Density> {
    let cells = plan.samples.len() * all.len();
    let bar = output::progress(cells as u64, "density");
    let density = measure_density(all, plan, &mut wall_clock(), |_| bar.inc(1))?;
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
    let below = |samples: &usize| *samples < densest;
    let samples: Vec<usize> = plan.samples.iter().copied().filter(below).collect();
    if ticks == 0 || samples.is_empty() {
        return Ok(Vec::new());
    }
    let plan = QualityPlan {
        steps: plan.steps,
        densest,
        samples,
        shapes: SHAPES.to_vec(),
        windows_s: WINDOWS_S.to_vec(),
        ticks,
    };
    let mut engine = CpuEngine::with_threads(engines::cores())?;
    let bar = output::progress((ticks * WINDOWS_S.len()) as u64, "quality");
    let rows = measure_quality(&mut engine, &plan, || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_have_every_power_of_two_of_threads_up_to_the_cores() {
        let threads = |cores: usize| -> Vec<usize> {
            let mut first: Vec<Box<dyn Engine>> = vec![Box::new(CpuEngine::single_threaded())];
            if cores > 1 {
                first.push(Box::new(CpuEngine::with_threads(cores).expect("threads")));
            }
            let all = with_every_thread_count(first, cores).expect("threads");
            all.iter().map(|engine| engine.threads()).collect()
        };
        for (cores, expected) in [
            (1, &[1][..]),
            (2, &[1, 2]),
            (3, &[1, 2, 3]),
            (8, &[1, 2, 4, 8]),
            (12, &[1, 2, 4, 8, 12]),
        ] {
            assert_eq!(threads(cores), expected, "{cores} cores");
        }
    }
}
