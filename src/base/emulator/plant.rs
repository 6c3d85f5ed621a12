//! The machine behind an emulated controller: two tracks, their encoders, a battery, a gyro, and the ground.

use core::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Trouble;
use super::motor::{Motor, SpeedControl};
use crate::base::{BaseSettings, Machine};
use crate::geometry::{Pose, Twist};
use crate::robot::{PerTrack, TrackSpeeds};

/// Time of one turn of the speed control, seconds: 100 Hz, as the inner loop of usual firmware.
const TURN_S: f64 = 0.01;

/// Longest step of the physics, seconds.
const STEP_S: f64 = 0.001;

/// Voltage of a full battery of six lithium cells, and of an empty one.
const FULL_V: f64 = 25.2;
const EMPTY_V: f64 = 19.8;

/// Its inner resistance, ohm, by which it sags, and its charge, ampere seconds (10 Ah).
const INNER_OHM: f64 = 0.05;
const CHARGE_AS: f64 = 36_000.0;

/// Current of all but the motors, A.
const IDLE_A: f64 = 0.8;

/// Noise of the gyro, rad/s, one deviation: as the simulated base's.
const GYRO_SIGMA: f64 = 8.7e-4;

#[derive(Clone, Debug)]
pub(super) struct Plant {
    settings: BaseSettings,
    motors: PerTrack<Motor>,
    controls: PerTrack<SpeedControl>,
    voltages: PerTrack<f64>,
    /// Way of each track since the start, metres, and its counter at the last turn.
    travel_m: PerTrack<f64>,
    counted: PerTrack<i64>,
    since_turn_s: f64,
    battery_v: f64,
    drawn_as: f64,
    yaw_rate: f64,
    pose: Pose,
    travelled_m: f64,
    rng: Pcg64Mcg,
}

impl Plant {
    /// A machine that stands. The settings are valid.
    pub(super) fn new(settings: BaseSettings, seed: u64) -> Self {
        Self {
            settings,
            motors: PerTrack::default(),
            controls: PerTrack::default(),
            voltages: PerTrack::default(),
            travel_m: PerTrack::default(),
            counted: PerTrack::default(),
            since_turn_s: 0.0,
            battery_v: FULL_V,
            drawn_as: 0.0,
            yaw_rate: 0.0,
            pose: Pose::default(),
            travelled_m: 0.0,
            rng: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Lets a time pass, seconds, with these set speeds of the tracks, m/s, and what is wrong just now.
    pub(super) fn run(&mut self, time_s: f64, set: TrackSpeeds, troubles: &[Trouble]) {
        let mut left_s = time_s;
        while left_s > 0.0 {
            let step_s = left_s.min(STEP_S);
            left_s -= step_s;
            self.since_turn_s += step_s;
            if self.since_turn_s >= TURN_S {
                self.turn(set);
            }
            self.roll(step_s, troubles);
        }
    }

    /// One turn of the firmware's speed control, by its encoders.
    fn turn(&mut self, set: TrackSpeeds) {
        let turn_s = core::mem::take(&mut self.since_turn_s);
        let counts = self.counts();
        let shown = counts
            .zip(self.counted, |now, before| (now - before) as f64 / turn_s)
            .zip(self.settings.ticks_per_m, |rate, per_m| rate / per_m);
        self.counted = counts;
        let wanted = PerTrack::from(set).zip(shown, |set, shown| (set, shown));
        let battery_v = self.battery_v;
        let turn = |control: &mut SpeedControl, (set, shown): (f64, f64)| {
            control.turn(set, shown, turn_s, battery_v)
        };
        self.voltages = PerTrack::new(
            turn(&mut self.controls.left, wanted.left),
            turn(&mut self.controls.right, wanted.right),
        );
        let truth = self.twist().angular;
        self.yaw_rate = truth + GYRO_SIGMA * standard_normal(&mut self.rng);
    }

    fn roll(&mut self, time_s: f64, troubles: &[Trouble]) {
        let has = |trouble| troubles.contains(&trouble);
        let mut volts = self.voltages;
        if has(Trouble::Reversed) {
            volts.left = -volts.left;
        }
        if has(Trouble::Runaway) {
            volts.left = self.battery_v;
        }
        if has(Trouble::Button) {
            volts = PerTrack::both(0.0);
        }
        let motors = &mut self.motors;
        motors.left.run(volts.left, has(Trouble::StuckLeft), time_s);
        motors
            .right
            .run(volts.right, has(Trouble::StuckRight), time_s);
        // The driver takes from the battery what it gives the motor, at a higher voltage.
        let share = volts.map(|volts| volts.abs() / self.battery_v);
        let taken_a = motors.zip(share, |motor, share| motor.current_a() * share);
        let current_a = IDLE_A + taken_a.left + taken_a.right;
        self.drawn_as = (self.drawn_as + current_a * time_s).min(CHARGE_AS);
        let open_v = FULL_V - (FULL_V - EMPTY_V) * self.drawn_as / CHARGE_AS;
        self.battery_v = open_v - INNER_OHM * current_a;
        let ran_m = self.motors.map(|motor| motor.speed() * time_s);
        self.travel_m = self.travel_m.zip(ran_m, |travel_m, ran_m| travel_m + ran_m);
        self.travelled_m += (0.5 * (ran_m.left + ran_m.right)).abs();
        self.pose = self.settings.drive().after(&self.pose, &ran_m);
    }

    fn counts(&self) -> PerTrack<i64> {
        self.travel_m
            .zip(self.settings.ticks_per_m, |travel_m, per_m| {
                (travel_m * per_m).floor() as i64
            })
    }

    /// As its controller measures it; nobody presses the button.
    pub(super) fn machine(&self) -> Machine {
        Machine {
            ticks: self.counts().map(|count| count as u32),
            speeds: self.controls.map(|control| control.measured()).into(),
            yaw_rate: self.yaw_rate,
            battery_v: self.battery_v,
            ..Machine::default()
        }
    }

    pub(super) const fn pose(&self) -> &Pose {
        &self.pose
    }

    pub(super) fn twist(&self) -> Twist {
        let speeds = self.motors.map(|motor| motor.speed());
        self.settings.drive().twist(&speeds.into())
    }

    pub(super) const fn travelled_m(&self) -> f64 {
        self.travelled_m
    }
}

/// A draw of mean zero and deviation one (Box and Muller, 1958).
fn standard_normal(rng: &mut Pcg64Mcg) -> f64 {
    // 1 - [0, 1) is never zero, so the logarithm is finite.
    let radius = (-2.0 * libm::log(1.0 - rng.random::<f64>())).sqrt();
    radius * libm::cos(TAU * rng.random::<f64>())
}
