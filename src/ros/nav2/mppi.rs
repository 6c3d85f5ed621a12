//! MPPI, Nav2's sampled controller: its limits and horizon mean the same here, its noise and critics do not.

use super::draft::Draft;
use super::leftovers::Rule;
use super::section::Section;
use super::{Nav2Error, Why};

pub(super) const PLUGIN: &str = "nav2_mppi_controller::MPPIController";

pub(super) const MAPPED: [&str; 9] = [
    "vx_max",
    "vx_min",
    "wz_max",
    "ax_max",
    "ax_min",
    "az_max",
    "model_dt",
    "time_steps",
    "batch_size",
];

/// Nav2's own defaults, for what a file leaves out: the horizon is their product.
const STEP_S: f64 = 0.05;
const STEPS: u32 = 56;

/// Turn rates for each forward speed: as the default sampling has them, 20 x 40.
const RATES_PER_SPEED: u32 = 2;

const SIDEWAYS: &str = "tracks do not move sideways";
const GRID: &str = "the window is sampled on a grid, without noise, and each decision by itself";
const TERMS: &str = "a critic of MPPI, whose costs are added as they are; local.weights weighs terms that are normalised over all samples";

pub(super) const RULES: [Rule; 29] = [
    ("vy_*", Why::NoSuchThing, SIDEWAYS),
    ("ay_*", Why::NoSuchThing, SIDEWAYS),
    ("vx_std", Why::NoSuchThing, GRID),
    ("wz_std", Why::NoSuchThing, GRID),
    ("temperature", Why::NoSuchThing, GRID),
    ("gamma", Why::NoSuchThing, GRID),
    ("iteration_count", Why::NoSuchThing, GRID),
    ("regenerate_noises", Why::NoSuchThing, GRID),
    ("advanced.*", Why::NoSuchThing, GRID),
    (
        "open_loop",
        Why::NoSuchThing,
        "decisions start from the speed that is measured",
    ),
    (
        "retry_attempt_limit",
        Why::NoSuchThing,
        "where no sample is admissible the robot brakes, and recovers",
    ),
    (
        "reset_period",
        Why::NoSuchThing,
        "nothing is carried from one decision to the next",
    ),
    (
        "motion_model",
        Why::NoSuchThing,
        "tracks only: what Nav2 calls DiffDrive",
    ),
    (
        "AckermannConstraints.*",
        Why::NoSuchThing,
        "tracks turn on the spot",
    ),
    (
        "prune_distance",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
    (
        "max_robot_pose_search_dist",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
    (
        "enforce_path_inversion",
        Why::NoSuchThing,
        "paths have no cusps",
    ),
    (
        "enforce_path_rotation",
        Why::NoSuchThing,
        "paths have no cusps",
    ),
    ("inversion_*", Why::NoSuchThing, "paths have no cusps"),
    ("visualize", Why::NoSuchThing, "no ROS topics"),
    ("publish_*", Why::NoSuchThing, "no ROS topics"),
    ("Visualization.*", Why::NoSuchThing, "no ROS topics"),
    ("TrajectoryVisualizer.*", Why::NoSuchThing, "no ROS topics"),
    (
        "TrajectoryValidator.*",
        Why::NoSuchThing,
        "every sample is checked for contact",
    ),
    ("trajectory_step", Why::NoSuchThing, "no ROS topics"),
    ("time_step", Why::NoSuchThing, "no ROS topics"),
    (
        "critics",
        Why::NoSuchThing,
        "no critics to choose: heading, clearance, velocity and path, each with its weight in local.weights",
    ),
    ("dump_noises", Why::NoSuchThing, GRID),
    (
        "*Constraints",
        Why::NoSuchThing,
        "tracks only: what Nav2 calls DiffDrive",
    ),
];

/// A critic's parameters: `CostCritic.cost_weight` and the like.
pub(super) const CRITICS: [Rule; 12] = [
    (
        "ConstraintCritic.*",
        Why::NoSuchThing,
        "no sample leaves the limits",
    ),
    ("CostCritic.*", Why::OtherMeaning, TERMS),
    ("ObstaclesCritic.*", Why::OtherMeaning, TERMS),
    ("GoalCritic.*", Why::OtherMeaning, TERMS),
    ("GoalAngleCritic.*", Why::OtherMeaning, TERMS),
    ("PathAlignCritic.*", Why::OtherMeaning, TERMS),
    ("PathAngleCritic.*", Why::OtherMeaning, TERMS),
    ("PathFollowCritic.*", Why::OtherMeaning, TERMS),
    ("PreferForwardCritic.*", Why::OtherMeaning, TERMS),
    ("TwirlingCritic.*", Why::NoSuchThing, "no such term"),
    (
        "VelocityDeadbandCritic.*",
        Why::NoSuchThing,
        "no such term; a base's deadband is base.tracks.deadband",
    ),
    ("SymmetricYawBias*", Why::NoSuchThing, "no such term"),
];

pub(super) fn take(part: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    for (name, key) in [
        ("vx_max", "robot.limits.max_vel_x"),
        ("wz_max", "robot.limits.max_vel_theta"),
        ("ax_max", "robot.limits.acc_lim_x"),
    ] {
        if let Some(given) = part.number(name)? {
            draft.at_most(key, given, "");
        }
    }
    for (name, key) in [
        ("vx_min", "robot.limits.min_vel_x"),
        ("ax_min", "robot.limits.decel_lim_x"),
    ] {
        if let Some(given) = part.number(name)? {
            draft.at_least(key, given, "");
        }
    }
    if let Some(given) = part.number("az_max")? {
        draft.at_most("robot.limits.acc_lim_theta", given.clone(), "");
        let brake = given.map(|gain| -gain);
        draft.at_least(
            "robot.limits.decel_lim_theta",
            brake,
            "negative, for braking",
        );
    }
    horizon(part, draft)?;
    if let Some(given) = part.count("batch_size")? {
        let (speeds, rates) = grid(given.value);
        let how = format!(
            "{} samples: the largest grid within them of {RATES_PER_SPEED} turn rates for each speed, {speeds} x {rates}",
            given.value
        );
        draft.set("local.vx_samples", given.clone().map(|_| speeds), &how);
        draft.set("local.vtheta_samples", given.map(|_| rates), &how);
    }
    Ok(())
}

/// The step is the same; the horizon is so many of them.
fn horizon(part: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let step = part.number("model_dt")?;
    let steps = part.count("time_steps")?;
    let (each, count) = (
        step.as_ref().map_or(STEP_S, |step| step.value),
        steps.as_ref().map_or(STEPS, |steps| steps.value),
    );
    let how = format!("time_steps x model_dt, {count} x {each:?}");
    // Without what the product of decimals is off in its last bits.
    let horizon_s = (each * f64::from(count) * 1e9).round() / 1e9;
    let key = "local.sim_time_s";
    match (step, steps) {
        (None, None) => {}
        (None, Some(steps)) => {
            draft.set(
                "local.sim_step_s",
                steps.clone().map(|_| STEP_S),
                "Nav2's default of model_dt",
            );
            draft.set(key, steps.map(|_| horizon_s), &how);
        }
        (Some(step), steps) => {
            draft.set("local.sim_step_s", step.clone(), "");
            draft.set(key, step.map(|_| horizon_s), &how);
            if let Some(steps) = steps {
                draft.also_from(key, steps.place, &how);
            }
        }
    }
    Ok(())
}

/// How many speeds and how many turn rates make at most so many samples, and nearly as many.
fn grid(samples: u32) -> (u32, u32) {
    let speeds = (samples / RATES_PER_SPEED).isqrt().max(1);
    (speeds, samples / speeds)
}

#[cfg(test)]
mod tests {
    use super::grid;

    #[test]
    fn a_grid_is_within_the_batch_and_near_to_it() {
        assert_eq!(
            [1, 2, 800, 1000, 2000].map(grid),
            [(1, 1), (1, 2), (20, 40), (22, 45), (31, 64)]
        );
        for samples in 1..5000 {
            let (speeds, rates) = grid(samples);
            assert!(speeds * rates <= samples && speeds * (rates + 1) > samples);
        }
    }
}
