//! The cases of the localization experiment.

/// Time of the injected fault, seconds: the robot is driving.
pub(super) const FAULT_S: f64 = 12.0;

/// A case of the localization experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalizationCase {
    /// Back and forth between start and goal, for the length of the tour.
    Tour,
    /// A tour among five people that the map does not show.
    People,
    /// A tour with a map of twice the world's cell size.
    CoarseMap,
    /// Along a straight smooth roadway of 120 m. Its walls do not show the position along it.
    Smooth,
    /// The robot is moved two metres back while it drives.
    Kidnapped,
    /// The robot is moved to a random free place, at least 20 m from the start.
    KidnappedFar,
    /// The robot is moved into an identical parallel roadway.
    KidnappedToTwin,
    /// Its lidar returns nothing from some time on.
    Occluded,
    /// Its lidar returns nothing for three seconds.
    BrieflyOccluded,
    /// The map is of another built-in scene.
    OtherMap,
}

impl LocalizationCase {
    /// All cases.
    pub const ALL: [Self; 10] = [
        Self::Tour,
        Self::People,
        Self::CoarseMap,
        Self::Smooth,
        Self::Kidnapped,
        Self::KidnappedFar,
        Self::KidnappedToTwin,
        Self::Occluded,
        Self::BrieflyOccluded,
        Self::OtherMap,
    ];

    /// Its name in rows and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tour => "tour",
            Self::People => "people",
            Self::CoarseMap => "coarse_map",
            Self::Smooth => "smooth",
            Self::Kidnapped => "kidnapped",
            Self::KidnappedFar => "kidnapped_far",
            Self::KidnappedToTwin => "kidnapped_to_twin",
            Self::Occluded => "occluded",
            Self::BrieflyOccluded => "briefly_occluded",
            Self::OtherMap => "other_map",
        }
    }

    /// Time of its injected fault, seconds; zero without one.
    pub(super) const fn fault_s(self) -> f64 {
        match self {
            Self::Kidnapped
            | Self::KidnappedFar
            | Self::KidnappedToTwin
            | Self::Occluded
            | Self::BrieflyOccluded => FAULT_S,
            _ => 0.0,
        }
    }
}
