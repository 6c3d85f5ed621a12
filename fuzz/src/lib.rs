//! What every parser and decoder must do with any bytes at all: read them or refuse them in a line, never panic, and keep
//! the promises of what it has read. Each function is the body of a fuzz target, and of a test that needs no fuzzer.

pub mod bytes;
pub mod files;
pub mod frames;
pub mod maps;
mod program;
pub mod settings;
pub mod wire;

use core::fmt::Display;

/// A target: the name of its corpus, and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 28] = [
    ("map_yaml", maps::map_yaml),
    ("map_image", maps::map_image),
    ("map_server", maps::map_server),
    ("movingai_map", maps::movingai_map),
    ("text_map", maps::text_map),
    ("scenarios", maps::scenarios),
    ("problem_json", settings::problem_json),
    ("drive_config", settings::drive_config),
    ("short_drive", settings::short_drive),
    ("base_config", settings::base_config),
    ("words", settings::words),
    ("nav2_params", settings::nav2_params),
    ("sweep_plan", settings::sweep_plan),
    ("obstacles_json", files::obstacles_json),
    ("obstacles_toml", files::obstacles_toml),
    ("dynabarn_world", files::dynabarn_world),
    ("barn_tables", files::barn_tables),
    ("record", files::record),
    ("sweep_files", files::sweep_files),
    ("frames_native", frames::native),
    ("frames_wheeltec", frames::wheeltec),
    ("frames_roboclaw", frames::roboclaw),
    ("frames_ld19", frames::ld19),
    ("lines_arduino", frames::arduino),
    ("wire_native", wire::native),
    ("wire_wheeltec", wire::wheeltec),
    ("wire_roboclaw", wire::roboclaw),
    ("wire_arduino", wire::arduino),
];

/// A refusal must be one line.
pub fn one_line(error: &impl Display) {
    let said = error.to_string();
    assert!(!said.is_empty() && !said.contains('\n'), "{said:?}");
}
