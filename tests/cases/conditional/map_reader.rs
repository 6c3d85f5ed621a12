//! Comparison of map files cell by cell with an independent reader in Python.
//!
//! The reader needs a Python with numpy and Pillow: `python3`, `/usr/bin/python3`, or the one that `INBYE_PYTHON` names.
//! Without one the trials are ignored, or fail if the variable `INBYE_REQUIRE` contains `python`. Generated maps
//! are always compared; public maps only if the development data are next to the repository.

use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::map_kinds::{KINDS, Kind};
use crate::support::python::Python;
use crate::support::trials::{DATA, with_data};
use inbye::geometry::Pose;
use inbye::map::{
    Cell, GridFrame, LoadOptions, OccupancyGrid, cell_from_top_left, load, read_scen,
};
use libtest_mimic::{Failed, Trial};
use sha2::{Digest, Sha256};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/reference_map_reader.py");
static PYTHON: Python =
    Python::with("numpy, PIL", "INBYE_PYTHON", &["python3", "/usr/bin/python3"], "python");

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = KINDS.iter().map(generated).collect();
    trials.push(Trial::ignorable_test("one altered cell is detected", || {
        PYTHON.run(one_altered_cell)
    }));
    trials.extend(public());
    trials
}

/// Compares all map settings for one kind of image.
fn generated(kind: &'static Kind) -> Trial {
    Trial::ignorable_test(format!("generated: {}", kind.name), || {
        PYTHON.run(|python| {
            let folder = tempfile::tempdir()?;
            compare(python, &kind.write(folder.path())?)
        })
    })
}

/// Checks that the comparison detects one altered cell and an altered origin.
fn one_altered_cell(python: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let maps = KINDS[0].write(folder.path())?;
    let grid = load(&maps[0], &LoadOptions::default())?;
    let reading = &reference(python, &maps[..1])?[0];
    differ(&grid, reading)?;
    let frame = *grid.frame();
    for index in [0, frame.len() / 2, frame.len() - 1] {
        let mut cells = grid.cells().to_vec();
        cells[index] = if cells[index] == 100 { 0 } else { 100 };
        if differ(&OccupancyGrid::new(frame, cells), reading).is_ok() {
            return Err(format!("the altered cell {index} was not detected").into());
        }
    }
    let moved = GridFrame {
        origin: Pose::new(frame.origin.x.next_up(), frame.origin.y, frame.origin.yaw),
        ..frame
    };
    match differ(&OccupancyGrid::new(moved, grid.cells().to_vec()), reading) {
        Ok(()) => Err("the altered origin was not detected".into()),
        Err(_) => Ok(()),
    }
}

/// One trial for each public map, or one ignored trial without the data.
fn public() -> Vec<Trial> {
    let data = Path::new(DATA);
    let mut maps = files(&data.join("rosmaps"), "yaml");
    maps.extend(files(&data.join("mine"), "yaml"));
    maps.extend(files(&data.join("mine"), "map"));
    maps.extend(files(&data.join("movingai/dao"), "map"));
    if maps.is_empty() {
        return vec![with_data("public maps", "rosmaps", |_| Err("it has no map".into()))];
    }
    let scenarios = Trial::test("public: queries start and end on free cells", || {
        queries_fit_their_maps(Path::new(DATA))
    });
    let trial = |map: PathBuf| {
        let name = map.strip_prefix(data).unwrap_or(&map).display().to_string();
        Trial::ignorable_test(format!("public: {name}"), || {
            PYTHON.run(move |python| compare(python, &[map]))
        })
    };
    maps.into_iter().map(trial).chain([scenarios]).collect()
}

/// Checks that queries end on free cells; a flipped map or swapped coordinates would violate this.
fn queries_fit_their_maps(data: &Path) -> Result<(), Failed> {
    let mut queries = 0;
    for folder in ["movingai/dao", "movingai/da2", "movingai/bg512", "movingai/mazes", "mine"] {
        for scen in files(&data.join(folder), "scen") {
            let grid = load(&scen.with_extension(""), &LoadOptions::default())?;
            let frame = grid.frame();
            for query in read_scen(&scen)? {
                let ends = [query.start, query.goal].map(|end| cell_from_top_left(frame, end));
                let free = |&cell: &Cell| grid.get(cell) == Some(&0);
                if (query.width, query.height) != (frame.width, frame.height)
                    || !ends.iter().all(free)
                {
                    return Err(format!("{}: {query:?}", scen.display()).into());
                }
                queries += 1;
            }
        }
    }
    if queries > 0 { Ok(()) } else { Err("no query was read".into()) }
}

/// The files of a folder with this extension, sorted; none if the folder does not exist.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension() == Some(OsStr::new(extension)))
        .collect();
    files.sort();
    files
}

fn compare(python: &Path, maps: &[PathBuf]) -> Result<(), Failed> {
    for (map, reading) in maps.iter().zip(reference(python, maps)?) {
        let grid = load(map, &LoadOptions::default())?;
        differ(&grid, &reading).map_err(|what| format!("{}: {what}", map.display()))?;
    }
    Ok(())
}

/// A map as read by the Python reader.
#[derive(Debug, PartialEq)]
struct Reading {
    frame: GridFrame,
    sha256: String,
}

/// Returns an error that describes the difference between the grid and the reading, if any.
fn differ(grid: &OccupancyGrid, reading: &Reading) -> Result<(), String> {
    let bytes: Vec<u8> = grid.cells().iter().map(|&cell| cell as u8).collect();
    let mut sha256 = String::new();
    for byte in Sha256::digest(&bytes) {
        write!(sha256, "{byte:02x}").map_err(|error| error.to_string())?;
    }
    let own = Reading { frame: *grid.frame(), sha256 };
    if own == *reading {
        Ok(())
    } else {
        Err(format!("inbye read {own:?}, Python read {reading:?}"))
    }
}

fn reference(python: &Path, maps: &[PathBuf]) -> Result<Vec<Reading>, Failed> {
    let output = Command::new(python).arg(SCRIPT).args(maps).output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    let text = String::from_utf8(output.stdout)?;
    let readings: Vec<Reading> = text.lines().map(reading).collect::<Result<_, _>>()?;
    if readings.len() == maps.len() {
        Ok(readings)
    } else {
        Err(format!("{} readings of {} maps", readings.len(), maps.len()).into())
    }
}

fn reading(line: &str) -> Result<Reading, Failed> {
    let fields: Vec<&str> = line.split(' ').collect();
    let &[width, height, resolution, x, y, yaw, sha256] = fields.as_slice() else {
        return Err(format!("not a reading: {line}").into());
    };
    let origin = Pose::new(x.parse()?, y.parse()?, yaw.parse()?);
    Ok(Reading {
        frame: GridFrame::new(width.parse()?, height.parse()?, resolution.parse()?, origin)?,
        sha256: sha256.into(),
    })
}
