//! What a page is asked to run: shaders, bindings, dispatches, and what to send back. The page knows nothing more.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use inbye::local::Detail;
use inbye::local::internals::gpu::Batch;
use inbye::local::internals::gpu::{ACCESS, ANSWERS, Access, FIELD, RECORDS};
use libtest_mimic::Failed;
use serde::Serialize;

use super::super::kernel;
use super::super::operations::{Arguments, Operation, Outcome};

/// All of it, as `page.js` reads it.
#[derive(Serialize)]
pub struct Plan<'a> {
    wgsl: &'a str,
    bindings: Vec<Binding>,
    dispatches: Vec<Dispatch>,
    /// Numbers of the bindings to send back whole, in this order.
    read: Vec<usize>,
}

#[derive(Serialize)]
struct Binding {
    number: usize,
    /// In WebGPU's own words.
    r#type: &'static str,
    bytes: u64,
    /// What the buffer holds at first, in base64; zeros follow.
    contents: String,
}

#[derive(Serialize)]
struct Dispatch {
    entry_point: String,
    constants: BTreeMap<&'static str, f64>,
    workgroups: u32,
}

impl Binding {
    /// The contents are whole words, as WebGPU copies them.
    fn new(number: usize, access: Access, bytes: u64, contents: &[u8]) -> Self {
        Self {
            number,
            r#type: match access {
                Access::Uniform => "uniform",
                Access::Read => "read-only-storage",
                Access::ReadWrite => "storage",
            },
            bytes,
            contents: BASE64_STANDARD.encode(contents),
        }
    }
}

impl<'a> Plan<'a> {
    /// The engine's dispatches for a batch; with `Detail::Samples` the records follow the answers.
    pub fn evaluation(wgsl: &'a str, batch: &Batch<'_>, first_stamp: u32, detail: Detail) -> Self {
        let sizes = batch.sizes();
        let mut input = vec![0; sizes.input as usize];
        let mut field = Vec::new();
        let first_words: Vec<(u64, usize)> = batch
            .fields
            .iter()
            .map(|one| {
                let first_word = field.len() / 4;
                field.extend_from_slice(bytemuck::cast_slice(one.units()));
                field.resize(field.len().next_multiple_of(4), 0);
                (one.id(), first_word)
            })
            .collect();
        let put = |at: usize, bytes: &[u8]| input[at..at + bytes.len()].copy_from_slice(bytes);
        batch.write(put, first_stamp, |field| {
            let found = first_words.iter().find(|(id, _)| *id == field.id());
            found.expect("a field of the batch").1 as u32
        });
        let bindings = ACCESS.iter().zip(sizes.bindings()).enumerate();
        let bindings = bindings.map(|(number, (&access, bytes))| {
            let contents: &[u8] = match number {
                // Views of one buffer for the engine, copies of it here.
                ..FIELD => &input[..bytes as usize],
                FIELD => &field,
                _ => &[],
            };
            Binding::new(number, access, bytes, contents)
        });
        let dispatches = batch.dispatches();
        let dispatches = dispatches.iter().map(|dispatch| Dispatch {
            entry_point: dispatch.pipeline.entry_point().to_owned(),
            constants: dispatch.pipeline.constants().iter().copied().collect(),
            workgroups: dispatch.workgroups,
        });
        Self {
            wgsl,
            bindings: bindings.collect(),
            dispatches: dispatches.collect(),
            read: match detail {
                Detail::Answer => vec![ANSWERS],
                Detail::Samples => vec![ANSWERS, RECORDS],
            },
        }
    }

    /// One operation of the kernel over all cases.
    pub fn operation(
        wgsl: &'a str,
        operation: &Operation,
        cases: &[Arguments],
    ) -> Result<Self, Failed> {
        let input = bytemuck::cast_slice(cases);
        let (input_bytes, output_bytes) = (size_of_val(cases), size_of::<Outcome>() * cases.len());
        let [input_at, output_at] = kernel::BINDINGS.map(|binding| binding as usize);
        Ok(Self {
            wgsl,
            bindings: vec![
                Binding::new(input_at, Access::Read, input_bytes as u64, input),
                Binding::new(output_at, Access::ReadWrite, output_bytes as u64, &[]),
            ],
            dispatches: vec![Dispatch {
                entry_point: kernel::entry_point(operation)?,
                constants: BTreeMap::new(),
                workgroups: kernel::workgroups(cases),
            }],
            read: vec![output_at],
        })
    }

    /// Bytes that come back.
    pub fn bytes_read(&self) -> u64 {
        let read = self.bindings.iter();
        read.filter(|binding| self.read.contains(&binding.number))
            .map(|binding| binding.bytes)
            .sum()
    }
}
