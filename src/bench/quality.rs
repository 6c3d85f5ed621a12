//! Quality of the chosen command: few samples compared with the densest sampling, over many decisions of one drive.

use std::sync::Arc;

use super::regret::RegretBaseline;
use super::roadway::{Roadway, roadway_field};
use super::{BenchError, QualityRow};
use crate::geometry::Twist;
use crate::local::internals::Header;
use crate::local::{ClearanceField, Detail, Engine, Evaluation, QuantizedProblem, Terms};

/// Number of ticks after which [`Roadway::problem`] repeats.
const TICKS: usize = 100;

/// Samplings and decisions to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct QualityPlan {
    /// Steps of the horizon.
    pub steps: u32,
    /// Number of samples of the reference sampling.
    pub densest: usize,
    /// Numbers of samples to compare with it.
    pub samples: Vec<usize>,
    /// Ratios of forward speeds to turn rates: 1 for a square.
    pub shapes: Vec<f64>,
    /// Time that the dynamic window looks ahead, seconds.
    pub windows_s: Vec<f64>,
    /// Number of decisions, spread evenly along the drive: 1 to 100, all different.
    pub ticks: usize,
}

/// Returns numbers of forward speeds and turn rates for about this many samples, with this ratio of speeds to rates.
#[must_use]
pub fn grid_counts(samples: usize, shape: f64) -> (u32, u32) {
    let speeds = (samples as f64 * shape).sqrt().round().max(1.0) as usize;
    let speeds = speeds.min(samples.max(1));
    (speeds as u32, samples.max(1).div_ceil(speeds) as u32)
}

/// Takes the decisions of a drive with each number of samples, and compares the commands with those of the densest sampling.
/// The robot has two discs and drives in the roadway among three people. All engines choose the same commands, so any
/// engine serves. `done` is called after each tick.
///
/// # Errors
/// Fails when the engine fails, or a number of samples or steps is outside its range.
pub fn measure_quality(
    engine: &mut dyn Engine,
    plan: &QualityPlan,
    mut done: impl FnMut(),
) -> Result<Vec<QualityRow>, BenchError> {
    let field = roadway_field();
    let mut rows = Vec::new();
    for &window_s in &plan.windows_s {
        let roadway =
            Roadway { steps: plan.steps, window_s, discs: 2, people: 3, ..Roadway::default() };
        let mut decide = |counts, tick| decide(engine, &roadway, &field, counts, tick);
        let densest = grid_counts(plan.densest, 1.0);
        let grids = plan.samples.iter().flat_map(|&samples| {
            let counts = move |&shape: &f64| grid_counts(samples, shape);
            plan.shapes.iter().map(counts)
        });
        let mut cells: Vec<(Grid, Losses)> = grids.map(|grid| (grid, Losses::default())).collect();
        for number in 0..plan.ticks {
            // The decisions are spread evenly along the drive for any number.
            let tick = number * TICKS / plan.ticks;
            let best = decide(densest, tick)?;
            let baseline = RegretBaseline::new(&best.header, &best.answer);
            for (counts, losses) in &mut cells {
                let found = decide(*counts, tick)?;
                // There is no regret without a command of the densest sampling.
                if let (Some(baseline), Some(best)) = (baseline, best.command) {
                    losses.add(&baseline, &best.0, found.command.as_ref());
                }
            }
            done();
        }
        let densest = densest.0 as usize * densest.1 as usize;
        rows.extend(cells.iter().map(|(grid, losses)| losses.row(window_s, *grid, densest)));
    }
    Ok(rows)
}

/// Forward speeds and turn rates of a sampling.
type Grid = (u32, u32);

/// The result of one decision.
struct Decision {
    header: Header,
    answer: Evaluation,
    command: Option<(Twist, Terms)>,
}

fn decide(
    engine: &mut dyn Engine,
    roadway: &Roadway,
    field: &Arc<ClearanceField>,
    (vx_samples, vtheta_samples): Grid,
    tick: usize,
) -> Result<Decision, BenchError> {
    let which = || format!("{vx_samples} x {vtheta_samples} samples");
    let roadway = Roadway { vx_samples, vtheta_samples, ..*roadway };
    let problem = roadway.problem(field, tick);
    let prepared = QuantizedProblem::new(&problem)
        .map_err(|error| BenchError::Problem { which: which(), error })?;
    let answer = engine
        .evaluate(&prepared, Detail::Answer)
        .map_err(|error| BenchError::Engine { which: which(), error })?;
    let command = answer.winner.map(|winner| (problem.window.twist(winner.index), winner.terms));
    Ok(Decision { header: prepared.header, answer, command })
}

/// Losses of one sampling against the densest one, a number for each decision in which it found a command.
#[derive(Clone, Debug, Default)]
struct Losses {
    regret: Vec<f64>,
    linear: Vec<f64>,
    angular: Vec<f64>,
    without_command: usize,
}

impl Losses {
    fn add(&mut self, baseline: &RegretBaseline, best: &Twist, found: Option<&(Twist, Terms)>) {
        let Some((twist, terms)) = found else {
            self.without_command += 1;
            return;
        };
        self.regret.push(baseline.regret(terms));
        self.linear.push((twist.linear - best.linear).abs());
        self.angular.push((twist.angular - best.angular).abs());
    }

    fn row(&self, window_s: f64, (vx_samples, vtheta_samples): Grid, densest: usize) -> QualityRow {
        let (regret_p50, regret_max) = median_and_worst(&self.regret);
        let (v_off_p50_m_s, v_off_max_m_s) = median_and_worst(&self.linear);
        let (omega_off_p50_rad_s, omega_off_max_rad_s) = median_and_worst(&self.angular);
        QualityRow {
            window_s,
            samples: vx_samples as usize * vtheta_samples as usize,
            vx_samples,
            vtheta_samples,
            densest,
            decisions: self.regret.len() + self.without_command,
            without_command: self.without_command,
            regret_p50,
            regret_max,
            v_off_p50_m_s,
            v_off_max_m_s,
            omega_off_p50_rad_s,
            omega_off_max_rad_s,
        }
    }
}

/// The smallest value that at least half of the values do not exceed, and the greatest; none for an empty list.
fn median_and_worst(values: &[f64]) -> (Option<f64>, Option<f64>) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(values.len().saturating_sub(1) / 2);
    (median.copied(), sorted.last().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::{Counts, CpuEngine, Totals, Winner};

    #[test]
    fn grid_counts_have_the_samples_and_shape() {
        for (samples, shape, counts) in [
            (256, 1.0, (16, 16)),
            (1024, 0.25, (16, 64)),
            (1024, 4.0, (64, 16)),
            (800, 0.5, (20, 40)),
            (10, 1.0, (3, 4)),
            (1, 1.0, (1, 1)),
            (4, 1e9, (4, 1)),
            (4, 1e-9, (1, 4)),
        ] {
            assert_eq!(grid_counts(samples, shape), counts, "{samples} at {shape}");
        }
    }

    #[test]
    fn median_is_one_of_the_values() {
        for (values, expected) in [
            (&[][..], (None, None)),
            (&[2.0], (Some(2.0), Some(2.0))),
            (&[3.0, 1.0], (Some(1.0), Some(3.0))),
            (&[5.0, 1.0, 4.0], (Some(4.0), Some(5.0))),
        ] {
            assert_eq!(median_and_worst(values), expected, "{values:?}");
        }
    }

    #[test]
    fn losses_are_distances_from_the_best_command() {
        let header = Header { weights: [0, 0, 1 << 30, 0], ..Header::default() };
        let terms = |velocity| Terms { velocity, ..Terms::default() };
        let densest = Evaluation {
            counts: Counts { admissible: 2, ..Counts::default() },
            totals: Totals { sums: [0, 0, 400, 0], ..Totals::default() },
            winner: Some(Winner { index: 1, score: 0, terms: terms(300) }),
            samples: None,
        };
        let baseline = RegretBaseline::new(&header, &densest).expect("it has a winner");
        let best = Twist::new(0.5, -0.1);
        let mut losses = Losses::default();
        losses.add(&baseline, &best, Some(&(Twist::new(0.25, 0.15), terms(250))));
        losses.add(&baseline, &best, Some(&(best, terms(300))));
        losses.add(&baseline, &best, None);
        let row = losses.row(0.1, (4, 8), 1024);
        assert_eq!((row.samples, row.densest), (32, 1024));
        assert_eq!((row.decisions, row.without_command), (3, 1));
        assert_eq!((row.regret_p50, row.regret_max), (Some(0.0), Some(0.5)));
        assert_eq!(row.v_off_max_m_s, Some(0.25));
        assert_eq!(row.omega_off_max_rad_s, Some(0.25));
    }

    #[test]
    fn densest_sampling_has_no_regret() {
        let plan = QualityPlan {
            steps: 10,
            densest: 64,
            samples: vec![4, 64],
            shapes: vec![1.0],
            windows_s: vec![0.1, 1.0],
            ticks: 3,
        };
        let mut ticks = 0;
        let rows = measure_quality(&mut CpuEngine::single_threaded(), &plan, || ticks += 1)
            .expect("a sound plan");
        assert_eq!((rows.len(), ticks), (4, 6));
        for row in &rows {
            assert_eq!(row.decisions, 3, "{row:?}");
            if row.samples == 64 {
                assert_eq!((row.regret_max, row.v_off_max_m_s), (Some(0.0), Some(0.0)));
            } else {
                assert!(row.regret_max > Some(0.0), "{row:?}");
            }
        }
    }
}
