//! The table of one turn profile: the positions of the footprint's discs at each step. Lanes are steps here.

use super::arithmetic::{cos_q20, shift_round, sin_q20};
use super::lanes::{Lanes, MAX_LANES};
use super::soa_inputs::SoaInputs;
use crate::local::QuantizedProblem;
use crate::local::kernel_inputs::{Header, ProfileSegment};
use crate::numeric::{self, mul_hi_i32};

/// The table of one turn profile, by step.
///
/// A disc's x position is `disc_x + round(coarse x / 2^coarse_bits)`, and its column is that divided by `2^cell_bits`.
/// One shift does both divisions: `across` holds the part of `disc_x` below a cell plus the rounding half, in the scale
/// of the product. The column is that of `disc_x` plus `(coarse x + across) >> (coarse_bits + cell_bits)`.
#[derive(Debug, Default)]
pub struct DisplacementTable {
    cosines: Vec<i32>,
    sines: Vec<i32>,
    /// Share of the sample's own speed.
    shares: Vec<i32>,
    /// Displacement of a sample of speed zero, x. Empty where profiles have no speed of their own, as `base_y`.
    base_x: Vec<i32>,
    /// The same along y.
    base_y: Vec<i32>,
    /// Coarse displacement along x.
    pub x: Vec<i32>,
    /// Coarse displacement along y.
    pub y: Vec<i32>,
    /// `x` as two 16-bit numbers whose sum is `x`.
    pub x_halves: Vec<i32>,
    /// `y` as two 16-bit numbers whose sum is `y`.
    pub y_halves: Vec<i32>,
    /// Centre of each disc at each step for a sample of speed zero, x.
    pub disc_x: Vec<i32>,
    /// Centre of each disc at each step for a sample of speed zero, y.
    pub disc_y: Vec<i32>,
    /// Addend from a product to its cell for each disc and step, x.
    pub across: Vec<i32>,
    /// Addend from a product to its cell for each disc and step, y.
    pub along: Vec<i32>,
    /// The cell of each disc for a sample of speed zero.
    pub cell: Vec<i32>,
    /// `disc_x` and the rounding half, in the scale of the product, modulo 2^32. Only for lanes with register lookups,
    /// as `y_scaled`.
    pub x_scaled: Vec<i32>,
    /// The same along y.
    pub y_scaled: Vec<i32>,
    /// Sum of cosines times their shares in Q20.
    pub end_x: i32,
    /// Sum of sines times their shares in Q20.
    pub end_y: i32,
    /// Final position of a sample of speed zero relative to the start, fine units.
    pub base_end: [i32; 2],
}

impl DisplacementTable {
    /// Fills the table of a row; entries beyond the last step repeat it.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        row: usize,
    ) {
        let segments = problem.segments(row);
        self.fill_headings::<L>(token, &problem.header, segments);
        self.base_end = [0; 2];
        if inputs.profiles_have_speeds() {
            self.fill_shares::<L>(token, segments);
            self.fill_base::<L>(token, problem, inputs, row);
        }
        self.fill_displacements::<L>(token, &problem.header, inputs);
        self.fill_discs::<L>(token, problem, inputs, false);
    }

    /// Computes the positions of either the fixed discs or the others ([`SoaInputs::is_fixed`]).
    #[inline(always)]
    pub fn fill_discs<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        fixed: bool,
    ) {
        for (number, disc) in problem.discs.iter().enumerate() {
            if inputs.is_fixed(disc) == fixed {
                self.fill_disc::<L>(token, problem, inputs, number);
            }
        }
    }

    /// Resizes the columns for this decision.
    #[inline(always)]
    pub fn resize<L: Lanes>(&mut self, inputs: &SoaInputs, discs: usize) {
        // The discs of a step are turned already: there is one more angle than steps.
        let angles = inputs.steps + MAX_LANES;
        let cells = inputs.steps * discs;
        let shared = if inputs.profiles_have_speeds() { inputs.steps } else { 0 };
        let is_sized = self.cosines.len() == angles && self.disc_x.len() == cells;
        if is_sized && self.base_x.len() == shared {
            return;
        }
        for list in [&mut self.shares, &mut self.base_x, &mut self.base_y] {
            list.resize(shared, 0);
        }
        self.cosines.resize(angles, 0);
        self.sines.resize(angles, 0);
        for list in [&mut self.x, &mut self.y, &mut self.x_halves, &mut self.y_halves] {
            list.resize(inputs.steps, 0);
        }
        for list in
            [&mut self.disc_x, &mut self.disc_y, &mut self.across, &mut self.along, &mut self.cell]
        {
            list.resize(cells, 0);
        }
        if L::LARGEST_REGISTER_TILE > 0 {
            self.x_scaled.resize(cells, 0);
            self.y_scaled.resize(cells, 0);
        }
    }

    /// Computes the cosines and sines of all headings; those beyond the last repeat it.
    #[inline(always)]
    fn fill_headings<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        header: &Header,
        segments: &[ProfileSegment],
    ) {
        let heading = L::splat(token, header.heading as i32);
        let (mut cosines, mut sines) = (heading, heading);
        for at in (0..self.cosines.len()).step_by(L::COUNT) {
            if at <= header.steps as usize {
                let steps = lane_indices::<L>(token).add(L::splat(token, at as i32));
                let angle = heading.add(turned::<L>(token, segments, steps));
                (cosines, sines) = (cos_q20(token, angle), sin_q20(token, angle));
            } else {
                cosines = L::splat(token, cosines.last());
                sines = L::splat(token, sines.last());
            }
            cosines.store(&mut self.cosines[at..]);
            sines.store(&mut self.sines[at..]);
        }
    }

    /// Computes the share of the sample's own speed in each step; those beyond the last step are undefined.
    #[inline(always)]
    fn fill_shares<L: Lanes>(&mut self, token: L::FeatureToken, segments: &[ProfileSegment]) {
        for at in (0..self.shares.len()).step_by(L::COUNT) {
            let step = lane_indices::<L>(token).add(L::splat(token, at as i32));
            let mut shares = L::splat(token, 0);
            let mut begin = 0;
            for segment in segments {
                let after = step.sub(L::splat(token, begin as i32));
                let growth = after.mul(L::splat(token, segment.share_growth));
                let here = L::splat(token, segment.share).add(growth);
                // Later segments replace the value of the steps after this one.
                let begun = after.less(L::splat(token, 0));
                shares = L::select(begun, shares, here);
                begin = segment.end;
            }
            shares.store(&mut self.shares[at..]);
        }
    }

    /// Computes the displacements of a sample of speed zero, and keeps the cosines and sines times their shares.
    #[inline(always)]
    fn fill_base<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        row: usize,
    ) {
        let header = &problem.header;
        let profile = &problem.profiles[row];
        let (zero, steps) = (L::splat(token, 0), L::splat(token, header.steps as i32));
        let coarse = L::splat(token, profile.coarse);
        let lists = [(&self.cosines, &mut self.base_x), (&self.sines, &mut self.base_y)];
        for ((values, base), end) in lists.into_iter().zip(&mut self.base_end) {
            let mut rest = 0;
            for at in (0..inputs.steps).step_by(L::COUNT) {
                let number = lane_indices::<L>(token).add(L::splat(token, at as i32));
                let values = L::load(token, &values[at..]);
                let own = own_share(values, L::load(token, &self.shares[at..]));
                let values = L::select(number.less(steps), values.sub(own), zero);
                let sum = values.prefix_sums().add(L::splat(token, rest));
                rest = sum.last();
                let moved = coarse.mul(shift_round(token, sum, header.table_bits));
                shift_round(token, moved, header.coarse_bits).store(&mut base[at..]);
            }
            *end = numeric::shift_round(mul_hi_i32(profile.fine, rest), header.fine_bits);
        }
    }

    /// Computes the displacements, the running sums of cosines and sines times their shares.
    #[inline(always)]
    fn fill_displacements<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        header: &Header,
        inputs: &SoaInputs,
    ) {
        let (zero, low) = (L::splat(token, 0), L::splat(token, 0xFFFF));
        let steps = L::splat(token, header.steps as i32);
        let lists = [
            (&self.cosines, &mut self.x, &mut self.x_halves, &mut self.end_x),
            (&self.sines, &mut self.y, &mut self.y_halves, &mut self.end_y),
        ];
        for (values, sums, halves, end) in lists {
            *end = 0;
            for at in (0..inputs.steps).step_by(L::COUNT) {
                let number = lane_indices::<L>(token).add(L::splat(token, at as i32));
                let values = L::load(token, &values[at..]);
                let values = if inputs.profiles_have_speeds() {
                    own_share(values, L::load(token, &self.shares[at..]))
                } else {
                    values
                };
                // At most 2^20 for each of 1023 steps; nothing is added beyond the last step.
                let values = L::select(number.less(steps), values, zero);
                let sum = values.prefix_sums().add(L::splat(token, *end));
                *end = sum.last();
                let sum = shift_round(token, sum, header.table_bits);
                sum.store(&mut sums[at..]);
                let half = sum.sar(1);
                let packed = sum.sub(half).shl(16).add(half.and(low));
                packed.store(&mut halves[at..]);
            }
        }
    }

    /// Computes the positions of one disc.
    #[inline(always)]
    fn fill_disc<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        number: usize,
    ) {
        let QuantizedProblem { header, discs, .. } = problem;
        let disc = &discs[number];
        let (disc_x, disc_y) = (L::splat(token, disc.x), L::splat(token, disc.y));
        let start_x = L::splat(token, header.start_x);
        let start_y = L::splat(token, header.start_y);
        let within_cell = L::splat(token, (1 << header.cell_bits) - 1);
        let half = L::splat(token, (1 << header.coarse_bits) >> 1);
        let width = L::splat(token, header.width as i32);
        for step in (0..inputs.steps).step_by(L::COUNT) {
            let at = number * inputs.steps + step;
            let cosine = shift_round(token, L::load(token, &self.cosines[step + 1..]), 6);
            let sine = shift_round(token, L::load(token, &self.sines[step + 1..]), 6);
            let x = disc_x.mul(cosine).sub(disc_y.mul(sine));
            let y = disc_x.mul(sine).add(disc_y.mul(cosine));
            let mut x = start_x.add(shift_round(token, x, 14));
            let mut y = start_y.add(shift_round(token, y, 14));
            if inputs.profiles_have_speeds() {
                x = x.add(L::load(token, &self.base_x[step..]));
                y = y.add(L::load(token, &self.base_y[step..]));
            }
            x.store(&mut self.disc_x[at..]);
            y.store(&mut self.disc_y[at..]);
            if !inputs.order_free {
                continue;
            }
            let across = x.and(within_cell).shl(header.coarse_bits).add(half);
            let along = y.and(within_cell).shl(header.coarse_bits).add(half);
            let row = y.sar(header.cell_bits).mul(width);
            across.store(&mut self.across[at..]);
            along.store(&mut self.along[at..]);
            row.add(x.sar(header.cell_bits)).store(&mut self.cell[at..]);
            if L::LARGEST_REGISTER_TILE > 0 {
                let (x_scaled, y_scaled) = (x.shl(header.coarse_bits), y.shl(header.coarse_bits));
                x_scaled.add(half).store(&mut self.x_scaled[at..]);
                y_scaled.add(half).store(&mut self.y_scaled[at..]);
            }
        }
    }
}

/// Turn at the start of each of these steps, binary angles; constant from the end of the last segment.
#[inline(always)]
fn turned<L: Lanes>(token: L::FeatureToken, segments: &[ProfileSegment], steps: L) -> L {
    let (zero, one) = (L::splat(token, 0), L::splat(token, 1));
    let mut turned = zero;
    let mut begin = 0;
    for segment in segments {
        let all = L::splat(token, (segment.end - begin) as i32);
        let driven = steps.sub(L::splat(token, begin as i32)).max(zero).min(all);
        turned = turned.add(driven.mul(L::splat(token, segment.turn as i32)));
        if segment.turn_growth != 0 {
            let changes = driven.mul(driven.sub(one)).sar(1);
            turned = turned.add(changes.mul(L::splat(token, segment.turn_growth as i32)));
        }
        begin = segment.end;
    }
    turned
}

/// These values times the shares of the sample's own speed.
#[inline(always)]
fn own_share<L: Lanes>(values: L, shares: L) -> L {
    shares.mul_hi(values.shl(2))
}

/// Whether every disc of a row's samples stays on the field. Rounded positions are monotonic in the speed, so the first
/// and the last sample bound the others.
#[inline(always)]
pub fn stays_on_field<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    inputs: &SoaInputs,
    table: &DisplacementTable,
) -> bool {
    if inputs.inside {
        return true;
    }
    let header = &problem.header;
    let width = L::splat(token, header.width as i32);
    let height = L::splat(token, header.height as i32);
    for coarse in [inputs.coarse[0], inputs.coarse[inputs.stride - 1]] {
        let coarse = L::splat(token, coarse);
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let moved = displacements_at(token, problem, table, coarse, at);
            for disc in 0..problem.discs.len() {
                let (x, y) = disc_positions_at(token, table, moved, disc * inputs.steps + at);
                let on = L::mask_and(
                    x.sar(header.cell_bits).less_unsigned(width),
                    y.sar(header.cell_bits).less_unsigned(height),
                );
                if L::bitmask(on) != u32::MAX >> (32 - L::COUNT) {
                    return false;
                }
            }
        }
    }
    true
}

/// Displacement of one sample at the steps from `at`.
#[inline(always)]
pub fn displacements_at<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    table: &DisplacementTable,
    coarse: L,
    at: usize,
) -> (L, L) {
    let bits = problem.header.coarse_bits;
    let x = coarse.mul(L::load(token, &table.x[at..]));
    let y = coarse.mul(L::load(token, &table.y[at..]));
    (shift_round(token, x, bits), shift_round(token, y, bits))
}

/// Position of a disc for these displacements.
#[inline(always)]
pub fn disc_positions_at<L: Lanes>(
    token: L::FeatureToken,
    table: &DisplacementTable,
    (moved_x, moved_y): (L, L),
    place: usize,
) -> (L, L) {
    (
        moved_x.add(L::load(token, &table.disc_x[place..])),
        moved_y.add(L::load(token, &table.disc_y[place..])),
    )
}

/// The index of each lane.
#[inline(always)]
pub fn lane_indices<L: Lanes>(token: L::FeatureToken) -> L {
    const NUMBERS: [i32; MAX_LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    L::load(token, &NUMBERS)
}
