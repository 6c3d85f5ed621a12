//! Values that the paper publishes.

use serde::Serialize;

/// A row of the paper's tables; none for values that the paper does not print.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedRow {
    /// Environment or path.
    pub task: &'static str,
    /// `traditional` or `improved`.
    pub variant: &'static str,
    /// Length, metres.
    pub length_m: Option<f64>,
    /// Time, milliseconds.
    pub time_ms: Option<f64>,
    /// Inflection points.
    pub turns: Option<u32>,
}

const TRADITIONAL: &str = "traditional";
const IMPROVED: &str = "improved";

/// Table 1.
#[must_use]
pub fn published_table_1() -> Vec<PublishedRow> {
    [
        ("Environment 1", (20.31, 19.69), (18.85, 6.82)),
        ("Environment 2", (20.34, 18.91), (20.10, 5.20)),
        ("Environment 3", (26.56, 21.81), (26.21, 14.51)),
    ]
    .into_iter()
    .flat_map(|(task, before, after)| {
        [(TRADITIONAL, before), (IMPROVED, after)].map(|(variant, (length_m, time_ms))| {
            PublishedRow {
                task,
                variant,
                length_m: Some(length_m),
                time_ms: Some(time_ms),
                turns: None,
            }
        })
    })
    .collect()
}

/// Table 2.
#[must_use]
pub fn published_table_2() -> Vec<PublishedRow> {
    [
        ("Path 1", (68.77, 13), (35.14, 5)),
        ("Path 2", (62.70, 10), (32.15, 4)),
        ("Path 3", (52.53, 6), (21.15, 2)),
        ("Path 4", (29.14, 4), (15.43, 1)),
        ("Path 5", (28.70, 5), (18.02, 0)),
    ]
    .into_iter()
    .flat_map(|(task, before, after)| {
        [(TRADITIONAL, before), (IMPROVED, after)].map(|(variant, (time_ms, turns))| PublishedRow {
            task,
            variant,
            length_m: None,
            time_ms: Some(time_ms),
            turns: Some(turns),
        })
    })
    .collect()
}

/// The published rows of the traditional and of the improved algorithm.
pub(super) fn before_and_after(rows: &[PublishedRow]) -> [Vec<PublishedRow>; 2] {
    [TRADITIONAL, IMPROVED].map(|variant| {
        let of_variant = |row: &&PublishedRow| row.variant == variant;
        rows.iter().filter(of_variant).copied().collect()
    })
}
