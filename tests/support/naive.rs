//! The oracle: the paper's equations 27 to 35 in f64, written as simply as possible and without the engines' code.
//!
//! It reads the numbers of a problem and a list of blocked cells; a clearance tries every blocked cell. Lengths are
//! metres and angles radians, in the grid's own frame with its corner as origin.

use core::f64::consts::{PI, TAU};

use inbye::geometry::Twist;
use inbye::local::{Normalization, Outside, Problem, SampleStatus, Stopping};
use inbye::map::Cell;

/// A deliberate fault that the comparison must report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    No,
    /// Turns before it moves: eq. 27 moves along the old heading.
    TurnsFirst,
    /// Adds the path term, as eq. 35 prints, although smaller is better.
    AddsPath,
    /// Uses the positions of moving obstacles one step ago.
    ObstaclesLate,
    /// Does not turn the footprint with the robot.
    StiffFootprint,
    /// Compares the turn rate with the limit for the speed in eq. 30.
    WrongBraking,
    /// Keeps the turn rate of the first step over the horizon.
    KeepsFirstTurnRate,
    /// Keeps the speed of the first step over the horizon.
    KeepsFirstSpeed,
}

/// Clearances of one disc at one step.
#[derive(Clone, Copy, Debug)]
pub struct DiscClearance {
    /// Distance to the nearest blocked cell's centre minus the disc's radius; infinite without any.
    pub still: f64,
    /// The same from the centre of the cell that contains the disc's centre, as in a distance field: minimum and
    /// maximum over the cells that can contain it after rounding.
    pub by_cell: [f64; 2],
    /// Distance to the nearest moving obstacle minus both radii; infinite without any.
    pub moving: f64,
    /// Distance of the disc's centre from the border, inside the grid; negative outside.
    pub inside: f64,
}

/// The rollout of one sample.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Forward speed of the command.
    pub v: f64,
    /// Speed and turn rate from which it must be able to stop.
    pub fastest: Twist,
    /// Final x and y relative to the start, and final heading.
    pub end: [f64; 3],
    /// The clearances of each disc at each step.
    pub steps: Vec<Vec<DiscClearance>>,
}

/// The direction in which tolerances count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lean {
    /// No tolerance.
    Not,
    /// In favour of the sample: the field is read to its advantage.
    Towards,
    /// Against the sample.
    Against,
}

impl Lean {
    /// A tolerance with the sign of this lean.
    fn by(self, tolerance: f64) -> f64 {
        match self {
            Self::Not => 0.0,
            Self::Towards => tolerance,
            Self::Against => -tolerance,
        }
    }
}

/// An evaluated sample.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    pub reason: SampleStatus,
    /// Steps before the first that ends the trajectory; all steps if the rule is the smallest clearance.
    pub free_steps: usize,
}

/// The terms of eqs. 32 and 34.
#[derive(Clone, Copy, Debug, Default)]
pub struct Terms {
    pub heading: f64,
    pub clearance: f64,
    pub velocity: f64,
    pub path: f64,
}

impl Terms {
    /// Heading, clearance, velocity, path.
    pub fn list(self) -> [f64; 4] {
        [self.heading, self.clearance, self.velocity, self.path]
    }
}

/// A problem with the oracle's inputs.
pub struct Oracle<'a> {
    problem: &'a Problem,
    blocked: Vec<[f64; 2]>,
    start: [f64; 3],
    /// Largest rounding of lengths, metres.
    rounding_m: f64,
    fault: Fault,
}

impl<'a> Oracle<'a> {
    /// The oracle of a problem with these blocked cells. Engines may round lengths by `rounding_m`.
    pub fn new(problem: &'a Problem, blocked: &[Cell], rounding_m: f64, fault: Fault) -> Self {
        let side = problem.field.frame().resolution_m;
        let center = |cell: &Cell| {
            [(f64::from(cell.column) + 0.5) * side, (f64::from(cell.row) + 0.5) * side]
        };
        let pose = problem.pose;
        let [x, y] = to_grid(problem, pose.x, pose.y);
        Self {
            problem,
            blocked: blocked.iter().map(center).collect(),
            start: [x, y, pose.yaw - problem.field.frame().origin.yaw],
            rounding_m,
            fault,
        }
    }

    /// Rolls out sample `index` (eq. 27).
    pub fn roll_out(&self, index: usize) -> Trajectory {
        let v = self.problem.command(index as u32).linear;
        let fastest = self.problem.stopping_velocity(index as u32);
        let dt = self.problem.step_s;
        let [start_x, start_y, mut heading] = self.start;
        let (mut x, mut y) = (start_x, start_y);
        let mut steps = Vec::new();
        let velocities = self.problem.velocities(index as u32);
        let mut first = None;
        for (step, Twist { mut linear, angular: mut omega }) in (1..).zip(velocities) {
            let first = first.get_or_insert(Twist::new(linear, omega));
            match self.fault {
                Fault::KeepsFirstTurnRate => omega = first.angular,
                Fault::KeepsFirstSpeed => linear = first.linear,
                _ => {}
            }
            if self.fault == Fault::TurnsFirst {
                heading += omega * dt;
            }
            x += linear * libm::cos(heading) * dt;
            y += linear * libm::sin(heading) * dt;
            if self.fault != Fault::TurnsFirst {
                heading += omega * dt;
            }
            steps.push(self.meet(x, y, heading, step));
        }
        Trajectory { v, fastest, end: [x - start_x, y - start_y, heading], steps }
    }

    fn meet(&self, x: f64, y: f64, heading: f64, step: u32) -> Vec<DiscClearance> {
        let frame = self.problem.field.frame();
        let side = frame.resolution_m;
        let (width, height) = (f64::from(frame.width) * side, f64::from(frame.height) * side);
        let heading = match self.fault {
            Fault::StiffFootprint => self.start[2],
            _ => heading,
        };
        let (cosine, sine) = (libm::cos(heading), libm::sin(heading));
        let late = u32::from(self.fault == Fault::ObstaclesLate);
        let time = f64::from(step - late) * self.problem.step_s;
        let meet = |disc: &inbye::robot::Disc| {
            let at_x = x + disc.x * cosine - disc.y * sine;
            let at_y = y + disc.x * sine + disc.y * cosine;
            let nearest = |x: f64, y: f64| {
                let squared = |center: &[f64; 2]| {
                    let (dx, dy) = (center[0] - x, center[1] - y);
                    dx * dx + dy * dy
                };
                let least = self.blocked.iter().map(squared);
                least.fold(f64::INFINITY, f64::min).sqrt()
            };
            // Centres of the cells along one axis that can contain a coordinate: almost always one.
            let centers = |along: f64| {
                let center = |along: f64| ((along / side).floor() + 0.5) * side;
                let mut centers =
                    vec![center(along - self.rounding_m), center(along + self.rounding_m)];
                centers.dedup();
                centers
            };
            let mut by_cell = [f64::INFINITY, f64::NEG_INFINITY];
            for column in centers(at_x) {
                for row in centers(at_y) {
                    let distance = nearest(column, row) - disc.radius;
                    by_cell = [by_cell[0].min(distance), by_cell[1].max(distance)];
                }
            }
            let moving = self.problem.obstacles.iter().map(|body| {
                let (there_x, there_y) = (body.x + body.vx * time, body.y + body.vy * time);
                let [there_x, there_y] = to_grid(self.problem, there_x, there_y);
                libm::hypot(there_x - at_x, there_y - at_y) - disc.radius - body.radius
            });
            DiscClearance {
                still: nearest(at_x, at_y) - disc.radius,
                by_cell,
                moving: moving.fold(f64::INFINITY, f64::min),
                inside: at_x.min(at_y).min(width - at_x).min(height - at_y),
            }
        };
        self.problem.footprint.discs().iter().map(meet).collect()
    }

    /// Smallest clearance of a step, not capped. Outside the grid there are no static obstacles.
    fn step_clearance(&self, discs: &[DiscClearance], lean: Lean) -> f64 {
        let clearance = |disc: &DiscClearance| {
            let still = match lean {
                Lean::Not => disc.still,
                Lean::Towards => disc.by_cell[1],
                Lean::Against => disc.by_cell[0],
            };
            // Leaning towards the sample, cells count only if the centre is certainly inside.
            let on_grid = disc.inside >= lean.by(self.rounding_m);
            let still = if on_grid { still } else { f64::INFINITY };
            still.min(disc.moving) + lean.by(self.rounding_m)
        };
        discs.iter().map(clearance).fold(f64::INFINITY, f64::min)
    }

    /// Smallest clearance of the first steps, capped.
    pub fn clearance(&self, trajectory: &Trajectory, steps: usize, lean: Lean) -> f64 {
        let clearance = |discs: &Vec<DiscClearance>| self.step_clearance(discs, lean);
        let least = trajectory.steps[..steps].iter().map(clearance);
        least.fold(self.problem.max_clearance_m + lean.by(self.rounding_m), f64::min)
    }

    /// Status of a sample (eqs. 30 and 31).
    pub fn judge(&self, trajectory: &Trajectory, lean: Lean) -> Judgement {
        let by_arc = self.problem.stopping == Stopping::Arc;
        let contact = |discs: &[DiscClearance]| self.step_clearance(discs, lean) <= 0.0;
        let off_grid = |discs: &[DiscClearance]| {
            let off = |disc: &DiscClearance| disc.inside < -lean.by(self.rounding_m);
            self.problem.outside == Outside::Obstacle && discs.iter().any(off)
        };
        let steps = &trajectory.steps;
        let ends = |discs: &Vec<DiscClearance>| contact(discs) || off_grid(discs);
        let free_steps = match steps.iter().position(ends) {
            Some(free_steps) if by_arc => free_steps,
            _ => steps.len(),
        };
        let reason = if by_arc && free_steps == 0 {
            if contact(&steps[0]) { SampleStatus::Collision } else { SampleStatus::Outside }
        } else if !by_arc && steps.iter().any(|discs| contact(discs)) {
            SampleStatus::Collision
        } else if !by_arc && steps.iter().any(|discs| off_grid(discs)) {
            SampleStatus::Outside
        } else if self.can_stop(trajectory, free_steps, lean) {
            SampleStatus::Ok
        } else {
            SampleStatus::CannotStop
        };
        Judgement { reason, free_steps }
    }

    fn can_stop(&self, trajectory: &Trajectory, free_steps: usize, lean: Lean) -> bool {
        let problem = self.problem;
        let brakings = match self.fault {
            Fault::WrongBraking => [problem.braking_x, problem.braking_x],
            _ => [problem.braking_x, problem.braking_theta],
        };
        let rates = [trajectory.fastest.linear, trajectory.fastest.angular];
        rates.into_iter().zip(brakings).all(|(rate, braking)| {
            let dist = match problem.stopping {
                Stopping::Clearance => self.clearance(trajectory, free_steps, lean),
                Stopping::Arc => rate.abs() * free_steps as f64 * problem.step_s,
            };
            // Rounding of f64, if both sides are equal.
            rate * rate <= 2.0 * dist * braking * (1.0 + lean.by(1e-9))
        })
    }

    /// Distance from the final position of a sample to the target.
    pub fn to_target(&self, trajectory: &Trajectory) -> f64 {
        let [x, y] = self.seen_from_end(trajectory, self.problem.target.x, self.problem.target.y);
        libm::hypot(x, y)
    }

    /// The terms of a sample with this clearance (eqs. 32 and 34). A reversing sample has no velocity term.
    pub fn terms(&self, trajectory: &Trajectory, clearance: f64) -> Terms {
        let [x, y] = self.seen_from_end(trajectory, self.problem.target.x, self.problem.target.y);
        let off = libm::atan2(y, x) - trajectory.end[2];
        let off = (off - (off / TAU).round() * TAU).abs();
        let key_node = &self.problem.key_node;
        let [key_x, key_y] = self.seen_from_end(trajectory, key_node.x, key_node.y);
        Terms {
            heading: if x == 0.0 && y == 0.0 { PI } else { PI - off },
            clearance,
            velocity: trajectory.v.max(0.0),
            path: libm::hypot(key_x, key_y),
        }
    }

    fn seen_from_end(&self, trajectory: &Trajectory, x: f64, y: f64) -> [f64; 2] {
        let [x, y] = to_grid(self.problem, x, y);
        [x - self.start[0] - trajectory.end[0], y - self.start[1] - trajectory.end[1]]
    }

    /// Offset and divisor of each term (eq. 33): zero and the sum, or the minimum and the range.
    pub fn scales(&self, terms: &[Terms]) -> [(f64, f64); 4] {
        core::array::from_fn(|term| {
            let values = || terms.iter().map(|terms| terms.list()[term]);
            let least = values().fold(f64::INFINITY, f64::min);
            let greatest = values().fold(f64::NEG_INFINITY, f64::max);
            match self.problem.normalization {
                Normalization::Sum => (0.0, values().sum()),
                Normalization::MinMax => (least, greatest - least),
            }
        })
    }

    /// The scores (eqs. 33 and 35) of the admissible samples with these terms; the weights are scaled to a sum of one.
    pub fn scores(&self, terms: &[Terms]) -> Vec<f64> {
        let weights = &self.problem.weights;
        let sign = if self.fault == Fault::AddsPath { 1.0 } else { -1.0 };
        let weights = [weights.heading, weights.clearance, weights.velocity, sign * weights.path];
        let all: f64 = weights.iter().map(|weight| weight.abs()).sum();
        let scales = self.scales(terms);
        let score = |terms: &Terms| {
            let mut score = 0.0;
            for ((value, weight), (offset, scale)) in
                terms.list().into_iter().zip(weights).zip(scales)
            {
                if scale > 0.0 && all > 0.0 {
                    score += weight / all * (value - offset) / scale;
                }
            }
            score
        };
        terms.iter().map(score).collect()
    }
}

/// A point of the map frame in the grid's frame.
fn to_grid(problem: &Problem, x: f64, y: f64) -> [f64; 2] {
    let origin = problem.field.frame().origin;
    let (x, y) = (x - origin.x, y - origin.y);
    let (cosine, sine) = (libm::cos(origin.yaw), libm::sin(origin.yaw));
    [x * cosine + y * sine, y * cosine - x * sine]
}
