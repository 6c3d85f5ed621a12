//! A replay gives the recorded bits on every engine, and reports one flipped bit.

use core::ops::ControlFlow;
use std::io::Cursor;

use inbye::local::{CpuEngine, EngineError, Failover};
use inbye::navigator::Mode;
use inbye::recording::{
    BackpressurePolicy, DriveMetadata, FieldValue, Reader, Recorder, RecordingError, replay,
};

use super::drives::{
    Memory, cpu, crowded, late_tour, record, record_by, replay_on, tour, try_replay_on,
};
use crate::support::mcap_copy::altered;

pub const TESTS: &[super::Test] = &[
    ("replay_on_cpu_agrees", replay_on_cpu_agrees),
    ("replay_counts_decisions_of_cpu_in_place_of_gpu", replay_counts_decisions_of_cpu),
    ("replay_repeats_late_decisions_and_plans", replay_repeats_late_decisions),
    ("replay_reports_flipped_bit_of_decision", replay_reports_flipped_bit),
    ("replay_of_changed_observation_differs", replay_of_changed_observation_differs),
    ("reader_returns_drive_to_the_bit", reader_returns_drive),
    ("recording_without_ticks_is_no_agreement", recording_without_ticks_is_rejected),
    ("replay_ends_where_its_observer_breaks", replay_ends_at_break),
];

pub const GPU_TESTS: [(&str, crate::support::adapters::GpuTest); 1] =
    [("replay_on_gpu_agrees", replay_on_gpu_agrees)];

fn replay_on_cpu_agrees() {
    let (among_people, mut mounted) = crowded();
    mounted.simulation.lidar = mounted.simulation.lidar.mount_x_m(0.25).scan_rate_hz(Some(7.0));
    for (simulation, config) in [tour(), crowded(), (among_people, mounted)] {
        let (result, file) = record(&simulation, &config);
        for threads in [1, 2] {
            let replay = replay_on(&file, cpu(threads));
            assert_eq!(replay.first_difference, None);
            assert_eq!(replay.ticks, result.trace.rows.len() as u64);
            assert!(replay.is_complete && replay.ticks > 50, "{replay:?}");
        }
    }
}

fn recording_without_ticks_is_rejected() {
    let (simulation, config) = tour();
    let metadata = DriveMetadata::new(&simulation.mission, &config, "CPU".to_owned());
    let file = Memory::default();
    let recorder = Recorder::new(file.clone(), &metadata, BackpressurePolicy::Block);
    let report = recorder.expect("valid metadata").finish(String::new());
    assert_eq!(report.stopped, None);
    let error = try_replay_on(&file.bytes(), cpu(1));
    let error = error.expect_err("no tick").to_string();
    assert!(error.starts_with("the file has no tick"), "{error}");
}

fn replay_ends_at_break() {
    let (simulation, config) = tour();
    let (_, file) = record(&simulation, &config);
    let mut recording = Reader::open(Cursor::new(file)).expect("a recording");
    let mut seen = 0;
    let error = replay(&mut recording, cpu(1), None, &mut |_| {
        seen += 1;
        if seen == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(matches!(error, Err(RecordingError::Interrupted { ticks: 3 })), "{error:?}");
}

/// The bits agree, but they are not those of the GPU.
fn replay_counts_decisions_of_cpu() {
    let (simulation, config) = tour();
    let (_, file) = record(&simulation, &config);
    let with_fallback = |gpu| {
        let source = || Err(EngineError::NoAdapter);
        Box::new(Failover::new(gpu, source, CpuEngine::single_threaded()))
    };
    let replay = replay_on(&file, with_fallback(Err(EngineError::NoAdapter)));
    assert_eq!(replay.first_difference, None);
    assert!(replay.cpu_ticks() > 20, "{}", replay.cpu_ticks());
    assert_eq!(replay_on(&file, with_fallback(Ok(cpu(1)))).cpu_ticks(), 0);
    assert_eq!(replay_on(&file, cpu(1)).cpu_ticks(), 0);
}

fn replay_on_gpu_agrees(adapter: &inbye::local::Adapter) -> Result<(), libtest_mimic::Failed> {
    let (simulation, config) = crowded();
    let (_, file) = record(&simulation, &config);
    let engine = Box::new(inbye::local::GpuEngine::new(adapter)?);
    let replay = replay_on(&file, engine);
    match replay.first_difference {
        None if replay.is_complete => Ok(()),
        _ => Err(format!("{replay:?}").into()),
    }
}

fn replay_repeats_late_decisions() {
    let (simulation, config, mut clock) = late_tour();
    let file = Memory::default();
    let ends = (&simulation, &config);
    let (result, recorded) = record_by(ends, &mut clock, file.clone(), BackpressurePolicy::Block);
    assert_eq!(recorded.stopped, None);
    let stats = result.deadline_stats.expect("a deadline");
    assert!(stats.misses > 5, "{stats:?}");
    let bytes = file.bytes();
    let mut recording = Reader::open(Cursor::new(&bytes[..])).expect("a recording");
    let mut received = Vec::new();
    while let Some(tick) = recording.next_tick().expect("a whole file") {
        received.push(tick.plans_received);
    }
    assert!(received.last() > Some(&0), "no plan was received during the drive");
    let replay = replay_on(&bytes, cpu(2));
    assert_eq!(replay.first_difference, None);
    assert!(replay.is_complete);
    // The arrival of plans is recorded: if the first arrives a tick later, the replay differs.
    let first = received.iter().position(|&count| count > 0).expect("a plan was received");
    let at = command_at(config.simulation.lidar.beams) + 72;
    let copy = altered(&bytes, "/inbye/tick", first, |message| {
        assert_eq!(message[at..at + 8], 1_u64.to_le_bytes());
        message[at] = 0;
    });
    let difference = replay_on(&copy, cpu(1)).first_difference;
    assert!(difference.is_some_and(|difference| difference.tick >= first as u64));
}

/// Offset of the commanded speed in a tick, after the ranges at offset 164.
fn command_at(beams: usize) -> usize {
    164 + 8 * beams
}

fn replay_reports_flipped_bit() {
    let (simulation, config) = tour();
    let (result, file) = record(&simulation, &config);
    let at = command_at(config.simulation.lidar.beams);
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
            let difference = replay.first_difference.expect("the bit is flipped");
            assert_eq!((difference.tick, difference.field), (tick as u64, field));
            assert_eq!(
                difference.recorded.bits() ^ difference.replayed.bits(),
                1,
                "{difference:?}"
            );
            if field == "command_linear" {
                let driven = result.trace.rows[tick].command.linear;
                assert_eq!(difference.replayed, FieldValue::Real(driven));
            }
            assert_eq!(replay.ticks, result.trace.rows.len() as u64);
        }
    }
}

fn replay_of_changed_observation_differs() {
    let (simulation, config) = tour();
    let (_, file) = record(&simulation, &config);
    // The exponent of x: the pose jumps, and the robot brakes.
    let copy = altered(&file, "/inbye/tick", 9, |message| message[82] ^= 0x10);
    let replay = replay_on(&copy, cpu(1));
    let difference = replay.first_difference.expect("the pose jumps");
    assert_eq!(difference.tick, 9, "{difference:?}");
    assert_eq!(difference.replayed, FieldValue::Named("sensor_fault", Mode::SensorFault as u64));
}

fn reader_returns_drive() {
    let (simulation, config) = tour();
    let (result, file) = record(&simulation, &config);
    let mut recording = Reader::open(Cursor::new(&file[..])).expect("a recording");
    assert_eq!(recording.metadata().config, config);
    assert_eq!(*recording.metadata().map, *simulation.mission.map);
    assert_eq!(recording.metadata().waypoints.goals, simulation.mission.stops());
    for row in &result.trace.rows {
        let tick = recording.next_tick().expect("a whole file").expect("as many ticks");
        assert_eq!(tick.observation.pose, row.belief);
        assert_eq!(tick.decision.command, row.command);
        assert_eq!(tick.decision.mode, row.mode);
    }
    assert!(recording.next_tick().expect("a whole file").is_none());
    let summary = recording.summary().expect("the drive has ended");
    assert_eq!(summary.trace_digest, result.trace.digest());
}
