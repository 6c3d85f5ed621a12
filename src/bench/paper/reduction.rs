//! Reduction of one variant's figures relative to another's.

use serde::Serialize;

use super::published::{PublishedRow, before_and_after};
use super::{published_table_1, published_table_2};

/// A reduction as a share: 0.25 is a quarter less, a negative value is an increase. None if no values compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Reduced {
    /// Of the sums over all rows, as in the paper.
    pub of_sums: Option<f64>,
    /// Mean of the reductions of single rows; rows with zero before do not count.
    pub mean_of_rows: Option<f64>,
}

impl Reduced {
    /// Computes the reduction from figures before and after, row by row.
    #[must_use]
    pub fn of(before: &[f64], after: &[f64]) -> Self {
        let rows: Vec<f64> =
            before.iter().zip(after).filter_map(|(&before, &after)| share(before, after)).collect();
        let mean = rows.iter().sum::<f64>() / rows.len() as f64;
        Self {
            of_sums: share(before.iter().sum(), after.iter().sum()),
            mean_of_rows: (!rows.is_empty()).then_some(mean),
        }
    }
}

fn share(before: f64, after: f64) -> Option<f64> {
    (before > 0.0).then(|| 1.0 - after / before)
}

/// A compared measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
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
}

/// The reductions of one variant against another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reduction {
    /// The variant.
    pub variant: String,
    /// The variant that it is compared with.
    pub against: String,
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
    let [before, after] = before_and_after(rows);
    let reduced = |figure: fn(&PublishedRow) -> Option<f64>| {
        let figures = |rows: &[PublishedRow]| rows.iter().filter_map(figure).collect::<Vec<_>>();
        Reduced::of(&figures(&before), &figures(&after))
    };
    Reduction {
        variant: "improved".to_owned(),
        against: "traditional".to_owned(),
        time: reduced(|row| row.time_ms),
        length: reduced(|row| row.length_m),
        turns: reduced(|row| row.turns.map(f64::from)),
        turns_smoothed: reduced(|row| row.turns.map(f64::from)),
    }
}

/// Reductions that a table must reach to equal the paper: its own published reductions of sums or, without them, those of
/// the other table.
#[must_use]
pub fn targets(rows: &[PublishedRow]) -> [(Measure, f64); 4] {
    let own = published_reduction(rows);
    let others = [published_table_1(), published_table_2()].map(|rows| published_reduction(&rows));
    Measure::ALL.map(|measure| {
        let printed = core::iter::once(&own)
            .chain(&others)
            .find_map(|reduction| reduction.of(measure).of_sums);
        (measure, printed.unwrap_or(0.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_reductions_agree_with_the_papers_text() {
        let near = |found: Option<f64>, printed: f64| {
            let found = found.expect("the table prints it");
            assert!((found - printed).abs() < 5.1e-5, "{found}, not {printed}");
        };
        let one = published_reduction(&published_table_1());
        near(one.time.of_sums, 0.5608);
        near(one.length.of_sums, 0.0305);
        near(one.time.mean_of_rows, 0.5711);
        assert_eq!(one.turns, Reduced::default());
        let two = published_reduction(&published_table_2());
        near(two.time.of_sums, 0.4960);
        near(two.turns.of_sums, 1.0 - 12.0 / 38.0);
        // Missing values come from the other table.
        let [_, (_, length), (_, turns), _] = targets(&published_table_2());
        near(Some(length), 0.0305);
        near(Some(turns), 1.0 - 12.0 / 38.0);
    }

    #[test]
    fn reduction_ignores_rows_of_zero() {
        let reduced = Reduced::of(&[0.0, 4.0], &[1.0, 1.0]);
        assert_eq!((reduced.of_sums, reduced.mean_of_rows), (Some(0.5), Some(0.75)));
        assert_eq!(Reduced::of(&[], &[]), Reduced::default());
    }
}
