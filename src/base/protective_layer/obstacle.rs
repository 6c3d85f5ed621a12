//! Which returns count as an obstacle, and which ones as dust.
//!
//! A grain of dust returns one beam. In dusty air each scan has many of them, and some are always near the robot. A surface returns
//! beams next to each other.

use super::raw_scan::RawPoint;

/// Returns within this distance of each other belong to one obstacle, metres, such as the two legs of a person.
const TOGETHER_M: f64 = 0.3;
/// The same distance near the lidar, as a share of the range: a surface there returns many beams close to each other, and grains are
/// many there.
const TOGETHER_SHARE: f64 = 0.15;
/// The same distance for a lidar with few beams, in distances between two beams.
const TOGETHER_BEAMS: f64 = 3.0;

/// A return of the same obstacle may be this far away from one at a range, metres, for a lidar with an angle between two beams, radians.
pub(super) fn together_m(range_m: f64, increment: f64) -> f64 {
    TOGETHER_M.min(TOGETHER_SHARE * range_m).max(TOGETHER_BEAMS * increment * range_m)
}

/// A return of an obstacle, if there is one: some of the points, near to each other, stand for enough returns.
pub(super) fn obstacle_return<'a>(
    points: impl Iterator<Item = &'a RawPoint>,
    min_points: usize,
) -> Option<&'a RawPoint> {
    let mut counted: Vec<(&RawPoint, usize)> = Vec::new();
    for point in points {
        let mut count = point.beams;
        for (other, others) in &mut counted {
            if are_together(point, other) {
                *others += point.beams;
                count += other.beams;
                if *others >= min_points {
                    return Some(other);
                }
            }
        }
        if count >= min_points {
            return Some(point);
        }
        counted.push((point, count));
    }
    None
}

/// The return of an obstacle that is the nearest to the body.
pub(super) fn nearest_obstacle_return<'a>(
    points: impl Iterator<Item = &'a RawPoint>,
    min_points: usize,
) -> Option<&'a RawPoint> {
    let mut points: Vec<&RawPoint> = points.collect();
    points.sort_by(|one, other| one.gap_m.total_cmp(&other.gap_m));
    let count = |point: &RawPoint| -> usize {
        let together = points.iter().filter(|other| are_together(point, other));
        together.map(|other| other.beams).sum()
    };
    points.iter().copied().find(|point| count(point) >= min_points)
}

fn are_together(one: &RawPoint, other: &RawPoint) -> bool {
    (one.place - other.place).norm() <= one.together_m.max(other.together_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn point(x: f64, y: f64) -> RawPoint {
        let place = Point::new(x, y);
        RawPoint { place, moves: false, gap_m: x, beams: 1, together_m: 0.3 }
    }

    #[test]
    fn grains_apart_are_no_obstacle() {
        let grains = [point(0.5, 0.0), point(0.5, 0.4), point(0.5, -0.4), point(1.0, 0.0)];
        assert_eq!(obstacle_return(grains.iter(), 2), None);
        assert_eq!(nearest_obstacle_return(grains.iter(), 2), None);
        assert_eq!(nearest_obstacle_return(grains.iter(), 1), Some(&grains[0]));
        // The beams of a coarse lidar are farther apart.
        let coarse = grains.map(|point| RawPoint { together_m: 0.4, ..point });
        assert_eq!(obstacle_return(coarse.iter(), 2), Some(&coarse[0]));
    }

    /// A wall behind a grain. The returns at its middle have the most neighbours.
    #[test]
    fn returns_next_to_each_other_are_an_obstacle() {
        let wall = (0..9).map(|index| point(1.0, 0.09 * f64::from(index)));
        let all: Vec<RawPoint> = core::iter::once(point(0.2, 0.0)).chain(wall).collect();
        for (min_points, is_obstacle) in [(2, true), (7, true), (8, false)] {
            let found = obstacle_return(all.iter(), min_points);
            assert_eq!(found.is_some(), is_obstacle, "{min_points} of {found:?}");
            let nearest = nearest_obstacle_return(all.iter(), min_points);
            assert_eq!(nearest.is_some(), is_obstacle, "{min_points} of {nearest:?}");
        }
        let dense = [RawPoint { beams: 3, ..point(0.5, 0.0) }];
        assert_eq!(obstacle_return(dense.iter(), 3), Some(&dense[0]));
        assert_eq!(nearest_obstacle_return(dense.iter(), 4), None);
    }
}
