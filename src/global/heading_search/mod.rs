//! Search for a path that knows the heading where there is no room for every heading.
//!
//! A cell is open if the circle around the body keeps the margin from it: every heading is free there, and a state is the cell
//! alone. Elsewhere a state is a lattice point with one of 32 headings. A straight move sweeps the convex hull of the body at
//! its ends, a turn to the next heading a shape that contains every pose between. A move is free if its shape keeps the margin
//! from the square of every obstacle cell. The cells to check are the same for each lattice point within a cell, and are
//! computed once. So a path is exact for its own headings and positions, between them too.

mod cost;
mod distances;
mod headings;
mod lattice;
mod legs;
mod stencil;

use cost::{length_cost, metres_cost, turn_cost};
use distances::Distances;
use headings::{COUNT, Heading, PARTS, headings};
use lattice::{Ground, Lattice, State};
use stencil::{Body, Stencil};

pub(crate) use legs::{Leg, Legs};

use crate::geometry::{Point, Vector, wrap_angle};
use crate::map::{BitGrid, Cell, FreeSpace, GridFrame, ObstacleGrid};
use crate::robot::Polygon;

/// A robot that stands within this many lattice points of a lattice point may begin there.
const START_POINTS: i32 = 2;
/// A robot may begin with a heading within this of its own, radians.
const START_TURN_RAD: f64 = 0.25;

/// A lattice point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Place {
    x: i32,
    y: i32,
}

impl Place {
    const fn center(cell: Cell) -> Self {
        Self { x: PARTS * cell.column + 1, y: PARTS * cell.row + 1 }
    }

    const fn cell(self) -> Cell {
        Cell::new(self.x.div_euclid(PARTS), self.y.div_euclid(PARTS))
    }

    const fn moved(self, dx: i32, dy: i32) -> Self {
        Self { x: self.x + dx, y: self.y + dy }
    }

    fn distance(self, other: Self) -> f64 {
        libm::hypot(f64::from(self.x - other.x), f64::from(self.y - other.y))
    }

    /// Its number among the lattice points of a cell.
    const fn part(self) -> usize {
        (self.x.rem_euclid(PARTS) + PARTS * self.y.rem_euclid(PARTS)) as usize
    }

    /// In cells.
    fn point(self) -> Point {
        let part = f64::from(PARTS);
        Point::new(f64::from(self.x) / part, f64::from(self.y) / part)
    }

    /// In cells, relative to the corner of its cell.
    fn offset(self) -> Point {
        let part = |at: i32| f64::from(at.rem_euclid(PARTS)) / f64::from(PARTS);
        Point::new(part(self.x), part(self.y))
    }
}

/// Lattice points in a cell.
const PARTS_OF_CELL: usize = (PARTS * PARTS) as usize;

/// What to search for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Query {
    /// Where the robot stands, metres in the map frame.
    pub start: Point,
    /// Its yaw, radians; `None` where it may have any.
    pub start_yaw: Option<f64>,
    /// Where it drives, metres in the map frame.
    pub goal: Point,
    /// Greatest length of a path in the open, metres. Narrow stretches count as longer.
    pub most_m: f64,
}

/// Searches paths for one body on maps of one resolution. It keeps the cells that each move sweeps.
#[derive(Clone, Debug)]
pub(crate) struct HeadingSearcher {
    body: Body,
    headings: [Heading; COUNT],
    /// Margin, cells.
    margin: f64,
    /// Radius of the largest circle around the origin within the body, plus the margin, metres.
    pub inscribed_radius_m: f64,
    /// Whether the robot drives backwards.
    pub may_reverse: bool,
    drives: Vec<Option<Stencil>>,
    turns: Vec<Option<Stencil>>,
}

impl HeadingSearcher {
    /// A searcher for the convex hull of a body, with a margin in metres, on maps of this resolution in metres.
    pub fn new(body: &Polygon, margin_m: f64, resolution_m: f64) -> Self {
        let hull = Polygon::convex_hull(body.corners().to_vec());
        // A body that does not contain its origin has no inscribed circle.
        let inscribed_m = (-hull.signed_distance(&Point::default())).max(0.0);
        Self {
            body: Body::new(body, resolution_m),
            headings: headings(),
            margin: margin_m / resolution_m,
            inscribed_radius_m: inscribed_m + margin_m,
            may_reverse: false,
            drives: vec![None; COUNT * PARTS_OF_CELL],
            turns: vec![None; COUNT * PARTS_OF_CELL],
        }
    }

    /// The cells in which the robot can be with some heading, and some more.
    pub fn passable(&self, obstacles: &ObstacleGrid) -> FreeSpace {
        // A cell counts as free by its farthest point, and a lattice point may be anywhere on it.
        let diagonal_m = core::f64::consts::SQRT_2 * obstacles.frame().resolution_m;
        FreeSpace::new(obstacles, self.inscribed_radius_m - diagonal_m)
    }

    /// Finds a path. `open` are the cells with room for every heading, a subset of `passable`; the goal lies in one of them. Also
    /// returns the number of expanded states.
    pub fn find(
        &mut self,
        obstacles: &ObstacleGrid,
        [open, passable]: [&FreeSpace; 2],
        query: &Query,
    ) -> (Option<Legs>, u32) {
        let frame = *obstacles.frame();
        let (Some(start), Some(goal)) = (frame.cell_of(&query.start), frame.cell_of(&query.goal))
        else {
            return (None, 0);
        };
        if !open.is_free(goal) || !passable.is_free(start) {
            return (None, 0);
        }
        let spacing_m = frame.resolution_m / f64::from(PARTS);
        let most = metres_cost(query.most_m, spacing_m);
        let Some(distances) = Distances::new(passable, open, [start, goal], most) else {
            return (None, 0);
        };
        let free = free_cells(obstacles);
        let starts = if open.is_free(start) {
            vec![(State::Open(Place::center(start)), 0)]
        } else {
            self.starts(&free, &frame, query)
        };
        let ground = Ground { free: &free, open, distances: &distances, goal, most, spacing_m };
        let mut lattice = Lattice::new(self, ground);
        for (state, cost) in starts {
            lattice.add_start(state, cost);
        }
        let (path, expanded) = lattice.path();
        let legs = path.map(|path| self.legs(&free, open, query, &path));
        (legs, expanded)
    }

    /// The states near the pose of a robot without room for every heading, with their costs.
    fn starts(&mut self, free: &BitGrid, frame: &GridFrame, query: &Query) -> Vec<(State, u64)> {
        let at = frame.to_cell_units(&query.start);
        let nearest = |at: f64| (at * f64::from(PARTS)).round() as i32;
        let nearest = Place { x: nearest(at.x), y: nearest(at.y) };
        let spacing_m = frame.resolution_m / f64::from(PARTS);
        let mut starts = Vec::new();
        let around = -START_POINTS..=START_POINTS;
        for (dx, dy) in around.clone().flat_map(|dy| around.clone().map(move |dx| (dx, dy))) {
            let place = nearest.moved(dx, dy);
            let aside = (place.point() - at).norm() * f64::from(PARTS);
            for heading in 0..COUNT {
                let angle = self.headings[heading].angle;
                let turn = query
                    .start_yaw
                    .map_or(0.0, |yaw| wrap_angle(yaw - frame.origin.yaw - angle).abs());
                let shape = self.body.moved(place.offset(), angle, Vector::ZERO);
                if turn <= START_TURN_RAD
                    && frame.contains(place.cell())
                    && Stencil::new(&shape, self.margin).is_clear(free, place.cell())
                {
                    let cost = length_cost(aside) + turn_cost(turn, spacing_m);
                    starts.push((State::Heading(place, heading as u8), cost));
                }
            }
        }
        starts
    }

    /// Angle from a heading to another, radians in (-pi, pi].
    fn turn(&self, from: usize, to: usize) -> f64 {
        wrap_angle(self.headings[to].angle - self.headings[from].angle)
    }

    /// Whether the straight move of a heading from a place is free.
    fn can_drive(&mut self, free: &BitGrid, from: Place, heading: usize) -> bool {
        let Self { body, headings, margin, drives, .. } = self;
        let stencil = drives[heading * PARTS_OF_CELL + from.part()].get_or_insert_with(|| {
            let Heading { step: (x, y), angle, .. } = headings[heading];
            let by = Vector::new(f64::from(x), f64::from(y)) / f64::from(PARTS);
            Stencil::new(&body.moved(from.offset(), angle, by), *margin)
        });
        stencil.is_clear(free, from.cell())
    }

    /// Whether the turn between neighbouring headings is free at a place.
    fn can_turn(&mut self, free: &BitGrid, place: Place, one: usize, other: usize) -> bool {
        // The turn to the next heading counter-clockwise sweeps the same cells as the turn back.
        let from = if (one + 1) % COUNT == other { one } else { other };
        let turn = self.turn(from, (from + 1) % COUNT);
        let Self { body, headings, margin, turns, .. } = self;
        let stencil = turns[from * PARTS_OF_CELL + place.part()].get_or_insert_with(|| {
            Stencil::new(&body.turned(place.offset(), headings[from].angle, turn), *margin)
        });
        stencil.is_clear(free, place.cell())
    }
}

/// The cells without an obstacle.
fn free_cells(obstacles: &ObstacleGrid) -> BitGrid {
    let GridFrame { width, height, .. } = *obstacles.frame();
    let free: Vec<bool> = obstacles.cells().iter().map(|&blocked| !blocked).collect();
    BitGrid::from_cells(width, height, &free)
}
