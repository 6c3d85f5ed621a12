//! What a problem asks of a device, whoever drives it: what is bound where, and how many workgroups run. The engine
//! drives it through wgpu; a test drives the same shaders in a browser.

use bytemuck::{bytes_of, cast_slice};

use super::buffers::Sizes;
use super::layout::{SAMPLES_PER_GROUP, TURNS_PER_GROUP};
use crate::local::Prepared;
use crate::local::inputs::Header;

/// Number of bindings.
pub const BINDINGS: usize = 9;
/// Number of the binding that holds a [`super::layout::Record`] for each sample.
pub const RECORDS: usize = 6;
/// Number of the binding that holds the [`super::layout::Answer`].
pub const ANSWER: usize = 8;

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

/// Bytes of each binding, by its number.
#[must_use]
pub fn sizes(problem: &Prepared) -> [u64; BINDINGS] {
    Sizes::of(problem).bindings()
}

/// What the bindings hold that are never written, the first five: each in two pieces, one after the other.
#[must_use]
pub fn contents<'a>(header: &'a Header, problem: &'a Prepared) -> [[&'a [u8]; 2]; 5] {
    [
        [bytes_of(header), &[]],
        [cast_slice(&problem.speeds), &[]],
        [cast_slice(&problem.turns), &[]],
        [cast_slice(&problem.discs), cast_slice(&problem.obstacles)],
        [cast_slice(problem.field.units()), &[]],
    ]
}

/// Workgroups of each dispatch, in the order of [`super::shaders::ENTRY_POINTS`].
#[must_use]
pub fn workgroups(problem: &Prepared) -> [u32; 5] {
    let samples = (problem.len() as u32).div_ceil(SAMPLES_PER_GROUP);
    let turns = problem.header.omega_count.div_ceil(TURNS_PER_GROUP);
    [turns, samples, 1, samples, 1]
}
