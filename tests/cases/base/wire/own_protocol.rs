//! A protocol that another crate adds: lines of text with a speed and a turn rate.

use inbye::base::{BaseError, BaseSettings, Feedback, Session, SessionCore};
use inbye::geometry::Twist;

/// Host session of a toy protocol. Commands and reports are `LINEAR ANGULAR`, m/s and rad/s.
struct TextSession {
    core: SessionCore,
    line: Vec<u8>,
}

impl TextSession {
    fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        Ok(Self { core: SessionCore::new(settings)?, line: Vec::new() })
    }
}

fn parse(line: &[u8]) -> Option<Twist> {
    let (linear, angular) = str::from_utf8(line).ok()?.split_once(' ')?;
    Some(Twist::new(linear.parse().ok()?, angular.parse().ok()?))
}

impl Session for TextSession {
    fn core(&self) -> &SessionCore {
        &self.core
    }

    fn core_mut(&mut self) -> &mut SessionCore {
        &mut self.core
    }

    fn baud(&self) -> u32 {
        9600
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        for byte in bytes {
            if *byte != b'\n' {
                self.line.push(*byte);
                continue;
            }
            let line = std::mem::take(&mut self.line);
            match parse(&line) {
                Some(twist) => self.core.report(Feedback { twist, ..Feedback::default() }, now_s),
                None => self.core.counters.dropped_bytes += line.len() as u64,
            }
        }
    }

    fn transmit(&mut self, _now_s: f64, line: &mut Vec<u8>) {
        if std::mem::take(&mut self.core.is_pending) {
            let Twist { linear, angular } = self.core.target;
            line.extend(format!("{linear} {angular}\n").into_bytes());
        }
    }
}

/// The session as `SerialBase` takes it.
fn session() -> Box<dyn Session> {
    Box::new(TextSession::new(BaseSettings::default()).expect("valid settings"))
}

fn sent(session: &mut dyn Session) -> Vec<u8> {
    let mut line = Vec::new();
    session.transmit(0.0, &mut line);
    line
}

#[test]
fn own_protocol_sends_each_command_once_and_within_limits() {
    let mut session = session();
    assert_eq!(sent(&mut *session), b"");
    session.command(&Twist::new(0.5, -0.25)).expect("a finite command");
    assert_eq!(sent(&mut *session), b"0.5 -0.25\n");
    assert_eq!(sent(&mut *session), b"");
    assert!(session.command(&Twist::new(f64::NAN, 0.0)).is_err());
    assert_eq!(sent(&mut *session), b"");
    session.command(&Twist::new(1000.0, 0.0)).expect("a finite command");
    let limited = sent(&mut *session);
    let speed = parse(limited.trim_ascii_end()).expect("two numbers").linear;
    assert!((speed - BaseSettings::default().tracks.max_track_speed).abs() < 1e-9, "{speed}");
}

#[test]
fn own_protocol_reports_feedback_and_line_errors() {
    let mut session = session();
    session.receive(b"0.5 0.1\n0.", 1.0);
    let latest = session.latest().copied().expect("a report");
    assert_eq!((latest.received_s, latest.feedback.twist), (1.0, Twist::new(0.5, 0.1)));
    session.receive(b"4 0\n?!\n", 2.0);
    let latest = session.latest().copied().expect("a report");
    assert_eq!((latest.received_s, latest.feedback.twist), (2.0, Twist::new(0.4, 0.0)));
    assert_eq!(session.counters().dropped_bytes, 2);
}

#[test]
fn own_protocol_without_latch_stops_by_zero_commands() {
    let mut session = session();
    session.command(&Twist::new(0.5, 0.0)).expect("a finite command");
    session.engage_stop();
    assert_eq!(sent(&mut *session), b"0 0\n");
    session.release();
    assert_eq!(sent(&mut *session), b"0 0\n");
}
