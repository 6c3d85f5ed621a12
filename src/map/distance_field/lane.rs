//! The number types in which a row's parabolas are compared.

use super::FAR;

/// A number type for vector code: several values fit in a register. Operations are unchecked, since overflow checks
/// prevent vectorisation; the caller keeps relevant values in range.
pub(super) trait Lane: Copy + PartialOrd {
    const ONE: Self;
    /// At least as large as any relevant value.
    const MOST: Self;

    /// Converts a column index.
    fn column(column: usize) -> Self;
    /// Squares the vertical distance of a column to its obstacle, in cells.
    fn square_of_height(height: u16) -> Self;
    fn minus(self, other: Self) -> Self;
    /// Returns `offset^2 + squared_height`: the value of a parabola at this offset from its site.
    fn parabola(offset: Self, squared_height: Self) -> Self;
    /// Converts a non-negative whole number.
    fn whole(self) -> u32;
}

/// Heights from this value on are treated as equal by [`u16`]: its square is the largest that fits.
const HIGHEST_NEAR: u16 = 255;

/// At least eight lanes. Exact below `255^2`; larger values are saturated to at least that.
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

    /// A negative offset wraps, and its square is still correct.
    #[inline(always)]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset.wrapping_mul(offset).saturating_add(squared_height)
    }

    #[inline(always)]
    fn whole(self) -> u32 {
        self.into()
    }
}

/// Two lanes, exact for every grid: no sum reaches `2^53`.
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

    /// Adding `2^52` leaves the whole number in the low bits. This vectorises; a cast does not.
    #[inline(always)]
    fn whole(self) -> u32 {
        const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
        (self + TWO_TO_52).to_bits() as u32
    }
}
