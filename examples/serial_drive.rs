//! Drives a base on a serial line from (1, 1) to (4, 1) of a map, by its encoders alone. It moves as soon as it is connected: be
//! ready to stop it.
//!
//! Run with `cargo run --release --example serial_drive -- /dev/ttyUSB0 map.yaml`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::{env, sync::Arc, time::Instant};

use inbye::base::Protocol;
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{LoadOptions, load};
use inbye::navigator::Goal;
use inbye::runtime::hardware::{HardwareRobot, SerialLine};
use inbye::runtime::{Config, Mission, Observer, TickEvent, run_mission};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = env::args().nth(1).ok_or("give the port of the base")?;
    let map = env::args().nth(2).ok_or("give a map")?;
    let map = Arc::new(load(map.as_ref(), &LoadOptions::default())?);
    let start = Pose::new(1.0, 1.0, 0.0);
    let config = Config::default();
    let line = SerialLine::new(&port, Protocol::Native);
    // Nothing moves before the protective layer is armed. Without a lidar it can only be stopped by its switch.
    let mut layer = config.protective_layer(line.config.supervisor.period_s())?;
    layer.arm();
    // The base stops when the robot is dropped.
    let mut robot = HardwareRobot::new(line.connect(Arc::default())?, None, layer, start);
    let mission = Mission::new(map, start, Goal::at(Point::new(4.0, 1.0)));
    let began = Instant::now();
    let clock = &mut || began.elapsed().as_secs_f64();
    let on_tick = &mut |_: &TickEvent<'_>| {};
    let mut observer = Observer { clock, on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = run_mission(&mission, &config, engine, &mut robot, &mut observer)?;
    println!("reached: {}", result.reached);
    Ok(())
}
