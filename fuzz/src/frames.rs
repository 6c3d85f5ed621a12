//! Decoders of frames, packets and lines: with arbitrary bytes, in pieces of any size, and with frames of any content.

use core::fmt::Debug;
use core::slice;

use inbye::base::arduino::{Answer, parse_answer};
use inbye::base::roboclaw::Request;
use inbye::base::{Bumper, Faults, ld19, native, wheeltec};
use inbye::geometry::Twist;

use super::bytes::Bytes;

/// Longest native frame without delimiters, bytes: a decoder never holds more of a stream.
const NATIVE_HELD: usize = 32;

/// Longest frame of any protocol, bytes.
const LONGEST: usize = ld19::PACKET_LENGTH;

/// A decoder and its frames.
trait Stream: Default + Debug {
    type Frame: Clone + Debug + PartialEq;

    fn push(&mut self, bytes: &[u8]);
    fn frames(&mut self) -> Vec<Self::Frame>;
    fn dropped(&self) -> u64;
    fn encode(frame: &Self::Frame) -> Vec<u8>;
    /// A frame with arbitrary content.
    fn any(bytes: &mut Bytes) -> Self::Frame;
}

macro_rules! stream {
    ($protocol:ident, $frame:ident, $encode:expr, $any:expr) => {
        impl Stream for $protocol::Decoder<$protocol::$frame> {
            type Frame = $protocol::$frame;

            fn push(&mut self, bytes: &[u8]) {
                Self::push(self, bytes);
            }

            fn frames(&mut self) -> Vec<Self::Frame> {
                self.by_ref().collect()
            }

            fn dropped(&self) -> u64 {
                self.dropped_bytes()
            }

            fn encode(frame: &Self::Frame) -> Vec<u8> {
                $encode(frame)
            }

            fn any(bytes: &mut Bytes) -> Self::Frame {
                $any(bytes)
            }
        }
    };
}

stream!(native, Command, native::Command::encode, any_native_command);
stream!(native, Report, native::Report::encode, any_native_report);
stream!(
    wheeltec,
    Command,
    |frame: &wheeltec::Command| frame.encode().expect("finite").to_vec(),
    any_wheeltec_command
);
stream!(wheeltec, Report, |frame: &wheeltec::Report| frame.encode().to_vec(), any_wheeltec_report);

impl Stream for ld19::Decoder {
    type Frame = ld19::Packet;

    fn push(&mut self, bytes: &[u8]) {
        Self::push(self, bytes);
    }

    fn frames(&mut self) -> Vec<ld19::Packet> {
        self.by_ref().collect()
    }

    fn dropped(&self) -> u64 {
        self.dropped_bytes()
    }

    fn encode(packet: &ld19::Packet) -> Vec<u8> {
        packet.encode().to_vec()
    }

    fn any(bytes: &mut Bytes) -> ld19::Packet {
        any_ld19_packet(bytes)
    }
}

/// Native frames in both directions.
pub fn native(data: &[u8]) {
    in_native_stream::<native::Decoder<native::Command>>(data);
    in_native_stream::<native::Decoder<native::Report>>(data);
    round_trip::<native::Decoder<native::Command>>(data);
    round_trip::<native::Decoder<native::Report>>(data);
}

/// WHEELTEC's frames in both directions.
pub fn wheeltec(data: &[u8]) {
    in_wheeltec_stream::<wheeltec::Decoder<wheeltec::Command>>(data, wheeltec::COMMAND_LENGTH);
    in_wheeltec_stream::<wheeltec::Decoder<wheeltec::Report>>(data, wheeltec::FEEDBACK_LENGTH);
    round_trip::<wheeltec::Decoder<wheeltec::Command>>(data);
    round_trip::<wheeltec::Decoder<wheeltec::Report>>(data);
    any_rates_are_encoded_or_refused(&mut Bytes(data));
}

/// Packets of an LD19, and the revolutions that they form.
pub fn ld19(data: &[u8]) {
    let (stream, found, dropped) = in_pieces::<ld19::Decoder>(data);
    let used = found.len() * ld19::PACKET_LENGTH + dropped as usize;
    assert!(stream.len() - used < ld19::PACKET_LENGTH, "{} bytes wait", stream.len() - used);
    for packet in &found {
        let sent = packet.encode();
        assert!(stream.windows(sent.len()).any(|bytes| bytes == sent), "{packet:?}");
    }
    round_trip::<ld19::Decoder>(data);
    let mut bytes = Bytes(data);
    let settings = ld19::LidarSettings::default()
        .mount_x_m(0.2)
        .mount_yaw_rad(-2.0)
        .upside_down(bytes.byte() & 1 != 0);
    let mut revolutions = ld19::RevolutionAssembler::new(settings);
    let mut now_s = 0.0;
    while !bytes.0.is_empty() {
        now_s += f64::from(bytes.byte()) / 1e3;
        let packet = any_ld19_packet(&mut bytes);
        if let Some(sweep) = revolutions.push(&packet, now_s) {
            assert!(sweep.is_valid() && sweep.beams.len() <= 4096);
            assert!(sweep.beams.is_sorted_by_key(|beam| beam.time_s));
            let within = |range: f64| range.is_nan() || (0.0..=sweep.range_max).contains(&range);
            assert!(sweep.beams.iter().all(|beam| within(beam.range)));
        }
    }
}

/// `RoboClaw` requests at a controller, and replies at a host.
pub fn roboclaw(data: &[u8]) {
    let mut bytes = Bytes(data);
    let address = 0x80 | bytes.byte() & 7;
    packets(bytes.0, address);
    answers(bytes.0, address);
}

/// Lines of a `ROSArduinoBridge`.
pub fn arduino(data: &[u8]) {
    for line in data.split(|byte| *byte == b'\n') {
        match parse_answer(line) {
            None => {}
            Some(Answer::Ok) => assert_eq!(line, b"OK"),
            Some(Answer::Counts([first, second])) => {
                let written = format!("{} {}", first as i32, second as i32);
                assert_eq!(line, written.as_bytes());
            }
        }
    }
}

/// Decodes a stream in pieces of a length that the first byte determines, and as a whole: frames and dropped bytes are the same.
/// Returns the whole stream, its frames, and the number of bytes dropped.
fn in_pieces<S: Stream>(data: &[u8]) -> (&[u8], Vec<S::Frame>, u64) {
    let mut bytes = Bytes(data);
    let longest = usize::from(bytes.byte() % 40) + 1;
    let (mut whole, mut pieces) = (S::default(), S::default());
    whole.push(bytes.0);
    let found = whole.frames();
    let mut found_in_pieces = Vec::new();
    for piece in bytes.0.chunks(longest) {
        pieces.push(piece);
        found_in_pieces.extend(pieces.frames());
    }
    assert_eq!(found, found_in_pieces, "in pieces of {longest}");
    assert_eq!(whole.dropped(), pieces.dropped(), "in pieces of {longest}");
    for frame in &found {
        is_decoded_again::<S>(frame);
    }
    for decoder in [&whole, &pieces] {
        // `Debug` writes the bytes that a decoder holds: at most those of a frame, with commas.
        let held = format!("{decoder:?}").len();
        assert!(held < 500, "{held} characters: {decoder:?}");
    }
    (bytes.0, found, whole.dropped())
}

/// Every byte is a delimiter, part of a frame, dropped, or waits for the next delimiter.
fn in_native_stream<S: Stream>(data: &[u8]) {
    let (stream, found, dropped) = in_pieces::<S>(data);
    let ends = stream.split(|byte| *byte == 0).count() - 1;
    let last = stream.rsplit(|byte| *byte == 0).next().map_or(0, <[u8]>::len);
    let in_frames: usize = found.iter().map(|frame| S::encode(frame).len() - ZEROS).sum();
    assert_eq!(stream.len(), ends + in_frames + dropped as usize + last);
}

/// Number of delimiters of a native frame: one before it and one after it.
const ZEROS: usize = 2;

/// Every byte is part of a frame, dropped, or waits for the rest of a frame.
fn in_wheeltec_stream<S: Stream>(data: &[u8], length: usize) {
    let (stream, found, dropped) = in_pieces::<S>(data);
    let waiting = stream.len() - found.len() * length - dropped as usize;
    assert!(waiting < length, "{waiting} bytes wait");
}

/// A frame of any content is the same after encoding and decoding.
fn round_trip<S: Stream>(data: &[u8]) {
    is_decoded_again::<S>(&S::any(&mut Bytes(data)));
}

fn is_decoded_again<S: Stream>(frame: &S::Frame) {
    let line = S::encode(frame);
    assert!(line.len() <= LONGEST.max(NATIVE_HELD + ZEROS), "{line:?}");
    let mut decoder = S::default();
    decoder.push(&line);
    assert_eq!(decoder.frames(), slice::from_ref(frame));
    assert_eq!(decoder.dropped(), 0);
}

fn packets(stream: &[u8], address: u8) {
    let mut rest = stream;
    while let Ok(Some((request, length))) = Request::decode(rest, address) {
        assert_eq!(request.encode(address), rest[..length], "{request:?}");
        rest = &rest[length..];
    }
    // A decoder waits at most for the longest packet.
    if Request::decode(rest, address) == Ok(None) {
        assert!(rest.len() < 12, "{} bytes wait", rest.len());
    }
}

fn answers(stream: &[u8], address: u8) {
    for request in [
        Request::SetTimeout(5),
        Request::GetTimeout,
        Request::Encoder { second: false },
        Request::Encoder { second: true },
        Request::Speed { second: false },
        Request::Speed { second: true },
        Request::Battery,
        Request::Drive([0, 1]),
        Request::Status,
    ] {
        for status_bytes in [2, 4] {
            let length = request.reply_length(status_bytes);
            for end in [length.saturating_sub(1), length, length + 1] {
                let _ = request.reply(address, &stream[..end.min(stream.len())]);
            }
            if matches!(request, Request::SetTimeout(_) | Request::Drive(_)) {
                continue;
            }
            let data: [u8; 5] = Bytes(stream).array();
            let data = &data[..length - 2];
            let answer = request.encode_reply(address, data.to_vec());
            assert_eq!(answer.len(), length);
            let number = request.reply(address, &answer).expect("undamaged");
            let digits = &data[..data.len().min(4)];
            let expected = digits.iter().fold(0, |number, byte| number << 8 | u32::from(*byte));
            assert_eq!(number, expected, "{request:?}");
        }
    }
}

/// Decoded rates are within half a unit, or at the limit of 16 bits; rates that are not finite are rejected.
fn any_rates_are_encoded_or_refused(bytes: &mut Bytes) {
    let twist = Twist::new(bytes.real(), bytes.real());
    let line = wheeltec::Command { twist }.encode();
    assert_eq!(line.is_ok(), twist.is_finite(), "{twist:?}");
    let Ok(line) = line else { return };
    let mut decoder = wheeltec::Decoder::<wheeltec::Command>::default();
    decoder.push(&line);
    let found = decoder.next().expect("an undamaged frame").twist;
    for (sent, found) in [(twist.linear, found.linear), (twist.angular, found.angular)] {
        let nearest = sent.clamp(-32.768, 32.767);
        assert!((nearest - found).abs() < 0.000_500_1, "{sent} as {found}");
    }
}

/// A packet with any content that a lidar can send.
fn any_ld19_packet(bytes: &mut Bytes) -> ld19::Packet {
    let first = bytes.u16() % 36_000;
    ld19::Packet {
        speed_deg_s: bytes.u16(),
        first,
        last: (first + bytes.u16() % 9_001) % 36_000,
        time_ms: bytes.u16(),
        points: core::array::from_fn(|_| ld19::Point {
            distance_mm: bytes.u16(),
            intensity: bytes.byte(),
        }),
    }
}

fn any_native_command(bytes: &mut Bytes) -> native::Command {
    let flags = bytes.byte();
    native::Command {
        sequence: bytes.u16(),
        stop: flags & 1 != 0,
        release: flags & 2 != 0,
        speeds: [bytes.u32() as i32, bytes.u32() as i32],
    }
}

/// A report with arbitrary content; optional fields may be missing.
pub fn any_native_report(bytes: &mut Bytes) -> native::Report {
    let flags = bytes.byte();
    let flag = |bit: u8| flags >> bit & 1 != 0;
    native::Report {
        sequence: bytes.u16(),
        echo: flag(2).then(|| bytes.u16()),
        stopped: flag(0),
        button_pressed: flag(1),
        faults: Faults::from_bits(bytes.u16()),
        time_ms: bytes.u32(),
        counts: [bytes.u32(), bytes.u32()],
        yaw_rate_mrad_s: flag(3).then(|| bytes.u16() as i16),
        battery_mv: flag(4).then(|| bytes.u16()),
        bumper: Bumper { left: flag(5), right: flag(6) },
        cliff: flag(7),
    }
}

/// A command that the wire format represents exactly.
fn any_wheeltec_command(bytes: &mut Bytes) -> wheeltec::Command {
    wheeltec::Command { twist: Twist::new(bytes.plain(), bytes.plain()) }
}

/// A report that the wire format represents exactly.
pub fn any_wheeltec_report(bytes: &mut Bytes) -> wheeltec::Report {
    wheeltec::Report {
        motors_disabled: bytes.byte() & 1 != 0,
        twist: Twist::new(bytes.plain(), bytes.plain()),
        lateral: bytes.plain(),
        battery_v: f64::from(bytes.u16()) / 1000.0,
        ..wheeltec::Report::default()
    }
}
