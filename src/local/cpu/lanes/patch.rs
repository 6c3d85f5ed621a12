//! A square of entries small enough for registers.

/// The side of a large patch.
const LARGE: usize = 16;

/// A square of a list's entries, its side 8 or 16, row by row.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Patch([u16; LARGE * LARGE + 2]);

impl Patch {
    /// Sides of a small patch and of a large one.
    pub const SIDES: [usize; 2] = [8, LARGE];

    /// Copies the square that begins at `corner` of a list whose rows are `pitch` long.
    #[inline(always)]
    pub fn copy<const SIDE: usize>(&mut self, list: &[u16], corner: usize, pitch: usize) {
        let mut from = corner;
        for row in self.0[..SIDE * SIDE].chunks_exact_mut(SIDE) {
            row.copy_from_slice(&list[from..][..SIDE]);
            from += pitch;
        }
    }

    /// The entries, and two more, for vectors that read two at a time.
    #[inline(always)]
    pub const fn entries(&self) -> &[u16; LARGE * LARGE + 2] {
        &self.0
    }
}

impl Default for Patch {
    fn default() -> Self {
        Self([0; LARGE * LARGE + 2])
    }
}
