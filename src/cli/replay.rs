//! `inbye replay`.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use inbye::local::EngineChoice;
use inbye::recording::{Difference, FieldValue, Reader, RecordingError, Replay, replay};
use serde_json::{Value, json};

use super::{arguments, engines, output, value_parsers};

/// `inbye replay`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye drive --map mine.yaml --start 10,5 --goal 80,40 --record run.mcap\n  \
    inbye replay run.mcap --engine cpu --json\n\n\
    The navigator is created from the configuration, waypoints and map in the file and gets the recorded observations; every \
    number that it decides is compared with the recorded one. Decision times and the arrival of plans are repeated too, so a \
    drive with a deadline or on a real base (--port) replays as well.\n\
    `complete` is false for a file that was truncated or whose recording stopped: it is replayed up to its end.\n\
    Exit status: 0 all bits agree; 1 they differ; 2 the file cannot be used."
)]
pub struct ReplayArguments {
    /// The recording: a file of `inbye drive --record FILE.mcap`.
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = value_parsers::engine())]
    pub engine: EngineChoice,
    /// CPU threads [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = arguments::whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
}

/// Repeats the decisions of a recording. Returns false if a bit differs.
pub fn run(arguments: &ReplayArguments, json: bool) -> anyhow::Result<bool> {
    let name = || format!("{}", arguments.file.display());
    let file = File::open(&arguments.file)
        .with_context(|| format!("{}: cannot be read: name a recording", name()))?;
    let mut recording = Reader::open(BufReader::new(file)).with_context(name)?;
    let engine = engines::choose_to_drive(&arguments.engine, arguments.threads, false)?;
    let recorded_engine = recording.metadata().engine.clone();
    let replay = replay(&mut recording, engine).with_context(name)?;
    if replay.ticks == 0 {
        let missing = "tick";
        return Err(RecordingError::NotOurs { missing }).with_context(name);
    }
    if json {
        output::json(&object(&replay, &recorded_engine))?;
    } else {
        print(&replay, &recorded_engine);
    }
    Ok(replay.agrees())
}

fn object(replay: &Replay, recorded_engine: &str) -> Value {
    json!({
        "ticks": replay.ticks,
        "agree": replay.agrees(),
        "engine": replay.engine,
        "recorded_engine": recorded_engine,
        "first_difference": replay.first_difference.as_ref().map(difference),
        "complete": replay.is_complete,
    })
}

fn difference(difference: &Difference) -> Value {
    let Difference { tick, time_s, field, recorded, replayed } = difference;
    let value = |number: &FieldValue| match number {
        FieldValue::Real(value) => json!(value),
        FieldValue::Count(value) => json!(value),
        FieldValue::Named(word, _) => json!(word),
    };
    json!({
        "tick": tick,
        "time_s": time_s,
        "field": field,
        "recorded": value(recorded),
        "replayed": value(replayed),
        "recorded_hex": hex(recorded),
        "replayed_hex": hex(replayed),
    })
}

fn hex(number: &FieldValue) -> String {
    format!("{:#018x}", number.bits())
}

fn print(replay: &Replay, recorded_engine: &str) {
    let ticks = replay.ticks;
    match &replay.first_difference {
        None => output::line(format!("the same bits in all {ticks} ticks")),
        Some(difference) => {
            let Difference { tick, time_s, field, recorded, replayed } = difference;
            output::line(format!(
                "DIFFERS first at tick {tick} of {ticks}, at {time_s:.3} s: {field} was {}, is {}",
                with_hex(recorded),
                with_hex(replayed),
            ));
        }
    }
    output::line(format!("recorded on  {recorded_engine}"));
    output::line(format!("replayed on  {}", replay.engine));
    if !replay.is_complete {
        output::line(format!(
            "the recording is truncated: it ends with tick {}, before the end of the drive",
            ticks - 1
        ));
    }
}

fn with_hex(number: &FieldValue) -> String {
    match number {
        FieldValue::Real(value) => format!("{value} ({})", hex(number)),
        FieldValue::Count(value) => format!("{value} ({})", hex(number)),
        FieldValue::Named(word, _) => format!("{word} ({})", hex(number)),
    }
}
