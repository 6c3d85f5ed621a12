//! Smoothing by a uniform B-spline (paper, section 3.2.3, eqs. 24-26) that is proved clear of walls.
//!
//! On the pruned vertices alone the printed recipe cuts every corner that the pruning hugs, and hits its wall. Here each
//! vertex gets control points on both its edges; where the curve leaves the free cells, those of the vertex nearby move
//! towards it until the curve fits, and at last the vertex is kept sharp.

use super::line_of_sight::is_clear;
use super::path::Path;
use crate::geometry::Point;
use crate::map::FreeSpace;

/// Control points start this far from their vertex, metres, where the edges are long enough.
const WIDEST_M: f64 = 2.0;
/// A corner rounded by less than this share of a cell is kept sharp.
const SHARP_CELLS: f64 = 0.25;
/// A point this near to an edge is on it, metres: rounding, and less than the distance kept from walls is promised to.
const ON_EDGE_M: f64 = 1e-10;
/// Chords of the emitted polyline are about this long, metres: at the tightest turn of a robot's width it then departs
/// from the curve by less than 5 mm.
const CHORD_M: f64 = 0.1;

/// The curve of a degree over a path that is clear in `space`: same ends exactly, and every chord clear in `space` or part
/// of an edge of the path. Never longer than the path, up to rounding: the control points lie on it in its order. A
/// degree below two, or a path without inner points, leaves the path as it is.
#[must_use]
pub fn smooth(space: &FreeSpace, path: &Path, degree: usize) -> Path {
    let vertices = path.points();
    if vertices.len() < 3 || degree < 2 {
        return path.clone();
    }
    let last = vertices.len() - 1;
    let sharp_m = SHARP_CELLS * space.frame().resolution_m;
    let mut rounding_m = vec![WIDEST_M; vertices.len()];
    (rounding_m[0], rounding_m[last]) = (0.0, 0.0);
    loop {
        let control = control_points(vertices, &rounding_m, degree);
        let curve = sample(&control, degree);
        let mut shrunk = false;
        for chord in curve.windows(2) {
            // The chord belongs to the vertex whose control points weigh most, or to a neighbour of it.
            let vertex = chord[1].vertex;
            if is_clear(space, &chord[0].place, &chord[1].place)
                || is_part_of_an_edge(chord, &vertices[vertex.saturating_sub(1)..])
            {
                continue;
            }
            let nearby = vertex.saturating_sub(1)..=(vertex + 1).min(last);
            for (near, rounding_m) in nearby.clone().zip(&mut rounding_m[nearby]) {
                if *rounding_m > 0.0 {
                    *rounding_m *= if near == vertex { 0.7 } else { 0.9 };
                    shrunk = true;
                }
                if *rounding_m < sharp_m {
                    *rounding_m = 0.0;
                }
            }
        }
        // Where nothing could shrink, the vertices all around are sharp, and the chord is part of an edge but for rounding.
        if !shrunk {
            return Path::new(curve.into_iter().map(|sample| sample.place).collect());
        }
    }
}

/// Whether a chord lies on one of the first two edges of a path: clear by what the caller owes, even at the path's ends,
/// which may touch cells that are not free.
fn is_part_of_an_edge(chord: &[Control], vertices: &[Point]) -> bool {
    vertices.windows(2).take(2).any(|edge| {
        let edge = Path::new(edge.to_vec());
        chord
            .iter()
            .all(|sample| edge.project(&sample.place).distance_m <= ON_EDGE_M)
    })
}

/// A control point and the vertex it belongs to.
#[derive(Clone, Copy)]
struct Control {
    place: Point,
    vertex: usize,
}

/// Ends and sharp vertices, whose rounding is zero, are repeated as often as the degree, which makes the curve pass through
/// them; a rounded vertex has a control point on each of its edges.
fn control_points(vertices: &[Point], rounding_m: &[f64], degree: usize) -> Vec<Control> {
    let mut control = Vec::new();
    for (vertex, &place) in vertices.iter().enumerate() {
        let here = Control { place, vertex };
        if rounding_m[vertex] == 0.0 {
            control.extend(core::iter::repeat_n(here, degree));
            continue;
        }
        let towards = |neighbour: Point| {
            let edge = neighbour - place;
            // Half an edge at most: the other half is the neighbour's.
            let share = (rounding_m[vertex] / edge.norm()).min(0.5);
            Control {
                place: place + edge * share,
                vertex,
            }
        };
        control.extend([
            towards(vertices[vertex - 1]),
            here,
            towards(vertices[vertex + 1]),
        ]);
    }
    control
}

/// The curve as points, each with the vertex whose control point weighs most there.
fn sample(control: &[Control], degree: usize) -> Vec<Control> {
    let mut samples = vec![control[0]];
    let mut weights = vec![0.0; degree + 1];
    for segment in control.windows(degree + 1) {
        let spread: f64 = segment
            .windows(2)
            .map(|pair| (pair[1].place - pair[0].place).norm())
            .sum();
        let pieces = (spread / degree as f64 / CHORD_M).ceil().max(1.0) as usize;
        for piece in 1..=pieces {
            let u = piece as f64 / pieces as f64;
            for (k, weight) in weights.iter_mut().enumerate() {
                *weight = basis(k, degree, u);
            }
            // Relative to one of them, so that rounding in the weights is not multiplied by the map's coordinates.
            let first = segment[0].place;
            let place = segment
                .iter()
                .zip(&weights)
                .fold(first, |sum, (control, weight)| {
                    sum + (control.place - first) * *weight
                });
            let heaviest = segment
                .iter()
                .zip(&weights)
                .max_by(|one, other| one.1.total_cmp(other.1))
                .map_or(0, |(control, _)| control.vertex);
            samples.push(Control {
                place,
                vertex: heaviest,
            });
        }
    }
    // Rounding may leave the last sample a hair off the end that the repeated control points stand for.
    if let (Some(sample), Some(end)) = (samples.last_mut(), control.last()) {
        *sample = *end;
    }
    samples
}

/// Eq. 24: weight of control point `k` of a segment of degree `n` at `u` in 0..=1.
fn basis(k: usize, n: usize, u: f64) -> f64 {
    let mut sum = 0.0;
    for j in 0..=n - k {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        let base = u + (n - k - j) as f64;
        sum += sign * binomial(n + 1, j) * base.powi(n as i32);
    }
    sum / (1..=n).map(|factor| factor as f64).product::<f64>()
}

/// Eq. 25.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{Cell, GridFrame, ObstacleGrid};

    #[test]
    fn the_cubic_basis_is_the_textbook_one() {
        let at_start: Vec<f64> = (0..4).map(|k| basis(k, 3, 0.0)).collect();
        for (found, expected) in at_start.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        for degree in 1..=9 {
            let sum: f64 = (0..=degree).map(|k| basis(k, degree, 0.37)).sum();
            assert!((sum - 1.0).abs() < 1e-9, "degree {degree}");
        }
    }

    #[test]
    fn an_end_that_touches_a_blocked_cell_does_not_make_the_rest_sharp() {
        let frame = GridFrame {
            width: 80,
            height: 80,
            resolution_m: 0.1,
            origin: Pose::default(),
        };
        let mut obstacles = ObstacleGrid::new(frame, vec![false; frame.len()]);
        let open = FreeSpace::new(&obstacles, 0.0);
        obstacles.set(Cell::new(9, 10), true);
        let space = FreeSpace::new(&obstacles, 0.0);
        // The start lies on the border of the blocked cell, so no line of sight but those within its own cell is clear.
        let corner = [(1.0, 1.05), (4.0, 1.05), (4.0, 6.0)].map(|(x, y)| Point::new(x, y));
        let path = Path::new(corner.to_vec());
        assert_eq!(smooth(&space, &path, 3), smooth(&open, &path, 3));
    }
}
