//! Speed limits of zones, and one for everywhere.

use std::sync::Arc;

use super::Navigator;
use crate::geometry::{Point, Pose, Twist};
use crate::map::Zones;
use crate::robot::{Limits, TickTime};

/// Share of the braking limit with which the robot slows down before a zone with a speed limit.
const ZONE_BRAKING: f64 = 0.6;

/// The limits of a robot for one decision at a place among zones, as a [`Navigator`] has them there: with the speed from which it
/// keeps the limits of all zones around. One that is faster brakes.
#[must_use]
pub fn limits_in_zones(
    limits: &Limits,
    zones: &Zones,
    pose: &Pose,
    twist: &Twist,
    tick: impl Into<TickTime>,
) -> Limits {
    let fastest = fastest_in_zones(limits, zones, &pose.position());
    if fastest >= limits.max_vel_x { *limits } else { limits.slowed_to(fastest, twist, tick) }
}

/// The highest speed that keeps the limits of zones around a place, m/s.
fn fastest_in_zones(limits: &Limits, zones: &Zones, place: &Point) -> f64 {
    zones.fastest(place, limits.max_vel_x, -ZONE_BRAKING * limits.decel_lim_x)
}

impl Navigator {
    /// Limits the speed everywhere, m/s; `None` for no limit. A robot that is faster brakes. With a limit of zero it stands or
    /// turns on the spot, and this time does not count as time without progress. A limit below zero, or NaN, counts as zero.
    pub const fn set_speed_limit(&mut self, limit: Option<f64>) {
        self.speed_limit = match limit {
            Some(limit) => Some(limit.max(0.0)),
            None => None,
        };
    }

    /// The highest speed that keeps the limit for everywhere and those of zones around a place, m/s; infinite without any.
    pub(super) fn limited_speed(&self, place: &Point) -> f64 {
        let in_zones = |zones: &Arc<Zones>| fastest_in_zones(&self.robot.limits, zones, place);
        let in_zones = self.zones.as_ref().map_or(f64::INFINITY, in_zones);
        in_zones.min(self.speed_limit.unwrap_or(f64::INFINITY))
    }

    /// A command, or the same arc at this speed, m/s, as far as the base reaches it.
    pub(super) fn at_most(&self, fastest: f64, command: &Twist, twist: &Twist) -> Twist {
        if command.linear.abs() <= fastest {
            return *command;
        }
        let share = fastest / command.linear.abs();
        let slower = Twist::new(share * command.linear, share * command.angular);
        self.robot.limits.reachable(twist, &slower, self.tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, OccupancyGrid};

    #[test]
    fn limits_in_zones_are_the_slow_speed_or_what_braking_reaches() {
        let frame = GridFrame::new(100, 10, 0.1, Pose::default()).expect("a size");
        let mask = |value: i8| OccupancyGrid::filled(frame, value);
        let zones = |speed: &OccupancyGrid| Zones::from_masks(&frame, None, None, Some(speed));
        let slow = zones(&mask(70)).expect("a valid mask").expect("zones");
        let (limits, pose) = (Limits::default(), Pose::new(5.0, 0.5, 0.0));
        let limited = |speed: f64| {
            let twist = Twist::new(speed, 0.0);
            limits_in_zones(&limits, &slow, &pose, &twist, 0.1)
        };
        let expected = 0.3 * limits.max_vel_x;
        assert!((limited(0.0).max_vel_x - expected).abs() < 1e-12);
        let braked = limits.max_vel_x + 0.1 * limits.decel_lim_x;
        assert!((limited(limits.max_vel_x).max_vel_x - braked).abs() < 1e-12);
        let same = Limits { max_vel_x: limited(0.0).max_vel_x, ..limits };
        assert_eq!(limited(0.0), Limits { min_vel_x: limits.min_vel_x.max(-expected), ..same });
        // Without a limit nothing changes.
        let none = Zones::new(&frame);
        assert_eq!(limits_in_zones(&limits, &none, &pose, &Twist::STOP, 0.1), limits);
    }
}
