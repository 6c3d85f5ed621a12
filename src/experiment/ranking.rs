//! Ranks planners that drove the same worlds with the same seeds, and says which differences are chance.

use std::collections::{BTreeMap, BTreeSet};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::group::mean;
use super::{Group, RunOutcome, RunRow, WorldKind, faults};
use crate::bench::columns::{column_values, columns};
use crate::bench::{percentiles, wilson_interval};

/// Number of resamples of a bootstrap interval.
const RESAMPLES: usize = 10_000;
/// Seed of the resamples.
const BOOTSTRAP_SEED: u64 = 0;
/// With fewer worlds than this there is no interval: the runs of a world resemble one another, so few worlds show little, however
/// many runs they have.
const LEAST_WORLDS: usize = 6;

/// What the runs say about a planner and the best one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RankStatus {
    /// It is the best one.
    #[default]
    Best,
    /// It is worse: the interval of the difference is below zero.
    Worse,
    /// The interval of the difference contains zero: that may be chance.
    MayBeChance,
    /// There are too few worlds for an interval.
    TooFewWorlds,
}

impl RankStatus {
    /// As people read it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Best => "the best",
            Self::Worse => "worse than the best",
            Self::MayBeChance => "as good as the best, as far as these runs show",
            Self::TooFewWorlds => "too few worlds to tell",
        }
    }
}

column_values! {
    Text: RankStatus;
}

columns! {
    /// A planner in a ranking by `time_weighted_success`, over the worlds of one kind and the seeds with which all planners drove.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct RankedPlanner {
        /// Kind of the worlds.
        pub kind: WorldKind,
        /// Its place, from 1.
        pub rank: usize,
        /// Its name ([`planner_names`]).
        pub planner: String,
        /// Number of runs.
        pub runs: usize,
        /// Number of its other runs, which do not count: another planner did not drive in their worlds with their seeds.
        pub left_out: usize,
        /// Share of runs that reached their goal.
        pub reached_share: f64 => 3,
        /// Lower end of its interval of 95 % confidence (Wilson).
        pub reached_low: f64 => 3,
        /// Upper end.
        pub reached_high: f64 => 3,
        /// Share of runs that ended in contact.
        pub contact_share: f64 => 3,
        /// Share of runs that ended in a contact by the robot's own motion.
        pub robot_contact_share: f64 => 3,
        /// Share of runs that ran out of time.
        pub timeout_share: f64 => 3,
        /// Share of runs in which the navigator gave up, or that did not start.
        pub failed_share: f64 => 3,
        /// Mean success weighted by completion time; a run that did not start counts as zero.
        pub time_weighted_success: f64 => 3,
        /// Mean success weighted by path length, likewise.
        pub path_weighted_success: f64 => 3,
        /// That of the time minus the best planner's.
        pub difference: Option<f64> => 3,
        /// Lower end of the difference's interval of 95 % confidence, by 10,000 resamples of worlds; none with fewer than 6
        /// worlds.
        pub difference_low: Option<f64> => 3,
        /// Upper end.
        pub difference_high: Option<f64> => 3,
        /// What that says.
        pub verdict: RankStatus,
        /// The faults of its failed runs with their numbers, and why runs did not start; none without any.
        pub faults: Option<String>,
        /// BARN's mean score, 0 to 0.5.
        pub score: Option<f64> => 4,
        /// Mean time of the runs that reached their goal over BARN's optimal time.
        pub time_over_optimal: Option<f64> => 3,
        /// 5th percentile of the smallest gaps, metres.
        pub clearance_p05_m: Option<f64> => 3,
        /// Mean share of ticks with a gap below 0.3 m.
        pub near_share: Option<f64> => 3,
        /// Mean share of ticks in which the robot stood.
        pub stopped_share: Option<f64> => 3,
        /// Mean change of the speed, m/s^2.
        pub speed_change_m_s2: Option<f64> => 3,
        /// Mean of the jerk's root mean squares, m/s^3.
        pub jerk_rms_m_s3: Option<f64> => 2,
        /// Mean control effort, m/s^2.
        pub control_effort_m_s2: Option<f64> => 3,
        /// Mean work of the drive, J/kg.
        pub drive_work_j_per_kg: Option<f64> => 2,
        /// Sign changes of the turn rate per metre, 1/m.
        pub omega_sign_changes_per_m: Option<f64> => 3,
        /// Mean angle turned per metre, rad/m.
        pub angle_per_m: Option<f64> => 3,
        /// Mean curvature of the path driven, 1/m.
        pub curvature_per_m: Option<f64> => 3,
        /// Mean distance from the global path, metres.
        pub off_path_rms_m: Option<f64> => 3,
        /// Mean share of ticks with a moving obstacle within 0.45 m; none without moving obstacles.
        pub intimate_share: Option<f64> => 3,
        /// The same within 1.2 m.
        pub personal_share: Option<f64> => 3,
        /// Median over the runs of the median time of a tick, milliseconds.
        pub tick_p50_ms: Option<f64> => 3,
        /// Median over the runs of the 99th percentiles, milliseconds.
        pub tick_p99_ms: Option<f64> => 3,
    }
}

impl RankedPlanner {
    /// The columns of a short table, separated by spaces.
    pub const SUMMARY: &str = "rank planner runs reached_share reached_low reached_high contact_share timeout_share \
        failed_share time_weighted_success difference difference_low difference_high clearance_p05_m \
        omega_sign_changes_per_m tick_p50_ms tick_p99_ms";
}

/// The name of each row's planner: those of its settings and weights in the plan, then its sampling and its engine where rows of
/// one kind of worlds, with the same settings and weights, differ in them. `inbye` where all rows are of one planner.
#[must_use]
pub fn planner_names(rows: &[RunRow]) -> Vec<String> {
    let settings = |row: &RunRow| (row.kind, row.config.clone(), row.weights.clone());
    let sampling = |row: &RunRow| format!("{}x{}", row.vx_samples, row.vtheta_samples);
    let mut variants: BTreeMap<_, [BTreeSet<String>; 2]> = BTreeMap::new();
    for row in rows {
        let [samplings, engines] = variants.entry(settings(row)).or_default();
        samplings.insert(sampling(row));
        engines.insert(row.engine.clone());
    }
    let name = |row: &RunRow| {
        let [differs_in_sampling, differs_in_engine] = variants
            .get(&settings(row))
            .map_or([false; 2], |all| all.each_ref().map(|it| it.len() > 1));
        let parts = [
            row.config.as_deref().map(unambiguous),
            row.weights.as_deref().map(unambiguous),
            differs_in_sampling.then(|| sampling(row)),
            differs_in_engine.then(|| unambiguous(&row.engine)),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if parts.is_empty() { "inbye".to_owned() } else { parts.join(SEPARATOR) }
    };
    rows.iter().map(name).collect()
}

/// Between the parts of a planner's name.
const SEPARATOR: &str = ", ";

/// A part of a name, in quotes where two names could become equal without them.
fn unambiguous(part: &str) -> String {
    let is_plain = !(part.is_empty() || part.contains('"') || part.contains(SEPARATOR));
    if is_plain { part.to_owned() } else { format!("{part:?}") }
}

/// Ranks the planners of each kind of worlds, the best first. Only runs in worlds and with seeds of all planners count. The
/// interval of a difference resamples the worlds, since the seeds of a world resemble one another.
#[must_use]
pub fn rankings(rows: &[RunRow]) -> Vec<RankedPlanner> {
    let names = planner_names(rows);
    let mut by_kind: BTreeMap<WorldKind, BTreeMap<&str, Vec<&RunRow>>> = BTreeMap::new();
    for (row, name) in rows.iter().zip(&names) {
        let planners = by_kind.entry(row.kind).or_default();
        planners.entry(name).or_default().push(row);
    }
    by_kind.into_iter().flat_map(|(kind, planners)| ranking(kind, planners)).collect()
}

/// What planners have in common: world, seed, and whether latency is measured.
type Task<'r> = (&'r str, u64, bool);

/// The task of a row.
fn task(row: &RunRow) -> Task<'_> {
    (&row.world, row.seed, row.latency)
}

fn ranking(kind: WorldKind, planners: BTreeMap<&str, Vec<&RunRow>>) -> Vec<RankedPlanner> {
    let tasks = planners.values().map(|rows| rows.iter().copied().map(task).collect());
    let common = tasks.reduce(|one: BTreeSet<Task<'_>>, other| &one & &other);
    let common = common.unwrap_or_default();
    let mut ranked: Vec<(RankedPlanner, Vec<&RunRow>)> = Vec::new();
    for (name, mut rows) in planners {
        let all = rows.len();
        rows.retain(|row| common.contains(&task(row)));
        let left_out = all - rows.len();
        ranked.push((RankedPlanner { left_out, ..figures(kind, name, &rows) }, rows));
    }
    let order = |planner: &RankedPlanner| (planner.time_weighted_success, planner.reached_share);
    ranked.sort_by(|(one, _), (other, _)| {
        let (one, other) = (order(one), order(other));
        other.0.total_cmp(&one.0).then(other.1.total_cmp(&one.1))
    });
    let best: Vec<&RunRow> = ranked.first().map_or_else(Vec::new, |(_, rows)| rows.clone());
    for (index, (planner, rows)) in ranked.iter_mut().enumerate() {
        planner.rank = index + 1;
        if common.is_empty() {
            planner.verdict = RankStatus::TooFewWorlds;
        } else if index > 0 {
            compare(planner, &paired_differences(rows, &best));
        }
    }
    ranked.into_iter().map(|(planner, _)| planner).collect()
}

/// Sets the difference to the best planner from its mean in each world.
fn compare(planner: &mut RankedPlanner, of_worlds: &[f64]) {
    planner.difference = mean(of_worlds.iter().copied());
    planner.verdict = RankStatus::TooFewWorlds;
    if of_worlds.len() >= LEAST_WORLDS {
        let [low, high] = bootstrap_interval(of_worlds);
        planner.difference_low = Some(low);
        planner.difference_high = Some(high);
        planner.verdict = if high < 0.0 { RankStatus::Worse } else { RankStatus::MayBeChance };
    }
}

fn figures(kind: WorldKind, name: &str, rows: &[&RunRow]) -> RankedPlanner {
    let group = Group::of(name, rows.iter().copied());
    let runs = rows.len();
    let share = |count: usize| count as f64 / runs.max(1) as f64;
    let [reached_low, reached_high] = wilson_interval(group.reached, runs);
    let all = |figure: fn(&RunRow) -> Option<f64>| mean(rows.iter().filter_map(|row| figure(row)));
    let or_zero = |figure: fn(&RunRow) -> Option<f64>| {
        mean(rows.iter().map(|row| figure(row).unwrap_or_default())).unwrap_or_default()
    };
    RankedPlanner {
        kind,
        planner: name.to_owned(),
        runs,
        reached_share: group.reached_share,
        reached_low,
        reached_high,
        contact_share: share(group.contacts),
        robot_contact_share: share(group.contacts_robot),
        timeout_share: share(group.timeouts),
        failed_share: share(group.failed),
        time_weighted_success: or_zero(|row| row.time_weighted_success),
        path_weighted_success: or_zero(|row| row.path_weighted_success),
        score: group.mean_score,
        time_over_optimal: group.mean_time_over_optimal,
        clearance_p05_m: group.clearance_p05_m,
        near_share: all(|row| row.near_share),
        stopped_share: all(|row| row.waited_share),
        speed_change_m_s2: all(|row| row.speed_change_m_s2),
        jerk_rms_m_s3: all(|row| row.jerk_rms_m_s3),
        control_effort_m_s2: all(|row| row.control_effort_m_s2),
        drive_work_j_per_kg: all(|row| row.drive_work_j_per_kg),
        omega_sign_changes_per_m: group.omega_sign_changes_per_m,
        angle_per_m: all(|row| row.angle_per_m),
        curvature_per_m: all(|row| row.curvature_per_m),
        off_path_rms_m: all(|row| row.off_path_rms_m),
        intimate_share: all(|row| row.intimate_share),
        personal_share: all(|row| row.personal_share),
        tick_p50_ms: group.tick_p50_ms,
        tick_p99_ms: group.tick_p99_ms,
        faults: fault_text(rows.iter().copied()),
        ..RankedPlanner::default()
    }
}

/// The mean difference of two planners in `time_weighted_success` in each world.
fn paired_differences(rows: &[&RunRow], best: &[&RunRow]) -> Vec<f64> {
    let value = |row: &RunRow| row.time_weighted_success.unwrap_or_default();
    let of_best: BTreeMap<Task<'_>, f64> = best.iter().map(|row| (task(row), value(row))).collect();
    let mut by_world: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in rows {
        if let Some(other) = of_best.get(&task(row)) {
            by_world.entry(&row.world).or_default().push(value(row) - other);
        }
    }
    by_world.into_values().filter_map(|values| mean(values.into_iter())).collect()
}

/// Returns the faults of runs with their numbers, and the number of those that did not start with the first reason; none without any.
#[must_use]
pub fn fault_text<'r>(rows: impl Iterator<Item = &'r RunRow> + Clone) -> Option<String> {
    let not_started: Vec<&RunRow> =
        rows.clone().filter(|row| row.outcome == RunOutcome::Error).collect();
    let first = not_started.first().and_then(|row| row.reason.as_deref());
    let faults = faults(rows).into_iter();
    let faults = faults.map(|(name, count)| format!("{name}: {count}"));
    let not_started = first.map(|reason| format!("did not start: {}, {reason}", not_started.len()));
    let parts: Vec<String> = faults.chain(not_started).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// The interval of 95 % confidence of the mean of samples, by the percentiles of the means of resamples (Efron 1979). The same
/// samples give the same interval.
fn bootstrap_interval(samples: &[f64]) -> [f64; 2] {
    let mut random = Pcg64Mcg::seed_from_u64(BOOTSTRAP_SEED);
    let count = samples.len();
    let means: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn = (0..count).map(|_| samples[random.random_range(0..count)]);
            drawn.sum::<f64>() / count as f64
        })
        .collect();
    percentiles(means, [0.025, 0.975]).map(Option::unwrap_or_default)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::RunOutcome;

    fn row(planner: &str, world: usize, seed: u64, success: f64) -> RunRow {
        RunRow {
            world: world.to_string(),
            seed,
            config: Some(planner.to_owned()),
            outcome: if success > 0.0 { RunOutcome::Reached } else { RunOutcome::Contact },
            time_weighted_success: Some(success),
            ..RunRow::default()
        }
    }

    /// For normal samples the interval is close to the mean plus and minus 1.96 standard errors.
    #[test]
    fn bootstrap_interval_is_that_of_the_standard_error() {
        let samples: Vec<f64> = (0..400).map(|index| f64::from(index % 20) - 9.5).collect();
        let variance = samples.iter().map(|value| value * value).sum::<f64>() / 400.0;
        let half = 1.96 * (variance / 400.0).sqrt();
        let [low, high] = bootstrap_interval(&samples);
        assert!(
            (low + half).abs() < 0.05 * half && (high - half).abs() < 0.05 * half,
            "{low} {high}"
        );
        assert_eq!([low, high], bootstrap_interval(&samples), "the seed is fixed");
        assert_eq!(bootstrap_interval(&[0.25; 3]), [0.25, 0.25]);
    }

    #[test]
    fn ranking_says_which_difference_may_be_chance() {
        let mut rows = Vec::new();
        for world in 0..20 {
            for seed in 0..2 {
                rows.push(row("fast", world, seed, 0.8));
                // Better in half of the worlds, slightly worse in the others.
                rows.push(row("equal", world, seed, if world % 2 == 0 { 0.85 } else { 0.74 }));
                rows.push(row("slow", world, seed, 0.5 + 0.01 * world as f64));
            }
        }
        rows.push(row("fast", 99, 0, 0.8));
        let ranked = rankings(&rows);
        let names: Vec<&str> = ranked.iter().map(|it| it.planner.as_str()).collect();
        assert_eq!(names, ["fast", "equal", "slow"]);
        let verdicts: Vec<RankStatus> = ranked.iter().map(|it| it.verdict).collect();
        assert_eq!(verdicts, [RankStatus::Best, RankStatus::MayBeChance, RankStatus::Worse]);
        let slow = &ranked[2];
        assert!((slow.difference.expect("pairs") + 0.205).abs() < 1e-9, "{slow:?}");
        // A run that the other planners lack counts nowhere.
        assert_eq!((ranked[0].runs, ranked[0].left_out), (40, 1));
        assert_eq!((slow.runs, slow.left_out), (40, 0));
    }

    #[test]
    fn run_that_did_not_start_counts_as_a_failure() {
        let mut failed = row("one", 0, 0, 0.0);
        failed.time_weighted_success = None;
        let ranked = rankings(&[failed, row("one", 1, 0, 0.5)]);
        assert_eq!(ranked[0].time_weighted_success, 0.25);
    }

    /// The runs of a world resemble one another: with five worlds of 100 seeds, all in favour of one planner, nothing is known
    /// of other worlds.
    #[test]
    fn few_worlds_have_no_interval() {
        let rows = |worlds: usize| {
            let tasks = (0..worlds).flat_map(|world| (0..100).map(move |seed| (world, seed)));
            let each = tasks.flat_map(|(world, seed)| {
                [row("fast", world, seed, 0.8), row("slow", world, seed, 0.6)]
            });
            each.collect::<Vec<_>>()
        };
        let few = &rankings(&rows(5))[1];
        assert_eq!(
            (few.verdict, few.difference_low, few.difference_high),
            (RankStatus::TooFewWorlds, None, None)
        );
        assert!((few.difference.expect("pairs") + 0.2).abs() < 1e-9, "{few:?}");
        assert_eq!(rankings(&rows(6))[1].verdict, RankStatus::Worse);
    }

    /// Two worlds out of eight decide: seeds within a world are no further evidence.
    #[test]
    fn interval_resamples_worlds() {
        let mut rows = Vec::new();
        for world in 0..8 {
            for seed in 0..50 {
                rows.push(row("one", world, seed, 0.8));
                rows.push(row("other", world, seed, if world < 2 { 0.4 } else { 0.8 }));
            }
        }
        let other = &rankings(&rows)[1];
        assert_eq!((other.verdict, other.difference_high), (RankStatus::MayBeChance, Some(0.0)));
    }

    #[test]
    fn planners_without_a_common_run_are_not_compared() {
        let ranked = rankings(&[row("one", 0, 0, 0.9), row("other", 1, 0, 0.5)]);
        for planner in ranked {
            assert_eq!((planner.runs, planner.left_out, planner.difference), (0, 1, None));
            assert_eq!(planner.verdict, RankStatus::TooFewWorlds);
        }
    }

    #[test]
    fn weights_sampling_and_engine_make_different_planners() {
        let mut rows = Vec::new();
        for (weights, vx_samples, engine) in
            [("fast", 8, "cpu"), ("fast", 16, "cpu"), ("shy", 8, "cpu"), ("shy", 8, "gpu")]
        {
            rows.push(RunRow {
                weights: Some(weights.to_owned()),
                vx_samples,
                vtheta_samples: 4,
                engine: engine.to_owned(),
                ..row("one", 0, 0, 0.5)
            });
        }
        let names = ["one, fast, 8x4", "one, fast, 16x4", "one, shy, cpu", "one, shy, gpu"];
        assert_eq!(planner_names(&rows), names);
        assert_eq!(rankings(&rows).len(), 4);
        // Another kind of worlds has settings of its own.
        let barn = RunRow { kind: WorldKind::Barn, vx_samples: 20, ..RunRow::default() };
        assert_eq!(planner_names(&[barn, RunRow::default()]), ["inbye", "inbye"]);
        let pair = |config: &str, weights: &str| RunRow {
            config: Some(config.to_owned()),
            weights: Some(weights.to_owned()),
            ..RunRow::default()
        };
        let names = planner_names(&[pair("a, b", "c"), pair("a", "b, c"), pair("a", "")]);
        assert_eq!(names, ["\"a, b\", c", "a, \"b, c\"", "a, \"\""]);
    }

    #[test]
    fn faults_of_failed_runs_are_counted() {
        let failed = |world| RunRow {
            outcome: RunOutcome::Failed,
            fault: Some("NO_VALID_PATH".to_owned()),
            ..row("one", world, 0, 0.0)
        };
        let error = RunRow {
            outcome: RunOutcome::Error,
            reason: Some("./mine: no such file".to_owned()),
            ..row("one", 2, 0, 0.0)
        };
        let ranked = rankings(&[failed(0), failed(1), error, row("one", 3, 0, 0.5)]);
        let text = "NO_VALID_PATH: 2; did not start: 1, ./mine: no such file";
        assert_eq!(ranked[0].faults.as_deref(), Some(text));
    }
}
