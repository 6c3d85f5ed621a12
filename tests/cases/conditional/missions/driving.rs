//! Missions, and the conditions that every drive must meet.

use inbye::geometry::{Point, Pose};
use inbye::local::{CpuEngine, Engine};
use inbye::map::MovingDisc;
use inbye::navigator::{Goal, Mode};
use inbye::robot::Limits;
use inbye::runtime::{Config, Mission, MissionResult, Observer, Trace, TraceRow};
use inbye::sim::{MovingObstacles, SimError, Simulation};

use super::ground::Ground;

/// A mission in a known static world, for at most 400 s.
pub fn mission(ground: &Ground, [x, y, yaw]: [f64; 3], [goal_x, goal_y]: [f64; 2]) -> Simulation {
    let goal = Goal::at(Point::new(goal_x, goal_y));
    Simulation {
        seed: 1,
        ..Simulation::new(Mission {
            time_limit_s: 400.0,
            ..Mission::new(ground.map(), Pose::new(x, y, yaw), goal)
        })
    }
}

/// Pedestrians from JSON, as in a file.
pub fn people(mission: &Simulation, json: &str) -> MovingObstacles {
    let ground = mission.mission.map.obstacles(Config::default().unknown);
    MovingObstacles::parse(json, "people.json", &ground, 0).expect("pedestrians on the map")
}

/// The moving obstacles at a row of a trace, without velocity.
pub fn moving_at(trace: &Trace, row: &TraceRow) -> Vec<MovingDisc> {
    let discs = row.moving.iter().zip(&trace.moving_radii);
    discs
        .filter_map(|(center, &radius)| {
            center.map(|center| MovingDisc { x: center.x, y: center.y, radius, vx: 0.0, vy: 0.0 })
        })
        .collect()
}

pub fn try_drive(
    mission: &Simulation,
    config: &Config,
    engine: Box<dyn Engine>,
) -> Result<MissionResult, SimError> {
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    mission.run(config, engine, &mut observer)
}

/// Drives with the default robot, and checks what every drive must meet: lawful commands and no contact.
pub fn drive(mission: &Simulation) -> MissionResult {
    let config = Config::default();
    let engine = Box::new(CpuEngine::single_threaded());
    let result = try_drive(mission, &config, engine).expect("a mission that can start");
    assert_lawful(&result, &config);
    assert!(!result.collided && result.min_clearance_m > 0.0, "{}", story(&result));
    result
}

/// Drives, and checks that the robot arrives.
pub fn arrive(mission: &Simulation) -> MissionResult {
    let result = drive(mission);
    assert!(result.reached && result.fault.is_none(), "{}", story(&result));
    let (x, y) = result.final_error_m;
    assert!(
        libm::hypot(x, y) <= Config::default().navigator.xy_goal_tolerance,
        "{}",
        story(&result)
    );
    result
}

/// Checks that every command is within the limits, and that the robot reaches it before the next one takes effect.
pub fn assert_lawful(result: &MissionResult, config: &Config) {
    let reach_s = reach_s(config);
    for row in &result.trace.rows {
        assert!(is_lawful(row, &config.robot.limits, reach_s), "not lawful: {row:?}");
    }
}

/// Time that a command and the one before it act until the next one does, seconds: until the latency is identified, the
/// navigator assumes the longer one.
pub fn reach_s(config: &Config) -> f64 {
    let navigator = &config.navigator;
    config.local.control_period_s + navigator.actuation_delay_s.max(navigator.unidentified_delay_s)
}

pub fn is_lawful(row: &TraceRow, limits: &Limits, reach_s: f64) -> bool {
    // The robot decides from its measured speed. Track slip, encoders and gyro err by less than this.
    const MEASURED: f64 = 0.1;
    let (command, twist) = (row.command, row.twist);
    // The motors lag, so the speed may be slightly outside the limits; then only braking is lawful.
    let steps =
        |change: f64, gain: f64, brake: f64| change.abs() <= gain.max(-brake) * reach_s + MEASURED;
    command.is_finite()
        && (limits.min_vel_x..=limits.max_vel_x).contains(&command.linear)
        && command.angular.abs() <= limits.max_vel_theta
        && steps(command.linear - twist.linear, limits.acc_lim_x, limits.decel_lim_x)
        && steps(command.angular - twist.angular, limits.acc_lim_theta, limits.decel_lim_theta)
}

pub fn has_mode(result: &MissionResult, mode: Mode) -> bool {
    result.trace.rows.iter().any(|row| row.mode == mode)
}

/// Describes a drive in one line.
pub fn story(result: &MissionResult) -> String {
    format!(
        "reached {}, collided {}, {:.1} m in {:.1} s, {} plans, least gap {:.3} m, {:?}, ends {:?}",
        result.reached,
        result.collided,
        result.travelled_m,
        result.time_s,
        result.plans.len(),
        result.min_clearance_m,
        result.fault,
        result.trace.rows.last(),
    )
}
