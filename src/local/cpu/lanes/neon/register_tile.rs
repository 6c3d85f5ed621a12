//! A register tile of NEON: two tables of bytes.
#![expect(unsafe_code, reason = "vector instructions, fewer than the compiler makes of loops")]

// The lint applies only outside of tests.
#[cfg_attr(
    not(test),
    expect(clippy::wildcard_imports, reason = "every other name in this file is an intrinsic")
)]
use core::arch::aarch64::*;

use super::super::{LARGE_TILE, SMALL_TILE, Square};

/// A square, row-major: the lower and the upper bytes of its entries. A small square fills a quarter of the registers.
#[derive(Clone, Copy, Debug)]
pub struct RegisterTile {
    lower: [uint8x16_t; LARGE_TILE],
    upper: [uint8x16_t; LARGE_TILE],
}

/// Indices in one register.
static PLACES: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Eight entries as bytes.
#[inline(always)]
fn eight(entries: &[u16]) -> uint8x16_t {
    let entries = &entries[..8];
    run!(vreinterpretq_u8_u16(vld1q_u16(entries.as_ptr())))
}

/// The upper halves of the lanes of two vectors, in turn, shifted left.
#[inline(always)]
fn upper_halves(one: int32x4_t, other: int32x4_t, bits: i16) -> uint16x8_t {
    run!({
        let halves = vtrn2q_u16(vreinterpretq_u16_s32(one), vreinterpretq_u16_s32(other));
        vshlq_u16(halves, vdupq_n_s16(bits))
    })
}

/// The bytes at these indices in the first registers of a table.
#[inline(always)]
fn bytes_at<const SIDE: usize>(
    table: &[uint8x16_t; LARGE_TILE],
    mut index: uint8x16_t,
) -> uint8x16_t {
    let four = |number: usize| {
        let table = &table[4 * number..][..4];
        uint8x16x4_t(table[0], table[1], table[2], table[3])
    };
    let mut found = run!(vqtbl4q_u8(four(0), index));
    let mut number = 1;
    while number < SIDE * SIDE / 64 {
        // An index beyond the four registers keeps what was found.
        index = run!(vsubq_u8(index, vdupq_n_u8(64)));
        found = run!(vqtbx4q_u8(found, four(number), index));
        number += 1;
    }
    found
}

impl RegisterTile {
    /// Copies a square.
    #[inline(always)]
    pub fn of<const SIDE: usize>(square: &Square<'_>) -> Self {
        run!({
            // Columns are modulo the side, in each row. Sixteen entries are two rows of a small square, or one of a large one.
            let places = vld1q_u8(PLACES.as_ptr());
            let before = vsubq_u8(places, vdupq_n_u8(square.column as u8));
            let from = vshlq_n_u8::<1>(vbslq_u8(vdupq_n_u8(SIDE as u8 - 1), before, places));
            let next = vorrq_u8(from, vdupq_n_u8(1));
            let mut lower = [vdupq_n_u8(0); LARGE_TILE];
            let mut upper = lower;
            let mut number = 0;
            while number < SIDE * SIDE / 16 {
                let pair = if SIDE == SMALL_TILE {
                    let row = |row| eight(square.row::<SIDE>(row));
                    uint8x16x2_t(row(2 * number), row(2 * number + 1))
                } else {
                    let row = square.row::<SIDE>(number);
                    uint8x16x2_t(eight(row), eight(&row[8..]))
                };
                lower[number] = vqtbl2q_u8(pair, from);
                upper[number] = vqtbl2q_u8(pair, next);
                number += 1;
            }
            Self { lower, upper }
        })
    }

    /// See [`Lanes::look_up`](super::super::Lanes::look_up): the columns of both pairs, and their rows.
    #[inline(always)]
    pub fn look_up<const SIDE: usize>(
        &self,
        columns: [[int32x4_t; 2]; 2],
        rows: [[int32x4_t; 2]; 2],
        bits: u32,
    ) -> [int32x4_t; 2] {
        // The row and then the column, in the highest bits. Shifts to the left drop all bits above them.
        let bits = 32 - (bits + SIDE.ilog2()) as i16;
        let place = |half: usize| {
            let column = upper_halves(columns[0][half], columns[1][half], bits);
            let row = upper_halves(rows[0][half], rows[1][half], bits);
            run!(vreinterpretq_u8_u16(if SIDE == SMALL_TILE {
                vsriq_n_u16::<3>(row, column)
            } else {
                vsriq_n_u16::<4>(row, column)
            }))
        };
        run!({
            let places = vuzp2q_u8(place(0), place(1));
            let index = if SIDE == SMALL_TILE { vshrq_n_u8::<2>(places) } else { places };
            let lower = bytes_at::<SIDE>(&self.lower, index);
            let upper = bytes_at::<SIDE>(&self.upper, index);
            [
                vreinterpretq_s32_u8(vzip1q_u8(lower, upper)),
                vreinterpretq_s32_u8(vzip2q_u8(lower, upper)),
            ]
        })
    }
}
