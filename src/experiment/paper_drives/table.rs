//! Tables 3 and 4 again: every drive, sums of them, and whether they are good enough.

use serde::Serialize;

use super::findings::findings;
use super::{
    Deviation, DriveRun, Drives, PrintedDeviations, Spread, Traffic, printed_table_3,
    printed_table_4,
};
use crate::bench::paper::{AblationTable, PathTable};

/// Largest mean deviation along an axis that is accepted, metres.
pub const MEAN_LIMIT_M: f64 = 0.01;
/// Largest mean deviation in yaw that is accepted, radians.
pub const MEAN_LIMIT_RAD: f64 = 0.01;
/// What the summary of all scenes is called.
pub const ALL_SCENES: &str = "all";

/// A table of the records.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PaperTable {
    /// Paths of variants.
    Paths(PathTable),
    /// What each step earns.
    Ablation(AblationTable),
    /// Drives.
    Drives(DriveTable),
}

impl PaperTable {
    /// One word, the same in every run.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Paths(table) => table.name,
            Self::Ablation(table) => table.name,
            Self::Drives(table) => table.name,
        }
    }

    /// What follows, in sentences.
    #[must_use]
    pub fn findings(&self) -> &[String] {
        match self {
            Self::Paths(table) => &table.findings,
            Self::Ablation(table) => &table.findings,
            Self::Drives(table) => &table.findings,
        }
    }
}

/// The drives of one kind of traffic beside the paper's ten.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveTable {
    /// One word, the same in every run.
    pub name: &'static str,
    /// One line.
    pub title: String,
    /// What moves.
    pub traffic: Traffic,
    /// Scene by scene, in each seed by seed.
    pub rows: Vec<DriveRun>,
    /// Of each scene, then of all.
    pub summaries: Vec<DriveSummary>,
    /// What the paper prints.
    pub paper: PrintedDeviations,
    /// Whether the drives are good enough.
    pub acceptance: Acceptance,
    /// What follows, in sentences.
    pub findings: Vec<String>,
}

/// Some drives in one row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveSummary {
    /// The scene, or [`ALL_SCENES`].
    pub scene: String,
    /// How many drives.
    pub runs: usize,
    /// How many reached the goal.
    pub reached: usize,
    /// How many touched anything.
    pub contacts: usize,
    /// In how many somebody came near.
    pub met_somebody: usize,
    /// Of those that reached the goal; missing where none did.
    pub deviation: Option<Spread>,
    /// Mean time, seconds.
    pub time_s: f64,
    /// Mean way driven, metres.
    pub travelled_m: f64,
    /// Mean length of the first path, metres.
    pub path_length_m: f64,
    /// Smallest gap to anything, metres.
    pub min_clearance_m: f64,
    /// Most global plans of a drive.
    pub plans: usize,
    /// Mean share of the time for which it stood still.
    pub waited_share: f64,
    /// Longest time for which it stood still, seconds.
    pub longest_wait_s: f64,
}

/// Whether drives are good enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Acceptance {
    /// None touched anything.
    pub no_contact: bool,
    /// All reached the goal.
    pub all_reached: bool,
    /// In every scene, and over all, the mean deviations are at most [`MEAN_LIMIT_M`] and [`MEAN_LIMIT_RAD`].
    pub means_within_limits: bool,
}

impl Acceptance {
    /// Whether they are in every respect.
    #[must_use]
    pub const fn is_met(&self) -> bool {
        self.no_contact && self.all_reached && self.means_within_limits
    }
}

impl DriveSummary {
    fn of(scene: &str, runs: &[DriveRun]) -> Self {
        let count = |is: fn(&DriveRun) -> bool| runs.iter().filter(|run| is(run)).count();
        let figures = |figure: fn(&DriveRun) -> f64| runs.iter().map(figure);
        let mean = |figure| figures(figure).sum::<f64>() / runs.len().max(1) as f64;
        let reached = runs.iter().filter(|run| run.reached);
        let deviations: Vec<Deviation> = reached.map(|run| run.deviation).collect();
        Self {
            scene: scene.to_owned(),
            runs: runs.len(),
            reached: deviations.len(),
            contacts: count(|run| run.collided),
            met_somebody: count(DriveRun::met_somebody),
            deviation: Spread::of(&deviations),
            time_s: mean(|run| run.time_s),
            travelled_m: mean(|run| run.travelled_m),
            path_length_m: mean(|run| run.path_length_m),
            min_clearance_m: figures(|run| run.min_clearance_m).fold(f64::INFINITY, f64::min),
            plans: runs.iter().map(|run| run.plans).max().unwrap_or(0),
            waited_share: mean(|run| run.waited_share),
            longest_wait_s: figures(|run| run.longest_wait_s).fold(0.0, f64::max),
        }
    }

    /// Whether the mean deviations are small enough; those of no drive are not.
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
    /// What must not be: drives that touched something or did not arrive, a sentence each. A robot that stands cannot keep
    /// people from walking into it who do not mind it: that is told among the findings, and is none of its faults.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let was_walked_into =
            |run: &DriveRun| self.traffic == Traffic::Heedless && run.collided && !run.was_moving();
        let bad = self
            .rows
            .iter()
            .filter(|run| (run.collided || !run.reached) && !was_walked_into(run));
        bad.map(|run| {
            let what = match (&run.fault, run.collided) {
                (_, true) => format!("contact, at {:.2} m/s", run.final_speed_m_s),
                (Some(fault), false) => format!("gave up: {fault}"),
                (None, false) => "did not arrive in time".to_owned(),
            };
            let (scene, seed, traffic) = (&run.scene, run.seed, self.traffic.words());
            format!(
                "{scene}, seed {seed}, {traffic}: {what} after {:.1} s",
                run.time_s
            )
        })
        .collect()
    }
}

/// The drives of one kind of traffic as a table: Table 3 where nobody is about, else Table 4.
#[must_use]
pub fn drive_table(drives: &Drives) -> DriveTable {
    let rows = drives.runs.clone();
    let words = drives.traffic.words();
    let (name, title, paper) = match drives.traffic {
        Traffic::Nobody => (
            "table_3",
            format!("Table 3, figs. 12 and 17: driven {words}"),
            printed_table_3(),
        ),
        Traffic::Minding => (
            "table_4",
            format!("Table 4, figs. 13, 18 and 19: driven {words}"),
            printed_table_4(),
        ),
        Traffic::Heedless => (
            "table_4_heedless",
            format!("Table 4 and fig. 13 once more: driven {words}"),
            printed_table_4(),
        ),
    };
    let summaries = summaries(&rows);
    let all = |is: fn(&DriveRun) -> bool| rows.iter().all(is);
    let acceptance = Acceptance {
        no_contact: all(|run| !run.collided),
        all_reached: all(|run| run.reached),
        means_within_limits: summaries.iter().all(DriveSummary::is_within_limits),
    };
    let mut table = DriveTable {
        name,
        title,
        traffic: drives.traffic,
        rows,
        summaries,
        paper,
        acceptance,
        findings: Vec::new(),
    };
    table.findings = findings(&table);
    table
}

fn summaries(rows: &[DriveRun]) -> Vec<DriveSummary> {
    let scenes = rows.chunk_by(|a, b| a.scene == b.scene);
    let each = scenes.map(|runs| (runs[0].scene.as_str(), runs));
    each.chain([(ALL_SCENES, rows)])
        .map(|(scene, runs)| DriveSummary::of(scene, runs))
        .collect()
}
