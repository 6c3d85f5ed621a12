//! The tables, each with the paper's values beside it and what follows from it.

use serde::Serialize;

use super::ablation::{Breakdown, StepRow, breakdowns, step_rows};
use super::findings::{acceptance, literal, origin, theta};
use super::measure::TaskRuns;
use super::printed::PrintedRow;
use super::reduction::{Measure, Reduction, printed_reduction, targets};
use super::variants::{PathRow, THETAS, VARIANTS, path_rows, reductions};
use super::{printed_table_1, printed_table_2};

/// Paths of variants, one row for each task and variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathTable {
    /// One word, the same in every run.
    pub name: &'static str,
    /// One line.
    pub title: String,
    /// What was measured.
    pub rows: Vec<PathRow>,
    /// What the paper prints.
    pub paper: Vec<PrintedRow>,
    /// Every other variant against each traditional one.
    pub reductions: Vec<Reduction>,
    /// The paper's own.
    pub paper_reductions: Vec<Reduction>,
    /// What follows, in sentences.
    pub findings: Vec<String>,
}

/// What each step earns, summed over all tasks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AblationTable {
    /// One word, the same in every run.
    pub name: &'static str,
    /// One line.
    pub title: String,
    /// A row for each step.
    pub rows: Vec<StepRow>,
    /// Where each reduction comes from.
    pub breakdowns: Vec<Breakdown>,
    /// What follows, in sentences.
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
            printed_table_1(),
        ),
        figure_5(roadways),
        compared(
            "table_2",
            format!("Table 2, fig. 16: five ways through {mine_title}"),
            mine,
            printed_table_2(),
        ),
    ];
    let steps = vec![
        steps(
            "steps_roadways",
            "What each step earns: the three scenes",
            roadways,
        ),
        steps("steps_mine", "What each step earns: the mine", mine),
    ];
    (paths, steps)
}

fn compared(
    name: &'static str,
    title: String,
    measured: &[TaskRuns],
    paper: Vec<PrintedRow>,
) -> PathTable {
    let rows = path_rows(measured, &VARIANTS);
    let reductions = reductions(&rows);
    let targets = targets(&paper);
    let findings = reductions
        .iter()
        .filter(|reduction| reduction.variant != "literal")
        .map(|reduction| acceptance(reduction, &targets))
        .collect();
    PathTable {
        name,
        title,
        paper_reductions: vec![printed_reduction(&paper)],
        rows,
        paper,
        reductions,
        findings,
    }
}

fn figure_5(measured: &[TaskRuns]) -> PathTable {
    let rows = path_rows(measured, &THETAS);
    let findings = vec![theta(&rows)];
    PathTable {
        name: "figure_5",
        title: "Fig. 5: the angle of the distance model".to_owned(),
        rows,
        paper: Vec::new(),
        reductions: Vec::new(),
        paper_reductions: Vec::new(),
        findings,
    }
}

fn steps(name: &'static str, title: &str, measured: &[TaskRuns]) -> AblationTable {
    let rows = step_rows(measured);
    let breakdowns = breakdowns(&rows);
    // All are in the records; these answer where the paper's reductions come from, and where ours of time does.
    let is_told = |found: &&Breakdown| {
        found.chain == "improved"
            || (found.chain == "jump_points" && found.measure == Measure::Time)
    };
    let findings = breakdowns
        .iter()
        .filter(is_told)
        .map(origin)
        .chain(literal(&rows))
        .collect();
    AblationTable {
        name,
        title: title.to_owned(),
        rows,
        breakdowns,
        findings,
    }
}
