//! The planners and simulators of `examples/` drive.
//!
//! They need a Python with numpy, pyrvo, mujoco and ir-sim: the one that `tests/run` made in `target/planners`, or the one that
//! `INBYE_PLANNERS_PYTHON` names. Without one the trials are ignored, or fail if `INBYE_REQUIRE` contains `planners`.

use std::path::Path;
use std::process::Command;

use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use crate::support::python::Python;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
static PYTHON: Python = Python::with(
    "numpy, pyrvo, mujoco, irsim",
    "INBYE_PLANNERS_PYTHON",
    &[concat!(env!("CARGO_MANIFEST_DIR"), "/target/planners/bin/python"), "python3"],
    "planners",
);

/// Simulated time of a drive, seconds.
const DRIVES_S: f64 = 10.0;

/// Simulated time in which a controller reaches a goal with a yaw 5 m ahead, seconds. Controllers that ignored the yaw took over 25 s.
const TURNS_S: f64 = 20.0;

const CONTROLLERS: [&str; 6] =
    ["stop_and_go", "dwa_points", "regulated_pure_pursuit", "vfh_plus", "mppi", "orca"];

const DEAD_END: [&str; 4] = ["--scene", "dead_end", "--obstacles", "0"];

const GOAL_WITH_YAW: [&str; 6] =
    ["--scene", "dead_end", "--obstacles", "0", "--goal", "7.5,7.4,-2"];

const SIMULATORS: [&str; 3] = ["unicycle", "mujoco_skid_steer", "irsim_people"];

pub fn trials() -> Vec<Trial> {
    let controllers = CONTROLLERS.map(|name| {
        Trial::ignorable_test(format!("controller_{name}_drives"), move || {
            PYTHON.run(|python| {
                drives(python, "--controller", &format!("planners/{name}.py"), &DEAD_END)
            })
        })
    });
    let turns = CONTROLLERS.map(|name| {
        Trial::ignorable_test(format!("controller_{name}_turns_to_the_goal_yaw"), move || {
            PYTHON.run(|python| reaches_goal_with_yaw(python, &format!("planners/{name}.py")))
        })
    });
    let simulators = SIMULATORS.map(|name| {
        Trial::ignorable_test(format!("inbye_drives_in_simulator_{name}"), move || {
            PYTHON.run(|python| {
                drives(python, "--simulator", &format!("simulators/{name}.py"), &DEAD_END)
            })
        })
    });
    let turned =
        Trial::ignorable_test("simulator_irsim_people_has_the_walls_of_a_turned_map", || {
            PYTHON.run(drives_in_a_turned_room)
        });
    controllers.into_iter().chain(turns).chain(simulators).chain([turned]).collect()
}

/// In a room of 8 m by 4 m whose map is turned by 0.6 rad, from one end to the other.
fn drives_in_a_turned_room(python: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let wall = "0 ".repeat(160);
    let inside = format!("0 {}0\n", "254 ".repeat(158));
    let image = format!("P2\n160 80\n255\n{wall}\n{}{wall}\n", inside.repeat(78));
    std::fs::write(folder.path().join("room.pgm"), image)?;
    let map = folder.path().join("room.yaml");
    let place = "image: room.pgm\nresolution: 0.05\norigin: [-2.0, -1.0, 0.6]\n";
    std::fs::write(&map, format!("{place}negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"))?;
    let map = map.display().to_string();
    let way = ["--start=-2.304,1.215,0.6", "--goal=2.648,4.603"];
    let place = ["--map", &map, way[0], way[1]];
    drives(python, "--simulator", "simulators/irsim_people.py --people 0", &place)
}

/// The robot stands at the goal with its yaw, without contact.
fn reaches_goal_with_yaw(python: &Path, example: &str) -> Result<(), Failed> {
    let object = drive(python, "--controller", example, &GOAL_WITH_YAW, TURNS_S)?;
    if object["reached"] != true || object["collided"] != false {
        return Err(format!("{example}: {object}").into());
    }
    Ok(())
}

/// The robot drives more than two metres without contact, twice with the same bits.
fn drives(python: &Path, option: &str, example: &str, place: &[&str]) -> Result<(), Failed> {
    let object = drive(python, option, example, place, DRIVES_S)?;
    let travelled_m = object["travelled_m"].as_f64().unwrap_or_default();
    let has_failed = !object["fault"].is_null() || object["collided"] != false;
    if has_failed || travelled_m < 2.0 {
        return Err(format!("{example}: {object}").into());
    }
    let again = drive(python, option, example, place, DRIVES_S)?;
    if again["trace_digest"] != object["trace_digest"] {
        return Err(format!("{example}: two drives differ").into());
    }
    Ok(())
}

/// The JSON object of a drive with an example.
fn drive(
    python: &Path,
    option: &str,
    example: &str,
    place: &[&str],
    limit_s: f64,
) -> Result<Value, Failed> {
    let command = format!("{} {ROOT}/examples/{example}", python.display());
    let limit_s = limit_s.to_string();
    let output = Command::new(env!("CARGO_BIN_EXE_inbye"))
        .args(["drive", "--engine", "cpu", "--quiet", "--json"])
        .args(place)
        .args(["--time-limit", &limit_s, option, &command])
        .output()?;
    let object = serde_json::from_slice(&output.stdout);
    Ok(object.map_err(|error| format!("{example}: {error}: {output:?}"))?)
}
