//! What the shaders read of a batch and write, as Rust sees it. TWIN of `shaders/layout.wgsl`; what they read of one
//! problem is in `inputs.rs`.

use bytemuck::{Pod, Zeroable};

use crate::local::QuantizedProblem;
use crate::local::engine::{Counts, Evaluation, SampleRecord, SampleStatus, Terms, Totals, Winner};
use crate::local::kernel_inputs::{Header, VxSample};

/// Number of bindings.
pub const BINDINGS: usize = 9;
/// Number of the binding that holds the fields. Those before it all show the input from its start.
pub const FIELD: usize = 4;
/// Number of the binding that holds a [`super::layout::Record`] for each sample of a batch.
pub const RECORDS: usize = 6;
/// Number of the binding that holds a [`super::layout::Answer`] for each problem of a batch.
pub const ANSWERS: usize = 8;

/// How the shaders reach a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// As a uniform.
    Uniform,
    /// As storage that is only read.
    Read,
    /// As storage that is read and written.
    ReadWrite,
}

/// The access of each binding of `shaders/layout.wgsl`, by its number.
pub const ACCESS: [Access; BINDINGS] = [
    Access::Uniform,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::ReadWrite,
    Access::ReadWrite,
    Access::ReadWrite,
    Access::ReadWrite,
];

/// Threads of a workgroup of `tabulate_vtheta`: enough for the most samples, were they all turn rates, to need no more
/// than the 65,535 workgroups that every adapter allows.
pub const VTHETA_PER_GROUP: u32 = 128;
/// Threads of a workgroup of `evaluate_samples` and `score_samples`.
pub const SAMPLES_PER_GROUP: u32 = 256;
/// Bytes of a `Partial`.
pub const PARTIAL_BYTES: u64 = 64;

/// Problems of a batch: all of them fit into the uniform buffer that every adapter binds, 64 KiB.
pub const MAX_PROBLEMS: usize = 256;
/// Bytes of a `Batch` before its problems: their count, filled up to the 16-byte boundary that they need.
pub const BATCH_HEAD_BYTES: usize = 16;
/// Bytes of a `Batch`.
pub const BATCH_BYTES: usize = BATCH_HEAD_BYTES + MAX_PROBLEMS * size_of::<BatchEntry>();

/// Where a problem's parts begin in the buffers that all problems of a batch share.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BufferOffsets {
    /// Workgroups of turns and of samples before its own; those of samples have a `Partial` each.
    pub first_groups: [u32; 2],
    /// Speeds before its own, counted from the start of the input.
    pub first_vx: u32,
    /// Turns before its own, counted from the start of the input.
    pub first_vtheta: u32,
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
pub struct BatchEntry {
    /// The numbers that are not lists.
    pub header: Header,
    /// Where the lists are.
    pub offsets: BufferOffsets,
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
    /// A [`SampleStatus`] as a number.
    pub status: u32,
}

impl Record {
    /// The record of a sample with this speed.
    #[must_use]
    pub fn sample(&self, vx: &VxSample) -> SampleRecord {
        let status = SampleStatus::from_u32(self.status);
        let terms = Terms {
            heading: self.heading,
            clearance: self.clearance,
            velocity: if status == SampleStatus::Ok {
                vx.velocity_term
            } else {
                0
            },
            path: self.path,
        };
        SampleRecord { status, terms }
    }
}

/// All samples of a problem, from the bytes of their [`Record`]s.
pub(super) fn sample_records(problem: &QuantizedProblem, bytes: &[u8]) -> Vec<SampleRecord> {
    bytes
        .chunks_exact(size_of::<Record>())
        .map(bytemuck::pod_read_unaligned::<Record>)
        .zip(problem.vx_samples.iter().cycle())
        .map(|(record, vx)| record.sample(vx))
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
    pub min: [u32; 4],
    /// Greatest values.
    pub max: [u32; 4],
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
                min: self.min,
                max: self.max,
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
