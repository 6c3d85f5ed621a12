//! Deviation of the final pose from the goal.

use serde::Serialize;

use crate::geometry::{Pose, wrap_angle};

/// Absolute deviations of the final pose from the goal's, as the columns of Tables 3 and 4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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
    /// The deviation of a final pose from the goal's, both in the map frame, along the axes of the start pose, which is the
    /// paper's origin.
    #[must_use]
    pub fn between(last: &Pose, goal: &Pose, start: &Pose) -> Self {
        let local = |pose: &Pose| start.inverse_transform(&pose.position());
        let off = local(last) - local(goal);
        Self {
            dx_m: off.x.abs(),
            dy_m: off.y.abs(),
            dyaw_rad: wrap_angle(last.yaw - goal.yaw).abs(),
        }
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

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn deviation_is_along_the_axes_of_the_start() {
        let start = Pose::new(7.0, -2.0, FRAC_PI_2);
        let goal = Pose::new(10.0, 3.0, PI - 0.01);
        let last = Pose::new(10.2, 2.9, -PI + 0.02);
        let off = Deviation::between(&last, &goal, &start);
        for (found, expected) in off.to_array().into_iter().zip([0.1, 0.2, 0.03]) {
            assert!((found - expected).abs() < 1e-12, "{off:?}");
        }
    }

    #[test]
    fn spread_of_no_deviations_is_none() {
        assert_eq!(Spread::of(&[]), None);
        let rows = [[0.1, 0.4, 0.0], [0.3, 0.0, 0.2]].map(Deviation::from_array);
        let spread = Spread::of(&rows).expect("two rows");
        assert_eq!(spread.mean.to_array(), [0.2, 0.2, 0.1]);
        assert_eq!(spread.max.to_array(), [0.3, 0.4, 0.2]);
    }
}
