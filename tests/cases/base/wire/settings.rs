//! Settings out of range are rejected by name.

use inbye::base::{
    BaseSettings, FaultDetectorSettings, Protocol, SupervisorSettings, arduino::ArduinoSettings,
};
use inbye::robot::{PerTrack, TrackLimits};

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
        // Other units: millimetres, degrees, milliseconds.
        (valid.track_width_m(500.0), "track_width_m is 500"),
        (valid.min_battery_v(Some(21_000.0)), "min_battery_v is 21000"),
        (valid.max_speed_without_watchdog_m_s(300.0), "max_speed_without_watchdog_m_s is 300"),
        (
            valid.tracks(TrackLimits::default().max_track_speed(1250.0)),
            "[tracks] max_track_speed is 1250",
        ),
        (
            valid.arduino(ArduinoSettings::default().pid_interval_s(33.0)),
            "[arduino] pid_interval_s is 33",
        ),
    ] {
        let message = settings.validate().unwrap_err().to_string();
        assert!(message.starts_with(words), "{message}");
    }
}

/// Its commands have 16 bits.
#[test]
fn arduino_session_rejects_speeds_that_do_not_fit() {
    let settings = |per_m| BaseSettings::default().ticks_per_m(PerTrack::new(10_000.0, per_m));
    // 32,767 ticks per cycle at 1.25 m/s and 0.033 s.
    let largest = 32_767.0 / (1.25 * 0.033);
    assert!(Protocol::Arduino.session(settings(largest - 1.0)).is_ok());
    let error = Protocol::Arduino.session(settings(largest + 1.0)).err().expect("out of range");
    assert!(error.to_string().starts_with("ticks_per_m is 7943"), "{error}");
    assert!(Protocol::Roboclaw.session(settings(largest + 1.0)).is_ok());
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
        (valid.target_timeout_s(300.0), "target_timeout_s is 300"),
        (
            with_detector(|detector| detector.max_tilt_rad(20.0)),
            "[fault_detector] max_tilt_rad is 20",
        ),
        (with_detector(|detector| detector.runaway_s(500.0)), "[fault_detector] runaway_s is 500"),
        (
            with_detector(|detector| detector.command_delay_s(200.0)),
            "[fault_detector] command_delay_s is 200",
        ),
    ] {
        let message = settings.validate().unwrap_err().to_string();
        assert!(message.starts_with(words), "{message}");
    }
}
