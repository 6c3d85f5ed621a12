//! The emulated base with every session: it follows commands, and each injected fault is detected.

use inbye::base::{
    BaseSample, BaseSettings, CommandStats, Emulator, FaultDetector, FaultDetectorSettings, Faults,
    InjectedFault, Protocol, ScheduledFault, Session, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::{Mixer, Side};

/// Simulation step, seconds.
const STEP_S: f64 = 0.002;
/// Steps between commands: 50 commands per second.
const STEPS_PER_COMMAND: usize = 10;

const CURVE: Twist = Twist::new(0.4, 0.3);

/// A session with ramps and fault detector, and an emulated base, without a line between them.
pub struct Pair {
    pub emulator: Emulator,
    pub session: Box<dyn Session>,
    mixer: Mixer,
    detector: FaultDetector,
    steps: usize,
    pub cause: Option<(f64, StopCause)>,
    bytes: Vec<u8>,
}

impl Pair {
    pub fn new(protocol: Protocol, seed: u64) -> Self {
        let settings = BaseSettings::default();
        Self {
            emulator: Emulator::new(protocol, settings, seed).expect("valid settings"),
            session: protocol.session(settings).expect("valid settings"),
            mixer: Mixer::new(settings.drive(), settings.tracks),
            detector: FaultDetector::new(&settings, FaultDetectorSettings::default())
                .expect("valid settings"),
            steps: 0,
            cause: None,
            bytes: Vec::new(),
        }
    }

    pub fn with(protocol: Protocol, faults: &[ScheduledFault]) -> Self {
        let mut pair = Self::new(protocol, 1);
        for fault in faults {
            pair.emulator.schedule(*fault);
        }
        pair
    }

    fn now_s(&self) -> f64 {
        STEP_S * self.steps as f64
    }

    /// Commands a motion for a time, or zero after a fault was detected.
    pub fn drive_for(&mut self, target: Twist, time_s: f64) {
        for _ in 0..(time_s / STEP_S).round() as usize {
            if self.steps.is_multiple_of(STEPS_PER_COMMAND) {
                let target = self.cause.map_or(target, |_| Twist::STOP);
                let speeds = self.mixer.mix(&target, STEP_S * STEPS_PER_COMMAND as f64);
                let command = self.mixer.twist(&speeds);
                self.session.command(&command).expect("a finite command");
                self.detect(command);
            }
            self.step();
        }
    }

    fn detect(&mut self, sent: Twist) {
        let now_s = self.now_s();
        let Some(latest) = self.session.latest() else {
            return;
        };
        let sample = BaseSample { now_s, sent, feedback: latest.feedback };
        if let (None, Some(cause)) = (self.cause, self.detector.update(&sample)) {
            self.cause = Some((now_s, *cause));
        }
    }

    fn wait(&mut self, time_s: f64) {
        for _ in 0..(time_s / STEP_S).round() as usize {
            self.steps += 1;
            self.emulator.step(self.now_s(), &mut Vec::new());
        }
    }

    fn step(&mut self) {
        self.steps += 1;
        let now_s = self.now_s();
        let mut line = Vec::new();
        self.session.transmit(now_s, &mut line);
        self.emulator.receive(&line, now_s);
        line.clear();
        self.emulator.step(now_s, &mut line);
        self.bytes.extend(&line);
        self.session.receive(&line, now_s);
    }
}

#[test]
fn every_protocol_drives_machine_and_reports_motion() {
    for protocol in Protocol::ALL {
        let mut pair = Pair::new(protocol, 1);
        pair.drive_for(CURVE, 4.0);
        let (truth, reported) =
            (pair.emulator.twist(), pair.session.latest().expect("feedback").feedback.twist);
        for twist in [truth, reported] {
            assert!((twist.linear - 0.4).abs() < 0.03, "{protocol:?}: {twist:?}");
            assert!((twist.angular - 0.3).abs() < 0.06, "{protocol:?}: {twist:?}");
        }
        let travelled_m = pair.emulator.travelled_m();
        // 4 s at 0.4 m/s, less a ramp of 0.3 s, the lag and the time to connect.
        assert!((1.4..1.6).contains(&travelled_m), "{protocol:?}: {travelled_m}");
        assert_eq!(pair.cause, None);
        pair.drive_for(Twist::STOP, 1.5);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        let stats = pair.emulator.command_stats();
        assert!(stats.commands > 200 && stats.final_zero_commands > 40);
        assert_eq!(stats.watchdog_stops, 0);
    }
}

#[test]
fn watchdog_stops_base_without_host() {
    for (protocol, stops) in [
        (Protocol::Native, 1),
        (Protocol::Roboclaw, 1),
        (Protocol::Arduino, 1),
        (Protocol::Wheeltec, 0),
    ] {
        let mut pair = Pair::new(protocol, 1);
        pair.drive_for(CURVE, 2.0);
        pair.wait(4.0);
        let CommandStats { watchdog_stops, final_zero_commands, .. } =
            pair.emulator.command_stats();
        assert_eq!((watchdog_stops, final_zero_commands), (stops, 0), "{protocol:?}");
        let stands = pair.emulator.twist() == Twist::STOP;
        assert_eq!(stands, stops == 1, "{protocol:?}");
    }
}

#[test]
fn battery_sags_under_load_and_discharges() {
    let mut pair = Pair::new(Protocol::Native, 1);
    pair.drive_for(Twist::STOP, 0.1);
    let full_v = pair.emulator.machine().battery_v;
    pair.drive_for(Twist::new(1.2, 0.0), 0.5);
    let loaded_v = pair.emulator.machine().battery_v;
    pair.drive_for(Twist::new(1.2, 0.0), 10.0);
    pair.drive_for(Twist::STOP, 3.0);
    let rested_v = pair.emulator.machine().battery_v;
    assert!(loaded_v < full_v - 0.15, "{loaded_v} of {full_v}");
    assert!(rested_v > loaded_v && rested_v < full_v, "{rested_v} of {full_v}");
}

/// The detected fault of a machine with an injected fault, and the time to detect it.
fn detected(protocol: Protocol, fault: InjectedFault) -> Option<(f64, StopCause)> {
    let mut pair = Pair::with(protocol, &[ScheduledFault::from(fault, 2.0)]);
    pair.drive_for(Twist::new(0.5, 0.0), 6.0);
    let (at_s, cause) = pair.cause?;
    Some((at_s - 2.0, cause))
}

#[test]
fn every_machine_fault_is_detected_in_every_protocol() {
    for protocol in Protocol::ALL {
        let side = |cause: &StopCause| match cause {
            StopCause::Stuck { side, .. } => Some(*side),
            _ => None,
        };
        for (fault, at) in
            [(InjectedFault::StuckLeft, Side::Left), (InjectedFault::StuckRight, Side::Right)]
        {
            let (after_s, cause) = detected(protocol, fault).expect("a cause");
            assert_eq!(side(&cause), Some(at), "{protocol:?}: {cause}");
            assert!(after_s < 1.5, "{protocol:?}: {after_s}");
        }
        let (after_s, cause) = detected(protocol, InjectedFault::Runaway).expect("a cause");
        assert!(matches!(cause, StopCause::Runaway { side: Side::Left, .. }));
        assert!(after_s < 1.0, "{protocol:?}: {after_s}");
        let (after_s, cause) = detected(protocol, InjectedFault::Reversed).expect("a cause");
        assert!(matches!(cause, StopCause::Reversed { side: Side::Left, .. }));
        assert!(after_s < 1.5, "{protocol:?}: {after_s}");
    }
}

#[test]
fn button_stops_motors_and_is_reported_if_protocol_can() {
    for protocol in Protocol::ALL {
        let button = ScheduledFault::from(InjectedFault::Button, 2.0);
        let mut pair = Pair::with(protocol, &[button]);
        pair.drive_for(Twist::new(0.5, 0.0), 3.0);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        match protocol {
            // The protocol cannot report it, but the base does not move.
            Protocol::Arduino => assert!(
                matches!(pair.cause, Some((at_s, StopCause::IgnoresCommands { .. })) if at_s < 3.0),
                "{:?}",
                pair.cause
            ),
            _ => assert_eq!(
                pair.cause.map(|(_, cause)| cause),
                Some(StopCause::EmergencyStop),
                "{protocol:?}"
            ),
        }
    }
}

#[test]
fn button_stops_runaway() {
    let mut pair = Pair::with(
        Protocol::Native,
        &[
            ScheduledFault::from(InjectedFault::Runaway, 0.5),
            "button@2..3".parse().expect("a name and times"),
        ],
    );
    pair.drive_for(Twist::STOP, 1.9);
    assert!(pair.emulator.twist().linear > 0.7);
    pair.drive_for(Twist::STOP, 1.0);
    assert_eq!(pair.emulator.twist(), Twist::STOP);
    pair.drive_for(Twist::STOP, 1.0);
    assert!(pair.emulator.twist().linear > 0.5);
}

#[test]
fn damaged_line_loses_commands_but_invents_no_motion() {
    for protocol in [Protocol::Native, Protocol::Wheeltec, Protocol::Roboclaw] {
        for fault in [InjectedFault::Garbage, InjectedFault::BitFlips] {
            let mut pair = Pair::with(protocol, &[ScheduledFault::from(fault, 1.0)]);
            for _ in 0..50 {
                pair.drive_for(Twist::new(0.4, 0.0), 0.2);
                let speed = pair.emulator.twist().linear;
                assert!(speed < 0.55, "{protocol:?} {fault}: {speed}");
            }
            let counters = pair.session.counters();
            assert!(
                counters.dropped_bytes + counters.retries > 0,
                "{protocol:?} {fault}: {counters:?}"
            );
            assert!(pair.emulator.twist().linear > 0.3, "{protocol:?} {fault}");
        }
    }
}

#[test]
fn silence_ends_feedback_and_slow_reads_delay_commands() {
    let silence = ScheduledFault::from(InjectedFault::Silence, 1.0);
    for protocol in Protocol::ALL {
        let mut pair = Pair::with(protocol, &[silence]);
        pair.drive_for(CURVE, 2.0);
        let received_s = pair.session.latest().expect("feedback before").received_s;
        assert!(received_s < 1.01, "{protocol:?}: {received_s}");
        // A RoboClaw's watchdog is reset by every request, so that its session sends zeros.
        let drives_on = protocol != Protocol::Roboclaw;
        assert_eq!(pair.emulator.twist().linear > 0.3, drives_on, "{protocol:?}");
        // It still receives: zeros of another session stop it.
        pair.session = protocol.session(BaseSettings::default()).expect("as before");
        pair.drive_for(Twist::STOP, 1.5);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        assert_eq!(pair.emulator.command_stats().watchdog_stops, 0, "{protocol:?}");
    }

    let slow = ScheduledFault::from(InjectedFault::SlowReads, 0.0);
    let mut pair = Pair::with(Protocol::Native, &[slow]);
    pair.drive_for(CURVE, 0.29);
    assert_eq!(pair.emulator.command_stats().commands, 0);
    pair.drive_for(CURVE, 0.1);
    assert!(pair.emulator.command_stats().commands > 0);
}

/// Native reports acknowledge commands; without that a late base looks like one that starts slowly.
#[test]
fn command_delay_is_detected_in_native_protocol_only() {
    let (after_s, cause) = detected(Protocol::Native, InjectedFault::SlowReads).expect("a cause");
    assert!(
        matches!(cause, StopCause::CommandDelay { delay_s } if (0.2..0.5).contains(&delay_s)),
        "{cause}"
    );
    assert!(after_s < 1.2, "{after_s}");
    assert_eq!(detected(Protocol::Wheeltec, InjectedFault::SlowReads), None);
}

#[test]
fn emulator_is_reproducible_by_seed() {
    let run = |seed| {
        let mut pair = Pair::new(Protocol::Native, seed);
        for fault in [InjectedFault::Garbage, InjectedFault::BitFlips] {
            pair.emulator.schedule(ScheduledFault::from(fault, 0.5));
        }
        pair.drive_for(CURVE, 3.0);
        pair.bytes
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn healthy_base_reports_no_fault() {
    let mut pair = Pair::new(Protocol::Native, 1);
    pair.drive_for(CURVE, 1.0);
    let feedback = pair.session.latest().expect("feedback").feedback;
    assert_eq!(feedback.faults, Faults::NONE);
    assert!(feedback.battery_v.is_some_and(|volts| volts > 24.0));
    assert!(feedback.yaw_rate.is_some_and(|rate| (rate - 0.3).abs() < 0.05));
}

#[test]
fn scheduled_fault_includes_its_start_and_excludes_its_end() {
    let mut emulator =
        Emulator::new(Protocol::Native, BaseSettings::default(), 1).expect("valid settings");
    emulator.schedule("silence@2..3.5".parse().expect("a name and times"));
    let is_silent = [1.9, 2.0, 3.4, 3.5].map(|now_s| {
        // A report is due at each of these times.
        let mut line = Vec::new();
        emulator.step(now_s, &mut line);
        line.is_empty()
    });
    assert_eq!(is_silent, [false, true, true, false]);
}

#[test]
fn scheduled_fault_parses_every_name_and_its_times() {
    for fault in InjectedFault::ALL {
        let scheduled: ScheduledFault =
            fault.to_string().parse().expect("a name, or a name and times");
        assert_eq!(scheduled, ScheduledFault::from(fault, 0.0));
    }
    let scheduled: ScheduledFault = "button@2..3.5".parse().expect("a name, or a name and times");
    let (fault, from_s) = (InjectedFault::Button, 2.0);
    assert_eq!(scheduled, ScheduledFault { fault, from_s, to_s: 3.5 });
    for (text, words) in [
        ("stuck", "`stuck` is not a fault: use one of stuck-left, "),
        ("button@", "`` is not a time"),
        ("button@x", "`x` is not a time"),
        ("button@-1", "`-1` is not a time"),
        ("button@NaN", "`NaN` is not a time"),
        ("button@3..2", "`3..2` is not a time"),
    ] {
        let message = text.parse::<ScheduledFault>().unwrap_err();
        assert!(message.starts_with(words), "{message}");
    }
}

/// A fault of a sensor changes what the base reports exactly with the protocols that it names.
#[test]
fn faults_of_sensors_show_with_their_protocols_only() {
    for protocol in Protocol::ALL {
        let reports = |faults: &[ScheduledFault]| {
            let mut pair = Pair::with(protocol, faults);
            pair.drive_for(Twist::STOP, 2.0);
            pair.bytes
        };
        let healthy = reports(&[]);
        for fault in [
            InjectedFault::Tilt,
            InjectedFault::Bumper,
            InjectedFault::Cliff,
            InjectedFault::GyroBiased,
            InjectedFault::LowBattery,
        ] {
            let shows = reports(&[ScheduledFault::from(fault, 1.0)]) != healthy;
            assert_eq!(shows, fault.protocols().contains(&protocol), "{protocol:?}: {fault}");
        }
    }
}
