//! Many samples at once: 32-bit lanes of one vector register, or of an array where there is none.
//!
//! The kernels are written once over [`Lanes`] and compiled for each set of instructions; which one runs is decided
//! when the program starts ([`super::InstructionSet`]). Every operation is exact, so the choice changes no bit.

/// Looking up in a patch by gathering from memory.
macro_rules! look_up_in_memory {
    () => {
        const HAS_REGISTER_LOOKUP: bool = false;
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

mod portable;
mod register_tile;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use portable::Portable;
pub use register_tile::{LARGE_TILE, RegisterTile, SMALL_TILE, Square};
#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512, run_avx2, run_avx512};

/// The most lanes that any implementation has.
pub const MAX_LANES: usize = 16;

/// Lanes of `i32`. Additions, subtractions and products wrap; comparisons are signed.
///
/// Methods are `inline(always)`: they must be compiled within the kernel that has the instructions enabled.
pub trait Lanes: Copy {
    /// Number of lanes.
    const COUNT: usize;
    /// Shows that the processor has the instructions. Vectors are made from it, so none exists without.
    type FeatureToken: Copy;
    /// A truth value for each lane.
    type Mask: Copy;

    /// The same value in each lane.
    fn splat(token: Self::FeatureToken, value: i32) -> Self;
    /// The first values of a list that is at least as long as there are lanes.
    fn load(token: Self::FeatureToken, from: &[i32]) -> Self;
    /// Writes to the front of a list that is at least as long as there are lanes.
    fn store(self, to: &mut [i32]);

    /// `self + other`.
    fn add(self, other: Self) -> Self;
    /// `self - other`.
    fn sub(self, other: Self) -> Self;
    /// Lower half of the product.
    fn mul(self, other: Self) -> Self;
    /// Upper half of the signed product.
    fn mul_hi(self, other: Self) -> Self;
    /// A value from -2^30 to 2^30 times a polynomial of its square, which is divided by 2^30, rounded down: by Horner's
    /// rule the first coefficient, then each time times the square, divided by 2^30, rounded down, plus the next. The
    /// product is divided by two to the power of these bits, 1 to 31, rounded down. What is multiplied, and the outcome,
    /// fit in 32 bits.
    fn odd_polynomial<const N: usize>(self, bits: u32, coefficients: [i32; N]) -> Self;
    /// Shifted to the left by 0 to 31 bits.
    fn shl(self, bits: u32) -> Self;
    /// Shifted to the right by 0 to 31 bits, keeping the sign.
    fn sar(self, bits: u32) -> Self;
    /// Shifted to the right by 0 to 31 bits, filling with zeros.
    fn shr(self, bits: u32) -> Self;
    /// Each lane shifted to the left by its own 0 to 31 bits.
    fn shl_each(self, bits: Self) -> Self;
    /// A number of 16 bits, given in both halves of a lane, times the sum of the two halves of another lane, all signed.
    fn mul_halves(self, halves: Self) -> Self;
    /// Bitwise and.
    fn and(self, other: Self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// The greater of two.
    fn max(self, other: Self) -> Self;
    /// The size of a value; -2^31 stays as it is.
    fn abs(self) -> Self;
    /// Number of leading zeros of a value above zero.
    fn leading_zeros(self) -> Self;

    /// `floor(self / divisor)` of an unsigned value and a divisor from 1 to 2^17, with a quotient up to 2^17.
    fn div_unsigned(self, divisor: Self) -> Self;
    /// `floor(sqrt(self))` of unsigned values.
    fn isqrt(self) -> Self;
    /// `floor(sqrt(self^2 + other^2))` for values below 2^25 in size.
    fn hypot(self, other: Self) -> Self;
    /// `(y >> bits) * width + (x >> bits)`, for shifted values that fit in 16 bits, 16 to 31 `bits`, and a width from 1 to
    /// 32767.
    fn row_major(token: Self::FeatureToken, x: Self, y: Self, bits: u32, width: i32) -> Self;
    /// The entries of a list in the lower halves of the lanes; the upper halves hold anything. The list has at least one
    /// entry more than the greatest index; other indices give one of its entries as well.
    fn gather_dirty_high(self, list: &[u16]) -> Self;
    /// The smaller of two that loose operations gave, or of one and a value below 2^16; again loose.
    fn min_dirty_high(self, other: Self) -> Self;
    /// The smaller of two numbers, unsigned, in each half of the lanes.
    fn min_halves(self, other: Self) -> Self;
    /// Clears the upper halves of what the loose operations gave.
    fn mask_high(self) -> Self;
    /// The entries of a list, as in `gather_dirty_high`.
    #[inline(always)]
    fn gather(self, list: &[u16]) -> Self {
        self.gather_dirty_high(list).mask_high()
    }

    /// Whether registers can be looked up in: then `look_up` takes less time than two gathers from memory.
    const HAS_REGISTER_LOOKUP: bool;
    /// A square of a grid, its side 8 or 16.
    type RegisterTile: Copy;
    /// Copies a square.
    fn register_tile<const SIDE: usize>(
        token: Self::FeatureToken,
        square: &Square<'_>,
    ) -> Self::RegisterTile;
    /// The entries of a patch of this side at the columns `x >> bits` and the rows `y >> bits`, both modulo the side: of
    /// the first pair in the lower halves of the lanes, of the second in the upper ones. `bits` is 20 to 28.
    fn look_up<const SIDE: usize>(
        token: Self::FeatureToken,
        register_tile: &Self::RegisterTile,
        one: (Self, Self),
        other: (Self, Self),
        bits: u32,
    ) -> Self;

    /// Each lane with the sum of those before it added.
    fn prefix_sums(self) -> Self;
    /// The last lane.
    fn last(self) -> i32;
    /// The smallest of all lanes.
    fn reduce_min(self) -> i32;
    /// The greatest of all lanes.
    fn reduce_max(self) -> i32;
    /// The sum of all lanes, unsigned.
    fn reduce_sum_unsigned(self) -> u64;

    /// `self < other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `self < other`, both unsigned.
    fn less_unsigned(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn equal(self, other: Self) -> Self::Mask;
    /// Each lane from `yes` where the mask is set, from `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// A mask without a lane set.
    fn mask_none(token: Self::FeatureToken) -> Self::Mask;
    /// Set in both.
    fn mask_and(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Set in either.
    fn mask_or(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Set in the first and not in the second.
    fn mask_and_not(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Writes the lanes that are set one after the other to the front of a list that has room for all; their number.
    /// What comes behind them is anything.
    fn compress(mask: Self::Mask, lanes: Self, to: &mut [i32]) -> usize;
    /// The lanes set, first lane in the lowest bit.
    fn bitmask(mask: Self::Mask) -> u32;

    /// The values as a list; those beyond the number of lanes are zero.
    #[cfg(test)]
    fn to_array(self) -> [i32; MAX_LANES] {
        let mut array = [0; MAX_LANES];
        self.store(&mut array);
        array
    }
}

/// Work that is compiled for each instruction set. `run` must be `inline(always)`: only then the caller's instruction set
/// applies to it.
pub trait LaneTask {
    /// The result.
    type Output;

    /// Runs the work with one kind of lanes.
    fn run<L: Lanes>(self, token: L::FeatureToken) -> Self::Output;
}
