//! Whole conversations: the input is a story of bytes that come or do not, of commands and of time. The host's session never
//! commands more than the tracks may run, what it believes of the base is finite, and neither side keeps ever more.

use core::fmt::Debug;

use inbye::base::arduino::{ArduinoDevice, ArduinoSession};
use inbye::base::native::{self, NativeDevice, NativeSession};
use inbye::base::roboclaw::{Request, RoboClawDevice, RoboClawSession};
use inbye::base::wheeltec::{self, WheeltecDevice, WheeltecSession};
use inbye::base::{
    BaseError, BaseSettings, DeviceProtocol, Faults, MachineState, Session, SessionCounters,
};
use inbye::geometry::Twist;
use inbye::robot::{PerTrack, TrackSpeeds};

use super::bytes::Bytes;
use super::frames::{any_native_report, any_wheeltec_report};

/// What one write of a session may be at most, bytes.
const LONGEST_WRITE: usize = 64;

/// What a side may hold, written out by `Debug`, characters: some hundred readings of a tenth of a second.
const MOST_HELD: usize = 40_000;

/// Properties of a base protocol, independent of its session and device.
trait Ear {
    /// The track speeds that a host's write asks for, m/s, and how far off rounding may have put them. All its bytes must
    /// make sense.
    fn asked(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)>;

    /// What a base may say, undamaged but of any content.
    fn said(&mut self, bytes: &mut Bytes, settings: &BaseSettings) -> Vec<u8>;
}

struct NativeEar;
struct WheeltecEar;
struct RoboClawEar(Option<Request>);
struct ArduinoEar;

/// Our own frames.
pub fn native(data: &[u8]) {
    let (settings, story) = opened(data);
    tell(NativeSession::new(settings), NativeDevice::new(settings), NativeEar, settings, story);
}

/// WHEELTEC's frames.
pub fn wheeltec(data: &[u8]) {
    let (settings, story) = opened(data);
    tell(
        WheeltecSession::new(settings),
        WheeltecDevice::new(&settings),
        WheeltecEar,
        settings,
        story,
    );
}

/// A `RoboClaw`.
pub fn roboclaw(data: &[u8]) {
    let (settings, story) = opened(data);
    tell(
        RoboClawSession::new(settings),
        RoboClawDevice::new(settings),
        RoboClawEar(None),
        settings,
        story,
    );
}

/// A `ROSArduinoBridge`.
pub fn arduino(data: &[u8]) {
    let (settings, story) = opened(data);
    tell(ArduinoSession::new(settings), ArduinoDevice::new(settings), ArduinoEar, settings, story);
}

/// A short story in all four, with settings that were found sound.
pub fn short(settings: BaseSettings) {
    // Faster and sharper than any track can, with all its numbers at 0.5 and the encoders on their way.
    let command: &[u8] = &[7, 0xFF, 0x7F, 0x10, 0x27];
    let turn = |count: u8| {
        let half = [0xF4, 1];
        let counts = [&[5, 0, count, 0][..], &[count, 0, 0, 0]].concat();
        [counts, half.repeat(4)].concat()
    };
    // Time, a write, its way there, the base's turn, and the way back.
    let round = |count: u8| [&[0, 4, 3, 4][..], &turn(count), &[6]].concat();
    // Between commands there is time for questions.
    let rounds = |from: u8| (from..from + 16).flat_map(round).collect::<Vec<u8>>();
    let story = [command, &rounds(0), command, &rounds(16)].concat();
    let bytes = || Bytes(&story);
    let (s, b) = (settings, bytes);
    tell(NativeSession::new(s), NativeDevice::new(s), NativeEar, s, b());
    tell(WheeltecSession::new(s), WheeltecDevice::new(&s), WheeltecEar, s, b());
    let ear = RoboClawEar(None);
    tell(RoboClawSession::new(s), RoboClawDevice::new(s), ear, s, b());
    tell(ArduinoSession::new(s), ArduinoDevice::new(s), ArduinoEar, s, b());
}

/// The settings that a story begins with, and the rest of it.
fn opened(data: &[u8]) -> (BaseSettings, Bytes<'_>) {
    let mut bytes = Bytes(data);
    let flags = bytes.byte();
    let flag = |bit: u8| flags >> bit & 1 != 0;
    let mut settings = BaseSettings::default()
        .swap_tracks(flag(0))
        .reversed(PerTrack::new(flag(1), flag(2)))
        .effective_width_ratio(if flag(3) { 1.6 } else { 1.0 })
        .ticks_per_m(if flag(4) {
            PerTrack::new(150.0, 1_000_000.0)
        } else {
            PerTrack::both(10_000.0)
        });
    settings.roboclaw.status_bytes = if flag(5) { 2 } else { 4 };
    settings.roboclaw.address = 0x80 | flags >> 5;
    settings.validate().expect("sound settings");
    (settings, bytes)
}

/// Two sides, the line between them, and the time.
struct Scene<S, P, E> {
    session: S,
    peer: P,
    ear: E,
    settings: BaseSettings,
    now_s: f64,
    to_base: Vec<u8>,
    to_host: Vec<u8>,
    counters: SessionCounters,
    /// What the base said last of itself, without having been asked.
    said: Vec<u8>,
}

fn tell<S: Session + Debug, P: DeviceProtocol + Debug, E: Ear>(
    session: Result<S, BaseError>,
    peer: Result<P, BaseError>,
    ear: E,
    settings: BaseSettings,
    mut story: Bytes,
) {
    let mut scene = Scene {
        session: session.expect("sound settings"),
        peer: peer.expect("sound settings"),
        ear,
        settings,
        now_s: 0.0,
        to_base: Vec::new(),
        to_host: Vec::new(),
        counters: SessionCounters::default(),
        said: Vec::new(),
    };
    while !story.0.is_empty() {
        scene.happens(&mut story);
        scene.check();
    }
    scene.end();
}

impl<S: Session + Debug, P: DeviceProtocol + Debug, E: Ear> Scene<S, P, E> {
    /// One event of the story.
    fn happens(&mut self, story: &mut Bytes) {
        match story.byte() % 14 {
            0 => {
                let times_s = [0.0, 0.000_1, 0.001, 0.005, 0.02, 0.1, 0.6, 3.0, 1e6];
                self.now_s += times_s[usize::from(story.byte()) % times_s.len()];
            }
            1 => {
                let count = usize::from(story.byte() % 64);
                self.session.receive(story.take(count), self.now_s);
            }
            2 => {
                let count = usize::from(story.byte() % 64);
                self.peer.receive(story.take(count), self.now_s);
            }
            3 => self.transmit(),
            4 => {
                let line = core::mem::take(&mut self.to_base);
                self.peer.receive(&line, self.now_s);
            }
            5 => self.turn(story),
            6 => {
                let line = core::mem::take(&mut self.to_host);
                self.session.receive(&line, self.now_s);
            }
            7 => {
                let wanted = Twist::new(story.plain(), story.plain());
                self.session.command(&wanted).expect("finite");
            }
            8 => {
                let wanted = Twist::new(story.real(), story.real());
                let taken = self.session.command(&wanted);
                assert_eq!(taken.is_ok(), wanted.is_finite(), "{wanted:?}");
            }
            9 => self.session.engage_stop(),
            10 => self.session.release(),
            11 => {
                self.said = self.ear.said(story, &self.settings);
                self.session.receive(&self.said, self.now_s);
            }
            12 => {
                for _ in 0..story.byte() {
                    self.session.receive(&self.said, self.now_s);
                }
            }
            _ => {
                let place = usize::from(story.byte());
                let mask = story.byte();
                for line in [&mut self.to_base, &mut self.to_host] {
                    let length = line.len().max(1);
                    if let Some(byte) = line.get_mut(place % length) {
                        *byte ^= mask;
                    }
                }
            }
        }
    }

    /// The session writes what it wants to, which is within the limits of the tracks.
    fn transmit(&mut self) {
        let mut line = Vec::new();
        self.session.transmit(self.now_s, &mut line);
        assert!(line.len() <= LONGEST_WRITE, "{line:?}");
        for (asked, rounding) in self.ear.asked(&line, &self.settings) {
            let most = self.settings.tracks.max_track_speed;
            let most = most + most * 1e-9 + rounding;
            let fastest = asked.left.abs().max(asked.right.abs());
            assert!(fastest <= most, "{asked:?} is above {most}");
        }
        self.to_base.extend(line);
        self.to_base.truncate(1000);
    }

    /// The base has its turn, in a state that the story tells.
    fn turn(&mut self, story: &mut Bytes) {
        let flags = story.byte();
        let machine = MachineState {
            encoder_counts: PerTrack::new(story.u16().into(), story.u32()),
            speeds: TrackSpeeds { left: story.plain(), right: story.plain() },
            yaw_rate: story.plain(),
            battery_v: story.plain(),
            faults: Faults::from_bits(if flags & 2 == 0 { 0 } else { story.u16() }),
            button_pressed: flags & 1 != 0,
        };
        let set = self.peer.step(self.now_s, &machine, &mut self.to_host);
        assert!(set.left.is_finite() && set.right.is_finite(), "{set:?} of {:?}", self.peer);
        self.to_host.truncate(1000);
    }

    /// What must hold at any time.
    fn check(&mut self) {
        if let Some(latest) = self.session.latest() {
            let feedback = &latest.feedback;
            assert!(latest.received_s <= self.now_s, "{latest:?}");
            assert!(feedback.twist.is_finite(), "{latest:?}");
            for number in [feedback.battery_v, feedback.yaw_rate].into_iter().flatten() {
                assert!(number.is_finite(), "{latest:?}");
            }
        }
        let (before, now) = (self.counters, self.session.counters());
        for (before, now) in [
            (before.dropped_bytes, now.dropped_bytes),
            (before.retries, now.retries),
            (before.unanswered, now.unanswered),
            (before.rejected_readings, now.rejected_readings),
        ] {
            assert!(before <= now, "a counter ran backwards");
        }
        self.counters = now;
    }

    /// Neither side holds much when all has been said.
    fn end(mut self) {
        self.turn(&mut Bytes(&[]));
        for held in [format!("{:?}", self.session), format!("{:?}", self.peer)] {
            assert!(held.len() <= MOST_HELD, "{} characters: {}...", held.len(), &held[..2000]);
        }
    }
}

/// Channels as tracks but for the sign, and half a unit of rounding as speed.
fn of_channels(rates: [f64; 2], settings: &BaseSettings) -> (TrackSpeeds, f64) {
    let [left, right] = if settings.swap_tracks { [rates[1], rates[0]] } else { rates };
    let speeds = TrackSpeeds {
        left: left / settings.ticks_per_m.left,
        right: right / settings.ticks_per_m.right,
    };
    let coarsest = settings.ticks_per_m.left.min(settings.ticks_per_m.right);
    (speeds, 0.5 / coarsest)
}

impl Ear for NativeEar {
    fn asked(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut decoder = native::Decoder::<native::Command>::default();
        decoder.push(line);
        let commands: Vec<native::Command> = decoder.by_ref().collect();
        assert_eq!(decoder.dropped_bytes(), 0);
        assert!(line.is_empty() || commands.len() == 1, "{line:?}");
        for command in &commands {
            let stands = command.speeds == [0, 0];
            assert!(stands || !command.stop && !command.release, "{command:?}");
        }
        let asked = commands.iter().map(|command| command.speeds.map(f64::from));
        asked.map(|rates| of_channels(rates, settings)).collect()
    }

    fn said(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        any_native_report(bytes).encode()
    }
}

impl Ear for WheeltecEar {
    fn asked(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut decoder = wheeltec::Decoder::<wheeltec::Command>::default();
        decoder.push(line);
        let commands: Vec<wheeltec::Command> = decoder.by_ref().collect();
        assert_eq!(commands.len() * wheeltec::COMMAND_LENGTH, line.len());
        let half_width = settings.track_width_m / 2.0;
        let asked = commands.iter().map(|command| {
            let turn = command.twist.angular * half_width;
            let speeds = TrackSpeeds {
                left: command.twist.linear - turn,
                right: command.twist.linear + turn,
            };
            (speeds, 0.000_5 * (1.0 + half_width))
        });
        asked.collect()
    }

    fn said(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        any_wheeltec_report(bytes).encode().to_vec()
    }
}

impl Ear for RoboClawEar {
    fn asked(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut asked = Vec::new();
        let mut rest = line;
        while !rest.is_empty() {
            let (request, length) = Request::decode(rest, settings.roboclaw.address)
                .expect("a packet that a controller obeys")
                .expect("a whole packet");
            if let Request::Drive(rates) = request {
                asked.push(of_channels(rates.map(f64::from), settings));
            }
            self.0 = Some(request);
            rest = &rest[length..];
        }
        asked
    }

    /// The answer to the last question.
    fn said(&mut self, bytes: &mut Bytes, settings: &BaseSettings) -> Vec<u8> {
        match self.0 {
            None => Vec::new(),
            Some(Request::SetTimeout(_) | Request::Drive(_)) => vec![0xFF],
            Some(request) => {
                let length = request.reply_length(settings.roboclaw.status_bytes);
                let data: [u8; 5] = bytes.array();
                let address = settings.roboclaw.address;
                request.encode_reply(address, data[..length - 2].to_vec())
            }
        }
    }
}

impl Ear for ArduinoEar {
    fn asked(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let interval_s = settings.arduino.pid_interval_s;
        let text = str::from_utf8(line).expect("text");
        assert!(text.is_empty() || text.ends_with('\r'), "{text:?}");
        let lines = text.split('\r').filter(|line| !matches!(*line, "" | "e"));
        let asked = lines.map(|line| {
            let rate = |text: &str| f64::from(text.parse::<i16>().expect("16 bits")) / interval_s;
            let numbers: Vec<f64> =
                line.strip_prefix("m ").expect("a command to run").split(' ').map(rate).collect();
            let rates = numbers.try_into().expect("two numbers");
            let (speeds, rounding) = of_channels(rates, settings);
            (speeds, rounding / interval_s)
        });
        asked.collect()
    }

    fn said(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        let [first, second] = [bytes.u32() as i32, bytes.u32() as i32];
        format!("{first} {second}\r\n").into_bytes()
    }
}
