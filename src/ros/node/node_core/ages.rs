//! How old inputs may be, how late they and the ticks are, and how long the time between two ticks may be.

use super::NodeCore;
use crate::robot::TickTime;
use crate::ros::node::latest_inputs::AgeLimits;
use crate::runtime::NodeConfig;
use crate::settings::{SettingError, require};

/// Longest time between two ticks, seconds. After a longer one the world may have changed: the robot starts again from zero.
pub(super) const MAX_TICK_GAP_S: f64 = 0.3;

/// Checks the interval of the ticks, seconds.
pub(super) fn check_period(period_s: f64) -> Result<(), SettingError> {
    let expected = "at most 0.25 in the ROS node, which takes a longer time between two ticks for a pause of its process";
    require(period_s <= *NodeConfig::PERIODS_S.end(), "control_period_s", period_s, expected)
        .map_err(|error| error.in_table("local"))
}

impl NodeCore {
    pub(super) fn age_limits(&self) -> AgeLimits {
        let config = &self.settings.config;
        AgeLimits {
            odometry_s: config.navigator.odometry_timeout_s,
            transform_s: config.node.transform_timeout_s,
            clock_ahead_s: config.node.max_clock_ahead_s,
        }
    }

    /// Measures the time since the last tick, and counts and reports a late tick.
    pub(super) fn measure_tick(&mut self, now_s: f64) -> TickTime {
        let tick = self.tick_clock.tick(now_s);
        self.stats.late_ticks = self.tick_clock.late_ticks();
        self.notices.late_tick(now_s, &tick);
        tick
    }

    /// Counts the delays of scans and odometry, and reports those that are late.
    pub(super) fn check_delays(&mut self) {
        let settings = &self.settings.config.navigator;
        let delays = [
            ("odom", &self.inputs.odometry_delay, settings.odometry_timeout_s),
            ("scan", &self.inputs.scan_delay, settings.scan_timeout_s),
        ];
        for (topic, delay, limit_s) in delays {
            if let (Some(least_s), Some(age_s)) = (delay.least_s(), delay.least_age_s()) {
                self.stats.least_delay_s.insert(topic, least_s);
                self.notices.late(topic, least_s, age_s, limit_s);
            }
        }
    }
}
