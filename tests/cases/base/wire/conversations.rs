//! Each protocol's session against its peer: on a clean line, on a bad one, and with every wiring.

use inbye::base::{BaseSettings, Protocol};
use inbye::geometry::Twist;
use inbye::robot::{PerTrack, TrackLimits, TrackSpeeds};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::line::{Conversation, Damage, Way};

const CURVE: Twist = Twist::new(0.5, 0.4);

/// One tick per 33 ms, the coarsest step of any protocol, is 3 mm/s a track.
const RESOLUTION: f64 = 0.004;

fn settings() -> BaseSettings {
    BaseSettings {
        effective_width_ratio: 1.5,
        ticks_per_m: PerTrack::new(10_000.0, 12_000.0),
        ..BaseSettings::default()
    }
}

fn assert_near(found: Twist, wanted: Twist, tolerance: f64, what: &str) {
    let apart = (found.linear - wanted.linear).abs() + 0.5 * (found.angular - wanted.angular).abs();
    assert!(apart <= 2.0 * tolerance, "{what}: {found:?} for {wanted:?}");
}

#[test]
fn a_clean_line_drives_as_told_and_tells_the_truth() {
    for protocol in Protocol::ALL {
        let mut talk = Conversation::new(protocol, settings());
        talk.keep_on(CURVE, 2.0);
        assert_near(talk.twist(), CURVE, RESOLUTION, "driven");
        assert_near(talk.feedback().twist, CURVE, 2.0 * RESOLUTION, "reported");
        let counters = talk.session.counters();
        // Nothing but the answer to the carriage return that goes first.
        let clean = match protocol {
            Protocol::Arduino => b"Invalid Command\r\n".len() as u64,
            _ => 0,
        };
        assert_eq!(counters.dropped_bytes, clean, "{protocol:?}");
        assert_eq!(
            (
                counters.retries,
                counters.unanswered,
                counters.rejected_readings
            ),
            (0, 0, 0),
            "{protocol:?}"
        );
        assert!(talk.feedback().faults.is_empty(), "{protocol:?}");
        let battery_v = talk.feedback().battery_v;
        assert!(battery_v.is_none_or(|volts| (volts - 24.0).abs() < 1e-9));
        assert_eq!(battery_v.is_none(), protocol == Protocol::Arduino);
        talk.keep_on(Twist::STOP, 1.0);
        assert_near(talk.twist(), Twist::STOP, 1e-6, "stopped");
    }
}

#[test]
fn every_wiring_drives_the_same_robot() {
    for protocol in Protocol::ALL {
        for wiring in 0..8 {
            let settings = BaseSettings {
                swap_tracks: wiring & 1 != 0,
                reversed: PerTrack::new(wiring & 2 != 0, wiring & 4 != 0),
                ..settings()
            };
            let mut talk = Conversation::new(protocol, settings);
            talk.keep_on(CURVE, 1.0);
            assert_near(talk.twist(), CURVE, RESOLUTION, "driven");
            assert_near(talk.feedback().twist, CURVE, 2.0 * RESOLUTION, "reported");
            if let Some(ticks) = talk.feedback().encoder_counts {
                assert!(
                    (ticks.left as i32) > 0 && ticks.left as i32 <= 5000,
                    "{ticks:?}"
                );
            }
        }
    }
}

/// A host that does not know of swapped tracks turns the wrong way, and its encoders do not show it.
#[test]
fn swapped_tracks_that_the_host_does_not_know_turn_the_other_way() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        let even = BaseSettings::default();
        let swapped = BaseSettings {
            swap_tracks: true,
            ..even
        };
        let mut talk = Conversation::between(protocol, even, swapped);
        talk.keep_on(CURVE, 1.0);
        assert_near(talk.twist(), Twist::new(0.5, -0.4), RESOLUTION, "driven");
        assert_near(talk.feedback().twist, CURVE, 2.0 * RESOLUTION, "believed");
    }
}

#[test]
fn commands_beyond_a_track_are_scaled_with_their_curvature() {
    for protocol in Protocol::ALL {
        let limits = TrackLimits {
            max_track_speed: 0.5,
            ..TrackLimits::default()
        };
        let settings = BaseSettings {
            tracks: limits,
            ..BaseSettings::default()
        };
        let mut talk = Conversation::new(protocol, settings);
        talk.keep_on(Twist::new(0.8, 0.8), 2.0);
        assert_near(talk.twist(), Twist::new(0.4, 0.4), RESOLUTION, "driven");
    }
}

#[test]
fn commands_that_are_not_finite_are_refused_and_leave_the_last_one() {
    for protocol in Protocol::ALL {
        let mut talk = Conversation::new(protocol, settings());
        talk.keep_on(CURVE, 1.0);
        assert!(talk.session.command(&Twist::new(f64::NAN, 0.0)).is_err());
        talk.wait(0.02);
        assert_near(talk.twist(), CURVE, RESOLUTION, "driven");
    }
}

#[test]
fn counters_that_wrap_do_not_move_the_robot() {
    for protocol in [Protocol::Native, Protocol::Roboclaw, Protocol::Arduino] {
        // 4000 ticks before the wrap of 2^32 and of 2^31, at 4000 to 7200 ticks a second.
        for start in [f64::from(u32::MAX), f64::from(i32::MAX)] {
            let mut talk = Conversation::new(protocol, settings());
            talk.start_encoders_at(start - 4000.0);
            for _ in 0..20 {
                talk.keep_on(CURVE, 0.1);
                if talk.now_s > 0.5 {
                    assert_near(talk.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
                }
            }
            assert_eq!(talk.session.counters().rejected_readings, 0);
        }
    }
}

/// A line that loses, cuts, merges, and flips bits in one of so many writes.
fn bad_line(seed: u64, one_in: u32) -> Damage {
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

/// Speeds that the base was set to although nobody commanded them.
fn foreign(set: &[TrackSpeeds], commanded: &[TrackSpeeds]) -> usize {
    let near = |one: &TrackSpeeds, other: &TrackSpeeds| {
        (one.left - other.left).abs() < RESOLUTION && (one.right - other.right).abs() < RESOLUTION
    };
    set.iter()
        .filter(|set| !commanded.iter().any(|commanded| near(set, commanded)))
        .count()
}

/// Drives on a line and returns how often the base was set to what nobody commanded.
fn foreign_on(protocol: Protocol, damage: Damage) -> (usize, Conversation) {
    let mut talk = Conversation::new(protocol, settings());
    talk.damage = damage;
    let other = Twist::new(-0.3, 0.2);
    for _ in 0..20 {
        talk.keep_on(CURVE, 0.5);
        talk.keep_on(other, 0.5);
    }
    let drive = settings().drive();
    let commanded = [Twist::STOP, CURVE, other].map(|twist| drive.tracks(&twist));
    (foreign(&talk.set, &commanded), talk)
}

#[test]
fn a_bad_line_never_makes_another_command_of_one() {
    for protocol in [Protocol::Native, Protocol::Wheeltec, Protocol::Roboclaw] {
        for seed in 0..5 {
            let (foreign, mut talk) = foreign_on(protocol, bad_line(seed, 5));
            assert_eq!(foreign, 0, "{protocol:?}, seed {seed}");
            let counters = talk.session.counters();
            assert!(counters.dropped_bytes > 0, "{protocol:?}: {counters:?}");
            // And it is forgotten when the line is good again.
            talk.damage = Box::new(|_, bytes| bytes);
            talk.keep_on(CURVE, 1.0);
            assert_near(talk.twist(), CURVE, RESOLUTION, "driven");
            assert_near(talk.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        }
    }
}

/// The check above must be able to fail: here a good frame of another command is slipped in once.
#[test]
fn a_command_slipped_in_is_seen() {
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
        let damage: Damage = Box::new(move |way, bytes| {
            writes += u32::from(way == Way::ToBase);
            if writes == 40 && way == Way::ToBase {
                forged.clone()
            } else {
                bytes
            }
        });
        let (foreign, _) = foreign_on(protocol, damage);
        assert!(foreign > 0, "{protocol:?}");
    }
}

/// Text without a check: what it makes of damage is bounded by what follows, and the line recovers.
#[test]
fn the_arduino_recovers_from_a_bad_line_and_its_odometry_never_jumps() {
    for seed in 0..5 {
        let (_, mut talk) = foreign_on(Protocol::Arduino, bad_line(seed, 5));
        assert!(talk.session.counters().retries > 0);
        talk.damage = Box::new(|_, bytes| bytes);
        talk.keep_on(CURVE, 1.0);
        assert_near(talk.twist(), CURVE, RESOLUTION, "driven");
    }
    // A digit more in one of ten answers is no motion.
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut talk = Conversation::new(Protocol::Arduino, settings());
    talk.start_encoders_at(100_000.0);
    talk.damage = Box::new(move |way, mut bytes| {
        let is_count = way == Way::ToHost && bytes[0].is_ascii_digit();
        if is_count && rng.random_range(0..10) == 0 {
            bytes.insert(0, rng.random_range(b'1'..=b'9'));
        }
        bytes
    });
    for _ in 0..200 {
        talk.keep_on(CURVE, 0.1);
        if talk.now_s > 0.5 {
            assert_near(talk.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        }
    }
    assert!(talk.session.counters().rejected_readings > 20);
}

#[test]
fn a_late_line_only_delays() {
    for protocol in Protocol::ALL {
        let mut talk = Conversation::new(protocol, settings());
        // 8 ms each way: within every time-out.
        talk.delay_s = 0.008;
        talk.keep_on(CURVE, 2.0);
        assert_near(talk.feedback().twist, CURVE, 3.0 * RESOLUTION, "reported");
        assert_eq!(talk.session.counters().retries, 0, "{protocol:?}");
    }
    // Beyond the time-out every answer comes to the next try, and still nothing wrong is believed.
    let mut talk = Conversation::new(Protocol::Roboclaw, settings());
    talk.delay_s = 0.013;
    talk.keep_on(CURVE, 3.0);
    assert!(talk.session.counters().retries > 0);
    assert_eq!(
        foreign(
            &talk.set,
            &[Twist::STOP, CURVE].map(|twist| settings().drive().tracks(&twist))
        ),
        0
    );
}
