//! The cases of `inbye bench faults` on emulated serial lines.

use inbye::base::{InjectedFault, Protocol};

use super::serial_verdict::Required;

/// Begin of each fault, seconds after the base is switched on: the robot has its cruising speed.
pub const AT_S: f64 = 9.0;

/// Time for which a suspended drive, a cut line or a base without power lasts, seconds.
const PASSING_S: f64 = 2.0;

/// Goals, metres and radians: one that every robot reaches after its fault, and two for parking. The first of these needs a quarter of a
/// turn at the goal; the second is near enough for a base that is limited to 0.3 m/s.
const FAR: &str = "24.5,2.0";
const ACROSS: &str = "12.5,2.4,1.5708";
const ALONG: &str = "12.5,1.8,0";
const NEAR: &str = "7.0,2.2,-0.7854";

/// How every emulated machine differs from its settings. Its motors lag by 0.15 s, and its tracks lose 3 % of their travel. It turns
/// as if its tracks were 10 % farther apart, because the effective width is known to about 10 % on one floor.
const MACHINE: &str = "--motor-lag 0.15 --width-ratio 1.1 --slip 0.03";

/// What happens at [`AT_S`].
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// Nothing: the machine itself is the case.
    None,
    /// A fault that stays.
    Fault(InjectedFault),
    /// A fault that ends.
    Passing(InjectedFault),
    /// The lidar's port is gone.
    LidarUnplugged,
    /// The robot is put down at a place of the map.
    CarriedTo(&'static str),
    /// People appear, each by its gap ahead, its distance to the left, its speed and its wait.
    People(&'static [&'static str]),
    /// The process of the drive gets this signal.
    Signal(&'static str),
    /// The process of the drive is suspended; a person steps in front of the robot meanwhile.
    Suspended,
    /// The operator's port gets a stop.
    StopRequest,
}

/// A drive on a serial line.
#[derive(Clone, Copy, Debug)]
pub struct SerialCase {
    pub name: &'static str,
    pub protocol: Protocol,
    pub event: Event,
    pub required: Required,
    pub goal: &'static str,
    /// Arguments of the emulated machine.
    pub machine: &'static str,
}

const fn case(name: &'static str, event: Event, required: Required) -> SerialCase {
    let protocol = Protocol::Native;
    SerialCase { name, protocol, event, required, goal: FAR, machine: MACHINE }
}

const fn fault(name: &'static str, fault: InjectedFault, required: Required) -> SerialCase {
    case(name, Event::Fault(fault), required)
}

const fn mission(name: &'static str, goal: &'static str, limit_s: f64) -> SerialCase {
    SerialCase { goal, ..case(name, Event::None, Required::Parks(limit_s)) }
}

impl SerialCase {
    /// Arguments of `base emulate` for the event.
    pub fn emulate(&self) -> Vec<String> {
        let from = |name: &str| format!("{name}@{AT_S}");
        match self.event {
            Event::None | Event::Signal(_) | Event::StopRequest => Vec::new(),
            Event::Fault(fault) => vec!["--fault".to_owned(), from(&fault.to_string())],
            Event::Passing(fault) => {
                vec!["--fault".to_owned(), format!("{fault}@{AT_S}..{}", AT_S + PASSING_S)]
            }
            Event::LidarUnplugged => vec!["--lidar-until".to_owned(), AT_S.to_string()],
            Event::CarriedTo(place) => {
                let fault = from(&InjectedFault::Carried.to_string());
                ["--fault", &fault, "--carry-to", place].map(str::to_owned).to_vec()
            }
            Event::People(people) => {
                people.iter().flat_map(|person| ["--person".to_owned(), from(person)]).collect()
            }
            // The base's watchdog has stopped the robot by then.
            Event::Suspended => vec!["--person".to_owned(), format!("0.6@{}", AT_S + 1.5)],
        }
    }

    /// The signals that the drive gets, each with its time, seconds after the base is switched on.
    pub fn signals(&self) -> Vec<(f64, &'static str)> {
        match self.event {
            Event::Signal("KILL") => vec![(AT_S, "KILL")],
            // A robot that its operator has stopped waits for him.
            Event::Signal(signal) => vec![(AT_S, signal), (AT_S + 5.0, "INT")],
            Event::StopRequest => vec![(AT_S + 5.0, "INT")],
            Event::Suspended => vec![(AT_S, "STOP"), (AT_S + PASSING_S, "CONT")],
            _ => Vec::new(),
        }
    }
}

/// Every case. A limit is the time until the fault is known plus that of braking from 1 m/s at 1 m/s^2, with lags.
pub const CASES: [SerialCase; 51] = [
    // The base.
    fault("left track is stuck", InjectedFault::StuckLeft, Required::Stands(2.8)),
    fault("right track is stuck", InjectedFault::StuckRight, Required::Stands(2.8)),
    fault("left track runs in reverse", InjectedFault::Reversed, Required::Stands(2.8)),
    fault("left track runs away", InjectedFault::Runaway, Required::Reported),
    fault("left encoder is stuck", InjectedFault::EncoderStuck, Required::Stands(2.8)),
    fault("gyro disagrees with the tracks", InjectedFault::GyroBiased, Required::Stands(2.8)),
    // The voltage counts as low after 5 s: a motor that starts lowers it for a moment.
    fault("battery is low", InjectedFault::LowBattery, Required::Stands(6.8)),
    fault("belts spin, robot stands", InjectedFault::Bogged, Required::NoContact),
    fault("emergency button", InjectedFault::Button, Required::Stands(1.8)),
    // The frames of WHEELTEC have a weak checksum: one that shows the button may be damaged, and is confirmed by the next.
    SerialCase {
        protocol: Protocol::Wheeltec,
        goal: NEAR,
        ..fault("one report shows the button", InjectedFault::StopGlitch, Required::Reaches)
    },
    fault("bumper", InjectedFault::Bumper, Required::Stands(1.8)),
    fault("cliff", InjectedFault::Cliff, Required::Stands(1.8)),
    SerialCase {
        protocol: Protocol::Wheeltec,
        ..fault("base tilts", InjectedFault::Tilt, Required::Stands(2.5))
    },
    fault("base ignores commands", InjectedFault::IgnoredCommands, Required::Reported),
    fault("base does not turn", InjectedFault::IgnoredTurns, Required::NoContact),
    fault("motors are 0.3 s late", InjectedFault::LateMotors, Required::Reaches),
    fault("controller hangs", InjectedFault::Wedge, Required::Reported),
    case("base restarts", Event::Passing(InjectedFault::Reboot), Required::Pauses(0.8)),
    SerialCase {
        machine: "--motor-lag 0.15 --width-ratio 1.35 --slip 0.03",
        ..case("width is not calibrated", Event::None, Required::Reaches)
    },
    SerialCase {
        machine: "--motor-lag 0.15 --width-ratio 1.1 --slip 0.03 --deadband 0.02",
        ..mission("motors have a deadband", ACROSS, 10.0)
    },
    // The line.
    fault("base is silent", InjectedFault::Silence, Required::Stands(2.0)),
    fault("base reads slowly", InjectedFault::SlowReads, Required::Stands(3.0)),
    fault("garbage on the line", InjectedFault::Garbage, Required::Reaches),
    fault("bits are flipped", InjectedFault::BitFlips, Required::Reaches),
    fault("reports are corrupt", InjectedFault::CorruptReports, Required::Stands(2.5)),
    case("line is cut for 2 s", Event::Passing(InjectedFault::LineCut), Required::Restarts(1.3)),
    fault("port becomes another device", InjectedFault::PortReplaced, Required::Stands(2.0)),
    // The lidar.
    fault("lidar repeats a revolution", InjectedFault::LidarFrozen, Required::Stands(2.5)),
    fault("lidar receives no echo", InjectedFault::LidarBlind, Required::Stands(2.5)),
    fault("lidar is blind ahead", InjectedFault::LidarSectorBlind, Required::NoContact),
    fault("lidar is 1 s late", InjectedFault::LidarLate, Required::Stands(2.0)),
    fault("lidar's packets are corrupt", InjectedFault::LidarCorrupt, Required::Stands(2.0)),
    fault("lidar's bits are flipped", InjectedFault::LidarBitFlips, Required::Reaches),
    fault("lidar does not rotate", InjectedFault::LidarStalled, Required::Stands(2.0)),
    fault("lidar is silent", InjectedFault::LidarSilent, Required::Stands(2.0)),
    case("lidar is unplugged", Event::LidarUnplugged, Required::Stands(2.0)),
    // The surroundings.
    case("robot is carried 10 m away", Event::CarriedTo("18.0,1.6,0.3"), Required::FoundOrLost),
    case("person appears 1.7 m ahead", Event::People(&["1.7"]), Required::Reaches),
    case("person crosses 2.5 m ahead", Event::People(&["2.5,1.4,1.4"]), Required::Reaches),
    case("person starts to walk", Event::People(&["3.5,1.3,1.2,1"]), Required::Reaches),
    case(
        "roadway is blocked 1.9 m ahead",
        Event::People(&["1.9,-1.5", "1.9,-0.9", "1.9,-0.3", "1.9,0.3", "1.9,0.9", "1.9,1.5"]),
        Required::NoContact,
    ),
    // The process of the drive, and its operator.
    case("drive is suspended for 2 s", Event::Suspended, Required::Restarts(1.3)),
    // Nothing is left to send zeros: the watchdog of the base acts after 0.5 s.
    case("drive gets SIGKILL", Event::Signal("KILL"), Required::Stands(1.3)),
    case("drive gets SIGINT", Event::Signal("INT"), Required::StandsByZeros(0.8)),
    case("drive gets SIGTERM", Event::Signal("TERM"), Required::StandsByZeros(0.8)),
    case("operator's signal", Event::Signal("USR1"), Required::StandsByZeros(0.8)),
    case("operator's request", Event::StopRequest, Required::StandsByZeros(0.8)),
    // No fault. Measured: 7.4 s with a quarter of a turn, 4.5 s without, 6.6 s at 0.3 m/s; a robot that waits needs 23 s more.
    mission("mission, quarter of a turn", ACROSS, 10.0),
    mission("mission, straight", ALONG, 7.0),
    SerialCase { protocol: Protocol::Wheeltec, ..mission("mission, slow base", NEAR, 9.0) },
    SerialCase {
        protocol: Protocol::Roboclaw,
        ..mission("mission, requests and replies", ALONG, 7.0)
    },
];

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_injected_fault_has_a_case_and_no_case_comes_twice() {
        let mut cases = HashSet::new();
        assert!(CASES.iter().all(|case| cases.insert((case.name, case.protocol.name()))));
        for fault in InjectedFault::ALL {
            let name = format!("{fault}@");
            let has = |case: &SerialCase| case.emulate().iter().any(|text| text.starts_with(&name));
            assert!(CASES.iter().any(has), "{fault} has no case");
        }
        let missions = CASES.iter().filter(|case| matches!(case.required, Required::Parks(_)));
        assert!(CASES.len() - missions.count() >= 31);
    }
}
