//! Settings of the supervisor.

use serde::{Deserialize, Serialize};

use crate::base::FaultDetectorSettings;
use crate::settings::{require, settings};

settings! {
    /// Command rate, target timeout, reconnection and fault detection.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct SupervisorSettings {
        /// Commands per second. Default 50.
        pub rate_hz: f64 = 50.0, ["Hz", 5 to 1000];
        /// Age at which a target expires. Default 0.3 s: three periods of the planner. The ROS differential drive
        /// controller allows 0.5 s, and cannot tell that a hung planner repeats an old target.
        pub target_timeout_s: f64 = 0.3, ["s", above 0];
        /// Pause after the first failure of the connection. Default 0.1 s.
        pub reconnect_min_s: f64 = 0.1, ["s", above 0];
        /// Longest pause between attempts to reconnect, at least `reconnect_min_s`. Default 5 s.
        pub reconnect_max_s: f64 = 5.0, ["s", above 0];
        /// Thresholds of the fault detector.
        pub fault_detector: FaultDetectorSettings = FaultDetectorSettings::default();
    }
    rule |settings| require(
        settings.reconnect_max_s >= settings.reconnect_min_s,
        "reconnect_max_s",
        settings.reconnect_max_s,
        "finite and at least reconnect_min_s",
    )
}

impl SupervisorSettings {
    /// Time between commands, seconds.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.rate_hz.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn supervisor_settings_reject_bad_values_by_name() {
        let valid = SupervisorSettings::default();
        valid.validate().expect("valid settings");
        for (settings, words) in [
            (SupervisorSettings { rate_hz: 1.0, ..valid }, "rate_hz is 1"),
            (SupervisorSettings { target_timeout_s: f64::NAN, ..valid }, "target_timeout_s is NaN"),
            (SupervisorSettings { reconnect_max_s: 0.01, ..valid }, "reconnect_max_s is 0.01"),
        ] {
            let message = settings.validate().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
