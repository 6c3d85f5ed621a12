//! Dead reckoning by track encoders and a gyro, with their errors.

use std::collections::VecDeque;

use rand_pcg::Pcg64Mcg;

use super::{OdometryNoise, RngStream, generator, normal};
use crate::geometry::{Pose, Twist};
use crate::robot::TrackSpeeds;
use crate::runtime::OdometryReading;

/// Sampling period of the sensors, seconds: common base firmware runs its inner loop at 100 Hz.
pub(super) const SAMPLE_S: f64 = 0.01;

/// Smallest difference between two times, seconds.
pub(super) const INSTANT_S: f64 = 1e-9;

/// The sensors of one run.
#[derive(Clone, Debug)]
pub(super) struct Odometry {
    noise: OdometryNoise,
    rng: Pcg64Mcg,
    travel_scale: f64,
    gyro_scale: f64,
    gyro_bias: f64,
    /// Travel of each belt since the start with the scale error, before quantisation, metres.
    travel_m: [f64; 2],
    /// The quantised travel at the last sample.
    counted_m: [f64; 2],
    /// Time and true rotation since the last sample.
    elapsed_s: f64,
    turned_rad: f64,
    /// Time and travel of the newest samples.
    window: VecDeque<(f64, f64)>,
    start: Pose,
    reading: OdometryReading,
}

impl Odometry {
    pub(super) fn new(noise: OdometryNoise, start: Pose, seed: u64) -> Self {
        let mut rng = generator(seed, RngStream::Odometry);
        Self {
            noise,
            travel_scale: 1.0 + normal(&mut rng, noise.travel_scale_sigma),
            gyro_scale: 1.0 + normal(&mut rng, noise.gyro_scale_sigma),
            gyro_bias: normal(&mut rng, noise.gyro_bias_sigma_rad_s),
            rng,
            travel_m: [0.0; 2],
            counted_m: [0.0; 2],
            elapsed_s: 0.0,
            turned_rad: 0.0,
            window: VecDeque::new(),
            start,
            reading: OdometryReading { pose: start, twist: Twist::STOP },
        }
    }

    /// The reading of the last sample.
    pub(super) const fn reading(&self) -> OdometryReading {
        self.reading
    }

    /// The reading before the first sample.
    pub(super) const fn at_start(&self) -> OdometryReading {
        OdometryReading { pose: self.start, twist: Twist::STOP }
    }

    /// Advances by a time, seconds, with the mean belt speeds and the true rotation, radians, of that time.
    pub(super) fn roll(&mut self, tracks: &TrackSpeeds, turned_rad: f64, time_s: f64) {
        self.travel_m[0] += tracks.left * time_s * self.travel_scale;
        self.travel_m[1] += tracks.right * time_s * self.travel_scale;
        self.turned_rad += turned_rad;
        self.elapsed_s += time_s;
        if self.elapsed_s > SAMPLE_S - INSTANT_S {
            self.sample();
        }
    }

    fn sample(&mut self) {
        let time_s = core::mem::take(&mut self.elapsed_s);
        let turned_rad = core::mem::take(&mut self.turned_rad);
        let counted = self.travel_m.map(|travel| {
            let tick = self.noise.encoder_tick_m;
            if tick > 0.0 { (travel / tick).floor() * tick } else { travel }
        });
        let travel_step_m =
            f64::midpoint(counted[0] - self.counted_m[0], counted[1] - self.counted_m[1]);
        self.counted_m = counted;
        let angular = self.turn_rate(turned_rad / time_s);
        let moved = Twist::new(travel_step_m / time_s, angular);
        self.reading = OdometryReading {
            pose: self.reading.pose.after(&moved, time_s),
            twist: Twist::new(self.mean_speed(time_s, travel_step_m), angular),
        };
    }

    fn turn_rate(&mut self, truth: f64) -> f64 {
        let noise = normal(&mut self.rng, self.noise.gyro_sigma_rad_s);
        let rate = self.gyro_scale * truth + self.gyro_bias + noise;
        let bit = self.noise.gyro_bit_rad_s;
        if bit > 0.0 { (rate / bit).round() * bit } else { rate }
    }

    /// Adds a sample; returns the mean speed over the window.
    fn mean_speed(&mut self, time_s: f64, travel_step_m: f64) -> f64 {
        self.window.push_back((time_s, travel_step_m));
        let sums = |window: &VecDeque<(f64, f64)>| {
            let add = |sum: (f64, f64), part: &(f64, f64)| (sum.0 + part.0, sum.1 + part.1);
            window.iter().fold((0.0, 0.0), add)
        };
        while self.window.len() > 1 && sums(&self.window).0 > self.noise.speed_window_s + INSTANT_S
        {
            self.window.pop_front();
        }
        let (time_s, travel_step_m) = sums(&self.window);
        travel_step_m / time_s
    }
}
