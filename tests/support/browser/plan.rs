//! What a page is asked to run: shaders, bindings, dispatches, and what to send back. The page knows nothing more.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use inbye::local::gpu::bindings::{ACCESS, ANSWER, Access, RECORDS, contents, sizes, workgroups};
use inbye::local::gpu::shaders::ENTRY_POINTS;
use inbye::local::{Detail, Header, Prepared};
use libtest_mimic::Failed;
use serde::Serialize;

use crate::kernel;
use crate::operations::{Arguments, Operation, Outcome};

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
    workgroups: u32,
}

impl Binding {
    fn new(number: usize, access: Access, bytes: u64, pieces: &[&[u8]]) -> Self {
        let mut contents = pieces.concat();
        // Copies are whole words.
        contents.resize(contents.len().next_multiple_of(4), 0);
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
    /// The engine's dispatches for a problem; with `Detail::Samples` the records follow the answer.
    pub fn evaluation(wgsl: &'a str, header: &Header, problem: &Prepared, detail: Detail) -> Self {
        let contents = contents(header, problem);
        let bindings = ACCESS.iter().zip(sizes(problem)).enumerate();
        let bindings = bindings.map(|(number, (&access, bytes))| {
            let pieces = contents.get(number).map_or(&[][..], |pieces| &pieces[..]);
            Binding::new(number, access, bytes, pieces)
        });
        let dispatches = ENTRY_POINTS.into_iter().zip(workgroups(problem));
        let dispatches = dispatches.map(|(entry_point, workgroups)| Dispatch {
            entry_point: entry_point.to_owned(),
            workgroups,
        });
        Self {
            wgsl,
            bindings: bindings.collect(),
            dispatches: dispatches.collect(),
            read: match detail {
                Detail::Answer => vec![ANSWER],
                Detail::Samples => vec![ANSWER, RECORDS],
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
                Binding::new(input_at, Access::Read, input_bytes as u64, &[input]),
                Binding::new(output_at, Access::ReadWrite, output_bytes as u64, &[]),
            ],
            dispatches: vec![Dispatch {
                entry_point: kernel::entry_point(operation)?,
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
