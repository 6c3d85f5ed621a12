//! The status bits of a `RoboClaw`, as its session reports them.

use inbye::base::roboclaw::{Request, RoboClawDevice, RoboClawSession};
use inbye::base::{BaseSettings, DeviceProtocol, Faults, MachineState, Session};

/// The emergency stop and the faults in the first report of a controller that answers with this function.
fn first_report(
    settings: BaseSettings,
    mut answer: impl FnMut(&[u8], f64) -> Vec<u8>,
) -> (bool, Faults) {
    let mut session = RoboClawSession::new(settings).expect("valid settings");
    for tick in 0..1000 {
        let now_s = 0.005 * f64::from(tick);
        let mut line = Vec::new();
        session.transmit(now_s, &mut line);
        session.receive(&answer(&line, now_s), now_s);
        if let Some(latest) = session.latest() {
            return (latest.feedback.emergency_stop, latest.feedback.faults);
        }
    }
    panic!("no report in 5 s");
}

fn with_status_bytes(status_bytes: usize) -> BaseSettings {
    let mut settings = BaseSettings::default();
    settings.roboclaw.status_bytes = status_bytes;
    settings
}

/// The emergency stop and the faults of these status bits.
fn report_of(bits: u32, settings: BaseSettings) -> (bool, Faults) {
    let address = settings.roboclaw.address;
    first_report(settings, |line, _| {
        let Ok(Some((request, _))) = Request::decode(line, address) else {
            return Vec::new();
        };
        let data = match request {
            Request::SetTimeout(_) | Request::Drive(_) => return vec![0xFF],
            // The watchdog of the settings, 0.5 s.
            Request::GetTimeout => vec![5],
            Request::Encoder { .. } | Request::Speed { .. } => vec![0; 5],
            Request::Battery => vec![0, 240],
            Request::Status => bits.to_be_bytes()[4 - settings.roboclaw.status_bytes..].to_vec(),
        };
        request.encode_reply(address, data)
    })
}

#[test]
fn status_round_trips_in_both_widths() {
    for status_bytes in [2, 4] {
        let settings = with_status_bytes(status_bytes).swap_tracks(true);
        for faults in [Faults::NONE, Faults::MOTOR_LEFT, Faults::SUPPLY.union(Faults::OVERHEATED)] {
            for button_pressed in [false, true] {
                let machine = MachineState { button_pressed, faults, ..MachineState::default() };
                let mut device = RoboClawDevice::new(settings).expect("valid settings");
                let found = first_report(settings, |line, now_s| {
                    let mut answer = Vec::new();
                    device.receive(line, now_s);
                    device.step(now_s, &machine, &mut answer);
                    answer
                });
                assert_eq!(found, (button_pressed, faults), "{status_bytes}");
            }
        }
    }
}

#[test]
fn status_warnings_are_no_faults() {
    let settings = BaseSettings::default();
    assert_eq!(report_of(0xFFFF_0000, settings), (false, Faults::NONE));
    assert_eq!(report_of(0x0001, settings), (true, Faults::NONE));
    assert_eq!(report_of(0x0040, settings), (false, Faults::MOTOR_LEFT));
}

/// The expected values are the manual's two tables.
#[test]
fn every_status_bit_matches_manual() {
    use Faults as F;
    let stop = (true, F::NONE);
    let fault = |fault| (false, fault);
    let nothing = fault(F::NONE);
    let [hot, supply, left, right] =
        [F::OVERHEATED, F::SUPPLY, F::MOTOR_LEFT, F::MOTOR_RIGHT].map(fault);
    let [stalled, position, current] = [F::STALLED, F::OTHER, F::OVERCURRENT].map(fault);
    let four_bytes = [
        stop, hot, hot, supply, supply, supply, left, right, stalled, stalled, position, position,
        current, current,
    ];
    let two_bytes = [
        nothing, nothing, stop, hot, hot, supply, supply, supply, left, right, nothing, nothing,
        nothing, nothing, nothing, nothing,
    ];
    let tables: [(usize, &[(bool, F)]); 2] = [(4, &four_bytes), (2, &two_bytes)];
    for (status_bytes, table) in tables {
        for (bit, expected) in table.iter().enumerate() {
            let found = report_of(1 << bit, with_status_bytes(status_bytes));
            assert_eq!(found, *expected, "{status_bytes} {bit}");
        }
    }
}
