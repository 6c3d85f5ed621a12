//! The lower bound for the engine's time: gathers from the distance field and nothing else.

use inbye::local::InstructionSet;
use inbye::local::internals::lanes::{LaneTask, Lanes, MAX_LANES};

/// Reads entries of the field at many cells, as fast as the instruction set allows.
///
/// A decision with one disc reads one entry per sample and step. An engine that evaluates every step cannot be faster
/// than this over as many cells.
pub struct GatherBaseline(pub InstructionSet);

impl GatherBaseline {
    /// The smallest entry of a list at these indices. An incomplete vector at the end is ignored. The list has at least one
    /// entry more than the greatest index.
    pub fn min_entry(&self, list: &[u16], cells: &[i32]) -> i32 {
        if self.0 == InstructionSet::Scalar {
            return cells.iter().fold(i32::MAX, |least, &cell| {
                let index = (cell as u32 as usize).min(list.len() - 1);
                least.min(i32::from(list[index]))
            });
        }
        self.0.run(Gathering { list, cells }).expect("the processor has the instructions")
    }
}

struct Gathering<'a> {
    list: &'a [u16],
    cells: &'a [i32],
}

impl LaneTask for Gathering<'_> {
    type Output = i32;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::FeatureToken) -> i32 {
        let Self { list, cells } = self;
        let most = L::splat(token, i32::from(u16::MAX));
        // Four independent gathers at a time.
        let (mut one, mut two, mut three, mut four) = (most, most, most, most);
        for cells in cells.chunks_exact(4 * MAX_LANES) {
            for at in (0..4 * MAX_LANES).step_by(4 * L::COUNT) {
                one = one.min_dirty_high(L::load(token, &cells[at..]).gather_dirty_high(list));
                two = two.min_dirty_high(
                    L::load(token, &cells[at + L::COUNT..]).gather_dirty_high(list),
                );
                three = three.min_dirty_high(
                    L::load(token, &cells[at + 2 * L::COUNT..]).gather_dirty_high(list),
                );
                four = four.min_dirty_high(
                    L::load(token, &cells[at + 3 * L::COUNT..]).gather_dirty_high(list),
                );
            }
        }
        one.min_dirty_high(two).min_dirty_high(three.min_dirty_high(four)).mask_high().reduce_min()
    }
}
