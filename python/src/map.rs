//! Occupancy grids, and global paths on them.

use core::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

use inbye::map::{GridFrame, LoadOptions, OccupancyGrid, Zones, has_own_resolution, load};
use inbye::navigator::ZonedMap;
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use super::conversion::{
    Numbers, check_unmasked, dtype, numpy_array, point, points, pose, pose_tuple, raise,
};
use super::settings::settings;

/// An occupancy grid.
#[pyclass(frozen, module = "inbye")]
pub struct Map(ZonedMap);

impl Deref for Map {
    type Target = ZonedMap;

    fn deref(&self) -> &ZonedMap {
        &self.0
    }
}

impl Map {
    fn of(grid: OccupancyGrid) -> Self {
        Self(ZonedMap::new(grid, None))
    }
}

#[pymethods]
impl Map {
    /// Cells of occupancy in percent, -1 for unknown, with the lowest row first.
    #[new]
    #[pyo3(signature = (cells, resolution_m, origin=Numbers([0.0; 3])))]
    fn new(cells: &Bound<'_, PyAny>, resolution_m: f64, origin: Numbers<3>) -> PyResult<Self> {
        let cells = whole_cells(cells)?;
        let cells = cells.as_array();
        let side = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
        let (height, width) = (side(cells.nrows()), side(cells.ncols()));
        let frame = GridFrame::new(width, height, resolution_m, pose(origin)?).map_err(raise)?;
        let cells = cells.iter().copied().collect();
        OccupancyGrid::from_cells(frame, cells).map(Self::of).map_err(raise)
    }

    /// Reads a map_server YAML file, a MovingAI map or rows of text. The side of a cell, one metre by default, is for the last two.
    #[staticmethod]
    #[pyo3(signature = (path, resolution_m=None))]
    fn load(py: Python<'_>, path: PathBuf, resolution_m: Option<f64>) -> PyResult<Self> {
        if let Some(given) = resolution_m.filter(|_| has_own_resolution(&path)) {
            let map = path.display();
            return Err(raise(format!("resolution_m {given}: {map} states its own: leave it out")));
        }
        let options = LoadOptions { resolution_m: resolution_m.unwrap_or(1.0) };
        py.detach(|| load(&path, &options)).map(Self::of).map_err(raise)
    }

    /// Makes a map of rows of text, the highest row first: # wall, . free, ? unknown.
    #[staticmethod]
    #[pyo3(signature = (rows, resolution_m, origin=Numbers([0.0; 3])))]
    fn from_rows(rows: Vec<String>, resolution_m: f64, origin: Numbers<3>) -> PyResult<Self> {
        OccupancyGrid::from_rows(&rows, resolution_m, pose(origin)?).map(Self::of).map_err(raise)
    }

    /// A copy of the cells, the lowest row first.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i8>>> {
        cells(py, &self.grid)
    }

    /// Side of a cell.
    #[getter]
    fn resolution_m(&self) -> f64 {
        self.grid.frame().resolution_m
    }

    /// Pose of the lower left corner.
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        pose_tuple(&self.grid.frame().origin)
    }

    /// Returns this map with zones in which the robot must not drive, or only slowly. The masks are those of Nav2's costmap filters.
    #[pyo3(signature = (*, keepout=None, speed=None))]
    fn with_zones(
        &self,
        keepout: Option<&Bound<'_, Self>>,
        speed: Option<&Bound<'_, Self>>,
    ) -> PyResult<Self> {
        let keepout = keepout.map(|mask| &*mask.get().grid);
        let speed = speed.map(|mask| &*mask.get().grid);
        self.0.with_masks(keepout, speed).map(Self).map_err(raise)
    }

    /// A copy of the zones on the cells of the map, if it has any: 0 no zone, 1 to 99 a speed limit in percent, 100 closed.
    #[getter]
    fn zones<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<i8>>>> {
        self.zones.as_ref().map(|zones| cells(py, zones.grid())).transpose()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<MapParts<'py>> {
        let make = py.import("inbye._native")?.getattr("_map_of_parts")?;
        let parts = (self.cells(py)?, self.resolution_m(), self.origin(), self.zones(py)?);
        Ok((make, parts))
    }

    fn __repr__(&self) -> String {
        let frame = self.grid.frame();
        format!("Map({} x {} cells of {} m)", frame.width, frame.height, frame.resolution_m)
    }
}

/// Cells, resolution, origin and zones, with the function that makes a map of them.
type MapParts<'py> = (
    Bound<'py, PyAny>,
    (Bound<'py, PyArray2<i8>>, f64, (f64, f64, f64), Option<Bound<'py, PyArray2<i8>>>),
);

/// Makes a map of the parts that it was pickled as.
#[pyfunction]
#[pyo3(name = "_map_of_parts")]
pub fn map_of_parts(
    cells: &Bound<'_, PyAny>,
    resolution_m: f64,
    origin: Numbers<3>,
    zones: Option<&Bound<'_, PyAny>>,
) -> PyResult<Map> {
    let map = Map::new(cells, resolution_m, origin)?;
    let Some(zones) = zones else { return Ok(map) };
    let zones = Map::new(zones, resolution_m, origin)?;
    let zones = Arc::new(Zones::from_grid(&zones.grid));
    Ok(Map(ZonedMap::new(Arc::clone(&map.grid), Some(zones))))
}

/// Cells from an array of any type of integers, or from rows of them.
fn whole_cells<'py>(cells: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray2<'py, i8>> {
    let of = |array: &Bound<'py, PyArray2<i8>>| array.try_readonly().map_err(raise);
    check_unmasked("cells", cells)?;
    if let Ok(array) = cells.cast::<PyArray2<i8>>() {
        return of(array);
    }
    let array = numpy_array("cells", cells)?;
    let (kind, name) = dtype(&array)?;
    if array.getattr("size")?.extract::<usize>()? == 0 {
        return Err(raise("cells: a map needs at least one row of one cell"));
    }
    // Truth values would be occupied by one percent, and shares of one be free.
    if kind != "i" && kind != "u" {
        return Err(raise(format!("cells: integers are expected, not values of type {name}")));
    }
    // The conversion wraps larger values.
    let least: i128 = array.call_method0("min")?.extract()?;
    let largest: i128 = array.call_method0("max")?.extract()?;
    if least < -1 || largest > 100 {
        return Err(raise("cells must be -1, for unknown, or 0 to 100 percent"));
    }
    let array = array.call_method1("astype", ("int8",))?;
    let array = array.cast_into::<PyArray2<i8>>();
    of(&array.map_err(|_| raise("cells: an array of dimension 2 is expected"))?)
}

/// A copy of the cells of a grid.
fn cells<'py>(py: Python<'py>, grid: &OccupancyGrid) -> PyResult<Bound<'py, PyArray2<i8>>> {
    let shape = (grid.frame().height as usize, grid.frame().width as usize);
    let cells = numpy::ndarray::ArrayView2::from_shape(shape, grid.cells());
    Ok(PyArray2::from_array(py, &cells.map_err(raise)?))
}

/// Plans a smooth path, metres, from a start to a goal.
#[pyfunction]
#[pyo3(signature = (map, start, goal, *, config=None))]
pub fn plan<'py>(
    py: Python<'py>,
    map: &Bound<'py, Map>,
    start: Numbers<2>,
    goal: Numbers<2>,
    config: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let config = settings(config)?;
    if config.global_planner.is_set() {
        return Err(raise(
            "global_planner.command: plan uses inbye's own planner: leave it out, or use Navigator and its path",
        ));
    }
    let (map, start, goal) = (map.get(), point(start)?, point(goal)?);
    let plan = py.detach(|| {
        let closed = map.navigation_map(config.unknown).closed();
        let mut planner = config.route_planner(closed.frame().resolution_m);
        planner.plan(&closed, start, goal, &mut || 0.0)
    });
    points(py, plan.map_err(raise)?.smoothed.points())
}
