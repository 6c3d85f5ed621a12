//! Each limit of a motion, just below it and just above it.

use inbye::base::{CollisionMonitorSettings, ProtectiveAction, ProtectiveLayer};
use inbye::geometry::Twist;
use inbye::robot::Footprint;

use super::checks::{body, layer, limits, scan, wall_ahead};

const FULL: Twist = Twist::new(1.0, 0.0);

/// A layer that got a scan and the measured motion at the time zero.
pub fn seeing(range: impl Fn(f64) -> f64, measured: Twist) -> ProtectiveLayer {
    let mut layer = layer(CollisionMonitorSettings::default());
    layer.update_motion(&measured, 0.0);
    layer.update_scan(&scan(0.0, range), 0.0);
    layer
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
    let braked = layer.ramp(&Twist::STOP, &sent, 0.1.into());
    assert_eq!(braked, limits().brake(&sent, 0.1));
    assert!((braked.linear - braked.angular).abs() < 1e-9 && braked.linear < 1.0, "{braked:?}");
}

/// One return next to the swept area may be dust; two reduce the speed.
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

/// The first and the last command on the line are to creep; between them are 0.14 s of full speed.
#[test]
fn short_acceleration_on_the_line_counts() {
    let creep = Twist::new(0.1, 0.0);
    let least_m = |pulse: Twist| {
        let passes = |at_m: f64| {
            let mut layer = layer(CollisionMonitorSettings::default().slow_margin_m(0.0));
            layer.update_scan(&scan(0.38, wall_ahead(at_m)), 0.38);
            let mut action = ProtectiveAction::Pass;
            for cycle in 0..20 {
                let sent = if (11..19).contains(&cycle) { pulse } else { creep };
                action = layer.limit(&creep, &sent, 0.02 * f64::from(cycle)).1;
            }
            action.passes()
        };
        let distances = (85..140).map(|step| 0.005 * f64::from(step));
        distances.into_iter().find(|at_m| passes(*at_m)).expect("a free distance")
    };
    let (without_m, with_m) = (least_m(creep), least_m(FULL));
    assert!(with_m > without_m + 0.015, "{with_m} {without_m}");
}

/// A turn on the spot brings no part of a round body nearer to a wall that is a centimetre away.
#[test]
fn round_robot_turns_on_the_spot_next_to_a_wall() {
    let body = Footprint::round(0.3).expect("a radius");
    let settings = CollisionMonitorSettings::default();
    let mut layer = ProtectiveLayer::new(settings, &body, limits(), 0.1).expect("valid settings");
    layer.arm();
    layer.set_stopping(0.2, 1.0);
    let turn = Twist::new(0.0, 1.0);
    layer.update_motion(&turn, 0.0);
    layer.update_scan(&scan(0.0, wall_ahead(0.31)), 0.0);
    assert_eq!(layer.limit(&turn, &turn, 0.0), (turn, ProtectiveAction::Pass));
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

#[test]
fn approach_reduces_a_command_more_the_nearer_a_wall_is() {
    let command = |at_m: f64| seeing(wall_ahead(at_m), FULL).limit(&FULL, &FULL, 0.0);
    let reduced: Vec<f64> =
        (110..130).map(|step| command(0.01 * f64::from(step)).0.linear).collect();
    assert!(reduced.iter().any(|speed| (0.8..0.9).contains(speed)), "{reduced:?}");
    assert!(reduced.is_sorted(), "{reduced:?}");
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
