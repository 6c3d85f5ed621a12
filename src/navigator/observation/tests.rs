//! Each limit of an observation, just below it and just above it.

use super::ObservationFault::{
    ClockJump, LidarFouled, MotionReversed, NoOdometry, NoPose, NoScan, PoseFrozen, PoseJump,
};
use super::*;
use crate::map::{GridFrame, ObstacleGrid};
use crate::robot::Footprint;

/// Validates observations of a robot in free space at 10 Hz.
struct Check {
    validator: ObservationValidator,
    known: RayCaster,
    time_s: f64,
}

impl Check {
    fn new() -> Self {
        let frame = GridFrame::new(10, 10, 1.0, Pose::default()).expect("a small map");
        let known = RayCaster::new(&ObstacleGrid::new(frame, vec![false; 100]));
        Self { validator: ObservationValidator::default(), known, time_s: 100.0 }
    }

    /// Validates an observation after a time, seconds; the function changes it.
    fn after(
        &mut self,
        elapsed_s: f64,
        commanded: Twist,
        change: impl FnOnce(&mut Observation),
    ) -> Option<ObservationFault> {
        self.time_s += elapsed_s;
        let mut seen = self.observation();
        change(&mut seen);
        self.validate(&seen, commanded).err()
    }

    /// An observation of a robot that stands, all of it measured now.
    fn observation(&self) -> Observation {
        let time_s = self.time_s;
        Observation {
            time_s,
            pose: Pose::default(),
            pose_s: time_s,
            lost: None,
            twist: Twist::STOP,
            odometry_s: time_s,
            scan: Scan::from_measurements(9, 9.0, (0..9).map(|beam| (f64::from(beam), 1.0))),
            scan_s: time_s,
            scan_changed_s: time_s,
            sent: None,
        }
    }

    fn validate(&mut self, seen: &Observation, commanded: Twist) -> Result<bool, ObservationFault> {
        let settings = NavigatorSettings::default();
        let robot = RobotModel {
            limits: Limits::default(),
            footprint: Footprint::round(0.3).expect("a radius"),
        };
        self.validator.validate(seen, &commanded, &robot, &settings, &self.known)
    }

    /// The fault of an observation 0.1 s after a sound one.
    fn second(change: impl FnOnce(&mut Observation)) -> Option<ObservationFault> {
        let mut check = Self::new();
        assert_eq!(check.after(0.1, Twist::STOP, |_| {}), None);
        check.after(0.1, Twist::STOP, change)
    }
}

#[test]
fn each_age_counts_from_its_limit() {
    let first = |change: fn(&mut Observation)| Check::new().after(0.1, Twist::STOP, change);
    assert_eq!(first(|seen| seen.scan_s -= 0.29), None);
    assert_eq!(first(|seen| seen.scan_s -= 0.31), Some(NoScan));
    assert_eq!(Check::second(|seen| seen.odometry_s -= 0.29), None);
    assert_eq!(Check::second(|seen| seen.odometry_s -= 0.31), Some(NoOdometry));
    assert_eq!(Check::second(|seen| seen.pose_s -= 0.99), None);
    assert_eq!(Check::second(|seen| seen.pose_s -= 1.01), Some(NoPose));
}

#[test]
fn measurement_from_the_future_and_jump_of_the_clock_are_faults() {
    assert_eq!(Check::second(|seen| seen.scan_s += 0.04), None);
    assert_eq!(Check::second(|seen| seen.scan_s += 0.06), Some(ClockJump));
    assert_eq!(Check::second(|seen| seen.odometry_s += 0.04), None);
    assert_eq!(Check::second(|seen| seen.odometry_s += 0.06), Some(ClockJump));
    assert_eq!(Check::second(|seen| seen.pose_s += 0.99), None);
    assert_eq!(Check::second(|seen| seen.pose_s += 1.01), Some(ClockJump));
    for (elapsed_s, expected) in [(0.99, None), (1.01, Some(ClockJump)), (-0.01, Some(ClockJump))] {
        let mut check = Check::new();
        check.after(0.1, Twist::STOP, |_| {});
        assert_eq!(check.after(elapsed_s, Twist::STOP, |_| {}), expected, "{elapsed_s} s");
    }
    let not_finite = Check::second(|seen| seen.scan_changed_s = f64::NAN);
    assert_eq!(not_finite, Some(ObservationFault::NotFinite));
}

/// 0.5 m of correction, and twice the distance at the speed limit.
#[test]
fn pose_may_jump_by_a_correction_and_the_fifth_pose_elsewhere_is_accepted() {
    let far_m = CORRECTION_M + SPEED_FACTOR * Limits::default().max_vel_x * 0.1;
    assert_eq!(Check::second(|seen| seen.pose.x = far_m - 0.01), None);
    assert_eq!(Check::second(|seen| seen.pose.x = far_m + 0.01), Some(PoseJump));
    let mut check = Check::new();
    check.after(0.1, Twist::STOP, |_| {});
    let mut jumps = |x: f64| check.after(0.1, Twist::STOP, |seen| seen.pose.x = x);
    // Poses that do not agree with each other are never accepted.
    (0..20).for_each(|tick| assert_eq!(jumps(20.0 + 5.0 * f64::from(tick)), Some(PoseJump)));
    (0..4).for_each(|_| assert_eq!(jumps(-20.0), Some(PoseJump)));
    // A jump of the clock begins their count again.
    assert_eq!(check.after(1.01, Twist::STOP, |_| {}), Some(ClockJump));
    let mut jumps = |x: f64| check.after(0.1, Twist::STOP, |seen| seen.pose.x = x);
    (0..4).for_each(|_| assert_eq!(jumps(-20.0), Some(PoseJump)));
    assert_eq!(jumps(-20.0), None);
}

#[test]
fn pose_that_stays_under_a_command_is_frozen_until_it_changes() {
    for (linear, angular, freezes) in [(-0.11, 0.0, true), (0.0, -0.21, true), (0.09, 0.19, false)]
    {
        let mut check = Check::new();
        let command = Twist::new(linear, angular);
        let faults: Vec<_> = (0..9).map(|_| check.after(0.1, command, |_| {})).collect();
        let first = faults.iter().position(|fault| *fault == Some(PoseFrozen));
        // Compared from the second one; more than 0.5 s later.
        assert_eq!(first.is_some_and(|first| (6..=7).contains(&first)), freezes, "{faults:?}");
        // A robot that brakes for this reason does not drive any more.
        let braked = check.after(0.1, Twist::STOP, |_| {});
        assert_eq!(braked.is_some(), freezes);
        assert_eq!(check.after(0.1, Twist::STOP, |seen| seen.pose.x = 0.01), None);
    }
}

#[test]
fn poses_against_the_speed_are_a_fault_from_half_of_it() {
    // 0.5 m/s for 0.8 s: above 0.2 m after the fifth step.
    for (speed, share, expected) in [
        (0.5, -0.6, true),
        (-0.5, -0.6, true),
        (0.5, -0.4, false),
        (-0.5, 1.0, false),
        (0.2, -1.0, false),
    ] {
        let mut check = Check::new();
        let faults = (0..9).map(|tick| {
            check.after(0.1, Twist::STOP, |seen| {
                seen.twist.linear = speed;
                seen.pose.x = speed * share * 0.1 * f64::from(tick);
            })
        });
        let first =
            faults.collect::<Vec<_>>().iter().position(|fault| *fault == Some(MotionReversed));
        assert_eq!(first.is_some(), expected, "{speed} m/s, {share}");
        assert!(first.is_none_or(|first| (4..=5).contains(&first)), "{first:?}");
    }
}

#[test]
fn scan_without_a_measurement_lost_pose_and_frozen_scan_are_faults() {
    let blank = |seen: &mut Observation| seen.scan.ranges.fill(f64::NAN);
    assert_eq!(Check::new().after(0.1, Twist::STOP, blank), Some(NoScan));
    let lost = |seen: &mut Observation| seen.lost = Some(LostReason::PoorMatch);
    let expected = Some(ObservationFault::Lost(LostReason::PoorMatch));
    assert_eq!(Check::second(lost), expected);
    let mut check = Check::new();
    let faults = (0..6).map(|_| {
        check.after(0.1, Twist::STOP, |seen| {
            seen.twist.angular = 1.0;
            seen.scan_changed_s = 100.0;
        })
    });
    let expected = [None, None, None].into_iter().chain([Some(ObservationFault::FrozenScan); 3]);
    assert!(faults.eq(expected));
}

/// Dirt on the lidar, or the robot's own mast: a second of scans.
#[test]
fn surface_within_the_outline_is_a_fault_after_ten_scans() {
    let mut check = Check::new();
    let fouled = |seen: &mut Observation| {
        seen.scan =
            Scan::from_measurements(360, 9.0, (0..7).map(|beam| (f64::from(beam) / 57.3, 0.12)));
    };
    let faults: Vec<_> = (0..11).map(|_| check.after(0.1, Twist::STOP, fouled)).collect();
    assert_eq!((faults[8], faults[9]), (None, Some(LidarFouled)));
    assert_eq!(check.after(0.1, Twist::STOP, |_| {}), None);
}

/// A room of 10 m with walls, and a lidar without a return.
#[test]
fn blind_lidar_is_a_fault_and_a_later_scan_is_valid() {
    let frame = GridFrame::new(10, 10, 1.0, Pose::default()).expect("a small map");
    let is_wall = |cell: usize| {
        let at = frame.cell_at(cell);
        [at.column, at.row].iter().any(|&at| at == 0 || at == 9)
    };
    let room = ObstacleGrid::new(frame, (0..100).map(is_wall).collect());
    let mut check = Check { known: RayCaster::new(&room), ..Check::new() };
    let sees = |check: &mut Check, range: f64| {
        check.time_s += 0.1;
        let mut seen = check.observation();
        seen.pose = Pose::new(5.0, 5.0, 0.0);
        seen.scan = Scan::from_measurements(
            90,
            12.0,
            (0..90).map(|beam| (f64::from(beam) * 0.0698, range)),
        );
        check.validate(&seen, Twist::STOP)
    };
    assert_eq!(sees(&mut check, 4.0), Ok(true));
    assert_eq!(sees(&mut check, f64::INFINITY), Ok(false), "not yet a fault, but suspect");
    assert_eq!(sees(&mut check, f64::INFINITY), Err(ObservationFault::LidarBlind));
    assert_eq!(sees(&mut check, 4.0), Ok(true));
}

#[test]
fn each_number_must_be_finite() {
    let changes: [fn(&mut Observation); 8] = [
        |seen| seen.sent = Some(Twist::new(f64::NAN, 0.0)),
        |seen| seen.time_s = f64::NAN,
        |seen| seen.pose_s = f64::NEG_INFINITY,
        |seen| seen.odometry_s = f64::NAN,
        |seen| seen.scan_s = f64::NAN,
        |seen| seen.scan_changed_s = f64::INFINITY,
        |seen| seen.pose.yaw = f64::NAN,
        |seen| seen.twist.angular = f64::NAN,
    ];
    for (number, change) in changes.iter().enumerate() {
        assert_eq!(Check::second(change), Some(ObservationFault::NotFinite), "{number}");
    }
}

#[test]
fn scan_without_directions_is_a_fault_that_names_its_cause() {
    type Change = fn(&mut Scan);
    let changes: [(Change, ScanError); 5] = [
        (|scan| scan.origin.x = f64::NAN, ScanError::Place),
        (|scan| scan.angle_min = f64::INFINITY, ScanError::FirstAngle),
        (|scan| scan.angle_increment = -0.1, ScanError::AngleIncrement),
        (|scan| scan.range_max = f64::NAN, ScanError::LargestRange),
        // Degrees.
        (|scan| scan.angle_increment = scan.angle_increment.to_degrees(), ScanError::TooWide),
    ];
    for (change, error) in changes {
        let found = Check::second(|seen| change(&mut seen.scan));
        assert_eq!(found, Some(ObservationFault::InvalidScan(error)));
    }
}

#[test]
fn scan_with_an_old_stamp_is_no_new_one() {
    let mut check = Check::new();
    let new = check.observation();
    assert_eq!(check.validate(&new, Twist::STOP), Ok(true));
    assert_eq!(check.validate(&new, Twist::STOP), Ok(false));
    let older = Observation { scan_s: new.scan_s - 0.1, ..new };
    assert_eq!(check.validate(&older, Twist::STOP), Ok(false));
}

/// A robot that stands at `x` before, is lost for a second or not, and then is at another `x`.
#[test]
fn pose_where_the_robot_cannot_have_driven_to_is_relocated() {
    for (is_lost, x, expected) in
        [(true, 9.0, true), (true, 0.4, false), (false, 9.0, true), (false, 0.4, false)]
    {
        let mut check = Check::new();
        let mut see = |x: f64, lost: Option<LostReason>| {
            check.after(0.1, Twist::STOP, |seen| (seen.pose.x, seen.lost) = (x, lost));
            std::mem::take(&mut check.validator.is_relocated)
        };
        let before = [see(0.0, None), see(0.0, None)];
        assert_eq!(before, [false, false]);
        let lost = is_lost.then_some(LostReason::PoorMatch);
        assert!((0..10).all(|_| !see(0.0, lost)));
        let after: Vec<bool> = (0..12).map(|_| see(x, None)).collect();
        assert_eq!(after.contains(&true), expected, "{is_lost}, {x} m: {after:?}");
        assert!(after.iter().filter(|it| **it).count() <= 1, "once");
    }
}
