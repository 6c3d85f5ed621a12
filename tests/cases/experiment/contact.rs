//! Attribution of a contact to the robot or to the obstacle that it touched.

use inbye::geometry::{Pose, Twist};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::{Disc, Footprint};
use inbye::runtime::{Contact, TouchedBody};
use inbye::sim::World;

/// 10 by 10 m, solid from x = 8 m on.
fn world(moving: &[MovingDisc]) -> World {
    let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a sound size");
    let mut ground = ObstacleGrid::filled(frame, false);
    for column in 80..100 {
        (0..100).for_each(|row| ground.set(Cell::new(column, row), true));
    }
    let mut world = World::new(ground);
    world.moving = moving.to_vec();
    world
}

fn footprint() -> Footprint {
    Footprint::round(0.4).expect("a sound radius")
}

fn body(x: f64, y: f64, vx: f64) -> MovingDisc {
    MovingDisc { x, y, radius: 0.3, vx, vy: 0.0 }
}

/// A robot that drives along x touches a body that comes along x from the right or left.
fn touch(robot_m_s: f64, body_m_s: f64) -> Contact {
    let world = world(&[body(1.0, 1.0, 0.0), body(4.69, 5.0, body_m_s)]);
    let twist = Twist::new(robot_m_s, 0.0);
    world.contact(&footprint(), 3.5, &Pose::new(4.0, 5.0, 0.0), &[twist])
}

fn closing_m_s(contact: &Contact) -> f64 {
    match contact.body {
        TouchedBody::Moving { index: 1, closing_m_s, .. } => closing_m_s,
        other => panic!("{other:?}"),
    }
}

#[test]
fn contact_is_caused_by_the_body_that_closes_the_gap() {
    for (robot_m_s, body_m_s, by_robot) in [
        (0.5, 0.0, true),
        // Both move towards each other and close the gap.
        (0.5, -0.8, true),
        // The robot catches up with the body.
        (0.5, 0.3, true),
        // The robot stands, or nearly.
        (0.0, -0.8, false),
        (0.01, -0.8, false),
        // The robot backs away too slowly.
        (-0.3, -0.8, false),
        // A standing robot next to a standing body has driven there.
        (0.0, 0.0, true),
    ] {
        let contact = touch(robot_m_s, body_m_s);
        assert_eq!(contact.is_by_robot(), by_robot, "{robot_m_s}, {body_m_s}");
        assert_eq!(contact.time_s, 3.5);
        // A wrong sign would give the opposite result.
        let closing_m_s = closing_m_s(&contact);
        assert!((closing_m_s - robot_m_s).abs() < 1e-12, "{closing_m_s}");
        let TouchedBody::Moving { speed_m_s, .. } = contact.body else { panic!("{contact:?}") };
        assert!((speed_m_s - body_m_s.abs()).abs() < 1e-9, "{speed_m_s}");
    }
}

/// A deliberate fault: with the sign reversed, the same contacts must be attributed differently.
#[test]
fn contact_attribution_depends_on_the_sign_of_the_closing_speed() {
    for robot_m_s in [0.5, -0.3] {
        let mut contact = touch(robot_m_s, -0.8);
        let by_robot = contact.is_by_robot();
        if let TouchedBody::Moving { closing_m_s, .. } = &mut contact.body {
            *closing_m_s = -*closing_m_s;
        }
        assert_ne!(contact.is_by_robot(), by_robot, "{robot_m_s}");
    }
}

#[test]
fn contact_counts_the_highest_closing_speed_of_the_period() {
    let world = world(&[body(4.69, 5.0, -0.5)]);
    let pose = Pose::new(4.0, 5.0, 0.0);
    let braking = [Twist::new(0.4, 0.0), Twist::STOP];
    let by_robot = |twists: &[Twist]| world.contact(&footprint(), 0.0, &pose, twists).is_by_robot();
    assert!(by_robot(&braking));
    assert!(!by_robot(&braking[1..]));
}

#[test]
fn contact_of_a_swinging_tail_is_caused_by_the_robot() {
    let discs = [0.2, -0.2].map(|x| Disc { x, y: 0.0, radius: 0.3 });
    let footprint = Footprint::new(discs.to_vec()).expect("two discs with a radius");
    let approaching = MovingDisc { vx: 0.0, vy: 0.4, ..body(3.8, 4.41, 0.0) };
    let world = world(&[approaching]);
    // Turning left in place swings the tail to the right, where a body approaches.
    for (rate, by_robot) in [(0.8, true), (-0.8, false)] {
        let pose = Pose::new(4.0, 5.0, 0.0);
        let found = world.contact(&footprint, 0.0, &pose, &[Twist::new(0.0, rate)]);
        assert_eq!(found.is_by_robot(), by_robot, "{rate}");
    }
}

#[test]
fn contact_with_a_static_body_is_caused_by_the_robot() {
    let world = world(&[body(6.0, 5.0, 0.0)]);
    let pose = Pose::new(7.61, 5.0, 0.0);
    let found = world.contact(&footprint(), 0.0, &pose, &[Twist::new(-0.5, 0.0)]);
    assert!(found.is_by_robot());
    assert_eq!(found.body, TouchedBody::Static);
}
