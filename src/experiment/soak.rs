//! The summary of a soak: many random missions, some of them driven again on another engine.

use std::collections::BTreeMap;

use serde::Serialize;

use super::group::{faults, groups_by, mean};
use super::{ContactCause, Group, RunRow, TrafficKind};
use crate::bench::{percentile, wilson_interval};
use crate::runtime::PlantKind;

/// Figures of a soak.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SoakSummary {
    /// All missions.
    pub all: Group,
    /// Share of missions that reached their goal.
    pub reached: Share,
    /// Share of missions that ended in a contact that the robot caused.
    pub contacts_robot: Share,
    /// Share of missions among people who do not yield that ended in a contact that they caused.
    pub contacts_of_non_yielding: Share,
    /// Number of missions by the name of their fault.
    pub faults: BTreeMap<String, usize>,
    /// Mean speed of the missions that reached their goal, m/s: all their distances over all their times.
    pub mean_speed_m_s: Option<f64>,
    /// True distance from the goal where it was reached.
    pub final_error: Option<FinalError>,
    /// Distance driven by all missions, metres.
    pub travelled_m: f64,
    /// Simulated time of all missions, seconds.
    pub time_s: f64,
    /// Each map, by name.
    pub worlds: Vec<Group>,
    /// Each kind of moving obstacles.
    pub traffic: Vec<Group>,
    /// Agreeing and disagreeing plants.
    pub plants: Vec<Group>,
    /// Response of the bases as the missions identified it; none without any.
    pub identified: Option<IdentifiedMotion>,
    /// Number of missions in which the protective layer changed a command.
    pub protected_missions: usize,
    /// Share of all ticks in which it did.
    pub protected_share: f64,
    /// Number of missions driven again on another engine.
    pub digests_compared: usize,
    /// Number of those with the same trace, to the last bit.
    pub digests_equal: usize,
}

/// A share of missions with its interval of 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Share {
    /// Number of missions that count.
    pub count: usize,
    /// Number of missions.
    pub of: usize,
    /// Lower and upper end of Wilson's interval, 0 to 1.
    pub interval_95: [f64; 2],
}

impl Share {
    /// Returns a number of missions out of all.
    #[must_use]
    pub fn new(count: usize, of: usize) -> Self {
        Self { count, of, interval_95: wilson_interval(count, of) }
    }
}

/// Response of the bases as the missions identified it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct IdentifiedMotion {
    /// Number of missions with an identified latency.
    pub missions: usize,
    /// Number of those whose interval of the latency ends below the drawn delay of commands.
    pub underestimated_delays: usize,
    /// Latency, seconds.
    pub delay_s: Spread,
    /// Deceleration, m/s^2.
    pub braking_m_s2: Spread,
    /// Measured over commanded turn rate; none where no mission identified it.
    pub turn_ratio: Option<Spread>,
}

/// Least, mean and largest value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Spread {
    /// The least value.
    pub least: f64,
    /// The mean.
    pub mean: f64,
    /// The largest value.
    pub largest: f64,
}

impl Spread {
    /// The spread of some values; none without any.
    fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        Some(Self {
            least: values.clone().reduce(f64::min)?,
            mean: mean(values.clone())?,
            largest: values.reduce(f64::max)?,
        })
    }
}

impl IdentifiedMotion {
    fn of(rows: &[RunRow]) -> Option<Self> {
        let spread =
            |figure: fn(&RunRow) -> Option<f64>| Spread::of(rows.iter().filter_map(figure));
        let is_below = |row: &&RunRow| {
            let ends = row.identified_delay_high_s.zip(row.command_delay_s);
            ends.is_some_and(|(high_s, true_s)| high_s < true_s)
        };
        Some(Self {
            missions: rows.iter().filter(|row| row.identified_delay_s.is_some()).count(),
            underestimated_delays: rows.iter().filter(is_below).count(),
            delay_s: spread(|row| row.identified_delay_s)?,
            braking_m_s2: spread(|row| row.identified_braking_m_s2)?,
            turn_ratio: spread(|row| row.turn_ratio),
        })
    }
}

/// True distance from the goal where it was reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FinalError {
    /// Mean distance, metres.
    pub mean_m: f64,
    /// 95th percentile, metres.
    pub p95_m: f64,
    /// Mean of the absolute yaw error, radians.
    pub mean_yaw_rad: f64,
    /// Its 95th percentile, radians.
    pub p95_yaw_rad: f64,
}

impl SoakSummary {
    /// The summary of rows, with the comparisons of some of them.
    #[must_use]
    pub fn of(rows: &[RunRow], comparisons: &[Comparison]) -> Self {
        let reached = || rows.iter().filter(|row| row.reached());
        let sum = |figure: fn(&RunRow) -> f64| -> f64 { reached().map(&figure).sum::<f64>() };
        let (distance_m, time_s) = (sum(|row| row.travelled_m), sum(|row| row.time_s));
        let faults = faults(rows).into_iter();
        let all = Group::of("all", rows);
        let non_yielding =
            || rows.iter().filter(|row| row.traffic == Some(TrafficKind::NonYielding));
        let caused = |row: &&RunRow| row.contact_cause == Some(ContactCause::Other);
        let protected = || rows.iter().filter_map(|row| row.protected_ticks);
        let ticks = rows.iter().map(|row| row.ticks).sum::<usize>().max(1);
        Self {
            reached: Share::new(all.reached, all.runs),
            contacts_robot: Share::new(all.contacts_robot, all.runs),
            contacts_of_non_yielding: Share::new(
                non_yielding().filter(caused).count(),
                non_yielding().count(),
            ),
            all,
            faults: faults.map(|(name, count)| (name.to_owned(), count)).collect(),
            mean_speed_m_s: (time_s > 0.0).then(|| distance_m / time_s),
            final_error: final_error(reached()),
            travelled_m: rows.iter().map(|row| row.travelled_m).sum::<f64>(),
            time_s: rows.iter().map(|row| row.time_s).sum::<f64>(),
            worlds: groups_by(rows, |row| row.world.clone()),
            traffic: groups_by(rows, |row| row.traffic.map_or("-", TrafficKind::name).to_owned()),
            plants: groups_by(rows, |row| plant_name(row).to_owned()),
            identified: IdentifiedMotion::of(rows),
            protected_missions: protected().filter(|ticks| *ticks > 0).count(),
            protected_share: protected().sum::<u64>() as f64 / ticks as f64,
            digests_compared: comparisons.len(),
            digests_equal: comparisons.iter().filter(|one| one.equal).count(),
        }
    }

    /// Whether the robot caused no contact, every unreached goal has a reason, and every compared digest is equal.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        self.all.contacts_robot == 0
            && self.all.unexplained == 0
            && self.digests_equal == self.digests_compared
    }
}

const fn plant_name(row: &RunRow) -> &'static str {
    match row.plant {
        Some(PlantKind::Agreeing) => "agreeing plant",
        Some(PlantKind::Disagreeing) => "disagreeing plant",
        None => "-",
    }
}

fn final_error<'a>(reached: impl Iterator<Item = &'a RunRow> + Clone) -> Option<FinalError> {
    let distances: Vec<f64> = reached.clone().filter_map(|row| row.final_error_m).collect();
    let yaws: Vec<f64> = reached.filter_map(|row| row.final_yaw_error_rad).map(f64::abs).collect();
    Some(FinalError {
        mean_m: mean(distances.iter().copied())?,
        p95_m: percentile(distances, 0.95)?,
        mean_yaw_rad: mean(yaws.iter().copied())?,
        p95_yaw_rad: percentile(yaws, 0.95)?,
    })
}

/// A run driven on two engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// Name of the world.
    pub world: String,
    /// The seed.
    pub seed: u64,
    /// The other engine.
    pub engine: Option<String>,
    /// The engine of the first run.
    pub first: Option<String>,
    /// Trace digest of the first run.
    pub expected: Option<String>,
    /// Trace digest of the other run.
    pub found: Option<String>,
    /// Whether the digests are equal.
    pub equal: bool,
}

/// Compares runs with the same runs on another engine. A run without a counterpart is left out.
#[must_use]
pub fn compare_digests(rows: &[RunRow], others: &[RunRow]) -> Vec<Comparison> {
    let compared = others.iter().filter_map(|other| {
        let is_same = |row: &&RunRow| {
            (&row.config, &row.world, row.seed) == (&other.config, &other.world, other.seed)
        };
        let row = rows.iter().find(is_same)?;
        Some(Comparison {
            world: row.world.clone(),
            seed: row.seed,
            engine: other.ran_on.clone(),
            first: row.ran_on.clone(),
            expected: row.trace_digest.clone(),
            found: other.trace_digest.clone(),
            equal: row.trace_digest == other.trace_digest,
        })
    });
    compared.collect()
}

/// Returns this many elements spread evenly over a list, or all of them.
#[must_use]
pub fn spread_evenly<T: Clone>(all: &[T], wanted: usize) -> Vec<T> {
    let wanted = wanted.min(all.len());
    (0..wanted).map(|index| all[index * all.len() / wanted].clone()).collect()
}
