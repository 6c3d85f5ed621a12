//! Each limit of the layer, just below it and just above it.

use core::f64::consts::{PI, TAU};

use inbye::base::{CollisionMonitorSettings, ProtectiveAction, ProtectiveLayer};
use inbye::geometry::{Point, Twist};
use inbye::map::{Beam, TimedScan};

use super::checks::{body, disc, layer, limits, scan, wall_ahead};

const FULL: Twist = Twist::new(1.0, 0.0);

/// A layer that got a scan and the measured motion at the time zero.
fn seeing(range: impl Fn(f64) -> f64, measured: Twist) -> ProtectiveLayer {
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_motion(&measured, 0.0);
    layer.update_scan(&scan(0.0, range), 0.0);
    layer
}

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

/// A base at 1 m/s whose last commands were to creep: it may keep its speed until the next command takes effect.
#[test]
fn measured_speed_is_taken_to_last_until_the_command_takes_effect() {
    let creep = Twist::new(0.1, 0.0);
    let passes = |at_m| {
        let mut layer = seeing(wall_ahead(at_m), FULL);
        layer.limit(&creep, &creep, 0.0).1.passes()
    };
    // 0.2 m of delay, 0.5 m of braking, and the body's 0.43 m with its margin.
    assert!(!passes(1.05) && passes(1.25));
}

/// A base that follows a command earlier than by the known delay.
#[test]
fn command_on_the_line_may_take_effect_at_once() {
    let action = |sent: Twist| {
        let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
        layer.update_scan(&scan(0.0, wall_ahead(0.46)), 0.0);
        layer.limit(&Twist::STOP, &Twist::STOP, 0.0);
        layer.limit(&FULL, &sent, 0.02).1
    };
    assert!(action(Twist::STOP).passes());
    assert!(!action(FULL).passes());
}

#[test]
fn weak_brakes_lengthen_the_stop_of_a_turn() {
    let turn = Twist::new(0.0, 1.0);
    let passes = |deceleration_m_s2| {
        // Returns to the left, ahead of the turning body's corner.
        let pillar = |angle: f64| if (angle - 1.25).abs() < 0.06 { 0.41 } else { 9.0 };
        let mut layer = seeing(pillar, turn);
        layer.set_stopping(0.2, deceleration_m_s2);
        layer.limit(&turn, &turn, 0.0).1
    };
    let (strong, weak) = (passes(10.0), passes(0.2));
    assert!(
        !matches!(strong, ProtectiveAction::Stop { .. } | ProtectiveAction::Approach { .. }),
        "{strong}"
    );
    assert!(
        matches!(weak, ProtectiveAction::Stop { .. } | ProtectiveAction::Approach { .. }),
        "{weak}"
    );
}

#[test]
fn stopping_values_out_of_range_are_ignored() {
    let mut layer = layer(CollisionMonitorSettings::default());
    for (delay_s, deceleration_m_s2) in [
        (f64::NAN, 1.0),
        (-0.1, 1.0),
        (f64::INFINITY, 1.0),
        (0.1, f64::NAN),
        (0.1, f64::INFINITY),
        (0.1, 0.04),
    ] {
        layer.set_stopping(delay_s, deceleration_m_s2);
        assert_eq!(layer.stopping(), (0.2, 1.0));
    }
    layer.set_stopping(0.0, 0.05);
    assert_eq!(layer.stopping(), (0.0, 0.05));
}

/// The robot drove on since the scan: its returns are nearer by that.
#[test]
fn returns_come_nearer_by_the_motion_since_their_scan() {
    let mut layer = seeing(wall_ahead(1.4), FULL);
    assert!(layer.limit(&FULL, &FULL, 0.0).1.passes());
    layer.update_motion(&FULL, 0.2);
    assert!(!layer.limit(&FULL, &FULL, 0.28).1.passes());
}

/// The least distance of a wall, metres, before which a command passes unchanged. The base moves as it was sent.
fn least_free_m(settings: &CollisionMonitorSettings, sent: Twist, target: Twist) -> f64 {
    let passes = |at_m: f64| {
        let mut layer = layer(settings.clone());
        layer.update_motion(&sent, 0.0);
        layer.update_scan(&scan(0.0, wall_ahead(at_m)), 0.0);
        layer.limit(&target, &sent, 0.0).1.passes()
    };
    let distances = (80..400).map(|step| 0.005 * f64::from(step));
    distances.into_iter().find(|at_m| passes(*at_m)).expect("a free distance")
}

/// Delay, period, braking and margin, each by its own share of the distance.
#[test]
fn stopping_distance_is_the_sum_of_its_parts() {
    let settings = || CollisionMonitorSettings::default().slow_margin_m(0.0);
    // At 1 m/s: 0.4 m of body, 0.03 m of margin, 0.2 m of delay, 0.1 m of period, and 0.5 m of braking.
    let usual_m = least_free_m(&settings(), FULL, FULL);
    assert!((usual_m - 1.23).abs() < 0.04, "{usual_m}");
    let wider_m = least_free_m(&settings().margin_m(0.2), FULL, FULL);
    assert!((wider_m - usual_m - 0.17).abs() < 0.011, "{wider_m} {usual_m}");
    let longer_m = least_free_m(&settings().time_before_collision(0.4), FULL, FULL);
    assert!((longer_m - usual_m - 0.3).abs() < 0.011, "{longer_m} {usual_m}");
    // A period of the sender is the least time before a collision.
    let shorter_m = least_free_m(&settings().time_before_collision(0.0), FULL, FULL);
    assert!((shorter_m - usual_m).abs() < 1e-9, "{shorter_m} {usual_m}");
    // A command to creep changes nothing before it takes effect: 0.2 m of delay, and braking from 1 m/s.
    let creep_m = least_free_m(&settings(), FULL, Twist::new(0.1, 0.0));
    assert!((creep_m - 1.13).abs() < 0.04, "{creep_m}");
}

#[test]
fn delay_counts_as_stated_until_it_is_identified() {
    let settings = CollisionMonitorSettings::default().stopping_delay_s(0.7);
    let layer = ProtectiveLayer::new(settings, &body(), limits(), 0.1).expect("valid settings");
    let (delay_s, _) = layer.stopping();
    assert!(delay_s >= 0.7, "{delay_s}");
}

#[test]
fn commands_from_before_a_backward_clock_do_not_count() {
    let mut layer = layer(CollisionMonitorSettings::default());
    for (now_s, sent) in [(100.0, FULL), (100.02, FULL), (10.0, Twist::STOP), (10.02, Twist::STOP)]
    {
        layer.update_motion(&sent, now_s);
        layer.update_scan(&scan(now_s, wall_ahead(0.6)), now_s);
        let passes = layer.limit(&Twist::new(0.3, 0.0), &sent, now_s).1.passes();
        assert_eq!(passes, sent == Twist::STOP, "{now_s} s");
    }
}

#[test]
fn sent_command_that_is_not_finite_hides_no_obstacle() {
    let mut layer = layer(CollisionMonitorSettings::default().time_before_collision(1.0));
    layer.update_scan(&scan(0.0, wall_ahead(0.7)), 0.0);
    let (command, action) = layer.limit(&FULL, &Twist::new(f64::NAN, 0.0), 0.0);
    assert!(command.linear < 0.5, "{command:?} {action}");
}

#[test]
fn full_stop_keeps_the_curvature() {
    let layer = layer(CollisionMonitorSettings::default());
    let sent = Twist::new(1.0, 1.0);
    let braked = layer.ramp(&Twist::STOP, &sent);
    assert_eq!(braked, limits().brake(&sent, 0.1));
    assert!((braked.linear - braked.angular).abs() < 1e-9 && braked.linear < 1.0, "{braked:?}");
}

/// One return beside the motion may be dust; two reduce the speed.
#[test]
fn single_return_in_the_slow_zone_is_dust() {
    let beside = |beams: f64| {
        move |angle: f64| {
            let index = (angle.to_degrees() - 90.0).floor();
            if (0.0..beams).contains(&index) { 0.3 } else { 9.0 }
        }
    };
    let action = |beams| seeing(beside(beams), Twist::STOP).limit(&FULL, &Twist::STOP, 0.0).1;
    assert!(action(1.0).passes());
    assert!(matches!(action(2.0), ProtectiveAction::Slow { .. }), "{}", action(2.0));
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
    TimedScan { beams: (0..beams).map(beam).collect(), range_max: 10.0 }
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

/// From 1 m/s at 0.05 m/s^2 a base stands after 20 s and 10 m. Steps of 5 ms cover the first 5 s.
#[test]
fn stop_that_is_longer_than_the_layer_looks_ahead_is_not_permitted() {
    let action = |step_s: f64, target: Twist| {
        let settings = CollisionMonitorSettings::default().simulation_time_step(step_s);
        let mut layer = layer(settings);
        layer.set_stopping(0.2, 0.05);
        layer.update_motion(&target, 0.0);
        layer.update_scan(&scan(0.0, wall_ahead(9.0)), 0.0);
        layer.limit(&target, &target, 0.0)
    };
    let (command, cut) = action(0.005, FULL);
    assert!(matches!(cut, ProtectiveAction::NoStandstill { .. }), "{cut}");
    assert_eq!(command, Twist::STOP, "its measured motion is as long");
    // The whole motion, and a slow one, which ends within that time.
    let (_, whole) = action(0.05, FULL);
    assert!(matches!(whole, ProtectiveAction::Stop { .. }), "{whole}");
    assert!(action(0.005, Twist::new(0.2, 0.0)).1.passes());
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

/// Commands count for a delay after the next one was sent. Nothing is measured.
#[test]
fn command_in_force_lasts_until_the_next_takes_effect() {
    let creep = Twist::new(0.1, 0.0);
    let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
    let mut passes = |now_s: f64, sent: Twist| {
        layer.update_scan(&scan(now_s, wall_ahead(0.9 + 0.001 * now_s)), now_s);
        layer.limit(&creep, &sent, now_s).1.passes()
    };
    (0..16).for_each(|cycle| _ = passes(0.02 * f64::from(cycle), FULL));
    assert!(!passes(0.32, Twist::STOP) && !passes(0.48, Twist::STOP));
    assert!(passes(0.54, Twist::STOP));
}

/// The last command before a stop is in force for the whole delay: 0.2 m at 1 m/s.
#[test]
fn stop_that_was_just_sent_takes_effect_after_the_delay() {
    let creep = Twist::new(0.1, 0.0);
    let passes = |at_m: f64| {
        let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
        let mut passes = |now_s: f64, sent: Twist| {
            layer.update_scan(&scan(now_s, wall_ahead(at_m + 0.001 * now_s)), now_s);
            layer.limit(&creep, &sent, now_s).1.passes()
        };
        (0..16).for_each(|cycle| _ = passes(0.02 * f64::from(cycle), FULL));
        passes(0.32, Twist::STOP)
    };
    // 0.43 m of body and margin, and 0.5 m of braking.
    assert!(!passes(1.02) && !passes(1.08) && passes(1.3));
}

/// A walker comes nearer by 1.6 m/s since the scan.
#[test]
fn older_scan_of_a_walker_reduces_the_command_more() {
    let command = |age_s: f64| {
        let mut layer = layer(CollisionMonitorSettings::default());
        for (stamp_s, at_m) in [(0.0, 3.6), (0.5, 3.0)] {
            layer.update_motion(&Twist::STOP, stamp_s);
            layer.update_scan(&scan(stamp_s, disc(Point::new(at_m, 0.0), 0.3)), stamp_s);
        }
        layer.update_motion(&Twist::STOP, 0.5 + age_s);
        layer.limit(&FULL, &FULL, 0.5 + age_s).0.linear
    };
    let (fresh, older, old) = (command(0.0), command(0.14), command(0.28));
    assert!(fresh > older + 0.05 && older > old + 0.05, "{fresh} {older} {old}");
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

#[test]
fn measured_motion_counts_from_a_small_difference_in_every_direction() {
    let free_m = |measured: Twist| {
        let sent = Twist::new(0.15, 0.0);
        let passes = |at_m: f64| {
            let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
            layer.update_motion(&measured, 0.0);
            layer.update_scan(&scan(0.0, wall_ahead(at_m)), 0.0);
            layer.limit(&sent, &sent, 0.0).1.passes()
        };
        (80..200).map(|step| 0.005 * f64::from(step)).find(|at_m| passes(*at_m)).expect("free")
    };
    let (usual_m, faster_m) = (free_m(Twist::new(0.15, 0.0)), free_m(Twist::new(0.3, 0.0)));
    assert!(faster_m > usual_m + 0.02, "{faster_m} {usual_m}");
    // Backwards, and a turn to either side.
    let behind = |angle: f64| if angle.abs() > 2.8 { 0.7 } else { 9.0 };
    let creep = Twist::new(-0.05, 0.0);
    let action = |measured| seeing(behind, measured).limit(&creep, &Twist::STOP, 0.0).1;
    assert!(action(Twist::STOP).passes() && !action(Twist::new(-1.0, 0.0)).passes());
    for side in [1.0, -1.0] {
        let pillar = |angle: f64| if (angle * side - 1.25).abs() < 0.06 { 0.38 } else { 9.0 };
        let forward = Twist::new(0.05, 0.0);
        let action = |rate: f64| {
            seeing(pillar, Twist::new(0.0, rate * side)).limit(&forward, &Twist::STOP, 0.0).1
        };
        assert!(!action(3.0).passes(), "{side}");
    }
}

#[test]
fn time_that_is_not_finite_stops() {
    let (command, action) = seeing(wall_ahead(8.0), FULL).limit(&FULL, &FULL, f64::NAN);
    assert_eq!((command, action), (Twist::STOP, ProtectiveAction::NotFinite));
}

#[test]
fn single_return_within_the_body_is_dust() {
    let dust = |angle: f64| if (0.0..0.0174).contains(&angle) { 0.35 } else { 9.0 };
    let back = Twist::new(-0.5, 0.0);
    assert!(seeing(dust, Twist::STOP).limit(&back, &Twist::STOP, 0.0).1.passes());
}

/// The body's corners, 0.4 m from its middle, move faster in a turn.
#[test]
fn limit_of_a_blind_sector_counts_for_every_point_of_the_body() {
    let blind_ahead = |angle: f64| if angle.abs() < 0.5 { f64::NAN } else { 9.0 };
    for turn in [0.5, -0.5] {
        let target = Twist::new(1.0, turn);
        let (command, action) = seeing(blind_ahead, FULL).limit(&target, &FULL, 0.0);
        assert!((command.linear - 0.1 / 1.2).abs() < 1e-9, "{command:?} {action}");
    }
    // Also for slow motion, and not for one narrow gap.
    let slow = Twist::new(0.3, 0.0);
    let (command, _) = seeing(blind_ahead, slow).limit(&slow, &slow, 0.0);
    assert!((command.linear - 0.1).abs() < 1e-9, "{command:?}");
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
fn approach_reduces_a_command_more_the_nearer_a_wall_is() {
    let command = |at_m: f64| seeing(wall_ahead(at_m), FULL).limit(&FULL, &FULL, 0.0);
    let reduced: Vec<f64> =
        (110..130).map(|step| command(0.01 * f64::from(step)).0.linear).collect();
    assert!(reduced.iter().any(|speed| (0.8..0.9).contains(speed)), "{reduced:?}");
    assert!(reduced.is_sorted(), "{reduced:?}");
}

#[test]
fn ranges_of_zero_and_beyond_the_lidar_s_are_no_returns() {
    let zeros = |angle: f64| if angle.abs() < 0.1 { 0.0 } else { 9.0 };
    assert!(seeing(zeros, FULL).limit(&FULL, &FULL, 0.0).1.passes());
    let far = seeing(|_| 12.0, FULL).limit(&FULL, &FULL, 0.0).1;
    assert!(matches!(far, ProtectiveAction::BlindScan { .. }), "{far}");
}

/// A base that brakes at half of its stated deceleration, 0.1 s late.
#[test]
fn layer_identifies_weak_brakes_by_itself() {
    let settings = CollisionMonitorSettings::default();
    let mut layer =
        ProtectiveLayer::new(settings, &body(), limits(), 0.02).expect("valid settings");
    let stated = -limits().decel_lim_x;
    let mut line = std::collections::VecDeque::from([0.0; 5]);
    let (mut speed, mut sent): (f64, f64) = (0.0, 0.0);
    for cycle in 0..2000 {
        let now_s = 0.02 * f64::from(cycle);
        let wanted = if cycle % 200 < 100 { 0.8 } else { 0.0 };
        layer.update_motion(&Twist::new(speed, 0.0), now_s);
        layer.limit(&Twist::STOP, &Twist::new(sent, 0.0), now_s);
        sent += (wanted - sent).clamp(-stated * 0.02, stated * 0.02);
        line.push_back(sent);
        let followed = line.pop_front().unwrap_or_default();
        speed += (followed - speed).clamp(-0.5 * stated * 0.02, stated * 0.02);
    }
    let (delay_s, deceleration_m_s2) = layer.stopping();
    assert!(deceleration_m_s2 < 0.75 * stated, "{deceleration_m_s2} of {stated}, {delay_s} s");
}
