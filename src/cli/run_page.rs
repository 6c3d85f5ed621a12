//! The page of one run of an experiment: it is driven again, and played.

use std::path::Path;

use anyhow::Context;
use inbye::experiment::{Cell, Run};
use inbye::local::CpuEngine;
use inbye::report::{MissionView, PlaybackRecorder};
use inbye::runtime::Observer;

use super::drive_text;
use super::files::{command_line, open_file};
use super::machine::wall_clock;

/// Drives the run of a cell again on the CPU, and writes its page into the file of a flag. Nothing is written for a run that does
/// not start. The title has the planner's name.
pub fn write(cell: &Cell, planner: Option<&str>, flag: &str, file: &Path) -> anyhow::Result<Run> {
    let mut playback = PlaybackRecorder::default();
    let mut observer =
        Observer { clock: &mut wall_clock(), on_tick: &mut |tick| playback.record(tick) };
    let engine = Box::new(CpuEngine::single_threaded());
    let (world, config, seed) = (&cell.world, &cell.config, cell.row.seed);
    let run = world.drive(seed, config, engine, &mut observer)?;
    if let (Some(drawn), Some(result)) = (&run.simulation, &run.result) {
        let planner = planner.map_or_else(String::new, |name| format!(", {name}"));
        let title = format!("{}, seed {seed}{planner}", world.name);
        let (command, facts) = (&command_line(), &drive_text::facts(result, seed));
        let view = MissionView {
            title: &title,
            command,
            mission: &drawn.simulation.mission,
            config,
            result,
            playback: Some(&playback),
            facts,
        };
        let page = drive_text::page(drive_text::SIMULATED, view);
        let written = open_file(flag, file)?.write(page.as_bytes());
        written.with_context(|| format!("{flag} {}", file.display()))?;
    }
    Ok(run)
}
