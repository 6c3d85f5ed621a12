//! What the engines read, laid out as the shaders do. TWIN of the input structs of `shaders/layout.wgsl`: same fields
//! in the same order.

/// The numbers of a problem that are not lists. TWIN of `Header` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Header {
    /// Number of forward speeds.
    pub v_count: u32,
    /// Number of turn rates.
    pub omega_count: u32,
    /// Number of steps.
    pub steps: u32,
    /// Number of discs.
    pub disc_count: u32,
    /// Number of moving obstacles.
    pub obstacle_count: u32,
    /// Columns of the field.
    pub width: u32,
    /// Rows of the field.
    pub height: u32,
    /// A position in units becomes a cell by this shift to the right.
    pub cell_bits: u32,
    /// Start in units from the field's corner, along its x axis.
    pub start_x: i32,
    /// Start in units from the field's corner, along its y axis.
    pub start_y: i32,
    /// Heading at the start in the field's frame, binary angle.
    pub heading: u32,
    /// Target from the start, fine units, field's frame.
    pub target_x: i32,
    /// Target from the start, fine units, field's frame.
    pub target_y: i32,
    /// Key node from the start, fine units, field's frame.
    pub key_x: i32,
    /// Key node from the start, fine units, field's frame.
    pub key_y: i32,
    /// Clearance beyond which more is not better, units.
    pub max_clearance: u32,
    /// Q20 displacement sums become coarse ones by this shift.
    pub table_bits: u32,
    /// A coarse product becomes units by this shift.
    pub coarse_bits: u32,
    /// The upper half of a fine product becomes fine units by this shift.
    pub fine_bits: u32,
    /// 1: stop within the arc left; 0: within the smallest clearance.
    pub stop_by_arc: u32,
    /// 1: ground outside the field is free; 0: it is an obstacle.
    pub outside_is_free: u32,
    /// 1: min-max normalisation; 0: by the sum.
    pub min_max: u32,
    /// Returned with a GPU's answer, so that a stale one is noticed; no other number depends on it.
    pub stamp: u32,
    /// Fills up to the 16-byte boundary that WGSL wants for what follows.
    pub padding: u32,
    /// Weights of heading, clearance, velocity and path; their sum is about 2^30.
    pub weights: [u32; 4],
}

/// A forward speed. TWIN of `Speed` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Speed {
    /// Units a step, scaled so that a product with a coarse displacement is shifted by [`Header::coarse_bits`].
    pub coarse: i32,
    /// Fine units a step, scaled likewise for [`Header::fine_bits`].
    pub fine: i32,
    /// The velocity term.
    pub term: u32,
    /// What stopping takes: units of clearance, or steps of arc.
    pub needs: u32,
}

/// A turn rate. TWIN of `Turn` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Turn {
    /// Binary angle a step.
    pub per_step: u32,
    /// What stopping takes: units of clearance, or steps of arc.
    pub needs: u32,
}

/// A disc of the footprint in units. TWIN of `BodyDisc` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct BodyDisc {
    /// Centre ahead of the robot's origin.
    pub x: i32,
    /// Centre to the left of it.
    pub y: i32,
    /// Radius.
    pub radius: i32,
}

impl BodyDisc {
    /// Whether it is around the robot's origin, so that it stays where it is as the robot turns.
    #[must_use]
    #[inline]
    pub const fn is_central(&self) -> bool {
        self.x == 0 && self.y == 0
    }
}

/// A moving obstacle in the field's frame. TWIN of `MovingBody` in `shaders/layout.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct MovingBody {
    /// Centre now from the robot's start, 256ths of a unit.
    pub x: i32,
    /// Centre now from the robot's start, 256ths of a unit.
    pub y: i32,
    /// Motion a step, 256ths of a unit.
    pub step_x: i32,
    /// Motion a step, 256ths of a unit.
    pub step_y: i32,
    /// Radius, units.
    pub radius: i32,
}
