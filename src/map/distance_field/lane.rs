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

/// The height from which [`u16`] takes all heights as equal: its square is the last that fits.
const HIGHEST_NEAR: u16 = 255;

/// Eight at a time and more, where all that counts is below `255^2`: higher values count as at least that.
impl Lane for u16 {
    const ONE: Self = 1;
    const MOST: Self = Self::MAX;

    #[inline(always)]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline(always)]
    fn square_of_height(height: u16) -> Self {
        let height = height.min(HIGHEST_NEAR);
        height.wrapping_mul(height)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }

    /// The square of a negative offset, which has wrapped, is right all the same.
    #[inline(always)]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset.wrapping_mul(offset).saturating_add(squared_height)
    }

    #[inline(always)]
    fn whole(self) -> u32 {
        self.into()
    }
}

/// Two at a time, exact for every grid: no sum comes near `2^53`.
impl Lane for f64 {
    const ONE: Self = 1.0;
    const MOST: Self = 4.0 * FAR as Self * FAR as Self;

    #[inline(always)]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline(always)]
    fn square_of_height(height: u16) -> Self {
        Self::from(height) * Self::from(height)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset * offset + squared_height
    }

    /// Adding `2^52` leaves a whole number in the low bits, which vectors do and a cast does not.
    #[inline(always)]
    fn whole(self) -> u32 {
        const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
        (self + TWO_TO_52).to_bits() as u32
    }
}
