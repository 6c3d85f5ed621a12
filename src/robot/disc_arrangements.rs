//! Arrangements of discs that cover a polygon.

use super::disc_cover::{MAX_COVER_DISCS, uncovered_point};
use super::{Disc, Polygon};
use crate::geometry::{Point, Vector};

/// A core of a cover is where the depth of the body is at least one of these shares of its greatest depth.
const CORE_SHARES: [f64; 3] = [1.0, 0.8, 0.6];
/// Places along a body at which its deepest point is searched.
const SLICES: u32 = 64;
/// Steps of a search in an interval: they halve it, or reduce it by a third.
const SEARCH_STEPS: u32 = 40;
/// Added to the radii that a search has found, metres: they cover the body despite rounding.
const ROUNDING_M: f64 = 1e-5;
/// Depths that differ by this are equal, metres.
const SAME_DEPTH_M: f64 = 1e-9;

/// An axis of the robot's frame.
#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
}

impl Axis {
    fn longer(body: &Polygon) -> Self {
        let (least, most) = body.bounds();
        if most.x - least.x >= most.y - least.y { Self::X } else { Self::Y }
    }

    const fn other(self) -> Self {
        match self {
            Self::X => Self::Y,
            Self::Y => Self::X,
        }
    }

    const fn of(self, point: &Point) -> f64 {
        match self {
            Self::X => point.x,
            Self::Y => point.y,
        }
    }

    /// The point with these coordinates along this axis and across it.
    const fn point(self, along: f64, across: f64) -> Point {
        match self {
            Self::X => Point::new(along, across),
            Self::Y => Point::new(across, along),
        }
    }

    /// Least and largest coordinate.
    fn range(self, points: &[Point]) -> (f64, f64) {
        let wider = |(least, most): (f64, f64), point: &Point| {
            (least.min(self.of(point)), most.max(self.of(point)))
        };
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), wider)
    }
}

/// Largest distance of the outline of a cover from the body, metres. For a body that is not convex it may be less.
///
/// A disc whose centre is inside the body extends beyond the nearest edge by its radius minus the distance to that edge.
pub(super) fn overhang_m(body: &Polygon, discs: &[Disc]) -> f64 {
    let beyond = |disc: &Disc| disc.radius + body.signed_distance(&Point::new(disc.x, disc.y));
    discs.iter().map(beyond).fold(0.0, f64::max)
}

/// Arrangements that cover a polygon, at most 8 discs each.
pub(super) fn arrangements(body: &Polygon) -> impl Iterator<Item = Vec<Disc>> {
    let axis = Axis::longer(body);
    let grids = [axis, axis.other()].into_iter().flat_map(move |axis| {
        (1..=MAX_COVER_DISCS).flat_map(move |columns| grids(body, axis, columns))
    });
    let cores = CORE_SHARES
        .into_iter()
        .flat_map(move |share| Core::new(body, axis, share).arrangements(body));
    grids.chain(cores)
}

/// The smallest disc around each of equally long sections of the body along the x axis.
pub(super) fn row_of_sections(body: &Polygon, count: usize) -> Vec<Disc> {
    let sections = sections(body.corners(), Axis::X, count);
    sections.iter().map(|section| smallest_disc(section)).collect()
}

/// Columns of discs: each column covers a section of the body. One disc for each column, then one more for the column that stands
/// out most, and so on.
fn grids(body: &Polygon, axis: Axis, columns: usize) -> Vec<Vec<Disc>> {
    let column = |section: &[Point], rows: usize| -> Vec<Disc> {
        let cells = sections(section, axis.other(), rows);
        cells.iter().map(|cell| smallest_disc(cell)).collect()
    };
    let sections = sections(body.corners(), axis, columns);
    let mut discs: Vec<Vec<Disc>> = sections.iter().map(|section| column(section, 1)).collect();
    let mut found = vec![discs.concat()];
    while discs.iter().map(Vec::len).sum::<usize>() < MAX_COVER_DISCS {
        let overhang = |index: &usize| overhang_m(body, &discs[*index]);
        let worst = (0..discs.len()).max_by(|one, other| overhang(one).total_cmp(&overhang(other)));
        let Some(worst) = worst else {
            break;
        };
        discs[worst] = column(&sections[worst], discs[worst].len() + 1);
        found.push(discs.concat());
    }
    found
}

/// Corners of the parts of a polygon in equal sections along an axis. Empty sections are left out.
fn sections(corners: &[Point], axis: Axis, count: usize) -> Vec<Vec<Point>> {
    let (least, most) = axis.range(corners);
    let at = |index: usize| least + (most - least) * (index as f64 / count as f64);
    (0..count)
        .map(|index| {
            let above = half(corners, |point| axis.of(point) - at(index));
            half(&above, |point| at(index + 1) - axis.of(point))
        })
        .filter(|section| !section.is_empty())
        .collect()
}

/// The part of a polygon on the side of a line where the distance to it is not negative.
fn half(corners: &[Point], distance: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut part = Vec::new();
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (before, after) = (distance(from), distance(to));
        if before >= 0.0 {
            part.push(*from);
        }
        if before * after < 0.0 {
            part.push(from + (to - from) * (before / (before - after)));
        }
    }
    part
}

/// The smallest disc that contains all points: two or three of them are on its outline.
fn smallest_disc(points: &[Point]) -> Disc {
    let mut center = points.first().copied().unwrap_or_default();
    let mut radius = 0.0;
    let is_outside = |(center, radius): (Point, f64), point: &Point| {
        (point - center).norm() > radius + SAME_DEPTH_M
    };
    for (one_index, one) in points.iter().enumerate() {
        if !is_outside((center, radius), one) {
            continue;
        }
        (center, radius) = (*one, 0.0);
        for (other_index, other) in points[..one_index].iter().enumerate() {
            if !is_outside((center, radius), other) {
                continue;
            }
            center = one + (other - one) * 0.5;
            radius = (one - center).norm();
            for third in &points[..other_index] {
                if is_outside((center, radius), third) {
                    center = circumcenter(one, other, third).unwrap_or(center);
                    radius = (one - center).norm();
                }
            }
        }
    }
    let farthest = points.iter().map(|point| (point - center).norm()).fold(0.0, f64::max);
    Disc { x: center.x, y: center.y, radius: farthest }
}

/// The point with the same distance from three points; `None` where they are on a line.
fn circumcenter(one: &Point, other: &Point, third: &Point) -> Option<Point> {
    let (to_other, to_third) = (other - one, third - one);
    let double = 2.0 * to_other.perp(&to_third);
    let (squared, squared_third) = (to_other.norm_squared(), to_third.norm_squared());
    let x = (to_third.y * squared - to_other.y * squared_third) / double;
    let y = (to_other.x * squared_third - to_third.x * squared) / double;
    (x.is_finite() && y.is_finite()).then(|| one + Vector::new(x, y))
}

/// A row of discs through the deepest places of a body, and discs in the corners that these leave open. All stand out equally.
struct Core {
    axis: Axis,
    /// Coordinates along the axis between which the centres of the row are.
    range: (f64, f64),
}

impl Core {
    fn new(body: &Polygon, axis: Axis, share: f64) -> Self {
        let (least, most) = axis.range(body.corners());
        let slice = |index: u32| {
            let along = least + (most - least) * f64::from(index) / f64::from(SLICES);
            (along, -body.signed_distance(&deepest(body, axis, along)))
        };
        let slices: Vec<(f64, f64)> = (0..=SLICES).map(slice).collect();
        let greatest = slices.iter().map(|(_, depth)| *depth).fold(0.0, f64::max);
        let deep: Vec<Point> = slices
            .iter()
            .filter(|(_, depth)| *depth >= share * greatest - SAME_DEPTH_M)
            .map(|(along, _)| axis.point(*along, 0.0))
            .collect();
        Self { axis, range: axis.range(&deep) }
    }

    /// The arrangement with the least overhang for each number of discs in the row.
    fn arrangements(&self, body: &Polygon) -> Vec<Vec<Disc>> {
        let (begin, end) = self.range;
        let longest = if end > begin { MAX_COVER_DISCS } else { 1 };
        let row = |count: usize| -> Vec<Point> {
            let at = |index: usize| match count {
                1 => 0.5,
                _ => index as f64 / (count - 1) as f64,
            };
            let center = |index: usize| deepest(body, self.axis, begin + (end - begin) * at(index));
            (0..count).map(center).collect()
        };
        (1..=longest).filter_map(|count| tightest(body, &row(count))).collect()
    }
}

/// The deepest point of a convex body on a line across an axis.
fn deepest(body: &Polygon, axis: Axis, along: f64) -> Point {
    let (mut least, mut most) = axis.other().range(body.corners());
    for _ in 0..SEARCH_STEPS {
        let third = (most - least) / 3.0;
        let (one, other) = (least + third, most - third);
        let outside = |across: f64| body.signed_distance(&axis.point(along, across));
        if outside(one) <= outside(other) { most = other } else { least = one }
    }
    axis.point(along, 0.5 * (least + most))
}

/// Discs around these centres, and discs in the corners, that cover a body with the least overhang; `None` where they cannot.
fn tightest(body: &Polygon, row: &[Point]) -> Option<Vec<Disc>> {
    let depths: Vec<f64> = row.iter().map(|center| -body.signed_distance(center)).collect();
    let (mut least, mut most) = (0.0, depths.iter().copied().fold(0.0, f64::max));
    let cover_with = |overhang_m: f64| {
        let mut discs: Vec<Disc> = row
            .iter()
            .zip(&depths)
            .map(|(center, depth)| Disc { x: center.x, y: center.y, radius: depth + overhang_m })
            .collect();
        add_corners(body, &mut discs, overhang_m);
        let covers = discs.len() <= MAX_COVER_DISCS && uncovered_point(body, &discs).is_none();
        discs.iter_mut().for_each(|disc| disc.radius += ROUNDING_M);
        covers.then_some(discs)
    };
    let mut best = cover_with(most)?;
    for _ in 0..SEARCH_STEPS / 2 {
        let middle = 0.5 * (least + most);
        match cover_with(middle) {
            Some(discs) => (best, most) = (discs, middle),
            None => least = middle,
        }
    }
    Some(best)
}

/// Adds a disc to each corner that no disc reaches. It touches the corner, and stands out to both sides by the overhang.
fn add_corners(body: &Polygon, discs: &mut Vec<Disc>, overhang_m: f64) {
    let corners = body.corners();
    for (index, corner) in corners.iter().enumerate() {
        let reaches = |disc: &Disc| (corner - Point::new(disc.x, disc.y)).norm() <= disc.radius;
        if discs.iter().any(reaches) {
            continue;
        }
        let next = corners[(index + 1) % corners.len()] - *corner;
        let last = corners[(index + corners.len() - 1) % corners.len()] - *corner;
        let bisector = next / next.norm() + last / last.norm();
        let cos_half = bisector.norm() / 2.0;
        let sin_half = (1.0 - cos_half * cos_half).max(0.0).sqrt();
        let radius = overhang_m / (1.0 - sin_half);
        let center = *corner + bisector * (radius / bisector.norm());
        if radius.is_finite() && center.is_finite() {
            discs.push(Disc { x: center.x, y: center.y, radius });
        }
    }
}
