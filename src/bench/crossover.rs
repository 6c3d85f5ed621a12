//! Number of samples from which a GPU is faster than the CPU.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::DensityRow;

/// The density at which a GPU's median falls below the best CPU engine's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crossover {
    /// The GPU engine's name.
    pub name: String,
    /// Smallest measured number of samples from which the GPU's median is below that of every CPU engine at all common
    /// densities. None: the CPU is faster at the densest of them, or there is no common density.
    pub samples: Option<usize>,
    /// The fastest CPU engine at that number, or without one at the densest common density.
    pub fastest_cpu: Option<String>,
    /// Largest common number of samples; zero without one.
    pub up_to: usize,
}

/// The crossover of each GPU engine, in the order in which they occur. Rows of one number of steps are expected.
#[must_use]
pub fn crossovers(rows: &[DensityRow]) -> Vec<Crossover> {
    let mut fastest_cpu: BTreeMap<usize, &DensityRow> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.engine == "cpu") {
        let fastest = fastest_cpu.entry(row.samples).or_insert(row);
        if row.p50_ms < fastest.p50_ms {
            *fastest = row;
        }
    }
    let mut gpus: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|row| row.engine == "gpu") {
        if !gpus.contains(&row.name.as_str()) {
            gpus.push(&row.name);
        }
    }
    let crossover = |name: &&str| {
        let own = rows.iter().filter(|row| row.engine == "gpu" && row.name == **name);
        let mut pairs: Vec<(&DensityRow, &DensityRow)> =
            own.filter_map(|row| Some((row, *fastest_cpu.get(&row.samples)?))).collect();
        pairs.sort_by_key(|(gpu, _)| gpu.samples);
        let wins = |(gpu, cpu): &&(&DensityRow, &DensityRow)| gpu.p50_ms < cpu.p50_ms;
        let first = pairs.iter().rev().take_while(wins).last();
        Crossover {
            name: (*name).to_owned(),
            samples: first.map(|(gpu, _)| gpu.samples),
            fastest_cpu: first.or(pairs.last()).map(|(_, cpu)| cpu.name.clone()),
            up_to: pairs.last().map_or(0, |(gpu, _)| gpu.samples),
        }
    };
    gpus.iter().map(crossover).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &str, name: &str, samples: usize, p50_ms: f64) -> DensityRow {
        DensityRow {
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
}
