//! The variants of Tables 1 and 2, and of fig. 5, as rows.

use serde::Serialize;

use super::measure::{TaskRuns, Times};
use super::reduction::{Reduced, Reduction};
use super::search::{LITERAL_K, Search, Stage};

/// A search and the stage that it delivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Name in files.
    pub name: &'static str,
    /// Name for people.
    pub label: &'static str,
    /// The search.
    pub search: Search,
    /// The delivered stage.
    pub delivers: Stage,
}

const fn variant(
    name: &'static str,
    label: &'static str,
    search: Search,
    delivers: Stage,
) -> Variant {
    Variant { name, label, search, delivers }
}

/// The variants of Tables 1 and 2: both traditional ones first.
pub const VARIANTS: [Variant; 5] = [
    variant("traditional_manhattan", "traditional, Manhattan", Search::Manhattan, Stage::Raw),
    variant("traditional_euclid", "traditional, Euclid", Search::Euclid, Stage::Raw),
    variant("improved", "improved", Search::Improved, Stage::Smoothed),
    variant("literal", "literal eq. 19", Search::Literal(LITERAL_K), Stage::Smoothed),
    variant("jump_points", "jump points", Search::JumpPoints, Stage::Smoothed),
];

/// Number of traditional variants at the start of [`VARIANTS`].
pub const TRADITIONAL: usize = 2;

/// The angles of fig. 5: 45 degrees is the octile distance.
pub const THETAS: [Variant; 3] = [
    variant("theta_30", "30 degrees", Search::Theta(30.0), Stage::Raw),
    variant("theta_45", "45 degrees", Search::Theta(45.0), Stage::Raw),
    variant("theta_60", "60 degrees", Search::Theta(60.0), Stage::Raw),
];

/// The path of one variant for one task.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
pub struct StageMs {
    /// Of the search.
    pub search: f64,
    /// Of the pruning.
    pub prune: Option<f64>,
    /// Of the smoothing.
    pub smooth: Option<f64>,
}

/// A row for each task and variant whose search was run.
#[must_use]
pub fn path_rows(measured: &[TaskRuns], variants: &[Variant]) -> Vec<PathRow> {
    measured
        .iter()
        .flat_map(|task| variants.iter().filter_map(|variant| row(task, variant)))
        .collect()
}

fn row(task: &TaskRuns, variant: &Variant) -> Option<PathRow> {
    let run = task.of(variant.search)?;
    let raw = run.at(Stage::Raw);
    let delivered = run.at(variant.delivers);
    let after = |stage: Stage| run.stages.get(stage as usize);
    let turns_pruned = after(Stage::Pruned).map(|path| path.path.turns());
    Some(PathRow {
        task: task.task.name.clone(),
        variant: variant.name,
        label: variant.label,
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

/// Every other variant against each traditional one.
#[must_use]
pub fn reductions(rows: &[PathRow]) -> Vec<Reduction> {
    let (traditional, others) = VARIANTS.split_at(TRADITIONAL);
    let figures = |variant: &Variant, figure: fn(&PathRow) -> f64| -> Vec<f64> {
        let of_variant = rows.iter().filter(|row| row.variant == variant.name);
        of_variant.map(figure).collect()
    };
    others
        .iter()
        .flat_map(|variant| {
            traditional.iter().map(move |against| {
                let reduced = |figure: fn(&PathRow) -> f64| {
                    Reduced::of(&figures(against, figure), &figures(variant, figure))
                };
                Reduction {
                    variant: variant.name.to_owned(),
                    against: against.name.to_owned(),
                    time: reduced(|row| row.time_ms.p50_ms),
                    length: reduced(|row| row.length_m),
                    turns: reduced(|row| row.turns as f64),
                    turns_smoothed: reduced(|row| row.turns_smoothed.unwrap_or(row.turns) as f64),
                }
            })
        })
        .collect()
}

/// The label of a variant's name.
#[must_use]
pub fn label_of(name: &str) -> &str {
    VARIANTS
        .iter()
        .chain(&THETAS)
        .find(|variant| variant.name == name)
        .map_or(name, |variant| variant.label)
}
