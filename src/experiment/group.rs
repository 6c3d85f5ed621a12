//! Figures over the runs of a group.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{ContactCause, RunOutcome, RunRow, WorldKind};
use crate::bench::columns::columns;
use crate::bench::{percentile, percentiles};

columns! {
    /// The figures of a group of runs. What the runs do not have in common, such as `config` of a mixed group, is that of the
    /// first.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct Group {
        /// Name of the group.
        pub name: String,
        /// Kind of the worlds.
        pub kind: WorldKind,
        /// Name of the settings.
        pub config: Option<String>,
        /// Name of the weights.
        pub weights: Option<String>,
        /// The engine.
        pub engine: String,
        /// Forward speeds.
        pub vx_samples: u32,
        /// Turn rates.
        pub vtheta_samples: u32,
        /// Samples: the product of the two.
        pub samples: u64,
        /// Number of worlds.
        pub worlds: usize,
        /// Number of runs.
        pub runs: usize,
        /// Number of runs that reached their goal.
        pub reached: usize,
        /// Their share, 0 to 1; zero of no runs.
        pub reached_share: f64 => 3,
        /// The same without the runs that ended in a contact that the robot neither caused nor could have avoided; none where
        /// no run is left.
        pub attributed_share: Option<f64> => 3,
        /// Number of runs that ended in contact.
        pub contacts: usize,
        /// Contacts that the robot's own motion caused.
        pub contacts_robot: usize,
        /// Contacts that an obstacle caused and the robot could have avoided.
        pub contacts_avoidable: usize,
        /// All other contacts.
        pub contacts_other: usize,
        /// Number of runs that ran out of time.
        pub timeouts: usize,
        /// Number of runs in which the navigator gave up, or that did not start.
        pub failed: usize,
        /// Number of unreached goals without a reason.
        pub unexplained: usize,
        /// Mean time of the runs that reached their goal, seconds.
        pub mean_time_s: Option<f64> => 2,
        /// Time over that of the group with the densest sampling, the mean over the worlds and seeds that both reached.
        pub mean_time_ratio: Option<f64> => 3,
        /// Number of worlds and seeds that all groups with any success reached. Only over these do times compare.
        pub shared: usize,
        /// Mean time over these, seconds; none where there are none, or the group has no success.
        pub mean_shared_time_s: Option<f64> => 2,
        /// Median time over these, seconds.
        pub shared_time_p50_s: Option<f64> => 2,
        /// 90th percentile of the time over these, seconds.
        pub shared_time_p90_s: Option<f64> => 2,
        /// BARN's mean score, 0 to 0.5.
        pub mean_score: Option<f64> => 4,
        /// Mean of the time over BARN's optimal time (T/OT), over the runs that reached their goal.
        pub mean_time_over_optimal: Option<f64> => 3,
        /// Mean of the smallest gaps, metres.
        pub mean_clearance_m: Option<f64> => 3,
        /// The same over the runs that reached their goal.
        pub mean_clearance_reached_m: Option<f64> => 3,
        /// 5th percentile of the smallest gaps of all runs, metres.
        pub clearance_p05_m: Option<f64> => 3,
        /// Sign changes of the turn rate per metre that the runs drove together, 1/m.
        pub omega_sign_changes_per_m: Option<f64> => 3,
        /// Mean time lost for each person met, seconds, over the runs that know it.
        pub time_lost_per_person_s: Option<f64> => 2,
        /// Wall-clock time of a tick, the median over the runs of their medians, milliseconds.
        pub tick_p50_ms: Option<f64> => 3,
        /// The median over the runs of their 99th percentiles, milliseconds. Ticks that wait for a global path are among
        /// these.
        pub tick_p99_ms: Option<f64> => 3,
    }
}

/// A world and a seed, without the settings and the engine.
type Task<'a> = (&'a str, u64);

/// Groups runs by kind, settings, weights, engine and sampling, in the order in which the groups first occur. A name is
/// that of the settings or of the sampling, whichever differs.
#[must_use]
pub fn groups(rows: &[RunRow]) -> Vec<Group> {
    let all = grouped(rows, |row| {
        let sampling = (row.vx_samples, row.vtheta_samples);
        let settings = (row.config.clone(), row.weights.clone());
        (row.kind, settings, row.engine.clone(), sampling)
    });
    let times: Vec<BTreeMap<Task<'_>, f64>> = all.iter().map(|(_, rows)| times_s(rows)).collect();
    let shared = |kind| {
        let of_kind = all.iter().zip(&times);
        of_kind
            .filter(|((_, rows), times)| rows[0].kind == kind && !times.is_empty())
            .map(|(_, times)| times.keys().copied().collect::<BTreeSet<_>>())
            .reduce(|one, other| &one & &other)
            .unwrap_or_default()
    };
    let densest = |first: &RunRow| {
        let comparable = all.iter().zip(&times).filter(|((_, rows), _)| {
            let other = rows[0];
            (other.kind, &other.config, &other.weights, &other.engine)
                == (first.kind, &first.config, &first.weights, &first.engine)
        });
        // The search runs from the end, so of equally dense ones the first counts.
        let comparable: Vec<_> = comparable.collect();
        let densest = comparable.into_iter().rev();
        densest.max_by_key(|((_, rows), _)| {
            u64::from(rows[0].vx_samples) * u64::from(rows[0].vtheta_samples)
        })
    };
    let of = |((_, rows), own): (&(_, Vec<&RunRow>), &BTreeMap<Task<'_>, f64>)| {
        let shared = shared(rows[0].kind);
        let shared_s = rows.iter().filter(|row| shared.contains(&task(row)));
        let shared_s: Vec<f64> =
            shared_s.filter(|row| row.reached()).map(|row| row.time_s).collect();
        let ratios = rows.iter().filter_map(|row| {
            let (_, times) = densest(rows[0])?;
            let least_s = times.get(&task(row)).filter(|&&least_s| least_s > 0.0)?;
            own.get(&task(row)).map(|time_s| time_s / least_s)
        });
        let mean_shared_time_s = mean(shared_s.iter().copied());
        let [shared_time_p50_s, shared_time_p90_s] = percentiles(shared_s, [0.5, 0.9]);
        Group {
            mean_time_ratio: mean(ratios),
            shared: shared.len(),
            mean_shared_time_s,
            shared_time_p50_s,
            shared_time_p90_s,
            ..Group::of("", rows.iter().copied())
        }
    };
    all.iter().zip(&times).map(of).collect()
}

/// Groups runs by a name, in the order of the names.
pub(super) fn groups_by(rows: &[RunRow], name: impl Fn(&RunRow) -> String) -> Vec<Group> {
    let mut all = grouped(rows, |row| name(row));
    all.sort_by(|one, other| one.0.cmp(&other.0));
    all.into_iter().map(|(name, rows)| Group::of(&name, rows)).collect()
}

/// Groups runs by the name of their settings, in the order in which the names first occur. Runs without one have none.
pub(crate) fn by_settings(rows: &[RunRow]) -> Vec<Group> {
    let all = grouped(rows, |row| row.config.clone().unwrap_or_default());
    all.into_iter().map(|(name, rows)| Group::of(&name, rows)).collect()
}

/// Rows with the same key together, in the order in which the keys first occur.
pub(crate) fn grouped<R, K: PartialEq>(
    rows: impl IntoIterator<Item = R>,
    key: impl Fn(&R) -> K,
) -> Vec<(K, Vec<R>)> {
    let mut all: Vec<(K, Vec<R>)> = Vec::new();
    for row in rows {
        let key = key(&row);
        match all.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(row),
            None => all.push((key, vec![row])),
        }
    }
    all
}

/// The runs of each world, numbered worlds by their numbers.
pub(crate) fn by_world<'r>(
    rows: impl IntoIterator<Item = &'r RunRow>,
) -> Vec<(&'r str, Vec<&'r RunRow>)> {
    let mut all = grouped(rows, |row| row.world.as_str());
    all.sort_by_key(|&(world, _)| (world.len(), world));
    all
}

fn task(row: &RunRow) -> Task<'_> {
    (row.world.as_str(), row.seed)
}

/// The time of each world and seed that was reached, seconds.
fn times_s<'a>(rows: &[&'a RunRow]) -> BTreeMap<Task<'a>, f64> {
    let reached = rows.iter().filter(|row| row.reached());
    reached.map(|row| (task(row), row.time_s)).collect()
}

impl Group {
    /// The columns of a short table, separated by spaces.
    pub const SUMMARY: &str = "kind config weights engine vx_samples vtheta_samples runs reached contacts mean_time_s \
        shared mean_shared_time_s";

    /// The columns of a table of how runs end, separated by spaces.
    pub const ENDS: &str = "name runs reached_share contacts_robot contacts_avoidable contacts_other timeouts failed \
        mean_time_s mean_clearance_reached_m clearance_p05_m omega_sign_changes_per_m time_lost_per_person_s";

    /// The figures of runs that are not compared with other groups.
    #[must_use]
    pub fn of<'r>(name: &str, rows: impl IntoIterator<Item = &'r RunRow>) -> Self {
        let rows: Vec<&RunRow> = rows.into_iter().collect();
        let count = |is: &dyn Fn(&RunRow) -> bool| rows.iter().filter(|row| is(row)).count();
        let ended = |outcome| count(&|row| row.outcome == outcome);
        let caused = |cause| count(&|row| row.contact_cause == Some(cause));
        let all =
            |figure: fn(&RunRow) -> Option<f64>| rows.iter().filter_map(move |row| figure(row));
        let middle = |figure| percentile(all(figure).collect(), 0.5);
        let reached = || rows.iter().filter(|row| row.reached());
        let share = |of: usize| (of > 0).then(|| reached().count() as f64 / of as f64);
        let first = rows.first().copied().cloned().unwrap_or_default();
        let worlds: BTreeSet<&str> = rows.iter().map(|row| row.world.as_str()).collect();
        let contacts_other = caused(ContactCause::Other);
        Self {
            name: name.to_owned(),
            kind: first.kind,
            samples: u64::from(first.vx_samples) * u64::from(first.vtheta_samples),
            config: first.config,
            weights: first.weights,
            engine: first.engine,
            vx_samples: first.vx_samples,
            vtheta_samples: first.vtheta_samples,
            worlds: worlds.len(),
            runs: rows.len(),
            reached: reached().count(),
            reached_share: share(rows.len()).unwrap_or_default(),
            attributed_share: share(rows.len() - contacts_other),
            contacts: ended(RunOutcome::Contact),
            contacts_robot: caused(ContactCause::Robot),
            contacts_avoidable: caused(ContactCause::Avoidable),
            contacts_other,
            timeouts: ended(RunOutcome::Timeout),
            failed: ended(RunOutcome::Failed) + ended(RunOutcome::Error),
            unexplained: count(&|row| {
                !row.reached() && row.reason.as_deref().is_none_or(str::is_empty)
            }),
            mean_time_s: mean(reached().map(|row| row.time_s)),
            mean_score: mean(all(|row| row.score)),
            mean_time_over_optimal: mean(
                reached().filter_map(|row| Some(row.time_s / row.optimal_time_s?)),
            ),
            mean_clearance_m: mean(all(|row| row.min_clearance_m)),
            clearance_p05_m: percentile(all(|row| row.min_clearance_m).collect(), 0.05),
            omega_sign_changes_per_m: omega_sign_changes_per_m(rows.iter().copied()),
            time_lost_per_person_s: time_lost_per_person_s(rows.iter().copied()),
            mean_clearance_reached_m: mean(reached().filter_map(|row| row.min_clearance_m)),
            tick_p50_ms: middle(|row| row.tick_p50_ms),
            tick_p99_ms: middle(|row| row.tick_p99_ms),
            ..Self::default()
        }
    }
}

/// The number of runs of each fault, by Nav2's name.
#[must_use]
pub fn faults<'r>(rows: impl IntoIterator<Item = &'r RunRow>) -> BTreeMap<&'r str, usize> {
    let mut faults = BTreeMap::new();
    for fault in rows.into_iter().filter_map(|row| row.fault.as_deref()) {
        *faults.entry(fault).or_insert(0) += 1;
    }
    faults
}

/// The sum of a figure over the sum of another, over the rows that have both; none where the other one is zero.
fn ratio<'a>(
    rows: impl Iterator<Item = &'a RunRow>,
    figures: impl Fn(&RunRow) -> Option<(f64, f64)>,
) -> Option<f64> {
    let sum = |sums: (f64, f64), figures: (f64, f64)| (sums.0 + figures.0, sums.1 + figures.1);
    let (above, below) = rows.filter_map(figures).fold((0.0, 0.0), sum);
    (below > 0.0).then(|| above / below)
}

/// Sign changes of the turn rate per metre that runs drove together, 1/m.
pub(in crate::experiment) fn omega_sign_changes_per_m<'a>(
    rows: impl Iterator<Item = &'a RunRow>,
) -> Option<f64> {
    ratio(rows, |row| Some((row.omega_sign_changes_per_m? * row.travelled_m, row.travelled_m)))
}

/// Mean time lost for each person met, seconds, over the runs that know it.
pub(in crate::experiment) fn time_lost_per_person_s<'a>(
    rows: impl Iterator<Item = &'a RunRow>,
) -> Option<f64> {
    ratio(rows, |row| Some((row.people_time_lost_s?, row.people_met? as f64)))
}

/// The mean of values; none of no values.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
