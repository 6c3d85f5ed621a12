//! What each part of the navigator buys: the same missions with one part more each time.

use std::collections::BTreeMap;

use serde::Serialize;

use super::missions::{MissionRow, Setup, Tally, Which, mean, shared, times_s};
use crate::bench::Columns;
use crate::navigator::NavigatorFeatures;
use crate::runtime::Config;

/// The navigator with some of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AblationVariant {
    /// One word.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// What is switched on.
    pub features: NavigatorFeatures,
}

const NOTHING: NavigatorFeatures = NavigatorFeatures {
    global_path: false,
    progress: false,
    tracking: false,
    replanning: false,
    passive_safety: false,
    recovery: false,
};

const fn variant(
    name: &'static str,
    title: &'static str,
    features: NavigatorFeatures,
) -> AblationVariant {
    AblationVariant {
        name,
        title,
        features,
    }
}

/// From the dynamic window alone to the whole navigator; each has one part more than the one before.
pub const ABLATION_VARIANTS: [AblationVariant; 7] = {
    let astar = NavigatorFeatures {
        global_path: true,
        ..NOTHING
    };
    let progress = NavigatorFeatures {
        progress: true,
        ..astar
    };
    let tracking = NavigatorFeatures {
        tracking: true,
        ..progress
    };
    let replanning = NavigatorFeatures {
        replanning: true,
        ..tracking
    };
    let passive_safety = NavigatorFeatures {
        passive_safety: true,
        ..replanning
    };
    let recovery = NavigatorFeatures {
        recovery: true,
        ..passive_safety
    };
    [
        variant("dwa", "DWA alone, the goal its target", NOTHING),
        variant("astar_dwa", "A* and DWA as printed", astar),
        variant("progress", "+ progress along the path", progress),
        variant("tracking", "+ moving obstacles tracked", tracking),
        variant("replanning", "+ paths planned anew", replanning),
        variant(
            "passive_safety",
            "+ passive safety near people",
            passive_safety,
        ),
        variant("recovery", "+ recovery: all", recovery),
    ]
};

impl AblationVariant {
    /// A configuration with only these parts.
    #[must_use]
    pub fn setup(&self, config: &Config) -> Setup {
        let mut config = config.clone();
        config.navigator.features = self.features;
        Setup {
            name: self.name.to_owned(),
            config,
        }
    }
}

/// What a variant did with the missions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AblationRow {
    /// The variant's word.
    pub variant: String,
    /// Its line.
    pub title: String,
    /// What came of its missions; the mean time is that of its own successes.
    #[serde(flatten)]
    pub tally: Tally,
    /// Missions that all variants with any success reached.
    pub shared: usize,
    /// This one's mean time over these, seconds; none where there are none, or it has no success.
    pub mean_shared_time_s: Option<f64>,
}

impl Columns for AblationRow {
    const COLUMNS: &[&str] = &[
        "variant",
        "title",
        "missions",
        "reached",
        "reached_share",
        "contacts_robot",
        "contacts_other",
        "failed",
        "timeouts",
        "unexplained",
        "mean_time_s",
        "mean_clearance_m",
        "shared",
        "mean_shared_time_s",
    ];
}

/// The table of an ablation, in the order of the variants.
#[must_use]
pub fn ablation_rows(rows: &[&MissionRow]) -> Vec<AblationRow> {
    let of_variant = |variant: &AblationVariant| -> Vec<&MissionRow> {
        let own = rows.iter().copied();
        own.filter(|row| row.setup == variant.name).collect()
    };
    let all: Vec<_> = ABLATION_VARIANTS
        .iter()
        .map(|variant| {
            let rows = of_variant(variant);
            (variant, times_s(&rows), rows)
        })
        .collect();
    let shared = shared(all.iter().map(|(_, times_s, _)| times_s));
    let row =
        |(variant, times_s, rows): &(&AblationVariant, BTreeMap<Which, f64>, Vec<_>)| AblationRow {
            variant: variant.name.to_owned(),
            title: variant.title.to_owned(),
            tally: Tally::of(rows),
            shared: shared.len(),
            mean_shared_time_s: mean(
                shared
                    .iter()
                    .filter_map(|which| times_s.get(which))
                    .copied(),
            ),
        };
    all.iter().map(row).collect()
}
