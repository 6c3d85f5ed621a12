//! Golden frames. Those of the native protocol and of `RoboClaw` come from an independent Python program:
//!
//! ```python
//! def crc(data, check):
//!     for byte in data:
//!         check ^= byte << 8
//!         for _ in range(8):
//!             check = (check << 1 ^ 0x1021 if check & 0x8000 else check << 1) & 0xFFFF
//!     return check
//! def cobs(data):
//!     return b"".join(bytes([len(block) + 1]) + block for block in data.split(b"\0"))
//! payload = struct.pack("<BBHBii", 1, 0x43, 1, 0, 1000, -1000)
//! print((b"\0" + cobs(payload + struct.pack("<H", crc(payload, 0xFFFF))) + b"\0").hex(" "))
//! packet = struct.pack(">BBii", 0x80, 37, 1000, -1000)
//! print((packet + struct.pack(">H", crc(packet, 0))).hex(" "))
//! ```

use inbye::base::arduino::{Answer, ArduinoDevice, parse_answer};
use inbye::base::native::{Command, Decoder, Frame, Report};
use inbye::base::roboclaw::Request;
use inbye::base::{BaseSettings, DeviceProtocol, Faults, MachineState};

pub fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).expect("two digits")).collect()
}

fn decoded<F: Frame>(line: &[u8]) -> Vec<F> {
    let mut decoder = Decoder::default();
    decoder.push(line);
    decoder.collect()
}

#[test]
fn native_commands_equal_the_golden_frames() {
    let zero = |sequence, stop, release| Command { sequence, stop, release, speeds: [0, 0] };
    for (command, hex) in [
        (
            Command { sequence: 1, speeds: [1000, -1000], ..Command::default() },
            "00 04 01 43 01 01 03 E8 03 01 07 18 FC FF FF C0 CE 00",
        ),
        (zero(2, false, false), "00 04 01 43 02 01 01 01 01 01 01 01 01 01 03 03 15 00"),
        (zero(3, true, false), "00 04 01 43 03 02 01 01 01 01 01 01 01 01 03 69 26 00"),
        (zero(4, false, true), "00 04 01 43 04 02 02 01 01 01 01 01 01 01 03 90 22 00"),
    ] {
        assert_eq!(command.encode(), bytes(hex));
        assert_eq!(decoded::<Command>(&bytes(hex)), [command]);
    }
}

#[test]
fn native_reports_equal_the_golden_frames() {
    let first = Report {
        sequence: 7,
        echo: Some(1),
        time_ms: 5000,
        counts: [100, 100_u32.wrapping_neg()],
        yaw_rate_mrad_s: Some(-100),
        battery_mv: Some(24_000),
        ..Report::default()
    };
    let second = Report {
        sequence: 8,
        echo: Some(3),
        stopped: true,
        faults: Faults::MOTOR_LEFT,
        time_ms: 5020,
        yaw_rate_mrad_s: Some(0),
        battery_mv: Some(23_950),
        ..first
    };
    for (report, hex) in [
        (
            first,
            "00 04 01 52 07 02 01 02 1C 01 03 88 13 01 02 64 01 01 0B 9C FF FF FF 9C FF C0 5D 99 41 00",
        ),
        (
            second,
            "00 04 01 52 08 02 03 03 1D 01 03 9C 13 01 02 64 01 01 05 9C FF FF FF 01 05 8E 5D 84 2C 00",
        ),
    ] {
        assert_eq!(report.encode(), bytes(hex));
        assert_eq!(decoded::<Report>(&bytes(hex)), [report]);
    }
}

#[test]
fn other_version_kind_or_reserved_bit_is_rejected() {
    // Version 2; kind `D`; bit 2 of the flags: each with a valid CRC.
    for payload in ["02 43 01", "01 44 01", "01 43 01 00 04"] {
        let mut payload = bytes(payload);
        payload.resize(13, 0);
        let check = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(&payload);
        payload.extend(check.to_le_bytes());
        let mut line = [0; 18];
        cobs::encode(&payload, &mut line[1..]);
        assert_eq!(decoded::<Command>(&line), []);
    }
    assert_eq!(decoded::<Report>(&Command::default().encode()), []);
}

#[test]
fn roboclaw_requests_equal_the_golden_packets() {
    for (request, hex) in [
        (Request::Drive([1000, -1000]), "80 25 00 00 03 E8 FF FF FC 18 82 90"),
        (Request::Drive([0, 0]), "80 25 00 00 00 00 00 00 00 00 34 04"),
        (Request::SetTimeout(5), "80 0E 05 48 F0"),
        (Request::GetTimeout, "80 0F"),
        (Request::Encoder { second: true }, "80 11"),
        (Request::Speed { second: false }, "80 12"),
        (Request::Battery, "80 18"),
        (Request::Status, "80 5A"),
    ] {
        let packet = bytes(hex);
        assert_eq!(request.encode(0x80), packet);
        assert_eq!(Request::decode(&packet, 0x80), Ok(Some((request, packet.len()))));
        for cut in 0..packet.len() {
            let early = Request::decode(&packet[..cut], 0x80);
            assert_eq!(early, Ok(None), "{request:?} cut at {cut}");
        }
        assert!(Request::decode(&packet, 0x81).is_err());
    }
}

#[test]
fn roboclaw_replies_equal_the_golden_bytes() {
    for (request, hex, number) in [
        (Request::Encoder { second: false }, "00 00 00 64 00 76 93", 100),
        (Request::Encoder { second: true }, "FF FF FF 9C 02 57 76", 100_u32.wrapping_neg()),
        (Request::Speed { second: false }, "00 00 03 E8 00 FA 76", 1000),
        (Request::Battery, "00 F0 D8 E5", 240),
        (Request::Status, "00 00 00 01 97 9D", 1),
        (Request::GetTimeout, "05 7B C1", 5),
        (Request::Drive([1, 2]), "FF", 0),
    ] {
        let reply_bytes = bytes(hex);
        assert_eq!(request.reply_length(4), reply_bytes.len());
        assert_eq!(request.reply(0x80, &reply_bytes), Some(number));
        for bit in 0..8 * reply_bytes.len() {
            let mut damaged = reply_bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(request.reply(0x80, &damaged), None, "{request:?} bit {bit}");
        }
    }
    // The reply to another request is invalid.
    let other = Request::Encoder { second: true };
    assert_eq!(other.reply(0x80, &bytes("00 00 00 64 00 76 93")), None);
}

#[test]
fn arduino_answer_has_firmware_spelling_only() {
    let counts = |first: i32, second: i32| Some(Answer::Counts([first as u32, second as u32]));
    for (line, answer) in [
        ("OK", Some(Answer::Ok)),
        ("0 0", counts(0, 0)),
        ("1234 -567", counts(1234, -567)),
        ("12 -5", counts(12, -5)),
        ("-2147483648 2147483647", counts(i32::MIN, i32::MAX)),
        ("2147483648 0", None),
        ("12", None),
        ("1 2 3", None),
        ("1  2", None),
        (" 1 2", None),
        ("1 2 ", None),
        ("+1 2", None),
        ("-0 2", None),
        ("01 2", None),
        ("1x 2", None),
        ("ok", None),
        ("OKOK", None),
        ("Invalid Command", None),
        ("", None),
        (" ", None),
    ] {
        assert_eq!(parse_answer(line.as_bytes()), answer, "{line:?}");
    }
    assert_eq!(parse_answer(&[0xFF, 0x20, 0x31]), None);
}

/// Set speeds of a controller that received these bytes, in ticks per cycle.
fn arduino_set_speeds(lines: &[u8]) -> [i32; 2] {
    let settings = BaseSettings::default();
    let mut device = ArduinoDevice::new(settings).expect("valid settings");
    device.receive(lines, 0.0);
    let speeds = device.step(0.0, &MachineState::default(), &mut Vec::new());
    let ticks = speeds.zip(settings.ticks_per_m, |speed, per_m| {
        (speed * per_m * settings.arduino.pid_interval_s).round() as i32
    });
    [ticks.left, ticks.right]
}

#[test]
fn arduino_arguments_are_parsed_like_firmware() {
    assert_eq!(arduino_set_speeds(b"m 20 -30\r"), [20, -30]);
    assert_eq!(arduino_set_speeds(b"m 20\r"), [20, 0]);
    assert_eq!(arduino_set_speeds(b"m 2x0 +3\r"), [2, 0]);
    // Two commands become one with a wild speed if the first loses its carriage return.
    assert_eq!(arduino_set_speeds(b"m 10 10m 20 20\r"), [10, 10]);
    assert_eq!(arduino_set_speeds(b"m 10 1020 20\r"), [10, 102_020]);
}
