//! Every protocol over a pair of pseudo-terminals, with the controller in another thread.

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

/// Generous enough for a busy machine.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Runs a controller with ideal motors until the flag is set.
fn control(
    mut port: TTYPort,
    mut device: Box<dyn DeviceProtocol>,
    settings: &BaseSettings,
    shutdown: &AtomicBool,
) {
    port.set_timeout(Duration::from_millis(1)).expect("a timeout");
    let start = Instant::now();
    let (mut machine, mut travel_m, mut last_s) =
        (MachineState::default(), PerTrack::both(0.0), 0.0);
    let mut bytes = [0; 256];
    while !shutdown.load(Ordering::Relaxed) {
        let now_s = start.elapsed().as_secs_f64();
        if let Ok(count) = port.read(&mut bytes) {
            device.receive(&bytes[..count], now_s);
        }
        let mut line = Vec::new();
        machine.speeds = device.step(now_s, &machine, &mut line);
        let _ = port.write_all(&line);
        let speeds = machine.speeds;
        travel_m = travel_m.zip(speeds, |travel_m, speed| travel_m + speed * (now_s - last_s));
        machine.encoder_counts = travel_m
            .zip(settings.ticks_per_m, |travel_m, per_m| (travel_m * per_m).floor() as i64 as u32);
        last_s = now_s;
    }
}

/// Sends a command repeatedly until the base reports about that speed.
fn drive_until_reported(base: &mut SerialBase, target: Twist) -> Result<(), BaseError> {
    loop {
        base.send(&target)?;
        match base.feedback() {
            Ok(feedback) if (feedback.twist.linear - target.linear).abs() < 0.05 => return Ok(()),
            Ok(_) | Err(BaseError::NoFeedbackYet { .. }) => {}
            Err(error) => return Err(error),
        }
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn every_protocol_drives_over_serial_port() {
    for protocol in Protocol::ALL {
        let settings = BaseSettings::default();
        let (device_port, port) = TTYPort::pair().expect("pseudo-terminals");
        let device = protocol.device(settings).expect("valid settings");
        let shutdown = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| control(device_port, device, &settings, &shutdown));
            let timeouts = SerialSettings {
                send_timeout: TIMEOUT,
                feedback_timeout: TIMEOUT,
                ..SerialSettings::default()
            };
            let session = protocol.session(settings).expect("valid settings");
            let mut base = SerialBase::from_port(Box::new(port), "pty", session, timeouts);
            let drove = drive_until_reported(&mut base, Twist::new(0.5, 0.0));
            let stopped = drive_until_reported(&mut base, Twist::STOP);
            shutdown.store(true, Ordering::Relaxed);
            let counters = base.counters();
            assert_eq!((drove, stopped), (Ok(()), Ok(())), "{protocol:?}: {counters:?}");
        });
    }
}

#[test]
fn silent_base_times_out() {
    for protocol in [Protocol::Roboclaw, Protocol::Arduino] {
        let (_silent, port) = TTYPort::pair().expect("pseudo-terminals");
        let session = protocol.session(BaseSettings::default()).expect("valid settings");
        let mut base =
            SerialBase::from_port(Box::new(port), "pty", session, SerialSettings::default());
        let result = std::iter::repeat_with(|| {
            base.send(&Twist::new(0.3, 0.0)).expect("an open port");
            base.feedback()
        })
        .find(|answer| !matches!(answer, Err(BaseError::NoFeedbackYet { .. })));
        assert!(matches!(result, Some(Err(BaseError::TimedOut { .. }))), "{result:?}");
        assert!(base.counters().retries > 0);
    }
}

/// A thread that was scheduled late must not count as a slow line.
#[test]
fn write_succeeds_with_zero_timeout_while_there_is_space() {
    let (_device, port) = TTYPort::pair().expect("pseudo-terminals");
    let session = Protocol::Native.session(BaseSettings::default()).expect("valid settings");
    let no_time = SerialSettings { send_timeout: Duration::ZERO, ..SerialSettings::default() };
    let mut base = SerialBase::from_port(Box::new(port), "pty", session, no_time);
    for _ in 0..20 {
        assert_eq!(base.send(&Twist::STOP), Ok(()));
    }
}

/// A base stops reading: the line fills up, the supervisor disconnects after its timeout, and its owner never waits.
#[test]
fn blocked_line_is_disconnected() {
    let (_blocked, port) = TTYPort::pair().expect("pseudo-terminals");
    let mut port = Some(port);
    let open: OpenBase = Box::new(move || {
        let disconnected = || BaseError::Disconnected { port: "pty".to_owned() };
        let port = port.take().ok_or_else(disconnected)?;
        let session = Protocol::Native.session(BaseSettings::default())?;
        // Only the writes time out, not the feedback.
        let timeouts =
            SerialSettings { feedback_timeout: 10 * TIMEOUT, ..SerialSettings::default() };
        Ok(Box::new(SerialBase::from_port(Box::new(port), "pty", session, timeouts)))
    });
    let settings = SupervisorSettings::default()
        .rate_hz(1000.0)
        .reconnect_min_s(1000.0)
        .reconnect_max_s(1000.0);
    let supervisor =
        BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default())
            .expect("an open port");
    let started = Instant::now();
    let error = loop {
        let _ = supervisor.set_target(&Twist::new(0.3, 0.0), supervisor.now_s());
        if let DriveStatus::Disconnected(error) = supervisor.status().drive_status {
            break error;
        }
        assert!(started.elapsed() < TIMEOUT, "{:?}", supervisor.status());
        thread::sleep(Duration::from_millis(5));
    };
    assert!(error.to_string().contains("writing a command"), "{error}");
}
