//! Lanes in the vector registers of x86-64.
#![expect(unsafe_code, reason = "calls of functions that are compiled for certain instructions")]

use super::{LaneTask, Lanes};

/// Runs an intrinsic.
macro_rules! run {
    ($call:expr) => {{
        // SAFETY: a vector exists only if its token does, and that exists only if the processor has the instructions.
        // Addresses are those of arrays of the right length.
        unsafe { $call }
    }};
}

/// Binary operations that are one instruction.
macro_rules! one_instruction {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            run!(Self($intrinsic(self.0, other.0)))
        }
    )*};
}

/// Shifts of all lanes by the same number of bits.
macro_rules! shifts {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(self, bits: u32) -> Self {
            run!(Self($intrinsic(self.0, count(bits))))
        }
    )*};
}

/// Methods that are the same calls in all registers, with the intrinsics of each.
macro_rules! same_calls {
    (
        set = $set:ident, load = $load:ident, store = $store:ident, add = $add:ident,
        mul = $mul:ident, right = $right:ident, and = $and:ident, abs = $abs:ident
    ) => {
        #[inline(always)]
        fn splat(_: FeatureToken, value: i32) -> Self {
            run!(Self($set(value)))
        }

        #[inline(always)]
        fn load(_: FeatureToken, from: &[i32]) -> Self {
            let from = &from[..COUNT];
            run!(Self($load(from.as_ptr().cast())))
        }

        #[inline(always)]
        fn store(self, to: &mut [i32]) {
            let to = &mut to[..COUNT];
            run!($store(to.as_mut_ptr().cast(), self.0));
        }

        #[inline(always)]
        fn mul_hi(self, other: Self) -> Self {
            run!(upper_halves($mul(self.0, other.0), $mul(odd(self), odd(other))))
        }

        #[inline(always)]
        fn abs(self) -> Self {
            run!(Self($abs(self.0)))
        }

        #[inline(always)]
        fn mask_high(self) -> Self {
            run!(Self($and(self.0, $set(0xFFFF))))
        }

        // Separately for even and odd lanes: the products are not interleaved until the end.
        #[inline(always)]
        fn odd_polynomial<const N: usize>(self, bits: u32, coefficients: [i32; N]) -> Self {
            let (x, other_x) = (self.0, odd(self));
            run!({
                let square = $right::<30>($mul(x, x));
                let other_square = $right::<30>($mul(other_x, other_x));
                let (mut even, mut odds) = ($set(coefficients[0]), $set(coefficients[0]));
                let mut next = 1;
                while next < N {
                    let coefficient = $set(coefficients[next]);
                    even = $add($right::<30>($mul(even, square)), coefficient);
                    odds = $add($right::<30>($mul(odds, other_square)), coefficient);
                    next += 1;
                }
                in_turn($mul(even, x), $mul(odds, other_x), bits)
            })
        }
    };
}

/// Whether the processor has all of these features.
macro_rules! detected {
    ($($feature:tt)*) => {
        true $(&& is_x86_feature_detected!($feature))*
    };
}

mod avx2;
mod avx512;

pub use avx2::Avx2;
pub use avx512::Avx512;

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn with_avx2<T: LaneTask>(token: <Avx2 as Lanes>::FeatureToken, task: T) -> T::Output {
    task.run::<Avx2>(token)
}

#[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,bmi1,bmi2,lzcnt,popcnt")]
fn with_avx512<T: LaneTask>(token: <Avx512 as Lanes>::FeatureToken, task: T) -> T::Output {
    task.run::<Avx512>(token)
}

/// Runs a task with AVX2.
pub fn run_avx2<T: LaneTask>(token: <Avx2 as Lanes>::FeatureToken, task: T) -> T::Output {
    // SAFETY: the token shows that the processor has the features that the function is compiled for.
    unsafe { with_avx2(token, task) }
}

/// Runs a task with AVX-512.
pub fn run_avx512<T: LaneTask>(token: <Avx512 as Lanes>::FeatureToken, task: T) -> T::Output {
    // SAFETY: the token shows that the processor has the features that the function is compiled for.
    unsafe { with_avx512(token, task) }
}
