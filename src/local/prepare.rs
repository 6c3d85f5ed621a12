//! From metres, seconds and radians to the integers that every engine computes with.
//!
//! All rounding of real numbers happens here, once for each problem, in f64 with `libm`: the same on every platform.

use std::sync::Arc;

use core::f64::consts::TAU;

use super::{ClearanceField, Normalization, Outside, Problem, ProblemError, Stopping, Window};
use crate::geometry::Point;
use crate::robot::Disc;

/// Final poses are in fine units, this many to a unit of length.
pub const FINE_PER_UNIT: f64 = 16.0;
/// Largest distance in one step, units.
pub const MAX_STEP_UNITS: f64 = 16_384.0;
/// Largest reach over the horizon, and distance to the target and the key node, units.
pub const MAX_REACH_UNITS: f64 = 262_144.0;
/// Largest clearance cap plus radii, units: two squares of it fit in a `u32`.
pub const MAX_CLEARANCE_UNITS: f64 = 46_330.0;
/// Largest coordinate of a disc in the robot's frame, units.
pub const MAX_OFFSET_UNITS: f64 = 32_767.0;
/// Most samples of a problem.
pub const MAX_SAMPLES: usize = 1 << 22;
/// Most steps of a horizon.
pub const MAX_STEPS: u32 = 1023;
/// Most discs of a footprint.
pub const MAX_DISCS: usize = 8;
/// Most moving obstacles.
pub const MAX_OBSTACLES: usize = 1024;

/// Coarse speeds stay below this, so that a product with a coarse displacement stays within 31 bits after rounding.
const MAX_COARSE_SPEED: f64 = 32_000.0;

/// The numbers of a problem that are not lists. TWIN of `Header` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Header {
    /// Number of forward speeds.
    pub v_count: u32,
    /// Number of turn rates.
    pub omega_count: u32,
    /// Number of steps.
    pub steps: u32,
    /// Number of discs.
    pub disc_count: u32,
    /// Number of moving obstacles.
    pub obstacle_count: u32,
    /// Columns of the field.
    pub width: u32,
    /// Rows of the field.
    pub height: u32,
    /// A position in units becomes a cell by this shift to the right.
    pub cell_bits: u32,
    /// Start in units from the field's corner, along its x axis.
    pub start_x: i32,
    /// Start in units from the field's corner, along its y axis.
    pub start_y: i32,
    /// Heading at the start in the field's frame, binary angle.
    pub heading: u32,
    /// Target from the start, fine units, field's frame.
    pub target_x: i32,
    /// Target from the start, fine units, field's frame.
    pub target_y: i32,
    /// Key node from the start, fine units, field's frame.
    pub key_x: i32,
    /// Key node from the start, fine units, field's frame.
    pub key_y: i32,
    /// Clearance beyond which more is not better, units.
    pub max_clearance: u32,
    /// Q20 displacement sums become coarse ones by this shift.
    pub table_bits: u32,
    /// A coarse product becomes units by this shift.
    pub coarse_bits: u32,
    /// The upper half of a fine product becomes fine units by this shift.
    pub fine_bits: u32,
    /// 1: stop within the arc left; 0: within the smallest clearance.
    pub stop_by_arc: u32,
    /// 1: ground outside the field is free; 0: it is an obstacle.
    pub outside_is_free: u32,
    /// 1: min-max normalisation; 0: by the sum.
    pub min_max: u32,
    /// Returned with a GPU's answer, so that a stale one is noticed; no other number depends on it.
    pub stamp: u32,
    /// Fills up to the 16-byte boundary that WGSL wants for what follows.
    pub padding: u32,
    /// Weights of heading, clearance, velocity and path; their sum is about 2^30.
    pub weights: [u32; 4],
}

/// A forward speed. TWIN of `Speed` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Speed {
    /// Units a step, scaled so that a product with a coarse displacement is shifted by [`Header::coarse_bits`].
    pub coarse: i32,
    /// Fine units a step, scaled likewise for [`Header::fine_bits`].
    pub fine: i32,
    /// The velocity term.
    pub term: u32,
    /// What stopping takes: units of clearance, or steps of arc.
    pub needs: u32,
}

/// A turn rate. TWIN of `Turn` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Turn {
    /// Binary angle a step.
    pub per_step: u32,
    /// What stopping takes: units of clearance, or steps of arc.
    pub needs: u32,
}

/// A disc of the footprint in units. TWIN of `BodyDisc` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct BodyDisc {
    /// Centre ahead of the robot's origin.
    pub x: i32,
    /// Centre to the left of it.
    pub y: i32,
    /// Radius.
    pub radius: i32,
}

/// A moving obstacle in the field's frame. TWIN of `MovingBody` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct MovingBody {
    /// Centre now from the robot's start, 256ths of a unit.
    pub x: i32,
    /// Centre now from the robot's start, 256ths of a unit.
    pub y: i32,
    /// Motion a step, 256ths of a unit.
    pub step_x: i32,
    /// Motion a step, 256ths of a unit.
    pub step_y: i32,
    /// Radius, units.
    pub radius: i32,
}

/// A problem as integers: what engines evaluate.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The numbers that are not lists.
    pub header: Header,
    /// Forward speeds, in order.
    pub speeds: Vec<Speed>,
    /// Turn rates, in order.
    pub turns: Vec<Turn>,
    /// Discs of the footprint.
    pub discs: Vec<BodyDisc>,
    /// Moving obstacles that can come near enough to matter.
    pub obstacles: Vec<MovingBody>,
    /// Static obstacles.
    pub field: Arc<ClearanceField>,
}

impl Prepared {
    /// The integers of a problem.
    ///
    /// # Errors
    /// Names the first quantity outside its range (see [`Problem`]).
    pub fn new(problem: &Problem) -> Result<Self, ProblemError> {
        check_numbers(problem)?;
        let unit_m = problem.field.unit_m();
        let steps = f64::from(problem.steps);
        let step_units = problem.window.linear.largest() * problem.step_s / unit_m;
        let reach_units = step_units * steps;
        at_most("distance in one step", step_units, MAX_STEP_UNITS, unit_m)?;
        at_most(
            "distance over the horizon",
            reach_units,
            MAX_REACH_UNITS,
            unit_m,
        )?;
        let frame = problem.field.frame();
        let start = frame.origin.inverse_transform(&problem.pose.position());
        let relative = |point: &Point| (frame.origin.inverse_transform(point) - start) / unit_m;
        let target = relative(&problem.target);
        let key_node = relative(&problem.key_node);
        at_most(
            "distance to the target",
            target.norm(),
            MAX_REACH_UNITS,
            unit_m,
        )?;
        at_most(
            "distance to the key node",
            key_node.norm(),
            MAX_REACH_UNITS,
            unit_m,
        )?;
        let from_field = start.x.abs().max(start.y.abs()) / unit_m;
        at_most(
            "distance to the field's corner",
            from_field,
            2.0_f64.powi(29),
            unit_m,
        )?;

        let table_bits = bits_to_fit(steps * 2.0_f64.powi(20), 65_535.0);
        // At most 24 bits are shifted out of a coarse product, so that rounding it cannot overflow.
        let coarse_scale = scale_to_fit(step_units, MAX_COARSE_SPEED, table_bits + 4);
        // MAX_STEP_UNITS makes this at least 12.
        let fine_scale = scale_to_fit(step_units * FINE_PER_UNIT, 2.0_f64.powi(30), 40);
        let fine = |units: f64| round_i32(units * FINE_PER_UNIT);
        let header = Header {
            v_count: problem.window.linear.count,
            omega_count: problem.window.angular.count,
            steps: problem.steps,
            disc_count: problem.footprint.discs().len() as u32,
            obstacle_count: 0,
            width: frame.width as u32,
            height: frame.height as u32,
            cell_bits: problem.field.cell_bits(),
            start_x: round_i32(start.x / unit_m),
            start_y: round_i32(start.y / unit_m),
            heading: binary_angle(problem.pose.yaw - frame.origin.yaw),
            target_x: fine(target.x),
            target_y: fine(target.y),
            key_x: fine(key_node.x),
            key_y: fine(key_node.y),
            max_clearance: round_i32(problem.max_clearance_m / unit_m) as u32,
            table_bits,
            coarse_bits: coarse_scale + 20 - table_bits,
            fine_bits: fine_scale - 12,
            stop_by_arc: u32::from(problem.stopping == Stopping::Arc),
            outside_is_free: u32::from(problem.outside == Outside::Free),
            min_max: u32::from(problem.normalization == Normalization::MinMax),
            stamp: 0,
            padding: 0,
            weights: weights(problem),
        };
        let mut prepared = Self {
            header,
            speeds: speeds(problem, coarse_scale, fine_scale),
            turns: turns(problem),
            discs: discs(problem)?,
            obstacles: obstacles(problem, reach_units)?,
            field: Arc::clone(&problem.field),
        };
        prepared.header.obstacle_count = prepared.obstacles.len() as u32;
        Ok(prepared)
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.speeds.len() * self.turns.len()
    }

    /// Whether there is no sample. Never true of a prepared problem.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

fn check_numbers(problem: &Problem) -> Result<(), ProblemError> {
    let Window { linear, angular } = &problem.window;
    let finite = [
        ("pose", problem.pose.is_finite()),
        (
            "forward speed window",
            linear.low.is_finite() && linear.high.is_finite(),
        ),
        (
            "turn rate window",
            angular.low.is_finite() && angular.high.is_finite(),
        ),
        ("target", problem.target.iter().all(|c| c.is_finite())),
        ("key node", problem.key_node.iter().all(|c| c.is_finite())),
    ];
    if let Some((quantity, _)) = finite.into_iter().find(|(_, finite)| !finite) {
        return Err(ProblemError::NotFinite { quantity });
    }
    let above_zero = "finite and above zero";
    for (quantity, value, unit) in [
        ("braking along the path", problem.braking_x, "m/s^2"),
        ("braking of the turn", problem.braking_theta, "rad/s^2"),
        ("length of a step", problem.step_s, "s"),
        ("clearance cap", problem.max_clearance_m, "m"),
    ] {
        in_range(
            quantity,
            value,
            unit,
            value > 0.0 && value.is_finite(),
            above_zero,
        )?;
    }
    problem.weights.validate()?;
    let half_turn = angular.largest() * problem.step_s;
    in_range(
        "turn in one step",
        half_turn,
        "rad",
        half_turn <= 1.5,
        "at most 1.5 rad",
    )?;
    check_counts(linear.count, angular.count, problem.steps)?;
    let discs = problem.footprint.discs().len();
    in_range(
        "number of discs",
        discs as f64,
        "",
        discs <= MAX_DISCS,
        "1 to 8",
    )?;
    let moving = problem.obstacles.len();
    in_range(
        "number of moving obstacles",
        moving as f64,
        "",
        moving <= MAX_OBSTACLES,
        "at most 1024",
    )
}

/// Checks the numbers of forward speeds, turn rates and steps.
pub(super) fn check_counts(v_count: u32, omega_count: u32, steps: u32) -> Result<(), ProblemError> {
    let samples = f64::from(v_count) * f64::from(omega_count);
    let samples_fit = samples >= 1.0 && samples <= MAX_SAMPLES as f64;
    in_range(
        "number of samples, vx_samples times vtheta_samples,",
        samples,
        "",
        samples_fit,
        "1 to 4194304",
    )?;
    in_range(
        "number of steps, sim_time_s over sim_step_s,",
        f64::from(steps),
        "",
        (1..=MAX_STEPS).contains(&steps),
        "1 to 1023",
    )
}

pub(super) fn in_range(
    quantity: &'static str,
    value: f64,
    unit: &'static str,
    good: bool,
    limit: &'static str,
) -> Result<(), ProblemError> {
    if good {
        Ok(())
    } else {
        Err(ProblemError::OutOfRange {
            quantity,
            value,
            unit,
            limit,
        })
    }
}

fn at_most(
    quantity: &'static str,
    units: f64,
    limit: f64,
    unit_m: f64,
) -> Result<(), ProblemError> {
    if units <= limit {
        Ok(())
    } else {
        Err(ProblemError::TooFar {
            quantity,
            value: units * unit_m,
            limit_m: limit * unit_m,
        })
    }
}

fn speeds(problem: &Problem, coarse_scale: u32, fine_scale: u32) -> Vec<Speed> {
    let units_per_step = problem.step_s / problem.field.unit_m();
    let (coarse, fine) = (
        2.0_f64.powi(coarse_scale as i32),
        2.0_f64.powi(fine_scale as i32),
    );
    let axis = &problem.window.linear;
    (0..axis.count)
        .map(|index| {
            let speed = axis.value(index);
            Speed {
                coarse: round_i32(speed * units_per_step * coarse),
                fine: round_i32(speed * units_per_step * FINE_PER_UNIT * fine),
                term: velocity_term(speed),
                needs: stopping_need(problem, speed, problem.braking_x),
            }
        })
        .collect()
}

fn turns(problem: &Problem) -> Vec<Turn> {
    let axis = &problem.window.angular;
    (0..axis.count)
        .map(|index| {
            let rate = axis.value(index);
            Turn {
                per_step: binary_angle(rate * problem.step_s),
                needs: stopping_need(problem, rate, problem.braking_theta),
            }
        })
        .collect()
}

/// Speed in 2^-20 m/s, at most 16 m/s less one step; reverse earns nothing.
fn velocity_term(speed: f64) -> u32 {
    let scaled = (speed.max(0.0) * 2.0_f64.powi(20)).round();
    scaled.min(2.0_f64.powi(24) - 1.0) as u32
}

/// Eq. 30 solved for what the sample must have: `rate^2 <= 2 dist a` is `dist >= rate^2 / (2 a)`; with the arc
/// `dist = |rate| n step` it is `n >= |rate| / (2 a step)`. Rounded up: a sample that only just fails, fails.
fn stopping_need(problem: &Problem, rate: f64, braking: f64) -> u32 {
    let need = match problem.stopping {
        Stopping::Clearance => rate * rate / (2.0 * braking) / problem.field.unit_m(),
        Stopping::Arc => rate.abs() / (2.0 * braking * problem.step_s),
    };
    need.ceil().min(2.0_f64.powi(30)) as u32
}

fn discs(problem: &Problem) -> Result<Vec<BodyDisc>, ProblemError> {
    let unit_m = problem.field.unit_m();
    let to_units = |disc: &Disc| {
        at_most(
            "disc offset",
            disc.x.abs().max(disc.y.abs()) / unit_m,
            MAX_OFFSET_UNITS,
            unit_m,
        )?;
        let sum = (problem.max_clearance_m + disc.radius) / unit_m;
        at_most(
            "clearance cap plus disc radius",
            sum,
            MAX_CLEARANCE_UNITS,
            unit_m,
        )?;
        Ok(BodyDisc {
            x: round_i32(disc.x / unit_m),
            y: round_i32(disc.y / unit_m),
            radius: round_i32(disc.radius / unit_m),
        })
    };
    problem.footprint.discs().iter().map(to_units).collect()
}

/// Moving obstacles that could come within the clearance cap of the robot; the others change no bit of the answer.
fn obstacles(problem: &Problem, reach_units: f64) -> Result<Vec<MovingBody>, ProblemError> {
    let unit_m = problem.field.unit_m();
    let origin = problem.field.frame().origin;
    let start = origin.inverse_transform(&problem.pose.position());
    let turn_back = origin.isometry().rotation.inverse();
    let time_s = f64::from(problem.steps) * problem.step_s;
    let largest_disc = problem
        .footprint
        .discs()
        .iter()
        .map(|disc| disc.radius)
        .fold(0.0, f64::max);
    let reach_m = reach_units * unit_m + problem.footprint.circumscribed_radius_m();
    let mut bodies = Vec::with_capacity(problem.obstacles.len());
    for (index, disc) in problem.obstacles.iter().enumerate() {
        if !disc.is_valid() {
            return Err(ProblemError::BadObstacle { index });
        }
        let center = origin.inverse_transform(&disc.center()) - start;
        let velocity = turn_back * crate::geometry::Vector::new(disc.vx, disc.vy);
        let comes_within =
            reach_m + velocity.norm() * time_s + problem.max_clearance_m + disc.radius;
        // A metre more covers all rounding.
        if center.norm() > comes_within + 1.0 {
            continue;
        }
        let sum = (problem.max_clearance_m + largest_disc + disc.radius) / unit_m;
        at_most(
            "clearance cap plus disc and obstacle radius",
            sum,
            MAX_CLEARANCE_UNITS,
            unit_m,
        )?;
        let moved = (center.norm() + velocity.norm() * time_s) / unit_m;
        at_most("way of a moving obstacle", moved, 2.0_f64.powi(22), unit_m)?;
        let in_256ths = |metres: f64| round_i32(metres / unit_m * 256.0);
        bodies.push(MovingBody {
            x: in_256ths(center.x),
            y: in_256ths(center.y),
            step_x: in_256ths(velocity.x * problem.step_s),
            step_y: in_256ths(velocity.y * problem.step_s),
            radius: round_i32(disc.radius / unit_m),
        });
    }
    Ok(bodies)
}

/// Weights as shares of 2^30; all zero stays all zero.
fn weights(problem: &Problem) -> [u32; 4] {
    let weights = &problem.weights;
    let list = [
        weights.heading,
        weights.clearance,
        weights.velocity,
        weights.path,
    ];
    let sum: f64 = list.iter().sum();
    if sum == 0.0 {
        return [0; 4];
    }
    list.map(|weight| (weight / sum * 2.0_f64.powi(30)).round() as u32)
}

/// The fewest bits to drop so that `largest` fits below `limit`.
fn bits_to_fit(largest: f64, limit: f64) -> u32 {
    let mut bits = 0;
    while largest / 2.0_f64.powi(bits) > limit {
        bits += 1;
    }
    bits as u32
}

/// The most bits, up to `most`, that `largest` may be scaled up by and stay below `limit`.
fn scale_to_fit(largest: f64, limit: f64, most: u32) -> u32 {
    let mut bits = most;
    while bits > 0 && largest * 2.0_f64.powi(bits as i32) > limit {
        bits -= 1;
    }
    bits
}

/// An angle in radians as a binary angle.
fn binary_angle(radians: f64) -> u32 {
    let turns = radians / TAU;
    let within_a_turn = turns - turns.floor();
    (within_a_turn * 2.0_f64.powi(32)).round() as u64 as u32
}

/// Rounded to the nearest; the callers' range checks keep it within 32 bits.
fn round_i32(value: f64) -> i32 {
    value.round() as i32
}
