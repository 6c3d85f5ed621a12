//! The native protocol, version 1: a specification for authors of base firmware, in any language.
//!
//! # The line
//!
//! 115,200 baud, 8 data bits, no parity, 1 stop bit; over USB the speed does not matter. A frame on the line is
//!
//! ```text
//! 00  COBS(payload)  00
//! ```
//!
//! COBS (Cheshire and Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on Networking 7 (2), 1999) encodes
//! the payload without zero bytes; so a zero always ends a frame. Payloads are shorter than 254 bytes and grow by one. The leading zero confines the damage of noise or a cut frame to that frame: a receiver takes the
//! bytes between two zeros, ignores an empty piece, and drops one that is longer than 32 bytes.
//!
//! Numbers are little-endian, signed ones two's complement. The last two bytes of a payload are the CRC-16 of all before
//! them, low byte first: polynomial `1021`, initial value `FFFF`, not reflected, no final exclusive or (CRC-16/IBM-3740,
//! also called CCITT-FALSE; the check value of the ASCII digits `123456789` is 29B1h).
//!
//! A receiver accepts a payload only if its length, version, kind and CRC are as below and no reserved bit is set.
//!
//! # Command, host to base: 15 bytes, 18 on the line
//!
//! | byte | type | content |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | kind, 43h (`C`) |
//! | 2 | u16 | sequence: one more for each command, wraps |
//! | 4 | u8 | bit 0: engage the stop; bit 1: release the stop; others reserved, 0 |
//! | 5 | i32 | set speed of the first channel, encoder ticks per second |
//! | 9 | i32 | set speed of the second channel, the same |
//! | 13 | u16 | CRC |
//!
//! # Report, base to host: 27 bytes, 30 on the line
//!
//! | byte | type | content |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | kind, 52h (`R`) |
//! | 2 | u16 | sequence of the report: one more for each, wraps |
//! | 4 | u16 | echo: sequence of the last command accepted |
//! | 6 | u8 | bit 0: the stop is latched; bit 1: the button is pressed; bit 2: a command was accepted since power-on, so that the echo counts; bit 3: the turn rate counts; bit 4: the battery voltage counts; bit 5: the left bumper is pressed; bit 6: the right bumper is pressed; bit 7: a cliff sensor sees no ground. A base without these sensors sends 0 in bits 5 to 7 |
//! | 7 | u16 | faults, the bits of [`Faults`] |
//! | 9 | u32 | time since power-on when the counters were read, ms, wraps |
//! | 13 | u32 | encoder count of the first channel, wraps |
//! | 17 | u32 | the same of the second |
//! | 21 | i16 | turn rate by the gyro, mrad/s, counter-clockwise |
//! | 23 | u16 | battery voltage, mV |
//! | 25 | u16 | CRC |
//!
//! # Behaviour
//!
//! The host sends commands at a fixed rate, 20 per second or more, and never answers a report. It ignores a report with the
//! sequence of the previous one. From the echo it knows how late the base accepts commands.
//!
//! The base
//! - sends a report every 20 ms from power-on, without a request;
//! - holds both set speeds at zero from power-on until the first command it accepts;
//! - accepts a command if it is valid and its sequence is not that of the last accepted one: a repetition comes from a stuck
//!   buffer, and does not reset the watchdog;
//! - controls the speeds to the set speeds with ramps of its own, at least as a safeguard;
//! - sets both speeds to zero when it has accepted no command for 0.5 s ([`WATCHDOG_S`]), and reports fault bit 7 until
//!   the next one, which ends the watchdog's stop by itself;
//! - latches the stop when the button or a bumper is pressed, when a cliff sensor sees no ground, when a command has bit 0, or
//!   when it detects a fault that it must act on.
//!   While the stop is latched the motors are off and set speeds are ignored; commands are still accepted and echoed;
//! - ends the stop only on a command with bit 1 set, bit 0 clear and both set speeds zero, and only while the button is not
//!   pressed. Releasing the button alone does not end the stop.
//!
//! The host knows the track widths, the length of a tick, swapped and reversed channels, and the limits: the base works in ticks
//! only.
//!
//! # Golden frames
//!
//! Computed by an independent program from the tables above (CRC bit by bit, COBS by hand).
//!
//! ```text
//! command 1, +1000 and -1000 ticks/s      00 04 01 43 01 01 03 E8 03 01 07 18 FC FF FF C0 CE 00
//! command 2, both zero                    00 04 01 43 02 01 01 01 01 01 01 01 01 01 03 03 15 00
//! command 3, engage the stop              00 04 01 43 03 02 01 01 01 01 01 01 01 01 03 69 26 00
//! command 4, release the stop             00 04 01 43 04 02 02 01 01 01 01 01 01 01 03 90 22 00
//! report 7, echo 1, flags 1C, no faults, 5000 ms, counts 100 and -100, -100 mrad/s, 24000 mV
//!                00 04 01 52 07 02 01 02 1C 01 03 88 13 01 02 64 01 01 0B 9C FF FF FF 9C FF C0 5D 99 41 00
//! report 8, echo 3, flags 1D, fault 1, 5020 ms, counts 100 and -100, 0 mrad/s, 23950 mV
//!                00 04 01 52 08 02 03 03 1D 01 03 9C 13 01 02 64 01 01 05 9C FF FF FF 01 05 8E 5D 84 2C 00
//! ```
//!
//! [`Faults`]: super::Faults

mod frames;
mod session;

#[doc(hidden)]
pub use frames::{Command, Decoder, Frame, Report};
#[doc(hidden)]
pub use session::{NativeDevice, NativeSession};

/// Speed of the serial line, baud.
pub const BAUD: u32 = 115_200;

/// Version of the protocol.
pub const VERSION: u8 = 1;

/// Time without an accepted command after which a base stops, seconds: that of the ROS differential drive controller.
pub const WATCHDOG_S: f64 = 0.5;

/// Time between reports, seconds.
pub const REPORT_PERIOD_S: f64 = 0.02;
