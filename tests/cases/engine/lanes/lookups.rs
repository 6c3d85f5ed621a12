//! Lookup operations.

use super::cases::{Case, Shared};
use super::operations::{Operation, any, each, stored, whole};
use inbye::local::internals::lanes::Lanes;

pub fn lists<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each(
            "row_major",
            any,
            |p, x, y, s| L::row_major(p, x, y, 16 + s.bits % 16, s.width),
            |x, y, s| {
                let bits = 16 + s.bits % 16;
                (y >> bits) * s.width + (x >> bits)
            },
        ),
        each(
            "gather",
            within,
            |_, x, _, s| x.gather(s.list()),
            |x, _, s| i32::from(s.list()[x as usize]),
        ),
        each(
            "gather_dirty_high, min_dirty_high and mask_high",
            within,
            |_, x, y, s| {
                let (one, other) = (x.gather_dirty_high(s.list()), y.gather_dirty_high(s.list()));
                one.min_dirty_high(other).mask_high()
            },
            |x, y, s| i32::from(s.list()[x as usize].min(s.list()[y as usize])),
        ),
        each(
            "min_dirty_high of clean halves",
            |[x, y], _| [x & 0xFFFF, y & 0xFFFF],
            |_, x, y, _| x.min_dirty_high(y).mask_high(),
            |x, y, _| x.min(y),
        ),
        each(
            "min_halves",
            any,
            |_, x, y, _| x.min_halves(y),
            |x, y, _| {
                let low = (x as u16).min(y as u16);
                let high = (x as u32 >> 16).min(y as u32 >> 16);
                (high << 16) as i32 | i32::from(low)
            },
        ),
        look_up::<L, 8>("look_up in a small register tile"),
        look_up::<L, 16>("look_up in a large register tile"),
        whole(
            "gather beyond the list",
            any,
            |_, x, _, s| {
                let is_entry = |&word: &i32| s.list().iter().any(|&entry| i32::from(entry) == word);
                let known = stored(x.gather(s.list())).into_iter().map(|word| {
                    // Long lists contain half of all values, and searching them takes long.
                    i32::from(s.width > 2000 && (0..=0xFFFF).contains(&word) || is_entry(&word))
                });
                known.collect()
            },
            |cases, _| vec![1; cases.len()],
        ),
    ]
}

/// Two lookups in a register tile; the second exchanges columns and rows.
const fn look_up<L: Lanes, const SIDE: usize>(name: &'static str) -> Operation<L> {
    each(
        name,
        any,
        |token, x, y, shared| {
            let register_tile = L::register_tile::<SIDE>(token, &shared.square());
            L::look_up::<SIDE>(token, &register_tile, (x, y), (y, x), shared.tile_bits())
        },
        |x, y, shared| shared.entry::<SIDE>(x, y) | (shared.entry::<SIDE>(y, x) << 16),
    )
}

/// Indices before the last entry of the list.
fn within([x, y]: Case, shared: &Shared) -> Case {
    [x.rem_euclid(shared.width), y.rem_euclid(shared.width)]
}
