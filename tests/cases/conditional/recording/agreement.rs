//! A recorded drive is decided again with the same bits, on every engine, and one flipped bit is found.

use inbye::navigator::Mode;
use inbye::recording::{DiskBusy, Number, Recording};

use super::drives::{Memory, cpu, crowded, late_tour, record, record_by, replay_on, tour};
use crate::support::mcap_copy::altered;

pub const TESTS: &[super::Test] = &[
    ("a drive is decided again on the CPU", on_the_cpu),
    ("late decisions and plans are repeated", late_decisions),
    (
        "a flipped bit of a decision is found and named",
        a_flipped_bit,
    ),
    (
        "another observation is another decision",
        another_observation,
    ),
    ("a recording tells the drive to the bit", the_head),
];

pub const GPU_TESTS: [(&str, crate::support::adapters::GpuTest); 1] =
    [("a drive is decided again on the GPU", on_a_gpu)];

fn on_the_cpu() {
    for (mission, config) in [tour(), crowded()] {
        let (result, file) = record(&mission, &config);
        for threads in [1, 2] {
            let replay = replay_on(&file, cpu(threads));
            assert_eq!(replay.first_difference, None);
            assert_eq!(replay.ticks, result.trace.rows.len() as u64);
            assert!(replay.is_complete && replay.ticks > 50, "{replay:?}");
        }
    }
}

fn on_a_gpu(adapter: &inbye::local::Adapter) -> Result<(), libtest_mimic::Failed> {
    let (mission, config) = crowded();
    let (_, file) = record(&mission, &config);
    let engine = Box::new(inbye::local::GpuEngine::new(adapter)?);
    let replay = replay_on(&file, engine);
    match replay.first_difference {
        None if replay.is_complete => Ok(()),
        _ => Err(format!("{replay:?}").into()),
    }
}

fn late_decisions() {
    let (mission, config, mut clock) = late_tour();
    let file = Memory::default();
    let ends = (&mission, &config);
    let (result, recorded) = record_by(ends, &mut clock, file.clone(), DiskBusy::Wait);
    assert_eq!(recorded.stopped, None);
    let stats = result.deadline_stats.expect("there is a deadline");
    assert!(stats.misses > 5, "{stats:?}");
    let bytes = file.bytes();
    let mut recording = Recording::open(&bytes[..]).expect("a recording");
    let mut answers = Vec::new();
    while let Some(tick) = recording.next_tick().expect("it is whole") {
        answers.push(tick.plans_received);
    }
    assert!(
        answers.last() > Some(&0),
        "no plan was asked for on the way"
    );
    let replay = replay_on(&bytes, cpu(2));
    assert_eq!(replay.first_difference, None);
    assert!(replay.is_complete);
    // When a plan came is one of the numbers: told that the first came a tick later, the replay does otherwise.
    let first = answers
        .iter()
        .position(|&taken| taken > 0)
        .expect("one was");
    let at = command_at(config.lidar.beams) + 72;
    let copy = altered(&bytes, "/inbye/tick", first, |message| {
        assert_eq!(message[at..at + 8], 1_u64.to_le_bytes());
        message[at] = 0;
    });
    let difference = replay_on(&copy, cpu(1)).first_difference;
    assert!(difference.is_some_and(|difference| difference.tick >= first as u64));
}

/// Place of the command's speed in a tick with so many beams: behind the ranges, which stand at 108.
fn command_at(beams: usize) -> usize {
    108 + 8 * beams
}

fn a_flipped_bit() {
    let (mission, config) = tour();
    let (result, file) = record(&mission, &config);
    let at = command_at(config.lidar.beams);
    // The least significant bit of the speed, the turn rate and the target, and the mode.
    for (place, field) in [
        (at, "command_linear"),
        (at + 8, "command_angular"),
        (at + 16, "mode"),
        (at + 24, "target_x"),
        (at + 32, "target_y"),
    ] {
        for tick in [0, 7, result.trace.rows.len() - 1] {
            let copy = altered(&file, "/inbye/tick", tick, |message| message[place] ^= 1);
            let replay = replay_on(&copy, cpu(1));
            let difference = replay.first_difference.expect("it was flipped");
            assert_eq!((difference.tick, difference.field), (tick as u64, field));
            assert_eq!(
                difference.recorded.bits() ^ difference.replayed.bits(),
                1,
                "{difference:?}"
            );
            if field == "command_linear" {
                let driven = result.trace.rows[tick].command.linear;
                assert_eq!(difference.replayed, Number::Real(driven));
            }
            assert_eq!(replay.ticks, result.trace.rows.len() as u64);
        }
    }
}

fn another_observation() {
    let (mission, config) = tour();
    let (_, file) = record(&mission, &config);
    // The exponent of the pose's x: the robot seems to have jumped, and brakes.
    let copy = altered(&file, "/inbye/tick", 9, |message| message[42] ^= 0x10);
    let replay = replay_on(&copy, cpu(1));
    let difference = replay.first_difference.expect("it seems to be elsewhere");
    assert_eq!(difference.tick, 9, "{difference:?}");
    assert_eq!(
        difference.replayed,
        Number::Word("sensor_fault", Mode::SensorFault as u64)
    );
}

fn the_head() {
    let (mission, config) = tour();
    let (result, file) = record(&mission, &config);
    let mut recording = Recording::open(&file[..]).expect("a recording");
    assert_eq!(recording.head().config, config);
    assert_eq!(*recording.head().map, *mission.map);
    assert_eq!(recording.head().journey.stops, mission.stops());
    for row in &result.trace.rows {
        let tick = recording
            .next_tick()
            .expect("it is whole")
            .expect("as many");
        assert_eq!(tick.observation.pose, row.belief);
        assert_eq!(tick.decision.command, row.command);
        assert_eq!(tick.decision.mode, row.mode);
    }
    assert!(recording.next_tick().expect("it is whole").is_none());
    let tail = recording.tail().expect("it ended");
    assert_eq!(tail.trace_digest, result.trace.digest());
}
