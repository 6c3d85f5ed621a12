//! An emulated base without hardware or I/O: a lower controller, the machine it drives, and injected faults.
//!
//! Bytes and time are parameters. The same bytes at the same times with the same seed give the same motion and answers.

mod injected_fault;
mod lidar_faults;
mod plant;

pub use injected_fault::{InjectedFault, ScheduledFault};
pub use lidar_faults::LidarFaultInjector;
pub(crate) use plant::standard_normal;

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::plant::Plant;
use super::{
    BaseError, BaseSettings, Bumper, CommandStats, DeviceProtocol, MachineState, Protocol, Tilt,
};
use crate::geometry::{Pose, Twist};
use crate::robot::{PerTrack, TrackSpeeds};

/// Delay of the host's bytes while reads are slow, seconds: longer than every timeout of a host.
const SLOW_READ_S: f64 = 0.3;

/// Bursts of garbage per second in each direction.
const BURSTS_PER_S: f64 = 10.0;

/// Longest burst, bytes: more than any frame header, less than a frame.
const MAX_BURST: usize = 12;

/// One of this many bytes has one bit flipped.
const BYTES_PER_FLIP: u32 = 200;

/// Roll of a base that lies on its side, rad.
const TILTED_ROLL: f64 = 0.6;

/// Set speed below which a lagging motor stands, m/s.
const STANDSTILL_M_S: f64 = 0.005;

/// Error of a biased gyro, rad/s: twice the difference from the tracks that counts as slip.
const GYRO_BIAS_RAD_S: f64 = 0.8;

/// Voltage of a low battery.
const LOW_BATTERY_V: f64 = 15.0;

/// Delay of late motors, seconds.
const LATE_MOTORS_S: f64 = 0.3;

/// A base that was switched on at time zero and stands.
pub struct Emulator {
    protocol: Protocol,
    /// The settings that the controller knows.
    settings: BaseSettings,
    device: Box<dyn DeviceProtocol>,
    /// Time at which the controller got power, and whether it has power.
    powered_s: f64,
    has_power: bool,
    plant: Plant,
    faults: Vec<ScheduledFault>,
    /// Delayed bytes of the host, each with the time to read them.
    delayed: VecDeque<(f64, Vec<u8>)>,
    rng: Pcg64Mcg,
    last_s: f64,
    /// Set speeds of the controller, and those that its motors follow.
    set: TrackSpeeds,
    lagged: TrackSpeeds,
    /// Set speeds of the last [`LATE_MOTORS_S`], each with its time, while the motors are late.
    late: VecDeque<(f64, TrackSpeeds)>,
    motor_lag_s: f64,
    deadband_m_s: f64,
    /// Whether the present glitch was reported.
    has_glitched: bool,
}

impl Emulator {
    /// Creates a base with this protocol and these settings.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(protocol: Protocol, settings: BaseSettings, seed: u64) -> Result<Self, BaseError> {
        Ok(Self {
            protocol,
            settings,
            device: protocol.device(settings)?,
            powered_s: 0.0,
            has_power: true,
            plant: Plant::new(settings, seed),
            faults: Vec::new(),
            delayed: VecDeque::new(),
            // Independent of the stream of the gyro's noise.
            rng: Pcg64Mcg::seed_from_u64(seed ^ 0x510e_527f_ade6_82d1),
            last_s: 0.0,
            set: TrackSpeeds::default(),
            lagged: TrackSpeeds::default(),
            late: VecDeque::new(),
            motor_lag_s: 0.0,
            deadband_m_s: 0.0,
            has_glitched: false,
        })
    }

    /// Sets a further lag of the motors behind their set speeds, seconds: a time constant, zero for none. The motors have one
    /// of about 0.05 s.
    #[must_use]
    pub const fn with_motor_lag(mut self, lag_s: f64) -> Self {
        self.motor_lag_s = lag_s;
        self
    }

    /// Sets the true effective track width as a multiple of that in the settings, above zero.
    #[must_use]
    pub fn with_width_ratio(mut self, ratio: f64) -> Self {
        self.plant.widen(ratio);
        self
    }

    /// Sets the mean share of the travel of each track that is lost on the ground, 0 to below 1. It varies with the seed.
    #[must_use]
    pub const fn with_slip(mut self, share: f64) -> Self {
        self.plant.slip(share);
        self
    }

    /// Sets the set speed of a track below which its motor gets no voltage, m/s.
    #[must_use]
    pub const fn with_deadband(mut self, deadband_m_s: f64) -> Self {
        self.deadband_m_s = deadband_m_s;
        self
    }

    /// Schedules a fault; any number may overlap.
    pub fn schedule(&mut self, fault: ScheduledFault) {
        self.faults.push(fault);
    }

    /// Takes bytes of the host, in pieces of any size.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) {
        let is_deaf = |fault| self.has(fault, now_s);
        let deaf = [InjectedFault::Wedge, InjectedFault::Reboot, InjectedFault::LineCut];
        if bytes.is_empty() || deaf.into_iter().any(is_deaf) {
            return;
        }
        let mut bytes = bytes.to_vec();
        self.flip(&mut bytes, now_s);
        let is_slow = self.has(InjectedFault::SlowReads, now_s);
        if is_slow || !self.delayed.is_empty() {
            let due_s = now_s + if is_slow { SLOW_READ_S } else { 0.0 };
            self.delayed.push_back((due_s, bytes));
        } else {
            self.device.receive(&bytes, now_s - self.powered_s);
        }
    }

    /// Advances the base to a time and appends the bytes that it writes to `line`. Time never runs backwards; a typical controller
    /// needs steps of 10 ms or less.
    pub fn step(&mut self, now_s: f64, line: &mut Vec<u8>) {
        while self.delayed.front().is_some_and(|(due_s, _)| *due_s <= now_s) {
            if let Some((_, bytes)) = self.delayed.pop_front() {
                self.device.receive(&bytes, now_s - self.powered_s);
            }
        }
        let elapsed_s = now_s - self.last_s;
        self.last_s = now_s;
        let faults: Vec<InjectedFault> = self.active(now_s).collect();
        self.switch_power(!faults.contains(&InjectedFault::Reboot), now_s);
        if !self.has_power {
            self.run_plant(elapsed_s, &faults);
            return;
        }
        if faults.contains(&InjectedFault::Wedge) {
            self.run_plant(elapsed_s, &faults);
            return;
        }
        let noise = self.burst(elapsed_s, now_s);
        self.device.receive(&noise, now_s - self.powered_s);
        let machine = self.machine();
        let mut output = Vec::new();
        let set = self.device.step(now_s - self.powered_s, &machine, &mut output);
        self.set_speeds(set, now_s, &faults);
        self.run_plant(elapsed_s, &faults);
        let glitches = faults.contains(&InjectedFault::StopGlitch);
        self.has_glitched = glitches && (self.has_glitched || !output.is_empty());
        if faults.contains(&InjectedFault::CorruptReports)
            && let Some(byte) = output.first_mut()
        {
            *byte ^= 1 << self.rng.random_range(0..8);
        }
        output.extend(self.burst(elapsed_s, now_s));
        self.flip(&mut output, now_s);
        let is_mute = [InjectedFault::Silence, InjectedFault::LineCut];
        if !is_mute.iter().any(|fault| faults.contains(fault)) {
            line.extend(output);
        }
    }

    /// Switches the controller on or off. A controller that gets power has no command, no count and no stop.
    fn switch_power(&mut self, is_on: bool, now_s: f64) {
        if self.has_power && !is_on {
            self.set = TrackSpeeds::default();
            self.plant.reset_counters();
        }
        // The settings were valid before.
        if !self.has_power
            && is_on
            && let Ok(device) = self.protocol.device(self.settings)
        {
            (self.device, self.powered_s) = (device, now_s);
        }
        self.has_power = is_on;
    }

    /// Takes the set speeds of the controller, as the active faults let the motors have them.
    fn set_speeds(&mut self, set: TrackSpeeds, now_s: f64, faults: &[InjectedFault]) {
        if faults.contains(&InjectedFault::IgnoredCommands) {
            return;
        }
        let deadband = self.deadband_m_s;
        let set = set.map(|speed| if speed.abs() < deadband { 0.0 } else { speed });
        let is_late = faults.contains(&InjectedFault::LateMotors);
        if is_late {
            self.late.push_back((now_s, set));
        } else {
            self.late.clear();
            self.set = set;
        }
        while self.late.front().is_some_and(|(since_s, _)| now_s - since_s >= LATE_MOTORS_S) {
            self.set = self.late.pop_front().map_or(self.set, |(_, set)| set);
        }
        if faults.contains(&InjectedFault::IgnoredTurns) {
            self.set = PerTrack::both(f64::midpoint(self.set.left, self.set.right));
        }
    }

    /// State of the machine as its controller measures it.
    #[must_use]
    pub fn machine(&self) -> MachineState {
        let has = |fault| self.has(fault, self.last_s);
        let roll = if has(InjectedFault::Tilt) { TILTED_ROLL } else { 0.0 };
        let machine = self.plant.machine();
        let bias = if has(InjectedFault::GyroBiased) { GYRO_BIAS_RAD_S } else { 0.0 };
        MachineState {
            yaw_rate: machine.yaw_rate + bias,
            battery_v: if has(InjectedFault::LowBattery) {
                LOW_BATTERY_V
            } else {
                machine.battery_v
            },
            button_pressed: has(InjectedFault::Button)
                || has(InjectedFault::StopGlitch) && !self.has_glitched,
            tilt: Tilt { roll, pitch: 0.0 },
            bumper: Bumper { left: has(InjectedFault::Bumper), right: false },
            cliff: has(InjectedFault::Cliff),
            ..machine
        }
    }

    /// Moves the machine for a time, seconds, with the motors' lag.
    fn run_plant(&mut self, elapsed_s: f64, faults: &[InjectedFault]) {
        self.lagged = if self.motor_lag_s > 0.0 {
            let share = 1.0 - libm::exp(-elapsed_s / self.motor_lag_s);
            self.lagged.zip(self.set, |lagged, set| {
                let next = lagged + share * (set - lagged);
                if set == 0.0 && next.abs() < STANDSTILL_M_S { 0.0 } else { next }
            })
        } else {
            self.set
        };
        self.plant.run(elapsed_s, self.lagged, faults);
    }

    /// Statistics of the commands received so far.
    #[must_use]
    pub fn command_stats(&self) -> CommandStats {
        self.device.command_stats()
    }

    /// True pose relative to the pose at power-on.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        self.plant.pose()
    }

    /// True velocity.
    #[must_use]
    pub fn twist(&self) -> Twist {
        self.plant.twist()
    }

    /// Distance travelled by the base's centre, forwards and backwards, metres.
    #[must_use]
    pub const fn travelled_m(&self) -> f64 {
        self.plant.travelled_m()
    }

    fn active(&self, now_s: f64) -> impl Iterator<Item = InjectedFault> + '_ {
        let is_active = move |scheduled: &&ScheduledFault| scheduled.is_active(now_s);
        self.faults.iter().filter(is_active).map(|scheduled| scheduled.fault)
    }

    /// Whether a fault is active at a time, seconds.
    #[must_use]
    pub fn has(&self, fault: InjectedFault, now_s: f64) -> bool {
        self.active(now_s).any(|active| active == fault)
    }

    /// Garbage of a time step, usually none.
    fn burst(&mut self, elapsed_s: f64, now_s: f64) -> Vec<u8> {
        let chance = (BURSTS_PER_S * elapsed_s).clamp(0.0, 1.0);
        if !self.has(InjectedFault::Garbage, now_s) || !self.rng.random_bool(chance) {
            return Vec::new();
        }
        let length = self.rng.random_range(1..=MAX_BURST);
        (0..length).map(|_| self.rng.random()).collect()
    }

    fn flip(&mut self, bytes: &mut [u8], now_s: f64) {
        if self.has(InjectedFault::BitFlips, now_s) {
            flip_bits(bytes, &mut self.rng);
        }
    }
}

/// Flips one bit of one in [`BYTES_PER_FLIP`] bytes.
fn flip_bits(bytes: &mut [u8], rng: &mut Pcg64Mcg) {
    for byte in bytes {
        if rng.random_range(0..BYTES_PER_FLIP) == 0 {
            *byte ^= 1 << rng.random_range(0..8);
        }
    }
}
