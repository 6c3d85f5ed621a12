//! The check of the user's own programs before an experiment.

use std::collections::BTreeSet;

use super::{Cell, ExperimentError};
use crate::geometry::Pose;
use crate::map::{GridFrame, ObstacleGrid};
use crate::navigator::NavigationMap;

/// Side of a cell of the map for the check, metres.
const RESOLUTION_M: f64 = 0.1;

/// Starts each program that the settings of these cells name, once, and ends it. A program that cannot be used is no result: it must
/// not be ranked as one that drives badly.
///
/// # Errors
/// Names the first program that cannot be started, or fails before its first answer.
pub fn check_programs<'c>(
    cells: impl IntoIterator<Item = &'c Cell>,
) -> Result<(), ExperimentError> {
    let mut checked = BTreeSet::new();
    for cell in cells {
        let config = &cell.config;
        let unusable = |reason: String| {
            let name = cell.row.config.as_ref();
            let place =
                name.map_or_else(|| "settings".to_owned(), |name| format!("configs.{name}"));
            ExperimentError::Unusable { place, reason }
        };
        if checked.insert(("controller", &config.controller.command)) {
            // The map is not part of the first message.
            let frame = GridFrame::new(1, 1, RESOLUTION_M, Pose::default())?;
            let obstacles = ObstacleGrid::new(frame, vec![false]);
            let controller = config.new_controller(&NavigationMap { obstacles, zones: None });
            controller.map_err(|fault| unusable(fault.to_string()))?;
        }
        if checked.insert(("global planner", &config.global_planner.command)) {
            let planner = config.new_global_planner(RESOLUTION_M);
            planner.map_err(|fault| unusable(fault.to_string()))?;
        }
        let simulator = ("simulator", &config.simulator.command);
        // A world that cannot be made is a result, and leaves the check to the next one.
        if config.simulator.is_set()
            && !checked.contains(&simulator)
            && let Ok(world) = cell.world.simulation(cell.row.seed, config)
        {
            let simulation = &world.simulation;
            simulation.check_simulator(config).map_err(|error| unusable(error.to_string()))?;
            checked.insert(simulator);
        }
    }
    Ok(())
}
