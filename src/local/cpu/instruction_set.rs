//! Selects the vector instructions of the CPU engine at run time.

#[cfg(target_arch = "aarch64")]
use super::lanes::run_neon;
#[cfg(target_arch = "x86_64")]
use super::lanes::{Avx2, Avx512, run_avx2, run_avx512};
use super::lanes::{LaneTask, Lanes, Portable};

/// Instruction sets of the CPU kernels. All return the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InstructionSet {
    /// One sample after the other, step by step, as in the shaders: the reference for the others.
    Scalar,
    /// Loops over short arrays; the compiler uses the vector instructions that every processor of the target has.
    Portable,
    /// Eight samples at once with NEON, on aarch64.
    Neon,
    /// Eight samples at once with AVX2.
    Avx2,
    /// Sixteen samples at once with AVX-512.
    Avx512,
}

impl InstructionSet {
    /// All instruction sets.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Portable, Self::Neon, Self::Avx2, Self::Avx512];

    /// The fastest that this processor has.
    #[must_use]
    pub fn best() -> Self {
        Self::ALL.into_iter().rfind(|one| one.is_available()).unwrap_or(Self::Portable)
    }

    /// Whether this processor has the instructions.
    #[must_use]
    pub fn is_available(self) -> bool {
        Kernel::of(self).is_some()
    }

    /// Runs work that is compiled for this instruction set; `None` if the processor lacks it.
    #[doc(hidden)]
    #[must_use]
    pub fn run<T: LaneTask>(self, task: T) -> Option<T::Output> {
        Kernel::of(self).map(|kernel| kernel.run(task))
    }

    /// The name for display.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Portable => "portable",
            Self::Neon => "NEON",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        }
    }
}

/// An available instruction set, with the token that shows it.
#[derive(Clone, Copy, Debug)]
pub enum Kernel {
    /// One sample at a time.
    Scalar,
    /// Arrays.
    Portable,
    /// NEON.
    #[cfg(target_arch = "aarch64")]
    Neon,
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(<Avx2 as Lanes>::FeatureToken),
    /// AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512(<Avx512 as Lanes>::FeatureToken),
}

/// Counts the lanes.
struct CountLanes;

impl LaneTask for CountLanes {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L::FeatureToken) -> usize {
        L::COUNT
    }
}

impl Kernel {
    /// Number of lanes.
    pub fn lanes(self) -> usize {
        self.run(CountLanes)
    }

    /// Runs a task with these instructions. The scalar kernel uses arrays.
    pub fn run<W: LaneTask>(self, work: W) -> W::Output {
        match self {
            Self::Scalar | Self::Portable => work.run::<Portable>(()),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => run_neon(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => run_avx2(token, work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(token) => run_avx512(token, work),
        }
    }

    /// The kernel of an instruction set, if the processor has it.
    pub fn of(instructions: InstructionSet) -> Option<Self> {
        match instructions {
            InstructionSet::Scalar => Some(Self::Scalar),
            InstructionSet::Portable => Some(Self::Portable),
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => Some(Self::Neon),
            #[cfg(not(target_arch = "aarch64"))]
            InstructionSet::Neon => None,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => Avx2::detect().map(Self::Avx2),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => Avx512::detect().map(Self::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx2 | InstructionSet::Avx512 => None,
        }
    }
}
