//! The rows that `inbye bench` leaves behind in files.

use inbye::bench::movingai::AlgorithmRow;
use inbye::bench::{DensityRow, QualityRow};
use serde::Serialize;

use super::output_file::Output;

/// A row that has a line in a CSV file.
pub trait Line: Serialize {
    /// The line with the names of the columns.
    const HEADER: &str;

    /// The row's line.
    fn line(&self) -> String;
}

impl Line for DensityRow {
    const HEADER: &str = "engine,adapter,threads,samples,steps,p50_ms,p95_ms,p99_ms,max_ms,decisions,steps_per_s,\
        name,missed_20_hz,missed_50_hz,missed_100_hz";

    fn line(&self) -> String {
        format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            self.engine,
            quoted(self.adapter.as_deref().unwrap_or_default()),
            self.threads,
            self.samples,
            self.steps,
            self.p50_ms,
            self.p95_ms,
            self.p99_ms,
            self.max_ms,
            self.decisions,
            self.steps_per_s,
            quoted(&self.name),
            self.missed_20_hz,
            self.missed_50_hz,
            self.missed_100_hz,
        )
    }
}

impl Line for QualityRow {
    const HEADER: &str = "window_s,samples,vx_samples,vtheta_samples,densest,decisions,without_command,regret_p50,\
        regret_max,v_off_p50_m_s,v_off_max_m_s,omega_off_p50_rad_s,omega_off_max_rad_s";

    fn line(&self) -> String {
        let figures = [
            self.regret_p50,
            self.regret_max,
            self.v_off_p50_m_s,
            self.v_off_max_m_s,
            self.omega_off_p50_rad_s,
            self.omega_off_max_rad_s,
        ];
        let figures = figures.map(|figure| figure.map_or_else(String::new, |it| it.to_string()));
        format!(
            "{},{},{},{},{},{},{},{}",
            self.window_s,
            self.samples,
            self.vx_samples,
            self.vtheta_samples,
            self.densest,
            self.decisions,
            self.without_command,
            figures.join(","),
        )
    }
}

/// An algorithm on the scenarios of a map.
#[derive(Serialize)]
pub struct MapAlgorithm {
    /// Name of the map.
    pub map: String,
    /// What the algorithm did.
    #[serde(flatten)]
    pub row: AlgorithmRow,
}

impl Line for MapAlgorithm {
    const HEADER: &str = "map,name,exact,solved,total,suboptimal,illegal,median_us,p95_us,max_us,expanded,\
        mean_length_ratio,worst_length_ratio,first_fault";

    fn line(&self) -> String {
        let row = &self.row;
        let ratio = |ratio: Option<f64>| ratio.map_or_else(String::new, |it| it.to_string());
        format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            quoted(&self.map),
            row.name,
            row.exact,
            row.solved,
            row.total,
            row.suboptimal,
            row.illegal,
            row.median_us,
            row.p95_us,
            row.max_us,
            row.expanded,
            ratio(row.mean_length_ratio),
            ratio(row.worst_length_ratio),
            quoted(row.first_fault.as_deref().unwrap_or_default()),
        )
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "'"))
}

/// Writes rows, as JSON or CSV by the file's ending.
pub fn write<R: Line>(file: Output, rows: &[R]) -> anyhow::Result<()> {
    let text = if file.ending() == "json" {
        serde_json::to_string_pretty(rows)?
    } else {
        let lines = rows.iter().map(Line::line);
        let lines: Vec<String> = [R::HEADER.to_owned()].into_iter().chain(lines).collect();
        lines.join("\n")
    };
    file.write(text + "\n")
}
