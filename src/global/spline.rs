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
/// Chords of the emitted polyline are about this long, metres: at the tightest turn of a robot's width it then departs
/// from the curve by less than 5 mm.
const CHORD_M: f64 = 0.1;

/// The curve of a degree, at least one, over a clear path: same ends, every chord clear in `space`.
#[must_use]
pub fn smooth(space: &FreeSpace, path: &Path, degree: usize) -> Path {
    let vertices = path.points();
    if vertices.len() < 3 || degree < 2 {
        return path.clone();
    }
    let sharp_m = SHARP_CELLS * space.frame().resolution_m;
    let mut rounding_m = vec![WIDEST_M; vertices.len()];
    loop {
        let control = control_points(vertices, &rounding_m, degree, sharp_m);
        let curve = sample(&control, degree);
        let blocked: Vec<usize> = curve
            .windows(2)
            .filter(|chord| !is_clear(space, &chord[0].place, &chord[1].place))
            .map(|chord| chord[0].vertex)
            .collect();
        if blocked.is_empty() {
            return Path::new(curve.into_iter().map(|sample| sample.place).collect());
        }
        let mut shrunk = false;
        for vertex in blocked {
            // A chord belongs to the vertex whose control points weigh most, or to a neighbour of it.
            for near in vertex.saturating_sub(1)..=(vertex + 1).min(vertices.len() - 1) {
                if rounding_m[near] > 0.0 {
                    rounding_m[near] *= if near == vertex { 0.7 } else { 0.9 };
                    shrunk = true;
                }
                if rounding_m[near] < sharp_m {
                    rounding_m[near] = 0.0;
                }
            }
        }
        if !shrunk {
            return path.clone();
        }
    }
}

/// A control point and the vertex it belongs to.
#[derive(Clone, Copy)]
struct Control {
    place: Point,
    vertex: usize,
}

/// Both ends and sharp vertices are repeated as often as the degree, which makes the curve pass through them; a
/// rounded vertex has a control point on each of its edges.
fn control_points(
    vertices: &[Point],
    rounding_m: &[f64],
    degree: usize,
    sharp_m: f64,
) -> Vec<Control> {
    let last = vertices.len() - 1;
    let mut control = Vec::new();
    for (vertex, &place) in vertices.iter().enumerate() {
        let here = Control { place, vertex };
        let is_end = vertex == 0 || vertex == last;
        if is_end || rounding_m[vertex] < sharp_m {
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
            let place = segment
                .iter()
                .zip(&weights)
                .fold(Point::origin(), |sum, (control, weight)| {
                    sum + control.place.coords * *weight
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

    #[test]
    fn the_cubic_basis_is_the_textbook_one() {
        let at_start: Vec<f64> = (0..4).map(|k| basis(k, 3, 0.0)).collect();
        for (found, expected) in at_start.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        for degree in 1..=6 {
            let sum: f64 = (0..=degree).map(|k| basis(k, degree, 0.37)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "degree {degree}");
        }
    }
}
