//! Occupancy grids, and global paths on them.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use inbye::local::ClearanceField;
use inbye::map::{GridFrame, LoadOptions, OccupancyGrid, UnknownPolicy, load};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use super::conversion::{point, points, pose, pose_tuple, raise};
use super::settings::changed;

/// An occupancy grid.
#[pyclass(frozen, module = "inbye")]
pub struct Map {
    pub grid: Arc<OccupancyGrid>,
    /// Distances to obstacles, with unknown cells blocked and free.
    fields: [OnceLock<Arc<ClearanceField>>; 2],
}

impl Map {
    fn of(grid: OccupancyGrid) -> Self {
        Self { grid: Arc::new(grid), fields: [OnceLock::new(), OnceLock::new()] }
    }

    /// The distances to the obstacles, which are measured once.
    pub fn field(&self, unknown: UnknownPolicy) -> PyResult<Arc<ClearanceField>> {
        let field = &self.fields[usize::from(unknown == UnknownPolicy::Free)];
        if let Some(field) = field.get() {
            return Ok(Arc::clone(field));
        }
        let made = ClearanceField::new(&self.grid.obstacles(unknown)).map_err(raise)?;
        Ok(Arc::clone(field.get_or_init(|| Arc::new(made))))
    }
}

#[pymethods]
impl Map {
    /// Cells of occupancy in percent, -1 for unknown, with the lowest row first.
    #[new]
    #[pyo3(signature = (cells, resolution_m, origin=[0.0; 3]))]
    fn new(cells: PyReadonlyArray2<'_, i8>, resolution_m: f64, origin: [f64; 3]) -> PyResult<Self> {
        let cells = cells.as_array();
        let side = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
        let (height, width) = (side(cells.nrows()), side(cells.ncols()));
        let frame = GridFrame::new(width, height, resolution_m, pose(origin)?).map_err(raise)?;
        if cells.iter().any(|cell| !(-1..=100).contains(cell)) {
            return Err(raise("cells must be -1, for unknown, or 0 to 100 percent"));
        }
        Ok(Self::of(OccupancyGrid::new(frame, cells.iter().copied().collect())))
    }

    #[staticmethod]
    #[pyo3(signature = (path, resolution_m=1.0))]
    fn load(py: Python<'_>, path: PathBuf, resolution_m: f64) -> PyResult<Self> {
        py.detach(|| load(&path, &LoadOptions { resolution_m })).map(Self::of).map_err(raise)
    }

    #[staticmethod]
    #[pyo3(signature = (rows, resolution_m, origin=[0.0; 3]))]
    fn from_rows(rows: Vec<String>, resolution_m: f64, origin: [f64; 3]) -> PyResult<Self> {
        OccupancyGrid::from_rows(&rows, resolution_m, pose(origin)?).map(Self::of).map_err(raise)
    }

    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i8>>> {
        let frame = self.grid.frame();
        let shape = (frame.height as usize, frame.width as usize);
        let cells = numpy::ndarray::ArrayView2::from_shape(shape, self.grid.cells());
        Ok(PyArray2::from_array(py, &cells.map_err(raise)?))
    }

    #[getter]
    fn resolution_m(&self) -> f64 {
        self.grid.frame().resolution_m
    }

    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        pose_tuple(&self.grid.frame().origin)
    }

    fn __repr__(&self) -> String {
        let frame = self.grid.frame();
        format!("Map({} x {} cells of {} m)", frame.width, frame.height, frame.resolution_m)
    }
}

/// Plans a smooth path, metres, from a start to a goal.
#[pyfunction]
#[pyo3(signature = (map, start, goal, *, config=None))]
pub fn plan<'py>(
    py: Python<'py>,
    map: &Bound<'py, Map>,
    start: [f64; 2],
    goal: [f64; 2],
    config: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let config = changed(&inbye::runtime::Config::default(), config)?;
    let (grid, start, goal) = (&map.get().grid, point(start)?, point(goal)?);
    let plan = py.detach(|| {
        let obstacles = grid.obstacles(config.unknown);
        let mut planner = config.route_planner(grid.frame().resolution_m);
        planner.plan(&obstacles, start, goal, &mut || 0.0)
    });
    points(py, plan.map_err(raise)?.smoothed.points())
}
