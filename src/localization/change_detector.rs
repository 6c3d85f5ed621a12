//! What scans contradict in the map for minutes: obstacles that appeared, and obstacles that vanished.
//!
//! A return far from every mapped surface speaks for a new obstacle, and a beam that passes steeply through a mapped cell, without
//! a return near it, for one that is gone. The opposite speaks for the map. People pass and doors move: only what is contradicted
//! over a minute, and agreed with hardly ever, is a change.

use std::collections::BTreeSet;

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
/// A wall goes as a whole: fewer scans suffice for a cell next to one that is gone.
const MIN_SCANS_BESIDE: u32 = 5;
/// A beam passes a cell if it ends farther than this and a cell beyond it, metres: pose, range and map err.
const BEYOND_M: f64 = 0.1;
/// Least cosine of the angle between a beam and the normal of a mapped surface. Along a wall a small error of the pose leads a beam
/// through it.
const MIN_COSINE: f64 = 0.5;
/// Largest number of cells with evidence, and the number that noise and people cause.
const MAX_CELLS: usize = 1_000_000;
const EXPECTED_CELLS: usize = 4096;

/// What the scans showed of a cell that contradicts the map or did so.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    cell: u32,
    first_s: f64,
    last_s: f64,
    against_map: u32,
    for_map: u32,
}

impl Evidence {
    /// Whether at least this many scans contradict the map, and hardly any agree with it.
    fn is_against_map(&self, min_scans: u32) -> bool {
        let all = f64::from(self.against_map + self.for_map);
        self.against_map >= min_scans && f64::from(self.for_map) <= MAX_AGREEING * all
    }

    fn is_change(&self) -> bool {
        self.last_s - self.first_s >= CHANGED_S && self.is_against_map(MIN_SCANS)
    }
}

/// Collects the evidence of scans whose pose is certain. Once it is warm, it allocates only where more cells have evidence than ever
/// before.
#[derive(Clone, Debug)]
pub(super) struct ChangeDetector {
    evidence: Vec<Evidence>,
    /// Place of each cell's evidence plus one, or zero. So the operating system never allocates the pages of an area without any.
    slots: Vec<u32>,
    used_s: f64,
    /// Cells that beams of the scan end in, and that they pass, in the order of their indices.
    hit: Vec<u32>,
    passed: Vec<u32>,
}

impl ChangeDetector {
    /// A detector without evidence.
    pub fn new(map: &SignedDistanceField) -> Self {
        Self {
            evidence: Vec::with_capacity(EXPECTED_CELLS),
            slots: vec![0; map.frame.len()],
            used_s: f64::NEG_INFINITY,
            hit: Vec::new(),
            passed: Vec::new(),
        }
    }

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
        let (mut hit, mut passed) =
            (core::mem::take(&mut self.hit), core::mem::take(&mut self.passed));
        let ends = scan.hits.iter().map(|hit| pose.transform(&hit.end));
        replace(&mut hit, ends.filter_map(|end| cell_at(&map.frame, &end)));
        self.find_passed(map, scan, pose, &mut passed);
        let is_hit = |cell: u32| hit.binary_search(&cell).is_ok();
        for &cell in &hit {
            if map.of_cell_m(cell as usize) > near_m {
                self.contradict(cell, scan.time_s);
            }
        }
        for &cell in passed.iter().filter(|cell| !is_hit(**cell)) {
            let is_mapped = map.is_mapped(cell as usize);
            if !is_mapped {
                self.agree(cell);
            } else if !neighbours(&map.frame, cell).any(is_hit) {
                self.contradict(cell, scan.time_s);
            }
        }
        for cell in hit.iter().flat_map(|&cell| neighbours(&map.frame, cell)) {
            if map.is_mapped(cell as usize) {
                self.agree(cell);
            }
        }
        (self.hit, self.passed) = (hit, passed);
    }

    /// Finds the mapped cells that beams pass steeply, and those with evidence of a new obstacle that they pass.
    fn find_passed(
        &self,
        map: &SignedDistanceField,
        scan: &DeskewedScan,
        pose: &Pose,
        passed: &mut Vec<u32>,
    ) {
        let resolution_m = map.frame.resolution_m;
        let beyond_m = BEYOND_M + resolution_m;
        let closed = scan.hits.iter().map(|hit| (hit.from, (hit.end - hit.from)));
        let open = scan.open.iter().map(|ray| (ray.from, ray.direction * scan.range_max));
        passed.clear();
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
                let is_mapped = map.is_mapped(index as usize);
                let counts = if is_mapped {
                    is_steep(map, cell, &direction)
                } else {
                    self.slots[index as usize] != 0
                };
                if counts {
                    passed.push(index);
                }
            }
        }
        passed.sort_unstable();
        passed.dedup();
    }

    fn contradict(&mut self, cell: u32, time_s: f64) {
        let slot = &mut self.slots[cell as usize];
        if *slot == 0 {
            if self.evidence.len() >= MAX_CELLS {
                return;
            }
            let new =
                Evidence { cell, first_s: time_s, last_s: time_s, against_map: 0, for_map: 0 };
            self.evidence.push(new);
            *slot = self.evidence.len() as u32;
        }
        let evidence = &mut self.evidence[*slot as usize - 1];
        evidence.last_s = time_s;
        evidence.against_map += 1;
    }

    /// Evidence for the map. A cell that agrees more often than not has no evidence left: the next contradiction starts from zero.
    fn agree(&mut self, cell: u32) {
        let Some(place) = (self.slots[cell as usize] as usize).checked_sub(1) else {
            return;
        };
        let evidence = &mut self.evidence[place];
        evidence.for_map += 1;
        if evidence.for_map > evidence.against_map {
            self.evidence.swap_remove(place);
            self.slots[cell as usize] = 0;
            if let Some(moved) = self.evidence.get(place) {
                self.slots[moved.cell as usize] = place as u32 + 1;
            }
        }
    }

    /// The cells that changed, in the order of their indices, in the map of the detector.
    pub fn changed(&self, map: &SignedDistanceField) -> Vec<u32> {
        let changed = self.evidence.iter().filter(|evidence| evidence.is_change());
        let mut cells: BTreeSet<u32> = changed.map(|evidence| evidence.cell).collect();
        // Far away the beams leave gaps: of a wall that is gone, single cells would stay for a while.
        let is_mapped = |cell: &u32| map.is_mapped(*cell as usize);
        let mut open: Vec<u32> = cells.iter().copied().filter(is_mapped).collect();
        while let Some(cell) = open.pop() {
            for beside in neighbours(&map.frame, cell) {
                let is_against_map =
                    |evidence: &Evidence| evidence.is_against_map(MIN_SCANS_BESIDE);
                let is_gone =
                    is_mapped(&beside) && self.evidence_of(beside).is_some_and(is_against_map);
                if is_gone && cells.insert(beside) {
                    open.push(beside);
                }
            }
        }
        cells.into_iter().collect()
    }

    fn evidence_of(&self, cell: u32) -> Option<&Evidence> {
        self.evidence.get((self.slots[cell as usize] as usize).checked_sub(1)?)
    }
}

/// Replaces the contents by these cells in the order of their indices, each once.
fn replace(cells: &mut Vec<u32>, new: impl Iterator<Item = u32>) {
    cells.clear();
    cells.extend(new);
    cells.sort_unstable();
    cells.dedup();
}

/// Whether a direction crosses the surface of a mapped obstacle steeply. In the middle of a thin wall the distance has a ridge, so
/// the larger difference to both neighbours counts.
fn is_steep(map: &SignedDistanceField, cell: Cell, direction: &Vector) -> bool {
    let Cell { column, row } = cell;
    let slope = |before: Option<f64>, after: Option<f64>| {
        let here = map.of_cell_m(map.frame.index(cell));
        let [before, after] = [before.map(|it| here - it), after.map(|it| it - here)];
        let larger = |one: f64, other: f64| if other.abs() > one.abs() { other } else { one };
        larger(before.unwrap_or(0.0), after.unwrap_or(0.0)) / map.frame.resolution_m
    };
    let x = slope(map.distance_in_cell_m(column - 1, row), map.distance_in_cell_m(column + 1, row));
    let y = slope(map.distance_in_cell_m(column, row - 1), map.distance_in_cell_m(column, row + 1));
    (direction.x * x + direction.y * y).abs() >= MIN_COSINE * libm::hypot(x, y)
}

fn cell_at(frame: &GridFrame, point: &Point) -> Option<u32> {
    let units = Point::new(point.x / frame.resolution_m, point.y / frame.resolution_m);
    frame.cell_at_units(&units).map(|cell| frame.index(cell) as u32)
}

/// A cell and the eight around it.
fn neighbours(frame: &GridFrame, cell: u32) -> impl Iterator<Item = u32> + use<> {
    let frame = *frame;
    let cells = frame.cell_at(cell as usize).with_neighbours();
    cells.filter(move |cell| frame.contains(*cell)).map(move |cell| frame.index(cell) as u32)
}
