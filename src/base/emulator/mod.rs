//! A whole base without hardware and without I/O: a lower controller, the machine behind it, and what may go wrong.
//!
//! Bytes and time are parameters. The same bytes at the same times and the same seed give the same motion and the same
//! bytes back.

mod motor;
mod plant;
mod trouble;

pub use trouble::{PlannedTrouble, Trouble};

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::plant::Plant;
use super::peer::Orders;
use super::{BaseError, BaseSettings, Machine, Peer, Protocol};
use crate::geometry::{Pose, Twist};

/// How late the host's bytes are read while reads are slow, seconds: beyond every bound that a host waits.
const LATE_S: f64 = 0.3;

/// Bursts of garbage a second, each way.
const BURSTS_PER_S: f64 = 10.0;

/// Longest burst, bytes: more than any frame's beginning, less than a frame.
const LONGEST_BURST: usize = 12;

/// One of so many bytes is flipped in one bit.
const BYTES_PER_FLIP: u32 = 200;

/// A controller that was switched on at time zero, on a base that stands.
pub struct Emulator {
    peer: Box<dyn Peer>,
    plant: Plant,
    troubles: Vec<PlannedTrouble>,
    /// The host's bytes that are yet to be read, each with the time when they are.
    late: VecDeque<(f64, Vec<u8>)>,
    rng: Pcg64Mcg,
    last_s: f64,
}

impl Emulator {
    /// A base that speaks a protocol and is as the settings say.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(protocol: Protocol, settings: BaseSettings, seed: u64) -> Result<Self, BaseError> {
        Ok(Self {
            peer: protocol.peer(settings)?,
            plant: Plant::new(settings, seed),
            troubles: Vec::new(),
            late: VecDeque::new(),
            // Not the stream of the gyro's noise.
            rng: Pcg64Mcg::seed_from_u64(seed ^ 0x510e_527f_ade6_82d1),
            last_s: 0.0,
        })
    }

    /// Adds something that goes wrong at its time; any number may at once.
    pub fn plan(&mut self, trouble: PlannedTrouble) {
        self.troubles.push(trouble);
    }

    /// Takes the host's bytes, in pieces of any size.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() {
            return;
        }
        let mut bytes = bytes.to_vec();
        self.flip(&mut bytes, now_s);
        let is_slow = self.has(Trouble::SlowReads, now_s);
        if is_slow || !self.late.is_empty() {
            let due_s = now_s + if is_slow { LATE_S } else { 0.0 };
            self.late.push_back((due_s, bytes));
        } else {
            self.peer.receive(&bytes, now_s);
        }
    }

    /// Lets the time pass until now, and appends what the base writes. Time never runs backwards; steps of 10 ms or less
    /// make a controller of usual quickness.
    pub fn step(&mut self, now_s: f64, line: &mut Vec<u8>) {
        while self.late.front().is_some_and(|(due_s, _)| *due_s <= now_s) {
            if let Some((_, bytes)) = self.late.pop_front() {
                self.peer.receive(&bytes, now_s);
            }
        }
        let elapsed_s = now_s - self.last_s;
        self.last_s = now_s;
        let noise = self.burst(elapsed_s, now_s);
        self.peer.receive(&noise, now_s);
        let machine = self.machine();
        let mut said = Vec::new();
        let set = self.peer.step(now_s, &machine, &mut said);
        let now: Vec<Trouble> = self.active(now_s).collect();
        self.plant.run(elapsed_s, set, &now);
        said.extend(self.burst(elapsed_s, now_s));
        self.flip(&mut said, now_s);
        if !self.has(Trouble::Silence, now_s) {
            line.extend(said);
        }
    }

    /// The machine as its controller measures it.
    #[must_use]
    pub fn machine(&self) -> Machine {
        let button_pressed = self.has(Trouble::Button, self.last_s);
        Machine {
            button_pressed,
            ..self.plant.machine()
        }
    }

    /// What the controller was told so far.
    #[must_use]
    pub fn orders(&self) -> Orders {
        self.peer.orders()
    }

    /// Where the base truly is, of the pose at which it was switched on.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        self.plant.pose()
    }

    /// How fast it truly moves.
    #[must_use]
    pub fn twist(&self) -> Twist {
        self.plant.twist()
    }

    /// Way of its middle so far, either way, metres.
    #[must_use]
    pub const fn travelled_m(&self) -> f64 {
        self.plant.travelled_m()
    }

    fn active(&self, now_s: f64) -> impl Iterator<Item = Trouble> + '_ {
        let holds = move |planned: &&PlannedTrouble| planned.holds(now_s);
        self.troubles
            .iter()
            .filter(holds)
            .map(|planned| planned.trouble)
    }

    fn has(&self, trouble: Trouble, now_s: f64) -> bool {
        self.active(now_s).any(|active| active == trouble)
    }

    /// Garbage of a time, mostly none.
    fn burst(&mut self, elapsed_s: f64, now_s: f64) -> Vec<u8> {
        let chance = (BURSTS_PER_S * elapsed_s).clamp(0.0, 1.0);
        if !self.has(Trouble::Garbage, now_s) || !self.rng.random_bool(chance) {
            return Vec::new();
        }
        let length = self.rng.random_range(1..=LONGEST_BURST);
        (0..length).map(|_| self.rng.random()).collect()
    }

    fn flip(&mut self, bytes: &mut [u8], now_s: f64) {
        if !self.has(Trouble::BitFlips, now_s) {
            return;
        }
        for byte in bytes {
            if self.rng.random_range(0..BYTES_PER_FLIP) == 0 {
                *byte ^= 1 << self.rng.random_range(0..8);
            }
        }
    }
}
