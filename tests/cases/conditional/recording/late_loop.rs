//! A recorded drive in real time whose control loop stalls: the replay has the measured times, and repeats every bit.

use core::ops::ControlFlow;
use std::io::Cursor;

use inbye::geometry::Twist;
use inbye::recording::{BackpressurePolicy, DriveMetadata, Reader, Recorder};
use inbye::runtime::{GroundTruth, Observer, Robot, SensorData, TickEvent};
use inbye::sim::{FaultInjection, SimBase};

use super::drives::{Memory, cpu, replay_on, tour};
use crate::support::mcap_copy::altered;

pub const TESTS: &[super::Test] =
    &[("replay_repeats_a_drive_with_a_stalled_loop", replay_repeats_stalls)];

/// A simulated base with a clock. Its control loop stalls in every 13th tick, for up to 0.7 s.
struct StalledBase {
    base: SimBase,
    now_s: f64,
    ticks: usize,
}

impl Robot for StalledBase {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.base.sense(time_s)
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        self.base.ground_truth()
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.now_s)
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        self.ticks += 1;
        // No tick is punctual to the bit.
        let jitter_s = 1e-4 * (self.ticks % 7) as f64;
        let stall_s =
            if self.ticks.is_multiple_of(13) { 0.01 * (self.ticks % 71) as f64 } else { 0.0 };
        let elapsed_s = period_s + jitter_s + stall_s;
        self.now_s += elapsed_s;
        self.base.drive(command, elapsed_s)
    }
}

fn replay_repeats_stalls() {
    let (mut simulation, config) = tour();
    simulation.faults = vec![FaultInjection::LidarSilent { from_s: 6.0, to_s: 8.0 }];
    let recorded_config = config.clone().in_real_time();
    let file = Memory::default();
    let metadata = DriveMetadata::new(&simulation.mission, &recorded_config, cpu(1).name());
    let mut recorder = Recorder::new(file.clone(), &metadata, BackpressurePolicy::Block)
        .expect("space for the metadata");
    let mut on_tick = |tick: &TickEvent<'_>| {
        recorder.record(tick);
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let base = SimBase::of(&config, simulation.mission.start, 0).expect("valid settings");
    let mut base = StalledBase { base, now_s: 1.7e9, ticks: 0 };
    let driven = simulation.run_with(&mut base, &config, cpu(1), &mut observer);
    let result = driven.expect("a mission that can start");
    assert_eq!(recorder.finish(result.trace.digest()).stopped, None);
    assert!(result.late_ticks > 5, "{} of {}", result.late_ticks, result.trace.rows.len());
    let bytes = file.bytes();
    let replay = replay_on(&bytes, cpu(2));
    assert_eq!(replay.first_difference, None);
    assert!(replay.is_complete);
    assert_eq!(replay.drive.late_ticks, result.late_ticks);
    assert_eq!(replay.drive.time_s.to_bits(), result.time_s.to_bits());
    // The measured time decides: a recording with the tick of a stall at another time differs.
    let mut recording = Reader::open(Cursor::new(&bytes[..])).expect("a recording");
    let mut times = Vec::new();
    while let Some(tick) = recording.next_tick().expect("a whole file") {
        times.push(tick.observation.time_s);
    }
    let brakes = |tick: usize| {
        let row = &result.trace.rows[tick];
        times[tick] - times[tick - 1] > 0.2 && row.command.linear > 0.0
    };
    let late = (1..times.len()).find(|&tick| brakes(tick)).expect("a late tick");
    let copy = altered(&bytes, "/inbye/tick", late, |message| {
        let time_at = 20;
        assert_eq!(message[time_at..time_at + 8], times[late].to_le_bytes());
        let earlier_s = times[late] - 0.05;
        message[time_at..time_at + 8].copy_from_slice(&earlier_s.to_le_bytes());
    });
    let difference = replay_on(&copy, cpu(1)).first_difference;
    assert!(difference.is_some_and(|difference| difference.tick >= late as u64));
}
