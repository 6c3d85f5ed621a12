//! What drives are to show.

/// When faults happen, seconds: the robot is under way.
pub(super) const MISHAP_S: f64 = 12.0;

/// What a drive is to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalizationCase {
    /// To and fro between the ends, as long as the tour is to be.
    Tour,
    /// The same among five people that the map does not show.
    People,
    /// The same with a map whose cells are twice as wide as those of the world.
    CoarseMap,
    /// Along a straight smooth roadway of 120 m that does not say how far along it one is.
    Smooth,
    /// Carried two metres back under way.
    Carried,
    /// Carried to any other open place of the map, at least 20 m from the start.
    Elsewhere,
    /// Carried into a smooth roadway beside the smooth one that it drives in: nothing tells them apart.
    Twin,
    /// Its lidar sees nothing from a moment on.
    Blinded,
    /// The same for three seconds.
    BlindedForAMoment,
    /// With the map of another mine than that it is in; both are of the built-in scenes.
    OtherMap,
}

impl LocalizationCase {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Tour,
        Self::People,
        Self::CoarseMap,
        Self::Smooth,
        Self::Carried,
        Self::Elsewhere,
        Self::Twin,
        Self::Blinded,
        Self::BlindedForAMoment,
        Self::OtherMap,
    ];

    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Tour => "tour",
            Self::People => "people",
            Self::CoarseMap => "coarse_map",
            Self::Smooth => "smooth",
            Self::Carried => "carried",
            Self::Elsewhere => "elsewhere",
            Self::Twin => "twin",
            Self::Blinded => "blinded",
            Self::BlindedForAMoment => "blinded_for_a_moment",
            Self::OtherMap => "other_map",
        }
    }

    /// When its mishap happens, seconds; zero where there is none.
    pub(super) const fn mishap_s(self) -> f64 {
        match self {
            Self::Carried
            | Self::Elsewhere
            | Self::Twin
            | Self::Blinded
            | Self::BlindedForAMoment => MISHAP_S,
            _ => 0.0,
        }
    }
}
