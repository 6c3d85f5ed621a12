//! What the shaders read of a batch and write, as Rust sees it. TWIN of `shaders/layout.wgsl`; what they read of one
//! problem is in `inputs.rs`.

use bytemuck::{Pod, Zeroable};

use crate::local::Prepared;
use crate::local::contract::{Counts, Evaluation, Reason, SampleRecord, Terms, Totals, Winner};
use crate::local::inputs::{Header, Speed};

/// Threads of a workgroup of `tabulate_turns`: enough for the most samples, were they all turn rates, to need no more
/// than the 65,535 workgroups that every adapter allows.
pub const TURNS_PER_GROUP: u32 = 128;
/// Threads of a workgroup of `judge_samples` and `score_samples`.
pub const SAMPLES_PER_GROUP: u32 = 256;
/// Bytes of a `Partial`.
pub const PARTIAL_BYTES: u64 = 64;

/// Problems of a batch: all of them fit into the uniform buffer that every adapter binds, 64 KiB.
pub const MOST_PROBLEMS: usize = 256;
/// Bytes of a `Batch` before its problems: their count, filled up to the 16-byte boundary that they need.
pub const BATCH_HEAD_BYTES: usize = 16;
/// Bytes of a `Batch`.
pub const BATCH_BYTES: usize = BATCH_HEAD_BYTES + MOST_PROBLEMS * size_of::<Placed>();

/// Where a problem's parts begin in the buffers that all problems of a batch share.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Place {
    /// Workgroups of turns and of samples before its own; those of samples have a `Partial` each.
    pub first_groups: [u32; 2],
    /// Speeds before its own, counted from the start of the input.
    pub first_speed: u32,
    /// Turns before its own, counted from the start of the input.
    pub first_turn: u32,
    /// Words before its discs and moving obstacles, counted from the start of the input.
    pub first_body: u32,
    /// Words of fields before its own.
    pub first_field: u32,
    /// Words of tables before its own.
    pub first_table: u32,
    /// Records before its own.
    pub first_record: u32,
}

/// A problem's numbers and where its parts are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Placed {
    /// The numbers that are not lists.
    pub header: Header,
    /// Where the lists are.
    pub place: Place,
}

/// A sample, judged.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Record {
    /// Heading term.
    pub heading: u32,
    /// Clearance term.
    pub clearance: u32,
    /// Path term.
    pub path: u32,
    /// A [`Reason`] as a number.
    pub reason: u32,
}

impl Record {
    /// The record of a sample with this speed.
    #[must_use]
    pub fn sample(&self, speed: &Speed) -> SampleRecord {
        let reason = Reason::from_number(self.reason);
        let terms = Terms {
            heading: self.heading,
            clearance: self.clearance,
            velocity: if reason == Reason::Ok { speed.term } else { 0 },
            path: self.path,
        };
        SampleRecord { reason, terms }
    }
}

/// All samples of a problem, from the bytes of their [`Record`]s.
pub(super) fn sample_records(problem: &Prepared, bytes: &[u8]) -> Vec<SampleRecord> {
    bytes
        .chunks_exact(size_of::<Record>())
        .map(bytemuck::pod_read_unaligned::<Record>)
        .zip(problem.speeds.iter().cycle())
        .map(|(record, speed)| record.sample(speed))
        .collect()
}

/// What a decision returns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Answer {
    /// Admissible, collision, cannot stop, outside.
    pub counts: [u32; 4],
    /// Lower halves of the sums.
    pub sums_low: [u32; 4],
    /// Upper halves of the sums.
    pub sums_high: [u32; 4],
    /// Least values.
    pub least: [u32; 4],
    /// Greatest values.
    pub greatest: [u32; 4],
    /// Offset, mantissa and bits of each term's normaliser.
    pub normalizers: [[u32; 3]; 4],
    /// Index of the winner.
    pub winner: u32,
    /// Lower half of its score.
    pub score_low: u32,
    /// Upper half of its score.
    pub score_high: u32,
    /// Stamp of the problem answered.
    pub stamp: u32,
    /// Its heading, clearance, velocity and path terms.
    pub terms: [u32; 4],
}

impl Answer {
    /// The evaluation that this answer stands for.
    #[must_use]
    pub fn evaluation(&self, samples: Option<Vec<SampleRecord>>) -> Evaluation {
        let [admissible, collision, cannot_stop, outside] = self.counts;
        let [heading, clearance, velocity, path] = self.terms;
        let wide = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
        Evaluation {
            counts: Counts {
                admissible,
                collision,
                cannot_stop,
                outside,
            },
            totals: Totals {
                sums: core::array::from_fn(|term| wide(self.sums_low[term], self.sums_high[term])),
                least: self.least,
                greatest: self.greatest,
            },
            winner: (admissible > 0).then(|| Winner {
                index: self.winner,
                score: wide(self.score_low, self.score_high) as i64,
                terms: Terms {
                    heading,
                    clearance,
                    velocity,
                    path,
                },
            }),
            samples,
        }
    }
}
