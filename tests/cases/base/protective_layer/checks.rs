//! Each check by itself, with hand-made scans.

use core::f64::consts::{PI, TAU};

use inbye::base::{CollisionMonitorSettings, ProtectiveAction, ProtectiveLayer};
use inbye::geometry::{Point, Twist};
use inbye::map::{Beam, TimedScan};
use inbye::robot::{Disc, Footprint, Limits};

/// Two discs of 0.25 m: a body 0.5 m wide.
pub fn body() -> Footprint {
    let discs = [0.15, -0.15].map(|x| Disc { x, y: 0.0, radius: 0.25 });
    Footprint::new(discs.to_vec()).expect("a footprint")
}

pub fn limits() -> Limits {
    Limits::default().min_vel_x(-1.0)
}

pub fn layer(settings: CollisionMonitorSettings) -> ProtectiveLayer {
    let mut layer = ProtectiveLayer::new(settings, &body(), limits(), 0.1).expect("valid settings");
    layer.arm();
    layer.set_stopping(0.2, 1.0);
    layer
}

/// A scan of 360 beams with a range for each direction, radians in (-pi, pi].
pub fn scan(stamp_s: f64, range: impl Fn(f64) -> f64) -> TimedScan {
    let beam = |index: i32| {
        let angle = (f64::from(index) + 0.5) / 360.0 * TAU - PI;
        Beam { angle, range: range(angle), time_s: stamp_s }
    };
    TimedScan { beams: (0..360).map(beam).collect(), range_max: 10.0, ..TimedScan::default() }
}

/// Range to a wall across the x axis at a distance ahead; nothing elsewhere but a wall far behind.
pub fn wall_ahead(at_m: f64) -> impl Fn(f64) -> f64 {
    move |angle| {
        let ahead = libm::cos(angle);
        let range = if ahead > 0.0 { at_m / ahead } else { -9.0 / ahead };
        if range <= 10.0 { range } else { f64::INFINITY }
    }
}

/// Range within a corridor along the x axis.
pub fn corridor(width_m: f64) -> impl Fn(f64) -> f64 {
    move |angle| {
        let range = width_m / 2.0 / libm::sin(angle).abs();
        if range <= 10.0 { range } else { f64::INFINITY }
    }
}

/// Range to a disc at a point, and to a wall of 9 m around.
pub fn disc(center: Point, radius_m: f64) -> impl Fn(f64) -> f64 {
    move |angle| {
        let (sin, cos) = libm::sincos(angle);
        let (along, across) = (center.x * cos + center.y * sin, center.y * cos - center.x * sin);
        let half = radius_m * radius_m - across * across;
        if half >= 0.0 && along > 0.0 { along - half.sqrt() } else { 9.0 }
    }
}

/// The command instead of a target, for a robot that moves as it was sent, by one scan at the time zero.
fn limited(range: impl Fn(f64) -> f64, target: Twist, sent: Twist) -> (Twist, ProtectiveAction) {
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_motion(&sent, 0.0);
    layer.update_scan(&scan(0.0, range), 0.0);
    layer.limit(&target, &sent, 0.0)
}

const FULL: Twist = Twist::new(1.0, 0.0);

#[test]
fn nothing_moves_before_it_is_armed_and_after_the_operator_stops() {
    let mut layer =
        ProtectiveLayer::new(CollisionMonitorSettings::default(), &body(), limits(), 0.1)
            .expect("valid settings");
    layer.update_scan(&scan(0.0, wall_ahead(8.0)), 0.0);
    assert_eq!(layer.limit(&FULL, &Twist::STOP, 0.0), (Twist::STOP, ProtectiveAction::NotArmed));
    layer.arm();
    assert_eq!(layer.limit(&FULL, &Twist::STOP, 0.0), (FULL, ProtectiveAction::Pass));
    layer.operator().stop();
    layer.disarm();
    let stopped = (Twist::STOP, ProtectiveAction::OperatorStop);
    assert_eq!(layer.limit(&FULL, &FULL, 0.05), stopped);
    layer.arm();
    layer.disarm();
    assert_eq!(layer.limit(&FULL, &FULL, 0.05).1, ProtectiveAction::NotArmed);
}

#[test]
fn switch_acts_without_a_lidar_and_when_scans_are_ignored() {
    let off = CollisionMonitorSettings::default().enabled(false);
    let on = CollisionMonitorSettings::default();
    for mut layer in [layer(off), layer(on).without_lidar()] {
        assert_eq!(layer.limit(&FULL, &Twist::STOP, 0.0), (FULL, ProtectiveAction::Pass));
        layer.operator_stop();
        assert_eq!(layer.limit(&FULL, &Twist::STOP, 0.0).0, Twist::STOP);
    }
}

#[test]
fn missing_old_and_future_scans_stop() {
    let mut layer = layer(CollisionMonitorSettings::default());
    assert_eq!(layer.limit(&FULL, &FULL, 0.0), (Twist::STOP, ProtectiveAction::NoScan));
    layer.update_scan(&scan(1.0, wall_ahead(8.0)), 1.0);
    assert!(layer.limit(&FULL, &FULL, 1.29).1.passes());
    for now_s in [0.69, 1.31] {
        let (command, action) = layer.limit(&FULL, &FULL, now_s);
        assert_eq!(command, Twist::STOP);
        assert!(matches!(action, ProtectiveAction::StaleScan { .. }), "{action}");
    }
}

#[test]
fn scan_without_returns_stops_unless_the_open_is_permitted() {
    let (command, action) = limited(|_| f64::INFINITY, FULL, FULL);
    assert_eq!((command, action), (Twist::STOP, ProtectiveAction::BlindScan { share: 0.0 }));
    assert_eq!(limited(|_| f64::NAN, FULL, FULL).0, Twist::STOP);
    let mut open = layer(CollisionMonitorSettings::default().min_return_share(0.0));
    open.update_scan(&scan(0.0, |_| f64::INFINITY), 0.0);
    assert_eq!(open.limit(&FULL, &FULL, 0.0), (FULL, ProtectiveAction::Pass));
}

#[test]
fn identical_scans_stop_a_base_that_moves_and_only_that() {
    for (speed, expected) in [(0.5, true), (0.0, false)] {
        let mut layer = layer(CollisionMonitorSettings::default());
        let moves = Twist::new(speed, 0.0);
        let mut stopped = false;
        for tick in 0..10 {
            let now_s = f64::from(tick) * 0.1;
            layer.update_motion(&moves, now_s);
            layer.update_scan(&scan(now_s, wall_ahead(9.0)), now_s);
            let (_, action) = layer.limit(&moves, &moves, now_s);
            stopped |= matches!(action, ProtectiveAction::FrozenScan { .. });
        }
        assert_eq!(stopped, expected, "{speed} m/s");
    }
}

#[test]
fn identical_scans_of_a_base_that_stands_since_they_began_do_not_stop_it() {
    let mut layer = layer(CollisionMonitorSettings::default());
    for tick in 0..20 {
        let now_s = f64::from(tick) * 0.1;
        // The base stops at once after the first report; a lidar without noise then repeats its scan.
        layer.update_motion(if tick == 0 { &FULL } else { &Twist::STOP }, now_s);
        layer.update_scan(&scan(now_s, wall_ahead(9.0)), now_s);
    }
    let (_, action) = layer.limit(&FULL, &Twist::STOP, 1.9);
    assert!(action.passes(), "{action}");
}

#[test]
fn frozen_lidar_is_released_by_a_new_scan() {
    let mut layer = layer(CollisionMonitorSettings::default());
    for tick in 0..8 {
        let now_s = f64::from(tick) * 0.1;
        layer.update_motion(&FULL, now_s);
        layer.update_scan(&scan(now_s, wall_ahead(9.0)), now_s);
    }
    assert!(!layer.limit(&FULL, &FULL, 0.7).1.passes());
    layer.update_scan(&scan(0.8, wall_ahead(8.9)), 0.8);
    assert!(layer.limit(&FULL, &FULL, 0.8).1.passes());
}

#[test]
fn robot_stops_for_a_wall_within_its_stopping_distance_and_passes_before() {
    // From 1 m/s: 0.2 m of delay, 0.1 m of its period and 0.5 m of braking, before a body that reaches 0.4 m ahead.
    assert!(limited(wall_ahead(1.3), FULL, FULL).1.passes());
    let (slower, action) = limited(wall_ahead(1.15), FULL, FULL);
    assert!(slower.linear > 0.3 && slower.linear < 1.0, "{slower:?} {action}");
    assert!(matches!(action, ProtectiveAction::Approach { .. }), "{action}");
    let (stopped, action) = limited(wall_ahead(0.9), FULL, FULL);
    assert_eq!(stopped, Twist::STOP);
    assert!(matches!(action, ProtectiveAction::Stop { .. }), "{action}");
}

#[test]
fn measured_motion_counts_where_it_differs_from_the_sent_one() {
    // A base that still rolls at 1 m/s, although its command is to creep.
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_motion(&FULL, 0.0);
    layer.update_scan(&scan(0.0, wall_ahead(0.9)), 0.0);
    let creep = Twist::new(0.1, 0.0);
    assert_eq!(layer.limit(&creep, &creep, 0.0).0, Twist::STOP);
    layer.update_motion(&creep, 0.05);
    assert_eq!(layer.limit(&creep, &creep, 0.05), (creep, ProtectiveAction::Pass));
}

#[test]
fn identified_delay_and_deceleration_lengthen_the_stop() {
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_scan(&scan(0.0, wall_ahead(1.4)), 0.0);
    layer.update_motion(&FULL, 0.0);
    assert!(layer.limit(&FULL, &FULL, 0.0).1.passes());
    layer.set_stopping(0.5, 1.0);
    assert!(layer.limit(&FULL, &FULL, 0.0).0.linear < 1.0);
    layer.set_stopping(0.2, 0.5);
    assert!(layer.limit(&FULL, &FULL, 0.0).0.linear < 1.0);
    // What is no number changes nothing.
    layer.set_stopping(f64::NAN, 0.0);
    layer.set_stopping(0.1, 2.0);
    assert!(layer.limit(&FULL, &FULL, 0.0).1.passes());
}

#[test]
fn corridor_of_one_metre_is_driven_at_full_speed() {
    let settings = CollisionMonitorSettings::default();
    let mut layer = layer(settings);
    layer.update_motion(&FULL, 0.0);
    layer.update_scan(&scan(0.0, corridor(1.0)), 0.0);
    assert_eq!(layer.limit(&FULL, &FULL, 0.0), (FULL, ProtectiveAction::Pass));
    let reverse = Twist::new(-1.0, 0.0);
    layer.update_motion(&reverse, 0.01);
    assert_eq!(layer.limit(&reverse, &reverse, 0.01), (reverse, ProtectiveAction::Pass));
    // A turn into the wall is not.
    let turn = Twist::new(1.0, 1.0);
    assert!(limited(corridor(1.0), turn, turn).0.linear < 1.0);
}

#[test]
fn return_near_the_arc_slows_the_robot_and_one_that_falls_behind_does_not() {
    // 5 cm to the side of the body.
    let (slow, action) = limited(corridor(0.6), FULL, Twist::STOP);
    assert!((slow.linear - 0.5).abs() < 1e-9, "{slow:?}");
    assert!(matches!(action, ProtectiveAction::Slow { .. }), "{action}");
    let behind = |angle: f64| if angle.abs() > 3.0 { 0.45 } else { 9.0 };
    assert!(limited(behind, FULL, Twist::STOP).1.passes());
}

#[test]
fn return_within_the_body_permits_only_slow_motion_away_from_it() {
    let ahead = |angle: f64| if angle.abs() < 0.2 { 0.35 } else { 9.0 };
    let (command, action) = limited(ahead, FULL, Twist::STOP);
    assert_eq!(command, Twist::STOP, "{action}");
    let (command, action) = limited(ahead, Twist::new(-0.5, 0.0), Twist::STOP);
    assert!((-0.11..-0.05).contains(&command.linear), "{command:?}");
    assert!(matches!(action, ProtectiveAction::Escape { .. }), "{action}");
}

/// The noise of the ranges must not let a robot creep at a wall that it may not come nearer to.
#[test]
fn robot_that_was_too_near_approaches_nothing_for_a_second() {
    let mut layer = layer(CollisionMonitorSettings::default());
    // The front of the body is at 0.4 m.
    let mut permitted = |time_s: f64, gap_m: f64, speed: f64| {
        layer.update_motion(&Twist::STOP, time_s);
        layer.update_scan(&scan(time_s, wall_ahead(0.4 + gap_m)), time_s);
        layer.limit(&Twist::new(speed, 0.0), &Twist::STOP, time_s).0.linear
    };
    assert!(permitted(0.0, 0.035, 0.05) > 0.0);
    assert_eq!(permitted(0.1, 0.02, 0.05), 0.0);
    assert_eq!(permitted(0.2, 0.035, 0.05), 0.0, "the wall did not move");
    assert_eq!(permitted(1.0, 0.035, 0.05), 0.0);
    assert!(permitted(1.0, 0.035, -0.05) < 0.0, "away from the wall");
    assert!(permitted(1.2, 0.035, 0.05) > 0.0);
    // The clock runs backwards during a hold: it lasts for a second of the new clock.
    assert_eq!(permitted(1.3, 0.02, 0.05), 0.0);
    assert_eq!(permitted(0.4, 0.035, 0.05), 0.0);
    assert_eq!(permitted(1.2, 0.035, 0.05), 0.0);
    assert!(permitted(1.6, 0.035, 0.05) > 0.0);
}

/// The command ahead that is permitted at a time, with a wall at a gap, metres. Its normal has a direction, radians.
fn beside_a_wall(
    layer: &mut ProtectiveLayer,
    time_s: f64,
    normal: f64,
    gap_m: f64,
    speed: f64,
) -> f64 {
    let away_m = 0.15 * libm::cos(normal) + 0.25 + gap_m;
    let range = |angle: f64| {
        let range = away_m / libm::cos(angle - normal);
        if (0.0..=9.0).contains(&range) { range } else { 9.0 }
    };
    let twist = Twist::new(speed, 0.0);
    layer.update_motion(&twist, time_s);
    layer.update_scan(&scan(time_s, range), time_s);
    layer.limit(&twist, &twist, time_s).0.linear
}

/// At 1.2 rad a motion brings the body nearer to the wall by a third of its length.
#[test]
fn body_that_slides_at_a_wall_keeps_its_hard_margin() {
    let permitted = |gap_m: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        beside_a_wall(&mut layer, 0.0, 1.2, gap_m, 0.05)
    };
    assert!(permitted(0.035) > 0.0);
    assert_eq!(permitted(0.025), 0.0, "it would end within the hard margin");
    // A thin post within the hard margin, ahead on the left and behind on the left.
    let past_a_post = |direction: f64| {
        let (sin, cos) = libm::sincos(direction);
        let post = disc(Point::new(0.15 + 0.285 * cos, 0.285 * sin), 0.02);
        limited(post, Twist::new(0.05, 0.0), Twist::new(0.05, 0.0)).0.linear
    };
    assert_eq!(past_a_post(1.2), 0.0);
    assert!(past_a_post(1.8) > 0.0);
}

#[test]
fn robot_that_was_too_near_may_slide_past_a_wall_and_not_drive_at_it_askew() {
    let permitted = |normal: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        beside_a_wall(&mut layer, 0.0, normal, 0.02, 0.0);
        beside_a_wall(&mut layer, 0.1, normal, 0.039, 0.02)
    };
    assert_eq!(permitted(0.7), 0.0);
    assert!(permitted(1.2) > 0.0);
}

#[test]
fn two_returns_that_are_too_near_hold_the_robot_and_dust_does_not() {
    let permitted = |half_rad: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        let mut at = |time_s: f64, gap_m: f64, half_rad: f64| {
            let post =
                |angle: f64| if (-0.009..half_rad).contains(&angle) { 0.4 + gap_m } else { 9.0 };
            layer.update_motion(&Twist::STOP, time_s);
            layer.update_scan(&scan(time_s, post), time_s);
            layer.limit(&Twist::new(0.05, 0.0), &Twist::STOP, time_s).0.linear
        };
        at(0.0, 0.02, half_rad);
        at(0.1, 0.035, 0.009)
    };
    assert_eq!(permitted(0.009), 0.0);
    assert!(permitted(0.0) > 0.0);
}

#[test]
fn single_return_is_ignored_as_dust() {
    let dust = |angle: f64| if (0.0..0.0174).contains(&angle) { 0.6 } else { 9.0 };
    assert!(limited(dust, FULL, FULL).1.passes());
    let two = |angle: f64| if (0.0..0.0349).contains(&angle) { 0.6 } else { 9.0 };
    assert_eq!(limited(two, FULL, FULL).0, Twist::STOP);
    // Two grains, ahead on the left and on the right.
    let apart = |angle: f64| if (0.3..0.3175).contains(&angle.abs()) { 0.6 } else { 9.0 };
    assert!(limited(apart, FULL, FULL).1.passes());
}

#[test]
fn direction_without_measurements_permits_creeping_only() {
    let blind_ahead = |angle: f64| if angle.abs() < 0.5 { f64::NAN } else { 9.0 };
    let (command, action) = limited(blind_ahead, FULL, FULL);
    assert!((0.1..0.1015).contains(&command.linear), "{command:?}");
    assert!(matches!(action, ProtectiveAction::BlindSector { .. }), "{action}");
    assert!(limited(blind_ahead, Twist::new(-1.0, 0.0), Twist::STOP).1.passes());
    // A lidar of 240 degrees: the rear of a robot that turns slightly enters what the lidar does not see more slowly than that.
    let blind_behind = |angle: f64| if angle.abs() > 2.1 { f64::NAN } else { 9.0 };
    for angular in [-0.15, 0.0, 0.15] {
        let curve = Twist::new(0.4, angular);
        assert_eq!(limited(blind_behind, curve, curve).0, curve);
    }
    let back = Twist::new(-1.0, 0.0);
    let (command, action) = limited(blind_behind, back, back);
    assert!((0.1..0.1015).contains(&-command.linear), "{command:?}");
    assert!(matches!(action, ProtectiveAction::BlindSector { .. }), "{action}");
    // A tenth of the beams without a measurement is usual.
    let some = |angle: f64| if (angle * 57.3).floor() % 10.0 == 0.0 { f64::NAN } else { 9.0 };
    assert!(limited(some, FULL, FULL).1.passes());
}

/// The command for a robot that stands, 0.5 s after a scan with a disc at one place, by a scan with it at another.
fn after_move(before: Point, now: Point, target: Twist) -> (Twist, ProtectiveAction) {
    let mut layer = layer(CollisionMonitorSettings::default());
    for (stamp_s, center) in [(0.0, before), (0.5, now)] {
        layer.update_motion(&Twist::STOP, stamp_s);
        layer.update_scan(&scan(stamp_s, disc(center, 0.3)), stamp_s);
    }
    layer.limit(&target, &target, 0.5)
}

#[test]
fn walking_person_ahead_slows_the_robot_more_than_a_standing_one() {
    let place = Point::new(2.6, 0.0);
    let (command, action) = after_move(place, place, FULL);
    assert_eq!(command, FULL, "{action}");
    let (command, action) = after_move(Point::new(2.6, 1.0), place, FULL);
    assert!(command.linear < 0.9, "{command:?} {action}");
    // A forward motion cannot reach a person behind the robot.
    let (command, action) = after_move(Point::new(-1.5, 1.0), Point::new(-1.5, 0.0), FULL);
    assert_eq!(command, FULL, "{action}");
}

#[test]
fn person_who_walks_parallel_to_the_arc_does_not_slow_the_robot() {
    let (before, now) = (Point::new(0.6, 2.6), Point::new(0.6, 1.6));
    let (command, action) = after_move(before, now, FULL);
    assert_eq!(command, FULL, "{action}");
    // The same person ahead does.
    let (command, _) = after_move(Point::new(2.6, 0.6), Point::new(1.6, 0.6), FULL);
    assert!(command.linear < 0.6, "{command:?}");
}

#[test]
fn person_who_walks_away_ahead_slows_the_robot() {
    let (command, action) = after_move(Point::new(2.2, 0.0), Point::new(2.6, 0.0), FULL);
    assert!(command.linear < 0.9, "{command:?} {action}");
}

#[test]
fn walking_person_is_detected_by_few_beams_at_whole_degrees_with_gaps() {
    for beams in [120, 180, 360, 400] {
        let mut layer = layer(CollisionMonitorSettings::default());
        for (stamp_s, across_m) in [(0.0, 1.0), (0.5, 0.0)] {
            let range = disc(Point::new(2.6, across_m), 0.3);
            let beam = |index: i32| {
                let angle = f64::from(index) / f64::from(beams) * TAU - PI;
                // Every eleventh beam returns nothing.
                let range = if index % 11 == 0 { f64::NAN } else { range(angle) };
                Beam { angle, range, time_s: stamp_s }
            };
            let sweep = TimedScan {
                beams: (0..beams).map(beam).collect(),
                range_max: 10.0,
                ..TimedScan::default()
            };
            layer.update_motion(&Twist::STOP, stamp_s);
            layer.update_scan(&sweep, stamp_s);
        }
        let (command, action) = layer.limit(&FULL, &FULL, 0.5);
        assert!(command.linear < 0.9, "{beams} beams: {command:?} {action}");
    }
}

#[test]
fn command_that_is_not_finite_stops() {
    for target in [Twist::new(f64::NAN, 0.0), Twist::new(0.0, f64::INFINITY)] {
        let (command, action) = limited(wall_ahead(8.0), target, Twist::STOP);
        assert_eq!((command, action), (Twist::STOP, ProtectiveAction::NotFinite));
    }
}

#[test]
fn invalid_scans_are_ignored_and_the_last_one_ages() {
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_scan(&scan(0.0, wall_ahead(8.0)), 0.0);
    let nowhere = |_: f64| f64::NAN;
    let mut broken = scan(0.25, nowhere);
    broken.beams[7].angle = f64::INFINITY;
    layer.update_scan(&broken, 0.25);
    layer.update_scan(&TimedScan::default(), 0.25);
    layer.update_scan(&scan(0.25, wall_ahead(8.0)), f64::NAN);
    layer.update_motion(&Twist::new(f64::NAN, 1.0), 0.25);
    assert!(layer.limit(&FULL, &FULL, 0.25).1.passes());
    assert!(matches!(layer.limit(&FULL, &FULL, 0.35).1, ProtectiveAction::StaleScan { .. }));
}
