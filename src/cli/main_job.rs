//! No command at all: the main job on built-in scenes.
use super::arguments::Arguments;
/// x
pub fn run(_a: &Arguments) -> anyhow::Result<bool> { Ok(true) }
