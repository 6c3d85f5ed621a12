//! Lanes: 32-bit integers of many samples in one vector register, or in an array.
//!
//! The kernels are generic over [`Lanes`] and compiled for each instruction set, which is selected at run time
//! ([`super::InstructionSet`]). Every operation is exact, so the selection changes no bit.

/// Looks up in a register tile by gathers from memory.
macro_rules! look_up_in_memory {
    () => {
        const LARGEST_REGISTER_TILE: usize = 0;
        type RegisterTile = $crate::local::cpu::lanes::RegisterTile;

        #[inline(always)]
        fn register_tile<const SIDE: usize>(
            _: Self::FeatureToken,
            square: &$crate::local::cpu::lanes::Square<'_>,
        ) -> Self::RegisterTile {
            Self::RegisterTile::of::<SIDE>(square)
        }

        #[inline(always)]
        fn look_up<const SIDE: usize>(
            token: Self::FeatureToken,
            register_tile: &Self::RegisterTile,
            one: (Self, Self),
            other: (Self, Self),
            bits: u32,
        ) -> Self {
            let last = Self::splat(token, SIDE as i32 - 1);
            let place = |(x, y): (Self, Self)| {
                let (column, row) = (x.shr(bits).and(last), y.shr(bits).and(last));
                row.shl(SIDE.ilog2()).add(column)
            };
            let one = place(one).gather(register_tile.entries());
            one.add(place(other).gather(register_tile.entries()).shl(16))
        }
    };
}

#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "aarch64")]
pub use neon::run_neon;
pub use portable::Portable;
#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512, run_avx2, run_avx512};

/// Largest number of lanes of any implementation.
pub const MAX_LANES: usize = 16;

/// Lanes of `i32`. Additions, subtractions and products wrap; comparisons are signed.
///
/// Methods are `inline(always)`: they must be compiled within the kernel that enables the instructions.
#[expect(clippy::return_self_not_must_use, reason = "an operation without a use is no mistake")]
pub trait Lanes: Copy {
    /// Number of lanes.
    const COUNT: usize;
    /// Shows that the processor has the instructions. A vector is constructed from it, so none exists without it.
    type FeatureToken: Copy;
    /// One truth value per lane.
    type Mask: Copy;

    /// Sets all lanes to one value.
    fn splat(token: Self::FeatureToken, value: i32) -> Self;
    /// Loads the first values of a slice that has at least [`Self::COUNT`] entries.
    fn load(token: Self::FeatureToken, from: &[i32]) -> Self;
    /// Stores to the front of a slice that has at least [`Self::COUNT`] entries.
    fn store(self, to: &mut [i32]);

    /// `self + other`.
    fn add(self, other: Self) -> Self;
    /// `self - other`.
    fn sub(self, other: Self) -> Self;
    /// Lower half of the product.
    fn mul(self, other: Self) -> Self;
    /// Upper half of the signed product.
    fn mul_hi(self, other: Self) -> Self;
    /// An odd polynomial: `self`, from -2^30 to 2^30, times a polynomial of its square.
    ///
    /// The square is divided by 2^30 and rounded down. Horner's rule starts with the first coefficient; each iteration
    /// multiplies by the square, divides by 2^30, rounds down and adds the next coefficient. The final product is
    /// divided by 2^`bits`, `bits` from 1 to 31, and rounded down. The sums are above -2^30 and below 2^30, the last one also
    /// above -2^`bits` and below 2^`bits`.
    fn odd_polynomial<const N: usize>(self, bits: u32, coefficients: [i32; N]) -> Self;
    /// Shifts left by 0 to 31 bits.
    fn shl(self, bits: u32) -> Self;
    /// Shifts right by 0 to 31 bits, arithmetic.
    fn sar(self, bits: u32) -> Self;
    /// Shifts right by 0 to 31 bits, logical.
    fn shr(self, bits: u32) -> Self;
    /// Shifts each lane left by its own 0 to 31 bits.
    fn shl_each(self, bits: Self) -> Self;
    /// Multiplies a 16-bit number, present in both halves of a lane, by the sum of the two halves of the other lane.
    /// All are signed.
    fn mul_halves(self, halves: Self) -> Self;
    /// Bitwise and.
    fn and(self, other: Self) -> Self;
    /// Minimum.
    fn min(self, other: Self) -> Self;
    /// Maximum.
    fn max(self, other: Self) -> Self;
    /// Absolute value; -2^31 is unchanged.
    fn abs(self) -> Self;
    /// Number of leading zeros of a value above zero.
    fn leading_zeros(self) -> Self;

    /// `floor(self / divisor)` of an unsigned value and a divisor from 1 to 2^17, with a quotient up to 2^17.
    fn div_unsigned(self, divisor: Self) -> Self;
    /// `floor(sqrt(self))` of unsigned values.
    fn isqrt(self) -> Self;
    /// `floor(sqrt(self^2 + other^2))` for values below 2^25 in size.
    fn hypot(self, other: Self) -> Self;
    /// `(y >> bits) * width + (x >> bits)`. The shifted values fit in 16 bits, `bits` is 16 to 31 and `width` 1 to
    /// 32767.
    fn row_major(token: Self::FeatureToken, x: Self, y: Self, bits: u32, width: i32) -> Self;
    /// Gathers entries of a slice into the lower halves of the lanes; the upper halves are undefined. The slice has at
    /// least one entry more than the greatest index; other indices give one of its entries.
    fn gather_dirty_high(self, list: &[u16]) -> Self;
    /// Minimum of two results with undefined upper halves, or of one and a value below 2^16. The upper halves of the
    /// result are undefined.
    fn min_dirty_high(self, other: Self) -> Self;
    /// Unsigned minimum in each half of the lanes.
    fn min_halves(self, other: Self) -> Self;
    /// Clears the upper halves.
    fn mask_high(self) -> Self;
    /// Gathers entries of a slice, see [`Self::gather_dirty_high`].
    #[must_use]
    #[inline(always)]
    fn gather(self, list: &[u16]) -> Self {
        self.gather_dirty_high(list).mask_high()
    }

    /// Largest side for which `look_up` is faster than two gathers from memory; zero if it is for none.
    const LARGEST_REGISTER_TILE: usize;
    /// A square of a grid with a side of 8 or 16.
    type RegisterTile: Copy;
    /// Copies a square.
    fn register_tile<const SIDE: usize>(
        token: Self::FeatureToken,
        square: &Square<'_>,
    ) -> Self::RegisterTile;
    /// Looks up the entries at the columns `x >> bits` and the rows `y >> bits`, both modulo the side: the first pair
    /// to the lower halves of the lanes, the second to the upper halves. `bits` is 20 to 28.
    fn look_up<const SIDE: usize>(
        token: Self::FeatureToken,
        register_tile: &Self::RegisterTile,
        one: (Self, Self),
        other: (Self, Self),
        bits: u32,
    ) -> Self;

    /// Inclusive prefix sums.
    fn prefix_sums(self) -> Self;
    /// The last lane.
    fn last(self) -> i32;
    /// Minimum of all lanes.
    fn reduce_min(self) -> i32;
    /// Maximum of all lanes.
    fn reduce_max(self) -> i32;
    /// Unsigned sum of all lanes.
    fn reduce_sum_unsigned(self) -> u64;

    /// `self < other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `self < other`, unsigned.
    fn less_unsigned(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn equal(self, other: Self) -> Self::Mask;
    /// Takes `yes` in the lanes of the mask and `no` in the others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The empty mask.
    fn mask_none(token: Self::FeatureToken) -> Self::Mask;
    /// Bitwise and of two masks.
    fn mask_and(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Bitwise or of two masks.
    fn mask_or(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Bitwise and of the first mask and the complement of the second.
    fn mask_and_not(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Stores the lanes of the mask consecutively at the front of a slice that has space for all lanes. Returns their
    /// number. The entries after them are undefined.
    fn compress(mask: Self::Mask, lanes: Self, to: &mut [i32]) -> usize;
    /// The mask as bits; the first lane is the lowest bit.
    fn bitmask(mask: Self::Mask) -> u32;
}

/// Work that is compiled for each instruction set. `run` must be `inline(always)`: only then the caller's instruction
/// set applies to it.
pub trait LaneTask {
    /// The result.
    type Output;

    /// Runs the work with one kind of lanes.
    fn run<L: Lanes>(self, token: L::FeatureToken) -> Self::Output;
}

/// Side of a small register tile.
pub const SMALL_TILE: usize = 8;
/// Side of a large register tile.
pub const LARGE_TILE: usize = 16;

/// Entries of a large register tile, and two more for vector loads.
const ROOM: usize = LARGE_TILE * LARGE_TILE + 2;

/// The position of a square in a grid.
#[derive(Clone, Copy, Debug)]
pub struct Square<'a> {
    /// Entries of the grid, row-major, at least from the first to the last entry of the square.
    pub entries: &'a [u16],
    /// Distance between rows, entries.
    pub stride: usize,
    /// The first column.
    pub column: usize,
    /// The first row.
    pub row: usize,
}

impl<'a> Square<'a> {
    /// The entries of the row whose number modulo the side is `row` modulo the side.
    #[must_use]
    #[inline(always)]
    pub fn row<const SIDE: usize>(&self, row: usize) -> &'a [u16] {
        let after = row.wrapping_sub(self.row) % SIDE;
        &self.entries[after * self.stride..][..SIDE]
    }
}

/// A register tile in memory, row-major: each entry at its column and row in the grid, modulo the side.
#[derive(Clone, Copy, Debug)]
pub struct RegisterTile([u16; ROOM]);

impl RegisterTile {
    /// Copies a square.
    #[inline(always)]
    pub fn of<const SIDE: usize>(square: &Square<'_>) -> Self {
        let mut register_tile = [0; ROOM];
        for (row, places) in register_tile.chunks_exact_mut(SIDE).take(SIDE).enumerate() {
            let entries = square.row::<SIDE>(row);
            for (column, place) in places.iter_mut().enumerate() {
                *place = entries[column.wrapping_sub(square.column) % SIDE];
            }
        }
        Self(register_tile)
    }

    /// The entries, and two more.
    #[inline(always)]
    pub const fn entries(&self) -> &[u16; ROOM] {
        &self.0
    }
}
