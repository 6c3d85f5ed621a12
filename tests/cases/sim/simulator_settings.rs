//! The table `[simulation]` of a configuration.

use inbye::runtime::Config;
use inbye::sim::{Fixes, OdometryNoise, Slip};

fn message(text: &str) -> String {
    let config: Config = toml::from_str(text).expect("known keys");
    config.validate().expect_err("a setting out of range").to_string()
}

#[test]
fn settings_reject_number_out_of_range_by_table_and_key() {
    for (text, words) in [
        (
            "[simulation.dynamics]\ncommand_delay_s = -0.1",
            "[simulation.dynamics] command_delay_s is -0.1",
        ),
        ("[simulation.dynamics.slip]\nmean = -0.1", "[simulation.dynamics.slip] mean is -0.1"),
        (
            "[simulation.dynamics.slip]\nwidth_ratio = 0.0",
            "[simulation.dynamics.slip] width_ratio is 0",
        ),
        (
            "[simulation.dynamics.slip]\ncalibrated_width_ratio = nan",
            "[simulation.dynamics.slip] calibrated_width_ratio is NaN",
        ),
        (
            "[simulation.dynamics.slip]\nvariation_length_m = 0.0",
            "[simulation.dynamics.slip] variation_length_m is 0",
        ),
        (
            "[simulation.odometry]\nspeed_window_s = -1.0",
            "[simulation.odometry] speed_window_s is -1",
        ),
        (
            "[simulation.odometry]\ngyro_bit_rad_s = inf",
            "[simulation.odometry] gyro_bit_rad_s is inf",
        ),
        ("[simulation.fixes]\nrate_hz = 1e6", "[simulation.fixes] rate_hz is 1000000"),
        ("[simulation.fixes]\ndropout = 2.0", "[simulation.fixes] dropout is 2"),
        ("[simulation.lidar]\nrange_min_m = -1.0", "[simulation.lidar] range_min_m is -1"),
        ("[simulation.lidar]\ndropout = 1.5", "[simulation.lidar] dropout is 1.5"),
    ] {
        let error = message(text);
        assert!(error.starts_with(words), "{error}");
    }
}

#[test]
fn unknown_keys_are_errors() {
    for text in [
        "[simulation.dynamics.slip]\nratio = 1.0",
        "[simulation.odometry]\nnoise = 1.0",
        "[simulation.fixes]\nrate = 1.0",
    ] {
        assert!(toml::from_str::<Config>(text).is_err(), "{text}");
    }
}

#[test]
fn settings_keep_defaults_of_omitted_keys() {
    let config: Config = toml::from_str(
        "[simulation.dynamics.slip]\nmean = 0.1\n[simulation.odometry]\nencoder_tick_m = 0.0\n[simulation.fixes]\nrate_hz = 2.0",
    )
    .expect("a valid configuration");
    assert_eq!(config.validate(), Ok(()));
    let slip = Slip::default().mean(0.1);
    let odometry = OdometryNoise::default().encoder_tick_m(0.0);
    let fixes = Fixes::default().rate_hz(2.0);
    assert_eq!(config.simulation.dynamics.slip, slip);
    assert_eq!((config.simulation.odometry, config.simulation.fixes), (odometry, fixes));
}
