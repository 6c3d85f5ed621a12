//! World files, valid and damaged.

use std::fs;
use std::path::Path;

use inbye::experiment::barn::{Published, read_worlds};
use tempfile::TempDir;

use super::Test;

pub const TESTS: &[Test] = &[
    ("worlds are read in the order of their numbers", reads),
    ("a damaged list is rejected with file and place", refuses),
    ("damaged cylinders are rejected with file and place", refuses_cylinders),
    ("a folder without its files is rejected", refuses_folders),
];

const LIST: &str = "world,official50,n_obstacle_cylinders,path_length_m,optimal_time_s,dwa_success,dwa_collision,\
    dwa_timeout,dwa_mean_time_s,dwa_metric\n\
    12,1,2,12.0,6.0,0.90,0.10,0.00,20.5,0.1500\n\
    3,0,1,11.001,5.5003,,,,,\n";
const TWELVE: &str = "x_m,y_m,radius_m,kind\n-0.075,0.075,0.075,wall\n-2.0,6.5,0.075,obstacle\n";
const THREE: &str = "x_m,y_m,radius_m,kind\n-1,7,0.5,obstacle\n";

fn folder(changes: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let whole =
        [("worlds.csv", LIST), ("worlds/world_012.csv", TWELVE), ("worlds/world_003.csv", THREE)];
    for (name, text) in whole.iter().chain(changes) {
        write(folder.path(), name, text);
    }
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("as below");
    fs::write(path, text).expect("the folder can be written to");
}

fn reads() {
    let folder = folder(&[]);
    let worlds = read_worlds(folder.path(), None).expect("whole files");
    let numbers: Vec<u32> = worlds.iter().map(|world| world.number).collect();
    assert_eq!(numbers, [3, 12]);
    assert_eq!((worlds[0].cylinders.len(), worlds[1].cylinders.len()), (1, 2));
    assert_eq!(worlds[1].cylinders[1].y_m, 6.5);
    assert_eq!(worlds[1].optimal_time_s, 6.0);
    assert_eq!((worlds[0].official, worlds[0].published), (false, None));
    let published = Published { success: 0.9, collided: 0.1, timeout: 0.0, score: 0.15 };
    assert_eq!((worlds[1].official, worlds[1].published), (true, Some(published)));
    let only = read_worlds(folder.path(), Some(&[12])).expect("it is listed");
    assert_eq!(only.len(), 1);
    assert_eq!(only[0], worlds[1]);
}

fn refuses() {
    let list = |from: &str, to: &str| LIST.replace(from, to);
    for (text, words) in [
        (String::new(), "no column `world`"),
        (list("optimal_time_s", "time"), "line 1: no column `optimal_time_s`"),
        ("world,path_length_m,optimal_time_s\n".to_owned(), "holds no world"),
        (list("12.0,6.0", "12.0,NaN"), "line 2: optimal_time_s is \"NaN\""),
        (list("12.0,6.0", "0,0"), "line 2: path_length_m is \"0\": it must be above zero"),
        (
            list("12.0,6.0", "12.0,7.0"),
            "line 2: optimal_time_s is \"7.0\": it must be path_length_m at 2 m/s",
        ),
        (list("\n3,0", "\n-3,0"), "line 3: world is \"-3\": it must be a whole number"),
        (list("\n3,0", "\n12,0"), "line 3: world is \"12\": it must be listed once"),
        (list("0.90,", "1.90,"), "line 2: dwa_success is \"1.90\": it must be 0 to 1"),
        (list("20.5,0.1500", "20.5"), "line 2: 9 fields; expected 10"),
    ] {
        refuse("worlds.csv", &text, words);
    }
}

fn refuses_cylinders() {
    let twelve = |from: &str, to: &str| TWELVE.replace(from, to);
    for (text, words) in [
        (twelve("radius_m", "r"), "no column `radius_m`"),
        ("x_m,y_m,radius_m\n".to_owned(), "holds no cylinder"),
        (twelve("6.5", "inf"), "line 3: y_m is \"inf\": it must be -1000 to 1000"),
        (twelve("6.5", "here"), "line 3: y_m is \"here\""),
        (twelve("0.075,wall", "0,wall"), "line 2: radius_m is \"0\": it must be above zero"),
        (twelve("6.5,", ""), "line 3: 3 fields; expected 4"),
    ] {
        refuse("worlds/world_012.csv", &text, words);
    }
}

/// Checks the error for a folder with one damaged file.
fn refuse(name: &str, text: &str, words: &str) {
    let folder = folder(&[(name, text)]);
    let error = read_worlds(folder.path(), None).expect_err(words).to_string();
    assert!(error.contains(words) && error.contains(name), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}

fn refuses_folders() {
    let folder = folder(&[]);
    fs::remove_file(folder.path().join("worlds/world_003.csv")).expect("it is there");
    let error = read_worlds(folder.path(), None).expect_err("a world is gone").to_string();
    assert!(error.contains("world_003.csv: cannot be read"), "{error}");
    assert!(read_worlds(folder.path(), Some(&[12])).is_ok());
    let error = read_worlds(folder.path(), Some(&[12, 5])).expect_err("no world 5").to_string();
    assert!(error.contains("world 5 is not among the 2") && error.contains("3, 12"), "{error}");
    let empty = tempfile::tempdir().expect("a place for temporary files");
    let error = read_worlds(empty.path(), None).expect_err("nothing there").to_string();
    assert!(error.contains("worlds.csv: cannot be read"), "{error}");
    fs::write(empty.path().join("worlds.csv"), [0xff, 0xfe, b'\n']).expect("a file");
    let error = read_worlds(empty.path(), None).expect_err("no text").to_string();
    assert!(error.contains("line 1: not UTF-8 text"), "{error}");
}
