//! What a base reports to be wrong with itself.

use core::fmt;

/// The names of the bits, in words.
const NAMES: [(Faults, &str); 9] = [
    (Faults::MOTOR_LEFT, "driver of the left motor"),
    (Faults::MOTOR_RIGHT, "driver of the right motor"),
    (Faults::OVERCURRENT, "overcurrent"),
    (Faults::OVERHEATED, "overheated"),
    (Faults::SUPPLY, "supply voltage"),
    (Faults::ENCODER, "encoder"),
    (Faults::STALLED, "stalled track"),
    (Faults::WATCHDOG, "stopped for want of commands"),
    (Faults::OTHER, "another fault"),
];

/// A set of faults, one bit each: the bits of our own frame on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(u16);

impl Faults {
    /// Nothing is wrong.
    pub const NONE: Self = Self(0);
    /// The left motor's driver.
    pub const MOTOR_LEFT: Self = Self(1);
    /// The right motor's driver.
    pub const MOTOR_RIGHT: Self = Self(1 << 1);
    /// Too much current.
    pub const OVERCURRENT: Self = Self(1 << 2);
    /// Too hot.
    pub const OVERHEATED: Self = Self(1 << 3);
    /// A supply voltage that is too high or too low.
    pub const SUPPLY: Self = Self(1 << 4);
    /// An encoder that is silent or jumps.
    pub const ENCODER: Self = Self(1 << 5);
    /// A track that does not turn though it is driven.
    pub const STALLED: Self = Self(1 << 6);
    /// The base stopped by itself because no commands came. Ends with the next command.
    pub const WATCHDOG: Self = Self(1 << 7);
    /// What has no bit of its own.
    pub const OTHER: Self = Self(1 << 15);

    /// The set with these bits. Those without a name count as [`Self::OTHER`].
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        const NAMED: u16 = 0x80FF;
        if bits & !NAMED == 0 {
            Self(bits)
        } else {
            Self(bits & NAMED | Self::OTHER.0)
        }
    }

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// Those of either.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Those of this set that are not in another.
    #[must_use]
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// This set if a condition holds, else none.
    #[must_use]
    pub const fn only_if(self, holds: bool) -> Self {
        if holds { self } else { Self::NONE }
    }

    /// Whether all of another set are in this one.
    #[must_use]
    pub const fn contain(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (fault, name) in NAMES {
            if self.contain(fault) {
                write!(formatter, "{separator}{name}")?;
                separator = ", ";
            }
        }
        if self.is_none() {
            formatter.write_str("none")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_read_as_words_and_none_is_lost() {
        assert_eq!(Faults::NONE.to_string(), "none");
        let two = Faults::OVERHEATED.and(Faults::STALLED);
        assert_eq!(two.to_string(), "overheated, stalled track");
        assert_eq!(Faults::from_bits(0x0400), Faults::OTHER);
        for (fault, _) in NAMES {
            assert_eq!(Faults::from_bits(fault.bits()), fault);
        }
    }
}
