//! A session and a device with a simulated machine, linked by a line in memory that delays and damages bytes.

use std::collections::VecDeque;

use inbye::base::{BaseSettings, DeviceProtocol, Feedback, MachineState, Protocol, Session};
use inbye::geometry::Twist;
use inbye::robot::{PerTrack, TrackSpeeds};

/// Simulation step, seconds.
const STEP_S: f64 = 0.001;
/// Time constant of the motors, seconds.
const LAG_S: f64 = 0.03;

/// Direction of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    ToBase,
    ToHost,
}

/// Damages the bytes of one write.
pub type Damage = Box<dyn FnMut(Direction, Vec<u8>) -> Vec<u8>>;

pub struct SimulatedLink {
    pub session: Box<dyn Session>,
    pub device: Box<dyn DeviceProtocol>,
    pub machine: MachineState,
    /// Whether the host transmits.
    pub host_runs: bool,
    pub damage: Damage,
    pub delay_s: f64,
    pub now_s: f64,
    /// Speeds that the device set in each step.
    pub set: Vec<TrackSpeeds>,
    /// All bytes that the host wrote.
    pub written: Vec<u8>,
    settings: BaseSettings,
    travel: PerTrack<f64>,
    to_base: VecDeque<(f64, Vec<u8>)>,
    to_host: VecDeque<(f64, Vec<u8>)>,
    steps: u64,
}

impl SimulatedLink {
    /// Links a host and a base with the same settings.
    pub fn new(protocol: Protocol, settings: BaseSettings) -> Self {
        Self::between(protocol, settings, settings)
    }

    /// Links a host and a base with different settings.
    pub fn between(protocol: Protocol, host: BaseSettings, base: BaseSettings) -> Self {
        Self {
            session: protocol.session(host).expect("valid settings"),
            device: protocol.device(base).expect("valid settings"),
            machine: MachineState { battery_v: 24.0, ..MachineState::default() },
            host_runs: true,
            damage: Box::new(|_, bytes| bytes),
            delay_s: 0.003,
            now_s: 0.0,
            set: Vec::new(),
            written: Vec::new(),
            settings: base,
            travel: PerTrack::both(0.0),
            to_base: VecDeque::new(),
            to_host: VecDeque::new(),
            steps: 0,
        }
    }

    /// Sets the encoder counts.
    pub fn start_encoders_at(&mut self, ticks: f64) {
        self.travel = self.settings.ticks_per_m.map(|per_m| ticks / per_m);
        self.count();
    }

    /// Commands a motion twenty times per second.
    pub fn drive_for(&mut self, twist: Twist, time_s: f64) {
        let steps = (time_s / STEP_S).round() as usize;
        for step in 0..steps {
            if step % 50 == 0 {
                self.session.command(&twist).expect("a finite command");
            }
            self.step();
        }
    }

    /// Advances the time without commands.
    pub fn wait(&mut self, time_s: f64) {
        for _ in 0..(time_s / STEP_S).round() as usize {
            self.step();
        }
    }

    pub fn feedback(&self) -> Feedback {
        self.session.latest().expect("feedback by now").feedback
    }

    /// True velocity.
    pub fn twist(&self) -> Twist {
        self.settings.drive().twist(&self.machine.speeds)
    }

    fn step(&mut self) {
        self.steps += 1;
        self.now_s = STEP_S * self.steps as f64;
        let now_s = self.now_s;
        for bytes in arrived(&mut self.to_base, now_s) {
            self.device.receive(&bytes, now_s);
        }
        let mut line = Vec::new();
        let set = self.device.step(now_s, &self.machine, &mut line);
        self.set.push(set);
        self.write(Direction::ToHost, line);
        self.move_machine(set);
        for bytes in arrived(&mut self.to_host, now_s) {
            self.session.receive(&bytes, now_s);
        }
        if self.host_runs {
            let mut line = Vec::new();
            self.session.transmit(now_s, &mut line);
            self.written.extend(&line);
            self.write(Direction::ToBase, line);
        }
    }

    fn write(&mut self, direction: Direction, bytes: Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let bytes = (self.damage)(direction, bytes);
        let due_s = self.now_s + self.delay_s;
        match direction {
            Direction::ToBase => self.to_base.push_back((due_s, bytes)),
            Direction::ToHost => self.to_host.push_back((due_s, bytes)),
        }
    }

    fn count(&mut self) {
        self.machine.encoder_counts =
            self.travel.zip(self.settings.ticks_per_m, |travel_m, per_m| {
                (travel_m * per_m).floor() as i64 as u32
            });
    }

    fn move_machine(&mut self, set: TrackSpeeds) {
        let share = STEP_S / LAG_S;
        let speeds = self.machine.speeds.zip(set, |now, set| now + share * (set - now));
        self.machine.speeds = speeds;
        self.travel = self.travel.zip(speeds, |travel_m, speed| travel_m + speed * STEP_S);
        self.count();
        self.machine.yaw_rate = self.twist().angular;
    }
}

fn arrived(queue: &mut VecDeque<(f64, Vec<u8>)>, now_s: f64) -> Vec<Vec<u8>> {
    let count = queue.iter().take_while(|(at_s, _)| *at_s <= now_s).count();
    queue.drain(..count).map(|(_, bytes)| bytes).collect()
}
