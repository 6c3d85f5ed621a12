//! The legs of a found path: open ones, which are planned again, and straight narrow ones.

use super::lattice::{Arrival, State};
use super::stencil::{MAX_TURN_RAD, Stencil};
use super::{HeadingSearcher, Place};
use crate::geometry::{Point, bearing, wrap_angle};
use crate::global::Travel;
use crate::map::{BitGrid, Cell, FreeSpace};
use core::f64::consts::PI;

/// Distance by which an end on the edge of its cell is moved into the cell, cells.
const INTO_CELL: f64 = 1e-6;

/// A part of a path, from the end of the part before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leg {
    /// Through open cells.
    Open {
        /// Its end, metres in the map frame.
        to: Point,
    },
    /// Straight.
    Narrow {
        /// Its end, metres in the map frame.
        to: Point,
        /// Direction of travel.
        travel: Travel,
    },
}

/// A path from a point on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Legs {
    /// Its begin, metres in the map frame.
    pub start: Point,
    pub legs: Vec<Leg>,
}

/// A straight narrow leg, in cells.
#[derive(Clone, Copy, Debug)]
struct Straight {
    from: Point,
    to: Point,
    travel: Travel,
}

impl Straight {
    /// The heading of the robot in the grid, radians.
    fn heading(&self) -> f64 {
        let along = bearing(&self.from, &self.to);
        match self.travel {
            Travel::Forward => along,
            Travel::Backward => wrap_angle(along + PI),
        }
    }
}

/// A part of a path, in cells.
#[derive(Clone, Debug)]
enum Piece {
    Open(Point),
    /// Straight lines, each from the end of the one before.
    Narrow(Vec<Straight>),
}

impl HeadingSearcher {
    /// The legs of a path of states, with as few narrow ones as keep the margin.
    pub(super) fn legs(
        &self,
        free: &BitGrid,
        open: &FreeSpace,
        query: &super::Query,
        path: &[(State, Arrival)],
    ) -> Legs {
        let frame = open.frame();
        let (mut pieces, start) = pieces(path, frame.to_cell_units(&query.start));
        let last = frame.to_cell_units(&query.goal);
        match pieces.last_mut() {
            Some(Piece::Open(to)) => *to = last,
            _ => pieces.push(Piece::Open(last)),
        }
        let out = |point: &Point| frame.from_cell_units(point);
        let mut legs = Vec::new();
        for piece in pieces {
            match piece {
                Piece::Open(to) => legs.push(Leg::Open { to: out(&to) }),
                Piece::Narrow(lines) => {
                    let lines = self.straightened(free, open, &lines);
                    let leg =
                        |line: &Straight| Leg::Narrow { to: out(&line.to), travel: line.travel };
                    legs.extend(lines.iter().map(leg));
                }
            }
        }
        Legs { start: out(&start), legs }
    }

    /// Replaces successive lines by one where it keeps the margin, and the turns at its ends do.
    fn straightened(&self, free: &BitGrid, open: &FreeSpace, lines: &[Straight]) -> Vec<Straight> {
        let mut result: Vec<Straight> = Vec::new();
        let mut first = 0;
        while first < lines.len() {
            let before = result.last().copied();
            let joined = |last: usize| Straight { to: lines[last].to, ..lines[first] };
            let is_free = |&last: &usize| {
                let line = joined(last);
                let before = before.map_or(lines[first].heading(), |line| line.heading());
                let after = lines.get(last + 1).map(Straight::heading);
                let can_leave =
                    |after: f64| self.can_turn_freely(free, open, line.to, [line.heading(), after]);
                lines[first..=last].iter().all(|one| one.travel == line.travel)
                    && self.can_drive_freely(free, &line)
                    && self.can_turn_freely(free, open, line.from, [before, line.heading()])
                    && after.is_none_or(can_leave)
            };
            let last = (first + 1..lines.len()).rev().find(is_free).unwrap_or(first);
            result.push(joined(last));
            first = last + 1;
        }
        result
    }

    /// Whether a straight line keeps the margin.
    fn can_drive_freely(&self, free: &BitGrid, line: &Straight) -> bool {
        let shape = self.body.moved(line.from, line.heading(), line.to - line.from);
        Stencil::new(&shape, self.margin).is_clear(free, Cell::new(0, 0))
    }

    /// Whether the shorter turn between two headings keeps the margin at a point.
    fn can_turn_freely(
        &self,
        free: &BitGrid,
        open: &FreeSpace,
        at: Point,
        [from, to]: [f64; 2],
    ) -> bool {
        let is_open = open.frame().cell_at_units(&at).is_some_and(|cell| open.is_free(cell));
        let turn = wrap_angle(to - from);
        if is_open || turn == 0.0 {
            return true;
        }
        let steps = (turn.abs() / MAX_TURN_RAD).ceil();
        (0..steps as u32).all(|step| {
            let shape = self.body.turned(at, from + turn * f64::from(step) / steps, turn / steps);
            Stencil::new(&shape, self.margin).is_clear(free, Cell::new(0, 0))
        })
    }
}

/// The pieces of a path of states, and its first point, in cells.
fn pieces(path: &[(State, Arrival)], exact_start: Point) -> (Vec<Piece>, Point) {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut start = exact_start;
    let mut is_same_line = false;
    for &(state, arrival) in path {
        let (State::Open(place) | State::Heading(place, _)) = state;
        match arrival {
            Arrival::Start => {
                if matches!(state, State::Heading(..)) {
                    start = anchored(place);
                }
            }
            Arrival::Open => {
                if let Some(Piece::Open(to)) = pieces.last_mut() {
                    *to = anchored(place);
                } else {
                    pieces.push(Piece::Open(anchored(place)));
                }
            }
            Arrival::Turn => is_same_line = false,
            Arrival::Straight(via, travel) => {
                let (from, to) = (anchored(via), anchored(place));
                if let Some(Piece::Narrow(lines)) = pieces.last_mut() {
                    match lines.last_mut() {
                        Some(last) if is_same_line && last.travel == travel => last.to = to,
                        _ => lines.push(Straight { from, to, travel }),
                    }
                } else {
                    match pieces.last_mut() {
                        Some(Piece::Open(end)) => *end = from,
                        // The path begins with an open cell.
                        _ if from != start => pieces.push(Piece::Open(from)),
                        _ => {}
                    }
                    pieces.push(Piece::Narrow(vec![Straight { from, to, travel }]));
                }
                is_same_line = true;
            }
        }
    }
    (pieces, start)
}

/// A lattice point in cells, within its cell.
fn anchored(place: Place) -> Point {
    let point = place.point();
    let into = |at: f64| if at.fract() == 0.0 { at + INTO_CELL } else { at };
    Point::new(into(point.x), into(point.y))
}
