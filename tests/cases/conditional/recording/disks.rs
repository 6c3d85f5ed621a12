//! Full, slow and broken disks, and truncated or damaged files.

use std::io::{self, Cursor, ErrorKind, Write};
use std::sync::mpsc::{Receiver, channel};

use inbye::recording::{BackpressurePolicy, Reader, RecordingError};
use inbye::runtime::Observer;

use super::drives::{Memory, cpu, record, record_by, replay_on, tour, try_replay_on};
use crate::support::mcap_copy::chunk_ends;

pub const TESTS: &[super::Test] = &[
    ("full_disk_stops_recording_not_drive", full_disk_stops_recording_not_drive),
    ("slow_disk_stops_recording_in_real_time", slow_disk_stops_recording_in_real_time),
    ("writes_are_at_most_a_chunk", writes_are_at_most_a_chunk),
    ("truncated_file_is_replayed_to_last_whole_chunk", truncated_file_is_replayed),
    ("damaged_file_is_rejected", damaged_file_is_rejected),
    ("other_files_are_rejected", other_files_are_rejected),
];

/// A disk with limited space.
struct SmallDisk {
    file: Memory,
    free_bytes: usize,
}

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.free_bytes);
        if taken == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        self.free_bytes -= taken;
        self.file.write(&bytes[..taken])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn full_disk_stops_recording_not_drive() {
    let (simulation, config) = tour();
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let alone = simulation.run(&config, cpu(1), &mut observer).expect("a valid mission");
    let (_, whole) = record(&simulation, &config);
    for free_bytes in [whole.len() / 3, whole.len() / 2 + 1, whole.len() - 1] {
        let file = Memory::default();
        let disk = SmallDisk { file: file.clone(), free_bytes };
        let ends = (&simulation, &config);
        let (result, recorded) = record_by(ends, &mut || 0.0, disk, BackpressurePolicy::Block);
        assert_eq!(result.trace.digest(), alone.trace.digest());
        let cause = recorded.stopped.expect("a full disk");
        assert!(cause.contains("no storage space"), "{cause}");
        assert_eq!(recorded.bytes, free_bytes as u64);
        let replay = replay_on(&file.bytes(), cpu(1));
        assert_eq!(replay.first_difference, None);
        assert!(!replay.is_complete);
        // The map once, seven messages in each tick, and the plans.
        let least = 1 + 7 * replay.ticks;
        let most = least + result.plans.len() as u64;
        assert!(replay.ticks >= 10, "{} ticks", replay.ticks);
        // What was written after the last whole chunk counts too.
        let most = most + 7 * 20;
        assert!((least..=most).contains(&recorded.messages), "{} messages", recorded.messages);
    }
}

/// A disk that accepts the metadata and then blocks until it is released.
struct BlockedDisk {
    file: Memory,
    release: Receiver<()>,
}

impl Write for BlockedDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.file.bytes().len() > 60_000 {
            // The recorder's thread waits here. If the drive waited, the test would hang.
            let _ = self.release.recv();
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn slow_disk_stops_recording_in_real_time() {
    let (simulation, config) = tour();
    let (release, released) = channel();
    let file = Memory::default();
    let disk = BlockedDisk { file: file.clone(), release: released };
    let mut ticks = 0;
    let engine = cpu(1);
    let metadata =
        inbye::recording::DriveMetadata::new(&simulation.mission, &config, engine.name());
    let mut recorder = inbye::recording::Recorder::new(disk, &metadata, BackpressurePolicy::Stop)
        .expect("space for the metadata");
    let mut kept = 0;
    let mut on_tick = |moment: &inbye::runtime::TickEvent<'_>| {
        ticks += 1;
        if recorder.record(moment) && recorder.stopped().is_none() {
            kept += 1;
        }
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let result = simulation.run(&config, engine, &mut observer).expect("a valid mission");
    assert_eq!(ticks, result.trace.rows.len());
    // The ticks of the blocked first chunk and those in the queue: there is no more memory.
    assert!((64..=64 + 22).contains(&kept), "{kept} of {ticks}");
    assert_eq!(recorder.stopped(), Some("the disk is too slow for the drive"));
    drop(release);
    let recorded = recorder.finish(result.trace.digest());
    assert!(recorded.stopped.is_some());
    let replay = replay_on(&file.bytes(), cpu(1));
    assert_eq!((replay.ticks, replay.is_complete), (kept, false));
    assert_eq!(replay.first_difference, None);
}

/// A disk that measures its largest write.
struct MeasuringDisk {
    file: Memory,
    bytes: std::sync::Arc<std::sync::atomic::AtomicUsize>,
}

impl Write for MeasuringDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        use std::sync::atomic::Ordering;
        self.bytes.fetch_max(bytes.len(), Ordering::Relaxed);
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn writes_are_at_most_a_chunk() {
    let (simulation, config) = tour();
    let file = Memory::default();
    let largest = std::sync::Arc::default();
    let disk = MeasuringDisk { file: file.clone(), bytes: std::sync::Arc::clone(&largest) };
    let ends = (&simulation, &config);
    let (_, recorded) = record_by(ends, &mut || 0.0, disk, BackpressurePolicy::Block);
    let largest = largest.load(std::sync::atomic::Ordering::Relaxed);
    assert!(largest < 1_200_000, "{largest}");
    assert!(recorded.bytes > 2 * largest as u64, "{recorded:?}");
}

fn truncated_file_is_replayed() {
    let (simulation, config) = tour();
    let (result, file) = record(&simulation, &config);
    let all = result.trace.rows.len() as u64;
    let ends = chunk_ends(&file);
    assert!(ends.len() > 5, "{ends:?}");
    let mut last = 0;
    for (number, &end) in ends.iter().enumerate().skip(1) {
        let replay = replay_on(&file[..end], cpu(1));
        assert_eq!((&replay.first_difference, replay.is_complete), (&None, false));
        assert!(replay.ticks > last, "chunk {number}");
        // One byte less loses the chunk, and with the first one all ticks. Half of the next chunk changes nothing.
        match try_replay_on(&file[..end - 1], cpu(1)) {
            Ok(shorter) => assert_eq!(shorter.ticks, last),
            Err(error) => assert!(last == 0 && matches!(error, RecordingError::NotOurs { .. })),
        }
        let next = ends.get(number + 1).copied().unwrap_or(file.len());
        let replayed = replay_on(&file[..end.midpoint(next)], cpu(1)).ticks;
        assert_eq!(replayed, replay.ticks);
        last = replay.ticks;
    }
    assert_eq!(last, all);
    // Without the last byte of its index the file is not complete.
    assert!(replay_on(&file, cpu(1)).is_complete);
    assert!(!replay_on(&file[..file.len() - 1], cpu(1)).is_complete);
    // Every truncation is reported.
    for end in (0..ends[1]).step_by(ends[1] / 100) {
        match Reader::open(Cursor::new(&file[..end])) {
            Ok(mut cut) => {
                while cut.next_tick().expect("a truncated file is valid").is_some() {}
                assert!(!cut.is_complete());
            }
            Err(error) => assert!(matches!(error, RecordingError::NotOurs { .. }), "{error}"),
        }
    }
}

fn damaged_file_is_rejected() {
    let (simulation, config) = tour();
    let (_, file) = record(&simulation, &config);
    let ends = chunk_ends(&file);
    for place in [ends[2] - 5_000, ends[3] - 10] {
        let mut copy = file.clone();
        copy[place] ^= 4;
        let mut recording = Reader::open(Cursor::new(&copy[..])).expect("valid metadata");
        let error = loop {
            match recording.next_tick() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("the damage at {place} went unnoticed"),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, RecordingError::Damaged { .. }), "{error}");
    }
}

fn other_files_are_rejected() {
    let open = |bytes: &[u8]| match Reader::open(Cursor::new(bytes)) {
        Ok(_) => panic!("not a recording"),
        Err(error) => error,
    };
    assert!(matches!(open(b"{\"time_s\": 0.0}"), RecordingError::NotMcap));
    assert!(matches!(open(b""), RecordingError::NotOurs { .. }));
    let mut empty = mcap::Writer::new(Cursor::new(Vec::new())).expect("writable memory");
    empty.finish().expect("writable memory");
    let empty = empty.into_inner().into_inner();
    assert!(matches!(open(&empty), RecordingError::NotOurs { .. }));
}
