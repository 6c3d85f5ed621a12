//! Ages of inputs by their stamps: what is old stops the robot, however punctually it arrives.

use inbye::geometry::{Pose, Twist};
use inbye::ros::node::IncomingMessage;

use super::action::cancel;
use super::robot::{Robot, transform};

/// Ticks of 0.1 s until the robot stands: 0.3 s of age, and braking from 1 m/s at 1 m/s^2.
const STOP_TICKS: usize = 14;

/// A robot in a frame of its own that tf connects to the map, at speed.
fn localized(transform_late_s: f64) -> Robot {
    let mut robot = Robot::ready();
    (robot.frame, robot.frame_at) = ("odom", Pose::new(0.8, -0.3, 0.6));
    (robot.has_transform, robot.transform_late_s) = (true, transform_late_s);
    robot
}

#[track_caller]
fn stops_within(robot: &mut Robot, ticks: usize) {
    let steps = robot.until(ticks + 1, Robot::stands);
    assert!(steps <= ticks, "{steps}");
    (0..30).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
}

#[test]
fn robot_stands_when_the_transform_stops_and_continues_with_it() {
    let mut robot = localized(0.0);
    robot.until(50, |robot| robot.speed() > 0.9);
    let from = robot.pose;
    robot.has_transform = false;
    stops_within(&mut robot, STOP_TICKS);
    let driven_m = (robot.pose.position() - from.position()).norm();
    assert!(driven_m < 1.1, "{driven_m}");
    assert!(robot.has_notice("tf no longer gives the pose of `odom` in `map`"));
    robot.has_transform = true;
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn transform_that_is_dated_ahead_is_as_old_as_its_arrival() {
    // Localization nodes date their transforms a second ahead.
    let mut robot = localized(-1.0);
    robot.until(50, |robot| robot.speed() > 0.9);
    robot.has_transform = false;
    stops_within(&mut robot, STOP_TICKS);
}

#[test]
fn static_transform_does_not_age() {
    let mut robot = Robot::ready();
    (robot.frame, robot.frame_at) = ("odom", Pose::new(0.8, -0.3, 0.6));
    let place = transform("map", "odom", &robot.frame_at, 1.0);
    robot.receive(&IncomingMessage::StaticTransforms(place));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

/// Delays an input of a robot.
type Delay = fn(&mut Robot);

#[test]
fn robot_with_steadily_late_inputs_never_starts() {
    let late: [(Delay, &str); 3] = [
        (|robot| robot.scan_late_s = 2.0, "messages on scan are 2.00 s old"),
        (|robot| robot.odometry_late_s = 2.0, "messages on odom are 2.00 s old"),
        (|robot| robot.transform_late_s = 2.0, "its last transform is too old"),
    ];
    for (delay, words) in late {
        let mut robot = localized(0.0);
        delay(&mut robot);
        (0..20).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP), "{words}"));
        assert!(robot.has_notice(words), "{words}: {:?}", robot.notices);
    }
}

/// Scans that are 0.25 s old at their arrival are 0.35 s old before the next one comes.
#[test]
fn scans_that_become_too_old_before_the_next_one_are_reported() {
    let mut robot = localized(0.0);
    robot.scan_late_s = 0.25;
    for _ in 0..5 {
        robot.step();
    }
    let words = "messages on scan are 0.25 s old when they arrive, and 0.35 s before the next one, the limit is 0.3 s";
    assert!(robot.has_notice(words), "{:?}", robot.notices);
}

#[test]
fn robot_at_speed_stands_when_scans_become_two_seconds_old() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.9);
    robot.scan_late_s = 2.0;
    stops_within(&mut robot, STOP_TICKS);
}

#[test]
fn robot_stands_while_a_clock_is_ahead() {
    let ahead: [fn(&mut Robot); 2] =
        [|robot| robot.scan_late_s = -5.0, |robot| robot.odometry_late_s = -5.0];
    for advance in ahead {
        let mut robot = Robot::ready();
        robot.until(50, |robot| robot.speed() > 0.9);
        advance(&mut robot);
        stops_within(&mut robot, STOP_TICKS);
        assert!(robot.has_notice("its stamp is 5.000 s in the future"), "{:?}", robot.notices);
        assert!(robot.has_notice("chrony or NTP"));
    }
}

#[test]
fn small_delays_and_offsets_are_reported_and_do_not_stop_the_robot() {
    let mut robot = localized(0.1);
    (robot.scan_late_s, robot.odometry_late_s) = (0.12, -0.04);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    let least_s = &robot.core.stats().least_delay_s;
    assert!((least_s["scan"] - 0.12).abs() < 1e-6, "{least_s:?}");
    assert!((least_s["odom"] + 0.04).abs() < 1e-6, "{least_s:?}");
    assert!(robot.core.stats().rejected.is_empty());
}

#[test]
fn clock_that_is_slightly_ahead_does_not_make_inputs_younger() {
    let mut robot = Robot::ready();
    robot.scan_late_s = -0.09;
    robot.until(50, |robot| robot.speed() > 0.9);
    robot.has_scan = false;
    // The last scan seems to be from the future by 0.09 s; it counts from its arrival.
    let steps = robot.until(50, |robot| robot.has_notice("there is no fresh scan"));
    assert!(steps <= 5, "{steps}");
}

/// A robot at speed whose next tick comes after a time, seconds. Returns it with its last command.
fn late_at_speed(elapsed_s: f64) -> (Robot, Twist) {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.9);
    robot.step_s = elapsed_s;
    let last = robot.step().expect("it drives");
    (robot, last)
}

/// A cancelled goal makes the robot brake.
#[test]
fn late_tick_brakes_for_its_whole_time_and_is_reported() {
    let (mut robot, last) = late_at_speed(0.25);
    robot.receive(&cancel(1, [0; 16]));
    let braked = robot.step().expect("it brakes");
    assert!((last.linear - braked.linear - 0.25).abs() < 1e-6, "{last:?} {braked:?}");
    assert_eq!(robot.core.stats().late_ticks, 1);
    let late = "the control loop is late: 0.250 s passed since the tick before, the control period is 0.1 s";
    assert!(robot.has_notice(late), "{:?}", robot.notices);
    // It is late at every tick, and reported once in ten seconds.
    robot.until(8, Robot::stands);
    assert!(robot.core.stats().late_ticks > 2);
    let count = robot.notices.iter().filter(|notice| notice.contains("is late")).count();
    assert_eq!(count, 1, "{:?}", robot.notices);
}

/// Odometry arrives all the time: a notice that none was received would send its reader to the driver.
#[test]
fn notice_after_a_late_tick_names_the_pause() {
    let (mut robot, _) = late_at_speed(0.5);
    robot.step();
    let words = "waiting: no odometry was received since the node or its transport paused";
    assert!(robot.has_notice(words), "{:?}", robot.notices);
}

#[test]
fn robot_stands_after_a_stall_of_half_a_second() {
    let (mut robot, _) = late_at_speed(0.5);
    robot.step_s = 0.1;
    assert_eq!(robot.step(), Some(Twist::STOP));
    assert_eq!(robot.core.stats().late_ticks, 1);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn late_ticks_accelerate_for_one_period() {
    let mut robot = Robot::ready();
    robot.step_s = 0.25;
    let mut last = 0.0;
    for _ in 0..8 {
        let speed = robot.step().expect("it drives").linear;
        assert!(speed - last < 0.1 + 1e-9, "{last} {speed}");
        last = speed;
    }
    assert!(last > 0.3, "{last}");
}
