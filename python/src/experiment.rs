//! Plans of experiments, run with controllers in Python.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use inbye::ReportFolder;
use inbye::experiment::{
    Cell, ExperimentError, Grid, Manifest, Plan, RunRow, check_programs, open_engine,
    planner_names as names_of, rankings, run_cell, run_in_order_checked,
};
use inbye::input_file::read_text;
use inbye::local::SharedEngines;
use inbye::report::{ComparisonReport, comparison_files};
use inbye::runtime::{Decider, parse_toml};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyType};
use serde::Serialize;

use super::controller::{PythonController, Raised};
use super::conversion::{from_json, raise, whole};
use super::drive::World;
use super::interrupt::Interrupt;
use super::settings::toml_text;

/// Most runs at a time, as for `--jobs`.
const MOST_JOBS: usize = 1024;

/// A plan from its file, a dictionary or a TOML text, and the folder that its paths are relative to.
fn read(plan: &Bound<'_, PyAny>) -> PyResult<(Plan, PathBuf)> {
    let parse = |text: &str| parse_toml(text, &Plan::default(), Plan::check);
    if let Ok(plan) = plan.cast::<PyMapping>() {
        return Ok((parse(&toml_text(plan)?).map_err(raise)?, PathBuf::new()));
    }
    let path: PathBuf =
        plan.extract().map_err(|_| raise("a plan is the path of a TOML file, or a dictionary"))?;
    let in_file = |error: &dyn std::fmt::Display| raise(format!("{}: {error}", path.display()));
    let text = read_text(&path).map_err(|error| in_file(&error))?;
    let plan = parse(&text).map_err(|error| in_file(&error))?;
    Ok((plan, path.parent().unwrap_or(Path::new("")).to_owned()))
}

/// The worlds of a plan.
#[pyfunction]
pub fn read_worlds(py: Python<'_>, plan: &Bound<'_, PyAny>) -> PyResult<Vec<World>> {
    let (plan, folder) = read(plan)?;
    let worlds = py.detach(|| plan.read_worlds(&folder)).map_err(raise)?;
    Ok(worlds.into_iter().map(|inner| World { inner }).collect())
}

/// The controllers with their names, each of which is that of one planner only: the ranking merges rows of one name.
fn named_controllers<'py>(
    controllers: Option<&Bound<'py, PyMapping>>,
    cells: &[Cell],
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let Some(controllers) = controllers else { return Ok(Vec::new()) };
    let rows: Vec<RunRow> = cells.iter().map(|cell| cell.row.clone()).collect();
    let taken: BTreeSet<String> = names_of(&rows).into_iter().collect();
    let named = |item: Bound<'py, PyAny>| {
        let (name, controller): (Bound<'py, PyAny>, Bound<'py, PyAny>) = item.extract()?;
        let name: String = name.extract().unwrap_or_default();
        if name.is_empty() {
            return Err(raise("controllers: a name is empty or no text: name each controller"));
        }
        if taken.contains(&name) {
            return Err(raise(format!(
                "controllers: settings of the plan have the name {name} too: rename the controller"
            )));
        }
        Ok((name, controller))
    };
    controllers.items()?.iter().map(named).collect()
}

/// What an exception of a controller ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum OnException {
    /// All runs, and the caller gets it.
    Raise,
    /// Its run, which counts as a failure.
    Fail,
}

impl OnException {
    fn of_argument(text: &str) -> PyResult<Self> {
        match text {
            "raise" => Ok(Self::Raise),
            "fail" => Ok(Self::Fail),
            _ => Err(raise(format!("on_exception is {text}: it must be raise or fail"))),
        }
    }

    /// Raises what ends all runs. Ctrl-C and a call of `sys.exit` always do.
    fn check(self, py: Python<'_>, raised: &Raised) -> PyResult<()> {
        match raised.check() {
            Err(error) if self == Self::Fail && error.is_instance_of::<PyException>(py) => Ok(()),
            result => result,
        }
    }
}

/// A controller of the caller.
struct OwnController<'py> {
    name: String,
    /// The object for all runs, or the class of which each run has one.
    given: Bound<'py, PyAny>,
    /// The object of the first run: it shows before all runs whether there is a controller.
    first: Option<Bound<'py, PyAny>>,
}

impl<'py> OwnController<'py> {
    fn new((name, given): (String, Bound<'py, PyAny>)) -> PyResult<Self> {
        let first = Self::object(&given)?;
        PythonController::compute_method(&first)?;
        Ok(Self { name, given, first: Some(first) })
    }

    /// The object of a run.
    fn object(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        given.cast::<PyType>().map_or_else(|_| Ok(given.clone()), |class| class.call0())
    }

    /// Appends the rows of its runs; with an exception, those of the runs before it.
    fn run(
        mut self,
        tasks: &Grid,
        on_exception: OnException,
        clock: &(impl Fn() -> f64 + Sync),
        rows: &mut Vec<RunRow>,
    ) -> PyResult<()> {
        let (tasks, mut done) = (tasks.with_controller(&self.name), Vec::new());
        let outcome = self.run_each(&tasks.distinct(), on_exception, clock, &mut done);
        rows.extend(rows_of(&tasks, &done));
        outcome
    }

    fn run_each(
        &mut self,
        tasks: &[&Cell],
        on_exception: OnException,
        clock: &(impl Fn() -> f64 + Sync),
        done: &mut Vec<RunRow>,
    ) -> PyResult<()> {
        for cell in tasks {
            let object = self.first.take().map_or_else(|| Self::object(&self.given), Ok)?;
            let controller = PythonController::of(&object)?;
            let raised = controller.raised();
            let controller = Decider::Controller(Box::new(controller));
            let driven = object.py().detach(|| run_cell(cell, controller, &mut { clock }, ""));
            on_exception.check(object.py(), &raised)?;
            done.push(driven.map_err(raise)?.row);
        }
        Ok(())
    }
}

/// The worlds and seeds of a plan with the settings of each world: a controller in Python is what an entry of `configs` is that
/// sets `controller.command` alone.
fn tasks(plan: &Plan, folder: &Path) -> Result<Grid, ExperimentError> {
    let mut plan = plan.clone();
    plan.configs.clear();
    plan.weights.clear();
    plan.sampling.clear();
    plan.engines.truncate(1);
    Grid::new(&plan, folder)
}

/// The rows of a grid's cells, from those of its distinct cells.
fn rows_of(grid: &Grid, distinct: &[RunRow]) -> Vec<RunRow> {
    let by_key: BTreeMap<&str, &RunRow> =
        distinct.iter().map(|row| (row.key.as_str(), row)).collect();
    Manifest::of(grid).rows(|key| by_key.get(key).copied())
}

/// A row with the name of its planner, as the ranking has it.
#[derive(Serialize)]
struct NamedRow<'a> {
    planner: &'a str,
    #[serde(flatten)]
    row: &'a RunRow,
}

/// Rows as Python has them.
fn to_python<'py>(py: Python<'py>, rows: &[RunRow]) -> PyResult<Bound<'py, PyAny>> {
    let names = names_of(rows);
    let named = names.iter().zip(rows).map(|(planner, row)| NamedRow { planner, row });
    from_json(py, &named.collect::<Vec<_>>())
}

/// The attribute of an exception with the rows of the runs before it.
const ROWS_BEFORE: &str = "_inbye_rows";

/// Keeps rows in an exception, which ends a plan: runs of hours must not be lost.
fn keep_rows(py: Python<'_>, error: &PyErr, rows: &[RunRow]) {
    let kept = to_python(py, rows).and_then(|rows| error.value(py).setattr(ROWS_BEFORE, rows));
    // An exception that has no attributes is raised as it is.
    drop(kept);
}

/// As [`run_plan`]; an exception has the rows of the runs before it.
fn rows(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    controllers: Option<&Bound<'_, PyMapping>>,
    options: (i128, &str),
) -> PyResult<(String, Vec<RunRow>)> {
    let mut rows = Vec::new();
    let title = run_plan(py, plan, controllers, options, &mut rows);
    let title = title.inspect_err(|error| keep_rows(py, error, &rows))?;
    Ok((title, rows))
}

/// Appends the rows of a plan's cells, this many at a time, and returns its title. Each controller drives the tasks of the plan
/// after that, one at a time: only one thread executes Python. The second option says what an exception of theirs ends.
fn run_plan(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    controllers: Option<&Bound<'_, PyMapping>>,
    (jobs, on_exception): (i128, &str),
    rows: &mut Vec<RunRow>,
) -> PyResult<String> {
    let on_exception = OnException::of_argument(on_exception)?;
    let jobs = whole("jobs", jobs)?;
    if !(1..=MOST_JOBS).contains(&jobs) {
        return Err(raise(format!("jobs is {jobs}: it must be 1 to {MOST_JOBS}")));
    }
    let (plan, folder) = read(plan)?;
    let mut grid = py.detach(|| Grid::new(&plan, &folder)).map_err(raise)?;
    let controllers = named_controllers(controllers, &grid.cells)?;
    let controllers: Vec<_> =
        controllers.into_iter().map(OwnController::new).collect::<PyResult<_>>()?;
    let tasks = match controllers.len() {
        0 => Grid { cells: Vec::new(), title: String::new() },
        _ => py.detach(|| tasks(&plan, &folder)).map_err(raise)?,
    };
    let (interrupt, raised) = (Interrupt::new(), Raised::default());
    grid.cells.iter_mut().for_each(|cell| interrupt.set_in(&mut cell.world));
    let cells = grid.distinct();
    let check_programs = || check_programs(cells.iter().copied());
    let checked = py.detach(|| interrupt.watch(&raised, check_programs));
    raised.check()?;
    checked.map_err(raise)?;
    let began = Instant::now();
    let clock = || began.elapsed().as_secs_f64();
    let engines = SharedEngines::default();
    let own = |cell: &&Cell| {
        let engine = open_engine(cell, &engines).map_err(raise)?;
        let run = || run_cell(cell, engine, &mut { clock }, "");
        let file = interrupt.watch(&Raised::default(), run).map_err(raise)?;
        Ok(file.row)
    };
    let check = || interrupt.check();
    let (done, outcome) = py.detach(|| run_in_order_checked(&cells, jobs, own, || {}, check));
    rows.extend(rows_of(&grid, &done));
    outcome?;
    for controller in controllers {
        controller.run(&tasks, on_exception, &clock, rows)?;
    }
    Ok(grid.title)
}

/// Runs the cells of a plan, and its tasks with controllers by their names; the figures of each run.
#[pyfunction]
#[pyo3(signature = (plan, controllers=None, *, jobs=1, on_exception="raise"))]
pub fn run<'py>(
    py: Python<'py>,
    plan: &Bound<'py, PyAny>,
    controllers: Option<&Bound<'py, PyMapping>>,
    jobs: i128,
    on_exception: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (_, rows) = rows(py, plan, controllers, (jobs, on_exception))?;
    to_python(py, &rows)
}

/// As [`run`], and the ranking of the planners. With a folder, the page of the comparison is written there.
#[pyfunction]
#[pyo3(signature = (plan, controllers=None, *, jobs=1, on_exception="raise", report=None))]
pub fn compare<'py>(
    py: Python<'py>,
    plan: &Bound<'py, PyAny>,
    controllers: Option<&Bound<'py, PyMapping>>,
    jobs: i128,
    on_exception: &str,
    report: Option<PathBuf>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let unusable = |error| raise(format!("{error:#}"));
    // One that cannot be used is refused before the runs.
    let folder = ReportFolder::of_argument("report", report.as_deref()).map_err(unusable)?;
    let (title, rows) = rows(py, plan, controllers, (jobs, on_exception))?;
    let ranked = py.detach(|| rankings(&rows));
    if report.is_some() {
        let machine: String = py.import("platform")?.call_method0("platform")?.extract()?;
        let files = comparison_files(&ComparisonReport {
            title: &title,
            note: "",
            machine: &machine,
            command: "inbye.bench.compare in Python",
            ranked: &ranked,
            rows: &rows,
            plays: &BTreeMap::new(),
            search: None,
        });
        let written = folder.write_files(&files).map_err(unusable);
        written.inspect_err(|error| keep_rows(py, error, &rows))?;
    }
    Ok((from_json(py, &ranked)?, to_python(py, &rows)?))
}

/// The name of each row's planner, as the ranking has it.
#[pyfunction]
pub fn planner_names(py: Python<'_>, rows: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let text: String = py.import("json")?.call_method1("dumps", (rows,))?.extract()?;
    let rows: Vec<RunRow> = serde_json::from_str(&text).map_err(raise)?;
    Ok(names_of(&rows))
}
