//! The uniform B-spline as the paper writes it (eqs. 24-26).

use crate::geometry::{Point, Vector};

/// Chords depart from the curve by at most this, metres.
const DEPARTURE_M: f64 = 0.003;
/// The heading changes along a chord by at most this, radians: two such chords make no turn as
/// [`Path::turns`](super::Path::turns) counts.
pub(super) const CHORD_TURN_RAD: f64 = 0.04;
/// A segment is halved at most so many times.
const HALVINGS: u32 = 12;

/// Eq. 24: weight of control point `k` of a segment of degree `n` at `u` in 0..=1.
fn weight(k: usize, n: usize, u: f64) -> f64 {
    let mut sum = 0.0;
    for j in 0..=n - k {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        sum += sign * binomial(n + 1, j) * (u + (n - k - j) as f64).powi(n as i32);
    }
    sum / (1..=n).map(|factor| factor as f64).product::<f64>()
}

/// Eq. 25.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// One segment of a uniform B-spline (eq. 26): its degree is one less than its number of control points, at least two.
#[derive(Clone, Copy)]
pub(super) struct Segment<'a>(pub &'a [Point]);

impl Segment<'_> {
    /// Points of the segment, both ends included: their chords stay within 3 mm and 0.04 rad of the curve.
    pub fn chords(&self) -> Vec<Point> {
        let (first, last) = (self.sample(0.0), self.sample(1.0));
        let mut points = vec![first.place];
        self.halve(&first, &last, HALVINGS, &mut points);
        points
    }

    /// Appends the points after `from` up to `to`, as many as the chords need.
    fn halve(&self, from: &Sample, to: &Sample, halvings: u32, points: &mut Vec<Point>) {
        let chord = to.place - from.place;
        let across = Vector::new(-chord.y, chord.x) / chord.norm().max(f64::MIN_POSITIVE);
        let departure_m = self.bend(&across) * (to.u - from.u).powi(2) / 8.0;
        let (one, other) = (from.tangent, to.tangent);
        let turn_rad = libm::atan2(one.perp(&other), one.dot(&other)).abs();
        if halvings == 0 || departure_m <= DEPARTURE_M && turn_rad <= CHORD_TURN_RAD {
            points.push(to.place);
            return;
        }
        let middle = self.sample(f64::midpoint(from.u, to.u));
        self.halve(from, &middle, halvings - 1, points);
        self.halve(&middle, to, halvings - 1, points);
    }

    fn sample(&self, u: f64) -> Sample {
        Sample {
            u,
            place: self.point(u),
            tangent: self.tangent(u),
        }
    }

    fn degree(&self) -> usize {
        self.0.len() - 1
    }

    /// The point at `u` in 0..=1. Summed about the first control point, so that large coordinates cost no digits.
    pub fn point(&self, u: f64) -> Point {
        let first = self.0[0];
        let weighted =
            |(k, control): (usize, &Point)| (control - first) * weight(k, self.degree(), u);
        first + self.0.iter().enumerate().map(weighted).sum::<Vector>()
    }

    /// The derivative at `u`: the curve of one degree less over the differences of the control points.
    fn tangent(&self, u: f64) -> Vector {
        let weighted =
            |(k, pair): (usize, &[Point])| (pair[1] - pair[0]) * weight(k, self.degree() - 1, u);
        self.0.windows(2).enumerate().map(weighted).sum()
    }

    /// The curvature at `u`, 1/m, to either side; zero where the curve stands still, and for a straight segment.
    pub fn curvature(&self, u: f64) -> f64 {
        let Some(degree) = self.degree().checked_sub(2) else {
            return 0.0;
        };
        let weighted = |(k, triple): (usize, &[Point])| {
            ((triple[2] - triple[1]) - (triple[1] - triple[0])) * weight(k, degree, u)
        };
        let bend: Vector = self.0.windows(3).enumerate().map(weighted).sum();
        let tangent = self.tangent(u);
        let curvature = tangent.perp(&bend).abs() / tangent.norm().powi(3);
        if curvature.is_finite() {
            curvature
        } else {
            0.0
        }
    }

    /// Bound on the second derivative across a unit direction: that derivative is a weighted mean of the second
    /// differences of the control points.
    fn bend(&self, across: &Vector) -> f64 {
        self.0
            .windows(3)
            .map(|triple| {
                ((triple[2] - triple[1]) - (triple[1] - triple[0]))
                    .dot(across)
                    .abs()
            })
            .fold(0.0, f64::max)
    }
}

struct Sample {
    u: f64,
    place: Point,
    tangent: Vector,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cubic_weights_are_the_textbook_ones() {
        let at_start: Vec<f64> = (0..4).map(|k| weight(k, 3, 0.0)).collect();
        for (found, expected) in at_start.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn weights_of_every_degree_sum_to_one() {
        for degree in 0..=9 {
            let sum: f64 = (0..=degree).map(|k| weight(k, degree, 0.37)).sum();
            assert!((sum - 1.0).abs() < 1e-10, "degree {degree}: {sum}");
        }
    }

    #[test]
    fn the_tangent_is_the_slope_of_the_curve() {
        let control = [(0.0, 0.0), (1.0, 2.0), (4.0, 1.0), (5.0, -3.0), (4.0, 4.0)]
            .map(|(x, y)| Point::new(x, y));
        let segment = Segment(&control);
        for u in [0.1, 0.5, 0.8] {
            let slope = (segment.point(u + 1e-6) - segment.point(u - 1e-6)) / 2e-6;
            assert!((slope - segment.tangent(u)).norm() < 1e-7);
        }
    }

    #[test]
    fn chords_keep_to_the_curve() {
        let control = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 5.0)];
        let control = control.map(|(x, y)| Point::new(x, y));
        let spline = Segment(&control);
        let chords = crate::global::Path::new(spline.chords());
        assert_eq!(chords.turns(), 0);
        for step in 0..=1000 {
            let place = spline.point(f64::from(step) / 1000.0);
            let distance_m = chords.project(&place).distance_m;
            assert!(distance_m <= DEPARTURE_M, "{distance_m} m at step {step}");
        }
    }
}
