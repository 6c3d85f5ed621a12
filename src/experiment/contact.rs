//! Attribution of a contact to the robot or to the obstacle that it touched.

use super::ContactCause;
use crate::geometry::{Point, Vector};
use crate::robot::Footprint;
use crate::runtime::TraceRow;
use crate::sim::World;

/// Closing speed above which the robot's own motion closed the gap, m/s.
const CLOSING_M_S: f64 = 0.02;
/// Highest speed of a body that counts as standing, m/s.
const STANDING_M_S: f64 = 0.02;

/// The body that was touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchedBody {
    /// A static obstacle.
    Static,
    /// A moving obstacle, by its index in the row's list.
    Moving(usize),
}

/// A contact and its cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The body that was touched; of several bodies, the one with the least gap.
    pub body: TouchedBody,
    /// Whose motion closed the gap: the robot's or only the other's.
    pub cause: ContactCause,
    /// Speed at which the robot's own motion closed the gap, m/s; below zero if it backed away. None for a static body,
    /// which never causes a contact.
    pub closing_m_s: Option<f64>,
    /// Speed of the body, m/s; none if it was not present in the row before.
    pub body_m_s: Option<f64>,
}

/// Returns the contact at a row of a trace, none if there is a gap. `before` is the previous row, `radii_m` are those of
/// the moving obstacles, `world` holds the static ones.
///
/// The robot causes the contact when the body stands, or when the true velocity of the touching part of its footprint
/// towards the body's centre is above 0.02 m/s, at the row or at the previous one: the gap closed between the two.
/// Otherwise only the body's motion can have closed it.
#[must_use]
pub fn contact(
    row: &TraceRow,
    before: Option<&TraceRow>,
    radii_m: &[f64],
    footprint: &Footprint,
    world: &World,
) -> Option<Contact> {
    let moving = row.moving.iter().zip(radii_m).enumerate();
    let nearest = moving
        .filter_map(|(index, (center, &radius_m))| {
            let center = (*center)?;
            let gap_m = footprint.gap_to_disc_m(&row.pose, &center, radius_m);
            Some((gap_m, index, center))
        })
        .min_by(|one, other| one.0.total_cmp(&other.0));
    let to_ground_m = world.gap_to_static_m(footprint, &row.pose);
    let (gap_m, touched) = match nearest {
        Some((gap_m, index, center)) if gap_m < to_ground_m => (gap_m, Some((index, center))),
        _ => (to_ground_m, None),
    };
    if gap_m > 0.0 {
        return None;
    }
    let Some((index, center)) = touched else {
        return Some(Contact {
            body: TouchedBody::Static,
            cause: ContactCause::Robot,
            closing_m_s: None,
            body_m_s: Some(0.0),
        });
    };
    let was = before.and_then(|before| Some((before, (*before.moving.get(index)?)?)));
    let body_m_s = was.map(|(before, place)| {
        (center - place).norm() / (row.time_s - before.time_s).max(f64::MIN_POSITIVE)
    });
    let earlier = was.map(|(before, place)| closing_m_s(before, footprint, &place));
    let closing_m_s = closing_m_s(row, footprint, &center);
    let closing_m_s = earlier.map_or(closing_m_s, |earlier| closing_m_s.max(earlier));
    let stands = body_m_s.is_some_and(|body_m_s| body_m_s <= STANDING_M_S);
    let cause =
        if stands || closing_m_s > CLOSING_M_S { ContactCause::Robot } else { ContactCause::Other };
    Some(Contact {
        body: TouchedBody::Moving(index),
        cause,
        closing_m_s: Some(closing_m_s),
        body_m_s,
    })
}

/// Speed at which the robot's true motion brings the nearest disc of its footprint closer to a point, m/s.
fn closing_m_s(row: &TraceRow, footprint: &Footprint, center: &Point) -> f64 {
    let gap = |(own, radius_m): &(Point, f64)| (center - own).norm() - radius_m;
    let nearest = footprint.at(&row.pose).min_by(|one, other| gap(one).total_cmp(&gap(other)));
    let Some((own, _)) = nearest else {
        return 0.0;
    };
    let (sin, cos) = libm::sincos(row.pose.yaw);
    let arm = own - row.pose.position();
    // The rotation of a disc about its own centre closes no gap; its centre moves with the robot.
    let velocity =
        Vector::new(cos, sin) * row.twist.linear + Vector::new(-arm.y, arm.x) * row.twist.angular;
    let towards = center - own;
    let distance_m = towards.norm();
    if distance_m > 0.0 { velocity.dot(&towards) / distance_m } else { velocity.norm() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::map::{Cell, GridFrame, ObstacleGrid};
    use crate::navigator::Mode;

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
        let discs = [0.2, -0.2].map(|x| crate::robot::Disc { x, y: 0.0, radius: 0.3 });
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
}
