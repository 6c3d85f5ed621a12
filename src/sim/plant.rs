//! The true parameters of the simulated robot of a mission.

use core::f64::consts::PI;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{Lidar, OdometryNoise, RngStream, generator};
use crate::runtime::{Config, PlantKind, SimulationSettings};

/// Returns the settings of the simulation with the true values of one mission. An agreeing plant has the values of the settings; for
/// a disagreeing plant they are drawn from the ranges. The same seed gives the same values. The kind of the result is agreeing, so
/// that the result describes the mission without the seed. The delay of the scans is at most what the lidar's period permits.
#[must_use]
pub fn draw_plant(config: &Config, seed: u64) -> SimulationSettings {
    let settings = &config.simulation;
    if settings.plant == PlantKind::Agreeing {
        return *settings;
    }
    let ranges = &settings.plant_ranges;
    let mut rng = generator(seed, RngStream::Plant);
    let mut drawn = *settings;
    drawn.plant = PlantKind::Agreeing;
    // All values are drawn in a fixed order, so that a change of one range leaves the others unchanged.
    let dynamics = &mut drawn.dynamics;
    dynamics.command_delay_s = uniform(&mut rng, ranges.command_delay_s);
    let longest_s = config.largest_sensing_delay_s();
    let delays_s = ranges.sensing_delay_s.map(|delay_s| delay_s.min(longest_s));
    drawn.sensing_delay_s = uniform(&mut rng, delays_s);
    dynamics.motor_lag_s = uniform(&mut rng, ranges.motor_lag_s);
    dynamics.acceleration_ratio = uniform(&mut rng, ranges.acceleration_ratio);
    dynamics.braking_ratio = uniform(&mut rng, ranges.braking_ratio);
    dynamics.deadband_m_s = uniform(&mut rng, ranges.deadband_m_s);
    dynamics.slip.width_ratio = uniform(&mut rng, ranges.width_ratio);
    dynamics.slope_rad = uniform(&mut rng, ranges.slope_rad);
    dynamics.uphill_rad = uniform(&mut rng, [-PI, PI]);
    let noise = uniform(&mut rng, ranges.noise_ratio);
    drawn.odometry = noisier(&settings.odometry, noise);
    drawn.fixes.sigma_m *= noise;
    drawn.fixes.sigma_rad *= noise;
    drawn.lidar = Lidar {
        range_sigma_m: settings.lidar.range_sigma_m * noise,
        ghosts: uniform(&mut rng, ranges.ghosts),
        mixed_pixels: uniform(&mut rng, ranges.mixed_pixels),
        ..settings.lidar
    };
    let [slowest, fastest] = ranges.pedestrian_speed_m_s;
    let pedestrians = settings.pedestrians.min_speed(slowest).max_speed(fastest);
    drawn.pedestrians = pedestrians.leg_diameter_m(uniform(&mut rng, ranges.leg_diameter_m));
    let is_blind = rng.random::<f64>() < ranges.blind_share;
    let start_s = uniform(&mut rng, ranges.blind_start_s);
    let time_s = uniform(&mut rng, ranges.blind_time_s);
    let direction_rad = uniform(&mut rng, [-PI, PI]);
    let width_rad = uniform(&mut rng, ranges.blind_width_rad);
    drawn.map_error_m = uniform(&mut rng, ranges.map_error_m);
    if is_blind {
        drawn.lidar.blind_start_s = start_s;
        drawn.lidar.blind_time_s = time_s;
        drawn.lidar.blind_direction_rad = direction_rad;
        drawn.lidar.blind_width_rad = width_rad;
    }
    drawn
}

/// Draws a value between two bounds; one random number in any case.
fn uniform(rng: &mut Pcg64Mcg, [least, largest]: [f64; 2]) -> f64 {
    least + (largest - least) * rng.random::<f64>()
}

/// Odometry with larger errors; its resolution stays.
fn noisier(noise: &OdometryNoise, ratio: f64) -> OdometryNoise {
    OdometryNoise {
        travel_scale_sigma: noise.travel_scale_sigma * ratio,
        gyro_sigma_rad_s: noise.gyro_sigma_rad_s * ratio,
        gyro_bias_sigma_rad_s: noise.gyro_bias_sigma_rad_s * ratio,
        gyro_scale_sigma: noise.gyro_scale_sigma * ratio,
        ..*noise
    }
}
