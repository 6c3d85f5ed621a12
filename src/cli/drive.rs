//! `inbye drive`.

use std::sync::Arc;

use anyhow::{Context, anyhow};
use inbye::bench::Latencies;
use inbye::global::PlanError;
use inbye::local::DecisionError;
use inbye::map::{OccupancyGrid, UnknownPolicy};
use inbye::navigator::{Fault, Goal};
use inbye::report::{MissionView, PlaybackRecorder};
use inbye::runtime::{
    Config, Mission, MissionError, MissionResult, Observer, PoseSource, StopError, TickEvent,
    run_mission,
};
use inbye::sim::{MovingObstacles, SimError, Simulation};
use serde_json::{Value, json};

use super::arguments::{DriveArguments, Obstacles, Place};
use super::drive_log::DriveLog;
use super::process::wall_clock;
use super::recording::{Ending, Recording};
use super::{engines, hardware_drive, incident_text, map_file, output, plan, report_file};

/// Drives to a goal. Returns false if it is not reached, an obstacle was hit, or the recording is incomplete.
pub fn run(arguments: &DriveArguments, json: bool) -> anyhow::Result<bool> {
    let (map, mut config) = map_file::read(&arguments.map)?;
    if let Some(deadline_ms) = arguments.deadline {
        config.navigator.deadline_s = Some(deadline_ms / 1e3);
    }
    if arguments.hardware.lidar.is_some() {
        anyhow::ensure!(
            matches!(arguments.obstacles, Obstacles::Count(0)),
            "--obstacles are simulated, but --lidar measures real ones: leave one of them out"
        );
        config.pose_source = PoseSource::Scans;
    }
    let mut hardware = hardware_drive::connect(&arguments.hardware, arguments.start.pose())?;
    let map_name = format!("{}", arguments.map.map.display());
    let moving_obstacles = match moving_obstacles(arguments, &map, &config) {
        Ok(moving_obstacles) => moving_obstacles,
        Err(error) => return no_path_or(error, arguments, &map, &config, json),
    };
    // Created before the drive: a wrong name must not cost an hour of driving.
    let record_file = arguments.record.as_deref().map(output::create_record).transpose()?;
    if let Some(folder) = &arguments.report {
        report_file::create_folder(folder)?;
    }
    let stop = |place: &Place| Goal { position: place.position, yaw: place.yaw };
    let goal = stop(&arguments.goal);
    let simulation = Simulation {
        moving_obstacles,
        seed: arguments.seed,
        ..Simulation::new(Mission {
            via: arguments.via.iter().map(stop).collect(),
            time_limit_s: arguments.time_limit,
            ..Mission::new(Arc::new(map), arguments.start.pose(), goal)
        })
    };
    let mission = &simulation.mission;
    let engine =
        engines::choose_to_drive(&arguments.engine, arguments.threads, arguments.require_gpu)?;
    // Frames cost time in every tick, so they are recorded for a report only.
    let mut playback = arguments.report.as_ref().map(|_| PlaybackRecorder::default());
    let mut recording = record_file.zip(arguments.record.as_deref()).map(|file| {
        let is_real_time = hardware.is_some();
        Recording::begin(file, mission, &config, engine.name(), is_real_time)
    });
    let driven = drive(
        &simulation,
        &config,
        engine,
        "driving",
        hardware.as_mut(),
        playback.as_mut(),
        recording.as_mut(),
    );
    // The base stops before anything is written.
    let base = hardware.map(hardware_drive::HardwareDrive::end);
    let result = match driven {
        Ok(result) => result,
        Err(error) => return no_path_or(error, arguments, &mission.map, &config, json),
    };
    if let Some(Fault::Choose(DecisionError::Problem(error))) = &result.fault {
        return Err(anyhow!(error.clone())).with_context(|| settings_source(arguments));
    }
    let recording = recording.map(|recording| recording.end(&result));
    if let Some((folder, playback)) = arguments.report.as_ref().zip(playback.as_ref()) {
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        let drive = MissionView {
            title: &map_name,
            command: &command,
            mission,
            config: &config,
            result: &result,
            playback: Some(playback),
            facts: &report_file::facts(&result),
        };
        let page = report_file::drive_page(drive, arguments.hardware.description());
        report_file::write(folder, &page)?;
    }
    let unknown = (&*mission.map, config.unknown);
    show(&result, unknown, base.as_ref(), recording.as_ref(), json)?;
    let is_recorded = recording.as_ref().is_none_or(Ending::is_whole);
    Ok(result.reached && !result.collided && is_recorded)
}

/// Prints the result of a drive, as one JSON object or as text.
fn show(
    result: &MissionResult,
    (map, policy): (&OccupancyGrid, UnknownPolicy),
    base: Option<&hardware_drive::HardwareReport>,
    recording: Option<&Ending>,
    json: bool,
) -> anyhow::Result<()> {
    if json {
        let mut object = object(result);
        object["unknown"] = map_file::unknown_cells_json(map, policy);
        object["recording"] = json!(recording.map(Ending::object));
        if let Some(base) = base {
            object["base"] = base.object();
        }
        output::json(&object)?;
    } else {
        print(result);
        if let Some(text) = map_file::unknown_cells_text(map, policy) {
            output::line(format!("unknown      {text}"));
        }
        for line in base.into_iter().flat_map(hardware_drive::HardwareReport::lines) {
            output::line(line);
        }
        if let Some(recording) = recording {
            output::line(recording.line());
        }
    }
    Ok(())
}

/// Runs a mission with the wall clock and a progress bar: on a real base if one is connected, else simulated.
pub fn drive(
    simulation: &Simulation,
    config: &Config,
    engine: Box<dyn inbye::local::Engine>,
    what: &str,
    hardware: Option<&mut hardware_drive::HardwareDrive>,
    mut playback: Option<&mut PlaybackRecorder>,
    mut recording: Option<&mut Recording<'_>>,
) -> Result<MissionResult, SimError> {
    let mission = &simulation.mission;
    let goal = mission.goal.position;
    let whole_cm = |metres: f64| (metres * 100.0) as u64;
    let far_m = (goal - mission.start.position()).norm();
    if let Some(warning) = recording.as_ref().and_then(|it| it.warning()) {
        output::warn(warning);
    }
    let bar = output::progress(whole_cm(far_m), what);
    let mut nearest_m = far_m;
    let mut log = output::is_verbose().then(DriveLog::default);
    let mut on_tick = |tick: &TickEvent<'_>| {
        if let Some(playback) = &mut playback {
            playback.record(tick);
        }
        if let Some(log) = &mut log {
            log.update(tick);
        }
        nearest_m = nearest_m.min((goal - tick.row.pose.position()).norm());
        bar.set_position(whole_cm(far_m - nearest_m));
        let warning = recording.as_mut().and_then(|it| it.record(tick));
        if let Some(warning) = warning {
            bar.suspend(|| output::warn(warning));
        }
    };
    let mut clock = wall_clock();
    let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
    let result = match hardware {
        Some(hardware) if hardware.has_lidar() => {
            let robot = &mut hardware.robot;
            run_mission(mission, config, engine, robot, &mut observer).map_err(SimError::from)
        }
        Some(hardware) => simulation.run_with(&mut hardware.robot, config, engine, &mut observer),
        None => simulation.run(config, engine, &mut observer),
    };
    bar.finish_and_clear();
    result
}

/// Prints a missing path, which is an answer; every other planning error is unusable input.
fn no_path_or(
    error: SimError,
    arguments: &DriveArguments,
    map: &OccupancyGrid,
    config: &Config,
    json: bool,
) -> anyhow::Result<bool> {
    match error {
        SimError::Mission(MissionError::Fault(Fault::Plan(
            error @ PlanError::NoValidPath { .. },
        ))) => {
            let mut object = plan::no_path_json(&error);
            object["reached"] = json!(false);
            object["collided"] = json!(false);
            object["fault"] = json!(error.to_string());
            plan::print_no_path(&error.to_string(), json.then_some(object))?;
            Ok(false)
        }
        SimError::Mission(MissionError::Fault(Fault::Plan(error))) => {
            let reason = error.to_string();
            Err(plan::unusable(&error, &reason, &arguments.map, map, config))
        }
        error => Err(error.into()),
    }
}

/// The source of a setting that proved invalid during the drive.
fn settings_source(arguments: &DriveArguments) -> String {
    let map = arguments.map.map.display();
    match &arguments.map.config {
        Some(file) => format!("{} with {map}", file.display()),
        None => format!("{map} with the default settings"),
    }
}

/// Moving obstacles from a file, or a number of pedestrians along the robot's route.
fn moving_obstacles(
    arguments: &DriveArguments,
    map: &OccupancyGrid,
    config: &Config,
) -> Result<MovingObstacles, SimError> {
    let count = match &arguments.obstacles {
        Obstacles::Count(count) => *count,
        Obstacles::File(file) => {
            let ground = map.obstacles(config.unknown);
            return MovingObstacles::read(file, &ground, arguments.seed);
        }
    };
    let ends = (arguments.start.pose().position(), arguments.goal.position);
    let spawner = config.simulation.pedestrians.spawner(count, arguments.seed);
    spawner.spawn_on_route(map, config, ends)
}

/// Collects the decision times.
pub fn latencies(result: &MissionResult) -> Latencies {
    let mut latencies = Latencies::default();
    for &seconds in &result.decision_s {
        // The wall clock never runs backwards, so every time is valid.
        let _ = latencies.record(seconds);
    }
    latencies
}

/// The result as a JSON object.
pub fn object(result: &MissionResult) -> Value {
    let (x_m, y_m) = result.final_error_m;
    let mut object = json!({
        "reached": result.reached,
        "collided": result.collided,
        "time_s": result.time_s,
        "travelled_m": result.travelled_m,
        "min_clearance_m": result.min_clearance_m,
        "final_error": { "x_m": x_m, "y_m": y_m, "yaw_rad": result.final_yaw_error },
        "stop_errors": result.stop_errors.iter().map(stop_error).collect::<Vec<_>>(),
        "engine": result.engine,
        "latency_ms": latencies(result).summary(),
        "ticks": result.trace.rows.len(),
        "plans": result.plans.len(),
        "fault": result.fault.as_ref().map(ToString::to_string),
        "trace_digest": result.trace.digest(),
    });
    for (name, value) in incident_text::fields(result) {
        object[name] = value;
    }
    object
}

fn stop_error(error: &StopError) -> Value {
    json!({ "x_m": error.x_m, "y_m": error.y_m, "yaw_rad": error.yaw_rad })
}

/// The result in one line.
pub fn one_line(result: &MissionResult) -> String {
    let outcome = match (result.reached, result.collided) {
        (_, true) => "hit an obstacle",
        (true, false) => "reached the goal",
        (false, false) => "did not reach the goal",
    };
    format!(
        "{outcome}: {:.1} m in {:.1} s, {} ticks, {} plans, smallest gap {:.3} m",
        result.travelled_m,
        result.time_s,
        result.trace.rows.len(),
        result.plans.len(),
        result.min_clearance_m,
    )
}

fn print(result: &MissionResult) {
    output::line(one_line(result));
    if let Some(fault) = &result.fault {
        output::line(format!("why: {fault}"));
    }
    for (number, error) in result.stop_errors.iter().enumerate() {
        let StopError { x_m, y_m, yaw_rad } = *error;
        output::line(error_line(&format!("stop {}", number + 1), x_m, y_m, yaw_rad));
    }
    let (x_m, y_m) = result.final_error_m;
    output::line(error_line("final error", x_m, y_m, result.final_yaw_error));
    if let Some(summary) = latencies(result).summary() {
        output::line(format!(
            "decision     p50 {:.2} ms, p99 {:.2} ms, slowest {:.2} ms on {}",
            summary.p50_ms, summary.p99_ms, summary.max_ms, result.engine,
        ));
    }
    for (name, fact) in incident_text::facts(result) {
        output::line(format!("{name:<12} {fact}"));
    }
    output::line(format!("trace        {}", result.trace.digest()));
}

/// The line of a position error.
fn error_line(name: &str, x_m: f64, y_m: f64, yaw_rad: Option<f64>) -> String {
    let yaw = yaw_rad.map_or_else(String::new, |yaw_rad| format!(", yaw {yaw_rad:+.4} rad"));
    format!("{name:<12} x {x_m:+.3} m, y {y_m:+.3} m{yaw}")
}
