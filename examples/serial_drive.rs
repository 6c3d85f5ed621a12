//! Drives a base with an LD19 lidar from (10, 5) to (16, 6) of a map. It moves as soon as it is connected: be ready to stop it. Ctrl-C
//! and SIGTERM stop it.
//!
//! Run with `cargo run --release --example serial_drive -- /dev/ttyUSB0 /dev/ttyUSB1 examples/mine.yaml`. Without hardware,
//! `inbye base emulate --lidar-map examples/mine.yaml --start 10,5` prints two ports.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::env;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use inbye::base::Protocol;
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{LoadOptions, load};
use inbye::navigator::Goal;
use inbye::runtime::hardware::{HardwareRobot, SerialLine, connect_lidar};
use inbye::runtime::{Config, Mission, Observer, PoseSource, TickEvent, run_mission};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [base, lidar, map] = &*arguments else {
        return Err("give the ports of the base and of the lidar, and a map".into());
    };
    // The base stops when the flag is set. A base without a watchdog needs the same for every signal that ends or suspends a program.
    let end = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&end);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))?;
    let map = Arc::new(load(map.as_ref(), &LoadOptions::default())?);
    let start = Pose::new(10.0, 5.0, 0.0);
    let config = Config::default().pose_source(PoseSource::Scans);
    let line = SerialLine::new(base, Protocol::Native);
    let base = line.connect(Arc::clone(&end))?;
    let lidar = connect_lidar(lidar, line.config.lidar, &end)?;
    // Nothing moves before the protective layer is armed.
    let mut layer = config.protective_layer(line.config.supervisor.period_s())?;
    layer.arm();
    // The base stops when the robot is dropped.
    let mut robot = HardwareRobot::new(base, Some(lidar), layer, start);
    let goal = Goal::at(Point::new(16.0, 6.0));
    let mission = Mission { interrupt: Some(end), ..Mission::new(map, start, goal) };
    let began = Instant::now();
    let clock = &mut || began.elapsed().as_secs_f64();
    let on_tick = &mut |_: &TickEvent<'_>| {};
    let mut observer = Observer { clock, on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = run_mission(&mission, &config, engine, &mut robot, &mut observer)?;
    println!("reached: {}", result.reached);
    result.why().iter().for_each(|why| println!("why: {why}"));
    Ok(())
}
