//! What moves where the robot drives.

use serde::Serialize;

/// What moves in the scenes, none of it on the robot's map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Traffic {
    /// Nothing: the paper's known static environment.
    Nobody,
    /// People who stop rather than walk into the robot.
    Minding,
    /// People who walk on as if there were no robot.
    Heedless,
}

impl Traffic {
    /// All, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Nobody, Self::Minding, Self::Heedless];

    /// In words, after "driven".
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Nobody => "with nobody about",
            Self::Minding => "among people who mind the robot",
            Self::Heedless => "among people who do not mind the robot",
        }
    }
}
