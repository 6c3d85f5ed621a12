//! A square of entries small enough for registers.

/// Entries of a large patch, and two more, for vectors that read two at a time.
const ROOM: usize = Patch::LARGE * Patch::LARGE + 2;

/// A square of a list's entries, its side 8 or 16, row by row.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Patch([u16; ROOM]);

impl Patch {
    /// The side of a small patch.
    pub const SMALL: usize = 8;
    /// The side of a large one.
    pub const LARGE: usize = 16;

    /// Copies the square that begins at `corner` of a list whose rows are `pitch` long.
    #[inline(always)]
    pub fn copy<const SIDE: usize>(&mut self, list: &[u16], corner: usize, pitch: usize) {
        let mut from = corner;
        for row in self.0[..SIDE * SIDE].chunks_exact_mut(SIDE) {
            row.copy_from_slice(&list[from..][..SIDE]);
            from += pitch;
        }
    }

    /// The entries, and two more.
    #[inline(always)]
    pub const fn entries(&self) -> &[u16; ROOM] {
        &self.0
    }
}

impl Default for Patch {
    fn default() -> Self {
        Self([0; ROOM])
    }
}
