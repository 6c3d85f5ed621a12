//! Plans of experiments, run with controllers in Python.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use inbye::experiment::{
    Cell, Grid, Plan, RunRow, check_programs, open_engine, planner_names as names_of, rankings,
    run_cell, run_in_order_checked,
};
use inbye::local::SharedEngines;
use inbye::report::{ComparisonReport, comparison_files};
use inbye::runtime::parse_toml;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyType};

use super::controller::PythonController;
use super::conversion::{from_json, raise};
use super::drive::World;
use super::interrupt::Interrupt;
use super::settings::toml_text;

/// A plan from its file, a dictionary or a TOML text, and the folder that its paths are relative to.
fn read(plan: &Bound<'_, PyAny>) -> PyResult<(Plan, PathBuf)> {
    let parse = |text: &str| parse_toml(text, &Plan::default(), Plan::check);
    if let Ok(plan) = plan.cast::<PyMapping>() {
        return Ok((parse(&toml_text(plan)?).map_err(raise)?, PathBuf::new()));
    }
    let path: PathBuf =
        plan.extract().map_err(|_| raise("a plan is the path of a TOML file, or a dictionary"))?;
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|error| raise(format!("{}: {error}", path.display())))?;
    let plan = parse(&text).map_err(|error| raise(format!("{}: {error}", path.display())))?;
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

/// The rows of a plan's cells, this many at a time. Each controller drives the tasks of the plan after that, one at a time: only
/// one thread executes Python.
fn rows(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    controllers: Option<&Bound<'_, PyMapping>>,
    jobs: usize,
) -> PyResult<(String, Vec<RunRow>)> {
    let (plan, folder) = read(plan)?;
    let mut grid = py.detach(|| Grid::new(&plan, &folder)).map_err(raise)?;
    let controllers = named_controllers(controllers, &grid.cells)?;
    let interrupt = Interrupt::new();
    grid.cells.iter_mut().for_each(|cell| interrupt.set_in(&mut cell.world));
    let cells = grid.distinct();
    py.detach(|| check_programs(cells.iter().copied())).map_err(raise)?;
    let began = Instant::now();
    let clock = || began.elapsed().as_secs_f64();
    let engines = SharedEngines::default();
    let own = |cell: &&Cell| {
        let engine = open_engine(cell, &engines).map_err(raise)?;
        Ok(run_cell(cell, engine, &mut { clock }, "").row)
    };
    let check = || interrupt.check();
    let mut rows = py.detach(|| run_in_order_checked(&cells, jobs.max(1), own, || {}, check))?;
    let task = |cell: &Cell| (cell.row.kind, cell.row.world.clone(), cell.row.seed);
    let tasks: BTreeMap<_, &Cell> = cells.iter().rev().map(|cell| (task(cell), *cell)).collect();
    for (name, controller) in controllers {
        for cell in tasks.values() {
            // A class has an object for each run.
            let object = match controller.cast::<PyType>() {
                Ok(class) => class.call0()?,
                Err(_) => controller.clone(),
            };
            let (controller, raised) = PythonController::of(&object)?;
            let row = py.detach(|| run_cell(cell, controller, &mut { clock }, "").row);
            raised.check()?;
            rows.push(RunRow { config: Some(name.clone()), weights: None, ..row });
        }
    }
    Ok((grid.title, rows))
}

/// Runs the cells of a plan, and its tasks with controllers by their names; the figures of each run.
#[pyfunction]
#[pyo3(signature = (plan, controllers=None, *, jobs=1))]
pub fn run<'py>(
    py: Python<'py>,
    plan: &Bound<'py, PyAny>,
    controllers: Option<&Bound<'py, PyMapping>>,
    jobs: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let (_, rows) = rows(py, plan, controllers, jobs)?;
    from_json(py, &rows)
}

/// As [`run`], and the ranking of the planners. With a folder, the page of the comparison is written there.
#[pyfunction]
#[pyo3(signature = (plan, controllers=None, *, jobs=1, report=None))]
pub fn compare<'py>(
    py: Python<'py>,
    plan: &Bound<'py, PyAny>,
    controllers: Option<&Bound<'py, PyMapping>>,
    jobs: usize,
    report: Option<PathBuf>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (title, rows) = rows(py, plan, controllers, jobs)?;
    let ranked = py.detach(|| rankings(&rows));
    if let Some(folder) = report {
        let machine: String = py.import("platform")?.call_method0("platform")?.extract()?;
        let files = comparison_files(&ComparisonReport {
            title: &title,
            note: "",
            machine: &machine,
            command: "inbye.bench.compare in Python",
            ranked: &ranked,
            rows: &rows,
            plays: &BTreeMap::new(),
        });
        std::fs::create_dir_all(&folder)?;
        for file in files {
            std::fs::write(folder.join(file.name), file.text)?;
        }
    }
    Ok((from_json(py, &ranked)?, from_json(py, &rows)?))
}

/// The name of each row's planner, as the ranking has it.
#[pyfunction]
pub fn planner_names(py: Python<'_>, rows: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let text: String = py.import("json")?.call_method1("dumps", (rows,))?.extract()?;
    let rows: Vec<RunRow> = serde_json::from_str(&text).map_err(raise)?;
    Ok(names_of(&rows))
}
