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

use inbye::base::Faults;
use inbye::base::arduino::{Answer, parse_answer};
use inbye::base::native::{Command, Decoder, Frame, Report};
use inbye::base::roboclaw::{Reply, Request};

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
    for (request, hex, reply) in [
        (Request::Encoder { second: false }, "00 00 00 64 00 76 93", Reply::Encoder(100)),
        (
            Request::Encoder { second: true },
            "FF FF FF 9C 02 57 76",
            Reply::Encoder(100_u32.wrapping_neg()),
        ),
        (Request::Speed { second: false }, "00 00 03 E8 00 FA 76", Reply::Speed(1000)),
        (Request::Battery, "00 F0 D8 E5", Reply::Battery(240)),
        (Request::Status, "00 00 00 01 97 9D", Reply::Status(1)),
        (Request::GetTimeout, "05 7B C1", Reply::Timeout(5)),
        (Request::Drive([1, 2]), "FF", Reply::Ack),
    ] {
        let reply_bytes = bytes(hex);
        assert_eq!(request.reply_length(4), reply_bytes.len());
        assert_eq!(request.reply(0x80, &reply_bytes), Some(reply));
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
fn arduino_answers_are_exact() {
    assert_eq!(parse_answer(b"12 -5"), Some(Answer::Counts([12, 5_u32.wrapping_neg()])));
    assert_eq!(parse_answer(b"12 -5 7"), None);
}
