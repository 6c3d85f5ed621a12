//! The motion that the samples of a row share: segments in which turn rate and speed share change evenly.

use super::sampler::MAX_SEGMENTS;

/// The motion that the samples of a row share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile {
    /// The row's speed, m/s.
    pub vx: f64,
    /// The segments, and default ones after them.
    pub segments: [Segment; MAX_SEGMENTS],
    /// Number of segments.
    pub count: usize,
}

/// Successive steps in which turn rate and share change evenly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Segment {
    /// One past its last step.
    pub end: u32,
    /// Turn rate in its first step, rad/s.
    pub vtheta: f64,
    /// Change of the turn rate from one step to the next, rad/s.
    pub vtheta_growth: f64,
    /// Share of the column's speed in its first step, 0 to 1.
    pub share: f64,
    /// Change of the share from one step to the next.
    pub share_growth: f64,
}

impl Segment {
    /// A constant turn rate.
    #[inline]
    pub const fn constant(end: u32, vtheta: f64, share: f64) -> Self {
        Self { end, vtheta, vtheta_growth: 0.0, share, share_growth: 0.0 }
    }

    /// An even change within `steps` steps that begin with this segment. A step has the mean of its values.
    #[inline]
    pub fn ramp(end: u32, steps: u32, vtheta: [f64; 2], share: [f64; 2]) -> Self {
        let steps = f64::from(steps);
        let growth = |[from, to]: [f64; 2]| (to - from) / steps;
        Self {
            end,
            vtheta: vtheta[0] + 0.5 * growth(vtheta),
            vtheta_growth: growth(vtheta),
            share: share[0] + 0.5 * growth(share),
            share_growth: growth(share),
        }
    }

    /// Turn rate and share at a step of this segment, which begins at step `begin`.
    fn at(&self, begin: u32, step: u32) -> (f64, f64) {
        let steps = f64::from(step - begin);
        (self.vtheta + steps * self.vtheta_growth, self.share + steps * self.share_growth)
    }
}

impl Profile {
    #[inline]
    pub fn segments(&self) -> &[Segment] {
        &self.segments[..self.count]
    }

    /// Turn rate and share at a step of the horizon.
    pub fn at(&self, step: u32) -> (f64, f64) {
        let mut begin = 0;
        for segment in self.segments() {
            if step < segment.end {
                return segment.at(begin, step);
            }
            begin = segment.end;
        }
        (0.0, 1.0)
    }
}
