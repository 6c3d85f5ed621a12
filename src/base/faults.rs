//! The set of faults that a base reports.

use core::fmt;

/// Descriptions of the bits.
const NAMES: [(Faults, &str); 9] = [
    (Faults::MOTOR_LEFT, "driver of the left motor"),
    (Faults::MOTOR_RIGHT, "driver of the right motor"),
    (Faults::OVERCURRENT, "overcurrent"),
    (Faults::OVERHEATED, "overheated"),
    (Faults::SUPPLY, "supply voltage"),
    (Faults::ENCODER, "encoder"),
    (Faults::STALLED, "stalled track"),
    (Faults::WATCHDOG, "stopped by its watchdog"),
    (Faults::OTHER, "another fault"),
];

/// A set of faults, one bit each: the bits of the native report frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(u16);

impl Faults {
    /// No fault.
    pub const NONE: Self = Self(0);
    /// The left motor's driver.
    pub const MOTOR_LEFT: Self = Self(1);
    /// The right motor's driver.
    pub const MOTOR_RIGHT: Self = Self(1 << 1);
    /// Too much current.
    pub const OVERCURRENT: Self = Self(1 << 2);
    /// Too hot.
    pub const OVERHEATED: Self = Self(1 << 3);
    /// The supply voltage is too high or too low.
    pub const SUPPLY: Self = Self(1 << 4);
    /// An encoder is silent or jumps.
    pub const ENCODER: Self = Self(1 << 5);
    /// A track does not turn although it is driven.
    pub const STALLED: Self = Self(1 << 6);
    /// The base stopped by itself because no commands came. Ends with the next command.
    pub const WATCHDOG: Self = Self(1 << 7);
    /// A fault without a bit of its own.
    pub const OTHER: Self = Self(1 << 15);

    /// Returns the set with these bits. Unknown bits become [`Self::OTHER`].
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        const KNOWN: u16 = 0x80FF;
        if bits & !KNOWN == 0 { Self(bits) } else { Self(bits & KNOWN | Self::OTHER.0) }
    }

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// Faults in either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Faults of this set that are not in the other.
    #[must_use]
    pub const fn difference(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// This set if the condition holds, else the empty set.
    #[must_use]
    pub const fn when(self, condition: bool) -> Self {
        if condition { self } else { Self::NONE }
    }

    /// Whether this set contains every fault of the other.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether there is no fault.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (fault, name) in NAMES {
            if self.contains(fault) {
                write!(formatter, "{separator}{name}")?;
                separator = ", ";
            }
        }
        if self.is_empty() {
            formatter.write_str("none")?;
        }
        Ok(())
    }
}
