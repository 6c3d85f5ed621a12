//! A simulated tracked base: delayed commands, acceleration ramps, motor lag and track slip.

use core::f64::consts::FRAC_PI_2;
use core::ops::ControlFlow;
use std::collections::VecDeque;

use rand_pcg::Pcg64Mcg;

use super::error::above_zero;
use super::odometry::{INSTANT_S, Odometry, SAMPLE_S};
use super::{DriveDynamics, OdometryNoise, RngStream, SimError, Slip, draw_plant, generator};
use crate::base::{BaseError, require_finite, standard_normal};
use crate::geometry::{Pose, Twist};
use crate::robot::{Limits, TrackSpeeds, TrackedDrive};
use crate::runtime::{Config, GroundTruth, OdometryReading, Robot, SensorData};
use crate::settings::require;

/// A simulated tracked base. Its time passes only in [`SimBase::step`].
///
/// A command is clamped to the speed limits and acts after a delay. The controller follows it by a ramp within the
/// acceleration limits and converts the ramp to belt speeds with its calibrated track width. A belt speed within the
/// deadband is zero; each motor follows the others with a first-order lag. By the controller's model, speed and turn rate
/// never change faster than the limits times the ratios of [`DriveDynamics`]. After a reversal, the deceleration limit
/// applies for a few lags longer, instead of the lower acceleration limit.
/// [`Slip`](super::Slip) determines the motion of the base from that of its belts.
#[derive(Clone, Debug)]
pub struct SimBase {
    drive: TrackedDrive,
    /// The drive with the controller's calibrated track width.
    calibrated: TrackedDrive,
    /// Speed limits, and the accelerations that the base reaches.
    limits: Limits,
    dynamics: DriveDynamics,
    pose: Pose,
    /// Delayed commands, each with the time until it acts, seconds; the oldest first.
    pending: VecDeque<(f64, Twist)>,
    command: Twist,
    command_age_s: f64,
    /// The present output of the ramp.
    set: Twist,
    tracks: TrackSpeeds,
    ground: Ground,
    odometry: Odometry,
    /// Time until the sensors are next read, seconds.
    until_sample_s: f64,
    delivery: OdometryDelivery,
}

impl SimBase {
    /// Creates a base at rest at a pose. The same seed gives the same slip and noise.
    ///
    /// # Errors
    /// Names the first setting that is out of range.
    pub fn new(
        drive: TrackedDrive,
        limits: Limits,
        dynamics: DriveDynamics,
        noise: OdometryNoise,
        pose: Pose,
        seed: u64,
    ) -> Result<Self, SimError> {
        limits.validate()?;
        dynamics.validate()?;
        noise.validate()?;
        above_zero("track_width_m", drive.track_width_m)?;
        for (name, value) in [("start x", pose.x), ("start y", pose.y), ("start yaw", pose.yaw)] {
            require(value.is_finite(), name, value, "finite")?;
        }
        let (faster, harder) = (dynamics.acceleration_ratio, dynamics.braking_ratio);
        Ok(Self {
            drive,
            calibrated: TrackedDrive {
                track_width_m: drive.track_width_m * dynamics.slip.calibrated_width_ratio,
            },
            limits: Limits {
                acc_lim_x: limits.acc_lim_x * faster,
                acc_lim_theta: limits.acc_lim_theta * faster,
                decel_lim_x: limits.decel_lim_x * harder,
                decel_lim_theta: limits.decel_lim_theta * harder,
                ..limits
            },
            dynamics,
            pose,
            pending: VecDeque::new(),
            command: Twist::STOP,
            command_age_s: 0.0,
            set: Twist::STOP,
            tracks: TrackSpeeds::default(),
            ground: Ground::new(dynamics.slip, seed),
            odometry: Odometry::new(noise, pose, seed),
            until_sample_s: SAMPLE_S,
            delivery: OdometryDelivery::default(),
        })
    }

    /// Creates the base that a configuration describes, at rest at a pose.
    ///
    /// # Errors
    /// As [`SimBase::new`].
    pub fn of(config: &Config, pose: Pose, seed: u64) -> Result<Self, SimError> {
        let simulation = draw_plant(config, seed);
        let (dynamics, noise) = (simulation.dynamics, simulation.odometry);
        let base =
            Self::new(config.robot.drive(), config.robot.limits, dynamics, noise, pose, seed)?;
        let delivery = OdometryDelivery {
            delay_s: simulation.sensing_delay_s,
            stamps_delay: simulation.stamps_sensing_delay,
            ..OdometryDelivery::default()
        };
        Ok(Self { delivery, ..base })
    }

    /// True pose; its yaw is in (-pi, pi].
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// True motion.
    #[must_use]
    pub fn twist(&self) -> Twist {
        let slope = Slope::of(&self.dynamics, self.pose.yaw, &self.tracks);
        self.ground.twist(&self.drive, &self.tracks, slope.slip)
    }

    /// Speeds of the belts.
    #[must_use]
    pub const fn track_speeds(&self) -> &TrackSpeeds {
        &self.tracks
    }

    /// Motion as measured by its sensors, which are sampled every 10 ms.
    #[must_use]
    pub const fn odometry(&self) -> OdometryReading {
        self.odometry.reading()
    }

    /// Takes a command, which acts after the delay. It is clamped to the speed limits.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`].
    pub fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        let command = self.limits.clamp(require_finite(command)?);
        let delay_s = self.dynamics.command_delay_s;
        // Of two commands sent at once the later one counts: the queue holds at most one for each instant.
        if self.pending.back().is_some_and(|last| last.0 >= delay_s) {
            self.pending.pop_back();
        }
        self.pending.push_back((delay_s, command));
        Ok(())
    }

    /// Simulates a time, seconds. Does nothing for a time that is not finite or below a nanosecond.
    ///
    /// Steps are at most 10 ms long and end where a command begins to act. In a step the base moves on an exact arc
    /// with the mean of the twists at its ends.
    pub fn step(&mut self, time_s: f64) {
        if !time_s.is_finite() {
            return;
        }
        let mut left_s = time_s;
        while left_s > INSTANT_S {
            self.apply_due_commands();
            let until_command_s = self.pending.front().map_or(f64::INFINITY, |next| next.0);
            let sub_step_s = left_s.min(self.until_sample_s).min(until_command_s);
            self.sub_step(sub_step_s);
            left_s -= sub_step_s;
        }
    }

    /// Applies the commands that are due, the newest last.
    fn apply_due_commands(&mut self) {
        while let Some(&(due_s, command)) = self.pending.front()
            && due_s <= INSTANT_S
        {
            self.pending.pop_front();
            self.command = command;
            self.command_age_s = 0.0;
        }
    }

    fn sub_step(&mut self, time_s: f64) {
        let target = if self.command_age_s > self.dynamics.command_timeout_s {
            Twist::STOP
        } else {
            self.command
        };
        self.set = self.limits.reachable(&self.set, &target, time_s);
        let deadband = self.dynamics.deadband_m_s;
        let set = self.calibrated.tracks(&self.set);
        let set = set.map(|speed| if speed.abs() < deadband { 0.0 } else { speed });
        let share = if self.dynamics.motor_lag_s > 0.0 {
            1.0 - libm::exp(-time_s / self.dynamics.motor_lag_s)
        } else {
            1.0
        };
        let before = self.tracks;
        self.tracks = before.zip(set, |now, set| now + share * (set - now));
        let mean = before.zip(self.tracks, f64::midpoint);
        let slope = Slope::of(&self.dynamics, self.pose.yaw, &mean);
        let moved = self.ground.twist(&self.drive, &mean, slope.slip);
        self.pose = self.pose.after(&moved, time_s);
        let slide_m = slope.slide * moved.linear.abs() * time_s;
        if slide_m != 0.0 {
            let aside = self.pose.yaw + FRAC_PI_2;
            self.pose.x += slide_m * libm::cos(aside);
            self.pose.y += slide_m * libm::sin(aside);
        }
        self.odometry.roll(&mean, moved.angular * time_s, time_s);
        self.ground.roll(f64::midpoint(mean.left.abs(), mean.right.abs()) * time_s);
        self.advance_clocks(time_s);
    }

    /// Advances every clock.
    fn advance_clocks(&mut self, time_s: f64) {
        self.command_age_s += time_s;
        for (due_s, _) in &mut self.pending {
            *due_s -= time_s;
        }
        self.until_sample_s -= time_s;
        self.delivery.advance(time_s);
        if self.until_sample_s <= INSTANT_S {
            self.until_sample_s = SAMPLE_S;
            self.delivery.push(self.odometry.reading());
        }
    }
}

/// Share of the slope's sine that is slip along the tracks, and sliding across them.
const SLOPE_SLIP: f64 = 0.5;

/// Effects of a slope on a base with a heading.
struct Slope {
    /// Additional slip of both tracks; below zero downhill.
    slip: f64,
    /// Sideways motion to the left for each metre driven.
    slide: f64,
}

impl Slope {
    fn of(dynamics: &DriveDynamics, yaw: f64, tracks: &TrackSpeeds) -> Self {
        if dynamics.slope_rad <= 0.0 {
            return Self { slip: 0.0, slide: 0.0 };
        }
        let share = SLOPE_SLIP * libm::sin(dynamics.slope_rad);
        let (sin, cos) = libm::sincos(yaw - dynamics.uphill_rad);
        let uphill = if tracks.left + tracks.right < 0.0 { -cos } else { cos };
        Self { slip: share * uphill, slide: share * sin }
    }
}

/// The transport of the odometry from the base to the control loop.
#[derive(Clone, Debug, Default)]
struct OdometryDelivery {
    delay_s: f64,
    stamps_delay: bool,
    /// Readings in transport, each with the time until it arrives, seconds; the oldest first.
    under_way: VecDeque<(f64, OdometryReading)>,
    delivered: Option<OdometryReading>,
}

impl OdometryDelivery {
    /// Sends a reading.
    fn push(&mut self, reading: OdometryReading) {
        if self.delay_s > 0.0 {
            self.under_way.push_back((self.delay_s, reading));
        }
    }

    fn advance(&mut self, time_s: f64) {
        for (due_s, _) in &mut self.under_way {
            *due_s -= time_s;
        }
        while let Some(&(due_s, reading)) = self.under_way.front()
            && due_s <= INSTANT_S
        {
            self.under_way.pop_front();
            self.delivered = Some(reading);
        }
    }
}

impl Robot for SimBase {
    /// Senses odometry only.
    fn sense(&mut self, time_s: f64) -> SensorData {
        let OdometryDelivery { delay_s, stamps_delay, delivered, .. } = &self.delivery;
        let odometry = if *delay_s > 0.0 {
            delivered.unwrap_or_else(|| self.odometry.at_start())
        } else {
            self.odometry()
        };
        let age_s = if *stamps_delay { *delay_s } else { 0.0 };
        let odometry_s = (time_s - age_s).max(0.0);
        SensorData { odometry, odometry_s, lidar: None, pose: None, pose_s: None, sent: None }
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        Some(GroundTruth {
            pose: self.pose,
            twist: self.twist(),
            gap_m: None,
            contact: None,
            moving: Vec::new(),
        })
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        // The control loop sends only finite commands, and the base rejects no finite command.
        let sent = self.send(command);
        debug_assert!(sent.is_ok());
        self.step(period_s);
        ControlFlow::Continue(())
    }
}

/// Largest slip, as a fraction of the belt's speed.
const MAX_SLIP: f64 = 0.95;

/// Smallest effective width, as a fraction of its mean.
const MIN_WIDTH: f64 = 0.5;

/// The ground of one run at the position of the base.
#[derive(Clone, Debug)]
struct Ground {
    slip: Slip,
    rng: Pcg64Mcg,
    /// States of the variation of slip and effective width: Ornstein-Uhlenbeck processes over the distance driven, with
    /// mean zero and deviation one.
    slip_state: f64,
    width_state: f64,
}

impl Ground {
    fn new(slip: Slip, seed: u64) -> Self {
        let mut rng = generator(seed, RngStream::Ground);
        let (slip_state, width_state) = (standard_normal(&mut rng), standard_normal(&mut rng));
        Self { slip, rng, slip_state, width_state }
    }

    /// Returns the true motion of a base with these belt speeds and an additional slip.
    fn twist(&self, drive: &TrackedDrive, tracks: &TrackSpeeds, more: f64) -> Twist {
        let Slip { mean, width_ratio, variation, .. } = self.slip;
        let slip = (mean + variation * self.slip_state + more).min(MAX_SLIP);
        let width = width_ratio * (1.0 + variation * self.width_state).max(MIN_WIDTH);
        let effective = TrackedDrive { track_width_m: drive.track_width_m * width };
        effective.twist(&tracks.map(|speed| speed * (1.0 - slip)))
    }

    /// Advances the variation by a distance, metres: the mean of both belts' absolute travel.
    fn roll(&mut self, distance_m: f64) {
        if self.slip.variation > 0.0 && distance_m > 0.0 {
            let kept = libm::exp(-distance_m / self.slip.variation_length_m);
            let fresh = (1.0 - kept * kept).sqrt();
            for state in [&mut self.slip_state, &mut self.width_state] {
                *state = kept * *state + fresh * standard_normal(&mut self.rng);
            }
        }
    }
}
