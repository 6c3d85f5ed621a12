//! Attribution of a contact to the robot or to the obstacle that it touched.

use inbye::experiment::{Contact, ContactCause, TouchedBody, contact};
use inbye::geometry::{Point, Pose, Twist};
use inbye::map::{Cell, GridFrame, ObstacleGrid};
use inbye::navigator::Mode;
use inbye::robot::{Disc, Footprint};
use inbye::runtime::TraceRow;
use inbye::sim::World;

/// Closing speed above which the robot's own motion closed the gap, m/s.
const CLOSING_M_S: f64 = 0.02;
const RADII_M: [f64; 1] = [0.3];

/// 10 by 10 m, solid from x = 8 m on.
fn world() -> World {
    let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a sound size");
    let mut ground = ObstacleGrid::new(frame, vec![false; frame.len()]);
    for column in 80..100 {
        (0..100).for_each(|row| ground.set(Cell::new(column, row), true));
    }
    World::new(ground)
}

fn footprint() -> Footprint {
    Footprint::round(0.4).expect("a sound radius")
}

fn row(time_s: f64, pose: Pose, twist: Twist, center: Option<[f64; 2]>) -> TraceRow {
    TraceRow {
        time_s,
        pose,
        belief: pose,
        twist,
        command: twist,
        local_target: pose.position(),
        gap_m: 0.0,
        admissible: 0,
        samples: 0,
        mode: Mode::Driving,
        path: 0,
        moving: vec![center.map(|[x, y]| Point::new(x, y))],
    }
}

/// A robot that drives along x and a body that comes along x from the right or left: they touch at the second row.
fn touch(robot_m_s: f64, body_m_s: f64) -> Contact {
    let twist = Twist::new(robot_m_s, 0.0);
    let before = row(
        0.0,
        Pose::new(4.0 - 0.1 * robot_m_s, 5.0, 0.0),
        twist,
        Some([4.69 - 0.1 * body_m_s, 5.0]),
    );
    let at = row(0.1, Pose::new(4.0, 5.0, 0.0), twist, Some([4.69, 5.0]));
    contact(&at, Some(&before), &RADII_M, &footprint(), &world()).expect("they touch")
}

#[test]
fn contact_is_caused_by_the_body_that_closes_the_gap() {
    for (robot_m_s, body_m_s, expected) in [
        (0.5, 0.0, ContactCause::Robot),
        // Both move towards each other and close the gap.
        (0.5, -0.8, ContactCause::Robot),
        // The robot catches up with the body.
        (0.5, 0.3, ContactCause::Robot),
        // The robot stands, or nearly.
        (0.0, -0.8, ContactCause::Other),
        (0.01, -0.8, ContactCause::Other),
        // The robot backs away too slowly.
        (-0.3, -0.8, ContactCause::Other),
    ] {
        let contact = touch(robot_m_s, body_m_s);
        assert_eq!(contact.cause, expected, "{robot_m_s}, {body_m_s}");
        assert_eq!(contact.body, TouchedBody::Moving(0));
        let closing_m_s = contact.closing_m_s.expect("it moves");
        // A wrong sign would give the opposite result.
        assert!((closing_m_s - robot_m_s).abs() < 1e-12, "{closing_m_s}");
        let found = contact.body_m_s.expect("it was there before");
        assert!((found - body_m_s.abs()).abs() < 1e-9, "{found}");
    }
}

/// A deliberate fault: with the sign reversed, the same contacts must be attributed differently.
#[test]
fn contact_attribution_depends_on_the_sign_of_the_closing_speed() {
    let wrong = |robot_m_s: f64, body_m_s| {
        let closing_m_s = -touch(robot_m_s, body_m_s).closing_m_s.expect("it moves");
        if closing_m_s > CLOSING_M_S { ContactCause::Robot } else { ContactCause::Other }
    };
    assert_ne!(wrong(0.5, -0.8), touch(0.5, -0.8).cause);
    assert_ne!(wrong(-0.3, -0.8), touch(-0.3, -0.8).cause);
}

#[test]
fn contact_counts_the_speed_before_braking_within_the_tick() {
    let before = row(0.0, Pose::new(3.97, 5.0, 0.0), Twist::new(0.4, 0.0), Some([4.74, 5.0]));
    let at = row(0.1, Pose::new(4.0, 5.0, 0.0), Twist::default(), Some([4.69, 5.0]));
    let found = contact(&at, Some(&before), &RADII_M, &footprint(), &world());
    assert_eq!(found.map(|found| found.cause), Some(ContactCause::Robot));
}

#[test]
fn contact_of_a_swinging_tail_is_caused_by_the_robot() {
    let discs = [0.2, -0.2].map(|x| Disc { x, y: 0.0, radius: 0.3 });
    let footprint = Footprint::new(discs.to_vec()).expect("two discs with a radius");
    // Turning left in place swings the tail to the right, where a body approaches.
    for (rate, expected) in [(0.8, ContactCause::Robot), (-0.8, ContactCause::Other)] {
        let twist = Twist::new(0.0, rate);
        let pose = Pose::new(4.0, 5.0, 0.0);
        let before = row(0.0, pose, twist, Some([3.8, 4.37]));
        let at = row(0.1, pose, twist, Some([3.8, 4.41]));
        let found = contact(&at, Some(&before), &RADII_M, &footprint, &world());
        assert_eq!(found.map(|found| found.cause), Some(expected), "{rate}");
    }
}

#[test]
fn contact_with_a_static_body_is_caused_by_the_robot() {
    let twist = Twist::new(-0.5, 0.0);
    let at = row(0.0, Pose::new(7.61, 5.0, 0.0), twist, None);
    let found = contact(&at, None, &RADII_M, &footprint(), &world()).expect("they touch");
    assert_eq!((found.cause, found.body), (ContactCause::Robot, TouchedBody::Static));
    let clear = row(0.0, Pose::new(7.5, 5.0, 0.0), twist, Some([6.0, 5.0]));
    assert_eq!(contact(&clear, None, &RADII_M, &footprint(), &world()), None);
}
