//! Disks that are full, slow or pulled out, and files that were cut or damaged.

use std::io::{self, ErrorKind, Write};
use std::sync::mpsc::{Receiver, channel};

use inbye::recording::{DiskBusy, Recording, RecordingError};
use inbye::runtime::Observer;
use inbye::sim::simulate_mission;

use super::drives::{Memory, cpu, record, record_by, replay_on, tour};
use crate::support::mcap_copy::chunk_ends;

pub const TESTS: &[super::Test] = &[
    (
        "a full disk stops the recording and not the drive",
        a_full_disk,
    ),
    (
        "a slow disk stops the recording of a real robot",
        a_slow_disk,
    ),
    (
        "a long drive waits in memory by the chunk",
        chunks_are_small,
    ),
    (
        "a cut file is replayed up to its last whole chunk",
        a_cut_file,
    ),
    ("a damaged file is refused", a_damaged_file),
    ("other files are refused", other_files),
];

/// A disk with room for so many bytes.
struct Small {
    file: Memory,
    room: usize,
}

impl Write for Small {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.room);
        if taken == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        self.room -= taken;
        self.file.write(&bytes[..taken])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn a_full_disk() {
    let (mission, config) = tour();
    let mut observer = Observer {
        clock: &mut || 0.0,
        on_tick: &mut |_| {},
    };
    let alone = simulate_mission(&mission, &config, cpu(1), &mut observer).expect("it can begin");
    let (_, whole) = record(&mission, &config);
    for room in [whole.len() / 3, whole.len() / 2 + 1, whole.len() - 1] {
        let file = Memory::default();
        let disk = Small {
            file: file.clone(),
            room,
        };
        let ends = (&mission, &config);
        let (result, recorded) = record_by(ends, &mut || 0.0, disk, DiskBusy::Wait);
        assert_eq!(result.trace.digest(), alone.trace.digest());
        let why = recorded.stopped.expect("it was full");
        assert!(why.contains("no storage space"), "{why}");
        assert_eq!(recorded.bytes, room as u64);
        let replay = replay_on(&file.bytes(), cpu(1));
        assert_eq!(replay.first_difference, None);
        assert!(!replay.is_complete);
        // The map once, seven messages in each tick, and the plans.
        let least = 1 + 7 * replay.ticks;
        let most = least + result.plans.len() as u64;
        assert!(replay.ticks > 10 && (least..=most).contains(&recorded.messages));
    }
}

/// A disk that takes the head and then hangs until it is told to go on.
struct Hanging {
    file: Memory,
    writes: usize,
    go_on: Receiver<()>,
}

impl Write for Hanging {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writes += 1;
        if self.file.bytes().len() > 20_000 {
            // Who waits here is the recorder's thread: were it the drive, the test would hang.
            let _ = self.go_on.recv();
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn a_slow_disk() {
    let (mission, config) = tour();
    let (go_on, told) = channel();
    let file = Memory::default();
    let disk = Hanging {
        file: file.clone(),
        writes: 0,
        go_on: told,
    };
    let mut ticks = 0;
    let engine = cpu(1);
    let head = inbye::recording::Head::new(&mission, &config, engine.name());
    let mut recorder =
        inbye::recording::Recorder::new(disk, &head, DiskBusy::Stop).expect("the head fits");
    let mut kept = 0;
    let mut on_tick = |moment: &inbye::runtime::TickEvent<'_>| {
        ticks += 1;
        if recorder.record(moment) && recorder.stopped().is_none() {
            kept += 1;
        }
    };
    let mut observer = Observer {
        clock: &mut || 0.0,
        on_tick: &mut on_tick,
    };
    let result = simulate_mission(&mission, &config, engine, &mut observer).expect("it can begin");
    assert_eq!(ticks, result.trace.rows.len());
    // Those of the first chunk, which the disk hung on, and those that wait: that is all the memory there is.
    assert!((64..=64 + 22).contains(&kept), "{kept} of {ticks}");
    assert_eq!(
        recorder.stopped(),
        Some("the disk is too slow for the drive")
    );
    drop(go_on);
    let recorded = recorder.finish(result.trace.digest());
    assert!(recorded.stopped.is_some());
    let replay = replay_on(&file.bytes(), cpu(1));
    assert_eq!((replay.ticks, replay.is_complete), (kept, false));
    assert_eq!(replay.first_difference, None);
}

/// The largest piece that it was given.
struct Largest {
    file: Memory,
    bytes: std::sync::Arc<std::sync::atomic::AtomicUsize>,
}

impl Write for Largest {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        use std::sync::atomic::Ordering;
        self.bytes.fetch_max(bytes.len(), Ordering::Relaxed);
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn chunks_are_small() {
    let (mission, config) = tour();
    let file = Memory::default();
    let largest = std::sync::Arc::default();
    let disk = Largest {
        file: file.clone(),
        bytes: std::sync::Arc::clone(&largest),
    };
    let ends = (&mission, &config);
    let (_, recorded) = record_by(ends, &mut || 0.0, disk, DiskBusy::Wait);
    let largest = largest.load(std::sync::atomic::Ordering::Relaxed);
    assert!(largest < 1_200_000, "{largest}");
    assert!(recorded.bytes > 2 * largest as u64, "{recorded:?}");
}

fn a_cut_file() {
    let (mission, config) = tour();
    let (result, file) = record(&mission, &config);
    let all = result.trace.rows.len() as u64;
    let ends = chunk_ends(&file);
    assert!(ends.len() > 5, "{ends:?}");
    let mut last = 0;
    for (number, &end) in ends.iter().enumerate().skip(1) {
        let replay = replay_on(&file[..end], cpu(1));
        assert_eq!(
            (&replay.first_difference, replay.is_complete),
            (&None, false)
        );
        assert!(replay.ticks > last, "chunk {number}");
        // A byte short of it, the chunk is lost; with half of the next it is not.
        assert_eq!(replay_on(&file[..end - 1], cpu(1)).ticks, last);
        let next = ends.get(number + 1).copied().unwrap_or(file.len());
        let replayed = replay_on(&file[..end.midpoint(next)], cpu(1)).ticks;
        assert_eq!(replayed, replay.ticks);
        last = replay.ticks;
    }
    assert_eq!(last, all);
    // Without its index it is whole, but does not say so at its very end.
    assert!(replay_on(&file, cpu(1)).is_complete);
    assert!(!replay_on(&file[..file.len() - 1], cpu(1)).is_complete);
    // Wherever it is cut, somebody says so.
    for end in (0..ends[1]).step_by(ends[1] / 100) {
        match Recording::open(&file[..end]) {
            Ok(mut cut) => {
                while cut.next_tick().expect("a cut is no damage").is_some() {}
                assert!(!cut.is_complete());
            }
            Err(error) => assert!(matches!(error, RecordingError::NotOurs { .. }), "{error}"),
        }
    }
}

fn a_damaged_file() {
    let (mission, config) = tour();
    let (_, file) = record(&mission, &config);
    let ends = chunk_ends(&file);
    for place in [ends[2] - 5_000, ends[3] - 10] {
        let mut copy = file.clone();
        copy[place] ^= 4;
        let mut recording = Recording::open(&copy[..]).expect("its head is whole");
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

fn other_files() {
    let open = |bytes: &[u8]| match Recording::open(bytes) {
        Ok(_) => panic!("it is no recording"),
        Err(error) => error,
    };
    assert!(matches!(
        open(b"{\"time_s\": 0.0}"),
        RecordingError::NotMcap
    ));
    assert!(matches!(open(b""), RecordingError::NotOurs { .. }));
    let mut empty = mcap::Writer::new(io::Cursor::new(Vec::new())).expect("memory takes it");
    empty.finish().expect("memory takes it");
    let empty = empty.into_inner().into_inner();
    assert!(matches!(open(&empty), RecordingError::NotOurs { .. }));
}
