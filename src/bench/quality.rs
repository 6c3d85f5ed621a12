//! Quality of the chosen command: few samples compared with the densest sampling, over many decisions of one drive.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::BenchError;
use super::columns::columns;
use super::roadway::{Decision, Roadway, roadway_field};
use super::timing::percentiles;
use crate::local::internals::Header;
use crate::local::internals::score::{Normalizer, normalizers};
use crate::local::{Engine, Evaluation, Sampler, Terms};

/// Number of ticks after which [`Roadway::problem`] repeats.
const TICKS: usize = 100;

columns! {
    /// Quality of the commands of one sampling relative to the densest one, over the decisions of a drive. Figures are null
    /// where no decision has one.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct QualityRow {
        /// Time that the dynamic window looks ahead, seconds.
        pub window_s: f64,
        /// Motion of the samples: [`Sampler::name`].
        #[serde(default = "arcs")]
        pub sampler: String,
        /// Samples of the dynamic window.
        pub samples: usize,
        /// Forward speeds among them.
        pub vx_samples: u32,
        /// Turn rates among them.
        pub vtheta_samples: u32,
        /// Samples of the densest sampling, two segments each.
        pub densest: usize,
        /// Decisions compared.
        pub decisions: usize,
        /// Decisions in which the densest sampling found a command and this one none; the figures below leave them out.
        pub without_command: usize,
        /// Median regret: 0 equals the densest sampling, 1 its mean admissible sample.
        pub regret_p50: Option<f64> => 4,
        /// Regret, the worst.
        pub regret_max: Option<f64> => 4,
        /// Distance of the forward speed from that of the densest sampling, the median, m/s.
        pub v_off_p50_m_s: Option<f64> => 4,
        /// The same, the greatest, m/s.
        pub v_off_max_m_s: Option<f64> => 4,
        /// Distance of the turn rate from that of the densest sampling, the median, rad/s.
        pub omega_off_p50_rad_s: Option<f64> => 4,
        /// The same, the greatest, rad/s.
        pub omega_off_max_rad_s: Option<f64> => 4,
    }
}

impl QualityRow {
    /// The columns of a short table, separated by spaces.
    pub const SUMMARY: &str = "window_s sampler samples vx_samples vtheta_samples regret_p50 regret_max v_off_p50_m_s \
        v_off_max_m_s omega_off_p50_rad_s omega_off_max_rad_s without_command";
}

/// Samplings and decisions to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct QualityPlan {
    /// Steps of the horizon.
    pub steps: u32,
    /// Number of samples of the reference sampling, two segments each.
    pub densest: usize,
    /// Numbers of samples to compare with it.
    pub samples: Vec<usize>,
    /// Samplers, each with a ratio of forward speeds to turn rates: 1 for a square.
    pub samplers: Vec<(Sampler, f64)>,
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

/// The sampler of rows that were recorded before there were others.
pub(super) fn arcs() -> String {
    Sampler::Arcs.name().to_owned()
}

/// The usual ratio of forward speeds to rows. A row of two segments or of a sequence has a second velocity too, so it
/// needs fewer first speeds.
#[must_use]
pub const fn usual_shape(sampler: Sampler) -> f64 {
    match sampler {
        Sampler::Arcs | Sampler::Ramps => 1.0,
        Sampler::TwoSegments | Sampler::Sequences => 1.0 / 16.0,
    }
}

/// Takes the decisions of a drive with each number of samples, and compares the commands with those of the densest sampling.
/// The robot has two discs and drives in the roadway among three people. All engines choose the same commands, so any
/// engine serves. `done` is called after each tick; it can end the comparison, which then returns the windows so far.
///
/// # Errors
/// Fails when the engine fails, or a number of samples or steps is outside its range.
pub fn measure_quality(
    engine: &mut dyn Engine,
    plan: &QualityPlan,
    mut done: impl FnMut() -> ControlFlow<()>,
) -> Result<Vec<QualityRow>, BenchError> {
    let field = roadway_field();
    let mut rows = Vec::new();
    for &window_s in &plan.windows_s {
        let sampled = |samples, (sampler, shape)| {
            let (vx_samples, vtheta_samples) = grid_counts(samples, shape);
            let steps = plan.steps;
            Roadway { vx_samples, vtheta_samples, steps, window_s, discs: 2, people: 3, sampler }
        };
        let densest =
            sampled(plan.densest, (Sampler::TwoSegments, usual_shape(Sampler::TwoSegments)));
        let roadways = plan
            .samples
            .iter()
            .flat_map(|&samples| plan.samplers.iter().map(move |&series| sampled(samples, series)));
        let mut cells: Vec<(Roadway, Losses)> =
            roadways.map(|roadway| (roadway, Losses::default())).collect();
        for number in 0..plan.ticks {
            // The decisions are spread evenly along the drive for any number.
            let tick = number * TICKS / plan.ticks;
            let best = densest.decide(engine, &field, tick)?;
            // There is no regret without a command of the densest sampling.
            let baseline = RegretBaseline::new(&best.header, &best.evaluation);
            for (roadway, losses) in &mut cells {
                let found = roadway.decide(engine, &field, tick)?;
                if let Some(baseline) = &baseline {
                    losses.add(baseline, &best, &found);
                }
            }
            if done().is_break() {
                return Ok(rows);
            }
        }
        rows.extend(cells.iter().map(|(roadway, losses)| losses.row(roadway, densest.samples())));
    }
    Ok(rows)
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
    fn add(&mut self, baseline: &RegretBaseline, best: &Decision, found: &Decision) {
        let (Some((best, _)), Some((twist, terms))) = (best.command(), found.command()) else {
            self.without_command += 1;
            return;
        };
        self.regret.push(baseline.regret(&terms));
        self.linear.push((twist.linear - best.linear).abs());
        self.angular.push((twist.angular - best.angular).abs());
    }

    fn row(&self, roadway: &Roadway, densest: usize) -> QualityRow {
        let median_and_worst = |values: &Vec<f64>| percentiles(values.clone(), [0.5, 1.0]);
        let [regret_p50, regret_max] = median_and_worst(&self.regret);
        let [v_off_p50_m_s, v_off_max_m_s] = median_and_worst(&self.linear);
        let [omega_off_p50_rad_s, omega_off_max_rad_s] = median_and_worst(&self.angular);
        QualityRow {
            window_s: roadway.window_s,
            sampler: roadway.sampler.name().to_owned(),
            samples: roadway.samples(),
            vx_samples: roadway.vx_samples,
            vtheta_samples: roadway.vtheta_samples,
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

/// Evaluates commands with the normalisers of the densest sampling.
///
/// Scores of different samplings do not compare: where terms are divided by their sums, scores shrink as samples are added.
/// Regret is a loss relative to the gain of the best sample over the mean admissible one in the densest sampling.
#[derive(Clone, Copy, Debug)]
pub struct RegretBaseline {
    normalizers: [Normalizer; 4],
    best: f64,
    mean: f64,
}

impl RegretBaseline {
    /// The baseline of a problem with the densest sampling; none without an admissible sample.
    #[must_use]
    pub fn new(header: &Header, densest: &Evaluation) -> Option<Self> {
        let winner = densest.winner.as_ref()?;
        let normalizers = normalizers(header, &densest.totals);
        let admissible = f64::from(densest.counts.admissible);
        // The score is linear in the terms, so the mean score is the score of the mean terms.
        let mean_terms = densest.totals.sums.map(|sum| sum as f64 / admissible);
        Some(Self {
            normalizers,
            best: score(&normalizers, winner.terms.to_array().map(f64::from)),
            mean: score(&normalizers, mean_terms),
        })
    }

    /// The regret of a sample with these terms: 0 for the best of the densest sampling, 1 for the mean of its admissible
    /// samples, above 1 for a worse sample. A sample between those of the densest sampling may be better than all of them;
    /// its regret is 0.
    #[must_use]
    pub fn regret(&self, terms: &Terms) -> f64 {
        let gain = self.best - self.mean;
        let lost = self.best - score(&self.normalizers, terms.to_array().map(f64::from));
        if lost > 0.0 && gain > 0.0 { lost / gain } else { 0.0 }
    }
}

/// The score of eq. 35 as in the engines but in floating point: the terms of another sampling may be outside the range of
/// these normalisers.
fn score(normalizers: &[Normalizer; 4], terms: [f64; 4]) -> f64 {
    let mut shares = normalizers.iter().zip(terms).map(|(normalizer, term)| {
        let scale = f64::from(normalizer.mantissa) * libm::exp2(-f64::from(normalizer.bits));
        (term - f64::from(normalizer.offset)) * scale
    });
    let mut next = || shares.next().unwrap_or(0.0);
    let gained = next() + next() + next();
    gained - next()
}
