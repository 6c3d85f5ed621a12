//! Rows of the density measurement.

use serde::{Deserialize, Serialize};

use super::columns::columns;

columns! {
    /// One cell of `bench density`: one engine at one sampling density. Fields from `name` on are missing in older records.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct DensityRow {
        /// `cpu` or `gpu`.
        pub engine: String,
        /// The adapter's name, for a GPU engine.
        pub adapter: Option<String>,
        /// Threads of a CPU engine; zero for a GPU engine.
        pub threads: usize,
        /// Samples of the dynamic window.
        pub samples: usize,
        /// Steps of the horizon.
        pub steps: usize,
        /// Median time of one decision, end to end, milliseconds.
        pub p50_ms: f64 => 3,
        /// 95th percentile, milliseconds.
        pub p95_ms: f64 => 3,
        /// 99th percentile, milliseconds.
        pub p99_ms: f64 => 3,
        /// Slowest, milliseconds.
        pub max_ms: f64 => 3,
        /// Decisions timed.
        pub decisions: usize,
        /// Trajectory-steps per second at the median.
        pub steps_per_s: f64 => 0,
        /// The engine's name for people, with its threads and instructions, or its adapter.
        #[serde(default)]
        pub name: String,
        /// Decisions that took longer than 50 ms, the period of a loop at 20 Hz.
        #[serde(default)]
        pub missed_20_hz: usize,
        /// Decisions that took longer than 20 ms, the period of a loop at 50 Hz.
        #[serde(default)]
        pub missed_50_hz: usize,
        /// Decisions that took longer than 10 ms, the period of a loop at 100 Hz.
        #[serde(default)]
        pub missed_100_hz: usize,
    }
}

/// A cell that was not measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkippedCell {
    /// The engine's name.
    pub name: String,
    /// Samples of the dynamic window.
    pub samples: usize,
    /// Why.
    pub reason: String,
}

columns! {
    /// Quality of the commands of one sampling relative to the densest one, over the decisions of a drive. Figures are null
    /// where no decision has one.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct QualityRow {
        /// Time that the dynamic window looks ahead, seconds.
        pub window_s: f64,
        /// Samples of the dynamic window.
        pub samples: usize,
        /// Forward speeds among them.
        pub vx_samples: u32,
        /// Turn rates among them.
        pub vtheta_samples: u32,
        /// Samples of the densest sampling.
        pub densest: usize,
        /// Decisions compared.
        pub decisions: usize,
        /// Decisions in which the densest sampling found a command and this one none; the figures below leave them out.
        pub without_command: usize,
        /// Median regret: 0 equals the densest sampling, 1 its mean admissible sample.
        pub regret_p50: Option<f64> => 4,
        /// Regret, the worst.
        pub regret_max: Option<f64> => 4,
        /// Distance of the forward speed from that of the densest sampling, the median, m/s.
        pub v_off_p50_m_s: Option<f64> => 4,
        /// The same, the greatest, m/s.
        pub v_off_max_m_s: Option<f64> => 4,
        /// Distance of the turn rate from that of the densest sampling, the median, rad/s.
        pub omega_off_p50_rad_s: Option<f64> => 4,
        /// The same, the greatest, rad/s.
        pub omega_off_max_rad_s: Option<f64> => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::DensityRow;

    #[test]
    fn density_row_reads_older_records() {
        let text = r#"{"engine": "cpu", "adapter": null, "threads": 2, "samples": 256, "steps": 40, "p50_ms": 0.05,
            "p95_ms": 0.08, "p99_ms": 0.1, "max_ms": 2.7, "decisions": 5000, "steps_per_s": 2e8}"#;
        let row: DensityRow = serde_json::from_str(text).expect("a row");
        assert_eq!((row.samples, row.name.as_str(), row.missed_20_hz), (256, "", 0));
    }
}
