//! Tables 3 and 4, repeated: every drive, summaries, and acceptance.

use serde::Serialize;

use super::findings::findings;
use super::{Deviation, PublishedDeviations, Spread, published_table_3, published_table_4};
use crate::bench::paper::{AblationTable, PathTable};
use crate::experiment::group::{omega_sign_changes_per_m, time_lost_per_person_s};
use crate::experiment::{RunRow, TrafficKind};

/// Largest mean deviation along an axis that is accepted, metres.
pub const MEAN_LIMIT_M: f64 = 0.01;
/// Largest mean deviation in yaw that is accepted, radians.
pub const MEAN_LIMIT_RAD: f64 = 0.01;
/// A person closer than this counts as near, metres between both edges.
pub const MET_WITHIN_M: f64 = 1.5;
/// Name of the summary of all scenes.
pub const ALL_SCENES: &str = "all";

/// A table of the paper, repeated.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PaperTable {
    /// Paths of variants.
    Paths(PathTable),
    /// The effect of each step.
    Ablation(AblationTable),
    /// Drives.
    Drives(DriveTable),
}

impl PaperTable {
    /// Its name in files.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Paths(table) => table.name,
            Self::Ablation(table) => table.name,
            Self::Drives(table) => table.name,
        }
    }
}

/// The drives of one kind of traffic, with the paper's ten.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DriveTable {
    /// Its name in files.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// The kind of traffic.
    pub traffic: TrafficKind,
    /// Scene by scene, in each seed by seed.
    pub rows: Vec<RunRow>,
    /// A summary of each scene, then of all.
    pub summaries: Vec<DriveSummary>,
    /// The paper's table.
    pub paper: PublishedDeviations,
    /// Whether the drives are good enough.
    pub acceptance: Acceptance,
    /// Findings, in sentences.
    pub findings: Vec<String>,
}

/// Figures over several drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DriveSummary {
    /// The scene, or [`ALL_SCENES`].
    pub scene: String,
    /// Number of drives.
    pub runs: usize,
    /// Number of drives that reached the goal.
    pub reached: usize,
    /// Number of drives that ended in contact.
    pub contacts: usize,
    /// Number of drives in which a person came near.
    pub near_people: usize,
    /// Deviations of the drives that reached the goal; none if no drive did.
    pub deviation: Option<Spread>,
    /// Mean time, seconds.
    pub time_s: f64,
    /// Mean distance driven, metres.
    pub travelled_m: f64,
    /// Mean length of the first path, metres.
    pub path_length_m: f64,
    /// Smallest gap to any obstacle, metres.
    pub min_clearance_m: f64,
    /// Sign changes of the turn rate per metre driven; none where no robot drove.
    pub omega_sign_changes_per_m: Option<f64>,
    /// Mean time lost for each person met, seconds; none where no drive knows it.
    pub time_lost_per_person_s: Option<f64>,
    /// Largest number of global plans of a drive.
    pub plans: usize,
    /// Mean share of the time in which the robot stood.
    pub waited_share: f64,
    /// Longest time in which it stood, seconds.
    pub longest_wait_s: f64,
}

/// Whether drives are good enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Acceptance {
    /// No drive ended in contact.
    pub no_contact: bool,
    /// All drives reached the goal.
    pub all_reached: bool,
    /// In every scene, and over all, the mean deviations are at most [`MEAN_LIMIT_M`] and [`MEAN_LIMIT_RAD`].
    pub means_within_limits: bool,
}

impl Acceptance {
    /// Whether all criteria are met.
    #[must_use]
    pub const fn is_met(&self) -> bool {
        self.no_contact && self.all_reached && self.means_within_limits
    }
}

impl DriveSummary {
    fn of(scene: &str, runs: &[RunRow]) -> Self {
        let count = |is: fn(&RunRow) -> bool| runs.iter().filter(|run| is(run)).count();
        let figures = |figure: fn(&RunRow) -> f64| runs.iter().map(figure);
        let mean = |figure| figures(figure).sum::<f64>() / runs.len().max(1) as f64;
        let reached = runs.iter().filter(|run| run.reached());
        let deviations: Vec<Deviation> = reached.map(Deviation::of).collect();
        Self {
            scene: scene.to_owned(),
            runs: runs.len(),
            reached: deviations.len(),
            contacts: count(RunRow::collided),
            near_people: count(|run| run.nearest_moving_m.is_some_and(|it| it <= MET_WITHIN_M)),
            deviation: Spread::of(&deviations),
            time_s: mean(|run| run.time_s),
            travelled_m: mean(|run| run.travelled_m),
            path_length_m: mean(|run| run.path_m.unwrap_or_default()),
            min_clearance_m: runs
                .iter()
                .filter_map(|run| run.min_clearance_m)
                .fold(f64::INFINITY, f64::min),
            omega_sign_changes_per_m: omega_sign_changes_per_m(runs.iter()),
            time_lost_per_person_s: time_lost_per_person_s(runs.iter()),
            plans: runs.iter().map(|run| run.plans).max().unwrap_or(0),
            waited_share: mean(|run| run.waited_share.unwrap_or_default()),
            longest_wait_s: figures(|run| run.longest_wait_s.unwrap_or_default())
                .fold(0.0, f64::max),
        }
    }

    /// Whether the mean deviations are within the limits; false if no drive arrived.
    #[must_use]
    pub fn is_within_limits(&self) -> bool {
        self.deviation.is_some_and(|Spread { mean, .. }| {
            mean.dx_m <= MEAN_LIMIT_M
                && mean.dy_m <= MEAN_LIMIT_M
                && mean.dyaw_rad <= MEAN_LIMIT_RAD
        })
    }
}

impl DriveTable {
    /// Drives with contact or without arrival, a sentence each. A standing robot cannot prevent contact with people who do
    /// not yield: that is a finding, not a fault.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let was_hit_standing = |run: &RunRow| {
            self.traffic == TrafficKind::NonYielding && run.collided() && !run.was_moving()
        };
        let bad = self.rows.iter().filter(|run| !run.reached() && !was_hit_standing(run));
        bad.map(|run| {
            let after = format!("after {:.1} s", run.time_s);
            let what = match (&run.fault, &run.reason) {
                _ if run.collided() => {
                    let speed_m_s = run.final_speed_m_s.unwrap_or_default();
                    format!("contact, at {speed_m_s:.2} m/s {after}")
                }
                (_, Some(reason)) if run.ticks == 0 => {
                    format!("did not start: {reason}: try another seed")
                }
                (Some(_), Some(reason)) => format!("gave up: {reason} {after}"),
                _ => format!("did not arrive in time {after}"),
            };
            let (scene, seed, traffic) = (scene(run), run.seed, text(self.traffic));
            format!("{scene}, seed {seed}, {traffic}: {what}")
        })
        .collect()
    }
}

/// The scene of a drive.
#[must_use]
pub fn scene(run: &RunRow) -> &str {
    run.world.split(' ').next().unwrap_or_default()
}

/// The drives of one kind of traffic as a table: Table 3 without people, else Table 4. The rows are sorted by scene, then
/// by seed.
#[must_use]
pub fn drive_table(traffic: TrafficKind, rows: Vec<RunRow>) -> DriveTable {
    let text = text(traffic);
    let (name, title, paper) = match traffic {
        TrafficKind::None => {
            ("table_3", format!("Table 3, figs. 12 and 17: driven {text}"), published_table_3())
        }
        TrafficKind::Yielding
        | TrafficKind::Appearing
        | TrafficKind::Starting
        | TrafficKind::SteppingOut => {
            ("table_4", format!("Table 4, figs. 13, 18 and 19: driven {text}"), published_table_4())
        }
        TrafficKind::NonYielding => (
            "table_4_non_yielding",
            format!("Table 4 and fig. 13 again: driven {text}"),
            published_table_4(),
        ),
    };
    let summaries = summaries(&rows);
    let all = |is: fn(&RunRow) -> bool| rows.iter().all(is);
    let acceptance = Acceptance {
        no_contact: all(|run| !run.collided()),
        all_reached: all(RunRow::reached),
        means_within_limits: summaries.iter().all(DriveSummary::is_within_limits),
    };
    let mut table = DriveTable {
        name,
        title,
        traffic,
        rows,
        summaries,
        paper,
        acceptance,
        findings: Vec::new(),
    };
    table.findings = findings(&table);
    table
}

/// The kind of traffic, after "driven".
const fn text(traffic: TrafficKind) -> &'static str {
    match traffic {
        TrafficKind::None => "without people",
        TrafficKind::Yielding => "among people who yield",
        TrafficKind::NonYielding => "among people who do not yield",
        TrafficKind::Appearing => "among people who appear",
        TrafficKind::Starting => "among people who start to walk",
        TrafficKind::SteppingOut => "among people who step out",
    }
}

fn summaries(rows: &[RunRow]) -> Vec<DriveSummary> {
    let scenes = rows.chunk_by(|a, b| scene(a) == scene(b));
    let each = scenes.map(|runs| (scene(&runs[0]), runs));
    each.chain([(ALL_SCENES, rows)]).map(|(scene, runs)| DriveSummary::of(scene, runs)).collect()
}
