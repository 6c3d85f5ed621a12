//! `inbye replay`.

use core::ops::ControlFlow;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use anyhow::{Context, ensure};
use clap::Args;
use inbye::recording::{Difference, FieldValue, Reader, RecordingError, replay};
use inbye::report::{MissionView, PlaybackRecorder};
use inbye::runtime::TickEvent;
use serde_json::{Value, json};

use super::arguments::EngineArguments;
use super::drive_pictures::{PictureArguments, Pictures};
use super::drive_text::gpu_facts;
use super::files::command_line;
use super::output;
use super::own_programs::{Words, words};
use super::refusal::refused;

/// Introduction of the page of a recording.
const REPLAYED: &str = "One mission, replayed from its recording, as the robot knew it: poses are estimated, gaps are those to the map, and \
    moving obstacles are shown where they were predicted.";

/// `inbye replay`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye drive --scene mine --record run.mcap\n  \
    inbye replay run.mcap --engine cpu --json\n  \
    inbye replay run.mcap --report out\n\n\
    The navigator is created from the configuration, waypoints and map in the file and gets the recorded observations; every \
    number that it decides is compared with the recorded one. Decision times and the arrival of plans are repeated too, so a \
    drive with a deadline or on a real base (--port) replays as well.\n\
    The answers of a controller are recorded, so its program does not run. A global planner runs again, and only with \
    --global-planner: a recording of another person must not run a command on this machine.\n\
    `complete` is false for a file that was truncated or whose recording stopped: it is replayed up to its end.\n\
    A GPU has the CPU as fallback, so that the rest of the recording is still compared after a GPU failure. Then the CPU decided some \
    ticks, and the replay is no proof for that GPU: `cpu_ticks` counts them, and the exit status is 1.\n\
    Exit status: 0 all bits agree; 1 they differ, or the CPU decided ticks in place of a GPU; 2 the file cannot be used.")]
pub struct ReplayArguments {
    /// The recording: a file of `inbye drive --record FILE.mcap`.
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    #[command(flatten)]
    pub engine: EngineArguments,
    /// Program that planned the paths of the drive, as in `inbye drive`. It runs again; the command in the recording is not used.
    #[arg(long, value_name = "COMMAND", value_parser = words)]
    pub global_planner: Option<Words>,
    #[command(flatten)]
    pub pictures: PictureArguments,
}

/// Repeats the decisions of a recording. Returns false if a bit differs, or the CPU decided in place of a GPU.
pub fn run(arguments: &ReplayArguments) -> anyhow::Result<bool> {
    let name = || format!("{}", arguments.file.display());
    let file = File::open(&arguments.file).map_err(|error| {
        refused(format!("{}: cannot be read", name()), error, "name a recording")
    })?;
    let is_folder = file.metadata().with_context(name)?.is_dir();
    ensure!(!is_folder, "{}: is a folder: name a recording in it", name());
    let mut recording = Reader::open(BufReader::new(file)).with_context(name)?;
    let engine = arguments.engine.open_to_replay(&recording.metadata().config)?;
    let recorded_engine = recording.metadata().engine.clone();
    let pictures = Pictures::create(&arguments.pictures)?;
    let config = recording.metadata().config.clone();
    let mut playback = pictures.are_requested.then(PlaybackRecorder::default);
    let mut on_tick = |tick: &TickEvent<'_>| {
        if let Some(playback) = &mut playback {
            playback.record(tick);
        }
        ControlFlow::Continue(())
    };
    let planner = arguments.global_planner.as_ref().map(Words::command);
    let replay = replay(&mut recording, engine, planner, &mut on_tick)
        .map_err(with_option)
        .with_context(name)?;
    let (ticks, engine) = (replay.ticks, &replay.engine);
    let difference = replay.first_difference.as_ref();
    let (incidents, cpu_ticks) = (replay.drive.incidents.as_ref(), replay.cpu_ticks());
    let mut lines = vec![match difference {
        None if cpu_ticks > 0 => format!(
            "the same bits in all {ticks} ticks, but the CPU decided {cpu_ticks} of them in place of the GPU"
        ),
        None => format!("the same bits in all {ticks} ticks"),
        Some(Difference { tick, time_s, field, recorded, replayed, .. }) => format!(
            "DIFFERS first at tick {tick} of {ticks}, at {time_s:.3} s: {field} was {}, is {}",
            with_hex(recorded),
            with_hex(replayed),
        ),
    }];
    lines.push(format!("recorded on  {recorded_engine}"));
    lines.push(format!("replayed on  {engine}"));
    if let Some(incidents) = incidents.filter(|incidents| incidents.total() > 0) {
        lines.extend(gpu_facts(incidents).iter().map(|(name, fact)| format!("{name:<12} {fact}")));
    }
    if !replay.is_complete {
        lines.push(format!(
            "the recording is truncated: it ends with tick {}, before the end of the drive",
            ticks - 1
        ));
    }
    let object = json!({
        "ticks": ticks,
        "agree": replay.agrees(),
        "engine": engine,
        "recorded_engine": recorded_engine,
        "first_difference": difference.map(difference_object),
        "complete": replay.is_complete,
        "gpu_losses": incidents.map(|incidents| &incidents.failures),
        "gpu_incidents": incidents.map(|incidents| &incidents.messages),
        "cpu_ticks": incidents.map(|_| cpu_ticks),
    });
    output::result(&object, lines)?;
    if let Some(playback) = &playback {
        // The recording does not tell what else ended a drive.
        let drive = &replay.drive;
        let is_known = drive.early_end.is_some() || drive.fault.is_some();
        let why = drive.why().filter(|_| is_known).map(|why| ("Why not reached".to_owned(), why));
        let facts: Vec<(String, String)> = why.into_iter().collect();
        let view = MissionView {
            title: &name(),
            command: &command_line(),
            mission: &replay.mission,
            config: &config,
            result: &replay.drive,
            playback: Some(playback),
            facts: &facts,
        };
        pictures.write(REPLAYED, view, playback)?;
    }
    Ok(replay.agrees() && cpu_ticks == 0)
}

/// Adds the command-line option that avoids an error.
fn with_option(error: RecordingError) -> anyhow::Error {
    let option = match &error {
        RecordingError::PlannerNotGiven { .. } => "--global-planner COMMAND",
        RecordingError::NoPlanner => "--global-planner",
        _ => return error.into(),
    };
    anyhow::anyhow!("{error} ({option})")
}

fn difference_object(difference: &Difference) -> Value {
    let Difference { tick, time_s, field, recorded, replayed, .. } = difference;
    json!({
        "tick": tick,
        "time_s": time_s,
        "field": field,
        "recorded": recorded,
        "replayed": replayed,
        "recorded_hex": hex(recorded),
        "replayed_hex": hex(replayed),
    })
}

fn hex(number: &FieldValue) -> String {
    format!("{:#018x}", number.bits())
}

fn with_hex(number: &FieldValue) -> String {
    format!("{number} ({})", hex(number))
}
