//! The protective layer in the safety controller.

use core::f64::consts::{PI, TAU};

use inbye::base::{
    BaseSettings, CollisionMonitorSettings, DriveStatus, Feedback, OperatorSwitch, OutgoingCommand,
    ProtectiveAction, ProtectiveLayer, SafetyController, SupervisorSettings,
};
use inbye::geometry::Twist;
use inbye::map::{Beam, TimedScan};
use inbye::robot::{Footprint, Limits};

const PERIOD_S: f64 = 0.02;

const RANGE_MAX_M: f64 = 12.0;

/// A base before a wall that follows each command 0.02 s later.
struct Robot {
    controller: SafetyController,
    now_s: f64,
    twist: Twist,
    /// Distance of the wall ahead of the lidar.
    wall_m: f64,
}

impl Robot {
    fn new(wall_m: f64, base: &BaseSettings) -> Self {
        let controller = SafetyController::new(base, SupervisorSettings::default());
        let controller = controller.expect("valid settings");
        Self { controller, now_s: 10.0, twist: Twist::STOP, wall_m }
    }

    fn scan(&self) -> TimedScan {
        let beam = |index: i32| {
            let angle = (f64::from(index) + 0.5) / 360.0 * TAU - PI;
            let ahead = libm::cos(angle);
            let range = if ahead > 0.1 { self.wall_m / ahead } else { 9.0 };
            // A lidar returns nothing from beyond its range.
            let range = if range > RANGE_MAX_M { f64::INFINITY } else { range };
            Beam { angle, range, time_s: self.now_s }
        };
        TimedScan {
            beams: (0..360).map(beam).collect(),
            range_max: RANGE_MAX_M,
            ..TimedScan::default()
        }
    }

    /// A cycle with a target; scans come at 10 Hz.
    fn cycle(&mut self, cycle: u32, target: &Twist, sees: bool) -> OutgoingCommand {
        self.now_s += PERIOD_S;
        let report = Feedback { twist: self.twist, ..Feedback::default() };
        self.controller.on_feedback(&report, self.now_s);
        if sees && cycle.is_multiple_of(5) {
            let scan = self.scan();
            self.controller.update_scan(&scan, self.now_s);
        }
        // Rejected while a stop is latched.
        let _ = self.controller.set_target(target, self.now_s, self.now_s);
        let command = self.controller.next_command(self.now_s);
        self.twist = match command {
            OutgoingCommand::Drive(twist) => twist,
            OutgoingCommand::EngageStop | OutgoingCommand::ReleaseStop => Twist::STOP,
        };
        self.wall_m -= self.twist.linear * PERIOD_S;
        command
    }

    fn cycles(&mut self, cycles: u32, sees: bool) {
        for cycle in 0..cycles {
            self.cycle(cycle, &AHEAD, sees);
        }
    }
}

const AHEAD: Twist = Twist::new(0.8, 0.0);

/// The switch of a robot's layer, and the robot.
fn with_switch(wall_m: f64) -> (Robot, OperatorSwitch) {
    with_base(wall_m, &BaseSettings::default())
}

fn with_base(wall_m: f64, base: &BaseSettings) -> (Robot, OperatorSwitch) {
    let mut robot = Robot::new(wall_m, base);
    let body = Footprint::round(0.3).expect("a radius");
    let monitor = CollisionMonitorSettings::default();
    let layer = ProtectiveLayer::new(monitor, &body, Limits::default(), PERIOD_S);
    let layer = layer.expect("valid settings");
    let switch = layer.operator();
    robot.controller.protect(layer);
    (robot, switch)
}

#[test]
fn base_stands_until_it_is_armed_and_after_the_operator_stops() {
    let (mut robot, switch) = with_switch(8.0);
    robot.cycles(50, true);
    assert_eq!(robot.twist, Twist::STOP);
    assert_eq!(robot.controller.status(), &DriveStatus::Protected(ProtectiveAction::NotArmed));
    switch.arm();
    robot.cycles(50, true);
    assert!(robot.twist.linear > 0.5, "{:?}", robot.twist);
    switch.stop();
    // Zero at once, without a ramp.
    assert_eq!(robot.cycle(1, &AHEAD, true), OutgoingCommand::Drive(Twist::STOP));
    robot.cycles(50, true);
    assert_eq!(robot.twist, Twist::STOP);
    // Arming alone restarts from zero.
    switch.arm();
    let OutgoingCommand::Drive(first) = robot.cycle(1, &AHEAD, true) else {
        panic!("a motion");
    };
    assert!(first.linear < 0.1, "{first:?}");
}

#[test]
fn base_stops_before_a_wall_that_the_planner_drives_at() {
    let (mut robot, switch) = with_switch(4.0);
    switch.arm();
    robot.cycles(1000, true);
    assert_eq!(robot.twist, Twist::STOP);
    assert!((0.3..0.5).contains(&robot.wall_m), "{} m", robot.wall_m);
}

/// The sender brakes the tracks at 0.4 m/s^2, and the robot's own limits say 1.0 m/s^2: the weaker counts.
#[test]
fn base_with_weak_brakes_of_its_tracks_stops_before_a_wall() {
    let mut base = BaseSettings::default();
    base.tracks.decel_lim_track = -0.4;
    let (mut robot, switch) = with_base(4.0, &base);
    switch.arm();
    robot.cycles(1500, true);
    assert_eq!(robot.twist, Twist::STOP);
    assert!((0.3..0.5).contains(&robot.wall_m), "{} m", robot.wall_m);
}

#[test]
fn base_stops_when_its_lidar_is_silent() {
    let (mut robot, switch) = with_switch(9.0);
    switch.arm();
    robot.cycles(50, true);
    assert!(robot.twist.linear > 0.5);
    // 0.3 s of patience and 0.8 s of braking, before that 5 cycles to the next scan.
    robot.cycles(70, false);
    assert_eq!(robot.twist, Twist::STOP);
    let status = robot.controller.status();
    assert!(
        matches!(status, DriveStatus::Protected(ProtectiveAction::StaleScan { .. })),
        "{status:?}"
    );
}
