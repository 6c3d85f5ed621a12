//! A session and a peer with a machine behind it, joined by a line in memory that delays and damages.

use std::collections::VecDeque;

use inbye::base::{BaseSettings, DeviceProtocol, Feedback, MachineState, Protocol, Session};
use inbye::geometry::Twist;
use inbye::robot::{PerTrack, TrackSpeeds};

/// One turn of both loops, seconds.
const TURN_S: f64 = 0.001;
/// Time constant of the motors, seconds.
const LAG_S: f64 = 0.03;

/// Where bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    ToBase,
    ToHost,
}

/// What happens to what is written at once.
pub type Damage = Box<dyn FnMut(Way, Vec<u8>) -> Vec<u8>>;

pub struct Conversation {
    pub session: Box<dyn Session>,
    pub peer: Box<dyn DeviceProtocol>,
    pub machine: MachineState,
    /// Whether the host runs at all.
    pub host_runs: bool,
    pub damage: Damage,
    pub delay_s: f64,
    pub now_s: f64,
    /// Speeds that the peer set at each turn.
    pub set: Vec<TrackSpeeds>,
    /// All that the host wrote.
    pub written: Vec<u8>,
    settings: BaseSettings,
    travel: PerTrack<f64>,
    to_base: VecDeque<(f64, Vec<u8>)>,
    to_host: VecDeque<(f64, Vec<u8>)>,
    turns: u64,
}

impl Conversation {
    /// Host and base that believe the same.
    pub fn new(protocol: Protocol, settings: BaseSettings) -> Self {
        Self::between(protocol, settings, settings)
    }

    /// A host that believes one thing of a base that is another.
    pub fn between(protocol: Protocol, host: BaseSettings, base: BaseSettings) -> Self {
        Self {
            session: protocol.session(host).expect("valid settings"),
            peer: protocol.device(base).expect("valid settings"),
            machine: MachineState {
                battery_v: 24.0,
                ..MachineState::default()
            },
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
            turns: 0,
        }
    }

    /// Lets the encoders begin elsewhere, in ticks.
    pub fn start_encoders_at(&mut self, ticks: f64) {
        self.travel = self.settings.ticks_per_m.map(|per_m| ticks / per_m);
        self.count();
    }

    /// Commands a motion twenty times a second.
    pub fn keep_on(&mut self, twist: Twist, time_s: f64) {
        let turns = (time_s / TURN_S).round() as usize;
        for turn in 0..turns {
            if turn % 50 == 0 {
                self.session.command(&twist).expect("a finite command");
            }
            self.turn();
        }
    }

    /// Lets time pass without commands.
    pub fn wait(&mut self, time_s: f64) {
        for _ in 0..(time_s / TURN_S).round() as usize {
            self.turn();
        }
    }

    pub fn feedback(&self) -> Feedback {
        self.session.latest().expect("feedback by now").feedback
    }

    /// How fast the tracks truly run.
    pub fn twist(&self) -> Twist {
        self.settings.drive().twist(&self.machine.speeds)
    }

    fn turn(&mut self) {
        self.turns += 1;
        self.now_s = TURN_S * self.turns as f64;
        let now_s = self.now_s;
        for bytes in arrived(&mut self.to_base, now_s) {
            self.peer.receive(&bytes, now_s);
        }
        let mut line = Vec::new();
        let set = self.peer.step(now_s, &self.machine, &mut line);
        self.set.push(set);
        self.write(Way::ToHost, line);
        self.roll(set);
        for bytes in arrived(&mut self.to_host, now_s) {
            self.session.receive(&bytes, now_s);
        }
        if self.host_runs {
            let mut line = Vec::new();
            self.session.transmit(now_s, &mut line);
            self.written.extend(&line);
            self.write(Way::ToBase, line);
        }
    }

    fn write(&mut self, way: Way, bytes: Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let bytes = (self.damage)(way, bytes);
        let due_s = self.now_s + self.delay_s;
        match way {
            Way::ToBase => self.to_base.push_back((due_s, bytes)),
            Way::ToHost => self.to_host.push_back((due_s, bytes)),
        }
    }

    fn count(&mut self) {
        self.machine.encoder_counts = self
            .travel
            .zip(self.settings.ticks_per_m, |travel_m, per_m| {
                (travel_m * per_m).floor() as i64 as u32
            });
    }

    fn roll(&mut self, set: TrackSpeeds) {
        let share = TURN_S / LAG_S;
        let speeds = PerTrack::from(self.machine.speeds)
            .zip(set.into(), |now, set| now + share * (set - now));
        self.machine.speeds = speeds.into();
        self.travel = self
            .travel
            .zip(speeds, |travel_m, speed| travel_m + speed * TURN_S);
        self.count();
        self.machine.yaw_rate = self.twist().angular;
    }
}

fn arrived(queue: &mut VecDeque<(f64, Vec<u8>)>, now_s: f64) -> Vec<Vec<u8>> {
    let count = queue.iter().take_while(|(at_s, _)| *at_s <= now_s).count();
    queue.drain(..count).map(|(_, bytes)| bytes).collect()
}
