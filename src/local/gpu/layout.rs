//! The inputs and outputs of the shaders for a batch. TWIN of `shaders/layout.wgsl`; the inputs of one problem are in
//! `kernel_inputs.rs`.

use bytemuck::{Pod, Zeroable};

use crate::local::QuantizedProblem;
use crate::local::engine::{Counts, Evaluation, SampleRecord, SampleStatus, Terms, Totals, Winner};
use crate::local::kernel_inputs::{Header, VxSample};

/// Number of bindings.
pub const BINDINGS: usize = 9;
/// Number of the binding of the fields. All bindings before it show the input from its start.
pub const FIELD: usize = 4;
/// Number of the binding of the [`Record`]s, one per sample of a batch.
pub const RECORDS: usize = 6;
/// Number of the binding of the [`Answer`]s, one per problem of a batch.
pub const ANSWERS: usize = 8;

/// Access of the shaders to a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Uniform buffer.
    Uniform,
    /// Read-only storage buffer.
    Read,
    /// Storage buffer that is read and written.
    ReadWrite,
}

/// The access of each binding of `shaders/layout.wgsl`, by number.
pub const ACCESS: [Access; BINDINGS] = {
    use Access::{Read, ReadWrite, Uniform};
    [Uniform, Read, Read, Read, Read, ReadWrite, ReadWrite, ReadWrite, ReadWrite]
};

/// Threads per workgroup of `tabulate_profiles`: each has a step of a turn profile.
pub const STEPS_PER_GROUP: u32 = 64;
/// Largest number of times that a workgroup takes turn profiles. With it the largest number of samples, all of them turn
/// rates, needs no more than the 65,535 workgroups that every adapter supports.
pub const MAX_TABULATION_ROUNDS: u32 = 65;

/// Number of turn profiles that a workgroup tabulates at once: a thread has a step, or one of every 64 steps. `lanes_of` of
/// `shaders/tabulate.wgsl` is the number of threads of each.
#[must_use]
pub const fn profiles_at_once(steps: u32) -> u32 {
    let bits = 32 - steps.wrapping_sub(1).leading_zeros();
    STEPS_PER_GROUP >> if bits < 6 { bits } else { 6 }
}
/// Threads per workgroup of `evaluate_samples` and `score_samples`.
pub const SAMPLES_PER_GROUP: u32 = 256;
/// Bytes of a `Partial`.
pub const PARTIAL_BYTES: u64 = 64;

/// Largest number of problems of a batch: they fit into the uniform buffer of 64 KiB that every adapter supports.
pub const MAX_PROBLEMS: usize = 256;
/// Bytes of a `Batch` before its problems: two counts and padding to a 16-byte boundary.
pub const BATCH_HEAD_BYTES: usize = 16;
/// Bytes of a `Batch`.
pub const BATCH_BYTES: usize = BATCH_HEAD_BYTES + MAX_PROBLEMS * size_of::<BatchEntry>();

/// Offsets of a problem's parts in the buffers of the batch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BufferOffsets {
    /// Workgroups of turn profiles and of samples before its own. A workgroup of samples has one `Partial`.
    pub first_groups: [u32; 2],
    /// Forward speeds before its own, from the start of the input.
    pub first_vx: u32,
    /// Turn profiles before its own, from the start of the input.
    pub first_profile: u32,
    /// Words before its discs, moving obstacles and segments, from the start of the input.
    pub first_list: u32,
    /// Words of fields before its own.
    pub first_field: u32,
    /// Words of tables before its own.
    pub first_table: u32,
    /// Records before its own.
    pub first_record: u32,
}

/// One problem of a batch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BatchEntry {
    /// The scalars.
    pub header: Header,
    /// Offsets of the lists.
    pub offsets: BufferOffsets,
}

/// An evaluated sample.
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
    /// Converts the record of a sample with this forward speed.
    #[must_use]
    pub fn sample(&self, vx: &VxSample) -> SampleRecord {
        let status = SampleStatus::from_u32(self.status);
        let terms = Terms {
            heading: self.heading,
            clearance: self.clearance,
            velocity: if status == SampleStatus::Ok { vx.velocity_term } else { 0 },
            path: self.path,
        };
        SampleRecord { status, terms }
    }
}

/// Decodes all samples of a problem from the bytes of their [`Record`]s.
pub(super) fn sample_records(problem: &QuantizedProblem, bytes: &[u8]) -> Vec<SampleRecord> {
    bytes
        .chunks_exact(size_of::<Record>())
        .map(bytemuck::pod_read_unaligned::<Record>)
        .zip(problem.vx_samples.iter().cycle())
        .map(|(record, vx)| record.sample(vx))
        .collect()
}

/// The answer to one problem.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Answer {
    /// Admissible, collision, cannot stop, outside.
    pub counts: [u32; 4],
    /// Lower halves of the sums.
    pub sums_low: [u32; 4],
    /// Upper halves of the sums.
    pub sums_high: [u32; 4],
    /// Minima.
    pub min: [u32; 4],
    /// Maxima.
    pub max: [u32; 4],
    /// Offset, mantissa and bits of each term's normaliser.
    pub normalizers: [[u32; 3]; 4],
    /// Index of the winner.
    pub winner: u32,
    /// Lower half of its score.
    pub score_low: u32,
    /// Upper half of its score.
    pub score_high: u32,
    /// Stamp of the problem.
    pub stamp: u32,
    /// Heading, clearance, velocity and path terms of the winner.
    pub terms: [u32; 4],
}

impl Answer {
    /// Converts the answer to an evaluation.
    #[must_use]
    pub fn evaluation(&self, samples: Option<Vec<SampleRecord>>) -> Evaluation {
        let [admissible, collision, cannot_stop, outside] = self.counts;
        let [heading, clearance, velocity, path] = self.terms;
        let wide = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
        Evaluation {
            counts: Counts { admissible, collision, cannot_stop, outside },
            totals: Totals {
                sums: core::array::from_fn(|term| wide(self.sums_low[term], self.sums_high[term])),
                min: self.min,
                max: self.max,
            },
            winner: (admissible > 0).then(|| Winner {
                index: self.winner,
                score: wide(self.score_low, self.score_high) as i64,
                terms: Terms { heading, clearance, velocity, path },
            }),
            samples,
        }
    }
}
