//! The shape of a sampling: its forward speeds to its turn rates.

use core::fmt::{self, Display};

/// Turn rates for each forward speed, to the nearest power of two: the counts are whole and keep it only about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SamplingShape(f64);

impl SamplingShape {
    /// Of so many forward speeds and turn rates; none without a forward speed.
    pub(super) fn of(vx_samples: u32, vtheta_samples: u32) -> Option<Self> {
        let ratio = f64::from(vtheta_samples.max(1)) / f64::from(vx_samples);
        (vx_samples > 0).then(|| Self(libm::exp2(libm::round(libm::log2(ratio)))))
    }
}

impl Display for SamplingShape {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1.0 {
            write!(out, "v : omega = {}:1", 1.0 / self.0)
        } else {
            write!(out, "v : omega = 1:{}", self.0)
        }
    }
}
