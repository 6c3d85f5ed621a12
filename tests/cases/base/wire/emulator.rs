//! The emulated base against every session: it drives as it is told, and each trouble is found and named.

use inbye::base::{
    BaseSample, BaseSettings, CommandStats, Emulator, FaultDetector, FaultDetectorSettings, Faults,
    InjectedFault, Protocol, ScheduledFault, Session, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::{Mixer, Side};

/// One turn of both loops, seconds.
const TURN_S: f64 = 0.002;
/// Turns from one command to the next: 50 a second.
const TURNS_PER_COMMAND: usize = 10;

const CURVE: Twist = Twist::new(0.4, 0.3);

/// A session with its ramp and its judge, and an emulated base, without a line between them.
struct Pair {
    emulator: Emulator,
    session: Box<dyn Session>,
    mixer: Mixer,
    judge: FaultDetector,
    turns: usize,
    verdict: Option<(f64, StopCause)>,
    bytes: Vec<u8>,
}

impl Pair {
    fn new(protocol: Protocol, seed: u64) -> Self {
        let settings = BaseSettings::default();
        Self {
            emulator: Emulator::new(protocol, settings, seed).expect("valid settings"),
            session: protocol.session(settings).expect("valid settings"),
            mixer: Mixer::new(settings.drive(), settings.tracks),
            judge: FaultDetector::new(&settings, FaultDetectorSettings::default())
                .expect("valid settings"),
            turns: 0,
            verdict: None,
            bytes: Vec::new(),
        }
    }

    fn with(protocol: Protocol, troubles: &[ScheduledFault]) -> Self {
        let mut pair = Self::new(protocol, 1);
        for trouble in troubles {
            pair.emulator.schedule(*trouble);
        }
        pair
    }

    fn now_s(&self) -> f64 {
        TURN_S * self.turns as f64
    }

    /// Commands a motion for a time, unless the judge has spoken.
    fn keep_on(&mut self, wanted: Twist, time_s: f64) {
        for _ in 0..(time_s / TURN_S).round() as usize {
            if self.turns.is_multiple_of(TURNS_PER_COMMAND) {
                let wanted = self.verdict.map_or(wanted, |_| Twist::STOP);
                let told = self.mixer.mix(&wanted, TURN_S * TURNS_PER_COMMAND as f64);
                let told = self.mixer.twist(&told);
                self.session.command(&told).expect("a finite command");
                self.update(told);
            }
            self.turn();
        }
    }

    fn update(&mut self, sent: Twist) {
        let now_s = self.now_s();
        let Some(heard) = self.session.latest() else {
            return;
        };
        let look = BaseSample {
            now_s,
            sent,
            feedback: heard.feedback,
        };
        if let (None, Some(verdict)) = (self.verdict, self.judge.update(&look)) {
            self.verdict = Some((now_s, *verdict));
        }
    }

    fn wait(&mut self, time_s: f64) {
        for _ in 0..(time_s / TURN_S).round() as usize {
            self.turns += 1;
            self.emulator.step(self.now_s(), &mut Vec::new());
        }
    }

    fn turn(&mut self) {
        self.turns += 1;
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
fn every_protocol_drives_the_machine_and_reports_its_way() {
    for protocol in Protocol::ALL {
        let mut pair = Pair::new(protocol, 1);
        pair.keep_on(CURVE, 4.0);
        let (truth, reported) = (
            pair.emulator.twist(),
            pair.session.latest().expect("feedback").feedback.twist,
        );
        for twist in [truth, reported] {
            assert!((twist.linear - 0.4).abs() < 0.03, "{protocol:?}: {twist:?}");
            assert!(
                (twist.angular - 0.3).abs() < 0.06,
                "{protocol:?}: {twist:?}"
            );
        }
        let way_m = pair.emulator.travelled_m();
        // 4 s at 0.4 m/s, less a ramp of 0.3 s, a lag and the connecting.
        assert!((1.4..1.6).contains(&way_m), "{protocol:?}: {way_m}");
        assert_eq!(pair.verdict, None);
        pair.keep_on(Twist::STOP, 1.5);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        let orders = pair.emulator.command_stats();
        assert!(orders.commands > 200 && orders.final_zero_commands > 40);
        assert_eq!(orders.watchdog_stops, 0);
    }
}

#[test]
fn a_base_whose_host_is_gone_stops_by_its_watchdog_where_it_has_one() {
    for (protocol, stops) in [
        (Protocol::Native, 1),
        (Protocol::Roboclaw, 1),
        (Protocol::Arduino, 1),
        (Protocol::Wheeltec, 0),
    ] {
        let mut pair = Pair::new(protocol, 1);
        pair.keep_on(CURVE, 2.0);
        pair.wait(4.0);
        let CommandStats {
            watchdog_stops,
            final_zero_commands,
            ..
        } = pair.emulator.command_stats();
        assert_eq!(
            (watchdog_stops, final_zero_commands),
            (stops, 0),
            "{protocol:?}"
        );
        let stands = pair.emulator.twist() == Twist::STOP;
        assert_eq!(stands, stops == 1, "{protocol:?}");
    }
}

#[test]
fn the_battery_sags_under_load_and_runs_down() {
    let mut pair = Pair::new(Protocol::Native, 1);
    pair.keep_on(Twist::STOP, 0.1);
    let full_v = pair.emulator.machine().battery_v;
    pair.keep_on(Twist::new(1.2, 0.0), 0.5);
    let starting_v = pair.emulator.machine().battery_v;
    pair.keep_on(Twist::new(1.2, 0.0), 10.0);
    pair.keep_on(Twist::STOP, 3.0);
    let rested_v = pair.emulator.machine().battery_v;
    assert!(starting_v < full_v - 0.15, "{starting_v} of {full_v}");
    assert!(
        rested_v > starting_v && rested_v < full_v,
        "{rested_v} of {full_v}"
    );
}

/// What a healthy machine is told, and when a trouble begins.
fn judged(protocol: Protocol, fault: InjectedFault) -> Option<(f64, StopCause)> {
    let mut pair = Pair::with(protocol, &[ScheduledFault::from(fault, 2.0)]);
    pair.keep_on(Twist::new(0.5, 0.0), 6.0);
    let (at_s, verdict) = pair.verdict?;
    Some((at_s - 2.0, verdict))
}

#[test]
fn each_trouble_of_the_machine_is_found_by_every_host() {
    for protocol in Protocol::ALL {
        let side = |verdict: &StopCause| match verdict {
            StopCause::Stuck { side, .. } => Some(*side),
            _ => None,
        };
        for (trouble, at) in [
            (InjectedFault::StuckLeft, Side::Left),
            (InjectedFault::StuckRight, Side::Right),
        ] {
            let (after_s, verdict) = judged(protocol, trouble).expect("a verdict");
            assert_eq!(side(&verdict), Some(at), "{protocol:?}: {verdict}");
            assert!(after_s < 1.5, "{protocol:?}: {after_s}");
        }
        let (after_s, verdict) = judged(protocol, InjectedFault::Runaway).expect("a verdict");
        assert!(matches!(
            verdict,
            StopCause::Runaway {
                side: Side::Left,
                ..
            }
        ));
        assert!(after_s < 1.0, "{protocol:?}: {after_s}");
        let (after_s, verdict) = judged(protocol, InjectedFault::Reversed).expect("a verdict");
        assert!(matches!(
            verdict,
            StopCause::Reversed {
                side: Side::Left,
                ..
            }
        ));
        assert!(after_s < 1.5, "{protocol:?}: {after_s}");
    }
}

#[test]
fn the_button_stops_the_motors_and_is_told_where_the_protocol_can() {
    for protocol in Protocol::ALL {
        let button = ScheduledFault::from(InjectedFault::Button, 2.0);
        let mut pair = Pair::with(protocol, &[button]);
        pair.keep_on(Twist::new(0.5, 0.0), 3.0);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        match protocol {
            // It has no word for it: the tracks stand though they are told to run.
            Protocol::Arduino => assert_eq!(pair.verdict, None),
            _ => assert_eq!(
                pair.verdict.map(|(_, verdict)| verdict),
                Some(StopCause::EmergencyStop),
                "{protocol:?}"
            ),
        }
    }
}

/// Two troubles at once, of which the button is the stronger.
#[test]
fn the_button_stops_even_a_runaway() {
    let mut pair = Pair::with(
        Protocol::Native,
        &[
            ScheduledFault::from(InjectedFault::Runaway, 0.5),
            "button@2..3".parse().expect("a name and times"),
        ],
    );
    pair.keep_on(Twist::STOP, 1.9);
    assert!(pair.emulator.twist().linear > 0.7);
    pair.keep_on(Twist::STOP, 1.0);
    assert_eq!(pair.emulator.twist(), Twist::STOP);
    pair.keep_on(Twist::STOP, 1.0);
    assert!(pair.emulator.twist().linear > 0.5);
}

#[test]
fn a_damaged_line_costs_commands_and_never_invents_motion() {
    for protocol in [Protocol::Native, Protocol::Wheeltec, Protocol::Roboclaw] {
        for trouble in [InjectedFault::Garbage, InjectedFault::BitFlips] {
            let mut pair = Pair::with(protocol, &[ScheduledFault::from(trouble, 1.0)]);
            for _ in 0..50 {
                pair.keep_on(Twist::new(0.4, 0.0), 0.2);
                let speed = pair.emulator.twist().linear;
                assert!(speed < 0.55, "{protocol:?} {trouble}: {speed}");
            }
            let counters = pair.session.counters();
            assert!(
                counters.dropped_bytes + counters.retries > 0,
                "{protocol:?} {trouble}: {counters:?}"
            );
            assert!(pair.emulator.twist().linear > 0.3, "{protocol:?} {trouble}");
        }
    }
}

#[test]
fn silence_ends_the_feedback_and_slow_reads_delay_the_commands() {
    let silence = ScheduledFault::from(InjectedFault::Silence, 1.0);
    for protocol in Protocol::ALL {
        let mut pair = Pair::with(protocol, &[silence]);
        pair.keep_on(CURVE, 2.0);
        let heard_s = pair.session.latest().expect("feedback before").received_s;
        assert!(heard_s < 1.01, "{protocol:?}: {heard_s}");
        assert!(pair.emulator.twist().linear > 0.3, "{protocol:?}");
        // It still hears: the host's zeros stop it, by whichever conversation.
        pair.session = protocol
            .session(BaseSettings::default())
            .expect("as before");
        pair.keep_on(Twist::STOP, 1.5);
        assert_eq!(pair.emulator.twist(), Twist::STOP, "{protocol:?}");
        assert_eq!(
            pair.emulator.command_stats().watchdog_stops,
            0,
            "{protocol:?}"
        );
    }

    let slow = ScheduledFault::from(InjectedFault::SlowReads, 0.0);
    let mut pair = Pair::with(Protocol::Native, &[slow]);
    pair.keep_on(CURVE, 0.29);
    assert_eq!(pair.emulator.command_stats().commands, 0);
    pair.keep_on(CURVE, 0.1);
    assert!(pair.emulator.command_stats().commands > 0);
}

/// Our own frames say which command was taken last; without that a late base looks like one that is slow to start.
#[test]
fn a_base_that_is_behind_with_its_commands_is_found_where_it_says_so() {
    let (after_s, verdict) = judged(Protocol::Native, InjectedFault::SlowReads).expect("a verdict");
    assert!(
        matches!(verdict, StopCause::CommandDelay { delay_s } if (0.2..0.5).contains(&delay_s)),
        "{verdict}"
    );
    assert!(after_s < 1.2, "{after_s}");
    assert_eq!(judged(Protocol::Wheeltec, InjectedFault::SlowReads), None);
}

#[test]
fn the_same_seed_is_the_same_base_and_another_is_not() {
    let run = |seed| {
        let mut pair = Pair::new(Protocol::Native, seed);
        for trouble in [InjectedFault::Garbage, InjectedFault::BitFlips] {
            pair.emulator.schedule(ScheduledFault::from(trouble, 0.5));
        }
        pair.keep_on(CURVE, 3.0);
        pair.bytes
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn a_healthy_base_reports_no_fault() {
    let mut pair = Pair::new(Protocol::Native, 1);
    pair.keep_on(CURVE, 1.0);
    let feedback = pair.session.latest().expect("feedback").feedback;
    assert_eq!(feedback.faults, Faults::NONE);
    assert!(feedback.battery_v.is_some_and(|volts| volts > 24.0));
    assert!(
        feedback
            .yaw_rate
            .is_some_and(|rate| (rate - 0.3).abs() < 0.05)
    );
}
