//! Each protocol's session with its device: on a clean line, on a damaged one, and with every wiring.

use inbye::base::{BaseSettings, Protocol};
use inbye::geometry::Twist;
use inbye::robot::{PerTrack, TrackLimits, TrackSpeeds};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::simulated_link::{Damage, Direction, SimulatedLink};

const CURVE: Twist = Twist::new(0.5, 0.4);

/// One tick per 33 ms, the coarsest step of any protocol, is 3 mm/s of a track.
const RESOLUTION: f64 = 0.004;

fn settings() -> BaseSettings {
    BaseSettings::default()
        .effective_width_ratio(1.5)
        .ticks_per_m(PerTrack::new(10_000.0, 12_000.0))
}

fn assert_near(found: Twist, expected: Twist, tolerance: f64, what: &str) {
    let difference =
        (found.linear - expected.linear).abs() + 0.5 * (found.angular - expected.angular).abs();
    assert!(difference <= 2.0 * tolerance, "{what}: {found:?} for {expected:?}");
}

/// Bytes that a session drops on a clean line: only the answer to the initial carriage return.
fn dropped_on_clean_line(protocol: Protocol) -> u64 {
    match protocol {
        Protocol::Arduino => b"Invalid Command\r\n".len() as u64,
        _ => 0,
    }
}

#[test]
fn clean_line_follows_commands_and_reports_truth() {
    for protocol in Protocol::ALL {
        let mut link = SimulatedLink::new(protocol, settings());
        link.drive_for(CURVE, 2.0);
        assert_near(link.twist(), CURVE, RESOLUTION, "driven");
        assert_near(link.feedback().twist, CURVE, 2.0 * RESOLUTION, "reported");
        let counters = link.session.counters();
        assert_eq!(counters.dropped_bytes, dropped_on_clean_line(protocol), "{protocol:?}");
        assert_eq!(
            (counters.retries, counters.unanswered, counters.rejected_readings),
            (0, 0, 0),
            "{protocol:?}"
        );
        assert!(link.feedback().faults.is_empty(), "{protocol:?}");
        let battery_v = link.feedback().battery_v;
        assert!(battery_v.is_none_or(|volts| (volts - 24.0).abs() < 1e-9));
        assert_eq!(battery_v.is_none(), protocol == Protocol::Arduino);
        link.drive_for(Twist::STOP, 1.0);
        assert_near(link.twist(), Twist::STOP, 1e-6, "stopped");
    }
}

#[test]
fn every_wiring_gives_same_motion() {
    for protocol in Protocol::ALL {
        for wiring in 0..8 {
            let settings = settings()
                .swap_tracks(wiring & 1 != 0)
                .reversed(PerTrack::new(wiring & 2 != 0, wiring & 4 != 0));
            let mut link = SimulatedLink::new(protocol, settings);
            link.drive_for(CURVE, 1.0);
            assert_near(link.twist(), CURVE, RESOLUTION, "driven");
            assert_near(link.feedback().twist, CURVE, 2.0 * RESOLUTION, "reported");
            if let Some(counts) = link.feedback().encoder_counts {
                assert!((counts.left as i32) > 0 && counts.left as i32 <= 5000, "{counts:?}");
            }
        }
    }
}

/// The encoders do not show it.
#[test]
fn unconfigured_swapped_tracks_turn_in_reverse() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        let straight = BaseSettings::default();
        let swapped = straight.swap_tracks(true);
        let mut link = SimulatedLink::between(protocol, straight, swapped);
        link.drive_for(CURVE, 1.0);
        assert_near(link.twist(), Twist::new(0.5, -0.4), RESOLUTION, "driven");
        assert_near(link.feedback().twist, CURVE, 2.0 * RESOLUTION, "reported");
    }
}

#[test]
fn fast_commands_are_scaled_at_constant_curvature() {
    for protocol in Protocol::ALL {
        let limits = TrackLimits::default().max_track_speed(0.5);
        let settings = BaseSettings::default().tracks(limits);
        let mut link = SimulatedLink::new(protocol, settings);
        link.drive_for(Twist::new(0.8, 0.8), 2.0);
        assert_near(link.twist(), Twist::new(0.4, 0.4), RESOLUTION, "driven");
    }
}

#[test]
fn command_that_is_not_finite_is_rejected_and_previous_stays() {
    for protocol in Protocol::ALL {
        let mut link = SimulatedLink::new(protocol, settings());
        link.drive_for(CURVE, 1.0);
        assert!(link.session.command(&Twist::new(f64::NAN, 0.0)).is_err());
        link.wait(0.02);
        assert_near(link.twist(), CURVE, RESOLUTION, "driven");
    }
}

#[test]
fn counter_wrap_is_no_motion() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        // 4000 ticks before the wrap of 2^32 and of 2^31, at 4000 to 7200 ticks per second.
        for start in [f64::from(u32::MAX), f64::from(i32::MAX)] {
            let mut link = SimulatedLink::new(protocol, settings());
            link.start_encoders_at(start - 4000.0);
            for _ in 0..20 {
                link.drive_for(CURVE, 0.1);
                if link.now_s > 0.5 {
                    assert_near(link.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
                    let received_s = link.session.latest().expect("feedback by now").received_s;
                    assert!(link.now_s - received_s < 0.1, "{protocol:?}: {received_s} s");
                }
            }
            let counters = link.session.counters();
            assert_eq!(counters.rejected_readings, 0);
            assert_eq!(counters.dropped_bytes, dropped_on_clean_line(protocol), "{protocol:?}");
        }
    }
}

/// Loses, truncates, extends or flips a bit in one of `one_in` writes.
fn damaged_line(seed: u64, one_in: u32) -> Damage {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    Box::new(move |_, mut bytes| {
        if rng.random_range(0..one_in) == 0 {
            match rng.random_range(0..4) {
                0 => bytes.clear(),
                1 => bytes.truncate(rng.random_range(0..=bytes.len())),
                2 => bytes.insert(0, rng.random()),
                _ => {
                    let at = rng.random_range(0..bytes.len());
                    bytes[at] ^= 1 << rng.random_range(0..8);
                }
            }
        }
        bytes
    })
}

/// Counts set speeds that were never commanded.
fn count_uncommanded(set: &[TrackSpeeds], commanded: &[TrackSpeeds]) -> usize {
    let near = |one: &TrackSpeeds, other: &TrackSpeeds| {
        (one.left - other.left).abs() < RESOLUTION && (one.right - other.right).abs() < RESOLUTION
    };
    set.iter().filter(|set| !commanded.iter().any(|commanded| near(set, commanded))).count()
}

/// Drives on a line and counts set speeds that were never commanded.
fn drive_on(protocol: Protocol, damage: Damage) -> (usize, SimulatedLink) {
    let mut link = SimulatedLink::new(protocol, settings());
    link.damage = damage;
    let other = Twist::new(-0.3, 0.2);
    for _ in 0..20 {
        link.drive_for(CURVE, 0.5);
        link.drive_for(other, 0.5);
    }
    let drive = settings().drive();
    let commanded = [Twist::STOP, CURVE, other].map(|twist| drive.tracks(&twist));
    (count_uncommanded(&link.set, &commanded), link)
}

#[test]
fn damaged_line_never_changes_a_command() {
    for protocol in [Protocol::Native, Protocol::Wheeltec, Protocol::Roboclaw] {
        for seed in 0..5 {
            let (uncommanded, mut link) = drive_on(protocol, damaged_line(seed, 5));
            assert_eq!(uncommanded, 0, "{protocol:?}, seed {seed}");
            let counters = link.session.counters();
            assert!(counters.dropped_bytes > 0, "{protocol:?}: {counters:?}");
            // A clean line recovers.
            link.damage = Box::new(|_, bytes| bytes);
            link.drive_for(CURVE, 1.0);
            assert_near(link.twist(), CURVE, RESOLUTION, "driven");
            assert_near(link.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        }
    }
}

/// The test above must be able to fail: here a valid frame of another command is inserted once.
#[test]
fn inserted_command_is_counted() {
    for protocol in [Protocol::Native, Protocol::Wheeltec, Protocol::Roboclaw] {
        let mut forger = protocol.session(settings()).unwrap();
        forger.command(&Twist::new(0.9, 0.0)).unwrap();
        let mut forged = Vec::new();
        if protocol == Protocol::Roboclaw {
            forged = inbye::base::roboclaw::Request::Drive([9000, 9000]).encode(0x80);
        } else {
            forger.transmit(0.0, &mut forged);
        }
        let mut writes = 0;
        let damage: Damage = Box::new(move |direction, bytes| {
            writes += u32::from(direction == Direction::ToBase);
            if writes == 40 && direction == Direction::ToBase { forged.clone() } else { bytes }
        });
        let (uncommanded, _) = drive_on(protocol, damage);
        assert!(uncommanded > 0, "{protocol:?}");
    }
}

/// Text without a checksum may carry a wrong command, but the line recovers.
#[test]
fn arduino_recovers_from_damaged_line_without_odometry_jump() {
    for seed in 0..5 {
        let (_, mut link) = drive_on(Protocol::Arduino, damaged_line(seed, 5));
        assert!(link.session.counters().retries > 0);
        link.damage = Box::new(|_, bytes| bytes);
        link.drive_for(CURVE, 1.0);
        assert_near(link.twist(), CURVE, RESOLUTION, "driven");
    }
    // An extra digit in one of ten answers is no motion.
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut link = SimulatedLink::new(Protocol::Arduino, settings());
    link.start_encoders_at(100_000.0);
    link.damage = Box::new(move |direction, mut bytes| {
        let is_count = direction == Direction::ToHost && bytes[0].is_ascii_digit();
        if is_count && rng.random_range(0..10) == 0 {
            bytes.insert(0, rng.random_range(b'1'..=b'9'));
        }
        bytes
    });
    for _ in 0..200 {
        link.drive_for(CURVE, 0.1);
        if link.now_s > 0.5 {
            assert_near(link.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        }
    }
    assert!(link.session.counters().rejected_readings > 20);
}

#[test]
fn late_line_only_delays() {
    for protocol in Protocol::ALL {
        let mut link = SimulatedLink::new(protocol, settings());
        // 8 ms each way: within every timeout.
        link.delay_s = 0.008;
        link.drive_for(CURVE, 2.0);
        assert_near(link.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        assert_eq!(link.session.counters().retries, 0, "{protocol:?}");
    }
    // Beyond the timeout every answer meets the next attempt, and still nothing wrong is accepted.
    let mut link = SimulatedLink::new(Protocol::Roboclaw, settings());
    link.delay_s = 0.013;
    link.drive_for(CURVE, 3.0);
    assert!(link.session.counters().retries > 0);
    assert_eq!(
        count_uncommanded(
            &link.set,
            &[Twist::STOP, CURVE].map(|twist| settings().drive().tracks(&twist))
        ),
        0
    );
}
