//! Speed limits of zones, and one for everywhere.

use std::sync::Arc;

use super::Navigator;
use crate::geometry::{Point, Twist};
use crate::map::Zones;

/// Share of the braking limit with which the robot slows down before a zone with a speed limit.
const ZONE_BRAKING: f64 = 0.6;

impl Navigator {
    /// Limits the speed everywhere, m/s; `None` for no limit. A robot that is faster brakes. With a limit of zero it stands or
    /// turns on the spot. A limit below zero, or NaN, counts as zero.
    pub const fn set_speed_limit(&mut self, limit: Option<f64>) {
        self.speed_limit = match limit {
            Some(limit) => Some(limit.max(0.0)),
            None => None,
        };
    }

    /// The highest speed that keeps the limit for everywhere and those of zones around a place, m/s; infinite without any.
    pub(super) fn limited_speed(&self, place: &Point) -> f64 {
        let limits = &self.robot.limits;
        let braking_m_s2 = -ZONE_BRAKING * limits.decel_lim_x;
        let in_zones = |zones: &Arc<Zones>| zones.fastest(place, limits.max_vel_x, braking_m_s2);
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
