//! The axis that charts of sampling density share, so that one can be read beside another.

use super::axis::Axis;
use crate::bench::{DensityRow, QualityRow};
use crate::experiment::Group as ClosedLoopRow;

/// What stands below it.
pub(super) const SAMPLES: &str = "Samples of the dynamic window (logarithmic)";

/// From the fewest to the most samples of any row.
pub(super) fn samples_axis(
    density: &[DensityRow],
    quality: &[QualityRow],
    closed_loop: &[ClosedLoopRow],
) -> Axis {
    let counts = density
        .iter()
        .map(|row| row.samples)
        .chain(quality.iter().map(|row| row.samples))
        .chain(closed_loop.iter().map(|row| row.samples as usize))
        .filter(|&samples| samples > 0);
    let fewest = counts.clone().min().unwrap_or(1);
    let most = counts.max().unwrap_or(fewest);
    Axis::logarithmic(fewest as f64, most as f64)
}
