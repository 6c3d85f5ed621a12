//! How old inputs may be, and how late they are.

use super::NodeCore;
use crate::ros::node::latest_inputs::AgeLimits;

impl NodeCore {
    pub(super) fn age_limits(&self) -> AgeLimits {
        let config = &self.settings.config;
        AgeLimits {
            odometry_s: config.navigator.odometry_timeout_s,
            transform_s: config.node.transform_timeout_s,
            clock_ahead_s: config.node.max_clock_ahead_s,
        }
    }

    /// Counts the delays of scans and odometry, and reports those that are late.
    pub(super) fn check_delays(&mut self) {
        let settings = &self.settings.config.navigator;
        let delays = [
            ("odom", &self.inputs.odometry_delay, settings.odometry_timeout_s),
            ("scan", &self.inputs.scan_delay, settings.scan_timeout_s),
        ];
        for (topic, delay, limit_s) in delays {
            if let Some(least_s) = delay.least_s() {
                self.stats.least_delay_s.insert(topic, least_s);
                self.notices.late(topic, least_s, limit_s);
            }
        }
    }
}
