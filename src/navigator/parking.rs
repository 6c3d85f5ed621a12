//! The last decimetres: to a point, to the centimetre, and to a yaw.
//!
//! The dynamic window judges where a trajectory ends after seconds; a robot that shall stand at a station needs the
//! distance itself. So near its goal it turns towards it, drives straight at it, forwards or backwards, and then turns to
//! the yaw asked for. A tracked base can do all three.

use core::f64::consts::FRAC_PI_2;

use super::{Goal, NavigatorSettings};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::robot::Limits;

/// The tolerance grows by itself in so many seconds: a pose that is not known so well is not chased for ever.
const TOLERANCE_GROWS_S: f64 = 10.0;
/// Speed for each metre left, 1/s; turn rate for each radian, 1/s. Slow enough for a base that answers within 0.2 s.
const SPEED_PER_M: f64 = 1.5;
const RATE_PER_RAD: f64 = 2.5;
/// It stops to aim when the goal lies further off its nose (or tail) than this, radians, and drives on within that.
const AIMS_FROM: f64 = 0.35;
const AIMS_UNTIL: f64 = 0.05;
/// A robot slower than this stands, m/s or rad/s.
const STANDING: f64 = 0.02;
/// After turning to its yaw it goes for the point again if it is this many times the tolerance off, and so often.
const OFF_AGAIN: f64 = 1.5;
const MOST_RETURNS: u32 = 3;

/// Where parking stands.
#[derive(Clone, Debug, Default)]
pub(super) struct Parking {
    since_s: Option<f64>,
    aims: bool,
    at_point: bool,
    returns: u32,
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ParkingStep {
    /// A velocity to make for, before the limits of acceleration.
    Move(Twist),
    /// It stands as asked.
    Parked,
}

impl Parking {
    /// Whether a goal lies close enough before (or behind) a robot to drive straight at it.
    pub fn can_begin(pose: &Pose, goal: &Goal, settings: &NavigatorSettings) -> bool {
        let to_goal = pose.inverse_transform(&goal.position);
        let off_nose = libm::atan2(to_goal.y, to_goal.x);
        to_goal.coords.norm() <= settings.parking_distance_m && off_nose.abs() <= AIMS_FROM
    }

    /// Whether it has begun.
    pub const fn has_begun(&self) -> bool {
        self.since_s.is_some()
    }

    /// Seconds since parking began; it begins with the first call.
    pub fn lasted_s(&mut self, now_s: f64) -> f64 {
        now_s - *self.since_s.get_or_insert(now_s)
    }

    /// What to do at a time, seconds, at a pose, moving so.
    pub fn step(
        &mut self,
        now_s: f64,
        (pose, twist): (&Pose, &Twist),
        goal: &Goal,
        settings: &NavigatorSettings,
        limits: &Limits,
    ) -> ParkingStep {
        let away_m = (goal.position - pose.position()).norm();
        let lasted_s = self.lasted_s(now_s);
        let tolerance_m = settings.xy_parking_tolerance * (1.0 + lasted_s / TOLERANCE_GROWS_S);
        if self.at_point && away_m > OFF_AGAIN * tolerance_m && self.returns < MOST_RETURNS {
            self.at_point = false;
            self.returns += 1;
        }
        self.at_point |= away_m <= tolerance_m;
        if !self.at_point {
            return ParkingStep::Move(self.approach(pose, goal, limits));
        }
        let error = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
        if error.abs() > settings.yaw_parking_tolerance {
            return ParkingStep::Move(turn(error, limits));
        }
        if twist.linear.abs() < STANDING && twist.angular.abs() < STANDING {
            return ParkingStep::Parked;
        }
        ParkingStep::Move(Twist::STOP)
    }

    /// Straight at the point, nose or tail first, whichever is nearer to it.
    fn approach(&mut self, pose: &Pose, goal: &Goal, limits: &Limits) -> Twist {
        let to_goal = pose.inverse_transform(&goal.position);
        let away_m = to_goal.coords.norm();
        let off_nose = libm::atan2(to_goal.y, to_goal.x);
        let backwards = off_nose.abs() > FRAC_PI_2 && limits.min_vel_x < 0.0;
        let error = if backwards {
            libm::atan2(-to_goal.y, -to_goal.x)
        } else {
            off_nose
        };
        let aims_from = if self.aims { AIMS_UNTIL } else { AIMS_FROM };
        self.aims = error.abs() > aims_from;
        if self.aims {
            return turn(error, limits);
        }
        let stops_in_time = (-limits.decel_lim_x * away_m).sqrt();
        let speed = (SPEED_PER_M * away_m)
            .min(stops_in_time)
            .min(limits.max_vel_x);
        let way = if backwards { -1.0 } else { 1.0 };
        Twist::new(way * speed, RATE_PER_RAD * error)
    }
}

/// A turn on the spot by an angle, at a rate from which it can still stop in time.
pub(super) fn turn(angle: f64, limits: &Limits) -> Twist {
    let rate = (-limits.decel_lim_theta * angle.abs())
        .sqrt()
        .min(RATE_PER_RAD * angle.abs())
        .min(limits.max_vel_theta);
    Twist::new(0.0, rate.copysign(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    /// A base that follows commands within its limits, one tick late.
    fn park(start: Pose, goal: Goal, limits: &Limits) -> (Pose, f64) {
        let settings = NavigatorSettings::default();
        let (mut pose, mut twist, mut parking) = (start, Twist::STOP, Parking::default());
        let mut late = Twist::STOP;
        for tick in 0..600 {
            let now_s = f64::from(tick) * 0.1;
            let step = parking.step(now_s, (&pose, &twist), &goal, &settings, limits);
            let ParkingStep::Move(wanted) = step else {
                return (pose, f64::from(tick) * 0.1);
            };
            twist = limits.reachable(&twist, &late, 0.1);
            late = limits.clamp(&wanted);
            let heading = pose.yaw + twist.angular * 0.05;
            pose.x += twist.linear * 0.1 * libm::cos(heading);
            pose.y += twist.linear * 0.1 * libm::sin(heading);
            pose.yaw = wrap_angle(pose.yaw + twist.angular * 0.1);
        }
        panic!("not parked after 60 s: {pose:?}, {parking:?}");
    }

    #[test]
    fn it_parks_to_the_centimetre_from_all_around() {
        let settings = NavigatorSettings::default();
        for (least, slowest_s) in [(-0.3, 15.0), (0.0, 25.0)] {
            let limits = Limits {
                min_vel_x: least,
                ..Limits::default()
            };
            for step in 0..48_u32 {
                let (around, yaw) = (f64::from(step) * 0.131, f64::from(step) * 0.77);
                let start = Pose::new(0.3 * libm::cos(around), 0.3 * libm::sin(around), yaw);
                let goal = Goal {
                    position: Point::new(0.0, 0.0),
                    yaw: (step % 3 > 0).then_some(wrap_angle(yaw + 2.0)),
                };
                let (end, took_s) = park(start, goal, &limits);
                let off_m = end.position().coords.norm();
                assert!(
                    off_m <= OFF_AGAIN * settings.xy_parking_tolerance,
                    "{step}: {off_m}"
                );
                let off = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
                assert!(off.abs() <= settings.yaw_parking_tolerance, "{step}: {off}");
                assert!(took_s < slowest_s, "{step}: {took_s} s");
            }
        }
    }

    #[test]
    fn a_goal_behind_is_backed_into_where_the_base_can_back() {
        let goal = Goal {
            position: Point::new(-0.2, 0.0),
            yaw: None,
        };
        for (least, backs) in [(-0.3, true), (0.0, false)] {
            let limits = Limits {
                min_vel_x: least,
                ..Limits::default()
            };
            let (end, _) = park(Pose::default(), goal, &limits);
            assert_eq!(end.yaw.abs() < 0.1, backs, "{end:?}");
        }
    }
}
