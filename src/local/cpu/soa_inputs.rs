//! The inputs that all rows of a decision share, as a structure of arrays for vector loads.

use core::ops::Range;

use super::lanes::MAX_LANES;
use super::reachable_region::max_disc_offset;
use crate::local::QuantizedProblem;
use crate::local::kernel_inputs::{
    Header, ProfileSegment, QuantizedDisc, QuantizedObstacle, VxSample,
};
use crate::numeric::shift_round;

/// Largest number of samples of a chunk.
pub const MAX_SAMPLES: usize = 128;

/// Largest number of rows of a tile.
pub const MAX_ROWS: usize = 16;

/// Number of steps that are looked up together: lists of steps are padded to whole pairs.
pub const PAIR: usize = 2;

/// Largest number of groups of steps, whole vectors.
pub const GROUPS: usize = 2 * MAX_LANES;

/// Approximate distance between the final positions of the samples of a box, cells.
const BOX_CELLS: f64 = 4.0;

/// Approximate distance between the final positions of the rows of a tile, cells.
const TILE_CELLS: f64 = 18.0;

/// Largest distance between the final positions of a chunk's samples for step pruning, cells. Above it the boxes are
/// too large for useful bounds.
const MAX_CELLS: f64 = 22.0;

/// Number of lookups of a tile up to which all of them are as fast as their bounds.
const FEW_LOOKUPS: usize = 1280;

/// Number of samples of a tile and chunk from which finer groups of steps are faster.
const DENSE: usize = 512;

/// Largest number of boxes of a chunk.
const MAX_BOXES: usize = 2;

/// Bound of the rounding of two stored distances, or of two positions with their tables and discs, units.
pub const ROUNDING: f64 = 10.0;

/// The lists of a problem as columns. The last entry is repeated to fill whole vectors. The memory is reused by the
/// next decision, so that a decision allocates nothing.
#[derive(Debug, Default)]
pub struct SoaInputs {
    /// Coarse speeds.
    pub coarse: Vec<i32>,
    /// Coarse speeds, in both halves of each word.
    pub coarse_twice: Vec<i32>,
    /// Fine speeds.
    pub fine: Vec<i32>,
    /// Velocity terms.
    pub velocity_term: Vec<i32>,
    /// Requirements for stopping.
    pub stopping_need: Vec<i32>,
    /// Centre of each moving obstacle at each step, in units from the field's corner: first all x, then all y.
    pub tracks: Vec<i32>,
    /// Number of forward speeds, rounded up to whole vectors of the kernel.
    pub stride: usize,
    /// Number of steps, rounded up to whole vectors of the kernel.
    pub steps: usize,
    /// Whether the order of the steps is free. This needs samples whose status depends on the smallest clearance, and
    /// positions small enough for the short conversion from product to cell
    /// ([`super::displacement_table::DisplacementTable`]).
    pub order_free: bool,
    /// Samples of a chunk, whole vectors.
    pub chunk: usize,
    /// Whether a simple bound shows that no sample can leave the field.
    pub inside: bool,
    /// Rows of a tile.
    pub tile_rows: usize,
    /// Boxes of samples in a chunk.
    pub boxes: usize,
    /// Steps of a group.
    pub group: i32,
    /// Number of groups.
    pub groups: usize,
    /// One at each step at which a group begins, otherwise zero.
    pub group_starts: Vec<i32>,
    /// All steps, in whole pairs.
    pub all_steps: Vec<i32>,
    /// `i32::MIN` for each existing group, `i32::MAX` for the others.
    pub absent_groups: [i32; GROUPS],
    /// Whether step pruning applies: the samples are close together, so their boxes are small, and there are enough of them.
    pub allows_pruning: bool,
    /// For each step, the largest distance of a chunk's samples from its middle sample, units.
    pub max_spread: Vec<i32>,
    /// Number of segments of each profile.
    segment_count: u32,
}

impl SoaInputs {
    /// Fills the columns from a problem, for a kernel with this number of lanes.
    pub fn fill(&mut self, problem: &QuantizedProblem, lanes: usize) {
        let header = &problem.header;
        self.segment_count = header.segment_count;
        self.stride = problem.vx_samples.len().next_multiple_of(lanes);
        self.steps = (header.steps as usize).next_multiple_of(lanes);
        let samples = &problem.vx_samples;
        column(&mut self.coarse, self.stride, samples, |vx| vx.coarse);
        column(&mut self.fine, self.stride, samples, |vx| vx.fine);
        column(&mut self.velocity_term, self.stride, samples, |vx| vx.velocity_term as i32);
        column(&mut self.stopping_need, self.stride, samples, |vx| vx.stopping_need as i32);
        let twice = |coarse: &i32| (coarse << 16) | (coarse & 0xFFFF);
        self.coarse_twice.clear();
        self.coarse_twice.extend(self.coarse.iter().map(twice));
        self.tracks.clear();
        // For all moving obstacles: the number of near ones changes from one decision to the next.
        self.tracks.reserve(2 * self.steps * problem.obstacles.capacity());
        for body in &problem.obstacles {
            let track = |start: i32, at: i32, step: i32| {
                let last = header.steps as i32;
                let steps = 1..=self.steps as i32;
                steps.map(move |steps| start + shift_round(at + steps.min(last) * step, 8))
            };
            let QuantizedObstacle { x, y, step_x, step_y, .. } = *body;
            self.tracks.extend(track(header.start_x, x, step_x));
            self.tracks.extend(track(header.start_y, y, step_y));
        }
        self.order_free = header.stop_by_arc == 0 && self.is_short(header);
        self.divide_tiles(problem);
    }

    fn is_short(&self, header: &Header) -> bool {
        let bits = header.coarse_bits + header.cell_bits;
        if !(16..=30).contains(&bits) {
            return false;
        }
        let fastest = self.coarse.iter().map(|coarse| coarse.unsigned_abs()).max();
        // Bound of the coarse table: a cosine is at most one, and 2^-20 more after rounding.
        let growth = ((i64::from(header.steps) * ((1 << 20) + 1)) >> header.table_bits) + 1;
        let product = i64::from(fastest.unwrap_or_default()) * growth;
        // The addend is less than a cell and half a unit, in the scale of the product.
        let fits = product + 2 * (1 << bits) < 1 << 31;
        let cells = (product >> bits) + 2;
        fits && growth < 65_535 && cells < 1 << 15 && header.width < 1 << 15
    }

    /// Divides the samples into tiles: chunks of speeds, and rows, that end about a cell from their middle one.
    fn divide_tiles(&mut self, problem: &QuantizedProblem) {
        let header = &problem.header;
        let cell = f64::from(1 << header.cell_bits);
        let steps = f64::from(header.steps);
        // Units per step for each unit of coarse speed.
        let per_coarse = 2.0_f64.powi(20 - header.table_bits as i32 - header.coarse_bits as i32);
        let (first, last) = (self.coarse[0], self.coarse[self.stride - 1]);
        let fastest = f64::from(first.abs().max(last.abs())) * per_coarse;

        let spread = f64::from((last - first).abs()) * per_coarse * steps;
        let samples = (2.0 * cell * f64::from(header.vx_count) / spread.max(1.0)) as usize;
        let most = MAX_SAMPLES.min(self.stride);
        self.chunk = samples.clamp(1, most).next_multiple_of(MAX_LANES).min(self.stride);
        let away = self.coarse.chunks(self.chunk).map(from_middle).max();
        let away = f64::from(away.unwrap_or_default()) * per_coarse;

        let chunk_cells = 2.0 * away * steps / cell;
        self.allows_pruning = chunk_cells <= MAX_CELLS;
        self.boxes =
            ((chunk_cells / BOX_CELLS).ceil() as usize).clamp(1, MAX_BOXES).next_power_of_two();

        // The headings of two rows diverge: the distance between the rows grows with the square of the steps.
        let mut between = largest_turn(problem);
        let ends = fastest * between * steps * steps / 2.0;
        self.tile_rows = ((TILE_CELLS * cell / ends.max(1e-9)) as usize).clamp(1, MAX_ROWS);
        if self.profiles_have_speeds() {
            // Neighbouring rows differ more than two turn rates do.
            self.tile_rows = 1;
        }
        self.allows_pruning &= self.stride * self.tile_rows * header.steps as usize > FEW_LOOKUPS;
        between *= (self.tile_rows / 2) as f64;

        let reach = max_disc_offset(problem);
        self.max_spread.clear();
        for step in 1..=self.steps {
            let step = step as f64;
            let between_rows = between * step * (fastest * step / 2.0 + f64::from(reach));
            self.max_spread.push(((away * step + between_rows).ceil() + ROUNDING) as i32);
        }
        self.divide_steps(header);
        // The distance driven straight ahead at the largest speed bounds every displacement.
        let own = problem.profiles.iter().map(|profile| profile.coarse.unsigned_abs()).max();
        let fastest = fastest.max(f64::from(own.unwrap_or_default()) * per_coarse);
        let margin = fastest * steps + f64::from(reach) + 2.0 * ROUNDING;
        let within = |start: i32, cells: u32| {
            let start = f64::from(start);
            start > margin && start + margin < f64::from(cells) * cell
        };
        self.inside = within(header.start_x, header.width) && within(header.start_y, header.height);
    }

    /// Divides the steps into groups.
    fn divide_steps(&mut self, header: &Header) {
        self.all_steps.clear();
        let whole = (header.steps as usize).next_multiple_of(PAIR);
        self.all_steps.extend(0..whole as i32);
        // Bounds of more groups cost the same for few samples as for many.
        let is_dense = self.chunk * self.tile_rows >= DENSE;
        let groups = if is_dense { GROUPS } else { GROUPS / 2 };
        self.group = header.steps.div_ceil(groups as u32) as i32;
        self.groups = (header.steps as usize).div_ceil(self.group as usize);
        self.group_starts.clear();
        self.group_starts.resize(self.steps, 0);
        for group in 0..GROUPS {
            if group < self.groups {
                self.group_starts[group * self.group as usize] = 1;
            }
            self.absent_groups[group] = if group < self.groups { i32::MIN } else { i32::MAX };
        }
    }

    /// The steps of a group; the last group may have fewer.
    #[inline(always)]
    pub const fn steps_of(&self, group: i32) -> Range<usize> {
        let first = group as usize * self.group as usize;
        let end = first + self.group as usize;
        first..if end < self.steps { end } else { self.steps }
    }

    /// Whether the profiles have several segments, and speeds of their own.
    #[inline(always)]
    pub const fn profiles_have_speeds(&self) -> bool {
        self.segment_count > 1
    }

    /// Whether the centre of a disc is the same for a sample of speed zero at every step of every row: a central disc
    /// does not move when the robot turns.
    #[inline(always)]
    pub const fn is_fixed(&self, disc: &QuantizedDisc) -> bool {
        disc.is_central() && !self.profiles_have_speeds()
    }

    /// The columns x and y of one moving obstacle.
    #[inline(always)]
    pub fn track(&self, body: usize) -> (&[i32], &[i32]) {
        self.tracks[2 * body * self.steps..][..2 * self.steps].split_at(self.steps)
    }
}

/// The largest difference from the middle sample.
fn from_middle(samples: &[i32]) -> i32 {
    let middle = samples[samples.len() / 2];
    let [first, last] = [samples[0], samples[samples.len() - 1]];
    (first - middle).abs().max((last - middle).abs())
}

/// The largest angle between neighbouring rows per step, radians.
fn largest_turn(problem: &QuantizedProblem) -> f64 {
    let apart = |pair: &[ProfileSegment]| {
        let apart = pair[1].turn.wrapping_sub(pair[0].turn) as i32;
        apart.unsigned_abs()
    };
    let apart = problem.segments.windows(2).map(apart).max();
    f64::from(apart.unwrap_or_default()) / 2.0_f64.powi(32) * core::f64::consts::TAU
}

fn column(
    list: &mut Vec<i32>,
    stride: usize,
    samples: &[VxSample],
    value: impl Fn(&VxSample) -> i32,
) {
    list.clear();
    list.extend(samples.iter().map(value));
    let last = list.last().copied().unwrap_or_default();
    list.resize(stride, last);
}
