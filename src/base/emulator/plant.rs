//! The machine of an emulated base: two tracks with encoders, a battery, a gyro, and the motion on the ground.
//!
//! Each track has a DC motor with inertia and friction, and a PI speed controller. The parameters are chosen for a small 24 V
//! gear motor and belong to no particular product. The track reaches 63 % of a step of its set speed within about 0.05 s.

use core::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::InjectedFault;
use crate::base::{BaseSettings, MachineState};
use crate::geometry::{Pose, Twist};
use crate::robot::{PerTrack, TrackSpeeds, TrackedDrive};

/// Cycle time of the speed control, seconds: 100 Hz, typical for firmware.
const CYCLE_S: f64 = 0.01;

/// Longest integration step, seconds.
const STEP_S: f64 = 0.001;

/// Voltage of a full and of an empty battery of six lithium cells.
const FULL_V: f64 = 25.2;
const EMPTY_V: f64 = 19.8;

/// Internal resistance of the battery, ohm, and its charge, ampere seconds (10 Ah).
const INTERNAL_OHM: f64 = 0.05;
const CHARGE_AS: f64 = 36_000.0;

/// Current of all consumers but the motors, A.
const IDLE_A: f64 = 0.8;

/// Standard deviation of the gyro's noise, rad/s: that of the simulated base.
const GYRO_SIGMA: f64 = 8.7e-4;

/// Spread of the slip of a track relative to its mean, and the time in which it changes, seconds.
const SLIP_SPREAD: f64 = 0.5;
const SLIP_CHANGE_S: f64 = 1.0;

#[derive(Clone, Debug)]
pub(super) struct Plant {
    settings: BaseSettings,
    /// The kinematics on the ground: its width differs from that of the settings if they are not calibrated.
    drive: TrackedDrive,
    motors: PerTrack<Motor>,
    controls: PerTrack<SpeedControl>,
    voltages: PerTrack<f64>,
    /// Distance of each track since the start, metres, and its count at the last cycle.
    travel_m: PerTrack<f64>,
    counted: PerTrack<i64>,
    /// Counts when the counters were last zero.
    zero_counts: PerTrack<i64>,
    /// The count of the left track while its encoder is stuck.
    stuck_count: Option<i64>,
    /// Mean share of each track's travel that is lost on the ground, the deviation of each from it in spreads, and the speed that remains.
    mean_slip: f64,
    slip_deviations: PerTrack<f64>,
    ground_shares: PerTrack<f64>,
    since_cycle_s: f64,
    battery_v: f64,
    drawn_as: f64,
    yaw_rate: f64,
    /// Whether the belts turn without effect.
    is_bogged: bool,
    pose: Pose,
    travelled_m: f64,
    rng: Pcg64Mcg,
}

impl Plant {
    /// Creates a machine that stands. The settings are valid.
    pub(super) fn new(settings: BaseSettings, seed: u64) -> Self {
        Self {
            settings,
            drive: settings.drive(),
            motors: PerTrack::default(),
            controls: PerTrack::default(),
            voltages: PerTrack::default(),
            travel_m: PerTrack::default(),
            counted: PerTrack::default(),
            zero_counts: PerTrack::default(),
            stuck_count: None,
            mean_slip: 0.0,
            slip_deviations: PerTrack::default(),
            ground_shares: PerTrack::both(1.0),
            since_cycle_s: 0.0,
            battery_v: FULL_V,
            drawn_as: 0.0,
            yaw_rate: 0.0,
            is_bogged: false,
            pose: Pose::default(),
            travelled_m: 0.0,
            rng: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Multiplies the effective track width on the ground.
    pub(super) fn widen(&mut self, ratio: f64) {
        self.drive.track_width_m *= ratio;
    }

    /// Sets the mean share of each track's travel that is lost on the ground.
    pub(super) const fn slip(&mut self, share: f64) {
        self.mean_slip = share;
    }

    /// Sets the encoder counters to zero, as a restart of the controller does.
    pub(super) fn reset_counters(&mut self) {
        self.zero_counts = self.absolute_counts();
        self.counted = PerTrack::default();
        self.controls = PerTrack::default();
    }

    /// Advances by a time, seconds, with these set speeds of the tracks, m/s, and the active faults.
    pub(super) fn run(&mut self, time_s: f64, set: TrackSpeeds, faults: &[InjectedFault]) {
        self.is_bogged = faults.contains(&InjectedFault::Bogged);
        self.stuck_count = faults
            .contains(&InjectedFault::EncoderStuck)
            .then(|| self.stuck_count.unwrap_or(self.counts().left));
        let mut left_s = time_s;
        while left_s > 0.0 {
            let step_s = left_s.min(STEP_S);
            left_s -= step_s;
            self.since_cycle_s += step_s;
            if self.since_cycle_s >= CYCLE_S {
                self.control(set);
            }
            self.integrate(step_s, faults);
        }
    }

    /// Runs one cycle of the firmware's speed control.
    fn control(&mut self, set: TrackSpeeds) {
        let cycle_s = core::mem::take(&mut self.since_cycle_s);
        let counts = self.counts();
        let encoder_speeds = counts
            .zip(self.counted, |now, before| (now - before) as f64 / cycle_s)
            .zip(self.settings.ticks_per_m, |rate, per_m| rate / per_m);
        self.counted = counts;
        let inputs = set.zip(encoder_speeds, |set, speed| (set, speed));
        let battery_v = self.battery_v;
        let cycle = |control: &mut SpeedControl, (set, speed): (f64, f64)| {
            control.cycle(set, speed, cycle_s, battery_v)
        };
        self.voltages = PerTrack::new(
            cycle(&mut self.controls.left, inputs.left),
            cycle(&mut self.controls.right, inputs.right),
        );
        self.change_slip(cycle_s);
        let true_rate = self.twist().angular;
        self.yaw_rate = true_rate + GYRO_SIGMA * standard_normal(&mut self.rng);
    }

    /// Lets the slip of each track vary about its mean (Ornstein and Uhlenbeck, 1930).
    fn change_slip(&mut self, time_s: f64) {
        if self.mean_slip == 0.0 {
            return;
        }
        let kept = libm::exp(-time_s / SLIP_CHANGE_S);
        let mut next = |deviation: f64| {
            kept * deviation + (1.0 - kept * kept).sqrt() * standard_normal(&mut self.rng)
        };
        let PerTrack { left, right } = self.slip_deviations;
        self.slip_deviations = PerTrack::new(next(left), next(right));
        let mean = self.mean_slip;
        self.ground_shares = self
            .slip_deviations
            .map(|deviation| 1.0 - (mean * (1.0 + SLIP_SPREAD * deviation)).clamp(0.0, 1.0));
    }

    fn integrate(&mut self, time_s: f64, faults: &[InjectedFault]) {
        let has = |fault| faults.contains(&fault);
        let mut volts = self.voltages;
        if has(InjectedFault::Reversed) {
            volts.left = -volts.left;
        }
        if has(InjectedFault::Runaway) {
            volts.left = self.battery_v;
        }
        if has(InjectedFault::Button) || has(InjectedFault::Reboot) {
            volts = PerTrack::both(0.0);
        }
        let motors = &mut self.motors;
        motors.left.run(volts.left, has(InjectedFault::StuckLeft), time_s);
        motors.right.run(volts.right, has(InjectedFault::StuckRight), time_s);
        // The driver converts voltage: it draws the motor's current scaled by the voltage ratio.
        let duty = volts.map(|volts| volts.abs() / self.battery_v);
        let drawn_a = motors.zip(duty, |motor, duty| motor.current_a() * duty);
        let current_a = IDLE_A + drawn_a.left + drawn_a.right;
        self.drawn_as = (self.drawn_as + current_a * time_s).min(CHARGE_AS);
        let open_v = FULL_V - (FULL_V - EMPTY_V) * self.drawn_as / CHARGE_AS;
        self.battery_v = open_v - INTERNAL_OHM * current_a;
        let step_m = self.motors.map(|motor| motor.speed() * time_s);
        self.travel_m = self.travel_m.zip(step_m, |travel_m, step_m| travel_m + step_m);
        if !self.is_bogged {
            let step_m = step_m.zip(self.ground_shares, |step_m, share| step_m * share);
            self.travelled_m += (0.5 * (step_m.left + step_m.right)).abs();
            self.pose = self.drive.after(&self.pose, &step_m);
        }
    }

    /// The counters of the encoders.
    fn counts(&self) -> PerTrack<i64> {
        let counts = self.absolute_counts().zip(self.zero_counts, |count, zero| count - zero);
        PerTrack { left: self.stuck_count.unwrap_or(counts.left), ..counts }
    }

    /// Counts since the machine was made.
    fn absolute_counts(&self) -> PerTrack<i64> {
        self.travel_m
            .zip(self.settings.ticks_per_m, |travel_m, per_m| (travel_m * per_m).floor() as i64)
    }

    /// State as the controller measures it, with the button released.
    pub(super) fn machine(&self) -> MachineState {
        MachineState {
            encoder_counts: self.counts().map(|count| count as u32),
            speeds: self.controls.map(|control| control.measured()),
            yaw_rate: self.yaw_rate,
            battery_v: self.battery_v,
            ..MachineState::default()
        }
    }

    pub(super) const fn pose(&self) -> &Pose {
        &self.pose
    }

    pub(super) fn twist(&self) -> Twist {
        if self.is_bogged {
            return Twist::STOP;
        }
        let speeds = self.motors.map(|motor| motor.speed());
        self.drive.twist(&speeds.zip(self.ground_shares, |speed, share| speed * share))
    }

    pub(super) const fn travelled_m(&self) -> f64 {
        self.travelled_m
    }
}

/// Draws from the standard normal distribution (Box and Muller, 1958).
pub(crate) fn standard_normal(rng: &mut Pcg64Mcg) -> f64 {
    // 1 - [0, 1) is never zero, so the logarithm is finite.
    let radius = (-2.0 * libm::log(1.0 - rng.random::<f64>())).sqrt();
    radius * libm::cos(TAU * rng.random::<f64>())
}

/// No-load speed of a track, m/s per volt: 1.8 m/s at 24 V, about 1.5 times the default track's highest speed.
const SPEED_PER_V: f64 = 0.075;

/// Mechanical time constant at constant voltage, seconds.
const LAG_S: f64 = 0.12;

/// Rolling resistance as a loss of speed, m/s; a standing track does not start below it.
const FRICTION: f64 = 0.08;

/// Winding resistance, ohm: a blocked motor draws 30 A at 24 V.
const WINDING_OHM: f64 = 0.8;

/// Proportional gain, V per m/s of speed error.
const PROPORTIONAL_GAIN: f64 = 20.0;

/// Integral gain, V per metre of integrated speed error.
const INTEGRAL_GAIN: f64 = 100.0;

/// Weight of a new measurement in the low-pass filtered speed: a slow track moves few ticks per cycle.
const FILTER_WEIGHT: f64 = 0.5;

/// Speed controller of a track, one cycle every 10 ms.
#[derive(Clone, Copy, Debug, Default)]
struct SpeedControl {
    measured: f64,
    integral_v: f64,
}

impl SpeedControl {
    /// The filtered measured speed, m/s.
    const fn measured(&self) -> f64 {
        self.measured
    }

    /// Runs one cycle: returns the voltage for a set speed, m/s, from the mean encoder speed since the last cycle, m/s.
    fn cycle(&mut self, set: f64, encoder_speed: f64, cycle_s: f64, battery_v: f64) -> f64 {
        self.measured += FILTER_WEIGHT * (encoder_speed - self.measured);
        let error = set - self.measured;
        if set == 0.0 {
            // Shorted windings also brake a motor with swapped leads. The integral restarts.
            self.integral_v = 0.0;
            return 0.0;
        }
        let feedforward_v = (set + FRICTION * set.signum()) / SPEED_PER_V;
        let demand_v = feedforward_v + PROPORTIONAL_GAIN * error + self.integral_v;
        let voltage = demand_v.clamp(-battery_v, battery_v);
        // No wind-up while the voltage saturates.
        if voltage == demand_v {
            self.integral_v += INTEGRAL_GAIN * error * cycle_s;
        }
        voltage
    }
}

/// A motor and its track.
#[derive(Clone, Copy, Debug, Default)]
struct Motor {
    speed: f64,
    current_a: f64,
}

impl Motor {
    /// Speed of the track, m/s.
    const fn speed(&self) -> f64 {
        self.speed
    }

    /// Magnitude of the motor current, A.
    const fn current_a(&self) -> f64 {
        self.current_a.abs()
    }

    /// Advances by a short time, seconds, at a voltage. A blocked motor does not move and draws its stall current.
    fn run(&mut self, voltage: f64, is_blocked: bool, time_s: f64) {
        let driven = SPEED_PER_V * voltage;
        self.current_a = (driven - self.speed) / SPEED_PER_V / WINDING_OHM;
        if is_blocked {
            self.speed = 0.0;
            return;
        }
        if self.speed == 0.0 && driven.abs() <= FRICTION {
            return;
        }
        let along = if self.speed == 0.0 { driven } else { self.speed };
        let slope = (driven - self.speed - FRICTION * along.signum()) / LAG_S;
        let next = self.speed + slope * time_s;
        // Friction stops a motion and starts none.
        let stops = self.speed * next < 0.0 && driven.abs() <= FRICTION;
        self.speed = if stops { 0.0 } else { next };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speeds of a track every 10 ms after a step of its set speed.
    fn step_response(start: f64, set: f64, cycles: usize) -> Vec<f64> {
        let (mut motor, mut control) = (Motor::default(), SpeedControl::default());
        let mut run = |set: f64| {
            let voltage = control.cycle(set, motor.speed(), 0.01, 24.0);
            for _ in 0..10 {
                motor.run(voltage, false, 0.001);
            }
            motor.speed()
        };
        for _ in 0..300 {
            run(start);
        }
        (0..cycles).map(|_| run(set)).collect()
    }

    #[test]
    fn speed_control_settles_fast_with_small_overshoot() {
        for (start, set) in [(0.0, 0.5), (0.5, 1.2), (0.5, -0.5), (1.0, 0.0), (0.0, 0.05)] {
            let speeds = step_response(start, set, 200);
            let step = set - start;
            assert!((speeds[14] - set).abs() < 0.3 * step.abs(), "{speeds:?}");
            assert!((speeds[199] - set).abs() < 0.01, "{start} to {set}: {speeds:?}");
            let overshoot = speeds.iter().map(|speed| (speed - set) / step);
            assert!(overshoot.fold(0.0, f64::max) < 0.25, "{speeds:?}");
        }
    }

    #[test]
    fn friction_stops_unpowered_motor_and_starts_none() {
        let mut motor = Motor::default();
        motor.run(1.0, false, 0.001);
        assert_eq!(motor.speed(), 0.0);
        for _ in 0..200 {
            motor.run(12.0, false, 0.001);
        }
        assert!(motor.speed() > 0.5);
        for _ in 0..1000 {
            motor.run(0.0, false, 0.001);
        }
        assert_eq!(motor.speed(), 0.0);
    }
}
