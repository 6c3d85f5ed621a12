//! What stops a base: its watchdog, its latched stop, and a set-up that was not confirmed.

use inbye::base::native::{Command, NativeDevice, NativeSession, Report};
use inbye::base::{BaseSettings, DeviceProtocol, Faults, MachineState, Protocol, Session};
use inbye::geometry::Twist;
use inbye::robot::TrackSpeeds;

use super::goldens::bytes;
use super::line::{Conversation, Way};

const AHEAD: Twist = Twist::new(0.4, 0.0);

fn driving(protocol: Protocol) -> Conversation {
    let mut talk = Conversation::new(protocol, BaseSettings::default());
    talk.keep_on(AHEAD, 1.0);
    assert!(
        talk.twist().linear > 0.39,
        "{protocol:?}: {:?}",
        talk.twist()
    );
    talk
}

/// How long after the host fell silent the base was set to stop, seconds; none within 5 s.
fn stops_after(talk: &mut Conversation) -> Option<f64> {
    let before = talk.set.len();
    talk.wait(5.0);
    let stopped = |set: &TrackSpeeds| *set == TrackSpeeds::default();
    let turns = talk.set[before..].iter().position(stopped)?;
    Some(turns as f64 / 1000.0)
}

#[test]
fn a_base_stops_when_its_host_falls_silent_as_its_firmware_does() {
    for (protocol, bound_s) in [
        (Protocol::Native, Some(0.5)),
        (Protocol::Roboclaw, Some(0.5)),
        (Protocol::Arduino, Some(2.0)),
        (Protocol::Wheeltec, None),
    ] {
        let mut talk = driving(protocol);
        talk.host_runs = false;
        let after_s = stops_after(&mut talk);
        match (bound_s, after_s) {
            (Some(bound_s), Some(after_s)) => {
                assert!(after_s <= bound_s + 0.01, "{protocol:?}: {after_s}");
                assert!(after_s >= bound_s - 0.1, "{protocol:?}: {after_s}");
            }
            (None, None) => {}
            other => panic!("{protocol:?}: {other:?}"),
        }
    }
}

/// A session renews no command; yet the questions that it goes on to ask keep a `RoboClaw`'s watchdog quiet.
#[test]
fn without_commands_questions_alone_keep_only_a_roboclaw_running() {
    for (protocol, stops) in [
        (Protocol::Native, true),
        (Protocol::Arduino, true),
        (Protocol::Roboclaw, false),
        (Protocol::Wheeltec, false),
    ] {
        let mut talk = driving(protocol);
        assert_eq!(stops_after(&mut talk).is_some(), stops, "{protocol:?}");
    }
}

#[test]
fn the_watchdog_of_our_own_frames_is_reported_and_ends_with_the_next_command() {
    let mut talk = driving(Protocol::Native);
    talk.wait(0.7);
    assert_eq!(talk.feedback().faults, Faults::WATCHDOG);
    assert!(!talk.feedback().emergency_stop);
    talk.keep_on(AHEAD, 0.3);
    assert_eq!(talk.feedback().faults, Faults::NONE);
    assert!(talk.twist().linear > 0.39);
}

#[test]
fn a_stop_is_latched_until_it_is_released() {
    let mut talk = driving(Protocol::Native);
    talk.session.engage_stop();
    talk.keep_on(AHEAD, 1.0);
    assert!(talk.feedback().emergency_stop && talk.twist().linear < 1e-6);
    talk.session.release();
    talk.wait(0.1);
    assert!(!talk.feedback().emergency_stop && talk.twist().linear < 1e-6);
    talk.keep_on(AHEAD, 0.5);
    assert!(talk.twist().linear > 0.39);
}

#[test]
fn a_button_latches_and_no_release_ends_it_while_it_is_pressed() {
    let mut talk = driving(Protocol::Native);
    talk.machine.button_pressed = true;
    talk.keep_on(AHEAD, 0.5);
    talk.session.release();
    talk.keep_on(AHEAD, 0.5);
    assert!(talk.feedback().emergency_stop && talk.twist().linear < 1e-6);
    talk.machine.button_pressed = false;
    talk.keep_on(AHEAD, 0.5);
    assert!(
        talk.feedback().emergency_stop && talk.twist().linear < 1e-6,
        "letting go ends nothing"
    );
    talk.session.release();
    talk.wait(0.1);
    talk.keep_on(AHEAD, 0.5);
    assert!(!talk.feedback().emergency_stop && talk.twist().linear > 0.39);
}

#[test]
fn a_button_stops_the_others_and_those_that_can_say_so_do() {
    for (protocol, says) in [
        (Protocol::Wheeltec, true),
        (Protocol::Roboclaw, true),
        (Protocol::Arduino, false),
    ] {
        let mut talk = driving(protocol);
        talk.machine.button_pressed = true;
        talk.keep_on(AHEAD, 0.5);
        assert!(talk.twist().linear < 1e-6, "{protocol:?}");
        assert_eq!(talk.feedback().emergency_stop, says, "{protocol:?}");
    }
}

/// Nor is the same report, as a controller would send it whose program hangs while its line still runs.
#[test]
fn a_repeated_report_is_no_news_to_the_host() {
    let mut session = NativeSession::new(BaseSettings::default()).unwrap();
    let heard_s = |session: &NativeSession| session.latest().map(|heard| heard.received_s);
    let mut report = Report {
        sequence: 7,
        ..Report::default()
    };
    for now_s in [1.0, 2.0, 3.0] {
        session.receive(&report.encode(), now_s);
        assert_eq!(heard_s(&session), Some(1.0));
    }
    report.sequence = 8;
    session.receive(&report.encode(), 4.0);
    assert_eq!(heard_s(&session), Some(4.0));
}

/// The same frame again and again, as a stuck adapter would send it, is no sign of life.
#[test]
fn a_repeated_frame_does_not_hold_the_watchdog_off() {
    let mut peer = NativeDevice::new(BaseSettings::default()).unwrap();
    let command = |sequence| Command {
        sequence,
        speeds: [4000, 4000],
        ..Command::default()
    };
    let mut drive = |repeats: bool| {
        let mut set = TrackSpeeds::default();
        for turn in 0..100_u16 {
            let now_s = f64::from(turn) * 0.01;
            let sequence = if repeats { 1000 } else { turn };
            peer.receive(&command(sequence).encode(), now_s);
            set = peer.step(now_s, &MachineState::default(), &mut Vec::new());
        }
        set
    };
    assert!(drive(false).left > 0.39);
    assert_eq!(drive(true), TrackSpeeds::default());
}

#[test]
fn a_release_with_a_speed_in_it_releases_nothing() {
    let mut peer = NativeDevice::new(BaseSettings::default()).unwrap();
    let mut tell = |sequence, stop, release, speed| {
        let command = Command {
            sequence,
            stop,
            release,
            speeds: [speed, 0],
        };
        let now_s = f64::from(sequence) * 0.01;
        peer.receive(&command.encode(), now_s);
        peer.step(now_s, &MachineState::default(), &mut Vec::new())
    };
    tell(1, true, false, 0);
    for (sequence, stop, release, speed) in [(2, false, true, 5000), (4, true, true, 0)] {
        tell(sequence, stop, release, speed);
        assert_eq!(
            tell(sequence + 1, false, false, 5000),
            TrackSpeeds::default()
        );
    }
    tell(6, false, true, 0);
    assert!(tell(7, false, false, 5000).left > 0.49);
}

#[test]
fn a_roboclaw_is_not_driven_before_its_watchdog_is_confirmed() {
    let mut talk = Conversation::new(Protocol::Roboclaw, BaseSettings::default());
    let heard = std::rc::Rc::new(std::cell::Cell::new(0));
    let counted = heard.clone();
    // The first four answers to the set-up are lost.
    talk.damage = Box::new(move |way, bytes| {
        if way == Way::ToHost {
            counted.set(counted.get() + 1);
            if counted.get() <= 4 {
                return Vec::new();
            }
        }
        bytes
    });
    talk.keep_on(AHEAD, 0.06);
    assert!(heard.get() <= 4);
    assert!(talk.set.iter().all(|set| *set == TrackSpeeds::default()));
    let set_up = bytes("80 0E 05 48 F0");
    assert!(
        talk.written.chunks(5).all(|packet| packet == set_up),
        "{:02X?}",
        talk.written
    );
    talk.keep_on(AHEAD, 1.0);
    assert!(talk.twist().linear > 0.39);
    let counters = talk.session.counters();
    assert!(
        counters.retries >= 3 && counters.unanswered >= 1,
        "{counters:?}"
    );
}

#[test]
fn a_roboclaw_that_was_switched_off_and_on_gets_its_watchdog_again() {
    let mut talk = driving(Protocol::Roboclaw);
    talk.damage = Box::new(|_, _| Vec::new());
    talk.wait(0.3);
    talk.peer = Protocol::Roboclaw.device(BaseSettings::default()).unwrap();
    talk.damage = Box::new(|_, bytes| bytes);
    talk.keep_on(AHEAD, 0.5);
    talk.host_runs = false;
    assert!(stops_after(&mut talk).is_some_and(|after_s| after_s <= 0.51));
}

#[test]
fn a_counter_that_jumps_for_good_is_a_fault_until_released() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        let mut talk = driving(protocol);
        talk.start_encoders_at(5_000_000.0);
        talk.keep_on(AHEAD, 0.5);
        assert!(
            talk.feedback().faults.contains(Faults::ENCODER),
            "{protocol:?}"
        );
        assert!(
            (talk.feedback().twist.linear - 0.4).abs() < 0.02,
            "{protocol:?}"
        );
        talk.session.release();
        talk.keep_on(AHEAD, 0.3);
        assert_eq!(talk.feedback().faults, Faults::NONE, "{protocol:?}");
    }
}
