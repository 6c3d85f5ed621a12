//! Every decoder on streams that are split, merged and damaged: what is whole is found, what is damaged costs itself and
//! never becomes something else.

use std::cell::Cell;
use std::fmt::Debug;

use inbye::base::arduino::{Answer, parse_answer};
use inbye::base::roboclaw::Request;
use inbye::base::{BaseSettings, Faults, MachineState, Protocol, native, wheeltec};
use inbye::geometry::Twist;
use inbye::robot::TrackSpeeds;
use proptest::collection::vec;
use proptest::prelude::{
    BoxedStrategy, Just, Strategy, any, prop_assert, prop_assert_eq, prop_oneof,
};
use proptest::test_runner::TestCaseError;

use super::sure::{counterexample, for_all};

/// A decoder under test.
pub trait Language {
    /// What it finds.
    type Item: Clone + Debug + PartialEq;
    /// The bytes of one.
    fn encode(item: &Self::Item) -> Vec<u8>;
    /// What is found in pieces that arrive one after another.
    fn decode(pieces: &[&[u8]]) -> Vec<Self::Item>;
}

macro_rules! language {
    ($name:ident, $room:ident, $frame:ident, $encode:expr) => {
        struct $name;
        impl Language for $name {
            type Item = $room::$frame;
            fn encode(item: &Self::Item) -> Vec<u8> {
                $encode(item)
            }
            fn decode(pieces: &[&[u8]]) -> Vec<Self::Item> {
                let mut decoder = $room::Decoder::<$room::$frame>::default();
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

language!(NativeCommands, native, Command, native::Command::encode);
language!(NativeReports, native, Report, native::Report::encode);
language!(
    WheeltecCommands,
    wheeltec,
    Command,
    |command: &wheeltec::Command| { command.encode().expect("finite").to_vec() }
);
language!(
    WheeltecReports,
    wheeltec,
    Report,
    |report: &wheeltec::Report| { report.encode().to_vec() }
);

fn native_command() -> impl Strategy<Value = native::Command> {
    (
        any::<u16>(),
        any::<bool>(),
        any::<bool>(),
        number(),
        number(),
    )
        .prop_map(|(sequence, stop, release, first, second)| native::Command {
            sequence,
            stop,
            release,
            speeds: [first, second],
        })
}

fn native_report() -> impl Strategy<Value = native::Report> {
    (
        (
            any::<u16>(),
            any::<Option<u16>>(),
            any::<bool>(),
            any::<bool>(),
        ),
        (0..256_u16, any::<u32>(), number(), number()),
        (any::<Option<i16>>(), any::<Option<u16>>()),
    )
        .prop_map(|(first, second, third)| native::Report {
            sequence: first.0,
            echo: first.1,
            stopped: first.2,
            button_pressed: first.3,
            faults: Faults::from_bits(second.0),
            time_ms: second.1,
            counts: [second.2 as u32, second.3 as u32],
            yaw_rate_mrad_s: third.0,
            battery_mv: third.1,
        })
}

/// Numbers full of zeros and of the marks of frames.
fn number() -> impl Strategy<Value = i32> {
    prop_oneof![
        Just(0),
        Just(0x7B7D_7B7D),
        Just(0x0043_0152),
        any::<i32>(),
        -3000..3000_i32
    ]
}

/// A rate that a base has.
fn rate() -> impl Strategy<Value = f64> {
    (-3000..3000_i16).prop_map(|thousandths| f64::from(thousandths) / 1000.0)
}

/// One without the marks of frames in its bytes.
fn plain_rate() -> BoxedStrategy<f64> {
    let plain = |rate: &f64| {
        let bytes = ((rate * 1000.0).round() as i16).to_be_bytes();
        !bytes.iter().any(|byte| matches!(byte, 0x7B | 0x7D))
    };
    rate().prop_filter("no mark", plain).boxed()
}

/// One whose bytes are often those of the marks.
fn marked_rate() -> BoxedStrategy<f64> {
    let marks = prop_oneof![Just(0x7B), Just(0x7D), Just(0x7B - 256), Just(0)];
    prop_oneof![
        marks.prop_map(|thousandths: i16| f64::from(thousandths) / 1000.0),
        rate()
    ]
    .boxed()
}

fn wheeltec_command(rate: BoxedStrategy<f64>) -> impl Strategy<Value = wheeltec::Command> {
    (rate.clone(), rate).prop_map(|(linear, angular)| wheeltec::Command {
        twist: Twist::new(linear, angular),
    })
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

/// Cuts a stream at places given as any numbers.
fn pieces<'a>(stream: &'a [u8], cuts: &[usize]) -> Vec<&'a [u8]> {
    let mut ends: Vec<usize> = cuts.iter().map(|cut| cut % (stream.len() + 1)).collect();
    ends.push(stream.len());
    ends.sort_unstable();
    let mut start = 0;
    ends.into_iter()
        .map(|end| &stream[std::mem::replace(&mut start, end)..end])
        .collect()
}

/// A clean stream is found whole, however it is cut.
fn whole<L: Language>(items: &[L::Item], cuts: &[usize]) -> Result<(), TestCaseError> {
    let stream: Vec<u8> = items.iter().flat_map(L::encode).collect();
    prop_assert_eq!(L::decode(&pieces(&stream, cuts)), items);
    Ok(())
}

/// One frame with one wrong bit, between good ones: it is not found, they all are.
fn one_bit<L: Language>(
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
    // A mark of our own frames that is damaged into nothing may leave its frame whole: then it is found unchanged.
    let mut kept = without.clone();
    kept.insert(damaged, lost);
    prop_assert!(found == without || found == kept, "found {found:?}");
    Ok(())
}

/// Noise before good frames: the second at the latest is found, and all behind it.
fn after_noise<L: Language>(noise: &[u8], items: &[L::Item]) -> Result<(), TestCaseError> {
    let mut stream = noise.to_vec();
    stream.extend(items.iter().flat_map(L::encode));
    let found = L::decode(&[&stream]);
    prop_assert!(found.ends_with(&items[1..]), "found {found:?}");
    Ok(())
}

pub fn holds_everywhere<L: Language>(item: impl Strategy<Value = L::Item>) {
    let items = vec(item, 3..8);
    let cuts = vec(any::<usize>(), 0..12);
    let noise = vec(any::<u8>(), 0..80);
    for_all(
        300,
        (items, cuts, any::<usize>(), noise),
        |(items, cuts, bit, noise)| {
            whole::<L>(&items, &cuts)?;
            one_bit::<L>(&items, bit, &cuts)?;
            after_noise::<L>(&noise, &items)
        },
    );
}

#[test]
fn native_frames_survive_every_stream() {
    holds_everywhere::<NativeCommands>(native_command());
    holds_everywhere::<NativeReports>(native_report());
}

#[test]
fn wheeltec_frames_survive_every_stream() {
    holds_everywhere::<WheeltecCommands>(wheeltec_command(plain_rate()));
    holds_everywhere::<WheeltecReports>(wheeltec_report(plain_rate()));
}

/// Marks inside frames do not confuse a clean stream. On a damaged one they begin and end windows across two frames, and
/// then the check of 8 bits is all there is: few are believed.
#[test]
fn wheeltec_frames_full_of_marks_are_confused_as_rarely_as_8_bits_promise() {
    let wrong = Cell::new(0);
    let items = vec(wheeltec_command(marked_rate()), 3..8);
    let cuts = vec(any::<usize>(), 0..12);
    for_all(
        20_000,
        (items, cuts, any::<usize>()),
        |(items, cuts, bit)| {
            whole::<WheeltecCommands>(&items, &cuts)?;
            let held = one_bit::<WheeltecCommands>(&items, bit, &cuts).is_ok();
            wrong.set(wrong.get() + u32::from(!held));
            Ok(())
        },
    );
    assert!(wrong.get() < 20_000 / 256, "{}", wrong.get());
}

/// The properties must be able to fail: a decoder that checks nothing but the marks.
#[test]
fn a_decoder_without_a_check_is_caught() {
    struct Careless;
    impl Language for Careless {
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
        one_bit::<Careless>(&items, bit, &[])
    });
    assert!(failure.is_some());
}

/// Three wrong bits of a payload are always seen by a CRC of 16 bits; on the line the stuffing may spread them, and then
/// 1 of 65,536 is the chance. So many cases find none.
#[test]
fn a_native_command_with_up_to_four_wrong_bits_is_no_other_command() {
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

/// A packet with one wrong bit is refused, or waits for more, or is another question; but it is never another command.
#[test]
fn a_damaged_roboclaw_packet_is_no_other_command() {
    for_all(2000, (request(), any::<usize>()), |(request, bit)| {
        let mut packet = request.encode(0x80);
        prop_assert_eq!(
            Request::decode(&packet, 0x80),
            Ok(Some((request, packet.len())))
        );
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

/// Whatever a line says, it is an answer only when the firmware would have written it so.
#[test]
fn arduino_lines_are_read_only_as_they_are_written() {
    for_all(2000, (number(), number()), |(first, second)| {
        let line = format!("{first} {second}");
        let counts = Answer::Counts([first as u32, second as u32]);
        prop_assert_eq!(parse_answer(line.as_bytes()), Some(counts));
        Ok(())
    });
    let letters = vec(
        prop_oneof![Just(b' '), Just(b'-'), Just(b'0'), any::<u8>(), b'0'..=b'9'],
        0..24,
    );
    for_all(5000, letters, |line| {
        if let Some(Answer::Counts(counts)) = parse_answer(&line) {
            let [first, second] = counts.map(|count| count as i32);
            prop_assert_eq!(format!("{first} {second}").into_bytes(), line);
        }
        Ok(())
    });
}

/// Bytes from anywhere, at any times: nothing panics, no motion is believed, and no base moves by them that has a check of
/// 16 bits.
#[test]
fn noise_moves_nothing() {
    let noise = vec((vec(any::<u8>(), 0..40), 0.0..0.1_f64), 0..40);
    for_all(500, noise, |noise| {
        for protocol in Protocol::ALL {
            let settings = BaseSettings::default();
            let mut session = protocol.session(settings).expect("valid settings");
            let mut peer = protocol.device(settings).expect("valid settings");
            let mut now_s = 0.0;
            for (bytes, pause_s) in &noise {
                now_s += pause_s;
                session.receive(bytes, now_s);
                session.transmit(now_s, &mut Vec::new());
                peer.receive(bytes, now_s);
                let set = peer.step(now_s, &MachineState::default(), &mut Vec::new());
                let guarded = matches!(protocol, Protocol::Native | Protocol::Roboclaw);
                prop_assert!(!guarded || set == TrackSpeeds::default(), "{set:?}");
            }
            prop_assert!(session.latest().is_none());
        }
        Ok(())
    });
}
