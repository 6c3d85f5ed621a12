//! Drives over the emulated base by an injected clock: the control loop stalls, and the time that passed counts in full.

use core::ops::ControlFlow;
use std::sync::Arc;

use crate::support::room;
use inbye::base::{
    BaseSettings, Emulator, OutgoingCommand, Protocol, SafetyController, Session,
    SupervisorSettings,
};
use inbye::geometry::{Point, Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::OccupancyGrid;
use inbye::navigator::{Goal, Mode};
use inbye::runtime::{
    Config, FaultEvents, GroundTruth, Mission, MissionResult, Observer, OdometryReading, Robot,
    SensorData, TickEvent, TraceRow,
};
use inbye::sim::{FaultInjection, Simulation};

const PERIOD_S: f64 = 0.1;
/// Simulation step, seconds, and steps between commands.
const STEP_S: f64 = 0.002;
const STEPS_PER_COMMAND: usize = 10;
const START: Pose = Pose { x: 2.0, y: 3.0, yaw: 0.0 };

/// An emulated base with its session and sender, and a clock that the test advances.
struct WiredRobot<S> {
    controller: SafetyController,
    session: Box<dyn Session>,
    emulator: Emulator,
    steps: usize,
    observed_s: f64,
    ticks: usize,
    /// How much later a tick comes than planned, seconds.
    stall_s: S,
    /// Whether the sender stalls too, as in a process that is stopped.
    stops_sender: bool,
}

impl<S: Fn(usize) -> f64> WiredRobot<S> {
    fn new(stall_s: S, stops_sender: bool) -> Self {
        let base = BaseSettings::default();
        let mut robot = Self {
            controller: SafetyController::new(&base, SupervisorSettings::default())
                .expect("valid settings"),
            session: Protocol::Native.session(base).expect("valid settings"),
            emulator: Emulator::new(Protocol::Native, base, 1).expect("valid settings"),
            steps: 0,
            observed_s: 0.0,
            ticks: 0,
            stall_s,
            stops_sender,
        };
        robot.pass(1.0, true);
        robot
    }

    fn time_s(&self) -> f64 {
        STEP_S * self.steps as f64
    }

    fn pass(&mut self, time_s: f64, sends: bool) {
        for _ in 0..(time_s / STEP_S).round() as usize {
            if sends && self.steps.is_multiple_of(STEPS_PER_COMMAND) {
                self.send();
            }
            self.steps += 1;
            let now_s = self.time_s();
            let mut line = Vec::new();
            self.session.transmit(now_s, &mut line);
            self.emulator.receive(&line, now_s);
            line.clear();
            self.emulator.step(now_s, &mut line);
            self.session.receive(&line, now_s);
        }
    }

    fn send(&mut self) {
        let now_s = self.time_s();
        if let Some(latest) = self.session.latest() {
            self.controller.on_feedback(&latest.feedback, now_s);
        }
        let OutgoingCommand::Drive(command) = self.controller.next_command(now_s) else {
            panic!("{:?}", self.controller.stop_cause());
        };
        self.session.command(&command).expect("a finite command");
    }
}

impl<S: Fn(usize) -> f64> Robot for WiredRobot<S> {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.observed_s = self.time_s();
        let latest = self.session.latest().expect("a report");
        let pose = START.transform_pose(self.emulator.pose());
        SensorData {
            odometry: OdometryReading { pose, twist: latest.feedback.twist },
            odometry_s: time_s - (self.time_s() - latest.received_s),
            lidar: None,
            pose: None,
            pose_s: None,
            sent: Some(*self.controller.sent()),
        }
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        None
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.time_s())
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let now_s = self.time_s();
        self.controller.set_target(command, self.observed_s, now_s).expect("a valid target");
        self.pass(period_s, true);
        self.pass((self.stall_s)(self.ticks), !self.stops_sender);
        self.ticks += 1;
        ControlFlow::Continue(())
    }
}

/// Drives along a hall of 40 m. Returns the result and the events of its ticks.
fn drive(
    time_limit_s: f64,
    faults: Vec<FaultInjection>,
    stall_s: impl Fn(usize) -> f64,
    stops_sender: bool,
) -> (MissionResult, Vec<String>) {
    let rows = room::rows(200, 30, &[]);
    let map = OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a map");
    let goal = Goal::at(Point::new(37.0, 3.0));
    let mission = Mission { time_limit_s, ..Mission::new(Arc::new(map), START, goal) };
    let simulation = Simulation { faults, ..Simulation::new(mission) };
    let (mut events, mut fault_events) = (Vec::new(), FaultEvents::default());
    let mut on_tick = |tick: &TickEvent<'_>| events.extend(fault_events.update(tick));
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let config = Config::default();
    let mut robot = WiredRobot::new(stall_s, stops_sender);
    let result = simulation.run_with(&mut robot, &config, engine, &mut observer);
    (result.expect("a mission that can start"), events)
}

/// The elapsed time and the fall of the command from each row to the next.
fn steps(rows: &[TraceRow]) -> Vec<(f64, f64)> {
    let step = |pair: &[TraceRow]| {
        (pair[1].time_s - pair[0].time_s, pair[0].command.linear - pair[1].command.linear)
    };
    rows.windows(2).map(step).collect()
}

fn silent_from(from_s: f64) -> Vec<FaultInjection> {
    vec![FaultInjection::LidarSilent { from_s, to_s: f64::INFINITY }]
}

#[test]
fn command_after_a_stall_is_lower_by_the_deceleration_times_the_elapsed_time() {
    // The last scan is that of tick 40, so that the one after the stall is the first without a fresh scan.
    for (stall_s, stops_sender) in [(0.2, false), (0.5, false), (0.5, true)] {
        let stall = |tick| if tick == 41 { stall_s } else { 0.0 };
        let (result, events) = drive(8.0, silent_from(4.05), stall, stops_sender);
        let rows = &result.trace.rows;
        let (before, after) = (&rows[41], &rows[42]);
        let elapsed_s = after.time_s - before.time_s;
        assert!((elapsed_s - PERIOD_S - stall_s).abs() < 1e-6, "{elapsed_s}");
        assert!(before.command.linear > 0.9 && before.mode == Mode::Driving, "{before:?}");
        let limit = (before.command.linear - elapsed_s).max(0.0) + 1e-9;
        let case = format!("{stall_s} s: {before:?}, {after:?}");
        assert!(after.command.linear <= limit && after.mode == Mode::SensorFault, "{case}");
        assert_eq!(result.late_ticks, 1);
        let late = format!("control loop: {elapsed_s:.3} s passed since the tick before");
        assert!(events.iter().any(|event| event.starts_with(&late)), "{events:?}");
    }
}

#[test]
fn loop_that_is_always_late_brakes_with_the_configured_deceleration() {
    let (result, _) = drive(20.0, silent_from(8.0), |_| 0.15, false);
    let rows = &result.trace.rows;
    assert_eq!(result.late_ticks, rows.len() as u64 - 1);
    let first = rows.iter().position(|row| row.mode == Mode::SensorFault).expect("a fault");
    let speed = rows[first - 1].command.linear;
    assert!(speed > 0.5, "{:?}", rows[first - 1]);
    let stands = rows[first..].iter().find(|row| row.command == Twist::STOP).expect("it stands");
    let took_s = stands.time_s - rows[first - 1].time_s;
    assert!(took_s <= speed + 0.25 + 1e-6, "{speed} m/s in {took_s} s");
    let fastest = steps(rows).into_iter().map(|(_, fall)| -fall).fold(0.0, f64::max);
    assert!(fastest <= PERIOD_S + 1e-9, "accelerates by {fastest} m/s in a tick");
}

#[test]
fn time_limit_counts_the_time_of_stalls() {
    let (result, _) = drive(6.0, Vec::new(), |tick| if tick % 10 == 9 { 0.5 } else { 0.0 }, false);
    let rows = &result.trace.rows;
    let time_s = result.time_s;
    assert!((5.3..6.0).contains(&time_s) && !result.reached, "{time_s}");
    // 41 ticks of 0.1 s, and four stalls of 0.5 s.
    assert_eq!((rows.len(), result.late_ticks), (40, 3), "{time_s}");
    assert_eq!(result.why().as_deref().map(|why| why.starts_with("the time was up")), Some(true));
    let elapsed_s: f64 = steps(rows).iter().map(|(elapsed_s, _)| elapsed_s).sum();
    assert!((elapsed_s - time_s).abs() < 1e-6);
}

#[test]
fn robot_drives_on_after_a_pause_of_seconds() {
    let (result, events) = drive(60.0, Vec::new(), |tick| if tick == 50 { 5.0 } else { 0.0 }, true);
    assert!(result.reached, "{:?} {events:?}", result.why());
    let rows = &result.trace.rows;
    assert_eq!((rows[51].mode, rows[51].command), (Mode::SensorFault, Twist::STOP));
    assert_eq!(result.late_ticks, 1);
}
