//! Stops of a base: its watchdog, its latched stop, and an unconfirmed configuration.

use inbye::base::native::{self, Command, NativeDevice, NativeSession};
use inbye::base::roboclaw::Request;
use inbye::base::wheeltec::{Report, WheeltecSession};
use inbye::base::{
    BaseSettings, Bumper, DeviceProtocol, Faults, MachineState, Protocol, Session, Tilt,
};
use inbye::geometry::Twist;
use inbye::robot::TrackSpeeds;

use super::simulated_link::{Direction, SimulatedLink};

const AHEAD: Twist = Twist::new(0.4, 0.0);

fn driving(protocol: Protocol) -> SimulatedLink {
    let mut link = SimulatedLink::new(protocol, BaseSettings::default());
    link.drive_for(AHEAD, 1.0);
    assert!(link.twist().linear > 0.39, "{protocol:?}: {:?}", link.twist());
    link
}

/// Time from the host's silence to the base's stop, seconds; none if longer than 5 s.
fn stops_after(link: &mut SimulatedLink) -> Option<f64> {
    let before = link.set.len();
    link.wait(5.0);
    let stopped = |set: &TrackSpeeds| *set == TrackSpeeds::default();
    let steps = link.set[before..].iter().position(stopped)?;
    Some(steps as f64 / 1000.0)
}

#[test]
fn watchdog_stops_base_of_silent_host() {
    for (protocol, bound_s) in [
        (Protocol::Native, Some(0.5)),
        (Protocol::Roboclaw, Some(0.5)),
        (Protocol::Arduino, Some(2.0)),
        (Protocol::Wheeltec, None),
    ] {
        let mut link = driving(protocol);
        link.host_runs = false;
        let after_s = stops_after(&mut link);
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

/// A session renews no command, but its queries reset a `RoboClaw`'s watchdog.
#[test]
fn queries_alone_keep_only_roboclaw_running() {
    for (protocol, stops) in [
        (Protocol::Native, true),
        (Protocol::Arduino, true),
        (Protocol::Roboclaw, false),
        (Protocol::Wheeltec, false),
    ] {
        let mut link = driving(protocol);
        assert_eq!(stops_after(&mut link).is_some(), stops, "{protocol:?}");
    }
}

#[test]
fn native_watchdog_is_reported_until_next_command() {
    let mut link = driving(Protocol::Native);
    link.wait(0.7);
    assert_eq!(link.feedback().faults, Faults::WATCHDOG);
    assert!(!link.feedback().emergency_stop);
    link.drive_for(AHEAD, 0.3);
    assert_eq!(link.feedback().faults, Faults::NONE);
    assert!(link.twist().linear > 0.39);
}

#[test]
fn native_stop_is_latched_until_release() {
    let mut link = driving(Protocol::Native);
    link.session.engage_stop();
    link.drive_for(AHEAD, 1.0);
    assert!(link.feedback().emergency_stop && link.twist().linear < 1e-6);
    link.session.release();
    link.wait(0.1);
    assert!(!link.feedback().emergency_stop && link.twist().linear < 1e-6);
    link.drive_for(AHEAD, 0.5);
    assert!(link.twist().linear > 0.39);
}

/// Damages the next write of the host.
fn damage_next_command(link: &mut SimulatedLink) {
    let mut is_damaged = false;
    link.damage = Box::new(move |direction, mut bytes| {
        if direction == Direction::ToBase && !is_damaged {
            is_damaged = true;
            bytes[6] ^= 1;
        }
        bytes
    });
}

#[test]
fn native_release_is_repeated_until_the_base_acknowledges_it() {
    let mut link = driving(Protocol::Native);
    link.session.engage_stop();
    link.drive_for(AHEAD, 0.3);
    link.session.release();
    damage_next_command(&mut link);
    link.drive_for(Twist::STOP, 0.2);
    assert!(!link.feedback().emergency_stop);
    link.drive_for(AHEAD, 0.5);
    assert!(link.twist().linear > 0.39);
}

/// A button that is pressed and let go while a release is repeated has latched a new stop.
#[test]
fn native_release_that_the_base_refused_is_not_repeated() {
    let mut link = driving(Protocol::Native);
    link.machine.button_pressed = true;
    link.drive_for(AHEAD, 0.3);
    link.session.release();
    link.drive_for(Twist::STOP, 0.1);
    link.machine.button_pressed = false;
    link.drive_for(Twist::STOP, 0.2);
    assert!(link.feedback().emergency_stop);
}

/// No report arrives, so that the session cannot know whether the base has ended its stop.
#[test]
fn native_release_is_repeated_for_half_a_second_at_most() {
    let mut session = NativeSession::new(BaseSettings::default()).unwrap();
    session.release();
    let releases = (0..40_u32).map(|step| {
        session.command(&AHEAD).expect("a finite command");
        let mut line = Vec::new();
        session.transmit(0.02 * f64::from(step), &mut line);
        let mut decoder = native::Decoder::<Command>::default();
        decoder.push(&line);
        let command = decoder.next().expect("a command");
        assert_eq!(command.release, command.speeds == [0, 0]);
        command.release
    });
    assert_eq!(releases.filter(|release| *release).count(), 25);
}

/// A damaged report may show disabled motors, and pass the weak check.
#[test]
fn single_disabled_report_suspects_a_stop_and_the_second_confirms_it() {
    let mut session = WheeltecSession::new(BaseSettings::default()).unwrap();
    let mut reported = |motors_disabled| {
        session.receive(&Report { motors_disabled, ..Report::default() }.encode(), 0.0);
        let feedback = session.latest().expect("a report").feedback;
        (feedback.is_stop_suspected, feedback.emergency_stop)
    };
    let found = [false, true, false, true, true, true, false].map(&mut reported);
    let (none, suspected, stop) = ((false, false), (true, false), (false, true));
    assert_eq!(found, [none, suspected, none, suspected, stop, stop, none]);
}

#[test]
fn tilt_is_reported_if_protocol_can() {
    let mut link = driving(Protocol::Wheeltec);
    assert!(link.feedback().tilt.is_some_and(|tilt| tilt.roll.abs() < 0.01));
    link.machine.tilt = Tilt { roll: -0.3, pitch: 0.4 };
    link.wait(3.0);
    let tilt = link.feedback().tilt.expect("a tilt");
    assert!((tilt.roll + 0.3).abs() < 0.02 && (tilt.pitch - 0.4).abs() < 0.02, "{tilt:?}");
    assert_eq!(driving(Protocol::Native).feedback().tilt, None);
}

#[test]
fn native_bumper_and_cliff_latch_the_stop_of_the_base() {
    for (bumper, cliff) in [(Bumper { left: true, right: false }, false), (Bumper::default(), true)]
    {
        let mut link = driving(Protocol::Native);
        (link.machine.bumper, link.machine.cliff) = (bumper, cliff);
        link.drive_for(AHEAD, 0.5);
        let feedback = link.feedback();
        assert_eq!((feedback.bumper, feedback.cliff), (bumper, cliff));
        assert!(feedback.emergency_stop && link.twist().linear < 1e-6);
        (link.machine.bumper, link.machine.cliff) = (Bumper::default(), false);
        link.session.release();
        link.wait(0.1);
        link.drive_for(AHEAD, 0.5);
        assert!(!link.feedback().emergency_stop && link.twist().linear > 0.39);
    }
}

#[test]
fn pressed_button_prevents_release() {
    let mut link = driving(Protocol::Native);
    link.machine.button_pressed = true;
    link.drive_for(AHEAD, 0.5);
    link.session.release();
    link.drive_for(AHEAD, 0.5);
    assert!(link.feedback().emergency_stop && link.twist().linear < 1e-6);
    link.machine.button_pressed = false;
    link.drive_for(AHEAD, 0.5);
    assert!(
        link.feedback().emergency_stop && link.twist().linear < 1e-6,
        "releasing the button does not end the stop"
    );
    link.session.release();
    link.wait(0.1);
    link.drive_for(AHEAD, 0.5);
    assert!(!link.feedback().emergency_stop && link.twist().linear > 0.39);
}

#[test]
fn button_stops_base_and_is_reported_if_protocol_can() {
    for (protocol, is_reported) in
        [(Protocol::Wheeltec, true), (Protocol::Roboclaw, true), (Protocol::Arduino, false)]
    {
        let mut link = driving(protocol);
        link.machine.button_pressed = true;
        link.drive_for(AHEAD, 0.5);
        assert!(link.twist().linear < 1e-6, "{protocol:?}");
        assert_eq!(link.feedback().emergency_stop, is_reported, "{protocol:?}");
    }
}

/// A hung controller may repeat its last report.
#[test]
fn repeated_report_is_ignored() {
    let mut session = NativeSession::new(BaseSettings::default()).unwrap();
    let received_s = |session: &NativeSession| session.latest().map(|latest| latest.received_s);
    let mut report = native::Report { sequence: 7, ..native::Report::default() };
    for now_s in [1.0, 2.0, 3.0] {
        session.receive(&report.encode(), now_s);
        assert_eq!(received_s(&session), Some(1.0));
    }
    report.sequence = 8;
    session.receive(&report.encode(), 4.0);
    assert_eq!(received_s(&session), Some(4.0));
}

/// A stuck adapter may repeat the last frame.
#[test]
fn repeated_frame_does_not_reset_watchdog() {
    let mut device = NativeDevice::new(BaseSettings::default()).unwrap();
    let command = |sequence| Command { sequence, speeds: [4000, 4000], ..Command::default() };
    let mut drive = |repeats: bool| {
        let mut set = TrackSpeeds::default();
        for step in 0..100_u16 {
            let now_s = f64::from(step) * 0.01;
            let sequence = if repeats { 1000 } else { step };
            device.receive(&command(sequence).encode(), now_s);
            set = device.step(now_s, &MachineState::default(), &mut Vec::new());
        }
        set
    };
    assert!(drive(false).left > 0.39);
    assert_eq!(drive(true), TrackSpeeds::default());
}

#[test]
fn release_with_speed_is_ignored() {
    let mut device = NativeDevice::new(BaseSettings::default()).unwrap();
    let mut send = |sequence, stop, release, speed| {
        let command = Command { sequence, stop, release, speeds: [speed, 0] };
        let now_s = f64::from(sequence) * 0.01;
        device.receive(&command.encode(), now_s);
        device.step(now_s, &MachineState::default(), &mut Vec::new())
    };
    send(1, true, false, 0);
    for (sequence, stop, release, speed) in [(2, false, true, 5000), (4, true, true, 0)] {
        send(sequence, stop, release, speed);
        assert_eq!(send(sequence + 1, false, false, 5000), TrackSpeeds::default());
    }
    send(6, false, true, 0);
    assert!(send(7, false, false, 5000).left > 0.49);
}

#[test]
fn roboclaw_is_not_driven_before_watchdog_is_confirmed() {
    let mut link = SimulatedLink::new(Protocol::Roboclaw, BaseSettings::default());
    let answers = std::rc::Rc::new(std::cell::Cell::new(0));
    let counted = answers.clone();
    // The first four answers are lost.
    link.damage = Box::new(move |direction, bytes| {
        if direction == Direction::ToHost {
            counted.set(counted.get() + 1);
            if counted.get() <= 4 {
                return Vec::new();
            }
        }
        bytes
    });
    link.drive_for(AHEAD, 0.06);
    assert!(answers.get() <= 4);
    assert!(link.set.iter().all(|set| *set == TrackSpeeds::default()));
    let address = BaseSettings::default().roboclaw.address;
    let mut written = link.written.as_slice();
    while let Some((request, length)) = Request::decode(written, address).expect("a request") {
        assert!(matches!(request, Request::SetTimeout(5) | Request::Drive([0, 0])), "{request:?}");
        written = &written[length..];
    }
    link.drive_for(AHEAD, 1.0);
    assert!(link.twist().linear > 0.39);
    let counters = link.session.counters();
    assert!(counters.retries >= 3 && counters.unanswered >= 1, "{counters:?}");
}

/// Its answers are lost, and every byte that it receives resets its watchdog.
#[test]
fn roboclaw_without_answers_gets_zero_for_every_command() {
    let mut link = driving(Protocol::Roboclaw);
    link.damage = Box::new(|direction, bytes| match direction {
        Direction::ToHost => Vec::new(),
        Direction::ToBase => bytes,
    });
    let before = link.set.len();
    link.drive_for(AHEAD, 0.25);
    assert_eq!(link.set.last(), Some(&TrackSpeeds::default()));
    let moves = |set: &&TrackSpeeds| **set != TrackSpeeds::default();
    let moving_steps = link.set[before..].iter().filter(moves).count();
    assert!(moving_steps < 150, "{moving_steps} ms");
    // Answers come again: the watchdog is confirmed, and the base follows the next command.
    link.damage = Box::new(|_, bytes| bytes);
    link.drive_for(AHEAD, 0.5);
    assert!(link.twist().linear > 0.39, "{:?}", link.twist());
}

#[test]
fn restarted_roboclaw_gets_its_watchdog_again() {
    let mut link = driving(Protocol::Roboclaw);
    link.damage = Box::new(|_, _| Vec::new());
    link.wait(0.3);
    link.device = Protocol::Roboclaw.device(BaseSettings::default()).unwrap();
    link.damage = Box::new(|_, bytes| bytes);
    link.drive_for(AHEAD, 0.5);
    link.host_runs = false;
    assert!(stops_after(&mut link).is_some_and(|after_s| after_s <= 0.51));
}

/// At 1.9 m/s the tracks could have run back to zero in this time.
#[test]
fn counters_that_a_short_restart_has_reset_are_a_fault() {
    for protocol in [Protocol::Roboclaw, Protocol::Arduino] {
        for commanded in [AHEAD, Twist::STOP] {
            let mut link = driving(protocol);
            link.damage = Box::new(|_, _| Vec::new());
            link.drive_for(commanded, 0.3);
            link.device = protocol.device(BaseSettings::default()).unwrap();
            link.start_encoders_at(0.0);
            link.damage = Box::new(|_, bytes| bytes);
            link.drive_for(commanded, 0.5);
            assert!(link.feedback().faults.contains(Faults::ENCODER), "{protocol:?}");
            assert!(link.feedback().twist.linear > -0.01, "{:?}", link.feedback().twist);
        }
    }
}

/// The base drives on by its last command, or brakes.
#[test]
fn motion_while_the_line_is_cut_for_a_moment_is_no_fault() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        for commanded in [AHEAD, Twist::STOP, Twist::new(-0.4, 0.0)] {
            for cut_s in [0.15, 0.3, 0.45] {
                let mut link = driving(protocol);
                link.damage = Box::new(|_, _| Vec::new());
                link.drive_for(AHEAD, cut_s);
                link.damage = Box::new(|_, bytes| bytes);
                link.drive_for(commanded, 1.5);
                assert_eq!(link.feedback().faults, Faults::NONE, "{protocol:?}, {cut_s} s");
                assert_eq!(link.session.counters().rejected_readings, 0, "{protocol:?}");
            }
        }
    }
}

#[test]
fn permanent_counter_jump_is_fault_until_release() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        let mut link = driving(protocol);
        link.start_encoders_at(5_000_000.0);
        link.drive_for(AHEAD, 0.5);
        assert!(link.feedback().faults.contains(Faults::ENCODER), "{protocol:?}");
        assert!((link.feedback().twist.linear - 0.4).abs() < 0.02, "{protocol:?}");
        link.session.release();
        link.drive_for(AHEAD, 0.3);
        assert_eq!(link.feedback().faults, Faults::NONE, "{protocol:?}");
    }
}
