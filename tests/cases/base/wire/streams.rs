//! Every decoder on split, merged and damaged streams: valid frames are found, damaged frames are lost and never change into
//! others.

use std::cell::Cell;
use std::fmt::Debug;

use inbye::base::arduino::{Answer, parse_answer};
use inbye::base::roboclaw::Request;
use inbye::base::{BaseSettings, Bumper, Faults, MachineState, Protocol, native, wheeltec};
use inbye::geometry::Twist;
use inbye::robot::TrackSpeeds;
use proptest::collection::vec;
use proptest::prelude::{
    BoxedStrategy, Just, Strategy, any, prop_assert, prop_assert_eq, prop_oneof,
};
use proptest::test_runner::TestCaseError;

use super::property::{counterexample, for_all};

/// A decoder under test.
pub trait Codec {
    /// The decoded item.
    type Item: Clone + Debug + PartialEq;
    /// Encodes an item.
    fn encode(item: &Self::Item) -> Vec<u8>;
    /// Decodes a stream that arrives in pieces.
    fn decode(pieces: &[&[u8]]) -> Vec<Self::Item>;
}

macro_rules! codec {
    ($name:ident, $module:ident, $frame:ident, $encode:expr) => {
        struct $name;
        impl Codec for $name {
            type Item = $module::$frame;
            fn encode(item: &Self::Item) -> Vec<u8> {
                $encode(item)
            }
            fn decode(pieces: &[&[u8]]) -> Vec<Self::Item> {
                let mut decoder = $module::Decoder::<$module::$frame>::default();
                let mut found = Vec::new();
                for piece in pieces {
                    decoder.push(piece);
                    found.extend(decoder.by_ref());
                }
                found
            }
        }
    };
}

codec!(NativeCommands, native, Command, native::Command::encode);
codec!(NativeReports, native, Report, native::Report::encode);
codec!(WheeltecCommands, wheeltec, Command, |command: &wheeltec::Command| {
    command.encode().expect("finite").to_vec()
});
codec!(WheeltecReports, wheeltec, Report, |report: &wheeltec::Report| { report.encode().to_vec() });

fn native_command() -> impl Strategy<Value = native::Command> {
    (any::<u16>(), any::<bool>(), any::<bool>(), number(), number()).prop_map(
        |(sequence, stop, release, first, second)| native::Command {
            sequence,
            stop,
            release,
            speeds: [first, second],
        },
    )
}

fn native_report() -> impl Strategy<Value = native::Report> {
    (
        (any::<u16>(), any::<Option<u16>>(), any::<bool>(), any::<bool>()),
        (0..256_u16, any::<u32>(), number(), number()),
        (any::<Option<i16>>(), any::<Option<u16>>()),
        (any::<bool>(), any::<bool>(), any::<bool>()),
    )
        .prop_map(|(first, second, third, (left, right, cliff))| native::Report {
            sequence: first.0,
            echo: first.1,
            stopped: first.2,
            button_pressed: first.3,
            faults: Faults::from_bits(second.0),
            time_ms: second.1,
            counts: [second.2 as u32, second.3 as u32],
            yaw_rate_mrad_s: third.0,
            battery_mv: third.1,
            bumper: Bumper { left, right },
            cliff,
        })
}

/// Numbers with many zeros and frame marks.
fn number() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), Just(0x7B7D_7B7D), Just(0x0043_0152), any::<i32>(), -3000..3000_i32]
}

/// A rate within a base's range.
fn rate() -> impl Strategy<Value = f64> {
    (-3000..3000_i16).prop_map(|thousandths| f64::from(thousandths) / 1000.0)
}

/// A rate without frame marks in its bytes.
fn plain_rate() -> BoxedStrategy<f64> {
    let plain = |rate: &f64| {
        let bytes = ((rate * 1000.0).round() as i16).to_be_bytes();
        !bytes.iter().any(|byte| matches!(byte, 0x7B | 0x7D))
    };
    rate().prop_filter("no mark", plain).boxed()
}

/// A rate whose bytes are often frame marks.
fn marked_rate() -> BoxedStrategy<f64> {
    let marks = prop_oneof![Just(0x7B), Just(0x7D), Just(0x7B - 256), Just(0)];
    prop_oneof![marks.prop_map(|thousandths: i16| f64::from(thousandths) / 1000.0), rate()].boxed()
}

fn wheeltec_command(rate: BoxedStrategy<f64>) -> impl Strategy<Value = wheeltec::Command> {
    (rate.clone(), rate)
        .prop_map(|(linear, angular)| wheeltec::Command { twist: Twist::new(linear, angular) })
}

fn wheeltec_report(rate: BoxedStrategy<f64>) -> impl Strategy<Value = wheeltec::Report> {
    (any::<bool>(), rate.clone(), rate, 20_000..25_000_u16).prop_map(
        |(motors_disabled, linear, angular, millivolts)| wheeltec::Report {
            motors_disabled,
            twist: Twist::new(linear, angular),
            battery_v: f64::from(millivolts) / 1000.0,
            ..wheeltec::Report::default()
        },
    )
}

/// Cuts a stream at arbitrary positions.
fn pieces<'a>(stream: &'a [u8], cuts: &[usize]) -> Vec<&'a [u8]> {
    let mut ends: Vec<usize> = cuts.iter().map(|cut| cut % (stream.len() + 1)).collect();
    ends.push(stream.len());
    ends.sort_unstable();
    let mut start = 0;
    ends.into_iter().map(|end| &stream[std::mem::replace(&mut start, end)..end]).collect()
}

/// A clean stream is decoded completely, however it is cut.
fn check_clean<L: Codec>(items: &[L::Item], cuts: &[usize]) -> Result<(), TestCaseError> {
    let stream: Vec<u8> = items.iter().flat_map(L::encode).collect();
    prop_assert_eq!(L::decode(&pieces(&stream, cuts)), items);
    Ok(())
}

/// One frame with a wrong bit between valid ones: only that frame is lost.
fn check_one_bit<L: Codec>(
    items: &[L::Item],
    bit: usize,
    cuts: &[usize],
) -> Result<(), TestCaseError> {
    let damaged = items.len() / 2;
    let mut stream = Vec::new();
    for (index, item) in items.iter().enumerate() {
        let mut frame = L::encode(item);
        if index == damaged {
            let bit = bit % (8 * frame.len());
            frame[bit / 8] ^= 1 << (bit % 8);
        }
        stream.extend(frame);
    }
    let found = L::decode(&pieces(&stream, cuts));
    let mut without = items.to_vec();
    let lost = without.remove(damaged);
    // A damaged delimiter of a native frame may leave the frame itself intact.
    let mut kept = without.clone();
    kept.insert(damaged, lost);
    prop_assert!(found == without || found == kept, "found {found:?}");
    Ok(())
}

/// Noise before valid frames: at most the first frame is lost.
fn check_after_noise<L: Codec>(noise: &[u8], items: &[L::Item]) -> Result<(), TestCaseError> {
    let mut stream = noise.to_vec();
    stream.extend(items.iter().flat_map(L::encode));
    let found = L::decode(&[&stream]);
    prop_assert!(found.ends_with(&items[1..]), "found {found:?}");
    Ok(())
}

pub fn check_streams<L: Codec>(item: impl Strategy<Value = L::Item>) {
    let items = vec(item, 3..8);
    let cuts = vec(any::<usize>(), 0..12);
    let noise = vec(any::<u8>(), 0..80);
    for_all(300, (items, cuts, any::<usize>(), noise), |(items, cuts, bit, noise)| {
        check_clean::<L>(&items, &cuts)?;
        check_one_bit::<L>(&items, bit, &cuts)?;
        check_after_noise::<L>(&noise, &items)
    });
}

#[test]
fn native_frames_are_found_in_every_stream() {
    check_streams::<NativeCommands>(native_command());
    check_streams::<NativeReports>(native_report());
}

#[test]
fn wheeltec_frames_are_found_in_every_stream() {
    check_streams::<WheeltecCommands>(wheeltec_command(plain_rate()));
    check_streams::<WheeltecReports>(wheeltec_report(plain_rate()));
}

/// On a damaged stream, marks inside frames delimit false frames across two frames. Only the 8-bit check rejects those.
#[test]
fn wheeltec_false_frames_are_as_rare_as_8_bit_check_allows() {
    let wrong = Cell::new(0);
    let items = vec(wheeltec_command(marked_rate()), 3..8);
    let cuts = vec(any::<usize>(), 0..12);
    for_all(20_000, (items, cuts, any::<usize>()), |(items, cuts, bit)| {
        check_clean::<WheeltecCommands>(&items, &cuts)?;
        let is_ok = check_one_bit::<WheeltecCommands>(&items, bit, &cuts).is_ok();
        wrong.set(wrong.get() + u32::from(!is_ok));
        Ok(())
    });
    assert!(wrong.get() < 20_000 / 256, "{}", wrong.get());
}

/// The properties must be able to fail: here a decoder checks the marks only.
#[test]
fn decoder_without_check_fails_the_property() {
    struct Unchecked;
    impl Codec for Unchecked {
        type Item = wheeltec::Command;
        fn encode(item: &Self::Item) -> Vec<u8> {
            WheeltecCommands::encode(item)
        }
        fn decode(pieces: &[&[u8]]) -> Vec<Self::Item> {
            let mut stream = pieces.concat();
            let length = wheeltec::COMMAND_LENGTH;
            for start in 0..stream.len().saturating_sub(length - 1) {
                if stream[start] == 0x7B && stream[start + length - 1] == 0x7D {
                    let frame = &mut stream[start..start + length];
                    frame[9] = frame[..9].iter().fold(0, |check, byte| check ^ byte);
                }
            }
            WheeltecCommands::decode(&[&stream])
        }
    }
    let items = vec(wheeltec_command(plain_rate()), 3..8);
    let failure = counterexample(300, (items, any::<usize>()), |(items, bit)| {
        check_one_bit::<Unchecked>(&items, bit, &[])
    });
    assert!(failure.is_some());
}

/// A CRC-16 detects three wrong bits of a payload. Byte stuffing may spread wrong bits of the line, and then it misses 1 of
/// 65,536: none in this number of cases.
#[test]
fn native_command_with_up_to_four_wrong_bits_is_no_other_command() {
    let bits = vec(any::<usize>(), 1..5);
    for_all(20_000, (native_command(), bits), |(command, bits)| {
        let mut frame = command.encode();
        for bit in bits {
            let bit = bit % (8 * frame.len());
            frame[bit / 8] ^= 1 << (bit % 8);
        }
        let found = NativeCommands::decode(&[&frame]);
        prop_assert!(found.iter().all(|found| *found == command), "{found:?}");
        Ok(())
    });
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        (number(), number()).prop_map(|(first, second)| Request::Drive([first, second])),
        any::<u8>().prop_map(Request::SetTimeout),
        any::<bool>().prop_map(|second| Request::Encoder { second }),
        any::<bool>().prop_map(|second| Request::Speed { second }),
        Just(Request::GetTimeout),
        Just(Request::Battery),
        Just(Request::Status),
    ]
}

/// A packet with a wrong bit is rejected, incomplete or another query, but never another command.
#[test]
fn damaged_roboclaw_packet_is_no_other_command() {
    for_all(2000, (request(), any::<usize>()), |(request, bit)| {
        let mut packet = request.encode(0x80);
        prop_assert_eq!(Request::decode(&packet, 0x80), Ok(Some((request, packet.len()))));
        let bit = bit % (8 * packet.len());
        packet[bit / 8] ^= 1 << (bit % 8);
        let commands = match Request::decode(&packet, 0x80) {
            Ok(Some((found, _))) => matches!(found, Request::Drive(_) | Request::SetTimeout(_)),
            _ => false,
        };
        prop_assert!(!commands);
        Ok(())
    });
}

/// A line is an answer only in the firmware's own spelling.
#[test]
fn arduino_answers_round_trip_exactly() {
    for_all(2000, (number(), number()), |(first, second)| {
        let line = format!("{first} {second}");
        let counts = Answer::Counts([first as u32, second as u32]);
        prop_assert_eq!(parse_answer(line.as_bytes()), Some(counts));
        Ok(())
    });
    let letters =
        vec(prop_oneof![Just(b' '), Just(b'-'), Just(b'0'), any::<u8>(), b'0'..=b'9'], 0..24);
    for_all(5000, letters, |line| {
        if let Some(Answer::Counts(counts)) = parse_answer(&line) {
            let [first, second] = counts.map(|count| count as i32);
            prop_assert_eq!(format!("{first} {second}").into_bytes(), line);
        }
        Ok(())
    });
}

/// Random bytes at random times never panic, give no feedback, and move no base with a 16-bit check.
#[test]
fn noise_causes_no_motion() {
    let noise = vec((vec(any::<u8>(), 0..40), 0.0..0.1_f64), 0..40);
    for_all(500, noise, |noise| {
        for protocol in Protocol::ALL {
            let settings = BaseSettings::default();
            let mut session = protocol.session(settings).expect("valid settings");
            let mut device = protocol.device(settings).expect("valid settings");
            let mut now_s = 0.0;
            for (bytes, pause_s) in &noise {
                now_s += pause_s;
                session.receive(bytes, now_s);
                session.transmit(now_s, &mut Vec::new());
                device.receive(bytes, now_s);
                let set = device.step(now_s, &MachineState::default(), &mut Vec::new());
                let has_crc16 = matches!(protocol, Protocol::Native | Protocol::Roboclaw);
                prop_assert!(!has_crc16 || set == TrackSpeeds::default(), "{set:?}");
            }
            prop_assert!(session.latest().is_none());
        }
        Ok(())
    });
}
