//! The worlds of a folder: `worlds.csv` lists them, `worlds/world_NNN.csv` holds the cylinders of each.

use std::path::Path;

use super::{Course, Cylinder};
use crate::experiment::ExperimentError;
use crate::experiment::csv_file::{CsvFile, CsvLine};
use crate::experiment::plan_worlds::select_worlds;

/// A world and its published figures.
#[derive(Clone, Debug, PartialEq)]
pub struct BarnWorld {
    /// Its number in the benchmark.
    pub number: u32,
    /// Its cylinders.
    pub cylinders: Vec<Cylinder>,
    /// Start, goal and limits.
    pub course: Course,
    /// Time that the benchmark's path takes at 2 m/s, seconds.
    pub optimal_time_s: f64,
    /// Whether it is one of the 50 worlds that the challenge scores.
    pub official: bool,
    /// Figures of the challenge's baseline, where they are listed.
    pub published: Option<Published>,
}

/// Figures of the challenge's dynamic window baseline, at most 0.5 m/s, in one world in Gazebo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// Share of runs that reached the goal.
    pub success: f64,
    /// Share of runs that ended in a collision.
    pub collided: f64,
    /// Share of runs that ran out of time.
    pub timeout: f64,
    /// Mean score, 0 to 0.5.
    pub score: f64,
}

/// Speed that defines the challenge's optimal time, m/s.
pub(in crate::experiment) const OPTIMAL_SPEED: f64 = 2.0;
/// Tolerance of a listed time, seconds: lengths are rounded to 1 mm, times to 0.1 ms.
const LISTED_S: f64 = 6e-4;

/// Reads the worlds that a folder lists, or those with the given numbers, in the order of their numbers.
///
/// # Errors
/// Fails when a file is missing or a field does not fit its column; the message names the file and the line.
pub fn read_worlds(folder: &Path, only: Option<&[u32]>) -> Result<Vec<BarnWorld>, ExperimentError> {
    let file = folder.join("worlds.csv");
    let mut worlds = parse_list(&ExperimentError::read(&file)?, &file)?;
    if worlds.is_empty() {
        return Err(empty(&file, "world"));
    }
    worlds.sort_by_key(|world| world.number);
    select_worlds(&mut worlds, |world| world.number, only, &file)?;
    for world in &mut worlds {
        let name = format!("world_{:03}.csv", world.number);
        let file = folder.join("worlds").join(name);
        world.cylinders = parse_cylinders(&ExperimentError::read(&file)?, &file)?;
    }
    Ok(worlds)
}

fn empty(file: &Path, what: &str) -> ExperimentError {
    ExperimentError::file(file, format!("holds no {what}: check that it is the right file"))
}

/// The lines of a file with these columns.
fn table<'f>(text: &str, file: &'f Path, columns: &[&str]) -> Result<CsvFile<'f>, ExperimentError> {
    let table = CsvFile::parse(text, file)?;
    match table.lacks(columns) {
        None => Ok(table),
        Some(column) => {
            let cure = "check that it is the right file";
            Err(ExperimentError::file(file, format!("line 1: no column `{column}`: {cure}")))
        }
    }
}

/// The worlds in the text of a `worlds.csv`, without their cylinders, in the order of its rows.
///
/// # Errors
/// Fails when a field does not fit its column; the message names the file and the line.
#[doc(hidden)]
pub fn parse_list(text: &str, file: &Path) -> Result<Vec<BarnWorld>, ExperimentError> {
    let table = table(text, file, &["world", "path_length_m", "optimal_time_s"])?;
    let mut worlds: Vec<BarnWorld> = Vec::new();
    for line in table.lines() {
        let above_zero = |value: &f64| *value > 0.0 && *value <= 1e6;
        let expected = "above zero and at most 1e6";
        let length_m = line.number("path_length_m", expected, above_zero)?;
        let optimal_time_s = line.number("optimal_time_s", expected, above_zero)?;
        if (optimal_time_s - length_m / OPTIMAL_SPEED).abs() > LISTED_S {
            return Err(line.bad("optimal_time_s", "path_length_m at 2 m/s"));
        }
        let number = line.number("world", "a whole number, 0 to 4294967295", |_| true)?;
        if worlds.iter().any(|earlier| earlier.number == number) {
            return Err(line.bad("world", "listed once"));
        }
        worlds.push(BarnWorld {
            number,
            cylinders: Vec::new(),
            course: Course::BARN,
            optimal_time_s,
            official: line.text("official50") == "1",
            published: published(&line)?,
        });
    }
    Ok(worlds)
}

/// The published figures of a world: all four, or none.
fn published(line: &CsvLine<'_>) -> Result<Option<Published>, ExperimentError> {
    let mut figures = [0.0; 4];
    let names = ["dwa_success", "dwa_collision", "dwa_timeout", "dwa_metric"];
    for (figure, name) in figures.iter_mut().zip(names) {
        if line.text(name).is_empty() {
            return Ok(None);
        }
        let is_share = |value: &f64| (0.0..=1.0).contains(value);
        *figure = line.number(name, "0 to 1, or nothing", is_share)?;
    }
    let [success, collided, timeout, score] = figures;
    Ok(Some(Published { success, collided, timeout, score }))
}

/// The cylinders in the text of a `world_NNN.csv`, at least one.
///
/// # Errors
/// Fails when a field does not fit its column, or there is no cylinder; the message names the file and the line.
#[doc(hidden)]
pub fn parse_cylinders(text: &str, file: &Path) -> Result<Vec<Cylinder>, ExperimentError> {
    let table = table(text, file, &["x_m", "y_m", "radius_m"])?;
    let near = |value: &f64| value.abs() <= 1000.0;
    let is_radius = |value: &f64| *value > 0.0 && near(value);
    let cylinder = |line: CsvLine<'_>| -> Result<Cylinder, ExperimentError> {
        Ok(Cylinder {
            x_m: line.number("x_m", "-1000 to 1000", near)?,
            y_m: line.number("y_m", "-1000 to 1000", near)?,
            radius_m: line.number("radius_m", "above zero and at most 1000", is_radius)?,
        })
    };
    let cylinders = table.lines().map(cylinder).collect::<Result<Vec<_>, _>>()?;
    if cylinders.is_empty() {
        return Err(empty(file, "cylinder"));
    }
    Ok(cylinders)
}
