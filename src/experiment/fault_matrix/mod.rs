//! The fault matrix: each fault is injected while the robot drives at speed. The robot must stand in time, or drive on without
//! contact. `cases` has the table, `drive` drives one case.

mod cases;
mod drive;
mod faulty_engine;
mod sites;

use serde::{Deserialize, Serialize};

use super::ExperimentError;
use crate::bench::columns::columns;
use cases::cases;

columns! {
    /// What a robot did after a fault.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct FaultRow {
        /// Name of the fault.
        pub fault: String,
        /// `simulation`, or the protocol of an emulated serial line.
        pub place: String,
        /// Number of drives.
        pub runs: usize,
        /// Longest time from the fault until the robot stood for good, seconds; none where it may drive on.
        pub stood_s: Option<f64> => 2,
        /// Time within which it must stand or park, seconds; none where it may drive on.
        pub limit_s: Option<f64> => 2,
        /// Least true gap to anything after the fault, metres; none where it was not measured.
        pub min_gap_m: Option<f64> => 3,
        /// Number of contacts that the robot caused.
        pub contacts_robot: usize,
        /// True distance to the goal at the end, metres; none where the robot need not reach it.
        pub final_error_m: Option<f64> => 4,
        /// True difference to the yaw of the goal at the end, radians; none without one.
        pub final_yaw_error_rad: Option<f64> => 4,
        /// Time from the first pose near the goal to the end of a mission without a fault, seconds; none with one.
        pub parking_s: Option<f64> => 1,
        /// Whether every drive met the requirement.
        pub passed: bool,
        /// How the last drive that failed the requirement failed it; else the reason of the last that did not reach its goal.
        pub reason: Option<String>,
    }
}

impl FaultRow {
    /// The row of a fault before any drive.
    #[must_use]
    pub fn new(fault: &str, place: &str) -> Self {
        Self { fault: fault.to_owned(), place: place.to_owned(), ..Self::default() }
    }
}

/// Drives the named faults with these seeds. `progress` is called after each drive.
///
/// # Errors
/// [`ExperimentError`] when a drive cannot start.
pub fn simulated_faults(
    names: &[&str],
    seeds: &[u64],
    mut progress: impl FnMut(),
) -> Result<Vec<FaultRow>, ExperimentError> {
    let mut rows = Vec::new();
    for case in cases().filter(|case| names.contains(&case.name)) {
        let mut row = FaultRow {
            limit_s: case.limit_s,
            passed: true,
            ..FaultRow::new(case.name, "simulation")
        };
        for &seed in seeds {
            case.drive(seed, &mut row)?;
            progress();
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Names of all faults in simulation.
pub fn simulated_fault_names() -> impl Iterator<Item = &'static str> {
    cases().map(|case| case.name)
}
