//! Reduction of one variant's figures relative to another's, and the values that the paper publishes.

use serde::Serialize;

/// A row of the paper's tables; none for values that the paper does not print.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PublishedRow {
    /// Environment or path.
    pub task: &'static str,
    /// `traditional` or `improved`.
    pub variant: &'static str,
    /// Length, metres.
    pub length_m: Option<f64>,
    /// Time, milliseconds.
    pub time_ms: Option<f64>,
    /// Inflection points.
    pub turns: Option<u32>,
}

const BEFORE: &str = "traditional";
const AFTER: &str = "improved";

/// Table 1.
pub const PUBLISHED_TABLE_1: [PublishedRow; 6] = [
    table_1("Environment 1", BEFORE, 20.31, 19.69),
    table_1("Environment 1", AFTER, 18.85, 6.82),
    table_1("Environment 2", BEFORE, 20.34, 18.91),
    table_1("Environment 2", AFTER, 20.10, 5.20),
    table_1("Environment 3", BEFORE, 26.56, 21.81),
    table_1("Environment 3", AFTER, 26.21, 14.51),
];

/// Table 2.
pub const PUBLISHED_TABLE_2: [PublishedRow; 10] = [
    table_2("Path 1", BEFORE, 68.77, 13),
    table_2("Path 1", AFTER, 35.14, 5),
    table_2("Path 2", BEFORE, 62.70, 10),
    table_2("Path 2", AFTER, 32.15, 4),
    table_2("Path 3", BEFORE, 52.53, 6),
    table_2("Path 3", AFTER, 21.15, 2),
    table_2("Path 4", BEFORE, 29.14, 4),
    table_2("Path 4", AFTER, 15.43, 1),
    table_2("Path 5", BEFORE, 28.70, 5),
    table_2("Path 5", AFTER, 18.02, 0),
];

const fn table_1(
    task: &'static str,
    variant: &'static str,
    length_m: f64,
    time_ms: f64,
) -> PublishedRow {
    let (length_m, time_ms) = (Some(length_m), Some(time_ms));
    PublishedRow { task, variant, length_m, time_ms, turns: None }
}

const fn table_2(
    task: &'static str,
    variant: &'static str,
    time_ms: f64,
    turns: u32,
) -> PublishedRow {
    let (time_ms, turns) = (Some(time_ms), Some(turns));
    PublishedRow { task, variant, length_m: None, time_ms, turns }
}

/// A compared measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Measure {
    /// Time of planning.
    Time,
    /// Length of the path.
    Length,
    /// Turns of the path, before it is smoothed.
    Turns,
    /// Turns of the delivered path. The paper does not say which of the two it counts.
    TurnsSmoothed,
}

impl Measure {
    /// All measures, in the order in which they are shown.
    pub const ALL: [Self; 4] = [Self::Time, Self::Length, Self::Turns, Self::TurnsSmoothed];

    /// Its name in sentences.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Length => "length",
            Self::Turns => "turns",
            Self::TurnsSmoothed => "turns when smoothed",
        }
    }

    /// Decimals of a change in percent, as the paper prints them: lengths differ by little.
    pub(crate) const fn decimals(self) -> usize {
        if matches!(self, Self::Length) { 2 } else { 1 }
    }
}

/// A reduction as a share: 0.25 is a quarter less, a negative value is an increase. None if no values compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Reduced {
    /// Of the sums over all rows, as in the paper.
    pub of_sums: Option<f64>,
    /// Mean of the reductions of single rows; rows with zero before do not count.
    pub mean_of_rows: Option<f64>,
}

impl Reduced {
    /// Smallest reduction that counts: half of the last digit shown.
    pub(super) const LEAST: f64 = 0.000_5;

    /// Whether the reduction of the sums reaches a target, to the last digit shown; none if no values compare.
    pub(crate) fn reaches(&self, target: f64) -> Option<bool> {
        self.of_sums.map(|of_sums| of_sums >= target - Self::LEAST)
    }

    /// Computes the reduction from figures before and after, row by row.
    #[must_use]
    pub fn of(before: &[f64], after: &[f64]) -> Self {
        let share = |before: f64, after: f64| (before > 0.0).then(|| 1.0 - after / before);
        let rows: Vec<f64> =
            before.iter().zip(after).filter_map(|(&before, &after)| share(before, after)).collect();
        let mean = rows.iter().sum::<f64>() / rows.len() as f64;
        Self {
            of_sums: share(before.iter().sum(), after.iter().sum()),
            mean_of_rows: (!rows.is_empty()).then_some(mean),
        }
    }
}

/// The reductions of one variant against another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reduction {
    /// The variant.
    pub variant: &'static str,
    /// The variant that it is compared with.
    pub against: &'static str,
    /// Of the median times.
    pub time: Reduced,
    /// Of the lengths.
    pub length: Reduced,
    /// Of the turns before smoothing.
    pub turns: Reduced,
    /// Of the turns of the delivered paths.
    pub turns_smoothed: Reduced,
}

impl Reduction {
    /// Compares two variants; `figures` are those of a variant, a number for each row.
    pub(super) fn new(
        variant: &'static str,
        against: &'static str,
        figures: impl Fn(&str, Measure) -> Vec<f64>,
    ) -> Self {
        let [time, length, turns, turns_smoothed] = Measure::ALL
            .map(|measure| Reduced::of(&figures(against, measure), &figures(variant, measure)));
        Self { variant, against, time, length, turns, turns_smoothed }
    }

    /// The reduction of one measure.
    #[must_use]
    pub const fn of(&self, measure: Measure) -> Reduced {
        match measure {
            Measure::Time => self.time,
            Measure::Length => self.length,
            Measure::Turns => self.turns,
            Measure::TurnsSmoothed => self.turns_smoothed,
        }
    }
}

/// The paper's own reductions in a table, from its printed rows.
#[must_use]
pub fn published_reduction(rows: &[PublishedRow]) -> Reduction {
    Reduction::new(AFTER, BEFORE, |variant, measure| {
        let figure = |row: &PublishedRow| match measure {
            Measure::Time => row.time_ms,
            Measure::Length => row.length_m,
            Measure::Turns | Measure::TurnsSmoothed => row.turns.map(f64::from),
        };
        rows.iter().filter(|row| row.variant == variant).filter_map(figure).collect()
    })
}

/// Reductions that a table must reach to equal the paper: its own published reductions of sums or, without them, those of
/// the other table.
#[must_use]
pub fn targets(rows: &[PublishedRow]) -> [(Measure, f64); 4] {
    let reductions = [rows, &PUBLISHED_TABLE_1, &PUBLISHED_TABLE_2].map(published_reduction);
    Measure::ALL.map(|measure| {
        let printed = reductions.iter().find_map(|reduction| reduction.of(measure).of_sums);
        (measure, printed.unwrap_or(0.0))
    })
}
