//! The two kinds of numbers that a row's parabolas are compared in.

use super::FAR;

/// A number of which the vector unit holds several, and the few operations that a row needs. Without checks for
/// overflow, which would keep the compiler from using vectors; who calls keeps what matters in range.
pub(super) trait Lane: Copy + PartialOrd {
    const ONE: Self;
    /// Not below any value that counts.
    const MOST: Self;

    /// A column's number.
    fn column(column: usize) -> Self;
    /// The square of a column's distance to its obstacle, in cells.
    fn square_of_height(height: u16) -> Self;
    fn minus(self, other: Self) -> Self;
    /// `offset^2 + squared_height`: a parabola at this offset from its site.
    fn parabola(offset: Self, squared_height: Self) -> Self;
    /// A whole number from zero, as it is.
    fn whole(self) -> u32;
}

/// The height from which [`i16`] takes all heights as equal: its square is the last that fits.
const HIGHEST_NEAR: i16 = 181;

/// Eight at a time, where all that counts is below `181^2`: higher values count as at least that.
impl Lane for i16 {
    const ONE: Self = 1;
    const MOST: Self = Self::MAX;

    /// Wraps in the padding after the last column of the widest grids, where differences are right all the same.
    #[inline]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline]
    fn square_of_height(height: u16) -> Self {
        // FAR does not fit in 15 bits; vectors know the least only of numbers with a sign.
        let height = (height.min(Self::MAX as u16) as Self).min(HIGHEST_NEAR);
        height.wrapping_mul(height)
    }

    #[inline]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }

    #[inline]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset.wrapping_mul(offset).saturating_add(squared_height)
    }

    #[inline]
    fn whole(self) -> u32 {
        self as u32
    }
}

/// Two at a time, exact for every grid: no sum comes near `2^53`.
impl Lane for f64 {
    const ONE: Self = 1.0;
    const MOST: Self = 4.0 * FAR as Self * FAR as Self;

    #[inline]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline]
    fn square_of_height(height: u16) -> Self {
        Self::from(height) * Self::from(height)
    }

    #[inline]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset * offset + squared_height
    }

    /// Adding `2^52` leaves a whole number in the low bits, which vectors do and a cast does not.
    #[inline]
    fn whole(self) -> u32 {
        const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
        (self + TWO_TO_52).to_bits() as u32
    }
}
