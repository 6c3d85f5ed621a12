//! Latency over sampling density, its record, and the density from which a GPU is faster.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use inbye::bench::{Crossover, Density, DensityPlan, DensityRow, crossovers, measure_density};
use inbye::local::{CpuEngine, Detail, Engine, EngineError, Evaluation, QuantizedProblem};

/// An engine that answers like the CPU and advances a clock by a number of nanoseconds for each sample.
struct Slow {
    engine: CpuEngine,
    nanoseconds_per_sample: u64,
    clock: Arc<AtomicU64>,
}

impl Engine for Slow {
    fn name(&self) -> String {
        format!("{} ns", self.nanoseconds_per_sample)
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let nanoseconds = self.nanoseconds_per_sample * problem.len() as u64;
        self.clock.fetch_add(nanoseconds, Ordering::Relaxed);
        self.engine.evaluate(problem, detail)
    }
}

/// 4, 16 and 64 samples on such engines, half a second to each cell and 10 s at most.
fn measure(nanoseconds_per_sample: &[u64]) -> (Density, Vec<String>) {
    let clock = Arc::new(AtomicU64::new(0));
    let engine = |&nanoseconds_per_sample| -> Box<dyn Engine> {
        Box::new(Slow {
            engine: CpuEngine::single_threaded(),
            nanoseconds_per_sample,
            clock: Arc::clone(&clock),
        })
    };
    let mut engines: Vec<_> = nanoseconds_per_sample.iter().map(engine).collect();
    let plan = DensityPlan::powers_of_four(2, 4, 64, 0.5);
    let mut now = || clock.load(Ordering::Relaxed) as f64 / 1e9;
    let mut reported = Vec::new();
    let density = measure_density(&mut engines, &plan, &mut now, |cell| {
        reported.push(match cell {
            Ok(row) => format!("{} at {}", row.name, row.samples),
            Err(skipped) => format!("no {} at {}", skipped.name, skipped.samples),
        });
        ControlFlow::Continue(())
    });
    (density.expect("the engines answer"), reported)
}

#[test]
fn density_plan_counts_by_powers_of_four() {
    let plan = DensityPlan::powers_of_four(40, 256, 1_048_576, 0.5);
    assert_eq!(plan.samples, [256, 1024, 4096, 16_384, 65_536, 262_144, 1_048_576]);
    assert_eq!(plan.max_seconds, 10.0);
    assert_eq!(DensityPlan::powers_of_four(40, 3, 11, 0.01).max_seconds, 1.0);
}

#[test]
fn density_rows_report_the_clock() {
    // 4, 16 and 64 ms for a decision.
    let (density, reported) = measure(&[1_000_000]);
    assert_eq!(reported, ["1000000 ns at 4", "1000000 ns at 16", "1000000 ns at 64"]);
    let found: Vec<_> = density
        .rows
        .iter()
        .map(|row| {
            let misses = [row.missed_20_hz, row.missed_50_hz, row.missed_100_hz];
            (row.decisions, misses)
        })
        .collect();
    // Decisions for half a second and one more; for the slowest engine at least 20.
    assert_eq!(found, [(126, [0, 0, 0]), (32, [0, 0, 32]), (20, [20, 20, 20])]);
    for row in &density.rows {
        let expected_ms = row.samples as f64;
        for ms in [row.p50_ms, row.p95_ms, row.p99_ms, row.max_ms] {
            assert!((ms / expected_ms - 1.0).abs() < 2e-3, "{row:?}");
        }
        assert!((row.steps_per_s / 2000.0 - 1.0).abs() < 2e-3, "{row:?}");
    }
}

#[test]
fn very_slow_engines_are_timed_less_and_then_skipped() {
    // 0.4, 1.6 and 6.4 s for a decision: 20 of them are 8 s and 32 s, 6 of the last 38 s.
    let (density, reported) = measure(&[100, 100_000_000]);
    let slow: Vec<_> = density
        .rows
        .iter()
        .filter(|row| row.name == "100000000 ns")
        .map(|row| (row.samples, row.decisions))
        .collect();
    assert_eq!(slow, [(4, 20), (16, 7)]);
    let [skipped] = &density.skipped[..] else {
        panic!("{:?}", density.skipped);
    };
    assert_eq!((skipped.name.as_str(), skipped.samples), ("100000000 ns", 64));
    assert!(
        skipped.reason.contains("about 6.4 s") && skipped.reason.contains("10 s"),
        "{}",
        skipped.reason
    );
    assert_eq!(reported.len(), 6);
    assert_eq!(reported[5], "no 100000000 ns at 64");
    // The other engine is still measured at every density.
    assert_eq!(density.rows.len(), 5);
}

#[test]
fn density_row_reads_older_records() {
    let text = r#"{"engine": "cpu", "adapter": null, "threads": 2, "samples": 256, "steps": 40, "p50_ms": 0.05,
        "p95_ms": 0.08, "p99_ms": 0.1, "max_ms": 2.7, "decisions": 5000, "steps_per_s": 2e8}"#;
    let row: DensityRow = serde_json::from_str(text).expect("a row");
    assert_eq!((row.samples, row.name.as_str(), row.missed_20_hz), (256, "", 0));
}

fn row(engine: &str, name: &str, samples: usize, p50_ms: f64) -> DensityRow {
    DensityRow {
        sampler: "arcs".to_owned(),
        engine: engine.to_owned(),
        adapter: None,
        threads: 0,
        samples,
        steps: 40,
        p50_ms,
        p95_ms: p50_ms,
        p99_ms: p50_ms,
        max_ms: p50_ms,
        decisions: 20,
        steps_per_s: 1.0,
        name: name.to_owned(),
        missed_20_hz: 0,
        missed_50_hz: 0,
        missed_100_hz: 0,
    }
}

/// The crossover of a GPU with these times at these densities.
fn crossover(gpu: &[(usize, f64)]) -> Crossover {
    let cpu = [(64, 1.0), (256, 2.0), (1024, 8.0), (4096, 32.0)];
    let mut rows: Vec<DensityRow> = cpu
        .iter()
        .flat_map(|&(samples, ms)| {
            // Threads have a fixed cost.
            let many = row("cpu", "many threads", samples, ms / 2.0 + 1.0);
            [row("cpu", "one thread", samples, ms), many]
        })
        .collect();
    rows.extend(gpu.iter().map(|&(samples, ms)| row("gpu", "A", samples, ms)));
    crossovers(&rows).remove(0)
}

#[test]
fn crossover_needs_the_fastest_cpu_engine_beaten() {
    let found = crossover(&[(64, 4.0), (256, 4.0), (1024, 4.5), (4096, 5.0)]);
    assert_eq!((found.samples, found.up_to), (Some(1024), 4096));
    assert_eq!(found.fastest_cpu.as_deref(), Some("many threads"));
}

#[test]
fn crossover_is_none_for_a_slower_gpu() {
    let found = crossover(&[(64, 4.0), (256, 9.0), (1024, 30.0)]);
    assert_eq!((found.samples, found.up_to), (None, 1024));
    assert_eq!(found.fastest_cpu.as_deref(), Some("many threads"));
    // Equal is not faster.
    assert_eq!(crossover(&[(64, 1.0)]).samples, None);
}

#[test]
fn crossover_ignores_a_single_faster_density() {
    let lucky = crossover(&[(64, 0.5), (256, 9.0), (1024, 2.0), (4096, 3.0)]);
    assert_eq!(lucky.samples, Some(1024));
    assert_eq!(crossover(&[(64, 0.5), (256, 9.0)]).samples, None);
}

#[test]
fn crossover_is_none_without_common_densities() {
    let found = crossover(&[(100, 0.1)]);
    assert_eq!((found.samples, found.fastest_cpu, found.up_to), (None, None, 0));
    assert!(crossovers(&[]).is_empty());
    let alone = [row("gpu", "A", 64, 1.0), row("gpu", "B", 64, 1.0)];
    assert_eq!(crossovers(&alone).len(), 2);
}

#[test]
fn crossover_text_names_samples_and_cpu_engine() {
    let text = |samples, cpu: Option<&str>| {
        let crossover = Crossover {
            sampler: "arcs".to_owned(),
            name: "NVIDIA H200".to_owned(),
            samples,
            fastest_cpu: cpu.map(str::to_owned),
            up_to: 65_536,
        };
        crossover.to_string()
    };
    let cpu = Some("CPU, 1 thread, AVX2");
    assert_eq!(
        text(Some(16_384), cpu),
        "NVIDIA H200: faster than every CPU engine from 16384 samples on (there CPU, 1 thread, AVX2)"
    );
    assert_eq!(
        text(None, cpu),
        "NVIDIA H200: not faster than the CPU at 65536 samples (there CPU, 1 thread, AVX2)"
    );
    assert!(text(None, None).contains("no number of samples"));
}
