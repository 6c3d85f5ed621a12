//! The part of a robot's outline that its motion moves outward.

use super::{Disc, Footprint, Polygon};
use crate::geometry::{Point, Pose, Twist, Vector, nearest_on_segment};
use crate::map::MovingDisc;

/// A part of the outline that moves outward by less than this closes in on nothing, m/s.
const LEADING: f64 = 0.02;

impl Footprint {
    /// Distance between a moving obstacle and the part of the body's outline that a motion moves outward, metres; infinite where
    /// no part does. The robot causes no contact with an obstacle that touches another part.
    pub(crate) fn leading_gap_m(&self, pose: &Pose, twist: &Twist, obstacle: &MovingDisc) -> f64 {
        let center = pose.inverse_transform(&obstacle.center());
        let to_disc_m = |disc: &Disc| disc_distance_m(disc, twist, &center);
        let distance_m = self.body().map_or_else(
            || self.discs().iter().map(to_disc_m).fold(f64::INFINITY, f64::min),
            |body| polygon_distance_m(body, twist, &center),
        );
        distance_m - obstacle.radius
    }
}

/// Velocity of a point of the robot, in its frame, m/s.
fn velocity_at(twist: &Twist, point: &Point) -> Vector {
    Vector::new(twist.linear - twist.angular * point.y, twist.angular * point.x)
}

/// Distance from a point to the leading parts of a polygon's edges, metres; zero inside.
fn polygon_distance_m(body: &Polygon, twist: &Twist, point: &Point) -> f64 {
    let outward_sign = if body.is_counter_clockwise() { 1.0 } else { -1.0 };
    let mut least_m = f64::INFINITY;
    for (from, to) in body.edges() {
        let along = to - from;
        let outward = Vector::new(along.y, -along.x) * (outward_sign / along.norm());
        let speeds = [from, to].map(|end| velocity_at(twist, end).dot(&outward) - LEADING);
        let leading = match speeds.map(|speed| speed > 0.0) {
            [false, false] => continue,
            [true, true] => (*from, *to),
            [starts, _] => {
                let between = *from + along * (speeds[0] / (speeds[0] - speeds[1]));
                if starts { (*from, between) } else { (between, *to) }
            }
        };
        let nearest = nearest_on_segment(&leading.0, &leading.1, point);
        least_m = least_m.min((point - nearest).norm());
    }
    if least_m.is_finite() && body.contains(point) { 0.0 } else { least_m }
}

/// Distance from a point to the half of a disc's outline that leads, metres; negative inside.
fn disc_distance_m(disc: &Disc, twist: &Twist, point: &Point) -> f64 {
    let center = Point::new(disc.x, disc.y);
    let velocity = velocity_at(twist, &center);
    let speed = velocity.norm();
    if speed <= LEADING {
        return f64::INFINITY;
    }
    let away = point - center;
    if away.dot(&velocity) >= 0.0 {
        return away.norm() - disc.radius;
    }
    let across = Vector::new(-velocity.y, velocity.x) * (disc.radius / speed);
    (away - across).norm().min((away + across).norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: Twist = Twist::new(0.5, 0.0);

    fn gap_m(footprint: &Footprint, twist: Twist, (x, y): (f64, f64)) -> f64 {
        let obstacle = MovingDisc { x, y, radius: 0.2, vx: 1.0, vy: 0.0 };
        footprint.leading_gap_m(&Pose::default(), &twist, &obstacle)
    }

    #[test]
    fn front_leads_a_robot_that_drives_forward_and_tail_one_that_reverses() {
        let body = Polygon::rectangle(0.8, 0.4).expect("a rectangle");
        let mirrored = Polygon::new(body.corners().iter().rev().copied().collect());
        for body in [body.clone(), mirrored.expect("a rectangle")] {
            let footprint = Footprint::covering(body);
            let near = |twist, at, expected: f64| {
                let found = gap_m(&footprint, twist, at);
                assert!((found - expected).abs() < 1e-9, "{twist:?} {at:?}: {found}");
            };
            near(FORWARD, (1.0, 0.0), 0.4);
            near(FORWARD, (0.1, 0.6), 0.3);
            near(FORWARD, (-1.0, 0.0), 1.2);
            near(Twist::new(-0.5, 0.0), (-1.0, 0.0), 0.4);
            near(Twist::new(-0.5, 0.0), (1.0, 0.0), 1.2);
            near(FORWARD, (0.0, 0.0), -0.2);
        }
    }

    #[test]
    fn halves_of_the_sides_lead_a_robot_that_turns() {
        let footprint = Footprint::covering(Polygon::rectangle(0.8, 0.4).expect("a rectangle"));
        let near = |at, expected: f64| {
            let found = gap_m(&footprint, Twist::new(0.0, 1.0), at);
            assert!((found - expected).abs() < 1e-9, "{at:?}: {found}");
        };
        // Counter-clockwise, the front half of the left side and the left half of the tail lead.
        near((0.3, 0.5), 0.1);
        near((-0.3, 0.5), libm::hypot(0.1, 0.3) - 0.2);
        near((0.3, -0.5), libm::hypot(0.1, 0.3) - 0.2);
        near((-0.3, -0.5), 0.1);
    }

    #[test]
    fn half_of_a_disc_leads() {
        let footprint = Footprint::round(0.3).expect("a radius");
        assert!((gap_m(&footprint, FORWARD, (1.0, 0.0)) - 0.5).abs() < 1e-9);
        let behind = gap_m(&footprint, FORWARD, (-0.4, 0.0));
        assert!((behind - 0.3).abs() < 1e-9, "{behind}");
        assert_eq!(gap_m(&footprint, Twist::new(0.0, 1.0), (0.4, 0.0)), f64::INFINITY);
        assert_eq!(gap_m(&footprint, Twist::STOP, (0.4, 0.0)), f64::INFINITY);
        assert_eq!(gap_m(&footprint, Twist::new(0.01, 0.0), (0.4, 0.0)), f64::INFINITY);
    }
}
