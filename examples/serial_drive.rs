//! Drives a base on a serial line from (1, 1) to (4, 1) of a map by the encoders alone.
//!
//! `cargo run --release --example serial_drive -- /dev/ttyUSB0 map.yaml`

use std::sync::Arc;

use inbye::base::{BaseConfig, Protocol};
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{LoadOptions, load};
use inbye::navigator::Goal;
use inbye::runtime::hardware::SerialLine;
use inbye::runtime::{Config, Mission, Observer, run_mission};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, port, map] = &arguments[..] else {
        return Err("give the port of the base and a map".into());
    };
    let (port, protocol, config) = (port.clone(), Protocol::Native, BaseConfig::default());
    let line = SerialLine {
        port,
        protocol,
        config,
    };
    let start = Pose::new(1.0, 1.0, 0.0);
    // The supervisor stops the base when the robot is dropped.
    let mut robot = line.connect(start, Arc::default())?;
    let map = Arc::new(load(map.as_ref(), &LoadOptions::default())?);
    let goal = Goal {
        position: Point::new(4.0, 1.0),
        yaw: None,
    };
    let mission = Mission::new(map, start, goal);
    let clock = std::time::Instant::now();
    let mut seconds = || clock.elapsed().as_secs_f64();
    let mut observer = Observer {
        clock: &mut seconds,
        on_tick: &mut |_| {},
    };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = run_mission(
        &mission,
        &Config::default(),
        engine,
        &mut robot,
        &mut observer,
    )?;
    println!("reached: {}, {:.2} m", result.reached, result.travelled_m);
    Ok(())
}
