//! Track speeds from encoder counts, as a native session reports them.

use inbye::base::native::{NativeSession, Report};
use inbye::base::{BaseSettings, Faults, Feedback, Session};
use inbye::robot::TrackSpeeds;

/// A host that receives reports. Its tracks run at most 1.25 m/s and have 10,000 ticks per metre: with all margins 937.5 ticks
/// at once and 18,750 per second.
struct Host {
    session: NativeSession,
    sequence: u16,
}

impl Host {
    fn new() -> Self {
        let session = NativeSession::new(BaseSettings::default()).expect("valid settings");
        Self { session, sequence: 0 }
    }

    /// Receives counts by the base's clock. Returns the feedback, unless the counts are rejected.
    fn receive(&mut self, counts: [u32; 2], time_ms: u32) -> Option<Feedback> {
        self.sequence += 1;
        let report = Report { sequence: self.sequence, time_ms, counts, ..Report::default() };
        let received_s = f64::from(self.sequence);
        self.session.receive(&report.encode(), received_s);
        let latest = self.session.latest().filter(|latest| latest.received_s == received_s);
        latest.map(|latest| latest.feedback)
    }

    fn rejected(&self) -> u64 {
        self.session.counters().rejected_readings
    }
}

fn speeds(feedback: &Feedback) -> TrackSpeeds {
    BaseSettings::default().drive().tracks(&feedback.twist)
}

#[test]
fn speeds_are_averaged_across_counter_wrap() {
    let mut host = Host::new();
    let start = u32::MAX - 50;
    for tick in 0..20_u32 {
        let counts = [start.wrapping_add(100 * tick), start.wrapping_sub(50 * tick)];
        let feedback = host.receive(counts, 20 * tick).expect("plausible");
        if tick > 0 {
            let speeds = speeds(&feedback);
            assert!((speeds.left - 0.5).abs() < 1e-9, "{speeds:?}");
            assert!((speeds.right + 0.25).abs() < 1e-9, "{speeds:?}");
        }
    }
}

#[test]
fn single_jump_is_rejected_without_fault() {
    let mut host = Host::new();
    host.receive([0; 2], 0);
    assert_eq!(host.receive([100_000, 0], 20), None);
    let feedback = host.receive([200; 2], 40).expect("plausible");
    assert_eq!((host.rejected(), feedback.faults), (1, Faults::NONE));
}

#[test]
fn counter_reset_is_fault_and_no_motion() {
    let mut host = Host::new();
    host.receive([1_000_000; 2], 0);
    assert_eq!(host.receive([0; 2], 20), None);
    assert_eq!(host.receive([10; 2], 40), None);
    let feedback = host.receive([20; 2], 60).expect("the counters were reset");
    assert_eq!(speeds(&feedback), TrackSpeeds::default());
    assert_eq!(feedback.faults, Faults::ENCODER);
    host.session.release();
    let feedback = host.receive([30; 2], 80).expect("plausible");
    assert_eq!((host.rejected(), feedback.faults), (3, Faults::NONE));
}

#[test]
fn inconsistent_readings_are_always_rejected() {
    let mut host = Host::new();
    host.receive([0; 2], 0);
    for step in 1..50_u32 {
        assert_eq!(host.receive([step.wrapping_mul(0x9E37_79B9), 0], 20 * step), None);
    }
    assert_eq!(host.rejected(), 49);
}

#[test]
fn readings_at_constant_time_are_plausible() {
    let mut host = Host::new();
    for tick in 0..1000 {
        // The base's clock stands still.
        assert!(host.receive([tick; 2], 3000).is_some());
    }
    let feedback = host.receive([1999; 2], 3100).expect("plausible");
    let speeds = speeds(&feedback);
    assert!((speeds.left - 1.0).abs() < 1e-9, "{speeds:?}");
}

#[test]
fn backward_time_is_rejected() {
    let mut host = Host::new();
    host.receive([0; 2], 5000);
    assert_eq!(host.receive([0; 2], 100), None);
}
