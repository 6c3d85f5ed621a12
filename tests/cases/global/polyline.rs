//! Arc lengths, directions and projections of a polyline.

use inbye::geometry::{Point, Vector};
use inbye::global::Path;

fn corner() -> Path {
    Path::new(
        [(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(|(x, y)| Point::new(x, y)).to_vec(),
    )
}

#[test]
fn path_arc_lengths_continue_around_a_corner() {
    let path = corner();
    assert_eq!(path.points().len(), 3, "the repeated point is removed");
    assert_eq!(path.length_m(), 5.0);
    assert_eq!(path.point_at(2.0), Point::new(2.0, 0.0));
    assert_eq!(path.point_at(3.0), Point::new(2.0, 1.0));
    assert_eq!(path.point_at(-1.0), Point::new(0.0, 0.0));
    assert_eq!(path.point_at(9.0), Point::new(2.0, 3.0));
    assert_eq!(path.turns(), 1);
}

#[test]
fn path_directions_and_samples_follow_a_corner() {
    let path = corner();
    assert_eq!(path.direction_at(1.0), Vector::new(1.0, 0.0));
    assert_eq!(path.direction_at(4.0), Vector::new(0.0, 1.0));
    assert_eq!(path.samples(1.0).count(), 6);
    let single = Path::new(vec![Point::new(1.0, 1.0)]);
    assert_eq!(single.point_at(0.5), Point::new(1.0, 1.0));
    assert_eq!(single.direction_at(0.5), Vector::ZERO);
}

#[test]
fn projection_stays_within_its_range() {
    let path = corner();
    let near_start = Point::new(0.5, 1.0);
    let nearest = path.project(&near_start);
    assert_eq!((nearest.arc_m, nearest.point), (0.5, Point::new(0.5, 0.0)));
    let later = path.project_within(&near_start, 1.5..5.0);
    assert_eq!((later.arc_m, later.point), (1.5, Point::new(1.5, 0.0)));
}

#[test]
fn projection_ignores_points_with_equal_arc_lengths() {
    let nearly = f64::from_bits(100_f64.to_bits() + 1);
    let mut points = corner().points().to_vec();
    points.extend(
        [(100.0, 3.0), (100.0, f64::from_bits(3_f64.to_bits() + 1)), (nearly, 3.0)]
            .map(|(x, y)| Point::new(x, y)),
    );
    let path = Path::new(points);
    let found = path.project_within(&Point::new(0.0, 0.0), 4.0..path.length_m());
    assert_eq!((found.arc_m, found.point), (4.0, Point::new(2.0, 2.0)));
}
