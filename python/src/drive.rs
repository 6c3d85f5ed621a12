//! Worlds, drives in them, and replays of recordings.

use core::ops::ControlFlow;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

use inbye::bench::EngineRequest;
use inbye::experiment::{self, PlanWorlds, RunRow};
use inbye::recording::Reader;
use inbye::runtime::{Config, Decider, MissionResult, Observer, TickEvent};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::controller::{PythonController, Raised};
use super::conversion::{Numbers, from_json, goal, pose, raise, whole};
use super::decision::open;
use super::interrupt::Interrupt;
use super::map::Map;
use super::records::Records;
use super::settings::changed;

/// A world to drive in.
#[pyclass(frozen, module = "inbye")]
#[derive(Clone)]
pub struct World {
    pub inner: experiment::World,
}

#[pymethods]
impl World {
    /// A mission on a map, among people who walk across the path.
    #[new]
    #[pyo3(signature = (map, start, goal, *, people=0, time_limit_s=None, name="map"))]
    fn new(
        map: &Bound<'_, Map>,
        start: Numbers<3>,
        goal: Vec<f64>,
        people: i128,
        time_limit_s: Option<f64>,
        name: &str,
    ) -> PyResult<Self> {
        let map = map.get();
        let (grid, zones) = (Arc::clone(&map.grid), map.zones.clone());
        let (start, goal) = (pose(start)?, self::goal(&goal)?);
        let people = whole("people", people)?;
        let mut ranges = PlanWorlds::default().people(people);
        ranges.time_limit_s = time_limit_s.unwrap_or(ranges.time_limit_s);
        ranges.validate().map_err(raise)?;
        let inner = experiment::World::on_map(name, grid, zones, start, goal, people, time_limit_s);
        Ok(Self { inner })
    }

    /// Its name in tables.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Its kind, as plans name it.
    #[getter]
    fn kind(&self) -> &'static str {
        self.inner.kind.name()
    }

    /// Drives the mission of a seed.
    #[pyo3(signature = (seed=0, *, config=None, controller=None, engine="cpu"))]
    fn drive(
        &self,
        py: Python<'_>,
        seed: i128,
        config: Option<&Bound<'_, PyAny>>,
        controller: Option<&Bound<'_, PyAny>>,
        engine: &str,
    ) -> PyResult<Drive> {
        let (seed, config) = (whole("seed", seed)?, changed(&self.inner.settings, config)?);
        let (decider, raised) = decider(controller, &config, engine)?;
        let (mut world, mut interrupt) = (self.inner.clone(), Interrupt::new());
        interrupt.set_in(&mut world);
        let run = py.detach(|| {
            let waits = interrupt.clone();
            let on_tick = &mut |_: &TickEvent<'_>| {
                interrupt.check_now_and_then().unwrap_or_else(|error| raised.set(error));
            };
            let mut observer = Observer { clock: &mut || 0.0, on_tick };
            waits.watch(&raised, || world.drive(seed, &config, decider, &mut observer))
        });
        raised.check()?;
        py.check_signals()?;
        let run = run.map_err(raise)?;
        Ok(Drive { row: run.row, result: run.result })
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        format!("World({:?}, kind={:?})", self.inner.name, self.inner.kind.name())
    }
}

/// What decides: a controller in Python, or inbye's behaviours.
fn decider(
    controller: Option<&Bound<'_, PyAny>>,
    config: &Config,
    engine: &str,
) -> PyResult<(Decider, Raised)> {
    match controller {
        Some(controller) => {
            PythonController::check_settings(config)?;
            // It uses no engine.
            let _: EngineRequest = engine.parse().map_err(raise)?;
            let controller = PythonController::of(controller)?;
            let raised = controller.raised();
            Ok((Decider::Controller(Box::new(controller)), raised))
        }
        None => Ok((open(engine, 1)?.into(), Raised::default())),
    }
}

/// A drive in a simulated world.
#[pyclass(frozen, module = "inbye")]
pub struct Drive {
    row: RunRow,
    /// None if the navigator refused to start.
    result: Option<MissionResult>,
}

/// Columns of a trace.
const TRACE: &[(&str, &str)] = &[
    ("time_s", "<f8"),
    ("x", "<f8"),
    ("y", "<f8"),
    ("yaw", "<f8"),
    ("believed_x", "<f8"),
    ("believed_y", "<f8"),
    ("believed_yaw", "<f8"),
    ("vx", "<f8"),
    ("vtheta", "<f8"),
    ("command_vx", "<f8"),
    ("command_vtheta", "<f8"),
    ("target_x", "<f8"),
    ("target_y", "<f8"),
    ("gap_m", "<f8"),
    ("admissible", "<u4"),
    ("samples", "<u4"),
    ("mode", "<U12"),
    ("path", "<u4"),
];

#[pymethods]
impl Drive {
    /// Whether the robot reached its goal without contact.
    #[getter]
    fn reached(&self) -> bool {
        self.row.reached()
    }

    /// Time of the drive.
    #[getter]
    fn time_s(&self) -> f64 {
        self.row.time_s
    }

    /// Why the goal was not reached; none if it was.
    #[getter]
    fn reason(&self) -> Option<&str> {
        self.row.reason.as_deref()
    }

    /// All figures of the run, as in the records of experiments.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.row)
    }

    /// SHA-256 of the exact bits of the trace, as `inbye drive` prints it.
    #[getter]
    fn digest(&self) -> Option<String> {
        self.result.as_ref().map(|result| result.trace.digest())
    }

    /// How the robot kept the zones of the map; none without zones.
    #[getter]
    fn zones<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let zones = self.result.as_ref().and_then(|result| result.zones.as_ref());
        zones.map(|zones| from_json(py, zones)).transpose()
    }

    /// Every tick as a structured array.
    #[getter]
    fn trace<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut records = Records::new(TRACE);
        for row in self.result.iter().flat_map(|result| &result.trace.rows) {
            records.real(row.time_s);
            for pose in [&row.pose, &row.belief] {
                records.reals([pose.x, pose.y, pose.yaw]);
            }
            for twist in [&row.twist, &row.command] {
                records.reals([twist.linear, twist.angular]);
            }
            records.reals([row.local_target.x, row.local_target.y, row.gap_m]);
            records.whole(row.admissible);
            records.whole(row.samples);
            records.text(row.mode.name(), 12);
            records.whole(row.path as u32);
        }
        records.to_array(py)
    }

    /// The global paths that the robot followed.
    #[getter]
    fn paths<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, numpy::PyArray2<f64>>>> {
        let paths = self.result.iter().flat_map(|result| &result.trace.paths);
        paths.map(|path| super::conversion::points(py, path)).collect()
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let how = self.row.outcome.text();
        format!("Drive({} {how} after {:.1} s)", self.row.world, self.row.time_s)
    }
}

/// Repeats the decisions of a recording and compares their bits.
#[pyfunction]
#[pyo3(signature = (path, *, engine="cpu", global_planner=None))]
pub fn replay<'py>(
    py: Python<'py>,
    path: PathBuf,
    engine: &str,
    global_planner: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyDict>> {
    let place = |error: &dyn core::fmt::Display| raise(format!("{}: {error}", path.display()));
    let engine = open(engine, 1)?;
    let (mut interrupt, raised) = (Interrupt::new(), Raised::default());
    let replayed = py.detach(|| {
        let waits = interrupt.clone();
        let on_tick = &mut |_: &TickEvent<'_>| match interrupt.check_now_and_then() {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                raised.set(error);
                ControlFlow::Break(())
            }
        };
        let file = File::open(&path).map_err(|error| place(&error))?;
        let mut reader = Reader::open(BufReader::new(file)).map_err(|error| place(&error))?;
        let planner = global_planner.as_deref();
        let replay = || inbye::recording::replay(&mut reader, engine, planner, on_tick);
        waits.watch(&raised, replay).map_err(|error| place(&error))
    });
    raised.check()?;
    let replay = replayed?;
    let answer = PyDict::new(py);
    answer.set_item("ticks", replay.ticks)?;
    answer.set_item("agrees", replay.agrees())?;
    answer.set_item("complete", replay.is_complete)?;
    answer.set_item("cpu_ticks", replay.drive.incidents.as_ref().map(|_| replay.cpu_ticks()))?;
    answer.set_item(
        "first_difference",
        replay.first_difference.as_ref().map(|difference| {
            let [recorded, replayed] =
                [&difference.recorded, &difference.replayed].map(ToString::to_string);
            (difference.tick, difference.field, recorded, replayed)
        }),
    )?;
    Ok(answer)
}
