//! Covers a polygon with discs, and checks whether given discs cover it.

use super::{Disc, Polygon};
use crate::geometry::{Point, Vector};

/// Largest number of discs of a cover: as many as the local planner takes.
const MAX_COVER_DISCS: usize = 8;
/// A point this far outside a disc still counts as covered, metres: rounding.
const TOLERANCE_M: f64 = 1e-6;

/// Covers a polygon with few discs: its circumscribed circle, or a row of discs along the longer side of its bounding box if
/// that is narrower. A body nearly as wide as long gets two discs.
pub(super) fn cover(body: &Polygon) -> Vec<Disc> {
    let corners = body.corners();
    let least = corners.iter().fold(corners[0], |least, corner| least.min(corner));
    let most = corners.iter().fold(corners[0], |most, corner| most.max(corner));
    let (size, middle) = (most - least, least + (most - least) * 0.5);
    let (longer, shorter) = (size.x.max(size.y), size.x.min(size.y));
    // One disc more than squares fit: it halves the overhang to the sides.
    let squares = (longer / shorter.max(longer / MAX_COVER_DISCS as f64)).round();
    let count = (squares as usize + 1).clamp(2, MAX_COVER_DISCS);
    let spacing = longer / count as f64;
    let radius = libm::hypot(spacing / 2.0, shorter / 2.0);
    let farthest = |from: Point| {
        let distance = |corner: &Point| (corner - from).norm();
        corners.iter().map(distance).fold(0.0, f64::max)
    };
    let circumradius = farthest(middle);
    if circumradius <= radius {
        return vec![Disc { x: middle.x, y: middle.y, radius: circumradius }];
    }
    let disc = |index: usize| {
        let along = (index as f64 + 0.5) * spacing - longer / 2.0;
        let offset =
            if size.x >= size.y { Vector::new(along, 0.0) } else { Vector::new(0.0, along) };
        let center = middle + offset;
        Disc { x: center.x, y: center.y, radius }
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
