//! Surface points with normals, from scans.

use crate::geometry::{Point, Pose, Vector};
use crate::localization::{DeskewedScan, DistanceSample, Hit, Surfaces};

/// Returns up to this range are matched, metres: farther beams are far apart from each other.
pub(super) const MATCHED_RANGE_M: f64 = 30.0;

/// A beam end belongs to a surface if a neighbour of the scan is within this distance of it, metres, plus this fraction of its
/// range.
const NEIGHBOUR_M: f64 = 0.1;
const NEIGHBOUR_FRACTION: f64 = 0.06;

/// Neighbours on each side that give the normal.
const SIDE: usize = 2;

/// A beam does not match a surface that it meets from behind, or at a smaller angle than this: sine.
const MIN_INCIDENCE: f64 = 0.08;

/// A beam end matches surface points up to this distance, metres: also the side of a cell of the index.
const REACH_M: f64 = 0.4;

/// A surface point stands for a straight piece of surface of this length to both sides, metres.
const TANGENT_M: f64 = 0.25;

/// A cell and those around it, by rows and columns: the near ones first.
const NEIGHBOURS: [(isize, isize); 9] =
    [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];

/// Far more than the rounding of a squared distance, square metres.
const ROUNDING_M2: f64 = 1e-9;

/// A point of a surface and its unit normal, towards the lidar that saw it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfel {
    pub point: Point,
    pub normal: Vector,
}

/// The surface points of a scan in the robot's frame. Beam ends without neighbours have no direction and give none.
pub(super) fn surfels(scan: &DeskewedScan) -> Vec<Surfel> {
    let range = |hit: &Hit| (hit.end - hit.from).norm();
    let hits = &scan.hits;
    let mut surfels = Vec::with_capacity(hits.len());
    for (index, hit) in hits.iter().enumerate() {
        let range_m = range(hit);
        if range_m > MATCHED_RANGE_M {
            continue;
        }
        let near_m = NEIGHBOUR_M + NEIGHBOUR_FRACTION * range_m;
        let is_near = |one: usize, other: usize| (hits[one].end - hits[other].end).norm() < near_m;
        let mut first = index;
        while first > 0 && index - first < SIDE && is_near(first, first - 1) {
            first -= 1;
        }
        let mut last = index;
        while last + 1 < hits.len() && last - index < SIDE && is_near(last, last + 1) {
            last += 1;
        }
        if last - first < SIDE {
            continue;
        }
        if let Some(normal) = normal(&hits[first..=last], &(hit.from - hit.end)) {
            surfels.push(Surfel { point: hit.end, normal });
        }
    }
    surfels
}

/// The normal of the line through points, towards a side; none if the points are no line.
fn normal(hits: &[Hit], towards: &Vector) -> Option<Vector> {
    let count = hits.len() as f64;
    let (mut x, mut y) = (0.0, 0.0);
    for hit in hits {
        (x, y) = (x + hit.end.x / count, y + hit.end.y / count);
    }
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for hit in hits {
        let (dx, dy) = (hit.end.x - x, hit.end.y - y);
        (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
    }
    // Eigenvalues of the covariance: a line is much longer than wide.
    let (mean, half) = (f64::midpoint(xx, yy), (xx - yy) / 2.0);
    let root = (half * half + xy * xy).sqrt();
    if mean - root > 0.15 * (mean + root) {
        return None;
    }
    let angle = 0.5 * libm::atan2(2.0 * xy, xx - yy);
    let (sin, cos) = libm::sincos(angle);
    let normal = Vector::new(-sin, cos);
    Some(if normal.dot(towards) < 0.0 { normal * -1.0 } else { normal })
}

/// Surface points with an index of their places.
pub(super) struct SurfelMap {
    surfels: Vec<Surfel>,
    /// Corner of the first cell, and numbers of columns and rows.
    corner: Point,
    columns: usize,
    rows: usize,
    /// First surfel of each cell, in row-major order, and one entry more.
    starts: Vec<u32>,
}

impl SurfelMap {
    /// The points of several scans at their poses.
    pub fn new<'a>(scans: impl Iterator<Item = (Pose, &'a [Surfel])>) -> Self {
        let mut all = Vec::new();
        for (pose, surfels) in scans {
            let turn = Pose::new(0.0, 0.0, pose.yaw);
            all.extend(surfels.iter().map(|surfel| Surfel {
                point: pose.transform(&surfel.point),
                normal: turn.transform(&Point::new(surfel.normal.x, surfel.normal.y)).to_vector(),
            }));
        }
        let low = |of: fn(&Surfel) -> f64| all.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = |of: fn(&Surfel) -> f64| all.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        if all.is_empty() {
            let corner = Point::default();
            return Self { surfels: all, corner, columns: 0, rows: 0, starts: vec![0] };
        }
        let corner = Point::new(low(|it| it.point.x), low(|it| it.point.y));
        let cells = |most: f64, least: f64| ((most - least) / REACH_M).floor() as usize + 1;
        let columns = cells(high(|it| it.point.x), corner.x);
        let rows = cells(high(|it| it.point.y), corner.y);
        let cell = |point: &Point| {
            let column = ((point.x - corner.x) / REACH_M) as usize;
            let row = ((point.y - corner.y) / REACH_M) as usize;
            row * columns + column
        };
        let mut starts = vec![0_u32; columns * rows + 1];
        for surfel in &all {
            starts[cell(&surfel.point) + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut next = starts.clone();
        let mut sorted = all.clone();
        for surfel in &all {
            let place = &mut next[cell(&surfel.point)];
            sorted[*place as usize] = *surfel;
            *place += 1;
        }
        Self { surfels: sorted, corner, columns, rows, starts }
    }

    /// All points.
    pub fn surfels(&self) -> &[Surfel] {
        &self.surfels
    }
}

impl Surfaces for SurfelMap {
    fn resolution_m(&self) -> f64 {
        0.0
    }

    fn sample(&self, x: f64, y: f64, from_robot: (f64, f64)) -> Option<DistanceSample> {
        let (column, row) = ((x - self.corner.x) / REACH_M, (y - self.corner.y) / REACH_M);
        let is_near = column > -1.0
            && row > -1.0
            && column < self.columns as f64 + 1.0
            && row < self.rows as f64 + 1.0;
        if !is_near {
            return None;
        }
        let (left, low) = (column.floor(), row.floor());
        let (within_column, within_row) = (column - left, row - low);
        let range_m = libm::hypot(from_robot.0, from_robot.1);
        let (mut nearest, mut nearest2) = (None, REACH_M * REACH_M);
        // The nearest cells first: their points leave few of the others to look at.
        for (up, right) in NEIGHBOURS {
            let (column, row) = (left as isize + right, low as isize + up);
            let is_inside = (0..self.columns as isize).contains(&column)
                && (0..self.rows as isize).contains(&row);
            let (dx, dy) = (cells_away(within_column, right), cells_away(within_row, up));
            if !is_inside || (dx * dx + dy * dy) * (REACH_M * REACH_M) > nearest2 + ROUNDING_M2 {
                continue;
            }
            let cell = row as usize * self.columns + column as usize;
            let (from, to) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
            for surfel in &self.surfels[from..to] {
                let (dx, dy) = (x - surfel.point.x, y - surfel.point.y);
                let far2 = dx * dx + dy * dy;
                let facing = from_robot.0 * surfel.normal.x + from_robot.1 * surfel.normal.y;
                if far2 < nearest2 && facing < -MIN_INCIDENCE * range_m {
                    (nearest, nearest2) = (Some(surfel), far2);
                }
            }
        }
        let surfel = nearest?;
        let Vector { x: nx, y: ny } = surfel.normal;
        let (dx, dy) = (x - surfel.point.x, y - surfel.point.y);
        let along = dx * ny - dy * nx;
        (along.abs() <= TANGENT_M)
            .then_some(DistanceSample { distance_m: dx * nx + dy * ny, gradient: [nx, ny] })
    }
}

/// Distance along an axis from a place within a cell, 0 to 1, to a cell before, at or behind it, cells.
fn cells_away(within: f64, step: isize) -> f64 {
    match step {
        0 => 0.0,
        1 => 1.0 - within,
        _ => within,
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// A wall at x = 2 seen from the origin.
    fn wall() -> DeskewedScan {
        let hit = |step: i32| Hit {
            from: Point::default(),
            end: Point::new(2.0, 0.05 * f64::from(step)),
            is_alone: false,
        };
        DeskewedScan { hits: (-20..=20).map(hit).collect(), range_max: 10.0, ..Default::default() }
    }

    #[test]
    fn distance_to_a_wall_is_signed_and_seen_from_one_side() {
        let surfels = surfels(&wall());
        assert_eq!(surfels.len(), 41);
        let map = SurfelMap::new([(Pose::new(1.0, 0.0, 0.0), &surfels[..])].into_iter());
        let sample = map.sample(2.9, 0.2, (1.9, 0.2)).expect("near the wall");
        assert!((sample.distance_m - 0.1).abs() < 1e-9, "{sample:?}");
        assert!((sample.gradient[0] + 1.0).abs() < 1e-9, "{sample:?}");
        assert!(map.sample(3.1, 0.0, (-1.9, 0.0)).is_none());
        assert!(map.sample(3.5, 0.0, (1.9, 0.0)).is_none());
        assert!(map.sample(2.9, 1.4, (1.9, 1.4)).is_none());
        assert!(map.sample(f64::NAN, 0.0, (1.0, 0.0)).is_none());
        let empty = SurfelMap::new(core::iter::empty());
        assert!(empty.sample(0.0, 0.0, (1.0, 0.0)).is_none());
    }

    #[test]
    fn sample_is_that_of_the_nearest_facing_point() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut within = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
        let some: Vec<Surfel> = (0..300)
            .map(|_| {
                let (y, x) = libm::sincos(within(3.0));
                Surfel { point: Point::new(within(2.0), within(2.0)), normal: Vector::new(x, y) }
            })
            .collect();
        let map = SurfelMap::new([(Pose::default(), &some[..])].into_iter());
        let mut found = 0;
        for _ in 0..2000 {
            let (x, y, robot) = (within(2.6), within(2.6), (within(3.0), within(3.0)));
            let range_m = libm::hypot(robot.0, robot.1);
            let far = |one: &Surfel| libm::hypot(x - one.point.x, y - one.point.y);
            let faces = |one: &&Surfel| {
                robot.0 * one.normal.x + robot.1 * one.normal.y < -MIN_INCIDENCE * range_m
            };
            let nearest = some.iter().filter(faces).min_by(|a, b| far(a).total_cmp(&far(b)));
            let along =
                |one: &Surfel| (x - one.point.x) * one.normal.y - (y - one.point.y) * one.normal.x;
            let matching = nearest
                .filter(|one| far(one) < REACH_M && along(one).abs() <= TANGENT_M)
                .map(|one| [one.normal.x, one.normal.y]);
            assert_eq!(map.sample(x, y, robot).map(|sample| sample.gradient), matching);
            found += u32::from(matching.is_some());
        }
        assert!(found > 200, "{found}");
    }

    #[test]
    fn single_beams_are_no_surface() {
        let hits = (0..9).map(|step| Hit {
            from: Point::default(),
            end: Point::new(2.0, f64::from(step)),
            is_alone: false,
        });
        let scan = DeskewedScan { hits: hits.collect(), range_max: 10.0, ..Default::default() };
        assert!(surfels(&scan).is_empty());
    }
}
