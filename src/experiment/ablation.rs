//! The ablation of the navigator: the same missions, with one more feature in each variant.

use super::{Group, RunRow, Setup, groups};
use crate::navigator::NavigatorFeatures;
use crate::runtime::Config;

/// The navigator with some of its features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct AblationVariant {
    /// Name in rows.
    pub name: &'static str,
    /// Title for people.
    pub title: &'static str,
    /// The features that are switched on.
    pub features: NavigatorFeatures,
}

const NONE: NavigatorFeatures = NavigatorFeatures {
    global_path: false,
    progress: false,
    tracking: false,
    replanning: false,
    passive_safety: false,
    pairs_of_legs: false,
    scan_health: false,
    occlusion_speed: false,
    narrow_passages: false,
    map_changes: false,
    recovery: false,
};

const fn variant(
    name: &'static str,
    title: &'static str,
    features: NavigatorFeatures,
) -> AblationVariant {
    AblationVariant { name, title, features }
}

/// The variants, from the dynamic window alone to the whole navigator. Each has one feature more than the previous one.
pub const ABLATION_VARIANTS: [AblationVariant; 7] = {
    let astar = NavigatorFeatures { global_path: true, ..NONE };
    let progress = NavigatorFeatures { progress: true, ..astar };
    let tracking = NavigatorFeatures { tracking: true, ..progress };
    let replanning = NavigatorFeatures { replanning: true, ..tracking };
    let passive_safety = NavigatorFeatures {
        passive_safety: true,
        pairs_of_legs: true,
        scan_health: true,
        occlusion_speed: true,
        ..replanning
    };
    let recovery = NavigatorFeatures {
        recovery: true,
        narrow_passages: true,
        map_changes: true,
        ..passive_safety
    };
    [
        variant("dwa", "DWA alone, towards the goal", NONE),
        variant("astar_dwa", "A* and DWA as in the paper", astar),
        variant("progress", "+ progress along the path", progress),
        variant("tracking", "+ moving obstacles tracked", tracking),
        variant("replanning", "+ replanning", replanning),
        variant(
            "passive_safety",
            "+ passive safety, lidar checked by the map, speed by what is seen",
            passive_safety,
        ),
        variant("recovery", "+ recovery: all", recovery),
    ]
};

impl AblationVariant {
    /// A configuration with only these features.
    #[must_use]
    pub fn setup(&self, config: &Config) -> Setup {
        let mut config = config.clone();
        config.navigator.features = self.features;
        Setup::named(self.name, config)
    }
}

/// Groups the runs of an ablation by variant, in the order of the variants, named by their titles.
#[must_use]
pub fn ablation_groups(rows: &[RunRow]) -> Vec<Group> {
    let groups = groups(rows);
    let of_variant = |variant: &AblationVariant| {
        let is_own = |group: &&Group| group.config.as_deref() == Some(variant.name);
        let group = groups.iter().find(is_own)?;
        Some(Group { name: variant.title.to_owned(), ..group.clone() })
    };
    ABLATION_VARIANTS.iter().filter_map(of_variant).collect()
}
