//! The worlds of a folder: `worlds.csv` lists them, `worlds/world_NNN.csv` holds the cylinders of each.

use std::path::Path;

use super::table::{Table, TableRow};
use super::{BarnError, Course, Cylinder};
use crate::experiment::world_numbers::select_worlds;

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
const OPTIMAL_SPEED: f64 = 2.0;
/// Tolerance of a listed time, seconds: lengths are rounded to 1 mm, times to 0.1 ms.
const LISTED_S: f64 = 6e-4;

/// Reads the worlds that a folder lists, or those with the given numbers, in the order of their numbers.
///
/// # Errors
/// Fails when a file is missing or a field does not fit its column; the message names the file and the line.
pub fn read_worlds(folder: &Path, only: Option<&[u32]>) -> Result<Vec<BarnWorld>, BarnError> {
    let file = folder.join("worlds.csv");
    let table = Table::read(&file)?;
    let mut worlds = listed(&table)?;
    if worlds.is_empty() {
        let what = "world";
        return Err(BarnError::NoRow { file, what });
    }
    worlds.sort_by_key(|world| world.number);
    select_worlds(&mut worlds, |world| world.number, only, &file)?;
    for world in &mut worlds {
        let name = format!("world_{:03}.csv", world.number);
        let file = folder.join("worlds").join(name);
        world.cylinders = cylinders(&Table::read(&file)?, &file)?;
    }
    Ok(worlds)
}

/// The worlds in the text of a `worlds.csv`, without their cylinders, in the order of its rows.
///
/// # Errors
/// Fails when a field does not fit its column; the message names the file and the line.
pub fn parse_list(text: &str, file: &Path) -> Result<Vec<BarnWorld>, BarnError> {
    listed(&Table::parse(text, file)?)
}

/// The cylinders in the text of a `world_NNN.csv`, at least one.
///
/// # Errors
/// Fails when a field does not fit its column, or there is no cylinder; the message names the file and the line.
pub fn parse_cylinders(text: &str, file: &Path) -> Result<Vec<Cylinder>, BarnError> {
    cylinders(&Table::parse(text, file)?, file)
}

/// The rows of `worlds.csv`, without their cylinders.
fn listed(table: &Table) -> Result<Vec<BarnWorld>, BarnError> {
    let number = table.column("world")?;
    let length = table.column("path_length_m")?;
    let time = table.column("optimal_time_s")?;
    let official = table.optional_column("official50");
    let mut worlds: Vec<BarnWorld> = Vec::new();
    for row in table.rows() {
        let above_zero = |value: f64| value > 0.0 && value <= 1e6;
        let expected = "above zero and at most 1e6";
        let length_m = row.real(length, expected, above_zero)?;
        let optimal_time_s = row.real(time, expected, above_zero)?;
        if (optimal_time_s - length_m / OPTIMAL_SPEED).abs() > LISTED_S {
            return Err(row.bad(time, "path_length_m at 2 m/s"));
        }
        let world = row.whole(number)?;
        if worlds.iter().any(|earlier| earlier.number == world) {
            return Err(row.bad(number, "listed once"));
        }
        worlds.push(BarnWorld {
            number: world,
            cylinders: Vec::new(),
            course: Course::BARN,
            optimal_time_s,
            official: official.is_some_and(|column| row.text(column) == "1"),
            published: published(table, &row)?,
        });
    }
    Ok(worlds)
}

/// The published figures of a row: all four, or none.
fn published(table: &Table, row: &TableRow) -> Result<Option<Published>, BarnError> {
    let names = ["dwa_success", "dwa_collision", "dwa_timeout", "dwa_metric"];
    let mut figures = [0.0; 4];
    for (figure, name) in figures.iter_mut().zip(names) {
        let Some(column) = table.optional_column(name) else {
            return Ok(None);
        };
        let share = |value: f64| (0.0..=1.0).contains(&value);
        match row.optional_real(column, "0 to 1, or nothing", share)? {
            Some(value) => *figure = value,
            None => return Ok(None),
        }
    }
    let [success, collided, timeout, score] = figures;
    Ok(Some(Published { success, collided, timeout, score }))
}

fn cylinders(table: &Table, file: &Path) -> Result<Vec<Cylinder>, BarnError> {
    let [x, y] = [table.column("x_m")?, table.column("y_m")?];
    let radius = table.column("radius_m")?;
    let near = |value: f64| value.abs() <= 1000.0;
    let cylinder = |row: TableRow| -> Result<Cylinder, BarnError> {
        Ok(Cylinder {
            x_m: row.real(x, "-1000 to 1000", near)?,
            y_m: row.real(y, "-1000 to 1000", near)?,
            radius_m: row
                .real(radius, "above zero and at most 1000", |value| value > 0.0 && near(value))?,
        })
    };
    let cylinders = table.rows().map(cylinder).collect::<Result<Vec<_>, _>>()?;
    if cylinders.is_empty() {
        return Err(BarnError::NoRow { file: file.to_owned(), what: "cylinder" });
    }
    Ok(cylinders)
}
