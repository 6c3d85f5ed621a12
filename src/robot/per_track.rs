//! A thing that both tracks have.

use serde::{Deserialize, Serialize};

/// One of the two tracks, seen in the direction of travel.
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
    /// Of the left track.
    pub left: T,
    /// Of the right track.
    pub right: T,
}

impl<T> PerTrack<T> {
    /// A value for each track.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// What a function makes of each.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerTrack<U> {
        PerTrack::new(change(self.left), change(self.right))
    }

    /// What a function makes of each together with another's.
    pub fn zip<U, V>(self, other: PerTrack<U>, mut join: impl FnMut(T, U) -> V) -> PerTrack<V> {
        PerTrack::new(join(self.left, other.left), join(self.right, other.right))
    }

    /// Left and right exchanged.
    #[must_use]
    pub fn swapped(self) -> Self {
        Self::new(self.right, self.left)
    }
}

impl<T: Copy> PerTrack<T> {
    /// The same for both.
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
