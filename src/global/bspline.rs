//! The uniform B-spline as the paper writes it (eqs. 24-26).

use crate::geometry::{Point, Vector};

/// Chords depart from the curve by at most this, metres.
const DEPARTURE_M: f64 = 0.003;
/// The heading changes along a chord by at most this, radians: two such chords make no turn as
/// [`Path::turns`](super::Path::turns) counts.
pub(super) const CHORD_TURN_RAD: f64 = 0.04;
/// Its tangent.
const CHORD_TURN_TANGENT: f64 = 0.040_021_346_995_514_55;
/// Derivatives below this are none, metres: rounding.
const STANDING_M: f64 = 1e-9;
/// A segment is halved at most so many times.
const HALVINGS: u32 = 12;

/// Largest degree.
const MOST: usize = 9;

/// The weights of a degree (eq. 24) as polynomials.
pub(super) struct Basis {
    degree: usize,
    /// For each control point of a segment, the factors of 1, u, u^2, ...
    weights: [[f64; MOST + 1]; MOST + 1],
}

impl Basis {
    /// That of a degree of 1 to 9.
    ///
    /// Multiplied out, eq. 24 has at `u^p` the sum over `j` of `(-1)^j C(n + 1, j) C(n, p) (n - k - j)^(n - p) / n!`.
    pub fn new(degree: usize) -> Self {
        let factorial: f64 = (1..=degree).map(|factor| factor as f64).product();
        let mut weights = [[0.0; MOST + 1]; MOST + 1];
        for (k, weight) in weights.iter_mut().enumerate().take(degree + 1) {
            for (power, factor) in weight.iter_mut().enumerate().take(degree + 1) {
                let term = |j: usize| {
                    let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
                    let shift = (degree - k - j) as f64;
                    sign * binomial(degree + 1, j) * shift.powi((degree - power) as i32)
                };
                let sum: f64 = (0..=degree - k).map(term).sum();
                *factor = binomial(degree, power) * sum / factorial;
            }
        }
        Self { degree, weights }
    }
}

/// Eq. 25.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// One segment of a uniform B-spline (eq. 26), as a polynomial about its first control point, so that large coordinates
/// cost no digits.
pub(super) struct Segment<'a> {
    control: &'a [Point],
    /// The factors of 1, u, u^2, ...
    factors: [Vector; MOST + 1],
}

impl<'a> Segment<'a> {
    /// The segment of these control points, one more than the degree.
    pub fn new(basis: &Basis, control: &'a [Point]) -> Self {
        debug_assert_eq!(control.len(), basis.degree + 1);
        let mut factors = [Vector::zeros(); MOST + 1];
        for (point, weight) in control.iter().zip(&basis.weights) {
            let from_first = point - control[0];
            for (factor, weight) in factors.iter_mut().zip(weight).take(control.len()) {
                *factor += from_first * *weight;
            }
        }
        Self { control, factors }
    }

    /// Hands out the points of the segment after its first: their chords stay within 3 mm and 0.04 rad of the curve.
    pub fn chords(&self, mut next: impl FnMut(Point)) {
        self.halve(&self.sample(0.0), &self.sample(1.0), HALVINGS, &mut next);
    }

    /// Hands out the points after `from` up to `to`, as many as the chords need.
    fn halve(&self, from: &Sample, to: &Sample, halvings: u32, next: &mut impl FnMut(Point)) {
        let chord = to.place - from.place;
        let across = Vector::new(-chord.y, chord.x) / chord.norm().max(f64::MIN_POSITIVE);
        let departure_m = self.bend(&across) * (to.u - from.u).powi(2) / 8.0;
        let is_near = departure_m <= DEPARTURE_M && turns_little(&from.tangent, &to.tangent);
        if halvings == 0 || is_near {
            next(to.place);
            return;
        }
        let middle = self.sample(f64::midpoint(from.u, to.u));
        self.halve(from, &middle, halvings - 1, next);
        self.halve(&middle, to, halvings - 1, next);
    }

    fn sample(&self, u: f64) -> Sample {
        Sample {
            u,
            place: self.point(u),
            tangent: self.tangent(u),
        }
    }

    const fn degree(&self) -> usize {
        self.control.len() - 1
    }

    /// The point at `u` in 0..=1.
    pub fn point(&self, u: f64) -> Point {
        let factors = self.factors[..=self.degree()].iter().rev();
        self.control[0] + factors.fold(Vector::zeros(), |sum, factor| sum * u + factor)
    }

    /// The derivative at `u`.
    fn tangent(&self, u: f64) -> Vector {
        let powers = (1..=self.degree()).rev();
        powers.fold(Vector::zeros(), |sum, power| {
            sum * u + self.factors[power] * power as f64
        })
    }

    /// The second derivative at `u`.
    fn bending(&self, u: f64) -> Vector {
        let powers = (2..=self.degree()).rev();
        powers.fold(Vector::zeros(), |sum, power| {
            sum * u + self.factors[power] * (power * (power - 1)) as f64
        })
    }

    /// The curvature at `u`, 1/m, to either side; zero where the curve stands still, and for a straight segment.
    pub fn curvature(&self, u: f64) -> f64 {
        let tangent = self.tangent(u);
        let curvature = tangent.perp(&self.bending(u)).abs() / tangent.norm().powi(3);
        if curvature.is_finite() {
            curvature
        } else {
            0.0
        }
    }

    /// Bound on the second derivative across a unit direction: that derivative is a weighted mean of the second
    /// differences of the control points.
    fn bend(&self, across: &Vector) -> f64 {
        self.control
            .windows(3)
            .map(|triple| {
                ((triple[2] - triple[1]) - (triple[1] - triple[0]))
                    .dot(across)
                    .abs()
            })
            .fold(0.0, f64::max)
    }
}

/// Whether a heading changes to another by at most [`CHORD_TURN_RAD`]. A curve that stands still has none, only rounding.
fn turns_little(from: &Vector, to: &Vector) -> bool {
    let ahead = from.dot(to);
    let stands = from.norm().min(to.norm()) < STANDING_M;
    stands || (ahead >= 0.0 && from.perp(to).abs() <= CHORD_TURN_TANGENT * ahead)
}

struct Sample {
    u: f64,
    place: Point,
    tangent: Vector,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weight(k: usize, degree: usize, u: f64) -> f64 {
        let factors = Basis::new(degree).weights[k];
        factors
            .iter()
            .rev()
            .fold(0.0, |sum, factor| sum * u + factor)
    }

    #[test]
    fn the_weights_are_those_of_the_equation() {
        for degree in 1..=MOST {
            let factorial: f64 = (1..=degree).map(|factor| factor as f64).product();
            for k in 0..=degree {
                for u in [0.0, 0.21, 0.5, 1.0] {
                    let term = |j: usize| {
                        let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
                        let base: f64 = u + (degree - k - j) as f64;
                        sign * binomial(degree + 1, j) * base.powi(degree as i32) / factorial
                    };
                    let expected: f64 = (0..=degree - k).map(term).sum();
                    assert!(
                        (weight(k, degree, u) - expected).abs() < 1e-9,
                        "{k} of {degree}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_cubic_weights_are_the_textbook_ones() {
        let at_start: Vec<f64> = (0..4).map(|k| weight(k, 3, 0.0)).collect();
        for (found, expected) in at_start.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn weights_of_every_degree_sum_to_one() {
        for degree in 1..=MOST {
            let sum: f64 = (0..=degree).map(|k| weight(k, degree, 0.37)).sum();
            assert!((sum - 1.0).abs() < 1e-10, "degree {degree}: {sum}");
        }
    }

    #[test]
    fn the_tangent_is_the_slope_of_the_curve() {
        let control = [(0.0, 0.0), (1.0, 2.0), (4.0, 1.0), (5.0, -3.0), (4.0, 4.0)]
            .map(|(x, y)| Point::new(x, y));
        let basis = Basis::new(4);
        let segment = Segment::new(&basis, &control);
        for u in [0.1, 0.5, 0.8] {
            let slope = (segment.point(u + 1e-6) - segment.point(u - 1e-6)) / 2e-6;
            assert!((slope - segment.tangent(u)).norm() < 1e-7);
            let bending = (segment.tangent(u + 1e-6) - segment.tangent(u - 1e-6)) / 2e-6;
            assert!((bending - segment.bending(u)).norm() < 1e-6);
        }
    }

    #[test]
    fn chords_keep_to_the_curve() {
        let control = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 5.0)];
        let control = control.map(|(x, y)| Point::new(x, y));
        let basis = Basis::new(3);
        let spline = Segment::new(&basis, &control);
        let mut points = vec![spline.point(0.0)];
        spline.chords(|point| points.push(point));
        let chords = crate::global::Path::new(points);
        assert_eq!(chords.turns(), 0);
        for step in 0..=1000 {
            let place = spline.point(f64::from(step) / 1000.0);
            let distance_m = chords.project(&place).distance_m;
            assert!(distance_m <= DEPARTURE_M, "{distance_m} m at step {step}");
        }
    }
}
