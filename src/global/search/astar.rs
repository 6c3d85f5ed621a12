//! A* on an 8-connected grid without corner cutting (paper, section 3.2; eq. 13).

use super::labels::{Arrival, Labels};
use super::moves::{COSTS, MOVES, Node, allowed};
use super::open_list::OpenList;
use crate::map::{Cell, FreeSpace};

/// Marks the start cell in place of a move.
pub(super) const START: Arrival = 8;

/// The result of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// Cost of the cheapest path; none if there is no path.
    pub cost: Option<u64>,
    /// Number of cell expansions.
    pub expanded: u32,
}

/// Labels cells until the cheapest path to the goal is known. Both ends must be free; labels and open list must be empty.
///
/// `estimate` is the heuristic. `price` maps the index of a cell and the base cost of a move to it to the actual cost.
#[inline(always)]
pub(super) fn search<O: OpenList>(
    space: &FreeSpace,
    (start, goal): (Node, Node),
    labels: &mut Labels,
    open: &mut O,
    estimate: impl Fn(Cell) -> u64,
    price: impl Fn(usize, u64) -> u64,
) -> Outcome {
    let frame = space.frame();
    let (free, _) = space.bits();
    let leads = MOVES.map(|(dx, dy)| dy as isize * frame.width as isize + dx as isize);
    let mut expanded = 0;
    let mut best = if start == goal { 0 } else { u64::MAX };
    labels.reach(start.index(frame), 0, START, O::SETTLES);
    open.push(estimate(start.cell()), 0, start);
    while let Some((node, bound)) = open.pop() {
        if best <= bound && (node == goal || !O::SETTLES) {
            break;
        }
        let index = node.index(frame);
        let Some((cost, _)) = labels.expand(index) else {
            continue;
        };
        let cell = node.cell();
        if !O::SETTLES && best < u64::MAX && cost + estimate(cell) >= best {
            continue;
        }
        expanded += 1;
        let mut moves = allowed(free, free.position(cell.column, cell.row));
        while moves != 0 {
            let number = moves.trailing_zeros() as usize;
            moves &= moves - 1;
            let index = index.wrapping_add_signed(leads[number]);
            let cost = cost + price(index, COSTS[number]);
            if labels.reach(index, cost, number as Arrival, O::SETTLES) {
                let (dx, dy) = MOVES[number];
                let next = node.moved(dx, dy);
                if next == goal {
                    best = cost;
                }
                open.push(cost + estimate(next.cell()), cost, next);
            }
        }
    }
    Outcome { cost: (best < u64::MAX).then_some(best), expanded }
}

/// Follows the labels from the goal back to the start and appends the cells.
pub(super) fn trace_back(space: &FreeSpace, labels: &Labels, goal: Node, cells: &mut Vec<Cell>) {
    let mut node = goal;
    cells.push(node.cell());
    let arrival = |node: Node| usize::from(labels.arrival(node.index(space.frame())));
    while let Some(&(dx, dy)) = MOVES.get(arrival(node)) {
        node = node.moved(-dx, -dy);
        cells.push(node.cell());
    }
}
