//! The scene of timed decisions: a robot drives along a roadway with side roadways, rubble and people.

use std::sync::Arc;

use super::BenchError;
use crate::geometry::{Point, Pose, Twist};
use crate::local::internals::Header;
use crate::local::{
    ClearanceField, DecisionInput, Detail, Engine, Evaluation, LocalSettings, Problem,
    QuantizedProblem, Sampler, Terms,
};
use crate::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use crate::robot::{Disc, Footprint, Limits};

/// Cells along each side.
const SIDE: i32 = 400;
/// Side of a cell, metres.
const CELL_M: f64 = 0.05;

/// The decisions in the roadway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roadway {
    /// Number of forward speeds.
    pub vx_samples: u32,
    /// Number of turn rates.
    pub vtheta_samples: u32,
    /// Steps of the horizon, 0.1 s each.
    pub steps: u32,
    /// Time that the dynamic window looks ahead, seconds: 0.1 s is that of a real control loop, 1 s spreads the samples
    /// over all speeds and most turn rates.
    pub window_s: f64,
    /// Number of discs of the footprint, in a row: 1 to 8.
    pub discs: usize,
    /// Number of people in the roadway.
    pub people: usize,
    /// Motion of the samples.
    pub sampler: Sampler,
}

impl Default for Roadway {
    /// 80 x 63 arcs over 3 s in the widest window: one disc, no people.
    fn default() -> Self {
        Self {
            vx_samples: 80,
            vtheta_samples: 63,
            steps: 30,
            window_s: 1.0,
            discs: 1,
            people: 0,
            sampler: Sampler::Arcs,
        }
    }
}

/// The obstacles: a roadway 4 m wide with rough walls, two side roadways and rubble, 20 x 20 m at 5 cm.
///
/// # Panics
/// Never: it has a place for every cell.
#[must_use]
pub fn roadway_obstacles() -> ObstacleGrid {
    let frame =
        GridFrame { width: SIDE, height: SIDE, resolution_m: CELL_M, origin: Pose::default() };
    // Up to 0.3 m from the wall's line, constant over a few columns.
    let rough = |column: i32, salt: i32| ((column / 5) * 7919 + salt).rem_euclid(13) / 2;
    ObstacleGrid::from_fn(frame, |Cell { column, row }| {
        let in_drift = (160 + rough(column, 3)..240 - rough(column, 8)).contains(&row);
        let in_side_drift =
            (190..260).contains(&column) && row > 200 || (40..100).contains(&column) && row < 200;
        let rubble = column % 61 < 4 && (row - 170).rem_euclid(52) < 3;
        !(in_drift || in_side_drift) || rubble
    })
}

/// The distance field of [`roadway_obstacles`].
///
/// # Panics
/// Never: 5 cm is within the range of resolutions.
#[must_use]
pub fn roadway_field() -> Arc<ClearanceField> {
    let field = ClearanceField::new(&roadway_obstacles());
    Arc::new(field.expect("5 cm is within the range of resolutions"))
}

impl Roadway {
    /// The problem at a tick. The robot advances with each tick, so a hundred consecutive decisions differ.
    ///
    /// # Panics
    /// Panics when there are no discs, or more than 8.
    #[must_use]
    pub fn problem(&self, field: &Arc<ClearanceField>, tick: usize) -> Problem {
        let along = (tick % 100) as f64 / 100.0;
        let settings = LocalSettings {
            vx_samples: self.vx_samples,
            vtheta_samples: self.vtheta_samples,
            control_period_s: self.window_s,
            sampler: self.sampler,
            ..LocalSettings::default()
        };
        let ahead = Point::new(11.5, 10.2);
        let footprint = Footprint::new((0..self.discs).map(|disc| self.disc(disc)).collect());
        let obstacles: Vec<MovingDisc> = (0..self.people).map(person).collect();
        let twist = Twist::new(0.5 + 0.2 * along, 0.3 * along - 0.15);
        let situation = DecisionInput {
            field,
            pose: Pose::new(6.5 + along, 9.8 + 0.3 * along, 0.1 - 0.2 * along),
            twist,
            last_command: twist,
            obstacles: &obstacles,
            target: ahead,
            key_node: ahead,
            limits: Limits::default(),
            footprint: &footprint.expect("one to eight discs"),
            weights: settings.weights,
        };
        Problem { steps: self.steps, ..situation.problem(&settings) }
    }

    /// Indices of the cells that the robot's origin visits, by turn rate, speed and step: the look-ups of a decision with one
    /// disc. Steps outside the field are left out.
    ///
    /// # Panics
    /// As [`Self::problem`].
    #[must_use]
    pub fn cells(&self, field: &Arc<ClearanceField>, tick: usize) -> Vec<i32> {
        let problem = self.problem(field, tick);
        let frame = field.frame();
        let mut cells = Vec::new();
        for sample in 0..problem.window.len() as u32 {
            let visited =
                problem.path(sample).into_iter().filter_map(|point| frame.cell_of(&point));
            cells.extend(visited.map(|cell| frame.index(cell) as i32));
        }
        cells
    }

    pub(super) const fn samples(&self) -> usize {
        self.vx_samples as usize * self.vtheta_samples as usize
    }

    pub(super) fn name(&self) -> String {
        format!("{} x {} samples", self.vx_samples, self.vtheta_samples)
    }

    /// Takes the decision at a tick.
    pub(super) fn decide(
        &self,
        engine: &mut dyn Engine,
        field: &Arc<ClearanceField>,
        tick: usize,
    ) -> Result<Decision, BenchError> {
        let problem = self.problem(field, tick);
        let quantized = QuantizedProblem::new(&problem)
            .map_err(|error| BenchError::Problem { which: self.name(), error })?;
        let evaluation = engine
            .evaluate(&quantized, Detail::Answer)
            .map_err(|error| BenchError::Engine { which: self.name(), error })?;
        Ok(Decision { problem, header: quantized.header, evaluation })
    }

    /// A disc of the footprint; they are 0.25 m apart.
    fn disc(&self, number: usize) -> Disc {
        let middle = (self.discs as f64 - 1.0) / 2.0;
        Disc { x: (middle - number as f64) * 0.25, y: 0.0, radius: 0.3 }
    }
}

/// The result of one decision.
pub(super) struct Decision {
    problem: Problem,
    pub header: Header,
    pub evaluation: Evaluation,
}

impl Decision {
    /// The chosen command and its terms; none without an admissible sample.
    pub(super) fn command(&self) -> Option<(Twist, Terms)> {
        let winner = self.evaluation.winner.as_ref()?;
        Some((self.problem.command(winner.index), winner.terms))
    }
}

/// A person in the roadway ahead, walking along it.
fn person(number: usize) -> MovingDisc {
    let walks_away = number.is_multiple_of(2);
    let number = number as f64;
    MovingDisc {
        x: 9.0 + (number * 1.7) % 6.0,
        y: if walks_away { 9.2 } else { 11.0 } + 0.3 * libm::sin(number),
        radius: 0.25,
        vx: if walks_away { 0.8 } else { -0.8 },
        vy: 0.1 * libm::cos(number * 1.1),
    }
}
