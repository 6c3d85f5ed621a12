//! How a base is kept.

use serde::{Deserialize, Serialize};

use crate::base::settings::{above_zero, require};
use crate::base::{BaseError, PlausibilitySettings};
use crate::documented::documented;

documented! {
    /// How often a base is told what, and for how long a plan counts.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct KeeperSettings {
        /// Commands a second, 5 to 1000. Default 50.
        pub rate_hz: f64,
        /// Age at which a plan no longer counts, seconds, above zero. Default 0.3 s: three periods of the planner. ROS' drive
        /// controller allows 0.5 s, and that of a plan which a hung planner still repeats.
        pub plan_within_s: f64,
        /// Pause after the first failure of a line, seconds, above zero. Default 0.1 s.
        pub first_pause_s: f64,
        /// Longest pause, seconds, at least `first_pause_s`. Default 5 s.
        pub longest_pause_s: f64,
        /// When a base is doubted.
        pub plausibility: PlausibilitySettings,
    }
}

impl Default for KeeperSettings {
    fn default() -> Self {
        Self {
            rate_hz: 50.0,
            plan_within_s: 0.3,
            first_pause_s: 0.1,
            longest_pause_s: 5.0,
            plausibility: PlausibilitySettings::default(),
        }
    }
}

impl KeeperSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        require(
            (5.0..=1000.0).contains(&self.rate_hz),
            "rate_hz",
            self.rate_hz,
            "from 5 to 1000",
        )?;
        above_zero("plan_within_s", self.plan_within_s)?;
        above_zero("first_pause_s", self.first_pause_s)?;
        require(
            self.longest_pause_s.is_finite() && self.longest_pause_s >= self.first_pause_s,
            "longest_pause_s",
            self.longest_pause_s,
            "finite and at least first_pause_s",
        )?;
        self.plausibility.validate()
    }

    /// Time from one command to the next, seconds.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.rate_hz.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_settings_are_refused_by_name() {
        let fine = KeeperSettings::default();
        fine.validate().expect("sound settings");
        for (settings, words) in [
            (
                KeeperSettings {
                    rate_hz: 1.0,
                    ..fine
                },
                "rate_hz is 1",
            ),
            (
                KeeperSettings {
                    plan_within_s: f64::NAN,
                    ..fine
                },
                "plan_within_s is NaN",
            ),
            (
                KeeperSettings {
                    longest_pause_s: 0.01,
                    ..fine
                },
                "longest_pause_s is 0.01",
            ),
        ] {
            let message = settings.validate().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
