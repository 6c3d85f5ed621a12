//! A robot whose odometry moves and whose scans do not: bogged tracks, or a frozen lidar.

use inbye::geometry::{Pose, Twist};
use inbye::localization::{LocalizationStatus, LostReason};
use inbye::map::TimedScan;

use super::room::{ROOM, Stage, ground, lidar};

const START: Pose = Pose::new(3.0, 5.0, 0.0);

/// A robot in a room. It stands while it is lost, and drives by its odometry otherwise.
struct Robot {
    stage: Stage,
    odometry: Pose,
    /// Distance by odometry while the pose counts as known, metres.
    driven_m: f64,
    /// Turn by odometry since the start, radians, not wrapped.
    turned_rad: f64,
    tick: u32,
}

impl Robot {
    fn new() -> Self {
        let stage = Stage::new(ground(Pose::default(), &ROOM), &START);
        Self { stage, odometry: Pose::default(), driven_m: 0.0, turned_rad: 0.0, tick: 0 }
    }

    /// One revolution. The odometry moves by a speed, m/s, and a turn rate, rad/s.
    fn tick(&mut self, speed: f64, rate: f64, scan: impl FnOnce(&mut Stage, f64) -> TimedScan) {
        let time_s = 0.1 * f64::from(self.tick);
        self.tick += 1;
        if self.status().lost_reason().is_none() {
            let twist = Twist::new(speed, rate);
            self.odometry = self.odometry.after(&twist, 0.1);
            self.driven_m += 0.1 * speed.abs();
            self.turned_rad += 0.1 * rate;
        }
        self.stage.localizer.predict(time_s, &self.odometry);
        let scan = scan(&mut self.stage, time_s);
        self.stage.localizer.update(&scan);
    }

    fn status(&self) -> LocalizationStatus {
        self.stage.localizer.estimate().status
    }
}

/// Drives straight or turns by a share of the odometry's motion; the robot, and its status after each revolution.
fn drive(speed: f64, rate: f64, share: f64, ticks: u32) -> (Robot, Vec<LocalizationStatus>) {
    let mut robot = Robot::new();
    let mut statuses = Vec::new();
    for _ in 0..ticks {
        let moved = Twist::new(share * robot.driven_m, share * robot.turned_rad);
        let truth = START.after(&moved, 1.0);
        robot.tick(speed, rate, |stage, time_s| {
            let seen = lidar().scan(&stage.world, &truth, &mut stage.rng);
            TimedScan::from_scan(&seen.scan, time_s, 0.0)
        });
        statuses.push(robot.status());
    }
    (robot, statuses)
}

#[test]
fn bogged_robot_is_reported_and_gives_up_after_the_third_time() {
    for (speed, rate) in [(0.2, 0.0), (0.5, 0.0), (1.0, 0.0), (0.0, 0.8)] {
        let (robot, statuses) = drive(speed, rate, 0.0, 400);
        let first = statuses.iter().position(|status| status.lost_reason().is_some());
        let first = first.unwrap_or_else(|| panic!("{speed}, {rate}: never lost"));
        assert_eq!(statuses[first].lost_reason(), Some(LostReason::NotMoving), "{speed}, {rate}");
        // Within the motion that shows it, and in any case within three seconds.
        assert!(first <= 30, "{speed}, {rate}: lost at {first}");
        let last_known = statuses.iter().rposition(|status| status.lost_reason().is_none());
        assert!(last_known < Some(200), "{speed}, {rate}: {last_known:?}");
        assert!(robot.driven_m < 2.5, "{speed}: {} m", robot.driven_m);
    }
}

#[test]
fn frozen_lidar_is_reported_and_gives_up_after_the_third_time() {
    let mut robot = Robot::new();
    let mut frozen = None;
    let mut reasons = Vec::new();
    for tick in 0..400 {
        let along_m = robot.odometry.x;
        robot.tick(0.5, 0.0, |stage, time_s| {
            let truth = Pose::new(START.x + along_m, START.y, START.yaw);
            let mut seen = || lidar().scan(&stage.world, &truth, &mut stage.rng).scan;
            let scan = if tick < 20 { seen() } else { frozen.get_or_insert_with(seen).clone() };
            TimedScan::from_scan(&scan, time_s, 0.0)
        });
        reasons.push(robot.status().lost_reason());
    }
    assert!(reasons[..20].iter().all(Option::is_none), "{reasons:?}");
    let first = reasons.iter().position(Option::is_some).expect("the loss is noticed");
    assert!(first <= 35, "{first}");
    assert_eq!(reasons[first], Some(LostReason::NotMoving));
    assert!(reasons[250..].iter().all(Option::is_some), "{reasons:?}");
    assert!(robot.driven_m < 3.5, "{}", robot.driven_m);
}

#[test]
fn slipping_robot_is_not_taken_for_a_stuck_one() {
    for share in [0.97, 0.8, 0.5] {
        let (robot, statuses) = drive(0.3, 0.0, share, 80);
        let is_stuck = |status: &LocalizationStatus| {
            matches!(status.lost_reason(), Some(LostReason::NotMoving | LostReason::LostAgain))
        };
        assert!(!statuses.iter().any(is_stuck), "{share}: {statuses:?}");
        assert!(robot.driven_m > 1.0, "{share}: {}", robot.driven_m);
    }
    let (_, statuses) = drive(0.0, 0.6, 0.74, 100);
    assert!(statuses.iter().all(|status| status.lost_reason().is_none()), "{statuses:?}");
}
