//! Covers a polygon with discs, and checks whether given discs cover it.

use super::disc_arrangements::{arrangements, overhang_m, row_of_sections};
use super::{Disc, Polygon};
use crate::geometry::{Point, Vector};

/// Largest number of discs of a cover: as many as the local planner takes.
pub(super) const MAX_COVER_DISCS: usize = 8;
/// A row of equal discs suffices where it stands out by at most this, metres: the margins of a path exceed what this adds to the
/// circle around the body.
const GOOD_OVERHANG_M: f64 = 0.15;
/// A body that fills less than this share of its bounding box is tapered.
const LEAST_FILLED_SHARE: f64 = 0.7;
/// Each disc costs time in every decision. One more must reduce the overhang by at least this, metres.
const GAIN_PER_DISC_M: f64 = 0.01;
/// The discs of a slim cover stand out by at most this to the sides, metres, unless that takes too many.
const SLIM_OVERHANG_M: f64 = 0.01;
/// Sections of a body need other discs than its bounding box where these stand out less by at least this, metres.
const LEAST_GAIN_M: f64 = 1e-3;
/// A point this far outside a disc still counts as covered, metres: rounding.
const TOLERANCE_M: f64 = 1e-6;

/// Covers a polygon with few discs that stand out little: a row of equal discs along the x axis where that suffices, else the best of
/// several arrangements.
///
/// A body wider than long always gets the row. It stands out little to the sides, which need the room of a robot that drives. With
/// discs side by side every turn costs clearance, and the robot drives past the middle of a door.
pub(super) fn cover(body: &Polygon) -> Vec<Disc> {
    let row = usual_row(body);
    let (length, width) = size(body);
    if width > length || is_tapered(body) || overhang_m(body, &row) <= GOOD_OVERHANG_M {
        return row;
    }
    let price_m =
        |discs: &Vec<Disc>| overhang_m(body, discs) + GAIN_PER_DISC_M * discs.len() as f64;
    let mut best = (price_m(&row), row);
    for discs in arrangements(body) {
        let price_m = price_m(&discs);
        if price_m < best.0 {
            best = (price_m, discs);
        }
    }
    best.1
}

/// Whether a body fills little of its bounding box, such as a triangle. With smaller discs at its narrow end, the robot drives into
/// gaps in which its wide end has no room: a triangle reached its goal in fewer worlds of BARN.
fn is_tapered(body: &Polygon) -> bool {
    let (length, width) = size(body);
    body.signed_area_m2().abs() < LEAST_FILLED_SHARE * length * width
}

/// A row of equal discs along the x axis. A body about as wide as long gets two, and one more than twice as wide as long one.
pub(super) fn usual_row(body: &Polygon) -> Vec<Disc> {
    row_of_discs(body, usual_count(body))
}

/// Radius of the discs of the usual row, metres.
pub(super) fn usual_radius_m(body: &Polygon) -> f64 {
    row_radius_m(body, usual_count(body))
}

fn usual_count(body: &Polygon) -> usize {
    let (length, width) = size(body);
    // One disc more than squares fit: it halves the overhang to the sides.
    let squares = (length / width.max(length / MAX_COVER_DISCS as f64)).round();
    (squares as usize + 1).min(MAX_COVER_DISCS)
}

/// Covers a polygon with a row of enough discs that they stand out little to the sides. They stand out more at the ends.
pub(super) fn slim_cover(body: &Polygon) -> Vec<Disc> {
    let (length, width) = size(body);
    let side_m = |count: usize| libm::hypot(length / count as f64, width) / 2.0 - width / 2.0;
    let few = usual_row(body).len();
    let count = (few..MAX_COVER_DISCS).find(|&count| side_m(count) <= SLIM_OVERHANG_M);
    let count = count.unwrap_or(MAX_COVER_DISCS);
    let (row, mut sections) = (row_of_discs(body, count), row_of_sections(body, count));
    // The disc of a section at one side of the body, as beside a corner that is cut off, stands out to that side. A door that is wide
    // enough for the whole row must be wide enough for it too.
    for (section, equal) in sections.iter_mut().zip(&row) {
        let is_inside = (section.y - equal.y).abs() + section.radius <= equal.radius + TOLERANCE_M;
        if !is_inside {
            *section = *equal;
        }
    }
    // The discs of a narrower section are smaller.
    let is_better =
        !is_tapered(body) && overhang_m(body, &sections) + LEAST_GAIN_M < overhang_m(body, &row);
    if is_better { sections } else { row }
}

/// Length and width of the box around a polygon: along x and along y, metres.
fn size(body: &Polygon) -> (f64, f64) {
    let (least, most) = body.bounds();
    (most.x - least.x, most.y - least.y)
}

/// The middle of the box around a polygon, and the radius of the circle around it that contains the polygon.
fn circle_around(body: &Polygon) -> (Point, f64) {
    let (least, most) = body.bounds();
    let middle = least + (most - least) * 0.5;
    let distance = |corner: &Point| (corner - middle).norm();
    (middle, body.corners().iter().map(distance).fold(0.0, f64::max))
}

/// Radius of the discs of a row, metres.
fn row_radius_m(body: &Polygon, count: usize) -> f64 {
    let (length, width) = size(body);
    libm::hypot(length / count as f64 / 2.0, width / 2.0).min(circle_around(body).1)
}

/// A row of equal discs, or the circumscribed circle if that is not larger than one of them.
fn row_of_discs(body: &Polygon, count: usize) -> Vec<Disc> {
    let (length, _) = size(body);
    let spacing = length / count as f64;
    let radius = row_radius_m(body, count);
    let (middle, circumradius) = circle_around(body);
    if circumradius <= radius {
        return vec![Disc { x: middle.x, y: middle.y, radius: circumradius }];
    }
    let disc = |index: usize| {
        let along = (index as f64 + 0.5) * spacing - length / 2.0;
        Disc { x: middle.x + along, y: middle.y, radius }
    };
    (0..count).map(disc).collect()
}

/// A point of a polygon that no disc covers; `None` where the discs cover it.
///
/// A region left open inside the polygon, where the outline itself is covered, is bounded by arcs of discs that bend into it.
/// So it has corners, and each is a common point of two circles. It suffices to check the outline and these points.
pub(super) fn uncovered_point(body: &Polygon, discs: &[Disc]) -> Option<Point> {
    let on_outline = body.edges().find_map(|(from, to)| uncovered_on_edge(from, to, discs));
    on_outline.or_else(|| {
        let is_inside = |point: &Point| {
            body.contains(point) && (point - body.nearest_on_outline(point)).norm() > TOLERANCE_M
        };
        let pairs = discs
            .iter()
            .enumerate()
            .flat_map(|(index, one)| discs[index + 1..].iter().map(move |other| (one, other)));
        pairs.into_iter().find_map(|(one, other)| {
            let is_open = |point: &Point| {
                let covers = |disc: &&Disc| {
                    !core::ptr::eq(*disc, one)
                        && !core::ptr::eq(*disc, other)
                        && reaches(disc, point)
                };
                is_inside(point) && !discs.iter().any(|disc| covers(&disc))
            };
            common_points(one, other).into_iter().flatten().find(is_open)
        })
    })
}

fn reaches(disc: &Disc, point: &Point) -> bool {
    libm::hypot(point.x - disc.x, point.y - disc.y) <= disc.radius + TOLERANCE_M
}

/// The first point of an edge that no disc covers.
fn uncovered_on_edge(from: &Point, to: &Point, discs: &[Disc]) -> Option<Point> {
    let along = to - from;
    let length = along.norm();
    let direction = if length > 0.0 { along / length } else { Vector::ZERO };
    // The stretch of the edge within each disc, metres from its begin.
    let mut stretches: Vec<(f64, f64)> = discs
        .iter()
        .filter_map(|disc| {
            let offset = Point::new(disc.x, disc.y) - from;
            let (middle, aside) = (offset.dot(&direction), offset.perp(&direction));
            let radius = disc.radius + TOLERANCE_M;
            let half = (radius * radius - aside * aside).max(0.0).sqrt();
            (aside.abs() <= radius).then_some((middle - half, middle + half))
        })
        .collect();
    stretches.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut covered = 0.0;
    for (begin, end) in stretches {
        if begin > covered {
            break;
        }
        covered = end.max(covered);
        if covered >= length {
            return None;
        }
    }
    Some(from + direction * covered)
}

/// The points that two circles have in common.
fn common_points(one: &Disc, other: &Disc) -> [Option<Point>; 2] {
    let between = Vector::new(other.x - one.x, other.y - one.y);
    let distance = between.norm();
    let meet = distance > 0.0
        && distance <= one.radius + other.radius
        && distance >= (one.radius - other.radius).abs();
    if !meet {
        return [None, None];
    }
    let squared = one.radius * one.radius - other.radius * other.radius;
    let along = (distance * distance + squared) / (2.0 * distance);
    let aside = (one.radius * one.radius - along * along).max(0.0).sqrt();
    let direction = between / distance;
    let foot = Point::new(one.x, one.y) + direction * along;
    let left = Vector::new(-direction.y, direction.x) * aside;
    [Some(foot + left), Some(foot - left)]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// What a body needs to the sides decides where it can drive.
    #[test]
    fn body_wider_than_long_is_covered_by_a_short_row_along_its_course() {
        for (length, width, count) in [(0.4, 0.6, 2), (0.5, 0.6, 2), (0.3, 0.7, 1)] {
            let (x, y) = (length / 2.0, width / 2.0);
            let corners = [(x, y), (-x, y), (-x, -y), (x, -y)];
            let corners = corners.map(|(x, y)| Point::new(x + 0.1, y)).to_vec();
            let body = Polygon::new(corners).expect("a polygon");
            for discs in [cover(&body), slim_cover(&body)] {
                assert_eq!(uncovered_point(&body, &discs), None, "{body:?}");
                let side = |disc: &Disc| disc.y.abs() + disc.radius - y;
                let side_m = discs.iter().map(side).fold(0.0, f64::max);
                assert!(side_m < 0.04, "{length} x {width}: {side_m} m");
            }
            assert_eq!(cover(&body).len(), count, "{length} x {width}");
        }
    }

    #[test]
    fn discs_of_narrow_passages_cover_the_body_and_hardly_stand_out_to_its_sides() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let (mut slim, mut smaller) = (0, 0);
        for _ in 0..200 {
            let box_size =
                Vector::new(random.random_range(0.2..1.5), random.random_range(0.2..1.0));
            let mut at = |half: f64| random.random_range(0.3..1.0) * half;
            let (x, y) = (box_size.x / 2.0, box_size.y / 2.0);
            let corners = [(x, -at(y)), (x, at(y)), (-at(x), y), (-x, at(y)), (-x, -y)];
            let corners = corners.map(|(x, y)| Point::new(x + 0.1, y - 0.05)).to_vec();
            let body = Polygon::new(corners).expect("a polygon");
            let discs = slim_cover(&body);
            assert_eq!(uncovered_point(&body, &discs), None, "{body:?}");
            assert!(discs.len() <= MAX_COVER_DISCS && discs.len() >= usual_row(&body).len());
            let largest = discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
            let side_m = largest - size(&body).1 / 2.0;
            let is_slim = side_m <= SLIM_OVERHANG_M;
            assert!(is_slim || discs.len() == MAX_COVER_DISCS, "{body:?}: {side_m} m");
            slim += u32::from(is_slim && discs.len() > usual_row(&body).len());
            let equal = overhang_m(&body, &row_of_discs(&body, discs.len()));
            assert!(overhang_m(&body, &discs) <= equal, "{body:?}");
            smaller += u32::from(overhang_m(&body, &discs) < 0.8 * equal);
        }
        assert!(slim > 100, "{slim} with more discs");
        assert!(smaller > 0, "{smaller} with smaller discs at an end");
    }
}
