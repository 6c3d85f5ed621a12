//! Text of `inbye bench density`.

use inbye::bench::{Crossover, DensityRow, QualityRow, SkippedCell, text_table};

/// The table of latencies, the skipped cells, and where GPUs overtake the CPU.
pub fn density(
    rows: &[DensityRow],
    skipped: &[SkippedCell],
    crossovers: &[Crossover],
) -> Vec<String> {
    let mut lines = text_table(rows, &DensityRow::SUMMARY);
    lines.extend(skipped.iter().map(|cell| {
        let (name, samples, reason) = (&cell.name, cell.samples, &cell.reason);
        format!("not measured: {name} with {samples} samples: {reason}")
    }));
    lines.extend(crossovers.iter().map(crossover));
    lines
}

fn crossover(crossover: &Crossover) -> String {
    let name = &crossover.name;
    match (crossover.samples, &crossover.fastest_cpu) {
        (Some(samples), Some(cpu)) => {
            format!("{name}: faster than every CPU engine from {samples} samples on (there {cpu})")
        }
        (None, Some(cpu)) => {
            let up_to = crossover.up_to;
            format!("{name}: never faster than the CPU up to {up_to} samples (there {cpu})")
        }
        (_, None) => format!("{name}: measured with no number of samples that a CPU engine was"),
    }
}

/// The table of regrets; no lines where commands were not compared.
pub fn quality(rows: &[QualityRow]) -> Vec<String> {
    let Some(first) = rows.first() else {
        return Vec::new();
    };
    let title = format!(
        "The command compared with the one chosen from {} samples, {} decisions: regret 0 is equally good, 1 no better than \
         a random admissible sample; then the differences of v and omega.",
        first.densest, first.decisions
    );
    let mut lines = vec![String::new(), title];
    lines.extend(text_table(rows, &QualityRow::SUMMARY));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossovers_are_sentences() {
        let text = |samples, cpu: Option<&str>| {
            crossover(&Crossover {
                name: "NVIDIA H200".to_owned(),
                samples,
                fastest_cpu: cpu.map(str::to_owned),
                up_to: 65_536,
            })
        };
        let cpu = Some("CPU, 1 thread, AVX2");
        assert_eq!(
            text(Some(16_384), cpu),
            "NVIDIA H200: faster than every CPU engine from 16384 samples on (there CPU, 1 thread, AVX2)"
        );
        assert_eq!(
            text(None, cpu),
            "NVIDIA H200: never faster than the CPU up to 65536 samples (there CPU, 1 thread, AVX2)"
        );
        assert!(text(None, None).contains("no number of samples"));
    }
}
