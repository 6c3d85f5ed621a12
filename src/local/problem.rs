//! The problem of one decision, in metres, seconds and radians, and the ranges in which the engines are exact and close
//! to the real-valued result.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::sample_motions::{SampleMotions, ramp_steps};
use super::{ClearanceField, LocalSettings, ProblemError, Sampler, SamplerInputs, Window};
use crate::geometry::{MAX_COORDINATE, Point, Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits, TickTime};
use crate::settings::{SettingError, choices, require, setting_schema, settings};

settings! {
    /// Weights of the terms (paper, eq. 35: alpha, beta, gamma and lambda).
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Weights {
        /// Weight of the final heading towards the target (alpha).
        pub heading: f64 = 0.05, ["", 0 to 1e6];
        /// Weight of the clearance to obstacles (beta).
        pub clearance: f64 = 0.25, ["", 0 to 1e6];
        /// Weight of the forward speed (gamma).
        pub velocity: f64 = 0.20, ["", 0 to 1e6];
        /// Weight of the distance from the final position to the key node (lambda). The score subtracts this term:
        /// the paper prints a plus, yet says that smaller is better.
        pub path: f64 = 0.15, ["", 0 to 1e6];
    }
}

/// Normalisation of the terms over the admissible samples, before they are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Normalization {
    /// Divides each term by its sum (eq. 33). A term with a zero sum contributes nothing.
    #[default]
    Sum,
    /// Maps each term to 0 at its minimum and 1 at its maximum. A term with a zero range contributes nothing.
    MinMax,
}

/// The distance within which a sample must be able to stop (eq. 30).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stopping {
    /// The smallest clearance along the trajectory: `v^2 <= 2 dist a`, as in the paper.
    #[default]
    Clearance,
    /// The arc before the first contact, as in the original DWA (Fox, Burgard and Thrun 1997): the robot may pass fast
    /// between near walls. Steps after the first contact do not count towards the clearance.
    Arc,
}

/// The state of cells outside the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outside {
    /// Obstacle: a trajectory that leaves the field is not admissible.
    #[default]
    Obstacle,
    /// Free.
    Free,
}

setting_schema! {
    Normalization: choices::<Self>();
    Stopping: choices::<Self>();
    Outside: choices::<Self>();
}

/// All inputs of one decision.
///
/// [`Problem::new`] fills in the default settings; every field can be changed afterwards.
///
/// The ranges are checked when the problem is quantised. A unit of length is 0.122 to 0.244 mm, see [`ClearanceField`].
/// - map resolution 0.001 to 2 m; 1 to 4,194,304 samples; 1 to 1023 steps;
/// - speeds at most 15.99 m/s and, in one step, at most 16,384 units (at least 2 m) and 1.5 rad;
/// - the distance driven over the horizon, the distance to the target and the distance to the key node at most 262,144
///   units (at least 32 m);
/// - 1 to 8 discs within 32,767 units of the robot's origin along each axis (at least 4 m);
/// - clearance cap at least 1 mm; together with the radii of a disc and an obstacle at most 46,330 units (at least 5.6
///   m);
/// - at most 1024 moving obstacles; those near enough to matter stay within 2^22 units over the horizon (at least 512
///   m);
/// - the robot at most 2^29 units from the field's corner along each axis (at least 65 km);
/// - weights 0 to 1,000,000.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Static obstacles.
    pub field: Arc<ClearanceField>,
    /// Pose of the robot, in the map frame of the field.
    pub pose: Pose,
    /// The dynamic window: the sampled velocities.
    pub window: Window,
    /// Motion of the samples over the horizon.
    pub sampler: Sampler,
    /// What the motions of samplers other than [`Sampler::Arcs`] depend on.
    pub sampler_inputs: SamplerInputs,
    /// Deceleration along the path, m/s^2, above zero.
    pub braking_x: f64,
    /// Angular deceleration, rad/s^2, above zero.
    pub braking_theta: f64,
    /// Duration of a step, seconds.
    pub step_s: f64,
    /// Number of steps. Poses are checked at steps 1 to `steps`.
    pub steps: u32,
    /// Shape of the robot.
    pub footprint: Footprint,
    /// Cap of the clearance, metres: more clearance does not improve the score.
    pub max_clearance_m: f64,
    /// State of cells outside the field.
    pub outside: Outside,
    /// Moving obstacles at the start, with their velocities. Each step is checked against their predicted positions.
    pub obstacles: Vec<MovingDisc>,
    /// The local target: the robot faces it at the end of the horizon.
    pub target: Point,
    /// The key node of the global path: the trajectory ends near it.
    pub key_node: Point,
    /// Weights of the terms.
    pub weights: Weights,
    /// Normalisation of the terms.
    pub normalization: Normalization,
    /// Distance within which a sample must be able to stop.
    pub stopping: Stopping,
}

impl Problem {
    /// Creates a problem with the default settings, weights and limits, no moving obstacles, and the target as key
    /// node.
    ///
    /// The window depends on `twist`, the velocity of the robot. For other limits or samples assign a [`Window::new`]
    /// to it.
    #[must_use]
    pub fn new(
        field: impl Into<Arc<ClearanceField>>,
        footprint: &Footprint,
        pose: Pose,
        twist: Twist,
        target: Point,
    ) -> Self {
        DecisionInput::new(&field.into(), footprint, pose, twist, target)
            .problem(&LocalSettings::default())
    }
}

impl Problem {
    /// Velocity of a sample in the first control period: the command if the sample wins.
    #[must_use]
    pub fn command(&self, index: u32) -> Twist {
        self.motions().command(index)
    }

    /// Mean velocity of a sample within each step of the horizon.
    pub fn velocities(&self, index: u32) -> impl Iterator<Item = Twist> {
        let (vx, profile) = self.motions().sample(index);
        (0..self.steps).map(move |step| {
            let (vtheta, share) = profile.at(step);
            Twist::new(share * vx + (1.0 - share) * profile.vx, vtheta)
        })
    }

    /// Position of a sample after each step (eq. 27), map frame.
    #[must_use]
    pub fn path(&self, index: u32) -> Vec<Point> {
        let mut pose = self.pose;
        let advance = |twist: Twist| {
            let (sine, cosine) = libm::sincos(pose.yaw);
            pose.x += twist.linear * cosine * self.step_s;
            pose.y += twist.linear * sine * self.step_s;
            pose.yaw += twist.angular * self.step_s;
            pose.position()
        };
        self.velocities(index).map(advance).collect()
    }

    /// Largest forward speed and turn rate, without sign, from which a sample must be able to stop (eq. 30): those of its
    /// column, of its row, and of every step.
    #[doc(hidden)]
    #[must_use]
    pub fn stopping_velocity(&self, index: u32) -> Twist {
        let (vx, profile) = self.motions().sample(index);
        let vtheta = (0..self.steps).map(|step| profile.at(step).0.abs());
        Twist::new(vx.abs().max(profile.vx.abs()), vtheta.fold(0.0, f64::max))
    }

    /// The rows and columns of this problem.
    pub(super) fn motions(&self) -> SampleMotions<'_> {
        let Self { sampler, window, sampler_inputs, step_s, steps, .. } = self;
        SampleMotions::new(*sampler, window, sampler_inputs, *step_s, *steps)
    }
}

/// The state of robot and surroundings at a control tick.
#[derive(Clone, Debug)]
pub struct DecisionInput<'a> {
    /// Static obstacles around the robot.
    pub field: &'a Arc<ClearanceField>,
    /// Pose of the robot, map frame.
    pub pose: Pose,
    /// Velocity of the robot.
    pub twist: Twist,
    /// The last command: one of the samples, where it is within the window.
    pub last_command: Twist,
    /// Moving obstacles.
    pub obstacles: &'a [MovingDisc],
    /// The local target: the robot faces it at the end of the horizon.
    pub target: Point,
    /// The key node: the trajectory ends near it.
    pub key_node: Point,
    /// Limits of speed and acceleration at this tick.
    pub limits: Limits,
    /// Shape of the robot.
    pub footprint: &'a Footprint,
    /// Weights of the terms.
    pub weights: Weights,
}

impl<'a> DecisionInput<'a> {
    /// Creates an input with the default limits and weights, no moving obstacles, the velocity as the last command, and the target as
    /// key node.
    #[must_use]
    pub fn new(
        field: &'a Arc<ClearanceField>,
        footprint: &'a Footprint,
        pose: Pose,
        twist: Twist,
        target: Point,
    ) -> Self {
        Self {
            field,
            pose,
            twist,
            last_command: twist,
            obstacles: &[],
            target,
            key_node: target,
            limits: Limits::default(),
            footprint,
            weights: Weights::default(),
        }
    }

    /// The problem for a planner with these settings. The weights of the input replace those of the settings.
    #[must_use]
    pub fn problem(&self, settings: &LocalSettings) -> Problem {
        self.problem_in(None, settings, settings.control_period_s.into())
    }

    /// As [`Self::problem`], for a tick, in the memory of an old problem: allocates nothing for an unchanged footprint and for
    /// moving obstacles that fit into the old list.
    pub(super) fn problem_in(
        &self,
        old: Option<Problem>,
        settings: &LocalSettings,
        tick: TickTime,
    ) -> Problem {
        let (footprint, mut obstacles) =
            old.map_or_else(Default::default, |old| (Some(old.footprint), old.obstacles));
        let is_same = |footprint: &Footprint| footprint == self.footprint;
        let footprint = footprint.filter(is_same).unwrap_or_else(|| self.footprint.clone());
        obstacles.clear();
        obstacles.extend_from_slice(self.obstacles);
        let window_time = match settings.sampler {
            Sampler::Ramps => {
                let steps = f64::from(ramp_steps(settings.ramp_time_s, settings.sim_step_s));
                (steps * settings.sim_step_s).into()
            }
            _ => tick,
        };
        Problem {
            field: Arc::clone(self.field),
            pose: self.pose,
            window: Window::new(&self.limits, &self.twist, window_time, settings.sampling())
                .through(&self.last_command),
            sampler: settings.sampler,
            sampler_inputs: SamplerInputs {
                twist: self.twist,
                limits: self.limits,
                control_period_s: settings.control_period_s,
                ramp_time_s: settings.ramp_time_s,
                seed: settings.sampler_seed,
            },
            braking_x: -self.limits.decel_lim_x,
            braking_theta: -self.limits.decel_lim_theta,
            step_s: settings.sim_step_s,
            steps: settings.steps(),
            footprint,
            max_clearance_m: settings.max_clearance_m,
            outside: settings.outside,
            obstacles,
            target: self.target,
            key_node: self.key_node,
            weights: self.weights,
            normalization: settings.normalization,
            stopping: settings.stopping,
        }
    }
}

/// Longest distance of one step, units.
pub(super) const MAX_STEP_UNITS: f64 = 16_384.0;
/// Longest distance over the horizon, to the target and to the key node, units.
pub(crate) const MAX_REACH_UNITS: f64 = 262_144.0;
/// Largest sum of clearance cap and radii, units: two squares of it fit in a `u32`.
pub(super) const MAX_CLEARANCE_UNITS: f64 = 46_330.0;
/// Largest coordinate of a disc in the robot's frame, units.
pub(super) const MAX_OFFSET_UNITS: f64 = 32_767.0;
/// Largest forward speed, m/s: its term has 24 bits, 20 of them fractional.
pub(super) const MAX_SPEED: f64 = 15.99;
/// Largest number of samples of a problem.
pub(super) const MAX_SAMPLES: usize = 1 << 22;
/// Largest number of steps of a horizon.
pub(super) const MAX_STEPS: u32 = 1023;
/// Largest number of discs of a footprint.
pub const MAX_DISCS: usize = 8;
/// Largest number of moving obstacles.
pub(super) const MAX_OBSTACLES: usize = 1024;

/// Checks every number whose limit does not depend on the map's resolution.
pub(super) fn check_numbers(problem: &Problem) -> Result<(), ProblemError> {
    let Window { vx, vtheta } = &problem.window;
    let finite = [
        ("pose", problem.pose.is_finite()),
        ("forward speed window", vx.low.is_finite() && vx.high.is_finite()),
        ("turn rate window", vtheta.low.is_finite() && vtheta.high.is_finite()),
        ("target", problem.target.is_finite()),
        ("key node", problem.key_node.is_finite()),
    ];
    if let Some((quantity, _)) = finite.into_iter().find(|(_, finite)| !finite) {
        return Err(ProblemError::NotFinite { quantity });
    }
    // Beyond it, the numbers are farther apart than the directions that matter.
    let yaw = problem.pose.yaw;
    in_range("yaw", yaw, "rad", yaw.abs() <= MAX_COORDINATE, "at most 1e9 rad")?;
    let above_zero = "finite and above zero";
    for (quantity, value, unit) in [
        ("deceleration along the path", problem.braking_x, "m/s^2"),
        ("angular deceleration", problem.braking_theta, "rad/s^2"),
        ("duration of a step", problem.step_s, "s"),
    ] {
        in_range(quantity, value, unit, value > 0.0 && value.is_finite(), above_zero)?;
    }
    // A cap below one unit of length rounds to zero, and every sample collides.
    let cap = problem.max_clearance_m;
    let cap_fits = cap >= 0.001 && cap.is_finite();
    in_range("max_clearance_m", cap, "m", cap_fits, "finite and at least 0.001 m")?;
    let motions = problem.motions();
    if problem.sampler != Sampler::Arcs {
        check_sampler_inputs(&problem.sampler_inputs)?;
    }
    let fastest = motions.fastest();
    let speed_fits = fastest <= MAX_SPEED;
    in_range("forward speed", fastest, "m/s", speed_fits, "at most 15.99 m/s")?;
    problem.weights.validate()?;
    let turn = motions.fastest_turn() * problem.step_s;
    in_range("turn in one step", turn, "rad", turn <= 1.5, "at most 1.5 rad")?;
    check_counts(vx.count, vtheta.count, problem.steps)?;
    let discs = problem.footprint.discs().len();
    in_range("number of discs", discs as f64, "", discs <= MAX_DISCS, "1 to 8")?;
    let moving = problem.obstacles.len();
    in_range("moving obstacles", moving as f64, "", moving <= MAX_OBSTACLES, "at most 1024")
}

/// Checks what the motions of samplers other than [`Sampler::Arcs`] depend on.
fn check_sampler_inputs(inputs: &SamplerInputs) -> Result<(), ProblemError> {
    if !inputs.twist.is_finite() {
        return Err(ProblemError::NotFinite { quantity: "velocity" });
    }
    inputs.limits.validate()?;
    for (quantity, value) in
        [("control period", inputs.control_period_s), ("duration of a ramp", inputs.ramp_time_s)]
    {
        let is_valid = value > 0.0 && value.is_finite();
        in_range(quantity, value, "s", is_valid, "finite and above zero")?;
    }
    Ok(())
}

/// Checks the numbers of forward speeds, turn rates and steps.
pub(super) fn check_counts(
    vx_count: u32,
    vtheta_count: u32,
    steps: u32,
) -> Result<(), SettingError> {
    let samples = f64::from(vx_count) * f64::from(vtheta_count);
    let samples_fit = samples >= 1.0 && samples <= MAX_SAMPLES as f64;
    let expected = "1 to 4194304 (vx_samples times vtheta_samples)";
    require(samples_fit, "number of samples", samples, expected)?;
    let expected = "1 to 1023 (sim_time_s over sim_step_s)";
    require((1..=MAX_STEPS).contains(&steps), "number of steps", f64::from(steps), expected)
}

/// Returns an error unless `good`.
pub(super) fn in_range(
    quantity: &'static str,
    value: f64,
    unit: &'static str,
    good: bool,
    limit: &'static str,
) -> Result<(), ProblemError> {
    if good { Ok(()) } else { Err(ProblemError::OutOfRange { quantity, value, unit, limit }) }
}

/// Checks a length in units against a limit in units.
pub(super) fn at_most(
    quantity: &'static str,
    units: f64,
    limit: f64,
    unit_m: f64,
) -> Result<(), ProblemError> {
    if units <= limit {
        Ok(())
    } else {
        Err(ProblemError::TooFar { quantity, value: units * unit_m, limit_m: limit * unit_m })
    }
}
