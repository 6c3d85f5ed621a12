//! What scans contradict in the map for minutes: obstacles that appeared, and obstacles that vanished.
//!
//! A return far from every mapped surface speaks for a new obstacle, and a beam that passes steeply through a mapped cell, without
//! a return near it, for one that is gone. The opposite speaks for the map. People pass and doors move: only what is contradicted
//! over a minute, and agreed with hardly ever, is a change.

use std::collections::{BTreeMap, BTreeSet};

use super::DeskewedScan;
use super::signed_distance_field::SignedDistanceField;
use crate::geometry::{Point, Pose, Vector};
use crate::map::{Cell, GridFrame, GridRay};

/// Time between two scans that count, seconds.
const INTERVAL_S: f64 = 0.5;
/// A cell changed if scans over this time contradict the map, seconds; if they are at least this many; and if at most this share of
/// those that show the cell agree with the map.
const CHANGED_S: f64 = 60.0;
const MIN_SCANS: u32 = 20;
const MAX_AGREEING: f64 = 0.2;
/// A beam passes a cell if it ends farther than this and a cell beyond it, metres: pose, range and map err.
const BEYOND_M: f64 = 0.1;
/// Least cosine of the angle between a beam and the normal of a mapped surface. Along a wall a small error of the pose leads a beam
/// through it.
const MIN_COSINE: f64 = 0.5;
/// Largest number of cells with evidence.
const MAX_CELLS: usize = 1_000_000;

/// What the scans showed of a cell that contradicts the map or did so.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    first_s: f64,
    last_s: f64,
    against_map: u32,
    for_map: u32,
}

impl Evidence {
    fn is_change(&self) -> bool {
        let all = f64::from(self.against_map + self.for_map);
        self.last_s - self.first_s >= CHANGED_S
            && self.against_map >= MIN_SCANS
            && f64::from(self.for_map) <= MAX_AGREEING * all
    }
}

/// Collects the evidence of scans whose pose is certain.
#[derive(Clone, Debug)]
pub(super) struct ChangeDetector {
    /// By the index of the cell, so that the order is that of the cells.
    evidence: BTreeMap<u32, Evidence>,
    used_s: f64,
}

impl Default for ChangeDetector {
    fn default() -> Self {
        Self { evidence: BTreeMap::new(), used_s: f64::NEG_INFINITY }
    }
}

impl ChangeDetector {
    /// Takes a scan from a pose in the grid's frame. A return farther than this from every mapped surface, metres, belongs to none.
    pub fn update(
        &mut self,
        map: &SignedDistanceField,
        scan: &DeskewedScan,
        pose: &Pose,
        near_m: f64,
    ) {
        let since_s = scan.time_s - self.used_s;
        if (0.0..INTERVAL_S).contains(&since_s) {
            return;
        }
        self.used_s = scan.time_s;
        let cell_of = |point: &Point| cell_at(&map.frame, point);
        let ends = scan.hits.iter().map(|hit| pose.transform(&hit.end));
        let hit: BTreeSet<u32> = ends.filter_map(|end| cell_of(&end)).collect();
        let passed = self.passed(map, scan, pose);
        for &cell in &hit {
            if map.of_cell_m(cell as usize) > near_m {
                self.contradict(cell, scan.time_s);
            }
        }
        for &cell in passed.difference(&hit) {
            let is_mapped = map.of_cell_m(cell as usize) < 0.0;
            if !is_mapped {
                self.agree(cell);
            } else if !neighbours(&map.frame, cell).any(|beside| hit.contains(&beside)) {
                self.contradict(cell, scan.time_s);
            }
        }
        for cell in hit.iter().flat_map(|&cell| neighbours(&map.frame, cell)) {
            if map.of_cell_m(cell as usize) < 0.0 {
                self.agree(cell);
            }
        }
    }

    /// The mapped cells that beams pass steeply, and those with evidence of a new obstacle that they pass.
    fn passed(&self, map: &SignedDistanceField, scan: &DeskewedScan, pose: &Pose) -> BTreeSet<u32> {
        let resolution_m = map.frame.resolution_m;
        let beyond_m = BEYOND_M + resolution_m;
        let closed = scan.hits.iter().map(|hit| (hit.from, (hit.end - hit.from)));
        let open = scan.open.iter().map(|ray| (ray.from, ray.direction * scan.range_max));
        let mut passed = BTreeSet::new();
        for (from, along) in closed.chain(open) {
            let length_m = along.norm();
            if length_m <= beyond_m {
                continue;
            }
            let Point { x, y } = pose.transform(&from);
            let start = Point::new(x / resolution_m, y / resolution_m);
            let (sin, cos) = libm::sincos(pose.yaw);
            let direction =
                Vector::new(cos * along.x - sin * along.y, sin * along.x + cos * along.y)
                    / length_m;
            let until = (length_m - beyond_m) / resolution_m;
            for (cell, entered) in GridRay::new(&start, &direction) {
                if entered > until || !map.frame.contains(cell) {
                    break;
                }
                let index = map.frame.index(cell) as u32;
                let is_mapped = map.of_cell_m(index as usize) < 0.0;
                let counts = if is_mapped {
                    is_steep(map, cell, &direction)
                } else {
                    self.evidence.contains_key(&index)
                };
                if counts {
                    passed.insert(index);
                }
            }
        }
        passed
    }

    fn contradict(&mut self, cell: u32, time_s: f64) {
        if self.evidence.len() >= MAX_CELLS && !self.evidence.contains_key(&cell) {
            return;
        }
        let new = Evidence { first_s: time_s, last_s: time_s, against_map: 0, for_map: 0 };
        let evidence = self.evidence.entry(cell).or_insert(new);
        evidence.last_s = time_s;
        evidence.against_map += 1;
    }

    /// Evidence for the map. A cell that agrees more often than not has no evidence left: the next contradiction starts from zero.
    fn agree(&mut self, cell: u32) {
        if let Some(evidence) = self.evidence.get_mut(&cell) {
            evidence.for_map += 1;
            if evidence.for_map > evidence.against_map {
                self.evidence.remove(&cell);
            }
        }
    }

    /// The cells that changed, in the order of their indices.
    pub fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        let changed = self.evidence.iter().filter(|(_, evidence)| evidence.is_change());
        changed.map(|(&cell, _)| cell)
    }
}

/// Whether a direction crosses the surface of a mapped obstacle steeply. In the middle of a thin wall the distance has a ridge, so
/// the larger difference to both neighbours counts.
fn is_steep(map: &SignedDistanceField, cell: Cell, direction: &Vector) -> bool {
    let Cell { column, row } = cell;
    let value = |column: i32, row: i32| {
        let cell = Cell::new(column, row);
        map.frame.contains(cell).then(|| map.of_cell_m(map.frame.index(cell)))
    };
    let slope = |before: Option<f64>, after: Option<f64>| {
        let here = map.of_cell_m(map.frame.index(cell));
        let [before, after] = [before.map(|it| here - it), after.map(|it| it - here)];
        let larger = |one: f64, other: f64| if other.abs() > one.abs() { other } else { one };
        larger(before.unwrap_or(0.0), after.unwrap_or(0.0)) / map.frame.resolution_m
    };
    let x = slope(value(column - 1, row), value(column + 1, row));
    let y = slope(value(column, row - 1), value(column, row + 1));
    (direction.x * x + direction.y * y).abs() >= MIN_COSINE * libm::hypot(x, y)
}

fn cell_at(frame: &GridFrame, point: &Point) -> Option<u32> {
    let units = Point::new(point.x / frame.resolution_m, point.y / frame.resolution_m);
    frame.cell_at_units(&units).map(|cell| frame.index(cell) as u32)
}

/// A cell and the eight around it.
fn neighbours(frame: &GridFrame, cell: u32) -> impl Iterator<Item = u32> + use<> {
    let (frame, at) = (*frame, frame.cell_at(cell as usize));
    let around = (-1..=1).flat_map(|up| (-1..=1).map(move |right| (right, up)));
    around
        .map(move |(right, up)| Cell::new(at.column + right, at.row + up))
        .filter(move |cell| frame.contains(*cell))
        .map(move |cell| frame.index(cell) as u32)
}
