//! Dead reckoning: encoders on the tracks and a gyro, and where they say the base has come to.

use std::collections::VecDeque;

use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::SimError;
use super::error::at_least_zero;
use super::rng::{RngStream, generator, normal};
use crate::documented::documented;
use crate::geometry::{Pose, Twist};
use crate::robot::TrackSpeeds;
use crate::runtime::OdometryReading;

/// Time from one sample of the sensors to the next, seconds: the inner loop of usual base firmware runs at 100 Hz.
pub(super) const SAMPLE_S: f64 = 0.01;

/// Times nearer than this are the same, seconds.
pub(super) const INSTANT_S: f64 = 1e-9;

documented! {
    /// How well a base measures its own motion. Any of them may be zero: that error is then absent.
    ///
    /// Those called sigma are standard deviations. What is constant in a run is drawn at its start.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct OdometryNoise {
        /// Way of a belt from one tick of its encoder to the next, metres, at least zero. Default 0.0001 m: our own choice
        /// between a 500-line encoder before a 30:1 gear (60,000 edges a turn of a drive wheel, some 0.01 mm) and a 13-line
        /// Hall sensor there (1560 edges, some 0.3 mm).
        pub encoder_tick_m: f64,
        /// Error of the length of a tick, as a share, at least zero, constant in a run. Default 0.005: our own choice for
        /// belts that stretch and wear.
        pub travel_scale_sigma: f64,
        /// The reported forward speed is the mean over so long, seconds, at least zero; no more than the last sample for
        /// zero. Default 0.05 s: in one sample of 10 ms a slow belt moves few ticks.
        pub speed_window_s: f64,
        /// White noise of each sample of the turn rate, rad/s, at least zero. Default 0.00087 rad/s: 0.05 deg/s, the total
        /// noise that the MPU-6050 datasheet states for its filter of 100 Hz (revision 3.4, section 6.1).
        pub gyro_sigma_rad_s: f64,
        /// Bias of the turn rate, rad/s, at least zero, constant in a run. Default 0.00035 rad/s, 0.02 deg/s: our own
        /// choice of what is left of the datasheet's +-20 deg/s when the mean of a standstill is taken off and the chip has
        /// warmed up since.
        pub gyro_bias_sigma_rad_s: f64,
        /// Error of the gyro's scale, as a share, at least zero, constant in a run. Default 0.01: the datasheet's tolerance
        /// of +-3 % taken as three deviations.
        pub gyro_scale_sigma: f64,
        /// Turn rate of one bit, rad/s, at least zero; it is rounded to the nearest. Default 0.00026644 rad/s: 16 bits over
        /// +-500 deg/s, as WHEELTEC's drivers read the same chip.
        pub gyro_bit_rad_s: f64,
    }
}

impl Default for OdometryNoise {
    fn default() -> Self {
        Self {
            encoder_tick_m: 1e-4,
            travel_scale_sigma: 0.005,
            speed_window_s: 0.05,
            gyro_sigma_rad_s: 8.7e-4,
            gyro_bias_sigma_rad_s: 3.5e-4,
            gyro_scale_sigma: 0.01,
            gyro_bit_rad_s: 2.6644e-4,
        }
    }
}

impl OdometryNoise {
    /// Sensors without any error. The ground may still slip: the encoders do not see it.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            encoder_tick_m: 0.0,
            travel_scale_sigma: 0.0,
            speed_window_s: 0.0,
            gyro_sigma_rad_s: 0.0,
            gyro_bias_sigma_rad_s: 0.0,
            gyro_scale_sigma: 0.0,
            gyro_bit_rad_s: 0.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::BadSetting`] names the first that is not finite and at least zero.
    pub fn validate(&self) -> Result<(), SimError> {
        for (name, value) in [
            ("encoder_tick_m", self.encoder_tick_m),
            ("travel_scale_sigma", self.travel_scale_sigma),
            ("speed_window_s", self.speed_window_s),
            ("gyro_sigma_rad_s", self.gyro_sigma_rad_s),
            ("gyro_bias_sigma_rad_s", self.gyro_bias_sigma_rad_s),
            ("gyro_scale_sigma", self.gyro_scale_sigma),
            ("gyro_bit_rad_s", self.gyro_bit_rad_s),
        ] {
            at_least_zero(name, value)?;
        }
        Ok(())
    }
}

/// The sensors of one run.
#[derive(Clone, Debug)]
pub(super) struct Odometry {
    noise: OdometryNoise,
    rng: Pcg64Mcg,
    travel_scale: f64,
    gyro_scale: f64,
    gyro_bias: f64,
    /// Way of each belt since the start as its encoder would have it without ticks, metres.
    travel_m: [f64; 2],
    /// The same as counted at the last sample.
    counted_m: [f64; 2],
    /// Time and true turn since the last sample.
    elapsed_s: f64,
    turned_rad: f64,
    /// Time and way of the newest samples.
    window: VecDeque<(f64, f64)>,
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
            reading: OdometryReading {
                pose: start,
                twist: Twist::STOP,
            },
        }
    }

    /// As of the last sample.
    pub(super) const fn reading(&self) -> OdometryReading {
        self.reading
    }

    /// Lets the belts run at these mean speeds for a time, seconds, while the base truly turns by an angle, radians.
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
            if tick > 0.0 {
                (travel / tick).floor() * tick
            } else {
                travel
            }
        });
        let way_m = f64::midpoint(
            counted[0] - self.counted_m[0],
            counted[1] - self.counted_m[1],
        );
        self.counted_m = counted;
        let angular = self.turn_rate(turned_rad / time_s);
        let moved = Twist::new(way_m / time_s, angular);
        self.reading = OdometryReading {
            pose: self.reading.pose.after(&moved, time_s),
            twist: Twist::new(self.mean_speed(time_s, way_m), angular),
        };
    }

    fn turn_rate(&mut self, truth: f64) -> f64 {
        let noise = normal(&mut self.rng, self.noise.gyro_sigma_rad_s);
        let rate = self.gyro_scale * truth + self.gyro_bias + noise;
        let bit = self.noise.gyro_bit_rad_s;
        if bit > 0.0 {
            (rate / bit).round() * bit
        } else {
            rate
        }
    }

    /// Mean speed over the window, with one more sample in it.
    fn mean_speed(&mut self, time_s: f64, way_m: f64) -> f64 {
        self.window.push_back((time_s, way_m));
        let sums = |window: &VecDeque<(f64, f64)>| {
            let add = |sum: (f64, f64), part: &(f64, f64)| (sum.0 + part.0, sum.1 + part.1);
            window.iter().fold((0.0, 0.0), add)
        };
        while self.window.len() > 1 && sums(&self.window).0 > self.noise.speed_window_s + INSTANT_S
        {
            self.window.pop_front();
        }
        let (time_s, way_m) = sums(&self.window);
        way_m / time_s
    }
}
