//! Deviation of the final pose from the goal: of our drives, and Tables 3 and 4 as the paper prints them.

use serde::Serialize;

use crate::experiment::RunRow;
use crate::geometry::{Point, Pose};

/// Absolute deviations of the final pose from the goal's, as the columns of Tables 3 and 4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Deviation {
    /// Along the x axis of the start pose, metres.
    pub dx_m: f64,
    /// Along its y axis, metres.
    pub dy_m: f64,
    /// In yaw, radians.
    pub dyaw_rad: f64,
}

/// Names of the components, in the order of [`Deviation::to_array`].
pub(super) const COLUMNS: [&str; 3] = ["|dx|", "|dy|", "|dyaw|"];

impl Deviation {
    /// The deviation of a run; not a number where it did not start.
    #[must_use]
    pub fn of(run: &RunRow) -> Self {
        let figure = |figure: Option<f64>| figure.map_or(f64::NAN, f64::abs);
        let yaw_rad = figure(run.final_yaw_error_rad);
        Self::from_array([figure(run.final_dx_m), figure(run.final_dy_m), yaw_rad])
    }

    /// The offset of a final pose from the goal, both in the map frame, along the axes of the start pose, which is the
    /// paper's origin.
    pub(in crate::experiment) fn offset(last: &Pose, goal: &Point, start: &Pose) -> [f64; 2] {
        let off = start.inverse_transform(&last.position()) - start.inverse_transform(goal);
        [off.x, off.y]
    }

    /// Along x, along y, in yaw.
    #[must_use]
    pub const fn to_array(self) -> [f64; 3] {
        [self.dx_m, self.dy_m, self.dyaw_rad]
    }

    /// The reverse of [`Deviation::to_array`].
    #[must_use]
    pub const fn from_array([dx_m, dy_m, dyaw_rad]: [f64; 3]) -> Self {
        Self { dx_m, dy_m, dyaw_rad }
    }
}

/// Mean and largest of some deviations, column by column.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: Deviation,
    /// Largest.
    pub max: Deviation,
}

impl Spread {
    /// The mean and the largest; none of no deviations.
    #[must_use]
    pub fn of(deviations: &[Deviation]) -> Option<Self> {
        let columns = [0, 1, 2];
        let column = |index: usize| deviations.iter().map(move |row| row.to_array()[index]);
        let mean = columns.map(|index| column(index).sum::<f64>() / deviations.len() as f64);
        let max = columns.map(|index| column(index).fold(0.0, f64::max));
        (!deviations.is_empty())
            .then(|| Self { mean: Deviation::from_array(mean), max: Deviation::from_array(max) })
    }
}

/// A table of deviations in the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
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
