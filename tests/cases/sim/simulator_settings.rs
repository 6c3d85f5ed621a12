//! The simulator's tables of a configuration: each key is read, and refused by its table and name.

use inbye::runtime::Config;
use inbye::sim::{Fixes, OdometryNoise, Slip};

fn refusal(text: &str) -> String {
    let config: Config = toml::from_str(text).expect("known keys");
    config
        .validate()
        .expect_err("a setting out of range")
        .to_string()
}

#[test]
fn every_key_out_of_range_is_refused_by_table_and_name() {
    for (text, words) in [
        (
            "[dynamics]\ncommand_delay_s = -0.1",
            "[dynamics] command_delay_s is -0.1",
        ),
        (
            "[dynamics.slip]\nmean = -0.1",
            "[dynamics] slip.mean is -0.1",
        ),
        (
            "[dynamics.slip]\nwidth_ratio = 0.0",
            "[dynamics] slip.width_ratio is 0",
        ),
        (
            "[dynamics.slip]\ncalibrated_width_ratio = nan",
            "[dynamics] slip.calibrated_width_ratio is NaN",
        ),
        (
            "[dynamics.slip]\nwander_length_m = 0.0",
            "[dynamics] slip.wander_length_m is 0",
        ),
        (
            "[odometry]\nspeed_window_s = -1.0",
            "[odometry] speed_window_s is -1",
        ),
        (
            "[odometry]\ngyro_bit_rad_s = inf",
            "[odometry] gyro_bit_rad_s is inf",
        ),
        ("[fixes]\nrate_hz = 1e6", "[fixes] rate_hz is 1000000"),
        ("[fixes]\ndropout = 2.0", "[fixes] dropout is 2"),
        ("[lidar]\nrange_min_m = -1.0", "[lidar] range_min_m is -1"),
        ("[lidar]\ndropout = 1.5", "[lidar] dropout is 1.5"),
    ] {
        let error = refusal(text);
        assert!(error.starts_with(words), "{error}");
    }
}

#[test]
fn unknown_keys_are_errors() {
    for text in [
        "[dynamics.slip]\nratio = 1.0",
        "[odometry]\nnoise = 1.0",
        "[fixes]\nrate = 1.0",
    ] {
        assert!(toml::from_str::<Config>(text).is_err(), "{text}");
    }
}

#[test]
fn what_is_left_out_is_the_default() {
    let config: Config = toml::from_str(
        "[dynamics.slip]\nmean = 0.1\n[odometry]\nencoder_tick_m = 0.0\n[fixes]\nrate_hz = 2.0",
    )
    .expect("a valid configuration");
    assert_eq!(config.validate(), Ok(()));
    let slip = Slip {
        mean: 0.1,
        ..Slip::default()
    };
    let odometry = OdometryNoise {
        encoder_tick_m: 0.0,
        ..OdometryNoise::default()
    };
    let fixes = Fixes {
        rate_hz: 2.0,
        ..Fixes::default()
    };
    assert_eq!(config.simulation.dynamics.slip, slip);
    assert_eq!(
        (config.simulation.odometry, config.simulation.fixes),
        (odometry, fixes)
    );
}
