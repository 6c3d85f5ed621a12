//! The tables, each with the paper's values and the findings.

use serde::Serialize;

use super::ablation::{Breakdown, StepRow, breakdowns, step_rows};
use super::findings::{acceptance, literal, origin, theta};
use super::measure::{TaskRuns, Times};
use super::reduction::{
    Measure, PUBLISHED_TABLE_1, PUBLISHED_TABLE_2, PublishedRow, Reduction, published_reduction,
    targets,
};
use super::search::{Search, Stage, THETAS, TRADITIONAL, VARIANTS};

/// The path of one variant for one task.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PathRow {
    /// Scene or path.
    pub task: String,
    /// The variant's name.
    pub variant: &'static str,
    /// Label in text for people.
    pub label: &'static str,
    /// Length of the delivered path, metres.
    pub length_m: f64,
    /// Its turns before smoothing: those of the raw path if that is delivered, else those of the pruned path.
    pub turns: usize,
    /// Turns of the path as searched.
    pub turns_raw: usize,
    /// Turns without redundant nodes; none if nothing was pruned.
    pub turns_pruned: Option<usize>,
    /// Turns of the smoothed path; none if nothing was smoothed.
    pub turns_smoothed: Option<usize>,
    /// Smallest distance of the delivered path to an obstacle, metres.
    pub min_clearance_m: f64,
    /// Time from the start to the delivered path.
    pub time_ms: Times,
    /// Median time of each stage alone.
    pub stage_ms: StageMs,
    /// Cells expanded.
    pub expanded: u32,
    /// Length of the path as searched, metres.
    pub raw_length_m: f64,
    /// Excess length over a shortest path on the grid, as a share.
    pub over_shortest: f64,
    /// Whether the search always finds a shortest path.
    pub exact: bool,
}

/// Median times of the stages, milliseconds; none for a stage that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StageMs {
    /// Of the search.
    pub search: f64,
    /// Of the pruning.
    pub prune: Option<f64>,
    /// Of the smoothing.
    pub smooth: Option<f64>,
}

impl PathRow {
    /// The row of a variant; none if its search was not run.
    fn new(task: &TaskRuns, variant: &Search) -> Option<Self> {
        let run = task.of(*variant)?;
        let raw = run.at(Stage::Raw);
        let delivered = run.at(variant.last_stage);
        let after = |stage: Stage| run.stages.get(stage as usize);
        let turns_pruned = after(Stage::Pruned).map(|path| path.path.turns());
        Some(Self {
            task: task.task.name.clone(),
            variant: variant.variant.0,
            label: variant.variant.1,
            length_m: delivered.path.length_m(),
            turns: turns_pruned.unwrap_or_else(|| raw.path.turns()),
            turns_raw: raw.path.turns(),
            turns_pruned,
            turns_smoothed: after(Stage::Smoothed).map(|path| path.path.turns()),
            min_clearance_m: delivered.min_clearance_m,
            time_ms: delivered.time,
            stage_ms: StageMs {
                search: raw.own_ms,
                prune: after(Stage::Pruned).map(|path| path.own_ms),
                smooth: after(Stage::Smoothed).map(|path| path.own_ms),
            },
            expanded: run.expanded,
            raw_length_m: raw.path.length_m(),
            over_shortest: task.over_shortest(run),
            exact: run.search.is_exact(),
        })
    }

    fn figure(&self, measure: Measure) -> f64 {
        match measure {
            Measure::Time => self.time_ms.p50_ms,
            Measure::Length => self.length_m,
            Measure::Turns => self.turns as f64,
            Measure::TurnsSmoothed => self.turns_smoothed.unwrap_or(self.turns) as f64,
        }
    }
}

/// Paths of variants, one row for each task and variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PathTable {
    /// Name in files.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// Measured rows.
    pub rows: Vec<PathRow>,
    /// The paper's rows.
    pub paper: Vec<PublishedRow>,
    /// Every other variant against each traditional one.
    pub reductions: Vec<Reduction>,
    /// The paper's own comparisons.
    pub paper_reductions: Vec<Reduction>,
    /// Findings, in sentences.
    pub findings: Vec<String>,
}

/// The effect of each step, summed over all tasks.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AblationTable {
    /// Name in files.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// A row for each step.
    pub rows: Vec<StepRow>,
    /// The breakdown of each reduction.
    pub breakdowns: Vec<Breakdown>,
    /// Findings, in sentences.
    pub findings: Vec<String>,
}

/// All tables of global paths: Table 1 and fig. 5 and their steps from the roadways, Table 2 and its steps from the mine.
#[must_use]
pub fn path_tables(
    roadways: &[TaskRuns],
    mine: &[TaskRuns],
    mine_title: &str,
) -> (Vec<PathTable>, Vec<AblationTable>) {
    let paths = vec![
        compared(
            "table_1",
            "Table 1, figs. 9 to 11: three roadway scenes".to_owned(),
            roadways,
            &PUBLISHED_TABLE_1,
        ),
        figure_5(roadways),
        compared(
            "table_2",
            format!("Table 2, fig. 16: five paths through {mine_title}"),
            mine,
            &PUBLISHED_TABLE_2,
        ),
    ];
    let steps = vec![
        steps("steps_roadways", "Effect of each step: the three scenes", roadways),
        steps("steps_mine", "Effect of each step: the mine", mine),
    ];
    (paths, steps)
}

/// A row for each task and variant whose search was run.
fn path_rows(measured: &[TaskRuns], variants: &[Search]) -> Vec<PathRow> {
    let of_task = |task| variants.iter().filter_map(move |variant| PathRow::new(task, variant));
    measured.iter().flat_map(of_task).collect()
}

fn compared(
    name: &'static str,
    title: String,
    measured: &[TaskRuns],
    paper: &[PublishedRow],
) -> PathTable {
    let rows = path_rows(measured, &VARIANTS);
    let figures = |variant: &str, measure: Measure| {
        let of_variant = rows.iter().filter(|row| row.variant == variant);
        of_variant.map(|row| row.figure(measure)).collect()
    };
    let (traditional, others) = VARIANTS.split_at(TRADITIONAL);
    let pairs = others.iter().flat_map(|other| traditional.iter().map(move |it| (other, it)));
    let reductions: Vec<Reduction> = pairs
        .map(|(other, against)| Reduction::new(other.variant.0, against.variant.0, figures))
        .collect();
    let targets = targets(paper);
    let findings = reductions
        .iter()
        .filter(|reduction| reduction.variant != Search::LITERAL.variant.0)
        .map(|reduction| acceptance(reduction, &targets))
        .collect();
    PathTable {
        name,
        title,
        paper_reductions: vec![published_reduction(paper)],
        rows,
        paper: paper.to_vec(),
        reductions,
        findings,
    }
}

fn figure_5(measured: &[TaskRuns]) -> PathTable {
    let rows = path_rows(measured, &THETAS);
    PathTable {
        name: "figure_5",
        title: "Fig. 5: the angle of the distance model".to_owned(),
        findings: vec![theta(&rows)],
        rows,
        ..PathTable::default()
    }
}

fn steps(name: &'static str, title: &str, measured: &[TaskRuns]) -> AblationTable {
    let rows = step_rows(measured);
    let breakdowns = breakdowns(&rows);
    // These breakdowns explain the paper's reductions and our reduction of time; the files contain all of them.
    let is_shown = |found: &&Breakdown| {
        found.chain == Search::IMPROVED.name
            || (found.chain == Search::JUMP_POINTS.name && found.measure == Measure::Time)
    };
    let findings = breakdowns.iter().filter(is_shown).map(origin).chain(literal(&rows)).collect();
    AblationTable { name, title: title.to_owned(), rows, breakdowns, findings }
}
