//! Paths for a body that is longer than wide. Where its circumscribed circle does not fit, the state of the search includes the
//! heading.

use core::cmp::Reverse;
use core::f64::consts::TAU;
use core::iter::{once, successors};
use std::collections::BinaryHeap;

use super::{ClearanceCosts, Path, STRAIGHT};
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::{Cell, FreeSpace, GridFrame};

/// Moves ahead at each heading, cells. The headings are those of the moves; each quarter turn repeats the first eight.
const AHEAD: [(i32, i32); 32] = {
    let mut moves = [(0, 0); 32];
    let first = [(1, 0), (4, 1), (2, 1), (4, 3), (1, 1), (3, 4), (1, 2), (1, 4)];
    let mut heading = 0;
    while heading < moves.len() {
        moves[heading] = if heading < first.len() {
            first[heading]
        } else {
            let (dx, dy) = moves[heading - first.len()];
            (-dy, dx)
        };
        heading += 1;
    }
    moves
};
const HEADINGS: usize = AHEAD.len();
/// A turn to the next heading costs as much as this distance, metres.
const TURN_M: f64 = 0.05;
/// The search with headings stays this close to the path of the discs, metres.
const REACH_M: f64 = 1.5;
/// Most cells of that search: a path of 200 m over cells of 5 cm has as many. It takes 400 bytes for each.
const MAX_CELLS: usize = 250_000;
/// Distance and angle between two checked poses, metres and radians.
const STEP_M: f64 = 0.05;
const STEP_RAD: f64 = 0.1;

/// The free space of a body made of equal discs.
#[derive(Clone, Copy, Debug)]
pub struct BodySpace<'a> {
    /// Centres of the discs in the robot's frame, metres.
    pub discs: &'a [Point],
    /// Distance that these keep from obstacles, metres.
    pub radius_m: f64,
    /// The cells in which the centre of a disc keeps it wherever it is.
    pub whole: &'a FreeSpace,
    /// The cells in which it keeps it at the cell's centre.
    pub narrow: &'a FreeSpace,
    /// The cells in which the body may have any heading.
    pub wide: &'a FreeSpace,
}

impl BodySpace<'_> {
    fn has_any_heading(&self, place: &Point) -> bool {
        self.wide.frame().cell_of(place).is_some_and(|cell| self.wide.is_free(cell))
    }

    /// Whether the body fits at a place with a heading.
    fn fits_at(&self, place: &Point, yaw: f64) -> bool {
        let pose = Pose::new(place.x, place.y, yaw);
        let frame = self.narrow.frame();
        self.has_any_heading(place)
            || self.discs.iter().all(|center| {
                let center = pose.transform(center);
                frame.cell_of(&center).is_some_and(|cell| {
                    self.whole.is_free(cell)
                        || self.narrow.is_free(cell) && self.narrow.is_clear(&center, self.radius_m)
                })
            })
    }

    /// Whether the body fits at a place with some heading.
    #[must_use]
    pub fn fits(&self, place: &Point) -> bool {
        (0..HEADINGS).any(|heading| self.fits_at(place, heading as f64 / HEADINGS as f64 * TAU))
    }

    /// Whether the body fits on a straight way along which it heads.
    fn fits_ahead(&self, from: &Point, to: &Point, yaw: f64) -> bool {
        let steps = ((to - from).norm() / STEP_M).ceil().max(1.0);
        let at = |step: u32| from + (to - from) * (f64::from(step) / steps);
        (0..=steps as u32).all(|step| self.fits_at(&at(step), yaw))
    }

    /// Whether the body fits while it turns on the spot.
    fn fits_turning(&self, place: &Point, from_yaw: f64, to_yaw: f64) -> bool {
        let turn = wrap_angle(to_yaw - from_yaw);
        let steps = (turn.abs() / STEP_RAD).ceil().max(1.0);
        let at = |step: u32| from_yaw + turn * f64::from(step) / steps;
        self.has_any_heading(place) || (0..=steps as u32).all(|step| self.fits_at(place, at(step)))
    }

    /// Whether the body fits where it heads along the lines between points, and turns at the corners.
    #[must_use]
    pub fn fits_along(&self, points: &[Point]) -> bool {
        let mut last = None;
        points.windows(2).all(|pair| {
            let yaw = bearing(&pair[0], &pair[1]);
            let before = last.replace(yaw).unwrap_or(yaw);
            self.fits_turning(&pair[0], before, yaw) && self.fits_ahead(&pair[0], &pair[1], yaw)
        })
    }

    /// A path near another one, on which the body fits; `None` where there is none. The other path leads through cells in which a
    /// disc of the body may be.
    ///
    /// Searches over cells and headings by A*: the body drives ahead, or turns on the spot. Costs are those of the clearance.
    #[must_use]
    pub fn path_near(&self, guide: &Path, costs: &ClearanceCosts) -> Option<Path> {
        let (first, last) = (guide.points().first()?, guide.points().last()?);
        let strip = Strip::along(guide, self.narrow)?;
        let frame = *self.narrow.frame();
        let yaws =
            AHEAD.map(|(dx, dy)| libm::atan2(f64::from(dy), f64::from(dx)) + frame.origin.yaw);
        let goal = strip.place_of(frame.cell_of(last)?)?;
        let start = strip.place_of(frame.cell_of(first)?)?;
        let mut states = States::new(strip.cells.len() * HEADINGS);
        let center = |place: usize| frame.center_of(strip.cells[place]);
        for (heading, &yaw) in yaws.iter().enumerate() {
            if self.fits_at(&center(start), yaw) {
                states.reach(start * HEADINGS + heading, 0, strip.left[start], None);
            }
        }
        let turn = (TURN_M / frame.resolution_m * STRAIGHT as f64) as u64;
        while let Some((state, cost)) = states.next() {
            let (place, heading) = (state / HEADINGS, state % HEADINGS);
            if place == goal {
                let mut places: Vec<usize> =
                    states.turns_before(state).map(|state| state / HEADINGS).collect();
                places.dedup();
                let corners = places.into_iter().rev().map(center);
                let points: Vec<Point> = once(*first).chain(corners).chain(once(*last)).collect();
                return Some(Path::new(self.shortened(&points)));
            }
            let (from, yaw) = (center(place), yaws[heading]);
            let price = |place: usize, cost| costs.price(frame.index(strip.cells[place]), cost);
            for next in [(heading + 1) % HEADINGS, (heading + HEADINGS - 1) % HEADINGS] {
                let next_state = place * HEADINGS + next;
                let cost = cost + price(place, turn);
                if states.is_better(next_state, cost) && self.fits_turning(&from, yaw, yaws[next]) {
                    states.reach(next_state, cost, strip.left[place], Some(state));
                }
            }
            let (dx, dy) = AHEAD[heading];
            let Cell { column, row } = strip.cells[place];
            let Some(next) = strip.place_of(Cell::new(column + dx, row + dy)) else {
                continue;
            };
            let length = f64::from(dx * dx + dy * dy).sqrt() * STRAIGHT as f64;
            let (next_state, cost) = (next * HEADINGS + heading, cost + price(next, length as u64));
            if states.is_better(next_state, cost) && self.fits_ahead(&from, &center(next), yaw) {
                states.reach(next_state, cost, strip.left[next], Some(state));
            }
        }
        None
    }

    /// Leaves out points between which the body fits on the straight way.
    fn shortened(&self, points: &[Point]) -> Vec<Point> {
        let mut kept: Vec<Point> = points.first().into_iter().copied().collect();
        let mut at = 0;
        while at + 1 < points.len() {
            let before = kept.len().saturating_sub(2);
            let fits = |&to: &usize| {
                let mut tried = kept[before..].to_vec();
                tried.extend_from_slice(&points[to..points.len().min(to + 2)]);
                self.fits_along(&tried)
            };
            at = (at + 1..points.len()).rev().find(fits).unwrap_or(at + 1);
            kept.push(points[at]);
        }
        kept
    }
}

/// The free cells next to a path.
struct Strip {
    frame: GridFrame,
    cells: Vec<Cell>,
    /// Lower bound of the cost from each of them to the end of the path.
    left: Vec<u64>,
    /// Place of each cell of the grid among these, plus one; zero for the others.
    places: Vec<u32>,
}

impl Strip {
    /// `None` where there are too many cells.
    fn along(guide: &Path, space: &FreeSpace) -> Option<Self> {
        let frame = *space.frame();
        let mut strip =
            Self { frame, cells: Vec::new(), left: Vec::new(), places: vec![0; frame.len()] };
        let steps = (guide.length_m() / frame.resolution_m).ceil().max(1.0) as u32;
        // From the end on, so that each cell gets the least of the lengths that are left next to it.
        for step in 0..=steps {
            let left_m = guide.length_m() * f64::from(step) / f64::from(steps);
            let at = guide.point_at(guide.length_m() - left_m);
            let left = ((left_m - REACH_M) / frame.resolution_m).max(0.0) * STRAIGHT as f64;
            let near = frame.cells_within(&at, REACH_M).filter(|&cell| space.is_free(cell));
            near.for_each(|cell| strip.add(cell, left as u64));
            if strip.cells.len() > MAX_CELLS {
                return None;
            }
        }
        Some(strip)
    }

    fn add(&mut self, cell: Cell, left: u64) {
        let place = &mut self.places[self.frame.index(cell)];
        if *place == 0 {
            self.cells.push(cell);
            self.left.push(left);
            *place = self.cells.len() as u32;
        }
    }

    fn place_of(&self, cell: Cell) -> Option<usize> {
        if !self.frame.contains(cell) {
            return None;
        }
        (self.places[self.frame.index(cell)] as usize).checked_sub(1)
    }
}

/// Costs and predecessors of the states of the search.
struct States {
    costs: Vec<u64>,
    /// The state before each one, plus one; zero for the first.
    before: Vec<u32>,
    open: BinaryHeap<Reverse<(u64, u64, u32)>>,
}

impl States {
    fn new(count: usize) -> Self {
        Self { costs: vec![u64::MAX; count], before: vec![0; count], open: BinaryHeap::new() }
    }

    fn is_better(&self, state: usize, cost: u64) -> bool {
        cost < self.costs[state]
    }

    fn reach(&mut self, state: usize, cost: u64, left: u64, before: Option<usize>) {
        self.costs[state] = cost;
        self.before[state] = before.map_or(0, |before| before as u32 + 1);
        self.open.push(Reverse((cost + left, cost, state as u32)));
    }

    /// The open state with the least estimate, and its cost.
    fn next(&mut self) -> Option<(usize, u64)> {
        while let Some(Reverse((_, cost, state))) = self.open.pop() {
            if self.costs[state as usize] == cost {
                return Some((state as usize, cost));
            }
        }
        None
    }

    fn before(&self, state: usize) -> Option<usize> {
        (self.before[state] as usize).checked_sub(1)
    }

    /// The states before one, from it on backwards, to which a turn leads.
    fn turns_before(&self, state: usize) -> impl Iterator<Item = usize> + '_ {
        let turns_to = |state: &usize| {
            self.before(*state).is_some_and(|before| before / HEADINGS == state / HEADINGS)
        };
        successors(Some(state), |&state| self.before(state)).filter(turns_to)
    }
}
