//! Memory limit of planning on a large map.

#![cfg(unix)]

use std::process::Command;

use super::program::Workplace;

/// Columns and rows of the map.
const SIDE: usize = 4000;

/// Address space of the whole process, KiB.
const MAX_KIB: usize = 300_000;

/// A map of rooms with a pillar in each, enclosed by a wall.
fn pillars() -> String {
    let mut rows = String::with_capacity(SIDE * (SIDE + 1));
    for row in 0..SIDE {
        let blocked = |column: usize| {
            let edge = [row, column].iter().any(|&at| at == 0 || at == SIDE - 1);
            edge || (row % 40 < 24 && column % 40 < 24)
        };
        rows.extend((0..SIDE).map(|column| if blocked(column) { '#' } else { '.' }));
        rows.push('\n');
    }
    rows
}

fn status(place: &Workplace, max_kib: usize) -> Option<i32> {
    let arguments =
        "plan --map large.txt --resolution 0.1 --start 3,3 --goal 397,397 --radius 0.2 --json";
    let program = assert_cmd::cargo::cargo_bin!("inbye").display().to_string();
    Command::new("sh")
        .arg("-c")
        .arg(format!("ulimit -v {max_kib} && exec '{program}' {arguments} >plan.json"))
        .current_dir(place.path(""))
        .env("RUST_BACKTRACE", "0")
        .stderr(std::process::Stdio::null())
        .status()
        .expect("a shell")
        .code()
}

#[test]
fn map_of_16_million_cells_is_planned_within_300_mb() {
    let place = Workplace::new();
    place.write("large.txt", pillars());
    assert_eq!(status(&place, MAX_KIB), Some(0));
    // The limit is effective: a third of it is not enough.
    assert_ne!(status(&place, MAX_KIB / 3), Some(0));
}
