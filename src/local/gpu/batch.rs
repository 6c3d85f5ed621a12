//! Selects the problems of one submission and places their parts in the shared buffers.

use serde::Serialize;

use super::layout::BINDINGS;
use super::layout::{
    Answer, BATCH_BYTES, BATCH_HEAD_BYTES, BatchEntry, BufferOffsets, MAX_PROBLEMS,
    MAX_TABULATION_ROUNDS, PARTIAL_BYTES, Record, SAMPLES_PER_GROUP, profiles_at_once,
    sample_records,
};
use super::pipelines::Pipeline;
use crate::local::engine::{Detail, Evaluation};
use crate::local::kernel_inputs::{
    ProfileSegment, QuantizedDisc, QuantizedObstacle, TurnProfile, VxSample,
};
use crate::local::{ClearanceField, QuantizedProblem, rollout};

/// Largest number of samples of a batch of several problems: the limit of one problem, so that no batch takes longer
/// than one problem may.
const MAX_SAMPLES: u64 = 1 << 22;
/// Largest number of workgroups of a dispatch that every adapter supports.
const MAX_WORKGROUPS: u32 = 65_535;
/// Largest number of samples of a problem for which one workgroup finds the winner: the two dispatches that this saves take
/// longer on a GPU than its own work.
const MAX_DECIDED_AT_ONCE: usize = 8192;
/// Largest binding of a batch of several problems, bytes: every adapter supports it. A single problem may use the
/// adapter's own limit.
pub(super) const MAX_BYTES: u64 = 128 << 20;

/// Sizes of the parts of a batch.
#[derive(Clone, Copy, Debug, Default)]
struct Amount {
    problems: u64,
    vx_samples: u64,
    profiles: u64,
    list_words: u64,
    field_words: u64,
    table_words: u64,
    samples: u64,
    /// Workgroups of turn profiles if each takes rows once.
    profile_groups: u64,
    sample_groups: u64,
}

impl Amount {
    /// Adds a problem without its field.
    fn add(&mut self, problem: &QuantizedProblem) {
        let profiles = problem.profiles.len() as u64;
        let samples = problem.len() as u64;
        let table_words = rollout::table_words(&problem.header) as u64;
        let discs = size_of_val::<[QuantizedDisc]>(&problem.discs);
        let obstacles = size_of_val::<[QuantizedObstacle]>(&problem.obstacles);
        self.problems += 1;
        self.vx_samples += problem.vx_samples.len() as u64;
        self.profiles += profiles;
        let segments = size_of_val::<[ProfileSegment]>(&problem.segments);
        self.list_words += (discs + obstacles + segments) as u64 / 4;
        self.table_words += table_words * profiles;
        self.profile_groups += u64::from(profile_groups_of(problem, 1));
        self.samples += samples;
        self.sample_groups += samples.div_ceil(u64::from(SAMPLES_PER_GROUP));
    }

    /// Byte offsets of forward speeds, turn profiles and lists in the input, and its length. Each part is aligned to its
    /// own element.
    fn input_offsets(&self) -> [u64; 4] {
        let vx_samples = BATCH_HEAD_BYTES as u64 + self.problems * size_of::<BatchEntry>() as u64;
        let profiles = (vx_samples + self.vx_samples * size_of::<VxSample>() as u64)
            .next_multiple_of(size_of::<TurnProfile>() as u64);
        let lists = profiles + self.profiles * size_of::<TurnProfile>() as u64;
        [vx_samples, profiles, lists, lists + self.list_words * 4]
    }

    fn sizes(&self) -> Sizes {
        let [.., input] = self.input_offsets();
        Sizes {
            // The shaders declare a batch of the largest length.
            input: input.max(BATCH_BYTES as u64),
            field: self.field_words * 4,
            table: self.table_words * 4,
            records: self.samples * size_of::<Record>() as u64,
            partials: self.sample_groups * PARTIAL_BYTES,
            answers: self.problems * size_of::<Answer>() as u64,
        }
    }
}

/// Sizes of the buffers, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// Batch, forward speeds, turn profiles and lists, in this order.
    pub input: u64,
    /// The fields, each once.
    pub field: u64,
    /// Tables of all turn profiles.
    pub table: u64,
    /// Records of all samples.
    pub records: u64,
    /// Partials of all workgroups of samples.
    pub partials: u64,
    /// Answers to all problems.
    pub answers: u64,
}

impl Sizes {
    /// Size of each binding, by number. The first four show the input from its start.
    #[must_use]
    pub const fn bindings(&self) -> [u64; BINDINGS] {
        [
            BATCH_BYTES as u64,
            self.input,
            self.input,
            self.input,
            self.field,
            self.table,
            self.records,
            self.partials,
            self.answers,
        ]
    }

    /// Largest number of bytes that are read back.
    #[must_use]
    pub const fn readback(&self) -> u64 {
        self.answers + self.records
    }

    /// Size of the largest buffer.
    #[must_use]
    pub fn largest(&self) -> u64 {
        [self.input, self.field, self.table, self.readback()].into_iter().fold(0, u64::max)
    }

    /// The maximum of both, part by part.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.zip(other, u64::max)
    }

    /// Combines each size with that of the other.
    #[must_use]
    pub fn zip(&self, other: &Self, combine: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            input: combine(self.input, other.input),
            field: combine(self.field, other.field),
            table: combine(self.table, other.table),
            records: combine(self.records, other.records),
            partials: combine(self.partials, other.partials),
            answers: combine(self.answers, other.answers),
        }
    }
}

/// Words of a field on the device: two cells per word.
pub(super) fn field_words(field: &ClearanceField) -> u64 {
    (field.units().len() as u64).div_ceil(2)
}

/// A pipeline and the number of its workgroups.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Dispatch {
    /// The pipeline.
    pub pipeline: Pipeline,
    /// Number of workgroups.
    pub workgroups: u32,
}

/// Workgroups of the turn profiles of a problem, where each takes rows a number of times.
fn profile_groups_of(problem: &QuantizedProblem, rounds: u32) -> u32 {
    (problem.profiles.len() as u32).div_ceil(rounds * profiles_at_once(problem.header.steps))
}

/// Problems that are evaluated in one submission, by the engine or by a browser.
pub struct Batch<'a> {
    /// The problems.
    pub problems: &'a [QuantizedProblem],
    /// Their fields, each once.
    pub fields: Vec<&'a ClearanceField>,
    amount: Amount,
}

impl<'a> Batch<'a> {
    /// The longest prefix of `problems` that fits one submission; at least one problem if there is any.
    #[must_use]
    pub fn first_of(problems: &'a [QuantizedProblem]) -> Self {
        let mut batch =
            Self { problems: &problems[..0], fields: Vec::new(), amount: Amount::default() };
        for (count, problem) in (1..=MAX_PROBLEMS).zip(problems) {
            let field = problem.field.as_ref();
            let is_new = batch.fields.iter().all(|held| held.id() != field.id());
            let mut amount = batch.amount;
            amount.add(problem);
            if is_new {
                amount.field_words += field_words(field);
            }
            let is_too_much = amount.samples > MAX_SAMPLES || amount.sizes().largest() > MAX_BYTES;
            if count > 1 && is_too_much {
                break;
            }
            if is_new {
                batch.fields.push(field);
            }
            batch.amount = amount;
            batch.problems = &problems[..count];
        }
        batch
    }

    /// Divides the problems into as few submissions as they need, in order.
    #[must_use]
    pub fn split(problems: &'a [QuantizedProblem]) -> Vec<Self> {
        let mut batches = Vec::new();
        let mut rest = problems;
        while !rest.is_empty() {
            let batch = Self::first_of(rest);
            rest = &rest[batch.problems.len()..];
            batches.push(batch);
        }
        batches
    }

    /// Sizes that the buffers must have.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        self.amount.sizes()
    }

    /// Number of times that a workgroup takes turn profiles: once, unless there are too many.
    pub(super) fn tabulation_rounds(&self) -> u32 {
        let most = u64::from(MAX_WORKGROUPS) - MAX_PROBLEMS as u64;
        let rounds = self.amount.profile_groups.div_ceil(most) as u32;
        rounds.clamp(1, MAX_TABULATION_ROUNDS)
    }

    /// The dispatches of the submission, in order.
    #[must_use]
    pub fn dispatches(&self) -> Vec<Dispatch> {
        let rounds = self.tabulation_rounds();
        let groups = self.problems.iter().map(|problem| profile_groups_of(problem, rounds));
        let (profile_groups, sample_groups) = (groups.sum(), self.amount.sample_groups as u32);
        let is_simple =
            |problem: &QuantizedProblem| problem.discs.len() == 1 && problem.obstacles.is_empty();
        let evaluate = if self.problems.iter().all(is_simple) {
            Pipeline::EvaluateOneStaticDisc
        } else {
            Pipeline::EvaluateSamples
        };
        let problems = self.problems.len() as u32;
        let mut dispatches =
            vec![(Pipeline::TabulateProfiles, profile_groups), (evaluate, sample_groups)];
        if self.problems.iter().all(|problem| problem.len() <= MAX_DECIDED_AT_ONCE) {
            dispatches.push((Pipeline::Decide, problems));
        } else {
            dispatches.extend([
                (Pipeline::Normalize, problems),
                (Pipeline::ScoreSamples, sample_groups),
                (Pipeline::SelectWinner, problems),
            ]);
        }
        let dispatch = |(pipeline, workgroups)| Dispatch { pipeline, workgroups };
        dispatches.into_iter().map(dispatch).collect()
    }

    /// Length of the inputs of the shaders without the fields, bytes; at most [`Sizes::input`].
    #[must_use]
    pub fn input_bytes(&self) -> u64 {
        let [.., end] = self.amount.input_offsets();
        end
    }

    /// Passes each piece of the inputs, without the fields, and its position in bytes to `put`. `first_field` returns the word
    /// at which a field begins. The answers have consecutive stamps from `first_stamp`.
    pub fn write(
        &self,
        mut put_at: impl FnMut(usize, &[u8]),
        first_stamp: u32,
        first_field: impl Fn(&ClearanceField) -> u32,
    ) {
        let [speeds_at, profiles_at, lists_at, _] = self.amount.input_offsets();
        let mut writer =
            [0, BATCH_HEAD_BYTES as u64, speeds_at, profiles_at, lists_at].map(|at| at as usize);
        let mut put = |part: usize, bytes: &[u8]| {
            let at = &mut writer[part];
            put_at(*at, bytes);
            *at += bytes.len();
        };
        let rounds = self.tabulation_rounds();
        put(0, bytemuck::bytes_of(&[self.problems.len() as u32, rounds]));
        let mut before = Amount::default();
        let mut profile_groups = 0;
        for (stamp, problem) in (0..).zip(self.problems) {
            let mut header = problem.header;
            header.stamp = first_stamp.wrapping_add(stamp);
            let offsets = BufferOffsets {
                first_groups: [profile_groups, before.sample_groups as u32],
                first_vx: (speeds_at / size_of::<VxSample>() as u64 + before.vx_samples) as u32,
                first_profile: (profiles_at / size_of::<TurnProfile>() as u64 + before.profiles)
                    as u32,
                first_list: (lists_at / 4 + before.list_words) as u32,
                first_field: first_field(&problem.field),
                first_table: before.table_words as u32,
                first_record: before.samples as u32,
            };
            put(1, bytemuck::bytes_of(&BatchEntry { header, offsets }));
            put(2, bytemuck::cast_slice::<VxSample, u8>(&problem.vx_samples));
            put(3, bytemuck::cast_slice::<TurnProfile, u8>(&problem.profiles));
            put(4, bytemuck::cast_slice::<QuantizedDisc, u8>(&problem.discs));
            put(4, bytemuck::cast_slice::<QuantizedObstacle, u8>(&problem.obstacles));
            put(4, bytemuck::cast_slice::<ProfileSegment, u8>(&problem.segments));
            before.add(problem);
            profile_groups += profile_groups_of(problem, rounds);
        }
    }

    /// Decodes the evaluations from the bytes of all answers and, with [`Detail::Samples`], of all records after them.
    /// `None` when an answer has the wrong stamp: it is stale.
    #[must_use]
    pub fn read(&self, bytes: &[u8], first_stamp: u32, detail: Detail) -> Option<Vec<Evaluation>> {
        let (answers, mut records) = bytes.split_at(self.problems.len() * size_of::<Answer>());
        let answers = answers.chunks_exact(size_of::<Answer>());
        let stamped = (0..).zip(self.problems.iter().zip(answers));
        let evaluations = stamped.map(|(offset, (problem, answer))| {
            let answer: Answer = bytemuck::pod_read_unaligned(answer);
            let samples = (detail == Detail::Samples).then(|| {
                let (own, others) = records.split_at(problem.len() * size_of::<Record>());
                records = others;
                sample_records(problem, own)
            });
            let is_fresh = answer.stamp == first_stamp.wrapping_add(offset);
            is_fresh.then(|| answer.evaluation(samples))
        });
        evaluations.collect()
    }
}
