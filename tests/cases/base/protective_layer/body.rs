//! A body with corners: the layer judges its polygon, and not the discs that cover it.

use inbye::base::{CollisionMonitorSettings, ProtectiveAction, ProtectiveLayer};
use inbye::geometry::{Point, Twist};
use inbye::robot::{Footprint, Polygon};

use super::checks::{corridor, limits, scan, wall_ahead};

const FULL: Twist = Twist::new(1.0, 0.0);

/// A layer for a body of 0.7 by 0.5 m. Its discs reach 0.055 m farther to the sides, and 0.13 m farther ahead.
fn layer(range: impl Fn(f64) -> f64, measured: Twist) -> ProtectiveLayer {
    let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
    let settings = CollisionMonitorSettings::default().slow_margin_m(0.0);
    let mut layer = ProtectiveLayer::new(settings, &Footprint::covering(body), limits(), 0.1)
        .expect("valid settings");
    layer.arm();
    layer.set_stopping(0.2, 1.0);
    layer.update_motion(&measured, 0.0);
    layer.update_scan(&scan(0.0, range), 0.0);
    layer
}

fn limited(range: impl Fn(f64) -> f64, target: Twist) -> (Twist, ProtectiveAction) {
    layer(range, target).limit(&target, &target, 0.0)
}

/// Range to a pillar of a few beams in a direction, radians.
fn pillar(direction: f64, at_m: f64) -> impl Fn(f64) -> f64 {
    move |angle| if (angle - direction).abs() < 0.03 { at_m } else { 9.0 }
}

#[test]
fn gap_of_a_centimetre_more_than_the_margin_on_both_sides_is_driven_at_full_speed() {
    // The sides keep 0.04 m, where 0.03 m are required. The discs would be 0.015 m within both walls.
    assert_eq!(limited(corridor(0.58), FULL), (FULL, ProtectiveAction::Pass));
    // A turn there brings a corner into a wall.
    let (command, action) = limited(corridor(0.58), Twist::new(1.0, 0.5));
    assert!(command.linear < 0.9, "{command:?} {action}");
}

#[test]
fn body_stops_before_a_wall_by_its_front_and_not_by_its_discs() {
    let least_m = (80..200)
        .map(|step| 0.01 * f64::from(step))
        .find(|at_m| limited(wall_ahead(*at_m), FULL).1.passes())
        .expect("a free distance");
    // 0.35 m of body, 0.03 m of margin, and 0.8 m until it stands.
    assert!((least_m - 1.18).abs() < 0.04, "{least_m}");
}

#[test]
fn corner_that_swings_at_a_pillar_in_a_turn_stops_it() {
    // The corners are 0.43 m from the middle, at 0.62 rad: a turn to the left sweeps the pillar, one to the right does not.
    let action = |rate: f64| limited(pillar(0.95, 0.41), Twist::new(0.0, rate)).1;
    assert!(!action(1.0).passes());
    assert_eq!(action(-1.0), ProtectiveAction::Pass);
    // A pillar outside of the corners' circle and its margin does not matter.
    let far = limited(pillar(0.95, 0.48), Twist::new(0.0, 1.0)).1;
    assert_eq!(far, ProtectiveAction::Pass);
}

/// Between two checks the whole body moves past a post: none of the poses that are compared touches it.
#[test]
fn fast_body_does_not_pass_a_post_between_two_steps() {
    let post = pillar(0.55, 0.45);
    let fast = Twist::new(0.0, -9.0);
    let (command, action) = layer(post, fast).limit(&Twist::new(0.0, -0.5), &Twist::STOP, 0.0);
    assert_eq!(command, Twist::STOP, "{action}");
}

#[test]
fn return_within_a_corner_permits_motion_away_from_it_only() {
    // At (0.33, 0.22): 0.02 m within the front.
    let (within, back) = (pillar(0.588, 0.397), Twist::new(-0.5, 0.0));
    let (command, action) = limited(&within, FULL);
    assert_eq!(command, Twist::STOP, "{action}");
    let (command, action) = layer(&within, Twist::STOP).limit(&back, &Twist::STOP, 0.0);
    assert!((-0.11..-0.05).contains(&command.linear), "{command:?} {action}");
    let ProtectiveAction::Escape { depth_m, .. } = action else { panic!("{action}") };
    assert!((0.015..0.03).contains(&depth_m), "{depth_m}");
}

#[test]
fn blind_direction_ahead_of_the_polygon_permits_creeping() {
    let blind_ahead = |angle: f64| if angle.abs() < 0.5 { f64::NAN } else { 9.0 };
    let (command, action) = limited(blind_ahead, FULL);
    assert!((command.linear - 0.1).abs() < 1e-9, "{command:?}");
    assert!(matches!(action, ProtectiveAction::BlindSector { .. }), "{action}");
    let back = Twist::new(-1.0, 0.0);
    assert!(limited(blind_ahead, back).1.passes());
    // A turn on the spot of a long body enters directions that it did not fill before.
    let beside = |angle: f64| if (angle - 1.0).abs() < 0.5 { f64::NAN } else { 9.0 };
    let (command, action) = limited(beside, Twist::new(0.0, 1.0));
    assert!(command.angular < 0.5, "{command:?} {action}");
}

#[test]
fn person_who_walks_parallel_to_the_body_does_not_slow_it_and_one_ahead_does() {
    let person = |center: Point| super::checks::disc(center, 0.3);
    let after_move = |before: Point, now: Point| {
        let mut layer = layer(person(before), Twist::STOP);
        layer.update_motion(&Twist::STOP, 0.5);
        layer.update_scan(&scan(0.5, person(now)), 0.5);
        layer.limit(&FULL, &FULL, 0.5)
    };
    let (command, action) = after_move(Point::new(0.0, 2.6), Point::new(0.0, 1.8));
    assert_eq!(command, FULL, "{action}");
    let (command, action) = after_move(Point::new(2.4, 1.0), Point::new(2.4, 0.0));
    assert!(command.linear < 0.9, "{command:?} {action}");
}
