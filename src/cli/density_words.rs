//! What `inbye bench density` tells people.

use inbye::bench::{Crossover, DensityRow, QualityRow, SkippedCell};

/// Heads the rows of [`density_row`].
const DENSITY_HEADER: &str = "engine                                    samples  steps    p50 ms    p95 ms    \
    p99 ms    max ms   M steps/s  late at 20, 50, 100 Hz of";

/// The table of latencies, what was left out, and where GPUs overtake the CPU.
pub fn density(
    rows: &[DensityRow],
    skipped: &[SkippedCell],
    crossovers: &[Crossover],
) -> Vec<String> {
    let mut lines = vec![DENSITY_HEADER.to_owned()];
    lines.extend(rows.iter().map(density_row));
    lines.extend(skipped.iter().map(|cell| {
        let (name, samples, reason) = (&cell.name, cell.samples, &cell.reason);
        format!("not measured: {name} with {samples} samples: {reason}")
    }));
    lines.extend(crossovers.iter().map(crossover));
    lines
}

fn density_row(row: &DensityRow) -> String {
    let late = format!(
        "{}, {}, {}",
        row.missed_20_hz, row.missed_50_hz, row.missed_100_hz
    );
    format!(
        "{:40} {:8} {:6} {:9.3} {:9.3} {:9.3} {:9.3} {:11.1} {late:>23} {}",
        row.name,
        row.samples,
        row.steps,
        row.p50_ms,
        row.p95_ms,
        row.p99_ms,
        row.max_ms,
        row.steps_per_s / 1e6,
        row.decisions,
    )
}

fn crossover(crossover: &Crossover) -> String {
    let name = &crossover.name;
    match (crossover.samples, &crossover.fastest_cpu) {
        (Some(samples), Some(cpu)) => {
            format!("{name}: faster than every CPU engine from {samples} samples on (there {cpu})")
        }
        (None, Some(cpu)) => {
            format!(
                "{name}: never faster than the CPU up to {} samples (there {cpu})",
                crossover.up_to
            )
        }
        (_, None) => format!("{name}: measured with no number of samples that a CPU engine was"),
    }
}

/// The table of regrets; nothing where commands were not compared.
pub fn quality(rows: &[QualityRow]) -> Vec<String> {
    let Some(first) = rows.first() else {
        return Vec::new();
    };
    let mut lines = vec![
        String::new(),
        format!(
            "The command against the one chosen from {} samples, {} decisions: regret 0 % is as good, 100 % no better \
             than an admissible sample picked blindly; then how far v and omega are off.",
            first.densest, first.decisions
        ),
        "window s   samples   v x omega   median %   worst %   v median, worst m/s   omega median, worst rad/s   no command"
            .to_owned(),
    ];
    lines.extend(rows.iter().map(quality_row));
    lines
}

fn quality_row(row: &QualityRow) -> String {
    let grid = format!("{} x {}", row.vx_samples, row.vtheta_samples);
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let percent = |share: Option<f64>| number(share.map(|share| share * 100.0), 2);
    let pair = |median, worst| format!("{}, {}", number(median, 4), number(worst, 4));
    format!(
        "{:8} {:9} {grid:>11} {:>10} {:>9} {:>21} {:>27} {:>12}",
        row.window_s,
        row.samples,
        percent(row.regret_p50),
        percent(row.regret_max),
        pair(row.v_off_p50_m_s, row.v_off_max_m_s),
        pair(row.omega_off_p50_rad_s, row.omega_off_max_rad_s),
        row.without_command,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossovers_are_sentences() {
        let said = |samples, cpu: Option<&str>| {
            crossover(&Crossover {
                name: "NVIDIA H200".to_owned(),
                samples,
                fastest_cpu: cpu.map(str::to_owned),
                up_to: 65_536,
            })
        };
        let cpu = Some("CPU, 1 thread, AVX2");
        assert_eq!(
            said(Some(16_384), cpu),
            "NVIDIA H200: faster than every CPU engine from 16384 samples on (there CPU, 1 thread, AVX2)"
        );
        assert_eq!(
            said(None, cpu),
            "NVIDIA H200: never faster than the CPU up to 65536 samples (there CPU, 1 thread, AVX2)"
        );
        assert!(said(None, None).contains("no number of samples"));
    }

    #[test]
    fn figures_that_are_not_there_are_dashes() {
        let row = QualityRow {
            window_s: 0.1,
            samples: 64,
            vx_samples: 8,
            vtheta_samples: 8,
            densest: 256,
            decisions: 3,
            without_command: 3,
            regret_p50: None,
            regret_max: None,
            v_off_p50_m_s: None,
            v_off_max_m_s: None,
            omega_off_p50_rad_s: None,
            omega_off_max_rad_s: None,
        };
        let lines = quality(&[row]);
        assert!(
            lines[3].contains("8 x 8") && lines[3].contains("-, -"),
            "{lines:?}"
        );
        assert!(quality(&[]).is_empty());
    }
}
