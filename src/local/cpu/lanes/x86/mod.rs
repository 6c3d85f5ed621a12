//! Lanes in the vector registers of x86-64.

/// Runs an intrinsic.
macro_rules! run {
    ($call:expr) => {{
        // SAFETY: a vector exists only where its proof does, and that only where the processor has the instructions.
        // Addresses are those of arrays of the right length.
        unsafe { $call }
    }};
}

/// Operations on two vectors that are one instruction.
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
