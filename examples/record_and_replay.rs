//! Records a drive into an MCAP file that ROS 2 tools open, and repeats its decisions: `cargo run --release --example
//! record_and_replay`

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use core::ops::ControlFlow;
use std::env::temp_dir;
use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::sync::Arc;

use inbye::local::CpuEngine;
use inbye::navigator::Goal;
use inbye::recording::{BackpressurePolicy, DriveMetadata, Reader, Recorder, replay};
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{Simulation, dead_end};

fn main() -> Result<(), Box<dyn Error>> {
    let (scene, config) = (dead_end(), Config::default());
    let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
    let engine = || Box::new(CpuEngine::single_threaded());

    let file = temp_dir().join(format!("inbye-drive-{}.mcap", std::process::id()));
    let metadata = DriveMetadata::new(&mission, &config, "CPU".to_owned());
    // A real robot must not wait for the disk: `BackpressurePolicy::Stop`.
    let mut recorder = Recorder::new(File::create(&file)?, &metadata, BackpressurePolicy::Block)?;
    let mut observer = Observer {
        clock: &mut || 0.0,
        on_tick: &mut |event| {
            if !recorder.record(event) {
                println!("the recording ends: {}", recorder.stopped().unwrap_or("unknown cause"));
            }
        },
    };
    let result = Simulation::new(mission).run(&config, engine(), &mut observer)?;
    let report = recorder.finish(result.trace.digest());
    println!("{} messages, {} bytes", report.messages, report.bytes);

    let mut reader = Reader::open(BufReader::new(File::open(&file)?))?;
    let replayed = replay(&mut reader, engine(), None, &mut |_| ControlFlow::Continue(()))?;
    match &replayed.first_difference {
        None => println!("{} decisions are the same to the bit", replayed.ticks),
        Some(it) => println!("tick {}: {} {}, now {}", it.tick, it.field, it.recorded, it.replayed),
    }
    fs::remove_file(file)?;
    Ok(())
}
