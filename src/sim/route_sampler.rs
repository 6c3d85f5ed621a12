//! Samples routes over free cells.

use core::ops::RangeInclusive;
use std::collections::VecDeque;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::geometry::{Point, Vector};
use crate::map::GridRay;
use crate::map::{Cell, FreeSpace};

/// The four neighbours of a cell.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Smallest distance to the next random waypoint, metres: shorter routes would look like jitter.
const MIN_ROAM_M: f64 = 1.0;

/// The cell is not reached.
const UNREACHED: u8 = u8::MAX;

/// Ends of the straight free line through a point along a bearing, radians, at most `reach_m` in both directions.
pub(super) fn straight_route(
    free: &FreeSpace,
    spot: &Point,
    bearing_rad: f64,
    reach_m: f64,
) -> [Point; 2] {
    let frame = free.frame();
    let (sin, cos) = libm::sincos(bearing_rad - frame.origin.yaw);
    let start = frame.to_cell_units(spot);
    [-1.0, 1.0].map(|sign| {
        let direction = Vector::new(cos, sin) * sign;
        let reach = free_length(free, &start, &direction, reach_m / frame.resolution_m);
        frame.from_cell_units(&(start + direction * reach))
    })
}

/// Draws a route from a free point to a cell whose straight distance and route length are in the range, metres; none
/// without such a cell. Its legs are straight over free cells.
pub(super) fn winding_route(
    free: &FreeSpace,
    spot: &Point,
    length_m: &RangeInclusive<f64>,
    rng: &mut Pcg64Mcg,
) -> Option<Vec<Point>> {
    let frame = free.frame();
    let start = frame.cell_of(spot)?;
    let max_steps = (length_m.end() / frame.resolution_m) as u32;
    let reached = FloodFill::from(free, start, max_steps, |_| true);
    let end = reached.draw_beyond(length_m.start() / frame.resolution_m, rng)?;
    Some(reached.route_to(end))
}

/// Draws a route from a free point to a cell that is reachable within a disc around home, radius in metres. The cell is
/// at least [`MIN_ROAM_M`] away if there is such a cell. None if no cell is reachable. The legs of the route are
/// straight over free cells.
pub(super) fn roaming_route(
    free: &FreeSpace,
    place: &Point,
    home: &Point,
    reach_m: f64,
    rng: &mut Pcg64Mcg,
) -> Option<Vec<Point>> {
    let frame = free.frame();
    let start = frame.cell_of(place).filter(|&start| free.is_free(start))?;
    // A disc is convex, so the straight legs stay inside.
    let inside = |cell| (frame.center_of(cell) - home).norm() <= reach_m;
    let reached = FloodFill::from(free, start, u32::MAX, inside);
    let end = reached
        .draw_beyond(MIN_ROAM_M / frame.resolution_m, rng)
        .or_else(|| reached.draw_beyond(1.0, rng))?;
    let mut walk = vec![*place];
    walk.extend(reached.route_to(end));
    Some(walk)
}

/// Breadth-first search from a cell over free neighbours.
struct FloodFill<'a> {
    free: &'a FreeSpace,
    /// The step that reached each cell.
    step: Vec<u8>,
    /// Cells in the order in which they were reached, the start first.
    order: Vec<Cell>,
}

impl<'a> FloodFill<'a> {
    fn from(
        free: &'a FreeSpace,
        start: Cell,
        max_steps: u32,
        may_enter: impl Fn(Cell) -> bool,
    ) -> Self {
        let frame = free.frame();
        let mut reached = Self { free, step: vec![UNREACHED; frame.len()], order: vec![start] };
        // The entry of the start only marks it as reached.
        reached.step[frame.index(start)] = 0;
        let mut queue = VecDeque::from([(start, 0)]);
        while let Some((cell, steps)) = queue.pop_front() {
            if steps == max_steps {
                continue;
            }
            for (number, (dx, dy)) in STEPS.iter().enumerate() {
                let next = Cell::new(cell.column + dx, cell.row + dy);
                if free.is_free(next)
                    && reached.step[frame.index(next)] == UNREACHED
                    && may_enter(next)
                {
                    reached.step[frame.index(next)] = number as u8;
                    reached.order.push(next);
                    queue.push_back((next, steps + 1));
                }
            }
        }
        reached
    }

    /// Draws a cell whose straight distance from the start is at least this many cells.
    fn draw_beyond(&self, min_cells: f64, rng: &mut Pcg64Mcg) -> Option<Cell> {
        let start = self.order[0];
        let far: Vec<Cell> = self
            .order
            .iter()
            .copied()
            .filter(|cell| {
                let (dx, dy) = (cell.column - start.column, cell.row - start.row);
                libm::hypot(f64::from(dx), f64::from(dy)) >= min_cells
            })
            .collect();
        (!far.is_empty()).then(|| far[rng.random_range(0..far.len())])
    }

    /// The corners of the route from the start to a reached cell.
    fn route_to(&self, end: Cell) -> Vec<Point> {
        let frame = self.free.frame();
        prune_corners(self.free, &self.cells_to(end))
            .into_iter()
            .map(|cell| frame.center_of(cell))
            .collect()
    }

    /// The cells from the start to a reached cell, both included.
    fn cells_to(&self, end: Cell) -> Vec<Cell> {
        let mut route = vec![end];
        let mut cell = end;
        while cell != self.order[0] {
            let (dx, dy) = STEPS[self.step[self.free.frame().index(cell)] as usize];
            cell = Cell::new(cell.column - dx, cell.row - dy);
            route.push(cell);
        }
        route.reverse();
        route
    }
}

/// Greedy line-of-sight pruning: each leg extends until the first cell that is not reachable in a straight free line.
fn prune_corners(free: &FreeSpace, cells: &[Cell]) -> Vec<Cell> {
    let mut corners = vec![cells[0]];
    let mut from = 0;
    for next in 1..cells.len() {
        if !is_straight_free(free, cells[from], cells[next]) {
            from = next - 1;
            corners.push(cells[from]);
        }
    }
    corners.push(cells[cells.len() - 1]);
    corners
}

/// Whether a straight line between two points, the first one free, passes only free cells.
pub(crate) fn is_in_sight(free: &FreeSpace, from: &Point, to: &Point) -> bool {
    let frame = free.frame();
    let (from, to) = (frame.to_cell_units(from), frame.to_cell_units(to));
    let length = (to - from).norm();
    length == 0.0 || free_length(free, &from, &((to - from) / length), length) >= length
}

fn is_straight_free(free: &FreeSpace, from: Cell, to: Cell) -> bool {
    let leg = to.center() - from.center();
    let length = leg.norm();
    free_length(free, &from.center(), &(leg / length), length) >= length
}

/// Length of a ray over free cells, in cells, at most `max_length`. It ends slightly before a cell that is not free.
fn free_length(free: &FreeSpace, start: &Point, direction: &Vector, max_length: f64) -> f64 {
    GridRay::new(start, direction)
        .take_while(|&(_, entered)| entered <= max_length)
        .find(|&(cell, _)| !free.is_free(cell))
        .map_or(max_length, |(_, entered)| (entered - 1e-6).max(0.0))
}
