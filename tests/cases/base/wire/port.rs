//! Every protocol over a pair of pseudo-terminals: the port in one thread, the controller in another.

use std::io::{Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use inbye::base::{
    Base, BaseError, BaseSettings, BaseSupervisor, DeviceProtocol, DriveStatus, MachineState,
    OpenBase, Protocol, SerialBase, SerialSettings, SupervisorSettings,
};
use inbye::geometry::Twist;
use inbye::robot::PerTrack;
use serialport::{SerialPort, TTYPort};

/// A bound so generous that a busy machine does not trip it.
const PATIENCE: Duration = Duration::from_secs(20);

/// Runs a controller whose motors are at once where they are told to be, until it is told to end.
fn control(
    mut port: TTYPort,
    mut peer: Box<dyn DeviceProtocol>,
    settings: &BaseSettings,
    end: &AtomicBool,
) {
    port.set_timeout(Duration::from_millis(1))
        .expect("a timeout");
    let start = Instant::now();
    let (mut machine, mut travel_m, mut last_s) =
        (MachineState::default(), PerTrack::both(0.0), 0.0);
    let mut bytes = [0; 256];
    while !end.load(Ordering::Relaxed) {
        let now_s = start.elapsed().as_secs_f64();
        if let Ok(count) = port.read(&mut bytes) {
            peer.receive(&bytes[..count], now_s);
        }
        let mut line = Vec::new();
        machine.speeds = peer.step(now_s, &machine, &mut line);
        let _ = port.write_all(&line);
        let speeds = PerTrack::from(machine.speeds);
        travel_m = travel_m.zip(speeds, |travel_m, speed| {
            travel_m + speed * (now_s - last_s)
        });
        machine.encoder_counts = travel_m.zip(settings.ticks_per_m, |travel_m, per_m| {
            (travel_m * per_m).floor() as i64 as u32
        });
        last_s = now_s;
    }
}

/// Sends a command again and again until the base reports about that motion.
fn drive_until_reported(base: &mut SerialBase, wanted: Twist) -> Result<(), BaseError> {
    loop {
        base.send(&wanted)?;
        match base.feedback() {
            Ok(feedback) if (feedback.twist.linear - wanted.linear).abs() < 0.05 => return Ok(()),
            Ok(_) | Err(BaseError::NoFeedbackYet { .. }) => {}
            Err(error) => return Err(error),
        }
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn every_protocol_drives_over_a_port() {
    for protocol in Protocol::ALL {
        let settings = BaseSettings::default();
        let (peer_port, port) = TTYPort::pair().expect("pseudo-terminals");
        let peer = protocol.device(settings).expect("valid settings");
        let end = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| control(peer_port, peer, &settings, &end));
            let patient = SerialSettings {
                send_timeout: PATIENCE,
                feedback_timeout: PATIENCE,
                ..SerialSettings::default()
            };
            let session = protocol.session(settings).expect("valid settings");
            let mut base = SerialBase::from_port(Box::new(port), "pty", session, patient);
            let drove = drive_until_reported(&mut base, Twist::new(0.5, 0.0));
            let stopped = drive_until_reported(&mut base, Twist::STOP);
            end.store(true, Ordering::Relaxed);
            let counters = base.counters();
            assert_eq!(
                (drove, stopped),
                (Ok(()), Ok(())),
                "{protocol:?}: {counters:?}"
            );
        });
    }
}

/// A base that must be asked and never answers costs no more than the bounds, and is told.
#[test]
fn a_base_that_never_answers_is_told_and_does_not_hang() {
    for protocol in [Protocol::Roboclaw, Protocol::Arduino] {
        let (_silent, port) = TTYPort::pair().expect("pseudo-terminals");
        let session = protocol
            .session(BaseSettings::default())
            .expect("valid settings");
        let mut base =
            SerialBase::from_port(Box::new(port), "pty", session, SerialSettings::default());
        let told = std::iter::repeat_with(|| {
            base.send(&Twist::new(0.3, 0.0)).expect("an open line");
            base.feedback()
        })
        .find(|answer| !matches!(answer, Err(BaseError::NoFeedbackYet { .. })));
        assert!(
            matches!(told, Some(Err(BaseError::TimedOut { .. }))),
            "{told:?}"
        );
        assert!(base.counters().retries > 0);
    }
}

/// A thread that the system lets wait past the bound has not found the line to be slow.
#[test]
fn a_sender_that_was_held_up_past_its_bound_goes_on() {
    let (_peer, port) = TTYPort::pair().expect("pseudo-terminals");
    let session = Protocol::Native
        .session(BaseSettings::default())
        .expect("valid settings");
    let held_up = SerialSettings {
        send_timeout: Duration::ZERO,
        ..SerialSettings::default()
    };
    let mut base = SerialBase::from_port(Box::new(port), "pty", session, held_up);
    for _ in 0..20 {
        assert_eq!(base.send(&Twist::STOP), Ok(()));
    }
}

/// A base that reads no more: the line fills up, the sender gives it up within its bound, and its owner never waits.
#[test]
fn a_line_that_takes_no_more_is_given_up() {
    let (_wedged, port) = TTYPort::pair().expect("pseudo-terminals");
    let mut port = Some(port);
    let open: OpenBase = Box::new(move || {
        let gone = || BaseError::Disconnected {
            port: "pty".to_owned(),
        };
        let port = port.take().ok_or_else(gone)?;
        let session = Protocol::Native.session(BaseSettings::default())?;
        // Its silence alone is no reason yet.
        let patient = SerialSettings {
            feedback_timeout: 10 * PATIENCE,
            ..SerialSettings::default()
        };
        Ok(Box::new(SerialBase::from_port(
            Box::new(port),
            "pty",
            session,
            patient,
        )))
    });
    let settings = SupervisorSettings {
        rate_hz: 1000.0,
        reconnect_min_s: 1000.0,
        reconnect_max_s: 1000.0,
        ..SupervisorSettings::default()
    };
    let supervisor =
        BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default())
            .expect("an open line");
    let began = Instant::now();
    let why = loop {
        let _ = supervisor.set_target(&Twist::new(0.3, 0.0), supervisor.now_s());
        if let DriveStatus::Disconnected(why) = supervisor.status().drive_status {
            break why;
        }
        assert!(began.elapsed() < PATIENCE, "{:?}", supervisor.status());
        thread::sleep(Duration::from_millis(5));
    };
    assert!(why.to_string().contains("writing a command"), "{why}");
}
