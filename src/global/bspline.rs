//! Uniform B-spline segments (paper, eqs. 24-26).

use crate::geometry::{Point, Vector};

/// Largest distance between a chord and the curve, metres.
const MAX_DEVIATION_M: f64 = 0.003;
/// Largest change of heading along a chord, radians. Two such chords are below the threshold of
/// [`Path::turns`](super::Path::turns).
pub(super) const CHORD_TURN_RAD: f64 = 0.04;
/// Tangent of [`CHORD_TURN_RAD`].
const CHORD_TURN_TANGENT: f64 = 0.040_021_346_995_514_55;
/// Derivatives shorter than this count as zero, metres.
const ZERO_DERIVATIVE_M: f64 = 1e-9;
/// Largest number of recursive bisections of a segment.
const MAX_BISECTIONS: u32 = 12;

/// Largest degree.
pub(super) const MAX_DEGREE: usize = 9;

/// The basis functions of a degree (eq. 24) as polynomials.
pub(super) struct Basis {
    degree: usize,
    /// For each control point of a segment, the coefficients of 1, u, u^2, ...
    weights: [[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1],
}

impl Basis {
    /// Creates the basis of a degree of 1 to 9.
    ///
    /// In expanded form, the coefficient of `u^p` in eq. 24 is the sum over `j` of
    /// `(-1)^j C(n + 1, j) C(n, p) (n - k - j)^(n - p) / n!`.
    pub fn new(degree: usize) -> Self {
        let factorial: f64 = (1..=degree).map(|factor| factor as f64).product();
        let mut weights = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
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

/// Binomial coefficient (eq. 25).
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// One segment of a uniform B-spline (eq. 26), as a polynomial relative to its first control point. This keeps precision
/// for large coordinates.
pub(super) struct Segment<'a> {
    control: &'a [Point],
    /// The coefficients of 1, u, u^2, ...
    factors: [Vector; MAX_DEGREE + 1],
}

impl<'a> Segment<'a> {
    /// Creates the segment of these control points; their number is the degree plus one.
    pub fn new(basis: &Basis, control: &'a [Point]) -> Self {
        debug_assert_eq!(control.len(), basis.degree + 1);
        let mut factors = [Vector::ZERO; MAX_DEGREE + 1];
        for (point, weight) in control.iter().zip(&basis.weights) {
            let from_first = point - control[0];
            for (factor, weight) in factors.iter_mut().zip(weight).take(control.len()) {
                *factor = *factor + from_first * *weight;
            }
        }
        Self { control, factors }
    }

    /// Emits the points of the segment after its first. Their chords stay within 3 mm and 0.04 rad of the curve.
    pub fn chords(&self, mut next: impl FnMut(Point)) {
        self.bisect(&self.sample(0.0), &self.sample(1.0), MAX_BISECTIONS, &mut next);
    }

    /// Emits the points after `from` up to `to`, as many as the tolerances require.
    fn bisect(&self, from: &Sample, to: &Sample, bisections: u32, next: &mut impl FnMut(Point)) {
        let chord = to.point - from.point;
        let across = Vector::new(-chord.y, chord.x) / chord.norm().max(f64::MIN_POSITIVE);
        let deviation_m = self.max_second_derivative(&across) * (to.u - from.u).powi(2) / 8.0;
        let is_near = deviation_m <= MAX_DEVIATION_M && turns_little(&from.tangent, &to.tangent);
        if bisections == 0 || is_near {
            next(to.point);
            return;
        }
        let middle = self.sample(f64::midpoint(from.u, to.u));
        self.bisect(from, &middle, bisections - 1, next);
        self.bisect(&middle, to, bisections - 1, next);
    }

    fn sample(&self, u: f64) -> Sample {
        Sample { u, point: self.point(u), tangent: self.tangent(u) }
    }

    const fn degree(&self) -> usize {
        self.control.len() - 1
    }

    /// The point at `u` in 0..=1.
    pub fn point(&self, u: f64) -> Point {
        let factors = self.factors[..=self.degree()].iter().rev();
        self.control[0] + factors.fold(Vector::ZERO, |sum, factor| sum * u + factor)
    }

    /// The first derivative at `u`.
    fn tangent(&self, u: f64) -> Vector {
        let powers = (1..=self.degree()).rev();
        powers.fold(Vector::ZERO, |sum, power| sum * u + self.factors[power] * power as f64)
    }

    /// The second derivative at `u`.
    fn second_derivative(&self, u: f64) -> Vector {
        let powers = (2..=self.degree()).rev();
        powers.fold(Vector::ZERO, |sum, power| {
            sum * u + self.factors[power] * (power * (power - 1)) as f64
        })
    }

    /// The unsigned curvature at `u`, 1/m; zero for a straight segment and where the derivative vanishes.
    pub fn curvature(&self, u: f64) -> f64 {
        let tangent = self.tangent(u);
        let curvature = tangent.perp(&self.second_derivative(u)).abs() / tangent.norm().powi(3);
        if curvature.is_finite() { curvature } else { 0.0 }
    }

    /// Upper bound of the second derivative along a unit direction. The second derivative is a weighted mean of the second
    /// differences of the control points.
    fn max_second_derivative(&self, across: &Vector) -> f64 {
        self.control
            .windows(3)
            .map(|triple| ((triple[2] - triple[1]) - (triple[1] - triple[0])).dot(across).abs())
            .fold(0.0, f64::max)
    }
}

/// Whether the heading changes by at most [`CHORD_TURN_RAD`]. A vanishing derivative has no heading.
fn turns_little(from: &Vector, to: &Vector) -> bool {
    let ahead = from.dot(to);
    let vanishes = from.norm().min(to.norm()) < ZERO_DERIVATIVE_M;
    vanishes || (ahead >= 0.0 && from.perp(to).abs() <= CHORD_TURN_TANGENT * ahead)
}

struct Sample {
    u: f64,
    point: Point,
    tangent: Vector,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weight(k: usize, degree: usize, u: f64) -> f64 {
        let factors = Basis::new(degree).weights[k];
        factors.iter().rev().fold(0.0, |sum, factor| sum * u + factor)
    }

    #[test]
    fn basis_weights_equal_equation_24() {
        for degree in 1..=MAX_DEGREE {
            let factorial: f64 = (1..=degree).map(|factor| factor as f64).product();
            for k in 0..=degree {
                for u in [0.0, 0.21, 0.5, 1.0] {
                    let term = |j: usize| {
                        let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
                        let base: f64 = u + (degree - k - j) as f64;
                        sign * binomial(degree + 1, j) * base.powi(degree as i32) / factorial
                    };
                    let expected: f64 = (0..=degree - k).map(term).sum();
                    assert!((weight(k, degree, u) - expected).abs() < 1e-9, "{k} of {degree}");
                }
            }
        }
    }

    #[test]
    fn cubic_basis_weights_at_the_start_are_1_4_1() {
        let at_start: Vec<f64> = (0..4).map(|k| weight(k, 3, 0.0)).collect();
        for (found, expected) in at_start.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn basis_weights_of_every_degree_sum_to_one() {
        for degree in 1..=MAX_DEGREE {
            let sum: f64 = (0..=degree).map(|k| weight(k, degree, 0.37)).sum();
            assert!((sum - 1.0).abs() < 1e-10, "degree {degree}: {sum}");
        }
    }

    #[test]
    fn segment_derivatives_equal_difference_quotients() {
        let control = [(0.0, 0.0), (1.0, 2.0), (4.0, 1.0), (5.0, -3.0), (4.0, 4.0)]
            .map(|(x, y)| Point::new(x, y));
        let basis = Basis::new(4);
        let segment = Segment::new(&basis, &control);
        for u in [0.1, 0.5, 0.8] {
            let slope = (segment.point(u + 1e-6) - segment.point(u - 1e-6)) / 2e-6;
            assert!((slope - segment.tangent(u)).norm() < 1e-7);
            let change = (segment.tangent(u + 1e-6) - segment.tangent(u - 1e-6)) / 2e-6;
            assert!((change - segment.second_derivative(u)).norm() < 1e-6);
        }
    }

    /// A segment of degree two is a parabola: y = x^2 here, with curvature 2 / (1 + 4 x^2)^1.5.
    #[test]
    fn quadratic_segment_has_the_curvature_of_a_parabola() {
        // Control points at the crossings of the tangents of x = -2, 0, 2, 4.
        let control = [(-1.0, 0.0), (1.0, 0.0), (3.0, 8.0)].map(|(x, y)| Point::new(x, y));
        let basis = Basis::new(2);
        let segment = Segment::new(&basis, &control);
        for u in [0.0, 0.3, 0.5, 1.0] {
            let place = segment.point(u);
            assert!((place.y - place.x * place.x).abs() < 1e-12, "{place:?}");
            let squared = 1.0 + 4.0 * place.x * place.x;
            let curvature = 2.0 / (squared * squared.sqrt());
            assert!((segment.curvature(u) - curvature).abs() < 1e-12);
        }
    }

    #[test]
    fn chords_stay_within_the_tolerance_of_the_curve() {
        let control = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 5.0)];
        let control = control.map(|(x, y)| Point::new(x, y));
        let basis = Basis::new(3);
        let spline = Segment::new(&basis, &control);
        let mut points = vec![spline.point(0.0)];
        spline.chords(|point| points.push(point));
        let chords = crate::global::Path::new(points);
        assert_eq!(chords.turns(), 0);
        for step in 0..=1000 {
            let point = spline.point(f64::from(step) / 1000.0);
            let distance_m = chords.project(&point).distance_m;
            assert!(distance_m <= MAX_DEVIATION_M, "{distance_m} m at step {step}");
        }
    }
}
