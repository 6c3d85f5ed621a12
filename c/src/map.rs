//! Maps, configurations, and global paths.

use core::ffi::c_char;
use core::ops::Deref;
use core::panic::AssertUnwindSafe;
use std::path::Path;

use inbye::geometry::Point;
use inbye::map::{GridFrame, LoadOptions, OccupancyGrid, load};
use inbye::navigator::ZonedMap;
use inbye::runtime::Config;

use crate::error::{array, boxed, free, guarded, object, text};
use crate::values::{InbyePoint, InbyePose};

/// An occupancy grid with its zones. Unknown cells are obstacles, or free with `unknown = "free"` in the configuration.
pub struct InbyeMap(ZonedMap);

/// All settings of a robot and its navigation.
pub struct InbyeConfig(pub(crate) Config);

impl Deref for InbyeMap {
    type Target = ZonedMap;

    fn deref(&self) -> &ZonedMap {
        &self.0
    }
}

/// Makes a map of width times height cells, the lowest row first. A cell has its occupancy, 0 to 100 percent, or -1 if it is
/// unknown: a nav_msgs/OccupancyGrid. The resolution is the side of a cell in metres, the origin the pose of the lower left
/// corner. A map has at most 32,767 cells along each side and 100,000,000 in all. Returns null on failure.
///
/// # Safety
/// `cells` points to width times height values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_map_new(
    cells: *const i8,
    width: i32,
    height: i32,
    resolution_m: f64,
    origin: InbyePose,
) -> *mut InbyeMap {
    boxed(AssertUnwindSafe(|| {
        let origin = origin.checked("origin")?;
        let frame = GridFrame::new(width, height, resolution_m, origin);
        let frame = frame.map_err(|error| error.to_string())?;
        // SAFETY: the caller vouches for the cells; the frame has checked that both sides are above zero.
        let cells = unsafe { array(cells, frame.len(), "cells") }?;
        let grid = OccupancyGrid::from_cells(frame, cells.to_vec());
        Ok(InbyeMap(ZonedMap::new(grid.map_err(|error| error.to_string())?, None)))
    }))
}

/// Reads a map_server YAML file, a MovingAI map or rows of text. The side of a cell, metres, counts for the last two. Returns
/// null on failure.
///
/// # Safety
/// `path` points to a text that ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_map_load(path: *const c_char, resolution_m: f64) -> *mut InbyeMap {
    boxed(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the text.
        let path = unsafe { text(path, "path") }?;
        let grid = load(Path::new(path), &LoadOptions { resolution_m });
        Ok(InbyeMap(ZonedMap::new(grid.map_err(|error| error.to_string())?, None)))
    }))
}

/// Makes a copy of a map with zones in which the robot must not drive, or only slowly. The masks are those of Nav2's costmap filters:
/// occupied cells of `keepout` are closed, and a value of 30 in `speed` limits the speed to 70 percent of the largest. They may have
/// another size and resolution than the map; null for none. Zones that the map has already are kept: of two limits the lower counts. A
/// lidar sees through zones. Returns null on failure.
///
/// # Safety
/// `map` is alive; `keepout` and `speed` are null or maps that are alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_map_with_zones(
    map: *const InbyeMap,
    keepout: *const InbyeMap,
    speed: *const InbyeMap,
) -> *mut InbyeMap {
    boxed(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the map.
        let map = unsafe { object(map, "map") }?;
        // SAFETY: the caller vouches for the masks.
        let (keepout, speed) = unsafe { (keepout.as_ref(), speed.as_ref()) };
        let (keepout, speed) = (keepout.map(|mask| &*mask.grid), speed.map(|mask| &*mask.grid));
        map.with_masks(keepout, speed).map(InbyeMap).map_err(|error| error.to_string())
    }))
}

/// Frees a map. Navigators made of it stay valid.
///
/// # Safety
/// `map` is null or a map that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_map_free(map: *mut InbyeMap) {
    // SAFETY: the caller vouches for the map.
    unsafe { free(map) };
}

/// Makes the default settings with the changes of a text, TOML with the keys of a configuration file; null for no changes.
/// Returns null on failure.
///
/// # Safety
/// `toml` is null or points to a text that ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_config_new(toml: *const c_char) -> *mut InbyeConfig {
    boxed(AssertUnwindSafe(|| {
        let base = Config::default();
        if toml.is_null() {
            return Ok(InbyeConfig(base));
        }
        // SAFETY: the caller vouches for the text.
        let changes = unsafe { text(toml, "toml") }?;
        base.with_changes(changes).map(InbyeConfig).map_err(|error| error.to_string())
    }))
}

/// Frees a configuration.
///
/// # Safety
/// `config` is null or a configuration that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_config_free(config: *mut InbyeConfig) {
    // SAFETY: the caller vouches for the configuration.
    unsafe { free(config) };
}

/// Plans a path from a start to a goal: a smooth one, or that of the program `global_planner.command` of the configuration. Writes up
/// to `capacity` points into `points`, and the number of all of them into `count`: where it is larger than the capacity, call again
/// with more room.
///
/// # Safety
/// `map` and `config` are alive; `points` has room for `capacity` points; `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_plan(
    map: *const InbyeMap,
    config: *const InbyeConfig,
    start: InbyePoint,
    goal: InbyePoint,
    points: *mut InbyePoint,
    capacity: usize,
    count: *mut usize,
) -> bool {
    let planned = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for both.
        let (map, config) = unsafe { (object(map, "map")?, object(config, "config")?) };
        let (start, goal) = (start.checked("start")?, goal.checked("goal")?);
        let closed = map.navigation_map(config.0.unknown).closed();
        let planner = config.0.new_global_planner(closed.frame().resolution_m);
        let mut planner = planner.map_err(|error| error.to_string())?;
        let plan = planner.plan(&closed, &[], start, goal, &mut || 0.0);
        let path = plan.map_err(|error| error.to_string())?.smoothed;
        // SAFETY: the caller vouches for the places.
        unsafe { write_points(path.points(), points, capacity, count) }
    }));
    planned.is_some()
}

/// Writes the first points of a path, and the number of all.
///
/// # Safety
/// `points` is null or has room for `capacity` points; `count` is null or can be written.
pub(crate) unsafe fn write_points(
    path: &[Point],
    points: *mut InbyePoint,
    capacity: usize,
    count: *mut usize,
) -> Result<(), String> {
    if count.is_null() || (points.is_null() && capacity > 0) {
        return Err("points or count is null".to_owned());
    }
    for (index, point) in path.iter().take(capacity).enumerate() {
        // SAFETY: the caller vouches for the room.
        unsafe { points.add(index).write(point.into()) };
    }
    // SAFETY: the caller vouches for the place.
    unsafe { count.write(path.len()) };
    Ok(())
}
