//! Measures the distance of the engines' integers from the oracle's real numbers and checks it.

use core::f64::consts::PI;
use core::fmt;

use inbye::local::internals::rollout;
use inbye::local::{
    CpuEngine, Detail, Engine, Evaluation, Problem, QuantizedProblem, SampleRecord, SampleStatus,
    Sampler,
};

use super::naive::{DiscClearance, Fault, Lean, Oracle, Terms, Trajectory};
use super::scenes::Scene;

/// Tolerance of positions and clearances, metres.
pub const LENGTH_M: f64 = 1e-3;
/// Half the diagonal of a cell, in cell sides: a clearance is read from the cell of a centre.
pub const HALF_DIAGONAL: f64 = 0.7072;
/// Tolerance of the heading term, radians: 0.01 degree.
pub const HEADING_RAD: f64 = 0.01 * PI / 180.0;
/// Smallest distance of the final position from the target at which headings are compared, metres.
pub const HEADING_FROM_M: f64 = 0.5;
/// Tolerance of the path term, metres.
pub const PATH_M: f64 = 2e-3;
/// Resolution of a stored speed, m/s.
pub const SPEED_STEP: f64 = 1.0 / 1_048_576.0;
/// Largest difference of the winner's score from the best, on the oracle's terms.
pub const LOSS: f64 = 1e-4;
/// This bound holds if each weighted term is divided by at least this (rad, m, m/s, m). Below it, rounding is a large
/// part of the term.
pub const SCALES: [f64; 4] = [0.05, 0.25, 0.001, 0.05];
/// Largest error of a score for given terms.
pub const SCORE: f64 = 1e-8;

/// Tolerance of lengths that depend on positions within a trajectory: where rows have speeds of their own, a position has
/// two rounded displacements instead of one.
fn length_m(problem: &Problem) -> f64 {
    if problem.sampler == Sampler::Arcs { LENGTH_M } else { 2.0 * LENGTH_M }
}

/// The largest errors so far, and the number of comparisons.
#[derive(Debug, Default)]
pub struct Worst {
    pub scenes: u32,
    pub samples: u32,
    pub admissible: u32,
    /// Samples whose status depends on the tolerances.
    pub undecided: u32,
    /// Error of the final position, metres.
    pub end_m: f64,
    /// Error of the clearance in scenes with blocked cells, in half diagonals of a cell.
    pub still_half_diagonals: f64,
    /// Error of the clearance in scenes without blocked cells, metres.
    pub moving_m: f64,
    pub heading_rad: f64,
    pub path_m: f64,
    pub velocity: f64,
    /// Error of the winner's score, for the terms of the engine.
    pub score: f64,
    /// Difference of the winner's score from the best, on the oracle's terms.
    pub loss: f64,
    /// Scenes in which a term is divided by less than [`SCALES`].
    pub badly_scaled: u32,
    /// The same difference in those scenes, where no bound is promised.
    pub loss_badly_scaled: f64,
    /// Values out of bounds.
    pub failures: Vec<String>,
}

impl Worst {
    /// Panics if any value is out of bounds, with the first few.
    pub fn assert_within_bounds(&self) {
        let first: Vec<&str> = self.failures.iter().take(8).map(String::as_str).collect();
        let count = self.failures.len();
        assert!(count == 0, "{count} out of bounds:\n{}", first.join("\n"));
    }
}

impl fmt::Display for Worst {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scenes, samples, admissible, undecided, .. } = self;
        writeln!(
            f,
            "  {scenes} scenes, {samples} samples, {admissible} admissible, {undecided} undecided"
        )?;
        let degrees = self.heading_rad.to_degrees();
        writeln!(
            f,
            "  end {:.4} mm, heading {degrees:.4} deg, path {:.4} mm",
            self.end_m * 1e3,
            self.path_m * 1e3
        )?;
        let half_diagonals = self.still_half_diagonals;
        writeln!(
            f,
            "  clearance {:.3} mm of moving obstacles, {half_diagonals:.3} half diagonals of cells",
            self.moving_m * 1e3
        )?;
        writeln!(
            f,
            "  velocity {:.3} steps, score {:.1e}",
            self.velocity / SPEED_STEP,
            self.score
        )?;
        let (badly, there) = (self.badly_scaled, self.loss_badly_scaled);
        write!(f, "  loss {:.1e}; in {badly} badly scaled scenes {there:.1e}", self.loss)
    }
}

/// Compares one scene and updates the largest errors.
pub fn compare(scene: &Scene, name: &str, fault: Fault, worst: &mut Worst) {
    let problem = &scene.problem;
    let quantized = match QuantizedProblem::new(problem) {
        Ok(quantized) => quantized,
        Err(error) => {
            worst.failures.push(format!("{name}: {error}"));
            return;
        }
    };
    let evaluation = CpuEngine::single_threaded()
        .evaluate(&quantized, Detail::Samples)
        .expect("the CPU engine has no device to lose");
    let mut comparison = Comparison {
        name,
        problem,
        oracle: Oracle::new(problem, &scene.blocked, length_m(problem), fault),
        alone: scene.blocked.is_empty(),
        worst,
    };
    comparison.worst.scenes += 1;
    let records = evaluation.samples.as_deref().expect("samples are requested");
    let ends = ends(&quantized);
    let mut theirs = Vec::new();
    for (index, record) in records.iter().enumerate() {
        let trajectory = comparison.oracle.roll_out(index);
        comparison.end(index, &trajectory, ends[index]);
        if let Some(terms) = comparison.sample(index, &trajectory, record) {
            theirs.push((index as u32, terms));
        }
    }
    comparison.winner(&evaluation, records, &theirs);
}

/// Final positions of the engines relative to the start, metres in the grid's frame.
fn ends(quantized: &QuantizedProblem) -> Vec<[f64; 2]> {
    let fine_m = quantized.field.unit_m() / 16.0;
    let mut table = vec![0; rollout::table_words(&quantized.header)];
    let mut ends = Vec::with_capacity(quantized.len());
    for row in 0..quantized.profiles.len() {
        rollout::tabulate(quantized, row, &mut table);
        for speed in &quantized.vx_samples {
            let (x, y) = rollout::end_position(&quantized.header, speed, &table);
            ends.push([f64::from(x) * fine_m, f64::from(y) * fine_m]);
        }
    }
    ends
}

/// Statuses from certain contact to admissible: leaning towards a sample never moves its status back in this order.
const fn rank(reason: SampleStatus) -> u32 {
    match reason {
        SampleStatus::Collision => 0,
        SampleStatus::Outside => 1,
        SampleStatus::CannotStop => 2,
        SampleStatus::Ok => 3,
    }
}

struct Comparison<'a> {
    name: &'a str,
    problem: &'a Problem,
    oracle: Oracle<'a>,
    /// Without blocked cells.
    alone: bool,
    worst: &'a mut Worst,
}

impl Comparison<'_> {
    fn check(&mut self, what: &str, index: usize, error: f64, bound: f64) {
        // Written so that a NaN counts as out of bounds.
        let within = error <= bound;
        if !within {
            self.fail(index, &format!("{what} off by {error:.3e}, allowed {bound:.3e}"));
        }
    }

    fn fail(&mut self, index: usize, what: &str) {
        let name = self.name;
        self.worst.failures.push(format!("{name}, sample {index}: {what}"));
    }

    fn end(&mut self, index: usize, trajectory: &Trajectory, end: [f64; 2]) {
        let error = libm::hypot(end[0] - trajectory.end[0], end[1] - trajectory.end[1]);
        raise(&mut self.worst.end_m, error);
        self.check("end", index, error, LENGTH_M);
    }

    /// Compares a sample; returns the oracle's terms if the engine admits it.
    fn sample(
        &mut self,
        index: usize,
        trajectory: &Trajectory,
        record: &SampleRecord,
    ) -> Option<Terms> {
        self.worst.samples += 1;
        let most = self.oracle.judge(trajectory, Lean::Towards);
        let least = self.oracle.judge(trajectory, Lean::Against);
        self.worst.undecided += u32::from(most.reason != least.reason);
        if !(rank(least.reason)..=rank(most.reason)).contains(&rank(record.status)) {
            let (found, least, most) = (record.status, least.reason, most.reason);
            self.fail(index, &format!("{found:?}, where the oracle has {least:?} to {most:?}"));
            return None;
        }
        if record.status != SampleStatus::Ok {
            return None;
        }
        self.worst.admissible += 1;
        let free_steps = [least.free_steps, most.free_steps];
        let clearance = self.clearance(index, trajectory, record, free_steps);
        let terms = self.oracle.terms(trajectory, clearance);
        self.terms(index, trajectory, record, &terms);
        Some(terms)
    }

    /// Compares the clearance and returns the oracle's, read by cells. Where rounding leaves the cell or the number of
    /// free steps open, it returns the value nearest to the engine's.
    fn clearance(
        &mut self,
        index: usize,
        trajectory: &Trajectory,
        record: &SampleRecord,
        [fewest, most]: [usize; 2],
    ) -> f64 {
        let length_m = length_m(self.problem);
        let found = in_si(self.problem, record).clearance;
        // Fewer free steps leave more clearance.
        let lower = self.oracle.clearance(trajectory, most, Lean::Against);
        let upper = self.oracle.clearance(trajectory, fewest, Lean::Towards);
        let off = (lower - found).max(found - upper);
        self.check("clearance by cells, beyond rounding,", index, off, 0.0);
        // On the border of the grid, rounding decides whether its cells count.
        let on_border = |disc: &DiscClearance| disc.inside.abs() < length_m;
        if fewest == most && !trajectory.steps.iter().flatten().any(on_border) {
            let error = (found - self.oracle.clearance(trajectory, fewest, Lean::Not)).abs();
            if self.alone {
                raise(&mut self.worst.moving_m, error);
                self.check("clearance", index, error, length_m);
            } else {
                let half_diagonal = HALF_DIAGONAL * self.problem.field.frame().resolution_m;
                raise(&mut self.worst.still_half_diagonals, error / half_diagonal);
                self.check("clearance", index, error, length_m + half_diagonal);
            }
        }
        let (lower, upper) = (lower + length_m, upper - length_m);
        found.max(lower).min(upper.max(lower))
    }

    fn terms(
        &mut self,
        index: usize,
        trajectory: &Trajectory,
        record: &SampleRecord,
        terms: &Terms,
    ) {
        let found = in_si(self.problem, record);
        if self.oracle.to_target(trajectory) >= HEADING_FROM_M {
            let error = (found.heading - terms.heading).abs();
            raise(&mut self.worst.heading_rad, error);
            self.check("heading", index, error, HEADING_RAD);
        }
        let error = (found.path - terms.path).abs();
        raise(&mut self.worst.path_m, error);
        self.check("path", index, error, PATH_M);
        let error = (found.velocity - terms.velocity).abs();
        raise(&mut self.worst.velocity, error);
        // Half a step, and the rounding of f64.
        self.check("velocity", index, error, SPEED_STEP * 0.500_001);
    }

    fn winner(
        &mut self,
        evaluation: &Evaluation,
        records: &[SampleRecord],
        theirs: &[(u32, Terms)],
    ) {
        let Some(winner) = &evaluation.winner else {
            if !theirs.is_empty() {
                self.fail(0, "admissible, yet there is no winner");
            }
            return;
        };
        let index = winner.index as usize;
        let Some(place) = theirs.iter().position(|(index, _)| *index == winner.index) else {
            self.fail(index, "wins, yet is not admissible");
            return;
        };
        let admissible = records.iter().filter(|record| record.status == SampleStatus::Ok);
        let ours: Vec<Terms> = admissible.map(|record| in_si(self.problem, record)).collect();
        if ours.len() != theirs.len() {
            // Recorded as a failure above; the scores cannot be compared then.
            return;
        }
        let scores = self.oracle.scores(&ours);
        let error = (winner.score as f64 / 2.0_f64.powi(62) - scores[place]).abs();
        raise(&mut self.worst.score, error);
        self.check("score", index, error, SCORE);
        self.check("winner below the best of its own terms,", index, loss(&scores, place), SCORE);

        let terms: Vec<Terms> = theirs.iter().map(|(_, terms)| *terms).collect();
        let loss = loss(&self.oracle.scores(&terms), place);
        let scales = self.oracle.scales(&terms);
        if scales.iter().zip(SCALES).all(|((_, scale), least)| *scale >= least) {
            raise(&mut self.worst.loss, loss);
            self.check("winner below the best,", index, loss, LOSS);
        } else {
            self.worst.badly_scaled += 1;
            raise(&mut self.worst.loss_badly_scaled, loss);
        }
    }
}

fn raise(worst: &mut f64, error: f64) {
    *worst = worst.max(error);
}

/// Difference of a sample's score from the best.
fn loss(scores: &[f64], place: usize) -> f64 {
    scores.iter().copied().fold(f64::NEG_INFINITY, f64::max) - scores[place]
}

/// The terms of a record in radians, metres and metres per second.
fn in_si(problem: &Problem, record: &SampleRecord) -> Terms {
    let unit_m = problem.field.unit_m();
    Terms {
        heading: f64::from(record.terms.heading) / f64::from(1 << 23) * PI,
        clearance: f64::from(record.terms.clearance) * unit_m,
        velocity: f64::from(record.terms.velocity) * SPEED_STEP,
        path: f64::from(record.terms.path) / 16.0 * unit_m,
    }
}
