//! Whether the first decision can be made with the settings on the map.

use super::{NavigatorSettings, ObstacleModel, RobotModel};
use crate::geometry::{Point, Pose, Twist};
use crate::local::{
    CLEARANCE_AND_DISC, CLEARANCE_AND_DISCS, DecisionError, DecisionInput, LocalSettings,
    ProblemError, QuantizedProblem,
};
use crate::map::MovingDisc;

/// Rejects settings that no decision on this map can use: they are an error before the robot moves, not a fault of the drive. A robot
/// that stands at the start next to a person has the smallest problem with all radii.
pub(super) fn check_first_problem(
    start: Point,
    (obstacles, window_half_m): (&ObstacleModel, f64),
    robot: &RobotModel,
    (settings, local): (&NavigatorSettings, &LocalSettings),
) -> Result<(), DecisionError> {
    let field = obstacles.window(&start, window_half_m)?;
    let person = MovingDisc {
        x: start.x,
        y: start.y,
        radius: settings.pedestrian_radius_m + settings.moving_margin_m,
        vx: 0.0,
        vy: 0.0,
    };
    let input = DecisionInput {
        field: &field,
        pose: Pose::new(start.x, start.y, 0.0),
        twist: Twist::STOP,
        last_command: Twist::STOP,
        obstacles: if person.is_valid() { &[person] } else { &[] },
        target: start,
        key_node: start,
        limits: robot.limits,
        footprint: &robot.footprint.padded(settings.safety_margin_m),
        weights: local.weights,
    };
    QuantizedProblem::new(&input.problem(local)).map_err(with_margins)?;
    Ok(())
}

/// Names the settings of the navigator that the radii of an error include.
fn with_margins(error: ProblemError) -> ProblemError {
    match error {
        ProblemError::TooFar { quantity, value, limit_m } => {
            let quantity = match quantity {
                CLEARANCE_AND_DISC => {
                    "the sum of max_clearance_m of [local], safety_margin_m of [navigator] and the radius of a disc of the footprint"
                }
                CLEARANCE_AND_DISCS => {
                    "the sum of max_clearance_m of [local], safety_margin_m, pedestrian_radius_m and moving_margin_m of [navigator] \
                     and the radius of a disc of the footprint"
                }
                other => other,
            };
            ProblemError::TooFar { quantity, value, limit_m }
        }
        other => other,
    }
}
