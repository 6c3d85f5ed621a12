//! Perception over the log of a real robot: what counts as moving, and how long a mark outlasts its obstacle.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::percentiles;
use crate::geometry::{Point, Pose, bearing};
use crate::lidar_log::{LidarLog, LogFormat};
use crate::map::{Cell, FreeSpace, GridFrame, MovingDisc, ObstacleGrid, Scan, UnknownPolicy};
use crate::mapping::{MappingError, log_scans, map_log};
use crate::navigator::{ObstacleModel, measures_beyond};

/// Motion is not seen over a longer time between two scans, seconds.
const LONGEST_GAP_S: f64 = 1.0;
/// Discs of two scans within this distance are one obstacle, metres.
const SAME_M: f64 = 0.6;
/// Returns within this distance of a disc are those of the obstacle, metres.
const OWN_M: f64 = 0.1;
/// Returns within this distance of a surface of the map belong to it, metres.
const SURFACE_M: f64 = 0.1;
/// Marks beyond this distance are not judged, metres: a lidar of one beam per degree has three beams on a cell there.
const JUDGED_M: f64 = 6.0;
/// Beams go past a mark if they end this far behind it, metres.
const PAST_M: f64 = 0.07;
/// A mark that beams have gone past for this long is late, seconds.
const LATE_S: f64 = 0.5;

/// What the obstacle model made of a log, with the poses that `inbye map` finds.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct LogPerception {
    /// Format of the log.
    pub format: LogFormat,
    /// Number of scans.
    pub scans: usize,
    /// Time in which scans follow each other within a second, seconds. Rates count this time.
    pub tracked_s: f64,
    /// Share of beams without a measurement.
    pub unmeasured: f64,
    /// With an empty map: every surface is an unknown obstacle.
    pub unknown: Perceived,
    /// With the map of the whole log.
    pub mapped: Perceived,
}

/// What was perceived with one map. Figures are null where there is nothing to count.
#[derive(Clone, Debug, Default, Serialize)]
#[non_exhaustive]
pub struct Perceived {
    /// Obstacles that counted as moving.
    pub moving: usize,
    /// Of these, obstacles whose returns mostly lie on surfaces of the map of the whole log.
    pub on_surfaces: usize,
    /// Moving obstacles per minute.
    pub moving_per_min: Option<f64>,
    /// Sum of the times for which obstacles counted as moving, seconds.
    pub moving_s: f64,
    /// Marked cells, mean over the scans.
    pub marks: f64,
    /// Marks that went after beams had gone past them.
    pub cleared: usize,
    /// Marks that beams had gone past for over half a second at the end.
    pub late: usize,
    /// Median and 90th percentile of the time for which beams went past a mark before it went, seconds. Late marks count.
    pub clear_s: [Option<f64>; 2],
    /// Share of these times up to half a second.
    pub cleared_in_time: Option<f64>,
    /// Median and 99th percentile of the time per scan, microseconds.
    pub scan_us: [Option<f64>; 2],
}

/// Perceives the scans of a log. Its map and poses are those of [`map_log`]. `clock` returns seconds and serves the times per scan
/// alone.
///
/// # Errors
/// As [`map_log`].
pub fn perceive_log(
    log: &LidarLog,
    clock: &mut dyn FnMut() -> f64,
) -> Result<LogPerception, MappingError> {
    let mapped = map_log(log, &mut || ())?;
    let surfaces = mapped.map.obstacles(UnknownPolicy::Free);
    let nothing = ObstacleGrid::filled(*surfaces.frame(), false);
    let mut last_s = None;
    let scans: Vec<PlacedScan> = log_scans(log)
        .iter()
        .filter_map(|scan| {
            let logged = log.records[scan.record].scan.as_ref()?;
            let (time_s, pose) = (log.records[scan.record].time_s, mapped.poses[scan.record]?);
            let gap_s = last_s.replace(time_s).map_or(0.0, |last_s| time_s - last_s);
            let is_short = (0.0..=LONGEST_GAP_S).contains(&gap_s);
            Some(PlacedScan {
                time_s,
                gap_s: if is_short { gap_s } else { 0.0 },
                pose,
                scan: scan.scan.to_scan(logged.beams.beams.len()),
            })
        })
        .collect();
    let beams = log.records.iter().filter_map(|record| record.scan.as_ref());
    let (mut all, mut unmeasured) = (0, 0);
    for beam in beams.flat_map(|scan| &scan.beams.beams) {
        all += 1;
        unmeasured += usize::from(beam.range.is_nan());
    }
    let far = FreeSpace::new(&surfaces, SURFACE_M);
    let mut perceived = |map: ObstacleGrid| perceive(&scans, map, &surfaces, &far, clock);
    Ok(LogPerception {
        format: log.format,
        scans: scans.len(),
        tracked_s: tracked_s(&scans),
        unmeasured: unmeasured as f64 / all.max(1) as f64,
        unknown: perceived(nothing),
        mapped: perceived(surfaces.clone()),
    })
}

/// A scan in the robot's frame, with the robot's pose.
struct PlacedScan {
    time_s: f64,
    /// Time since the scan before, seconds; zero where motion is not seen.
    gap_s: f64,
    pose: Pose,
    scan: Scan,
}

/// Time in which motion is seen, seconds.
fn tracked_s(scans: &[PlacedScan]) -> f64 {
    scans.iter().map(|scan| scan.gap_s).sum()
}

/// A moving obstacle of the last scan, with the numbers of its returns so far.
struct Followed {
    disc: MovingDisc,
    returns: usize,
    on_surfaces: usize,
}

impl Followed {
    fn is_on_surfaces(&self) -> bool {
        2 * self.on_surfaces > self.returns
    }
}

fn perceive(
    scans: &[PlacedScan],
    map: ObstacleGrid,
    surfaces: &ObstacleGrid,
    far_from_surfaces: &FreeSpace,
    clock: &mut dyn FnMut() -> f64,
) -> Perceived {
    let mut model = ObstacleModel::new(map);
    let mut perceived = Perceived::default();
    let mut followed: Vec<Followed> = Vec::new();
    let mut marks = MarkTimes::default();
    let mut times_us = Vec::with_capacity(scans.len());
    for PlacedScan { time_s, gap_s, pose, scan } in scans {
        let before_s = clock();
        model.update(*time_s, pose, scan);
        times_us.push((clock() - before_s) * 1e6);
        let returns: Vec<Point> = scan.hits(pose).collect();
        let now: Vec<Followed> = model
            .moving()
            .iter()
            .map(|disc| {
                let is_same =
                    |older: &Followed| (older.disc.center() - disc.center()).norm() < SAME_M;
                let older =
                    followed.iter().position(is_same).map(|place| followed.swap_remove(place));
                perceived.moving += usize::from(older.is_none());
                let (mut count, mut on_surfaces) =
                    older.map_or((0, 0), |older| (older.returns, older.on_surfaces));
                let is_own = |point: &&Point| (*point - disc.center()).norm() < disc.radius + OWN_M;
                for point in returns.iter().filter(is_own) {
                    let cell = surfaces.frame().cell_of(point);
                    count += 1;
                    on_surfaces +=
                        usize::from(cell.is_some_and(|cell| !far_from_surfaces.is_free(cell)));
                }
                Followed { disc: *disc, returns: count, on_surfaces }
            })
            .collect();
        perceived.moving_s += gap_s * now.len() as f64;
        perceived.on_surfaces += followed.iter().filter(|gone| gone.is_on_surfaces()).count();
        followed = now;
        perceived.marks += model.marks().count() as f64 / scans.len() as f64;
        marks.update(*gap_s, pose, scan, surfaces.frame(), model.marks());
    }
    perceived.on_surfaces += followed.iter().filter(|gone| gone.is_on_surfaces()).count();
    let past_s = marks.past_s.into_values().flatten();
    let late: Vec<f64> = past_s.filter(|past_s| *past_s > LATE_S).collect();
    perceived.cleared = marks.cleared_s.len();
    perceived.late = late.len();
    let mut all_s = marks.cleared_s;
    all_s.extend(late);
    let in_time = all_s.iter().filter(|clear_s| **clear_s <= LATE_S).count();
    perceived.cleared_in_time = (!all_s.is_empty()).then(|| in_time as f64 / all_s.len() as f64);
    perceived.clear_s = percentiles(all_s, [0.5, 0.9]);
    perceived.scan_us = percentiles(times_us, [0.5, 0.99]);
    let tracked_s = tracked_s(scans);
    perceived.moving_per_min =
        (tracked_s > 0.0).then(|| perceived.moving as f64 * 60.0 / tracked_s);
    perceived
}

/// For how long beams have gone past each mark, seconds; none where they have not yet.
#[derive(Default)]
struct MarkTimes {
    past_s: BTreeMap<Cell, Option<f64>>,
    cleared_s: Vec<f64>,
}

impl MarkTimes {
    /// Updates the times with a scan and the marks after it. A return in the cell or next to it begins the time again.
    fn update(
        &mut self,
        gap_s: f64,
        pose: &Pose,
        scan: &Scan,
        frame: &GridFrame,
        marks: impl Iterator<Item = Point>,
    ) {
        let hit: BTreeSet<Cell> =
            scan.hits(pose).filter_map(|point| frame.cell_of(&point)).collect();
        let is_past = |cell: Cell| {
            let around = |column| (-1..=1).map(move |row| (column, row));
            let is_hit = (-1..=1).flat_map(around).any(|(column, row)| {
                hit.contains(&Cell::new(cell.column + column, cell.row + row))
            });
            (!is_hit).then(|| beams_pass(pose, scan, &frame.center_of(cell), frame.resolution_m))
        };
        let mut before = std::mem::take(&mut self.past_s);
        for cell in marks.filter_map(|mark| frame.cell_of(&mark)) {
            let past_s = before.remove(&cell).flatten();
            let past_s = match (is_past(cell), past_s) {
                (None, _) => None,
                (Some(false), past_s) => past_s,
                (Some(true), past_s) => Some(past_s.map_or(0.0, |past_s| past_s + gap_s)),
            };
            self.past_s.insert(cell, past_s);
        }
        // What remains has gone with this scan. A return next to it has another mark.
        for (cell, past_s) in before {
            if is_past(cell) == Some(true) {
                self.cleared_s.push(past_s.map_or(0.0, |past_s| past_s + gap_s));
            }
        }
    }
}

/// Whether all measured beams towards a cell end behind it; at least half are measured.
fn beams_pass(pose: &Pose, scan: &Scan, cell: &Point, side_m: f64) -> bool {
    let lidar = pose.transform(&scan.origin);
    let distance_m = (cell - lidar).norm();
    let half_angle = side_m / 2.0 / distance_m;
    (side_m..JUDGED_M).contains(&distance_m)
        && measures_beyond(pose, scan, bearing(&lidar, cell), half_angle, distance_m + PAST_M)
}
