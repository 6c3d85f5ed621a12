//! A* over cells with room for every heading, and over lattice points with a heading elsewhere.

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use super::cost::{length_cost, narrow_cost, turn_cost};
use super::distances::{Distances, NEIGHBOURS};
use super::headings::{COUNT, LONGEST, PARTS};
use super::{HeadingSearcher, Place};
use crate::global::Travel;
use crate::map::{BitGrid, Cell, FreeSpace, GridFrame};

/// Most states that a search expands: about half a second. A path that keeps near to that of the inscribed circle takes a tenth.
/// Beyond, the search floods the map around a passage that the body does not fit, and whatever it finds is a big detour.
const MAX_EXPANDED: u32 = 1 << 18;

/// A state of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum State {
    /// At the centre of a cell with room for every heading.
    Open(Place),
    /// At a lattice point with the heading of this index.
    Heading(Place, u8),
}

/// How a state was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    /// It is a start.
    Start,
    /// From a state with room for every heading, or to one within its cell.
    Open,
    /// By a straight move from a point.
    Straight(Place, Travel),
    /// By a turn in place.
    Turn,
}

#[derive(Clone, Copy, Debug)]
struct Label {
    cost: u64,
    parent: State,
    arrival: Arrival,
    is_expanded: bool,
}

/// Ground of a search.
pub(super) struct Ground<'a> {
    /// Cells without an obstacle.
    pub free: &'a BitGrid,
    /// Cells with room for every heading.
    pub open: &'a FreeSpace,
    /// Costs to the goal.
    pub distances: &'a Distances,
    pub goal: Cell,
    /// Greatest cost of a path.
    pub most: u64,
    /// Distance between lattice points, metres.
    pub spacing_m: f64,
}

impl Ground<'_> {
    fn frame(&self) -> &GridFrame {
        self.open.frame()
    }

    fn is_open(&self, place: Place) -> bool {
        self.open.is_free(place.cell())
    }

    /// Whether every cell that a move can end in is open.
    fn is_deep(&self, cell: Cell) -> bool {
        let (open, _) = self.open.bits();
        let reach = (LONGEST + PARTS) / PARTS;
        (-reach..=reach)
            .all(|dy| open.all_set_in_row(cell.row + dy, cell.column - reach..=cell.column + reach))
    }
}

/// A search under way.
pub(super) struct Lattice<'a> {
    searcher: &'a mut HeadingSearcher,
    ground: Ground<'a>,
    labels: HashMap<State, Label>,
    /// By estimate, then by higher cost so far, then by state.
    queue: BinaryHeap<(Reverse<u64>, u64, State)>,
    expanded: u32,
}

impl<'a> Lattice<'a> {
    pub fn new(searcher: &'a mut HeadingSearcher, ground: Ground<'a>) -> Self {
        Self { searcher, ground, labels: HashMap::new(), queue: BinaryHeap::new(), expanded: 0 }
    }

    /// Adds a state from which a path may begin, at a cost.
    pub fn add_start(&mut self, state: State, cost: u64) {
        self.reach(state, cost, state, Arrival::Start);
    }

    /// The states of the cheapest path in order with how each was reached, and the number of expanded states.
    pub fn path(mut self) -> (Option<Vec<(State, Arrival)>>, u32) {
        let goal = State::Open(Place::center(self.ground.goal));
        while let Some((_, cost, state)) = self.queue.pop() {
            if state == goal {
                return (Some(self.trace_back(goal)), self.expanded);
            }
            let Some(label) = self.labels.get_mut(&state) else {
                continue;
            };
            if label.is_expanded || cost > label.cost {
                continue;
            }
            if self.expanded == MAX_EXPANDED {
                break;
            }
            label.is_expanded = true;
            self.expanded += 1;
            match state {
                State::Open(place) => self.expand_open(place, cost),
                State::Heading(place, heading) => self.expand_heading(place, heading, cost),
            }
        }
        (None, self.expanded)
    }

    fn trace_back(&self, goal: State) -> Vec<(State, Arrival)> {
        let mut path = Vec::new();
        let mut state = goal;
        while let Some(label) = self.labels.get(&state) {
            path.push((state, label.arrival));
            if label.arrival == Arrival::Start {
                break;
            }
            state = label.parent;
        }
        path.reverse();
        path
    }

    fn reach(&mut self, state: State, cost: u64, parent: State, arrival: Arrival) {
        let (State::Open(place) | State::Heading(place, _)) = state;
        let index = self.ground.frame().index(place.cell());
        let estimate = cost.saturating_add(self.ground.distances.cost(index));
        let is_known = self.labels.get(&state).is_some_and(|label| label.cost <= cost);
        if is_known || estimate > self.ground.most {
            return;
        }
        self.labels.insert(state, Label { cost, parent, arrival, is_expanded: false });
        self.queue.push((Reverse(estimate), cost, state));
    }

    fn expand_open(&mut self, place: Place, cost: u64) {
        let cell = place.cell();
        let from = State::Open(place);
        for (dx, dy) in NEIGHBOURS {
            let at = |dx: i32, dy: i32| Cell::new(cell.column + dx, cell.row + dy);
            let open = self.ground.open;
            if [at(dx, dy), at(dx, 0), at(0, dy)].into_iter().all(|cell| open.is_free(cell)) {
                let length = libm::hypot(f64::from(dx), f64::from(dy)) * f64::from(PARTS);
                let next = State::Open(Place::center(at(dx, dy)));
                self.reach(next, cost + length_cost(length), from, Arrival::Open);
            }
        }
        if self.ground.is_deep(cell) {
            return;
        }
        // The axis of a passage may run along an edge of the cells.
        for (left, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let via = place.moved(-left, -down);
            let cost = cost + length_cost(libm::hypot(f64::from(left), f64::from(down)));
            for heading in 0..COUNT {
                self.drive(via, heading, cost, from, |ground, to| !ground.is_open(to));
            }
        }
    }

    fn expand_heading(&mut self, place: Place, heading: u8, cost: u64) {
        let from = State::Heading(place, heading);
        let center = Place::center(place.cell());
        if self.ground.is_open(place) {
            let aside = place.distance(center);
            return self.reach(State::Open(center), cost + length_cost(aside), from, Arrival::Open);
        }
        let heading = usize::from(heading);
        self.drive(place, heading, cost, from, |_, _| true);
        for next in [(heading + 1) % COUNT, (heading + COUNT - 1) % COUNT] {
            let turn = self.searcher.turn(heading, next);
            let state = State::Heading(place, next as u8);
            if self.searcher.can_turn(self.ground.free, place, heading, next) {
                let cost = cost + turn_cost(turn, self.ground.spacing_m);
                self.reach(state, cost, from, Arrival::Turn);
            }
        }
    }

    /// Reaches the ends of the straight moves from a place that are wanted.
    fn drive(
        &mut self,
        place: Place,
        heading: usize,
        cost: u64,
        from: State,
        is_wanted: impl Fn(&Ground<'_>, Place) -> bool,
    ) {
        let (dx, dy) = self.searcher.headings[heading].step;
        let length = self.searcher.headings[heading].length;
        for (travel, to) in
            [(Travel::Forward, place.moved(dx, dy)), (Travel::Backward, place.moved(-dx, -dy))]
        {
            let is_backward = travel == Travel::Backward;
            let is_possible = self.searcher.may_reverse || !is_backward;
            // A backward move sweeps the same cells as the forward move from its end.
            let tail = if is_backward { to } else { place };
            if is_possible
                && self.ground.frame().contains(to.cell())
                && is_wanted(&self.ground, to)
                && self.searcher.can_drive(self.ground.free, tail, heading)
            {
                let cost = cost + narrow_cost(length, is_backward);
                let state = State::Heading(to, heading as u8);
                self.reach(state, cost, from, Arrival::Straight(place, travel));
            }
        }
    }
}
