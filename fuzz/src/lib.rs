//! Requirements of every parser and decoder for arbitrary bytes: it reads or rejects them with a message of one line, never
//! panics, and returns values within their documented ranges. Each function is the body of a fuzz target, and of a test that
//! needs no fuzzer.

pub mod bytes;
pub mod files;
pub mod frames;
pub mod maps;
pub mod node;
mod program;
pub mod settings;
pub mod wire;

use core::fmt::Display;
use std::sync::OnceLock;

use inbye::geometry::Pose;
use inbye::map::OccupancyGrid;

/// A target: the name of its corpus, and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 30] = [
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
    ("node_messages", node::messages),
    ("node_conversation", node::conversation),
];

/// Checks that an error message is one line.
pub fn one_line(error: &impl Display) {
    let message = error.to_string();
    assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
}

/// A room of 6 by 4 metres with a pillar.
fn room() -> &'static OccupancyGrid {
    static ROOM: OnceLock<OccupancyGrid> = OnceLock::new();
    ROOM.get_or_init(|| {
        let mut rows = vec![".".repeat(30); 20];
        for row in &mut rows[8..12] {
            row.replace_range(13..17, "####");
        }
        OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a sound map")
    })
}
