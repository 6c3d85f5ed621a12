//! Whole conversations: the input is a script of received and lost bytes, commands and time. The host's session never commands
//! more than the limit of the tracks, its feedback is finite, and the memory of both sides is bounded.

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

/// Longest write of a session, bytes.
const LONGEST_WRITE: usize = 64;

/// Largest state of a side as text of `Debug`, characters: some hundred readings of a tenth of a second.
const MOST_HELD: usize = 40_000;

/// Properties of a base protocol, independent of its session and device.
trait ProtocolModel {
    /// The track speeds that a host's write commands, m/s, and their rounding error. All its bytes must be valid.
    fn commanded(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)>;

    /// An undamaged message of a base with arbitrary content.
    fn message(&mut self, bytes: &mut Bytes, settings: &BaseSettings) -> Vec<u8>;
}

struct NativeModel;
struct WheeltecModel;
struct RoboClawModel(Option<Request>);
struct ArduinoModel;

/// Native frames.
pub fn native(data: &[u8]) {
    let (settings, script) = settings_of(data);
    converse(
        NativeSession::new(settings),
        NativeDevice::new(settings),
        NativeModel,
        settings,
        script,
    );
}

/// WHEELTEC's frames.
pub fn wheeltec(data: &[u8]) {
    let (settings, script) = settings_of(data);
    converse(
        WheeltecSession::new(settings),
        WheeltecDevice::new(&settings),
        WheeltecModel,
        settings,
        script,
    );
}

/// A `RoboClaw`.
pub fn roboclaw(data: &[u8]) {
    let (settings, script) = settings_of(data);
    converse(
        RoboClawSession::new(settings),
        RoboClawDevice::new(settings),
        RoboClawModel(None),
        settings,
        script,
    );
}

/// A `ROSArduinoBridge`.
pub fn arduino(data: &[u8]) {
    let (settings, script) = settings_of(data);
    converse(
        ArduinoSession::new(settings),
        ArduinoDevice::new(settings),
        ArduinoModel,
        settings,
        script,
    );
}

/// A short conversation in all four protocols, with valid settings.
pub fn short_conversations(settings: BaseSettings) {
    // A command beyond the limits of the tracks; a base whose numbers are all 0.5 and whose encoders advance.
    let command: &[u8] = &[7, 0xFF, 0x7F, 0x10, 0x27];
    let turn = |count: u8| {
        let half = [0xF4, 1];
        let counts = [&[5, 0, count, 0][..], &[count, 0, 0, 0]].concat();
        [counts, half.repeat(4)].concat()
    };
    // Time passes, the session writes, its bytes arrive, the base acts, and its bytes arrive.
    let round = |count: u8| [&[0, 4, 3, 4][..], &turn(count), &[6]].concat();
    // Between commands there is time for requests.
    let rounds = |from: u8| (from..from + 16).flat_map(round).collect::<Vec<u8>>();
    let script = [command, &rounds(0), command, &rounds(16)].concat();
    let bytes = || Bytes(&script);
    let (s, b) = (settings, bytes);
    converse(NativeSession::new(s), NativeDevice::new(s), NativeModel, s, b());
    converse(WheeltecSession::new(s), WheeltecDevice::new(&s), WheeltecModel, s, b());
    let model = RoboClawModel(None);
    converse(RoboClawSession::new(s), RoboClawDevice::new(s), model, s, b());
    converse(ArduinoSession::new(s), ArduinoDevice::new(s), ArduinoModel, s, b());
}

/// The settings at the beginning of a script, and the rest of the script.
fn settings_of(data: &[u8]) -> (BaseSettings, Bytes<'_>) {
    let mut bytes = Bytes(data);
    let flags = bytes.byte();
    let flag = |bit: u8| flags >> bit & 1 != 0;
    let mut settings = BaseSettings::default()
        .swap_tracks(flag(0))
        .reversed(PerTrack::new(flag(1), flag(2)))
        .effective_width_ratio(if flag(3) { 1.6 } else { 1.0 })
        .ticks_per_m(if flag(4) {
            PerTrack::new(150.0, 700_000.0)
        } else {
            PerTrack::both(10_000.0)
        });
    settings.roboclaw.status_bytes = if flag(5) { 2 } else { 4 };
    settings.roboclaw.address = 0x80 | flags >> 5;
    settings.validate().expect("sound settings");
    (settings, bytes)
}

/// Host, base, the line between them, and the time.
struct Conversation<S, P, E> {
    session: S,
    device: P,
    model: E,
    settings: BaseSettings,
    now_s: f64,
    to_base: Vec<u8>,
    to_host: Vec<u8>,
    counters: SessionCounters,
    /// The last message of the base that answers no request.
    last_message: Vec<u8>,
}

fn converse<S: Session + Debug, P: DeviceProtocol + Debug, E: ProtocolModel>(
    session: Result<S, BaseError>,
    device: Result<P, BaseError>,
    model: E,
    settings: BaseSettings,
    mut script: Bytes,
) {
    let mut conversation = Conversation {
        session: session.expect("sound settings"),
        device: device.expect("sound settings"),
        model,
        settings,
        now_s: 0.0,
        to_base: Vec::new(),
        to_host: Vec::new(),
        counters: SessionCounters::default(),
        last_message: Vec::new(),
    };
    while !script.0.is_empty() {
        conversation.run_event(&mut script);
        conversation.check();
    }
    conversation.end();
}

impl<S: Session + Debug, P: DeviceProtocol + Debug, E: ProtocolModel> Conversation<S, P, E> {
    /// Runs one event of the script.
    fn run_event(&mut self, script: &mut Bytes) {
        match script.byte() % 14 {
            0 => {
                let times_s = [0.0, 0.000_1, 0.001, 0.005, 0.02, 0.1, 0.6, 3.0, 1e6];
                self.now_s += times_s[usize::from(script.byte()) % times_s.len()];
            }
            1 => {
                let count = usize::from(script.byte() % 64);
                self.session.receive(script.take(count), self.now_s);
            }
            2 => {
                let count = usize::from(script.byte() % 64);
                self.device.receive(script.take(count), self.now_s);
            }
            3 => self.transmit(),
            4 => {
                let line = core::mem::take(&mut self.to_base);
                self.device.receive(&line, self.now_s);
            }
            5 => self.turn(script),
            6 => {
                let line = core::mem::take(&mut self.to_host);
                self.session.receive(&line, self.now_s);
            }
            7 => {
                let twist = Twist::new(script.plain(), script.plain());
                self.session.command(&twist).expect("finite");
            }
            8 => {
                let twist = Twist::new(script.real(), script.real());
                let accepted = self.session.command(&twist);
                assert_eq!(accepted.is_ok(), twist.is_finite(), "{twist:?}");
            }
            9 => self.session.engage_stop(),
            10 => self.session.release(),
            11 => {
                self.last_message = self.model.message(script, &self.settings);
                self.session.receive(&self.last_message, self.now_s);
            }
            12 => {
                for _ in 0..script.byte() {
                    self.session.receive(&self.last_message, self.now_s);
                }
            }
            _ => {
                let place = usize::from(script.byte());
                let mask = script.byte();
                for line in [&mut self.to_base, &mut self.to_host] {
                    let length = line.len().max(1);
                    if let Some(byte) = line.get_mut(place % length) {
                        *byte ^= mask;
                    }
                }
            }
        }
    }

    /// The session writes; its commands are within the limits of the tracks.
    fn transmit(&mut self) {
        let mut line = Vec::new();
        self.session.transmit(self.now_s, &mut line);
        assert!(line.len() <= LONGEST_WRITE, "{line:?}");
        for (commanded, rounding) in self.model.commanded(&line, &self.settings) {
            let most = self.settings.tracks.max_track_speed;
            let most = most + most * 1e-9 + rounding;
            let fastest = commanded.left.abs().max(commanded.right.abs());
            assert!(fastest <= most, "{commanded:?} is above {most}");
        }
        self.to_base.extend(line);
        self.to_base.truncate(1000);
    }

    /// The base acts, in a state that the script determines.
    fn turn(&mut self, script: &mut Bytes) {
        let flags = script.byte();
        let machine = MachineState {
            encoder_counts: PerTrack::new(script.u16().into(), script.u32()),
            speeds: TrackSpeeds { left: script.plain(), right: script.plain() },
            yaw_rate: script.plain(),
            battery_v: script.plain(),
            faults: Faults::from_bits(if flags & 2 == 0 { 0 } else { script.u16() }),
            button_pressed: flags & 1 != 0,
            ..MachineState::default()
        };
        let set = self.device.step(self.now_s, &machine, &mut self.to_host);
        assert!(set.left.is_finite() && set.right.is_finite(), "{set:?} of {:?}", self.device);
        self.to_host.truncate(1000);
    }

    /// Checks the invariants.
    fn check(&mut self) {
        if let Some(latest) = self.session.latest() {
            let feedback = &latest.feedback;
            assert!(latest.received_s <= self.now_s, "{latest:?}");
            assert!(feedback.twist.is_finite(), "{latest:?}");
            let tilt = feedback.tilt.map(|tilt| tilt.roll + tilt.pitch);
            for number in [feedback.battery_v, feedback.yaw_rate, tilt].into_iter().flatten() {
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

    /// Checks the memory of both sides at the end.
    fn end(mut self) {
        self.turn(&mut Bytes(&[]));
        for held in [format!("{:?}", self.session), format!("{:?}", self.device)] {
            assert!(held.len() <= MOST_HELD, "{} characters: {}...", held.len(), &held[..2000]);
        }
    }
}

/// Speeds of the tracks from the rates of the channels, without sign, and half a unit of rounding as speed.
fn of_channels(rates: [f64; 2], settings: &BaseSettings) -> (TrackSpeeds, f64) {
    let [left, right] = if settings.swap_tracks { [rates[1], rates[0]] } else { rates };
    let speeds = TrackSpeeds {
        left: left / settings.ticks_per_m.left,
        right: right / settings.ticks_per_m.right,
    };
    let coarsest = settings.ticks_per_m.left.min(settings.ticks_per_m.right);
    (speeds, 0.5 / coarsest)
}

impl ProtocolModel for NativeModel {
    fn commanded(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut decoder = native::Decoder::<native::Command>::default();
        decoder.push(line);
        let commands: Vec<native::Command> = decoder.by_ref().collect();
        assert_eq!(decoder.dropped_bytes(), 0);
        assert!(line.is_empty() || commands.len() == 1, "{line:?}");
        for command in &commands {
            let stands = command.speeds == [0, 0];
            assert!(stands || !command.stop && !command.release, "{command:?}");
        }
        let commanded = commands.iter().map(|command| command.speeds.map(f64::from));
        commanded.map(|rates| of_channels(rates, settings)).collect()
    }

    fn message(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        any_native_report(bytes).encode()
    }
}

impl ProtocolModel for WheeltecModel {
    fn commanded(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut decoder = wheeltec::Decoder::<wheeltec::Command>::default();
        decoder.push(line);
        let commands: Vec<wheeltec::Command> = decoder.by_ref().collect();
        assert_eq!(commands.len() * wheeltec::COMMAND_LENGTH, line.len());
        let half_width = settings.track_width_m / 2.0;
        let commanded = commands.iter().map(|command| {
            let turn = command.twist.angular * half_width;
            let speeds = TrackSpeeds {
                left: command.twist.linear - turn,
                right: command.twist.linear + turn,
            };
            (speeds, 0.000_5 * (1.0 + half_width))
        });
        commanded.collect()
    }

    fn message(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        any_wheeltec_report(bytes).encode().to_vec()
    }
}

impl ProtocolModel for RoboClawModel {
    fn commanded(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let mut commanded = Vec::new();
        let mut rest = line;
        while !rest.is_empty() {
            let (request, length) = Request::decode(rest, settings.roboclaw.address)
                .expect("a packet that a controller obeys")
                .expect("a whole packet");
            if let Request::Drive(rates) = request {
                commanded.push(of_channels(rates.map(f64::from), settings));
            }
            self.0 = Some(request);
            rest = &rest[length..];
        }
        commanded
    }

    /// The reply to the last request.
    fn message(&mut self, bytes: &mut Bytes, settings: &BaseSettings) -> Vec<u8> {
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

impl ProtocolModel for ArduinoModel {
    fn commanded(&mut self, line: &[u8], settings: &BaseSettings) -> Vec<(TrackSpeeds, f64)> {
        let interval_s = settings.arduino.pid_interval_s;
        let text = str::from_utf8(line).expect("text");
        assert!(text.is_empty() || text.ends_with('\r'), "{text:?}");
        let lines = text.split('\r').filter(|line| !matches!(*line, "" | "e"));
        let commanded = lines.map(|line| {
            let rate = |text: &str| f64::from(text.parse::<i16>().expect("16 bits")) / interval_s;
            let numbers: Vec<f64> =
                line.strip_prefix("m ").expect("a command to move").split(' ').map(rate).collect();
            let rates = numbers.try_into().expect("two numbers");
            let (speeds, rounding) = of_channels(rates, settings);
            (speeds, rounding / interval_s)
        });
        commanded.collect()
    }

    fn message(&mut self, bytes: &mut Bytes, _settings: &BaseSettings) -> Vec<u8> {
        let [first, second] = [bytes.u32() as i32, bytes.u32() as i32];
        format!("{first} {second}\r\n").into_bytes()
    }
}
