//! Files of simulations and benchmarks: moving obstacles, worlds, records.

use std::path::Path;

use inbye::bench::csv_text;
use inbye::digest::BitDigest;
use inbye::experiment::barn::{parse_cylinders, parse_list};
use inbye::experiment::dynabarn::parse_world;
use inbye::experiment::{CellFile, Manifest, Record, read_record};
use inbye::geometry::Pose;
use inbye::map::{MovingDisc, UnknownPolicy};
use inbye::runtime::Config;
use inbye::sim::MovingObstacles;

use super::{one_line, room};

/// Moving obstacles as JSON.
pub fn obstacles_json(data: &[u8]) {
    obstacles(data, "people.json");
}

/// Moving obstacles as TOML.
pub fn obstacles_toml(data: &[u8]) {
    obstacles(data, "people.toml");
}

/// Obstacles that are read have a radius, a position and a velocity at any time.
fn obstacles(data: &[u8], name: &str) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    let ground = room().obstacles(UnknownPolicy::default());
    let mut walkers = match MovingObstacles::parse(text, name, &ground, 7) {
        Ok(walkers) => walkers,
        Err(error) => return one_line(&error),
    };
    let footprint = Config::default().robot.footprint;
    for time_s in [0.02, 0.1, 1.0, 0.1] {
        for disc in walkers.discs() {
            sound(&disc);
        }
        walkers.step(time_s, &Pose::new(1.0, 1.0, 0.0), &footprint);
    }
}

fn sound(disc: &MovingDisc) {
    assert!(disc.is_valid(), "{disc:?}");
}

/// A world of scripted cylinders. Each has a position at any time.
pub fn dynabarn_world(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match parse_world(text, Path::new("world_0.json")) {
        Err(error) => one_line(&error),
        Ok(world) => {
            assert!(world.start.is_finite(), "{:?}", world.start);
            for cylinder in &world.cylinders {
                for time_s in [0.0, 0.3, 1.0, 17.0, 1e4] {
                    sound(&cylinder.at(time_s));
                }
            }
        }
    }
}

/// The two kinds of tables of the BARN worlds.
pub fn barn_tables(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match parse_list(text, Path::new("worlds.csv")) {
        Err(error) => one_line(&error),
        Ok(worlds) => {
            for world in worlds {
                assert!(world.optimal_time_s > 0.0 && world.optimal_time_s <= 1e6);
            }
        }
    }
    match parse_cylinders(text, Path::new("world_000.csv")) {
        Err(error) => one_line(&error),
        Ok(cylinders) => {
            assert!(!cylinders.is_empty());
            for cylinder in cylinders {
                let inside = |metres: f64| metres.abs() <= 1000.0;
                assert!(inside(cylinder.x_m) && inside(cylinder.y_m), "{cylinder:?}");
                assert!(cylinder.radius_m > 0.0 && inside(cylinder.radius_m));
            }
        }
    }
}

/// A record. Runs that are read and written give the same runs when they are read again.
pub fn record(data: &[u8]) {
    let file = Path::new("runs.csv");
    match read_record(data, file) {
        Err(error) => one_line(&error),
        Ok(Record::Barn(rows) | Record::DynaBarn(rows) | Record::Soak(rows)) => {
            let text = csv_text(&rows);
            let again = read_record(text.as_bytes(), file).expect("what is written can be read");
            let (Record::Barn(again) | Record::DynaBarn(again) | Record::Soak(again)) = again
            else {
                panic!("{}", again.title());
            };
            assert_eq!(csv_text(&again), text);
        }
        Ok(_) => {}
    }
}

/// The files of a sweep: the list of its cells, and the result of one. Reading and writing them keeps their content.
pub fn sweep_files(data: &[u8]) {
    let file = Path::new("sweep.json");
    match Manifest::parse(data, file) {
        Err(error) => one_line(&error),
        Ok(manifest) => {
            let again = Manifest::parse(manifest.text().as_bytes(), file);
            assert_eq!(again.as_ref(), Ok(&manifest));
            assert!(manifest.keys().len() <= manifest.cells.len());
        }
    }
    // With a correct digest of the line, the checks after that of the digest run too.
    let text = String::from_utf8_lossy(data);
    let line = text.lines().next().unwrap_or_default();
    let mut digest = BitDigest::default();
    digest.text(line);
    let signed = format!("{line}\n{}\n", digest.hex());
    let key = serde_json::from_str::<CellFile>(line).map_or(String::new(), |cell| cell.row.key);
    for bytes in [data, signed.as_bytes()] {
        match CellFile::parse(bytes, Path::new("cell.json"), &key) {
            Err(error) => one_line(&error),
            Ok(cell) => {
                let again = CellFile::parse(cell.text().as_bytes(), Path::new("cell.json"), &key);
                assert_eq!(again.as_ref(), Ok(&cell));
            }
        }
    }
}
