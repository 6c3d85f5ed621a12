//! Paths for a body that is longer than wide. Where its circumscribed circle does not fit, the state of the search includes the
//! heading.

use core::f64::consts::TAU;
use core::iter::once;

use super::body_moves::{BodyMoves, HEADINGS, States};
use super::body_search::BodySearch;
use super::{ClearanceCosts, Path, STRAIGHT};
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::{Cell, FreeSpace, GridFrame};

/// The search with headings stays this close to the path of the discs, metres.
const REACH_M: f64 = 1.5;
/// Most cells of that search: a path of 200 m over cells of 5 cm has as many. It takes 500 bytes for each.
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
    /// Cells among which are all those in which it keeps it at some place.
    pub partial: &'a FreeSpace,
    /// The cells in which the body may have any heading.
    pub wide: &'a FreeSpace,
}

impl BodySpace<'_> {
    fn has_any_heading(&self, place: &Point) -> bool {
        self.wide.frame().cell_of(place).is_some_and(|cell| self.wide.is_free(cell))
    }

    /// Whether the body fits at a place with a heading.
    pub(super) fn fits_at(&self, place: &Point, yaw: f64) -> bool {
        if self.has_any_heading(place) {
            return true;
        }
        let pose = Pose::new(place.x, place.y, yaw).to_frame();
        let frame = self.narrow.frame();
        self.discs.iter().all(|center| {
            let center = pose.transform(center);
            frame.cell_of(&center).is_some_and(|cell| {
                self.whole.is_free(cell)
                    || self.partial.is_free(cell) && self.partial.is_clear(&center, self.radius_m)
            })
        })
    }

    /// Whether the body fits at a place with some heading.
    #[must_use]
    pub fn fits(&self, place: &Point) -> bool {
        (0..HEADINGS).any(|heading| self.fits_at(place, heading as f64 / HEADINGS as f64 * TAU))
    }

    /// Whether the body fits on a straight way along which it heads.
    pub(super) fn fits_ahead(&self, from: &Point, to: &Point, yaw: f64) -> bool {
        let steps = ((to - from).norm() / STEP_M).ceil().max(1.0);
        let at = |step: u32| from + (to - from) * (f64::from(step) / steps);
        (0..=steps as u32).all(|step| self.fits_at(&at(step), yaw))
    }

    /// Whether the body fits while it turns on the spot.
    pub(super) fn fits_turning(&self, place: &Point, from_yaw: f64, to_yaw: f64) -> bool {
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
        if !self.fits(last) {
            return None;
        }
        let strip = Strip::along(guide, self.narrow)?;
        let moves = BodyMoves::new(self, costs);
        let frame = *self.narrow.frame();
        let goal = strip.place_of(frame.cell_of(last)?)?;
        let start = strip.place_of(frame.cell_of(first)?)?;
        let mut states = States::new(strip.cells.len() * HEADINGS);
        for heading in moves.fitting(strip.cells[start]) {
            states.reach(start * HEADINGS + heading, 0, strip.left[start], None);
        }
        while let Some((state, cost)) = states.next() {
            let (place, heading) = (state / HEADINGS, state % HEADINGS);
            if place == goal {
                let turned = |state: &usize| {
                    states
                        .before(*state)
                        .is_some_and(|before| before / HEADINGS == state / HEADINGS)
                };
                let turned = states.trace_back(state).filter(turned);
                let mut places: Vec<usize> = turned.map(|state| state / HEADINGS).collect();
                places.dedup();
                let corners = places.into_iter().rev();
                let corners = corners.map(|place| frame.center_of(strip.cells[place]));
                let points: Vec<Point> = once(*first).chain(corners).chain(once(*last)).collect();
                // To the end itself the body heads a little to the side of the centre of its cell.
                if self.fits_along(&points[points.len().saturating_sub(3)..]) {
                    return Some(Path::new(self.shortened(&points)));
                }
            }
            let cell = strip.cells[place];
            for next in BodyMoves::turns(heading) {
                let next_state = place * HEADINGS + next;
                let cost = cost + moves.turn_cost(cell);
                if states.is_better(next_state, cost) && moves.fits_turning(cell, heading, next) {
                    states.reach(next_state, cost, strip.left[place], Some(state));
                }
            }
            let next_cell = BodyMoves::ahead(cell, heading);
            let Some(next) = strip.place_of(next_cell) else {
                continue;
            };
            let next_state = next * HEADINGS + heading;
            let cost = cost + moves.ahead_cost(next_cell, heading);
            if states.is_better(next_state, cost) && moves.fits_ahead(cell, heading) {
                states.reach(next_state, cost, strip.left[next], Some(state));
            }
        }
        None
    }

    /// A path on which the body fits, wherever on the map it leads. Where there is none: the centre of the cell nearest to the goal that
    /// the body reaches; `None` where it fits nowhere at the start.
    ///
    /// # Errors
    /// When the search with headings over the whole map finds no path.
    pub fn path_anywhere(
        &self,
        [start, goal]: [Point; 2],
        costs: &ClearanceCosts,
    ) -> Result<Path, Option<Point>> {
        let guide = BodySearch::new(self, costs).path(&start, &goal)?;
        // The search does not count the turns where the body has any heading. The one near its path does.
        let near = self.path_near(&guide, costs);
        Ok(near.unwrap_or_else(|| Path::new(self.shortened(guide.points()))))
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
