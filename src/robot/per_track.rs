//! Pairs of values, one for each track.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::settings::{Range, Setting, SettingError};

/// One of the two tracks, in the direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The left track.
    Left,
    /// The right track.
    Right,
}

/// One value for each track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerTrack<T> {
    /// Value of the left track.
    pub left: T,
    /// Value of the right track.
    pub right: T,
}

impl<T: Setting> Setting for PerTrack<T> {
    fn schema() -> Value {
        json!({
            "type": "object",
            "properties": { "left": T::schema(), "right": T::schema() },
            "required": ["left", "right"],
            "additionalProperties": false,
        })
    }

    fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
        self.left.check(name, range)?;
        self.right.check(name, range)
    }
}

impl<T> PerTrack<T> {
    /// Creates a pair from its values.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// Applies a function to both values.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerTrack<U> {
        PerTrack::new(change(self.left), change(self.right))
    }

    /// Combines both values with those of another pair.
    pub fn zip<U, V>(self, other: PerTrack<U>, mut join: impl FnMut(T, U) -> V) -> PerTrack<V> {
        PerTrack::new(join(self.left, other.left), join(self.right, other.right))
    }

    /// Returns the pair with left and right exchanged.
    #[must_use]
    pub fn swapped(self) -> Self {
        Self::new(self.right, self.left)
    }
}

impl<T: Copy> PerTrack<T> {
    /// Creates a pair of equal values.
    pub const fn both(value: T) -> Self {
        Self::new(value, value)
    }

    /// The value of one track.
    pub const fn of(&self, side: Side) -> T {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }
}

impl core::fmt::Display for Side {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}
