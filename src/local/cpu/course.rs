//! What all rows of a decision share, laid out for lanes.

use super::lanes::MOST_LANES;
use crate::local::Prepared;
use crate::local::inputs::{Header, MovingBody};
use crate::numeric::shift_round;

/// The most samples of a chunk.
pub const MOST_SAMPLES: usize = 128;

/// With more slack than this at the last step, cells, sifting costs more than it saves.
const MOST_SLACK_CELLS: i32 = 12;

/// Rounding of two stored distances, and of two positions, units.
pub const ROUNDING: i64 = 4;

/// Lists of the problem as columns, filled up to whole vectors by repeating the last entry. Kept from one decision to
/// the next, so that a decision allocates nothing.
#[derive(Debug, Default)]
pub struct Course {
    /// Coarse speeds.
    pub coarse: Vec<i32>,
    /// Coarse speeds in both halves of each word.
    pub coarse_twice: Vec<i32>,
    /// Fine speeds.
    pub fine: Vec<i32>,
    /// Velocity terms.
    pub term: Vec<i32>,
    /// What stopping takes.
    pub needs: Vec<i32>,
    /// For each moving obstacle and step its centre in units from the field's corner: all x, then all y.
    pub tracks: Vec<i32>,
    /// Speeds filled up.
    pub stride: usize,
    /// Steps filled up.
    pub steps: usize,
    /// Whether positions are small enough for the short way from a product to a cell ([`super::row::Step`]).
    pub short: bool,
    /// Samples of a chunk, whole vectors.
    pub chunk: usize,
    /// With more slack at the last step than this, all steps are looked at.
    most_slack: i32,
    /// The numbers of all steps, filled up.
    pub every_step: Vec<i32>,
    /// For each step how far, in units, a chunk's samples are at most from its middle one.
    pub apart: Vec<i32>,
    /// For each step how much their clearances differ at most from the middle one's.
    pub slack: Vec<i32>,
}

impl Course {
    /// Takes over a problem.
    pub fn fill(&mut self, problem: &Prepared) {
        let header = &problem.header;
        self.stride = problem.speeds.len().next_multiple_of(MOST_LANES);
        self.steps = (header.steps as usize).next_multiple_of(MOST_LANES);
        let speeds = &problem.speeds;
        column(
            &mut self.coarse,
            self.stride,
            speeds.iter().map(|s| s.coarse),
        );
        column(&mut self.fine, self.stride, speeds.iter().map(|s| s.fine));
        column(
            &mut self.term,
            self.stride,
            speeds.iter().map(|s| s.term as i32),
        );
        column(
            &mut self.needs,
            self.stride,
            speeds.iter().map(|s| s.needs as i32),
        );
        let twice = |coarse: &i32| (coarse << 16) | (coarse & 0xFFFF);
        self.coarse_twice.clear();
        self.coarse_twice.extend(self.coarse.iter().map(twice));
        self.tracks.clear();
        for body in &problem.obstacles {
            let track = |start: i32, at: i32, step: i32| {
                let last = header.steps as i32;
                let steps = 1..=self.steps as i32;
                steps.map(move |steps| start + shift_round(at + steps.min(last) * step, 8))
            };
            let MovingBody {
                x,
                y,
                step_x,
                step_y,
                ..
            } = *body;
            self.tracks.extend(track(header.start_x, x, step_x));
            self.tracks.extend(track(header.start_y, y, step_y));
        }
        self.short = self.is_short(header);
        self.divide(header);
    }

    fn is_short(&self, header: &Header) -> bool {
        let bits = header.coarse_bits + header.cell_bits;
        if !(16..=30).contains(&bits) {
            return false;
        }
        let fastest = self.coarse.iter().map(|coarse| coarse.unsigned_abs()).max();
        // The most that the coarse table can hold: a cosine is at most one, and one in 2^20 more by its rounding.
        let growth = ((i64::from(header.steps) * ((1 << 20) + 1)) >> header.table_bits) + 1;
        let product = i64::from(fastest.unwrap_or_default()) * growth;
        // What is added is less than a cell and half a unit, in the product's scale.
        let fits = product + 2 * (1 << bits) < 1 << 31;
        let cells = (product >> bits) + 2;
        fits && growth < 65_535 && cells < 1 << 15 && header.width < 1 << 15
    }

    /// Divides the rows into chunks of samples that end about a cell from their middle one.
    fn divide(&mut self, header: &Header) {
        let spread = i64::from(self.coarse[self.stride - 1]) - i64::from(self.coarse[0]);
        let reach = spread.abs() * per_step(header.table_bits) * i64::from(header.steps);
        let ends = (reach >> header.coarse_bits).max(1);
        let samples = 2 * (i64::from(header.v_count) << header.cell_bits) / ends;
        let most = MOST_SAMPLES.min(self.stride);
        self.chunk = (samples.max(1) as usize)
            .min(most)
            .next_multiple_of(MOST_LANES);

        let from_middle = |samples: &[i32]| {
            let middle = samples[samples.len() / 2];
            let [first, last] = [samples[0], samples[samples.len() - 1]];
            i64::from((first - middle).abs().max((last - middle).abs()))
        };
        let away = self.coarse.chunks(self.chunk).map(from_middle).max();
        // In 256ths of a unit, so that little is added by rounding up.
        let away =
            ((away.unwrap_or_default() * per_step(header.table_bits)) << 8) >> header.coarse_bits;
        let cell = 1 << header.cell_bits;
        // 1.41422 in Q16 is above the root of two.
        let diagonal = ((92_683_i64 << header.cell_bits) >> 16) + 1;
        self.most_slack = MOST_SLACK_CELLS << header.cell_bits;
        self.every_step.clear();
        self.every_step.extend(0..self.steps as i32);
        self.apart.clear();
        self.slack.clear();
        for steps in 1..=self.steps as i64 {
            let apart = ((steps * (away + 1)) >> 8) + ROUNDING;
            // Less than a cell apart, centres are no more than a diagonal apart.
            let further = if apart < cell { 0 } else { apart };
            self.apart.push(apart as i32);
            self.slack.push((further + diagonal + ROUNDING) as i32);
        }
    }

    /// Whether a chunk's samples stay near enough to one another to leave steps out.
    pub fn is_worth_sifting(&self) -> bool {
        self.slack
            .last()
            .is_some_and(|&slack| slack <= self.most_slack)
    }

    /// The columns x and y of one moving obstacle.
    pub fn track(&self, body: usize) -> (&[i32], &[i32]) {
        self.tracks[2 * body * self.steps..][..2 * self.steps].split_at(self.steps)
    }
}

fn column(list: &mut Vec<i32>, stride: usize, values: impl Iterator<Item = i32>) {
    list.clear();
    list.extend(values);
    let last = list.last().copied().unwrap_or_default();
    list.resize(stride, last);
}

/// The most by which the coarse table's displacement grows in one step: a cosine of one, a rounding, and what the
/// polynomials of sine and cosine may be off.
const fn per_step(table_bits: u32) -> i64 {
    (1 << (20 - table_bits)) + 2
}
