//! An emulated base without hardware or I/O: a lower controller, the machine it drives, and injected faults.
//!
//! Bytes and time are parameters. The same bytes at the same times with the same seed give the same motion and answers.

mod injected_fault;
mod plant;

pub use injected_fault::{InjectedFault, ScheduledFault};
pub(crate) use plant::standard_normal;

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::plant::Plant;
use super::{BaseError, BaseSettings, CommandStats, DeviceProtocol, MachineState, Protocol};
use crate::geometry::{Pose, Twist};

/// Delay of the host's bytes while reads are slow, seconds: longer than every timeout of a host.
const SLOW_READ_S: f64 = 0.3;

/// Bursts of garbage per second in each direction.
const BURSTS_PER_S: f64 = 10.0;

/// Longest burst, bytes: more than any frame header, less than a frame.
const MAX_BURST: usize = 12;

/// One of this many bytes has one bit flipped.
const BYTES_PER_FLIP: u32 = 200;

/// A base that was switched on at time zero and stands.
pub struct Emulator {
    device: Box<dyn DeviceProtocol>,
    plant: Plant,
    faults: Vec<ScheduledFault>,
    /// Delayed bytes of the host, each with the time to read them.
    delayed: VecDeque<(f64, Vec<u8>)>,
    rng: Pcg64Mcg,
    last_s: f64,
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
        })
    }

    /// Schedules a fault; any number may overlap.
    pub fn schedule(&mut self, fault: ScheduledFault) {
        self.faults.push(fault);
    }

    /// Takes bytes of the host, in pieces of any size.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() {
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
        let noise = self.burst(elapsed_s, now_s);
        self.device.receive(&noise, now_s);
        let machine = self.machine();
        let mut output = Vec::new();
        let set = self.device.step(now_s, &machine, &mut output);
        let faults: Vec<InjectedFault> = self.active(now_s).collect();
        self.plant.run(elapsed_s, set, &faults);
        output.extend(self.burst(elapsed_s, now_s));
        self.flip(&mut output, now_s);
        if !self.has(InjectedFault::Silence, now_s) {
            line.extend(output);
        }
    }

    /// State of the machine as its controller measures it.
    #[must_use]
    pub fn machine(&self) -> MachineState {
        let button_pressed = self.has(InjectedFault::Button, self.last_s);
        MachineState { button_pressed, ..self.plant.machine() }
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

    fn has(&self, fault: InjectedFault, now_s: f64) -> bool {
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
