//! Settings out of range are rejected by name.

use inbye::base::{BaseSettings, FaultDetectorSettings, SupervisorSettings};
use inbye::robot::PerTrack;

#[test]
fn base_settings_reject_bad_values_by_name() {
    let valid = BaseSettings::default();
    valid.validate().expect("valid settings");
    let no_ticks = PerTrack::new(0.0, 1.0);
    for (settings, words) in [
        (valid.track_width_m(-1.0), "track_width_m is -1"),
        (valid.effective_width_ratio(6.0), "effective_width_ratio is 6"),
        (valid.ticks_per_m(no_ticks), "ticks_per_m is 0"),
        (valid.min_battery_v(Some(f64::NAN)), "min_battery_v is NaN"),
    ] {
        let message = settings.validate().unwrap_err().to_string();
        assert!(message.starts_with(words), "{message}");
    }
}

/// Settings of a supervisor with another fault detector.
fn with_detector(
    change: impl Fn(FaultDetectorSettings) -> FaultDetectorSettings,
) -> SupervisorSettings {
    SupervisorSettings::default().fault_detector(change(FaultDetectorSettings::default()))
}

#[test]
fn supervisor_settings_reject_bad_values_by_name() {
    let valid = SupervisorSettings::default();
    valid.validate().expect("valid settings");
    for (settings, words) in [
        (valid.rate_hz(1.0), "rate_hz is 1"),
        // One step of the ramp is at most 0.1 s.
        (valid.rate_hz(9.9), "rate_hz is 9.9: it must be 10 to 1000"),
        (valid.target_timeout_s(f64::NAN), "target_timeout_s is NaN"),
        (valid.reconnect_max_s(0.01), "reconnect_max_s is 0.01"),
        // Longer times than the detector remembers would never be reached.
        (valid.max_gap_s(5.1), "max_gap_s is 5.1: it must be above zero and at most 5"),
        (with_detector(|detector| detector.stuck_s(5.1)), "[fault_detector] stuck_s is 5.1"),
        (with_detector(|detector| detector.reversed_s(6.0)), "[fault_detector] reversed_s is 6"),
    ] {
        let message = settings.validate().unwrap_err().to_string();
        assert!(message.starts_with(words), "{message}");
    }
}
