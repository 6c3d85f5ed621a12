//! The searches that are compared.

use serde::Serialize;

use crate::global::Heuristic;

/// A processing stage of a path; each stage includes those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// As the search returns it.
    Raw,
    /// Without redundant nodes.
    Pruned,
    /// Smoothed.
    Smoothed,
}

impl Stage {
    /// All stages in their order.
    pub const ALL: [Self; 3] = [Self::Raw, Self::Pruned, Self::Smoothed];
}

/// Weight of [`Search::LITERAL`]. The paper prints no weight, so the formula has no factor.
pub(super) const LITERAL_K: f64 = 1.0;
/// A weight for which the literal formula is nearly uninformed.
pub(super) const SMALL_K: f64 = 0.001;

/// A search of the grid, and how far its path is processed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Name in records.
    pub name: &'static str,
    /// Name in text for people.
    pub label: &'static str,
    /// Name and label as a variant of Tables 1 and 2, or of fig. 5.
    pub variant: (&'static str, &'static str),
    /// The heuristic of A*; none for jump points.
    pub heuristic: Option<Heuristic>,
    /// Its last stage in this comparison, and the delivered one. The baselines only search.
    pub last_stage: Stage,
}

impl Search {
    /// A* with the Manhattan distance: a traditional search.
    pub const MANHATTAN: Self = Self::new("manhattan", "Manhattan", Some(Heuristic::Manhattan))
        .as_variant("traditional_manhattan", "traditional, Manhattan");
    /// A* with the Euclidean distance: the other traditional search.
    pub const EUCLID: Self = Self::new("euclid", "Euclid", Some(Heuristic::Euclid))
        .as_variant("traditional_euclid", "traditional, Euclid");
    /// A* with a distance model of 30 degrees (fig. 5).
    pub const THETA_30: Self = Self::theta("theta_30", "theta 30 degrees", "30 degrees", 30.0);
    /// A* with a distance model of 45 degrees (fig. 5): the octile distance.
    pub const THETA_45: Self = Self::theta("theta_45", "theta 45 degrees", "45 degrees", 45.0);
    /// A* with a distance model of 60 degrees (fig. 5).
    pub const THETA_60: Self = Self::theta("theta_60", "theta 60 degrees", "60 degrees", 60.0);
    /// A* with the paper's improved heuristic made scale-free: [`Heuristic::default`].
    pub const IMPROVED: Self =
        Self::new("improved", "improved heuristic", Some(Heuristic::Normalized { k: 0.1 }))
            .as_variant("improved", "improved")
            .smoothed();
    /// A* with eq. 19 as printed.
    pub const LITERAL: Self = Self::new(
        "literal_1",
        "eq. 19 as printed, k = 1",
        Some(Heuristic::Literal { k: LITERAL_K }),
    )
    .as_variant("literal", "literal eq. 19")
    .smoothed();
    /// The same with a small weight.
    pub const LITERAL_SMALL: Self = Self::new(
        "literal_0.001",
        "eq. 19 as printed, k = 0.001",
        Some(Heuristic::Literal { k: SMALL_K }),
    );
    /// Jump points.
    pub const JUMP_POINTS: Self = Self::new("jump_points", "jump points", None).smoothed();

    const fn new(name: &'static str, label: &'static str, heuristic: Option<Heuristic>) -> Self {
        Self { name, label, variant: (name, label), heuristic, last_stage: Stage::Raw }
    }

    const fn theta(
        name: &'static str,
        label: &'static str,
        angle: &'static str,
        degrees: f64,
    ) -> Self {
        Self::new(name, label, Some(Heuristic::Theta { degrees })).as_variant(name, angle)
    }

    const fn as_variant(self, name: &'static str, label: &'static str) -> Self {
        Self { variant: (name, label), ..self }
    }

    const fn smoothed(self) -> Self {
        Self { last_stage: Stage::Smoothed, ..self }
    }

    /// Whether its paths are always shortest ones on the grid.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.heuristic.is_none_or(|heuristic| heuristic.is_admissible())
    }
}

/// All searches of the tables, in an order in which none benefits from the one before.
pub const SEARCHES: [Search; 9] = [
    Search::MANHATTAN,
    Search::EUCLID,
    Search::THETA_30,
    Search::THETA_45,
    Search::THETA_60,
    Search::IMPROVED,
    Search::LITERAL,
    Search::LITERAL_SMALL,
    Search::JUMP_POINTS,
];

/// The searches in the tables of the mine.
pub const MINE_SEARCHES: [Search; 7] = [
    Search::MANHATTAN,
    Search::EUCLID,
    Search::THETA_45,
    Search::IMPROVED,
    Search::LITERAL,
    Search::LITERAL_SMALL,
    Search::JUMP_POINTS,
];

/// The variants of Tables 1 and 2: both traditional ones first.
pub(crate) const VARIANTS: [Search; 5] =
    [Search::MANHATTAN, Search::EUCLID, Search::IMPROVED, Search::LITERAL, Search::JUMP_POINTS];

/// Number of traditional variants at the start of [`VARIANTS`].
pub(crate) const TRADITIONAL: usize = 2;

/// The angles of fig. 5: 45 degrees is the octile distance.
pub(crate) const THETAS: [Search; 3] = [Search::THETA_30, Search::THETA_45, Search::THETA_60];

/// The label of a variant's name.
#[must_use]
pub fn label_of(name: &str) -> &str {
    let variants = SEARCHES.iter().map(|search| search.variant);
    variants.into_iter().find(|(variant, _)| *variant == name).map_or(name, |(_, label)| label)
}
