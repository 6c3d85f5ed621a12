//! WHEELTEC frames as bytes, and a serial base over a pair of pseudo-terminals.

use inbye::base::BaseError;
use inbye::base::wheeltec::{COMMAND_LENGTH, Command, Decoder, FEEDBACK_LENGTH, Report};
use inbye::geometry::Twist;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// 0.5 m/s, -0.1 rad/s; computed by hand from the protocol.
const GOLDEN_COMMAND: [u8; COMMAND_LENGTH] =
    [0x7B, 0x00, 0x00, 0x01, 0xF4, 0x00, 0x00, 0xFF, 0x9C, 0xED, 0x7D];

/// The stop command; its check byte equals the head mark.
const GOLDEN_STOP: [u8; COMMAND_LENGTH] =
    [0x7B, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x7B, 0x7D];

/// 0.5 m/s, -0.1 rad/s, 16384 counts of vertical acceleration, -375 of yaw rate, 24 V.
const GOLDEN_FEEDBACK: [u8; FEEDBACK_LENGTH] = [
    0x7B, 0x00, 0x01, 0xF4, 0x00, 0x00, 0xFF, 0x9C, 0x00, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x00,
    0x00, 0x00, 0xFE, 0x89, 0x5D, 0xC0, 0x47, 0x7D,
];

fn encode(linear: f64, angular: f64) -> [u8; COMMAND_LENGTH] {
    let twist = Twist::new(linear, angular);
    Command { twist }.encode().expect("finite rates")
}

fn decode(bytes: &[u8]) -> Vec<Report> {
    let mut decoder = Decoder::default();
    decoder.push(bytes);
    decoder.collect()
}

/// Reports whose numbers contain many head and tail marks.
fn random_report(rng: &mut Pcg64Mcg) -> Report {
    let mut number = |scale: f64| match rng.random_range(0..4) {
        0 => f64::from(0x7B7D) / scale,
        1 => f64::from(0x7D7B) / scale,
        2 => 0.0,
        _ => f64::from(rng.random_range(-32_768..=32_767)) / scale,
    };
    Report {
        motors_disabled: false,
        twist: Twist::new(number(1000.0), number(1000.0)),
        lateral: number(1000.0),
        battery_v: number(1000.0).abs(),
        ..Report::default()
    }
}

#[test]
fn commands_equal_the_golden_frames() {
    assert_eq!(encode(0.5, -0.1), GOLDEN_COMMAND);
    assert_eq!(encode(0.0, 0.0), GOLDEN_STOP);
}

#[test]
fn commands_round_halves_away_from_zero_and_saturate() {
    let fields = |linear, angular| {
        let bytes = encode(linear, angular);
        (i16::from_be_bytes([bytes[3], bytes[4]]), i16::from_be_bytes([bytes[7], bytes[8]]))
    };
    assert_eq!(fields(0.0005, -0.0005), (1, -1));
    assert_eq!(fields(0.0025, -0.0025), (3, -3));
    assert_eq!(fields(0.000_49, -0.000_49), (0, 0));
    assert_eq!(fields(33.0, -33.0), (32_767, -32_768));
    assert_eq!(fields(f64::MAX, f64::MIN), (32_767, -32_768));
}

#[test]
fn commands_that_are_not_finite_are_rejected() {
    for (linear, angular) in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (f64::NEG_INFINITY, 0.0)] {
        let command = Command { twist: Twist::new(linear, angular) };
        let refusal = command.encode().unwrap_err();
        assert!(matches!(refusal, BaseError::NotFinite { .. }), "{refusal}");
    }
}

#[test]
fn feedback_decodes_the_golden_frame() {
    let reports = decode(&GOLDEN_FEEDBACK);
    assert_eq!(reports.len(), 1);
    let report = reports[0];
    assert!(!report.motors_disabled);
    assert_eq!(report.twist, Twist::new(0.5, -0.1));
    assert!(report.lateral.abs() < 1e-12);
    assert!((report.acceleration[2] - 16_384.0 / 1671.84).abs() < 1e-12);
    assert!((report.gyro[2] + 375.0 * 0.000_266_44).abs() < 1e-12);
    assert!((report.battery_v - 24.0).abs() < 1e-12);
    assert_eq!(report.encode(), GOLDEN_FEEDBACK);
}

#[test]
fn base_decodes_commands_of_host() {
    let mut decoder = Decoder::<Command>::default();
    decoder.push(&GOLDEN_STOP);
    decoder.push(&GOLDEN_COMMAND);
    let twists: Vec<Twist> = decoder.by_ref().map(|command| command.twist).collect();
    assert_eq!(twists, [Twist::STOP, Twist::new(0.5, -0.1)]);
    assert_eq!(decoder.dropped_bytes(), 0);
}

#[test]
fn frame_may_be_split_at_every_byte() {
    for split in 0..=FEEDBACK_LENGTH {
        let mut decoder = Decoder::<Report>::default();
        decoder.push(&GOLDEN_FEEDBACK[..split]);
        assert_eq!(decoder.next().is_some(), split == FEEDBACK_LENGTH, "split {split}");
        decoder.push(&GOLDEN_FEEDBACK[split..]);
        assert_eq!(decoder.next().is_some(), split < FEEDBACK_LENGTH, "split {split}");
        assert_eq!(decoder.dropped_bytes(), 0);
    }
}

#[test]
fn marks_inside_frames_are_harmless_in_clean_stream() {
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    for _ in 0..200 {
        let sent: Vec<Report> = (0..10).map(|_| random_report(&mut rng)).collect();
        let stream: Vec<u8> = sent.iter().flat_map(Report::encode).collect();
        let mut decoder = Decoder::<Report>::default();
        let mut received = Vec::new();
        let mut rest = &stream[..];
        while !rest.is_empty() {
            let (piece, after) = rest.split_at(rng.random_range(1..=rest.len().min(40)));
            decoder.push(piece);
            received.extend(decoder.by_ref());
            rest = after;
        }
        let bytes =
            |reports: &[Report]| reports.iter().flat_map(Report::encode).collect::<Vec<_>>();
        assert_eq!(bytes(&received), stream);
        assert_eq!(decoder.dropped_bytes(), 0);
    }
}

#[test]
fn damaged_byte_loses_own_frame_only() {
    for at in 0..FEEDBACK_LENGTH {
        for flip in [0x01, 0x80, 0xFF] {
            let mut damaged = GOLDEN_FEEDBACK;
            damaged[at] ^= flip;
            let mut decoder = Decoder::<Report>::default();
            decoder.push(&damaged);
            decoder.push(&GOLDEN_FEEDBACK);
            let reports: Vec<Report> = decoder.by_ref().collect();
            assert_eq!(reports, decode(&GOLDEN_FEEDBACK), "byte {at} flipped by {flip:02X}");
            assert_eq!(decoder.dropped_bytes(), FEEDBACK_LENGTH as u64);
        }
    }
}

#[test]
fn truncated_frame_and_noise_are_dropped_and_counted() {
    for cut in 1..FEEDBACK_LENGTH {
        let mut decoder = Decoder::<Report>::default();
        decoder.push(&[0x00, 0x7D, 0x55]);
        decoder.push(&GOLDEN_FEEDBACK[..cut]);
        decoder.push(&GOLDEN_FEEDBACK);
        assert_eq!(decoder.by_ref().count(), 1, "cut after {cut}");
        assert_eq!(decoder.dropped_bytes(), 3 + cut as u64);
    }
}

#[cfg(all(unix, feature = "serial"))]
mod serial {
    use std::io::{Read, Write};
    use std::time::Duration;

    use inbye::base::wheeltec::{Command, Decoder, Report, WheeltecSession};
    use inbye::base::{Base, BaseError, BaseSettings, Feedback, SerialBase, SerialSettings, Tilt};
    use inbye::geometry::Twist;
    use serialport::{SerialPort, TTYPort};

    use super::{GOLDEN_COMMAND, GOLDEN_FEEDBACK, GOLDEN_STOP};

    /// Generous enough for a busy machine.
    const LONG_TIMEOUTS: SerialSettings = SerialSettings {
        send_timeout: Duration::from_secs(20),
        request_timeout: Duration::from_secs(20),
        feedback_timeout: Duration::from_secs(60),
    };

    type Wheeltec = SerialBase;

    fn session() -> Box<WheeltecSession> {
        Box::new(WheeltecSession::new(BaseSettings::default()).expect("valid settings"))
    }

    fn connect(settings: SerialSettings) -> (TTYPort, Wheeltec) {
        let (mut device, port) = TTYPort::pair().expect("pseudo-terminals");
        device.set_timeout(Duration::from_secs(20)).expect("a timeout");
        (device, SerialBase::from_port(Box::new(port), "pty", session(), settings))
    }

    /// Waits for the first feedback: bytes take a moment through the terminal.
    fn await_feedback(base: &mut Wheeltec) -> Result<Feedback, BaseError> {
        loop {
            match base.feedback() {
                Err(BaseError::NoFeedbackYet { .. }) => {}
                answer => return answer,
            }
        }
    }

    #[test]
    fn command_bytes_arrive() {
        let (mut device, mut base) = connect(LONG_TIMEOUTS);
        base.send(&Twist::new(0.5, -0.1)).unwrap();
        base.send(&Twist::STOP).unwrap();
        let mut bytes = [0; 22];
        device.read_exact(&mut bytes).unwrap();
        assert_eq!(bytes, [GOLDEN_COMMAND, GOLDEN_STOP].concat()[..]);
    }

    #[test]
    fn command_that_is_not_finite_sends_nothing() {
        let (mut device, mut base) = connect(LONG_TIMEOUTS);
        let refusal = base.send(&Twist::new(f64::NAN, 0.0)).unwrap_err();
        assert!(matches!(refusal, BaseError::NotFinite { .. }), "{refusal}");
        base.send(&Twist::STOP).unwrap();
        let mut bytes = [0; 11];
        device.read_exact(&mut bytes).unwrap();
        assert_eq!(bytes, GOLDEN_STOP);
    }

    #[test]
    fn feedback_in_pieces_is_decoded_and_latest_kept() {
        let (mut device, mut base) = connect(LONG_TIMEOUTS);
        assert!(matches!(base.feedback(), Err(BaseError::NoFeedbackYet { .. })));
        device.write_all(&GOLDEN_FEEDBACK[..10]).unwrap();
        assert!(matches!(base.feedback(), Err(BaseError::NoFeedbackYet { .. })));
        device.write_all(&GOLDEN_FEEDBACK[10..]).unwrap();
        let feedback = await_feedback(&mut base).unwrap();
        let golden = Feedback {
            twist: Twist::new(0.5, -0.1),
            emergency_stop: false,
            battery_v: Some(24.0),
            yaw_rate: Some(-375.0 * 0.000_266_44),
            tilt: Some(Tilt::default()),
            ..Feedback::default()
        };
        let without_age = |feedback: Feedback| Feedback { age_s: 0.0, ..feedback };
        assert!(feedback.age_s >= 0.0);
        assert_eq!(without_age(feedback), golden);
        assert_eq!(base.feedback().map(without_age), Ok(golden), "until a newer one arrives");

        let stopped = Report { motors_disabled: true, ..Report::default() };
        device.write_all(&stopped.encode()).unwrap();
        let newer = std::iter::repeat_with(|| base.feedback().unwrap())
            .find(|feedback| without_age(*feedback) != golden)
            .unwrap();
        assert!(newer.is_stop_suspected, "a single report may be damaged");
        assert_eq!(base.counters().dropped_bytes, 0);
    }

    #[test]
    fn silence_after_feedback_times_out() {
        let (mut device, mut base) = connect(SerialSettings {
            feedback_timeout: Duration::from_millis(200),
            ..LONG_TIMEOUTS
        });
        device.write_all(&GOLDEN_FEEDBACK).unwrap();
        // On a busy machine the timeout may pass before the first answer.
        let timed_out = std::iter::repeat_with(|| base.feedback())
            .find(|answer| matches!(answer, Err(BaseError::TimedOut { timeout_ms: 200, .. })));
        assert!(timed_out.is_some());
    }

    #[test]
    fn closed_device_is_disconnected() {
        let (device, mut base) = connect(LONG_TIMEOUTS);
        drop(device);
        let disconnected = BaseError::Disconnected { port: "pty".to_owned() };
        assert_eq!(base.send(&Twist::STOP), Err(disconnected.clone()));
        assert_eq!(base.feedback(), Err(disconnected));
    }

    #[test]
    fn device_that_never_reads_times_out() {
        let (mut device, mut base) =
            connect(SerialSettings { send_timeout: Duration::from_millis(50), ..LONG_TIMEOUTS });
        // The terminal holds a few thousand commands before it is full.
        let refusal = (0..100_000)
            .find_map(|_| base.send(&Twist::new(0.5, -0.1)).err())
            .expect("the line never filled up");
        assert!(matches!(refusal, BaseError::TimedOut { timeout_ms: 50, .. }), "{refusal}");
        // When the device reads again the line recovers; all commands are complete except the truncated one.
        let mut decoder = Decoder::<Command>::default();
        let mut bytes = [0; 4096];
        device.set_timeout(Duration::from_millis(100)).unwrap();
        while let Ok(count) = device.read(&mut bytes) {
            decoder.push(&bytes[..count]);
        }
        assert!(decoder.by_ref().all(|command| command.twist == Twist::new(0.5, -0.1)));
        base.send(&Twist::STOP).unwrap();
        device.set_timeout(Duration::from_secs(20)).unwrap();
        let last = loop {
            let count = device.read(&mut bytes).unwrap();
            decoder.push(&bytes[..count]);
            if let Some(command) = decoder.next() {
                break command;
            }
        };
        assert_eq!(last.twist, Twist::STOP);
        assert!(decoder.dropped_bytes() < 11, "{}", decoder.dropped_bytes());
    }

    #[test]
    fn missing_port_is_named() {
        let error =
            SerialBase::open("no-such-port", session(), SerialSettings::default()).err().unwrap();
        assert!(error.to_string().starts_with("no-such-port: cannot be opened"), "{error}");
    }
}
