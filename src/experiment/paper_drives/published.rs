//! Tables 3 and 4 as the paper prints them, with the figures of its text.

use serde::Serialize;

use super::{Deviation, Spread};

/// A table of deviations in the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PublishedDeviations {
    /// Its ten rows.
    pub rows: Vec<Deviation>,
    /// Mean and largest of these rows.
    pub of_rows: Spread,
    /// Mean and largest in the text, which differ from the rows in places.
    pub of_text: Spread,
}

/// Table 3: ten drives in a known static environment.
#[must_use]
pub fn published_table_3() -> PublishedDeviations {
    published(
        [
            [0.070, 0.068, 0.034],
            [0.062, 0.082, 0.031],
            [0.101, 0.013, 0.181],
            [0.067, 0.031, 0.007],
            [0.094, 0.090, 0.021],
            [0.085, 0.025, 0.039],
            [0.088, 0.070, 0.020],
            [0.034, 0.088, 0.013],
            [0.059, 0.067, 0.012],
            [0.094, 0.018, 0.234],
        ],
        [0.075, 0.055, 0.059],
        [0.101, 0.090, 0.234],
    )
}

/// Table 4: ten drives in an unknown dynamic environment.
#[must_use]
pub fn published_table_4() -> PublishedDeviations {
    published(
        [
            [0.136, 0.033, 0.072],
            [0.079, 0.036, 0.178],
            [0.111, 0.011, 0.040],
            [0.148, 0.028, 0.543],
            [0.054, 0.143, 0.001],
            [0.084, 0.011, 0.018],
            [0.023, 0.305, 0.037],
            [0.086, 0.065, 0.089],
            [0.073, 0.045, 0.013],
            [0.020, 0.052, 0.006],
        ],
        [0.081, 0.012, 0.099],
        [0.148, 0.143, 0.543],
    )
}

fn published(rows: [[f64; 3]; 10], mean: [f64; 3], max: [f64; 3]) -> PublishedDeviations {
    let rows = rows.map(Deviation::from_array).to_vec();
    PublishedDeviations {
        of_rows: Spread::of(&rows).expect("ten rows have a mean"),
        of_text: Spread { mean: Deviation::from_array(mean), max: Deviation::from_array(max) },
        rows,
    }
}
