//! The inputs of the kernels, in the memory layout of the shaders. TWIN of the input structs of `shaders/layout.wgsl`:
//! same fields in the same order.

/// The scalars of a problem. TWIN of `Header` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Header {
    /// Number of forward speeds.
    pub vx_count: u32,
    /// Number of turn profiles.
    pub profile_count: u32,
    /// Number of steps.
    pub steps: u32,
    /// Number of discs of the footprint.
    pub disc_count: u32,
    /// Number of moving obstacles.
    pub obstacle_count: u32,
    /// Columns of the field.
    pub width: u32,
    /// Rows of the field.
    pub height: u32,
    /// A position in units, shifted right by this, is a cell index.
    pub cell_bits: u32,
    /// Start in units from the field's corner, along its x axis.
    pub start_x: i32,
    /// Start in units from the field's corner, along its y axis.
    pub start_y: i32,
    /// Heading at the start in the field's frame, binary angle.
    pub heading: u32,
    /// Target relative to the start, x, fine units, field's frame.
    pub target_x: i32,
    /// Target relative to the start, y, fine units, field's frame.
    pub target_y: i32,
    /// Key node relative to the start, x, fine units, field's frame.
    pub key_x: i32,
    /// Key node relative to the start, y, fine units, field's frame.
    pub key_y: i32,
    /// Cap of the clearance, units.
    pub max_clearance: u32,
    /// Shift from sums of Q20 cosines to coarse displacements.
    pub table_bits: u32,
    /// Shift from a coarse product to units.
    pub coarse_bits: u32,
    /// Shift from the upper half of a fine product to fine units.
    pub fine_bits: u32,
    /// 1: stop within the remaining arc; 0: stop within the smallest clearance.
    pub stop_by_arc: u32,
    /// 1: cells outside the field are free; 0: they are obstacles.
    pub outside_is_free: u32,
    /// 1: min-max normalisation; 0: normalisation by the sum.
    pub min_max: u32,
    /// A GPU returns it with the answer, which shows a stale answer. No other number depends on it.
    pub stamp: u32,
    /// Number of segments of each turn profile.
    pub segment_count: u32,
    /// Weights of heading, clearance, velocity and path; their sum is about 2^30.
    pub weights: [u32; 4],
}

/// A forward speed. TWIN of `VxSample` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct VxSample {
    /// Units per step, scaled: a product with a coarse displacement is shifted by [`Header::coarse_bits`].
    pub coarse: i32,
    /// Fine units per step, scaled likewise for [`Header::fine_bits`].
    pub fine: i32,
    /// The velocity term.
    pub velocity_term: u32,
    /// Requirement for stopping: units of clearance, or steps of arc.
    pub stopping_need: u32,
}

/// The motion that all samples of a row share: turn rates by step, and a speed that replaces the sample's own speed in
/// part. TWIN of `TurnProfile` in `shaders/layout.wgsl`.
///
/// The speed at a step is `share` times the sample's speed plus `1 - share` times the profile's speed.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct TurnProfile {
    /// The profile's speed, scaled as [`VxSample::coarse`].
    pub coarse: i32,
    /// The profile's speed, scaled as [`VxSample::fine`].
    pub fine: i32,
    /// Requirement for stopping: units of clearance, or steps of arc.
    pub stopping_need: u32,
    /// Bound of the turn in one step, binary angle, at most half a turn.
    pub max_turn: u32,
    /// Turn over the horizon, binary angle.
    pub end_turn: u32,
}

/// Successive steps of a turn profile in which turn rate and share change evenly. TWIN of `ProfileSegment` in
/// `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct ProfileSegment {
    /// One past its last step; that of the last segment is the number of steps.
    pub end: u32,
    /// Turn in its first step, binary angle.
    pub turn: u32,
    /// Change of the turn from one step to the next, binary angle.
    pub turn_growth: u32,
    /// Share of the sample's own speed in its first step, Q30.
    pub share: i32,
    /// Change of the share from one step to the next, Q30.
    pub share_growth: i32,
}

/// A disc of the footprint in units. TWIN of `QuantizedDisc` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct QuantizedDisc {
    /// Centre, forward of the robot's origin.
    pub x: i32,
    /// Centre, left of the robot's origin.
    pub y: i32,
    /// Radius.
    pub radius: i32,
}

impl QuantizedDisc {
    /// Whether the centre is the robot's origin: the disc then does not move when the robot turns.
    #[must_use]
    #[inline]
    pub(crate) const fn is_central(&self) -> bool {
        self.x == 0 && self.y == 0
    }
}

/// A moving obstacle in the field's frame. TWIN of `QuantizedObstacle` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct QuantizedObstacle {
    /// Centre relative to the robot's start, x, 1/256 unit.
    pub x: i32,
    /// Centre relative to the robot's start, y, 1/256 unit.
    pub y: i32,
    /// Motion per step, x, 1/256 unit.
    pub step_x: i32,
    /// Motion per step, y, 1/256 unit.
    pub step_y: i32,
    /// Radius, units.
    pub radius: i32,
}
