//! The density charts as one picture, to be looked at without a page.

use super::bench_page::{BenchReport, bench_svg};
use crate::bench::{DensityRow, QualityRow};
use crate::experiment::Group as ClosedLoopRow;

/// An SVG file: latency against samples; beside it regret, and success and time in closed loop, where there are such rows.
/// It holds everything it needs. Without any row it says so.
#[must_use]
pub fn density_svg(
    density: &[DensityRow],
    quality: &[QualityRow],
    closed_loop: &[ClosedLoopRow],
) -> String {
    bench_svg(&BenchReport {
        density,
        quality,
        closed_loop,
        ..BenchReport::default()
    })
}
