//! The tables, each with the paper's values and the findings.

use serde::Serialize;

use super::ablation::{Breakdown, StepRow, breakdowns, step_rows};
use super::findings::{acceptance, literal, origin, theta};
use super::measure::TaskRuns;
use super::published::PublishedRow;
use super::reduction::{Measure, Reduction, published_reduction, targets};
use super::variants::{PathRow, THETAS, VARIANTS, path_rows, reductions};
use super::{published_table_1, published_table_2};

/// Paths of variants, one row for each task and variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
            published_table_1(),
        ),
        figure_5(roadways),
        compared(
            "table_2",
            format!("Table 2, fig. 16: five paths through {mine_title}"),
            mine,
            published_table_2(),
        ),
    ];
    let steps = vec![
        steps("steps_roadways", "Effect of each step: the three scenes", roadways),
        steps("steps_mine", "Effect of each step: the mine", mine),
    ];
    (paths, steps)
}

fn compared(
    name: &'static str,
    title: String,
    measured: &[TaskRuns],
    paper: Vec<PublishedRow>,
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
        paper_reductions: vec![published_reduction(&paper)],
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
    // These breakdowns explain the paper's reductions and our reduction of time; the files contain all of them.
    let is_shown = |found: &&Breakdown| {
        found.chain == "improved"
            || (found.chain == "jump_points" && found.measure == Measure::Time)
    };
    let findings = breakdowns.iter().filter(is_shown).map(origin).chain(literal(&rows)).collect();
    AblationTable { name, title: title.to_owned(), rows, breakdowns, findings }
}
