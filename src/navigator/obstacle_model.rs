//! Obstacles that are not in the map: marked cells where they are static, discs where they move.

use std::sync::Arc;

use super::new_objects::places_of_new_objects;
use super::passive_safety::obstacle_that_may_come;
use super::scan_visibility::{is_in_view, measures_beyond};
use super::tracker::{FARTHEST_M, Tracker};
use super::{NavigationMap, NavigatorSettings};
use crate::geometry::{Point, Pose, bearing};
use crate::local::{ClearanceField, ProblemError};
use crate::map::{Cell, FreeSpace, GridFrame, MovingDisc, ObstacleGrid, RayCaster, Scan};

/// A return within this distance of a moving obstacle belongs to it, metres.
const MOVING_MARGIN_M: f64 = 0.12;
/// Marks that a moving obstacle made before its motion was established are at most this much older than its track, seconds.
const BEFORE_TRACK_S: f64 = 0.05;
/// A return within this distance of a known obstacle belongs to it, metres: three standard deviations of range and pose.
const KNOWN_MARGIN_M: f64 = 0.06;
/// At most this many scans must see through a mark, beyond those that hit it, before it goes: beams that pass close to a thin
/// post must not make it flicker.
const MAX_EVIDENCE: u8 = 3;
/// Beams see through a mark if they go beyond it by this, metres, or by a cell if that is more.
const SEEN_THROUGH_M: f64 = 0.05;
/// A mark of one return that the scan cannot show again goes after this, seconds: a grain of dust outside the field of view must
/// not hold the robot.
const UNCONFIRMED_S: f64 = 3.0;
/// A mark that exists for this long is settled, seconds.
const SETTLED_S: f64 = 2.5;
/// Largest number of cells along a side of the local window: it takes two bytes per cell, and is built at each decision.
const MAX_WINDOW_CELLS: f64 = 4095.0;
const WINDOW_LIMIT: &str = "at most 4095 cells: lower sim_time_s or the highest of max_vel_x, min_vel_x and escape_speed, or use a \
    coarser map";
/// Marks are forgotten farther away from the robot than this, metres.
const FORGET_BEYOND_M: f64 = 1.0;
/// Larger cells of the map are divided in the local window, metres: a clearance is good to the diagonal of a part.
pub(super) const FIELD_CELL_M: f64 = 0.05;
/// As [`FIELD_CELL_M`], near narrow passages.
pub(super) const NARROW_FIELD_CELL_M: f64 = 0.025;
/// Largest number of cells along a side of a window with divided cells.
const MAX_DIVIDED_CELLS: i32 = 640;
/// A window farther away than this lies outside every map, cells.
const FARTHEST_CELL: f64 = 1e9;

/// Obstacles that the lidar saw and the map does not show.
pub struct ObstacleModel {
    map: LocalMap,
    /// `None` where moving obstacles are marked as static ones.
    tracker: Option<Tracker>,
    /// The last window of [`Self::window_with`]. It stays the same while the robot turns or stands.
    last_window: Option<Window>,
}

impl ObstacleModel {
    /// A model over the obstacles of a map, without any others.
    #[must_use]
    pub fn new(map: impl Into<NavigationMap>) -> Self {
        Self::with_tracker(map.into(), Some(Tracker::default()))
    }

    /// As [`Self::new`], but without tracking: every obstacle counts as static.
    pub(crate) fn without_tracking(map: impl Into<NavigationMap>) -> Self {
        Self::with_tracker(map.into(), None)
    }

    fn with_tracker(map: NavigationMap, tracker: Option<Tracker>) -> Self {
        Self { map: LocalMap::new(map), tracker, last_window: None }
    }

    /// Updates the model with a scan made at a time, seconds, from a pose in the map frame: tracks moving obstacles, marks the
    /// other returns, and clears marks that the scan saw through. The scan must be valid ([`Scan::is_valid`]), pose and time
    /// finite.
    pub fn update(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let Some(tracker) = &mut self.tracker else {
            self.map.clear_seen_through(time_s, pose, scan);
            for hit in scan.hits(pose) {
                self.map.mark(time_s, &hit);
            }
            return;
        };
        let map = &self.map;
        tracker.update(time_s, pose, scan, |point| map.origin_at(time_s, point));
        for (disc, since_s) in &tracker.swept {
            self.map.erase(disc, MOVING_MARGIN_M, since_s - BEFORE_TRACK_S);
        }
        self.map.clear_seen_through(time_s, pose, scan);
        for point in tracker.points() {
            let is_moving = tracker
                .moving
                .iter()
                .any(|disc| (disc.center() - point).norm() <= disc.radius + MOVING_MARGIN_M);
            if !is_moving {
                self.map.mark(time_s, &point);
            }
        }
    }

    /// Replaces the known obstacles. Marks and tracks remain.
    pub(super) fn replace_map(&mut self, mut map: LocalMap) {
        map.take_over(&self.map);
        self.map = map;
    }

    /// Obstacles that move, or moved until a moment ago, in the map frame at the time of the last scan.
    #[must_use]
    pub fn moving(&self) -> &[MovingDisc] {
        self.tracker.as_ref().map_or(&[], |tracker| &tracker.moving)
    }

    /// Obstacles that move or stand, each at least as large as a person, in the map frame at the time of the last scan.
    pub(super) fn bodies(&self, settings: &NavigatorSettings) -> Vec<MovingDisc> {
        let NavigatorSettings { pedestrian_radius_m, features, .. } = *settings;
        // Pairs of narrow objects may be people who have stood there all the time. They are marked too.
        let may_be_legs = features.passive_safety && features.pairs_of_legs;
        let legs = self.tracker.iter().filter(|_| may_be_legs).flat_map(Tracker::pairs_of_legs);
        let bodies = self.moving().iter().copied().chain(legs);
        let with_body =
            |disc: MovingDisc| MovingDisc { radius: disc.radius.max(pedestrian_radius_m), ..disc };
        bodies.map(with_body).collect()
    }

    /// People who walk, at the time of the last scan: by the line of their legs, and the bodies that no such line explains.
    pub(super) fn walkers(&self, bodies: &[MovingDisc], radius_m: f64) -> Vec<MovingDisc> {
        let tracker = self.tracker.as_ref();
        tracker.map_or_else(Vec::new, |tracker| tracker.walkers(bodies, radius_m))
    }

    /// People who entered free ground a moment ago, and who are not tracked.
    pub(super) fn entered_bodies(
        &self,
        settings: &NavigatorSettings,
    ) -> impl Iterator<Item = MovingDisc> {
        self.tracker.iter().flat_map(Tracker::entered).map(|(place, since_stood_s)| {
            // The legs of a person who stands are seen in turn, and seem to move. One who starts to walk gains speed.
            let gained =
                since_stood_s.map_or(f64::INFINITY, |s| settings.pedestrian_acceleration * s);
            let speed = gained.min(settings.pedestrian_speed);
            obstacle_that_may_come(place, settings.pedestrian_radius_m, speed)
        })
    }

    /// Objects that stand alone and may be people who start to walk. They are marked too.
    pub(super) fn bodies_that_may_start(&self, settings: &NavigatorSettings) -> Vec<MovingDisc> {
        let objects = self.tracker.iter().flat_map(Tracker::free_standing);
        let at = |place| obstacle_that_may_come(place, settings.pedestrian_radius_m, 0.0);
        objects.map(at).collect()
    }

    /// Sets whether what comes out of hiding may be a person.
    pub(super) const fn set_hides_people(&mut self, hides_people: bool) {
        if let Some(tracker) = &mut self.tracker {
            tracker.hides_people = hides_people;
        }
    }

    /// Where no path leads on the map: its obstacles and closed zones.
    pub(crate) fn closed(&self) -> &ObstacleGrid {
        self.map.closed.as_ref().unwrap_or(&self.map.known)
    }

    /// Reads the model as it is without marks.
    pub(super) fn without_marks<T>(&mut self, read: impl FnOnce(&Self) -> T) -> T {
        let marks = core::mem::take(&mut self.map.marks);
        let answer = read(self);
        self.map.marks = marks;
        answer
    }

    /// Casts rays among the obstacles of the map.
    pub(super) const fn rays(&self) -> &RayCaster {
        &self.map.rays
    }

    /// Forgets marks that no scan hit since a time, seconds, except near the robot: it has no path, or they may be at wrong places.
    pub(super) fn forget(&mut self, since_s: f64, robot: &Point) {
        let is_far = |mark: &Mark| (mark.center - robot).norm() > FORGET_BEYOND_M;
        self.map
            .remove_where(|map, slot| map.marks[slot].last_s < since_s && is_far(&map.marks[slot]));
    }

    /// Centres of the marked cells.
    pub fn marks(&self) -> impl Iterator<Item = Point> + '_ {
        self.map.marks.iter().map(|mark| mark.center)
    }

    /// The marked cells of objects that did not exist yet at a time, seconds, as discs around them.
    pub(super) fn recent_marks(&self, time_s: f64) -> impl Iterator<Item = MovingDisc> + use<> {
        let radius = core::f64::consts::FRAC_1_SQRT_2 * self.map.known.frame().resolution_m;
        let marks = self.map.marks.iter().map(|mark| (mark.center, mark.first_s > time_s));
        let recent = places_of_new_objects(marks).into_iter();
        recent.map(move |place| obstacle_that_may_come(place, radius, 0.0))
    }

    /// The distance field between areas of a square window around a point, `half_m` to each side, aligned with the map's cells.
    /// Closed zones and cells outside the map are obstacles. Cells larger than 5 cm are divided.
    ///
    /// # Errors
    /// When the map's resolution is out of range, or the window has more than 4095 cells a side.
    pub fn window(&self, center: &Point, half_m: f64) -> Result<Arc<ClearanceField>, ProblemError> {
        field_of(&self.obstacles_around(center, half_m)?, FIELD_CELL_M)
    }

    /// As [`Self::window`], after a change of the window's obstacles. Near narrow passages, cells larger than 2.5 cm are divided.
    pub(super) fn window_with(
        &mut self,
        center: &Point,
        half_m: f64,
        is_narrow: bool,
        change: impl FnOnce(&mut ObstacleGrid),
    ) -> Result<Arc<ClearanceField>, ProblemError> {
        let cell_m = if is_narrow { NARROW_FIELD_CELL_M } else { FIELD_CELL_M };
        let mut obstacles = self.obstacles_around(center, half_m)?;
        change(&mut obstacles);
        if let Some(last) = &self.last_window
            && last.cell_m == cell_m
            && last.obstacles == obstacles
        {
            return Ok(Arc::clone(&last.field));
        }
        let field = field_of(&obstacles, cell_m)?;
        self.last_window = Some(Window { obstacles, cell_m, field: Arc::clone(&field) });
        Ok(field)
    }

    /// The obstacles of a square window, as [`Self::window`].
    fn obstacles_around(&self, center: &Point, half_m: f64) -> Result<ObstacleGrid, ProblemError> {
        let known = self.closed();
        let frame = *known.frame();
        let units = frame.to_cell_units(center);
        let half_cells = (half_m / frame.resolution_m).ceil();
        let side_cells = 2.0 * half_cells + 1.0;
        let fits = side_cells <= MAX_WINDOW_CELLS;
        if !fits {
            return Err(ProblemError::OutOfRange {
                quantity: "side of the local window",
                value: side_cells,
                unit: "cells",
                limit: WINDOW_LIMIT,
            });
        }
        let (half, side) = (half_cells as i32, side_cells as i32);
        let lowest = |units: f64| units.floor().clamp(-FARTHEST_CELL, FARTHEST_CELL) as i32 - half;
        let (left, bottom) = (lowest(units.x), lowest(units.y));
        let corner = frame.from_cell_units(&Point::new(f64::from(left), f64::from(bottom)));
        let origin = Pose { x: corner.x, y: corner.y, ..frame.origin };
        let window = GridFrame { width: side, height: side, origin, ..frame };
        let mut blocked = vec![true; window.len()];
        let columns = left.max(0)..(left + side).min(frame.width);
        if !columns.is_empty() {
            let width = columns.len();
            for row in bottom.max(0)..(bottom + side).min(frame.height) {
                let from = frame.index(Cell::new(columns.start, row));
                let to = window.index(Cell::new(columns.start - left, row - bottom));
                blocked[to..to + width].copy_from_slice(&known.cells()[from..from + width]);
            }
        }
        let mut obstacles = ObstacleGrid::new(window, blocked);
        for mark in &self.map.marks {
            let Cell { column, row } = frame.cell_at(mark.index as usize);
            obstacles.set(Cell::new(column - left, row - bottom), true);
        }
        Ok(obstacles)
    }
}

/// The obstacles of a local window, and the field of them with cells of at most this side.
struct Window {
    obstacles: ObstacleGrid,
    cell_m: f64,
    field: Arc<ClearanceField>,
}

/// The distance field between the areas of a square window. Cells larger than `cell_m` are divided.
fn field_of(obstacles: &ObstacleGrid, cell_m: f64) -> Result<Arc<ClearanceField>, ProblemError> {
    let GridFrame { width, resolution_m, .. } = *obstacles.frame();
    Ok(Arc::new(ClearanceField::of_areas(obstacles, parts(resolution_m, width, cell_m))?))
}

/// Number of parts along a side of a cell: as few as make the parts at most this large, metres, unless the window becomes too large.
fn parts(resolution_m: f64, side: i32, cell_m: f64) -> u16 {
    // A map of 5 cm may say 0.050000001.
    let wanted = (resolution_m / cell_m - 0.01).ceil().max(1.0);
    let most = f64::from(MAX_DIVIDED_CELLS / side).max(1.0);
    wanted.min(most) as u16
}

/// Known obstacles, and the marks of the lidar among them.
pub(super) struct LocalMap {
    known: ObstacleGrid,
    /// The known obstacles and the closed zones, if there are any.
    closed: Option<ObstacleGrid>,
    rays: RayCaster,
    /// Sine and cosine of the turn from the map frame to the grid's.
    turn: (f64, f64),
    /// Cells that are not next to a known obstacle.
    apart: FreeSpace,
    /// Index of each cell's mark plus one, or zero. So the operating system never allocates the pages of an area without
    /// marks.
    slots: Vec<u32>,
    /// The order depends only on the scans.
    marks: Vec<Mark>,
}

/// A cell that the lidar saw occupied and the map shows free.
#[derive(Clone, Copy, Debug)]
struct Mark {
    index: u32,
    center: Point,
    evidence: u8,
    first_s: f64,
    last_s: f64,
}

/// What a return belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReturnOrigin {
    /// An obstacle of the map, or a place outside the map.
    Mapped,
    /// A mark that has been there for a while.
    Settled,
    /// Anything else.
    New,
}

impl LocalMap {
    /// A local map over the known obstacles, without marks.
    pub fn new(map: NavigationMap) -> Self {
        let closed = map.zones.as_ref().filter(|zones| !zones.is_open()).map(|_| map.closed());
        let known = map.obstacles;
        let (sin, cos) = libm::sincos(known.frame().origin.yaw);
        Self {
            turn: (-sin, cos),
            apart: FreeSpace::new(&known, KNOWN_MARGIN_M),
            rays: RayCaster::new(&known),
            slots: vec![0; known.frame().len()],
            known,
            closed,
            marks: Vec::new(),
        }
    }

    /// Takes over the marks of another map that do not belong to an obstacle of this one.
    fn take_over(&mut self, other: &Self) {
        let frame = *self.known.frame();
        for mark in &other.marks {
            let Some(cell) = self.cell_of(&mark.center) else {
                continue;
            };
            let index = frame.index(cell);
            if self.slot_of(index).is_none() && !self.is_near_known(cell) {
                self.marks.push(Mark {
                    index: index as u32,
                    center: frame.center_of(cell),
                    ..*mark
                });
                self.slots[index] = self.marks.len() as u32;
            }
        }
    }

    /// What a return at a point belongs to.
    fn origin_at(&self, time_s: f64, point: &Point) -> ReturnOrigin {
        let Some(cell) = self.cell_of(point) else {
            return ReturnOrigin::Mapped;
        };
        if self.is_near_known(cell) {
            return ReturnOrigin::Mapped;
        }
        let settled =
            |cell: Cell| self.mark_of(cell).is_some_and(|mark| time_s - mark.first_s > SETTLED_S);
        // Its own cell first: it is the most likely one.
        if settled(cell) || cell.with_neighbours().any(settled) {
            ReturnOrigin::Settled
        } else {
            ReturnOrigin::New
        }
    }

    /// The cell of a point, as [`GridFrame::cell_of`] returns it.
    fn cell_of(&self, point: &Point) -> Option<Cell> {
        let frame = self.known.frame();
        let offset = (point - frame.origin.position()).rotated(self.turn) / frame.resolution_m;
        frame.cell_at_units(&Point::new(offset.x, offset.y))
    }

    /// Whether a cell is next to a known obstacle: by noise a return from the obstacle falls there too. Cells on the border of
    /// the grid are, because everything outside it is an obstacle.
    fn is_near_known(&self, cell: Cell) -> bool {
        let frame = self.known.frame();
        let on_border = cell.column == 0
            || cell.row == 0
            || cell.column == frame.width - 1
            || cell.row == frame.height - 1;
        on_border || !self.apart.is_free(cell)
    }

    /// The place of a cell's mark in the list of marks.
    fn slot_of(&self, index: usize) -> Option<usize> {
        self.slots[index].checked_sub(1).map(|slot| slot as usize)
    }

    fn mark_of(&self, cell: Cell) -> Option<&Mark> {
        let frame = self.known.frame();
        if !frame.contains(cell) {
            return None;
        }
        self.slot_of(frame.index(cell)).map(|slot| &self.marks[slot])
    }

    /// Marks the cell of a return, unless it belongs to a known obstacle.
    fn mark(&mut self, time_s: f64, hit: &Point) {
        let frame = *self.known.frame();
        let Some(cell) = self.cell_of(hit) else {
            return;
        };
        let index = frame.index(cell);
        if let Some(slot) = self.slot_of(index) {
            let mark = &mut self.marks[slot];
            mark.evidence = (mark.evidence + 1).min(MAX_EVIDENCE);
            mark.last_s = time_s;
        } else if !self.is_near_known(cell) {
            self.marks.push(Mark {
                index: index as u32,
                center: frame.center_of(cell),
                evidence: 1,
                first_s: time_s,
                last_s: time_s,
            });
            self.slots[index] = self.marks.len() as u32;
        }
    }

    /// Removes the marks of a moving obstacle: those within a distance of it, metres, since a time, seconds.
    fn erase(&mut self, disc: &MovingDisc, reach_m: f64, since_s: f64) {
        let frame = *self.known.frame();
        for cell in frame.cells_within(&disc.center(), disc.radius + reach_m) {
            if let Some(slot) = self.slot_of(frame.index(cell))
                && self.marks[slot].first_s >= since_s
            {
                self.remove(slot);
            }
        }
    }

    fn remove(&mut self, slot: usize) {
        let gone = self.marks.swap_remove(slot);
        self.slots[gone.index as usize] = 0;
        if let Some(moved) = self.marks.get(slot) {
            self.slots[moved.index as usize] = slot as u32 + 1;
        }
    }

    /// Removes the marks for which a condition holds, by their places in the list.
    fn remove_where(&mut self, mut is_gone: impl FnMut(&mut Self, usize) -> bool) {
        let mut slot = 0;
        while slot < self.marks.len() {
            if is_gone(self, slot) {
                self.remove(slot);
            } else {
                slot += 1;
            }
        }
    }

    /// Reduces the evidence of marks that the scan saw through, and removes those without any. Also removes marks of one return
    /// that the scan cannot show again.
    fn clear_seen_through(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        if scan.ranges.is_empty() {
            return;
        }
        let resolution_m = self.known.frame().resolution_m;
        let lidar = pose.transform(&scan.origin);
        let beyond_m = resolution_m.max(SEEN_THROUGH_M);
        self.remove_where(|map, slot| {
            let mark = &mut map.marks[slot];
            let distance = (mark.center - lidar).norm();
            let half_angle = resolution_m / distance.max(resolution_m);
            let direction = bearing(&lidar, &mark.center);
            let seen_through = distance < scan.range_max.min(FARTHEST_M)
                && measures_beyond(pose, scan, direction, half_angle, distance + beyond_m);
            mark.evidence -= u8::from(seen_through);
            let is_old = time_s - mark.last_s > UNCONFIRMED_S;
            mark.evidence == 0
                || is_old
                    && !is_in_view(pose, scan, direction, half_angle)
                    && map.is_of_one_return(slot)
        });
    }

    /// Whether one return alone made a mark: no other return hit its cell, and there is no mark next to it.
    fn is_of_one_return(&self, slot: usize) -> bool {
        let mark = &self.marks[slot];
        let cell = self.known.frame().cell_at(mark.index as usize);
        mark.evidence == 1
            && mark.first_s == mark.last_s
            && cell.with_neighbours().all(|next| next == cell || self.mark_of(next).is_none())
    }
}
