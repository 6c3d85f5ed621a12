//! What the layer takes from scans: their limits, the times of their beams, and what moves in them.

use core::f64::consts::{PI, TAU};

use inbye::base::{CollisionMonitorSettings, ProtectiveAction};
use inbye::geometry::{Point, Twist};
use inbye::map::{Beam, TimedScan};

use super::checks::{disc, layer, scan, wall_ahead};
use super::limits::seeing;

const FULL: Twist = Twist::new(1.0, 0.0);

/// 2 % of 360 beams are 7.2 beams.
#[test]
fn scan_is_blind_below_its_share_of_returns() {
    let with_returns = |count: f64| {
        move |angle: f64| {
            let index = (angle.to_degrees() + 180.0).floor();
            if index < count { 9.0 } else { f64::INFINITY }
        }
    };
    let action = |count| seeing(with_returns(count), FULL).limit(&FULL, &FULL, 0.0).1;
    assert_eq!(action(7.0), ProtectiveAction::BlindScan { share: 7.0 / 360.0 });
    assert!(!matches!(action(8.0), ProtectiveAction::BlindScan { .. }));
}

/// The action after a number of identical scans, 0.1 s apart, while a base moved.
fn after_identical(scans: u32, measured: Twist) -> ProtectiveAction {
    let mut layer = layer(CollisionMonitorSettings::default());
    for number in 0..scans {
        let now_s = f64::from(number) * 0.1;
        layer.update_motion(&measured, now_s);
        layer.update_scan(&scan(now_s, wall_ahead(9.0)), now_s);
        // The same scan again is no repetition.
        layer.update_scan(&scan(now_s, wall_ahead(9.0)), now_s);
    }
    layer.limit(&Twist::STOP, &Twist::STOP, f64::from(scans - 1) * 0.1).1
}

#[test]
fn third_identical_scan_of_a_base_that_moves_is_frozen() {
    let is_frozen = |scans, measured| {
        matches!(after_identical(scans, measured), ProtectiveAction::FrozenScan { .. })
    };
    // 0.05 m and 0.05 rad in the two periods between three scans.
    for (measured, expected) in [
        (Twist::new(0.26, 0.0), true),
        (Twist::new(-0.26, 0.0), true),
        (Twist::new(0.24, 0.0), false),
        (Twist::new(0.0, 0.26), true),
        (Twist::new(0.0, -0.26), true),
        (Twist::new(0.0, 0.24), false),
    ] {
        assert_eq!(is_frozen(3, measured), expected, "{measured:?}");
        assert!(!is_frozen(2, measured), "{measured:?}");
    }
}

/// A base that moves by twice the threshold between two scans: only the number of scans decides.
#[test]
fn same_scan_again_does_not_count_towards_a_frozen_lidar() {
    let fast = Twist::new(1.0, 0.0);
    assert!(!matches!(after_identical(2, fast), ProtectiveAction::FrozenScan { .. }));
    assert_eq!(after_identical(3, fast), ProtectiveAction::FrozenScan { scans: 3 });
}

/// In the open every scan is empty. Fewer than ten equal returns are no proof that the lidar is frozen.
#[test]
fn scans_with_hardly_any_return_do_not_count_towards_a_frozen_lidar() {
    let is_frozen = |returns: f64, empty: f64| {
        let mut layer = layer(CollisionMonitorSettings::default().min_return_share(0.0));
        for number in 0..50 {
            let now_s = f64::from(number) * 0.1;
            layer.update_motion(&FULL, now_s);
            let range = |angle: f64| if angle.to_degrees() + 180.0 < returns { 9.0 } else { empty };
            layer.update_scan(&scan(now_s, range), now_s);
        }
        let action = layer.limit(&FULL, &FULL, 4.9).1;
        matches!(action, ProtectiveAction::FrozenScan { .. })
    };
    for empty in [f64::INFINITY, f64::NAN] {
        assert!(!is_frozen(0.0, empty) && !is_frozen(9.0, empty), "{empty}");
        assert!(is_frozen(10.0, empty), "{empty}");
    }
}

/// The robot drove on since the scan: its returns are nearer by that.
#[test]
fn returns_come_nearer_by_the_motion_since_their_scan() {
    let mut layer = seeing(wall_ahead(1.4), FULL);
    assert!(layer.limit(&FULL, &FULL, 0.0).1.passes());
    layer.update_motion(&FULL, 0.2);
    assert!(!layer.limit(&FULL, &FULL, 0.28).1.passes());
}

/// A scan of 65,536 beams, nearer in the first of those within a hundredth of a radian of straight ahead.
fn dense(near: usize) -> TimedScan {
    let beams: i32 = 65_536;
    let first = (0..beams).find(|index| f64::from(*index) / f64::from(beams) * TAU - PI > 0.0);
    let first = first.expect("a beam ahead");
    let beam = |index: i32| {
        let angle = f64::from(index) / f64::from(beams) * TAU - PI;
        let is_near = (first..first + near as i32).contains(&index);
        Beam { angle, range: if is_near { 0.6 } else { 9.0 }, time_s: 0.0 }
    };
    TimedScan { beams: (0..beams).map(beam).collect(), range_max: 10.0, ..TimedScan::default() }
}

#[test]
fn few_near_beams_of_a_dense_scan_stop_the_robot() {
    let command = |near, min_points| {
        let mut layer = layer(CollisionMonitorSettings::default().min_points(min_points));
        layer.update_motion(&FULL, 0.0);
        layer.update_scan(&dense(near), 0.0);
        layer.limit(&FULL, &FULL, 0.0).0
    };
    // A single one of 65,536 beams, where one return counts; the other 44 beams of its direction end 8 m behind it.
    assert_eq!(command(1, 1), Twist::STOP);
    // Dust, and what is no dust, by the number of returns and not of directions.
    assert_eq!((command(1, 2), command(2, 2)), (FULL, Twist::STOP));
    assert_eq!((command(19, 20), command(20, 20)), (FULL, Twist::STOP));
}

#[test]
fn scan_with_too_many_beams_is_ignored() {
    for (count, is_used) in [(65_536, true), (65_537, false)] {
        let mut layer = layer(CollisionMonitorSettings::default());
        let mut all = scan(0.0, wall_ahead(8.0));
        let beam = all.beams[0];
        all.beams.resize(count, beam);
        layer.update_scan(&all, 0.0);
        let action = layer.limit(&Twist::STOP, &Twist::STOP, 0.0).1;
        assert_eq!(action != ProtectiveAction::NoScan, is_used, "{count} beams");
    }
}

#[test]
fn scans_of_another_length_are_not_identical() {
    let mut layer = layer(CollisionMonitorSettings::default());
    for number in 0..6 {
        let now_s = f64::from(number) * 0.1;
        let mut seen = scan(now_s, |_| 9.0);
        seen.beams.truncate(if number % 2 == 0 { 360 } else { 350 });
        layer.update_motion(&FULL, now_s);
        layer.update_scan(&seen, now_s);
        let action = layer.limit(&FULL, &FULL, now_s).1;
        assert!(!matches!(action, ProtectiveAction::FrozenScan { .. }), "{number}");
    }
}

/// Beams that were measured 0.2 s before the scan's stamp, 0.2 m farther back.
#[test]
fn beams_are_placed_at_the_pose_of_their_time() {
    let action = |beam_age_s: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        layer.update_motion(&FULL, -0.3);
        layer.update_motion(&FULL, 0.0);
        let mut seen = scan(0.0, wall_ahead(1.35));
        seen.beams.iter_mut().for_each(|beam| beam.time_s -= beam_age_s);
        layer.update_scan(&seen, 0.0);
        layer.limit(&FULL, &FULL, 0.0).1
    };
    assert!(action(0.0).passes());
    assert!(!action(0.2).passes());
}

/// The order of the beams does not matter: each has its own time, and the newest one is that of the scan.
#[test]
fn beams_may_come_in_any_order() {
    let action = |shuffle: &dyn Fn(&mut Vec<Beam>)| {
        let mut layer = layer(CollisionMonitorSettings::default());
        layer.update_motion(&FULL, -0.3);
        layer.update_motion(&FULL, 0.0);
        let mut seen = scan(0.0, wall_ahead(1.15));
        let count = seen.beams.len() as f64;
        for (index, beam) in seen.beams.iter_mut().enumerate() {
            beam.time_s = -0.1 * (1.0 - (index + 1) as f64 / count);
        }
        shuffle(&mut seen.beams);
        let end_s = seen.end_s().expect("beams");
        assert_eq!(end_s, 0.0);
        layer.update_scan(&seen, end_s);
        layer.limit(&FULL, &FULL, 0.25)
    };
    let in_order = action(&|_| ());
    assert!(matches!(
        in_order.1,
        ProtectiveAction::Stop { .. } | ProtectiveAction::Approach { .. }
    ));
    for shuffle in [
        &(|beams: &mut Vec<Beam>| beams.reverse()) as &dyn Fn(&mut Vec<Beam>),
        &|beams| beams.rotate_left(100),
        &|beams| beams.sort_by_key(|beam| (beam.angle * 1e4) as i64 % 17),
    ] {
        assert_eq!(action(shuffle), in_order);
    }
}

#[test]
fn scan_with_a_beam_from_another_time_is_ignored() {
    for (beam_s, is_used) in [(-0.99, true), (-1.01, false), (0.0, true), (0.01, false)] {
        let mut layer = layer(CollisionMonitorSettings::default());
        let mut seen = scan(0.0, wall_ahead(8.0));
        seen.beams[100].time_s = beam_s;
        layer.update_scan(&seen, 0.0);
        let action = layer.limit(&Twist::STOP, &Twist::STOP, 0.0).1;
        assert_eq!(action != ProtectiveAction::NoScan, is_used, "{beam_s} s");
    }
}

/// A person who approaches at 0.3 m/s comes 0.03 m nearer between two scans, which is as much as noise.
#[test]
fn slow_walker_is_noticed_over_several_scans() {
    let speed = |approach_m_s: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        let mut command = FULL;
        for number in 0..=10 {
            let now_s = f64::from(number) * 0.1;
            let at_m = 2.6 + approach_m_s * (1.0 - now_s);
            // Every scan differs from the one before.
            let range = disc(Point::new(at_m, 0.0), 0.3);
            layer.update_motion(&Twist::STOP, now_s);
            layer.update_scan(&scan(now_s, |angle| range(angle) + 0.001 * now_s), now_s);
            command = layer.limit(&FULL, &FULL, now_s).0;
        }
        command.linear
    };
    assert_eq!(speed(0.0), 1.0);
    assert!(speed(0.3) < 0.95, "{}", speed(0.3));
}

/// Where nothing was measured before, a return has not moved.
#[test]
fn return_in_a_direction_without_earlier_measurements_stands() {
    let mut layer = layer(CollisionMonitorSettings::default());
    let place = disc(Point::new(2.6, 0.0), 0.3);
    for (stamp_s, sees) in [(0.0, false), (0.5, true)] {
        let range = |angle: f64| if sees || angle.abs() > 0.4 { place(angle) } else { f64::NAN };
        layer.update_motion(&Twist::STOP, stamp_s);
        layer.update_scan(&scan(stamp_s, range), stamp_s);
    }
    assert_eq!(layer.limit(&FULL, &Twist::STOP, 0.5), (FULL, ProtectiveAction::Pass));
}

/// A walker comes nearer by 1.6 m/s since the scan: 1.35 m are enough for 0.4 s of motion, and not for 0.7 s.
#[test]
fn walker_in_an_older_scan_is_nearer() {
    let action = |age_s: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        for (stamp_s, at_m) in [(0.0, 2.25), (0.5, 1.65)] {
            layer.update_motion(&Twist::STOP, stamp_s);
            layer.update_scan(&scan(stamp_s, disc(Point::new(at_m, 0.0), 0.3)), stamp_s);
        }
        layer.update_motion(&Twist::STOP, 0.5 + age_s);
        layer.limit(&FULL, &Twist::STOP, 0.5 + age_s).1
    };
    assert!(action(0.0).passes() && action(0.1).passes(), "{} {}", action(0.0), action(0.1));
    let old = action(0.28);
    assert!(matches!(old, ProtectiveAction::Stop { .. } | ProtectiveAction::Approach { .. }));
}

#[test]
fn dense_scan_with_half_of_its_returns_is_not_blind() {
    let mut half = dense(0);
    half.beams
        .iter_mut()
        .filter(|beam| beam.angle < 0.0)
        .for_each(|beam| beam.range = f64::INFINITY);
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_scan(&half, 0.0);
    let action = layer.limit(&FULL, &Twist::STOP, 0.0).1;
    assert!(action.passes(), "{action}");
}

/// The robot turned left by 0.75 rad since its scan: what was ahead is to its right.
#[test]
fn blind_direction_turns_with_the_robot() {
    let blind_ahead = |angle: f64| if angle.abs() < 0.5 { f64::NAN } else { 9.0 };
    let action = |target: Twist| {
        let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
        layer.update_motion(&Twist::new(0.0, 3.0), 0.0);
        layer.update_scan(&scan(0.0, blind_ahead), 0.0);
        layer.update_motion(&Twist::STOP, 0.25);
        layer.limit(&target, &target, 0.25).1
    };
    let to_the_right = action(Twist::new(0.8, -1.0));
    let ProtectiveAction::BlindSector { direction_rad, .. } = to_the_right else {
        panic!("{to_the_right}")
    };
    assert!((direction_rad + 0.75).abs() < 0.2, "{direction_rad}");
}

/// The body's corners, 0.4 m from its middle, move faster in a turn.
#[test]
fn limit_of_a_blind_sector_counts_for_every_point_of_the_body() {
    let blind_ahead = |angle: f64| if angle.abs() < 0.5 { f64::NAN } else { 9.0 };
    for turn in [0.5, -0.5] {
        let target = Twist::new(1.0, turn);
        let (command, action) = seeing(blind_ahead, FULL).limit(&target, &FULL, 0.0);
        // The middles of the layer's sectors are 5 degrees beside the course.
        assert!((0.1..0.1015).contains(&(1.2 * command.linear)), "{command:?} {action}");
    }
    // Also for slow motion, and not for one narrow gap.
    let slow = Twist::new(0.3, 0.0);
    let (command, _) = seeing(blind_ahead, slow).limit(&slow, &slow, 0.0);
    assert!((0.1..0.1015).contains(&command.linear), "{command:?}");
    let narrow = |angle: f64| if angle.abs() < 0.08 { f64::NAN } else { 9.0 };
    assert!(seeing(narrow, FULL).limit(&FULL, &FULL, 0.0).1.passes());
    // Where a lidar has no beams.
    let mut layer = layer(CollisionMonitorSettings::default());
    let mut front = scan(0.0, |_| 9.0);
    front.beams.retain(|beam| beam.angle.abs() < 2.0);
    layer.update_scan(&front, 0.0);
    let back = Twist::new(-1.0, 0.0);
    assert!((layer.limit(&back, &back, 0.0).0.linear + 0.1).abs() < 1e-9);
}

#[test]
fn ranges_of_zero_and_beyond_the_lidar_s_are_no_returns() {
    let zeros = |angle: f64| if angle.abs() < 0.1 { 0.0 } else { 9.0 };
    assert!(seeing(zeros, FULL).limit(&FULL, &FULL, 0.0).1.passes());
    let far = seeing(|_| 12.0, FULL).limit(&FULL, &FULL, 0.0).1;
    assert!(matches!(far, ProtectiveAction::BlindScan { .. }), "{far}");
}
