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
use crate::robot::TrackSpeeds;

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

/// A base that was switched on at time zero and stands.
pub struct Emulator {
    device: Box<dyn DeviceProtocol>,
    plant: Plant,
    faults: Vec<ScheduledFault>,
    /// Delayed bytes of the host, each with the time to read them.
    delayed: VecDeque<(f64, Vec<u8>)>,
    rng: Pcg64Mcg,
    last_s: f64,
    /// Set speeds of the controller, and those that its motors follow.
    set: TrackSpeeds,
    lagged: TrackSpeeds,
    motor_lag_s: f64,
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
            device: protocol.device(settings)?,
            plant: Plant::new(settings, seed),
            faults: Vec::new(),
            delayed: VecDeque::new(),
            // Independent of the stream of the gyro's noise.
            rng: Pcg64Mcg::seed_from_u64(seed ^ 0x510e_527f_ade6_82d1),
            last_s: 0.0,
            set: TrackSpeeds::default(),
            lagged: TrackSpeeds::default(),
            motor_lag_s: 0.0,
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

    /// Schedules a fault; any number may overlap.
    pub fn schedule(&mut self, fault: ScheduledFault) {
        self.faults.push(fault);
    }

    /// Takes bytes of the host, in pieces of any size.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() || self.has(InjectedFault::Wedge, now_s) {
            return;
        }
        let mut bytes = bytes.to_vec();
        self.flip(&mut bytes, now_s);
        let is_slow = self.has(InjectedFault::SlowReads, now_s);
        if is_slow || !self.delayed.is_empty() {
            let due_s = now_s + if is_slow { SLOW_READ_S } else { 0.0 };
            self.delayed.push_back((due_s, bytes));
        } else {
            self.device.receive(&bytes, now_s);
        }
    }

    /// Advances the base to a time and appends the bytes that it writes to `line`. Time never runs backwards; a typical controller
    /// needs steps of 10 ms or less.
    pub fn step(&mut self, now_s: f64, line: &mut Vec<u8>) {
        while self.delayed.front().is_some_and(|(due_s, _)| *due_s <= now_s) {
            if let Some((_, bytes)) = self.delayed.pop_front() {
                self.device.receive(&bytes, now_s);
            }
        }
        let elapsed_s = now_s - self.last_s;
        self.last_s = now_s;
        let faults: Vec<InjectedFault> = self.active(now_s).collect();
        if faults.contains(&InjectedFault::Wedge) {
            self.run_plant(elapsed_s, &faults);
            return;
        }
        let noise = self.burst(elapsed_s, now_s);
        self.device.receive(&noise, now_s);
        let machine = self.machine();
        let mut output = Vec::new();
        let set = self.device.step(now_s, &machine, &mut output);
        if !faults.contains(&InjectedFault::IgnoredCommands) {
            self.set = set;
        }
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
        if !self.has(InjectedFault::Silence, now_s) {
            line.extend(output);
        }
    }

    /// State of the machine as its controller measures it.
    #[must_use]
    pub fn machine(&self) -> MachineState {
        let has = |fault| self.has(fault, self.last_s);
        let roll = if has(InjectedFault::Tilt) { TILTED_ROLL } else { 0.0 };
        MachineState {
            button_pressed: has(InjectedFault::Button)
                || has(InjectedFault::StopGlitch) && !self.has_glitched,
            tilt: Tilt { roll, pitch: 0.0 },
            bumper: Bumper { left: has(InjectedFault::Bumper), right: false },
            cliff: has(InjectedFault::Cliff),
            ..self.plant.machine()
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
        if !self.has(InjectedFault::BitFlips, now_s) {
            return;
        }
        for byte in bytes {
            if self.rng.random_range(0..BYTES_PER_FLIP) == 0 {
                *byte ^= 1 << self.rng.random_range(0..8);
            }
        }
    }
}
