//! The device's memory for one problem: made once, grown when a larger problem comes, written in one piece.

use super::bindings::{ACCESS, Access, BINDINGS, contents};
use super::layout::{Answer, PARTIAL_BYTES, Record, SAMPLES_PER_GROUP};
use crate::local::contract::Detail;
use crate::local::inputs::Header;
use crate::local::{Prepared, rollout};

/// Offsets of bindings within a buffer are multiples of this (WebGPU's default limit).
const ALIGNMENT: u64 = 256;

/// Bytes of each part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sizes {
    speeds: u64,
    turns: u64,
    bodies: u64,
    field: u64,
    table: u64,
    samples: u64,
}

impl Sizes {
    /// What a problem needs.
    pub fn of(problem: &Prepared) -> Self {
        let words = rollout::table_words(&problem.header) * problem.turns.len();
        let bodies =
            size_of_val(problem.discs.as_slice()) + size_of_val(problem.obstacles.as_slice());
        Self {
            speeds: size_of_val(problem.speeds.as_slice()) as u64,
            turns: size_of_val(problem.turns.as_slice()) as u64,
            bodies: bodies as u64,
            field: (problem.field.units().len() as u64 * 2).next_multiple_of(4),
            table: words as u64 * 4,
            samples: problem.len() as u64,
        }
    }

    /// Whether buffers of this size hold a problem of that.
    pub fn hold(&self, other: &Self) -> bool {
        *self == self.union(other)
    }

    /// What holds both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            speeds: self.speeds.max(other.speeds),
            turns: self.turns.max(other.turns),
            bodies: self.bodies.max(other.bodies),
            field: self.field.max(other.field),
            table: self.table.max(other.table),
            samples: self.samples.max(other.samples),
        }
    }

    /// Bytes of the largest binding.
    pub fn largest(&self) -> u64 {
        self.records().max(self.table).max(self.field)
    }

    /// Bytes of each binding.
    pub fn bindings(&self) -> [u64; BINDINGS] {
        let bytes = [
            size_of::<Header>() as u64,
            self.speeds,
            self.turns,
            self.bodies,
            self.field,
            self.table,
            self.records(),
            self.partials(),
            size_of::<Answer>() as u64,
        ];
        bytes.map(|bytes| bytes.max(16))
    }

    fn records(&self) -> u64 {
        self.samples * size_of::<Record>() as u64
    }

    fn partials(&self) -> u64 {
        self.samples.div_ceil(u64::from(SAMPLES_PER_GROUP)) * PARTIAL_BYTES
    }

    /// Where speeds, turns and bodies begin in the input buffer, and its whole size.
    fn input_offsets(&self) -> [u64; 4] {
        let after = |offset: u64, bytes: u64| (offset + bytes).next_multiple_of(ALIGNMENT);
        let speeds = after(0, size_of::<Header>() as u64);
        let turns = after(speeds, self.speeds);
        let bodies = after(turns, self.turns);
        [speeds, turns, bodies, after(bodies, self.bodies)]
    }
}

/// Buffers and the bind group over them.
pub(super) struct Buffers {
    sizes: Sizes,
    input: wgpu::Buffer,
    staging: Vec<u8>,
    field: wgpu::Buffer,
    /// The field that the device holds.
    field_id: u64,
    records: wgpu::Buffer,
    answer: wgpu::Buffer,
    readback: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl Buffers {
    pub fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, sizes: Sizes) -> Self {
        use wgpu::BufferUsages as Usage;
        let make = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let [
            header,
            speeds,
            turns,
            bodies,
            field,
            table,
            records,
            partials,
            answer,
        ] = sizes.bindings();
        let [speeds_at, turns_at, bodies_at, input_bytes] = sizes.input_offsets();
        let readback_bytes = answer + records;
        let input_usage = Usage::UNIFORM | Usage::STORAGE | Usage::COPY_DST;
        let input = make("input", input_bytes, input_usage);
        let field = make("field", field, Usage::STORAGE | Usage::COPY_DST);
        let table = make("table", table, Usage::STORAGE);
        let records = make("records", records, Usage::STORAGE | Usage::COPY_SRC);
        let partials = make("partials", partials, Usage::STORAGE);
        let answer = make("answer", answer, Usage::STORAGE | Usage::COPY_SRC);
        let readback = make(
            "readback",
            readback_bytes,
            Usage::MAP_READ | Usage::COPY_DST,
        );
        let part = |offset, bytes| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &input,
                offset,
                size: wgpu::BufferSize::new(bytes),
            })
        };
        let resources = [
            part(0, header),
            part(speeds_at, speeds),
            part(turns_at, turns),
            part(bodies_at, bodies),
            field.as_entire_binding(),
            table.as_entire_binding(),
            records.as_entire_binding(),
            partials.as_entire_binding(),
            answer.as_entire_binding(),
        ];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("inbye"),
            layout,
            entries: &entries,
        });
        Self {
            sizes,
            staging: vec![0; input_bytes as usize],
            input,
            field,
            field_id: 0,
            records,
            answer,
            readback,
            bind_group,
        }
    }

    pub const fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    pub const fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    pub const fn readback(&self) -> &wgpu::Buffer {
        &self.readback
    }

    /// Writes a problem: the inputs in one piece, the field only when the device holds another.
    pub fn upload(&mut self, queue: &wgpu::Queue, problem: &Prepared, stamp: u32) {
        let header = Header {
            stamp,
            ..problem.header
        };
        let [inputs @ .., field] = contents(&header, problem);
        let [speeds_at, turns_at, bodies_at, _] = self.sizes.input_offsets();
        for (pieces, at) in inputs.iter().zip([0, speeds_at, turns_at, bodies_at]) {
            let mut at = at as usize;
            for piece in pieces {
                self.staging[at..at + piece.len()].copy_from_slice(piece);
                at += piece.len();
            }
        }
        queue.write_buffer(&self.input, 0, &self.staging);
        if self.field_id != problem.field.id() {
            self.field_id = problem.field.id();
            let [units, _] = field;
            let (words, last) = units.split_at(units.len() / 4 * 4);
            queue.write_buffer(&self.field, 0, words);
            if let [low, high] = *last {
                // Copies are whole words; the upper half of the last is read by nobody.
                queue.write_buffer(&self.field, words.len() as u64, &[low, high, 0, 0]);
            }
        }
    }

    /// Bytes that come back.
    pub fn readback_bytes(samples: usize, detail: Detail) -> u64 {
        let records = match detail {
            Detail::Answer => 0,
            Detail::Samples => samples * size_of::<Record>(),
        };
        (size_of::<Answer>() + records) as u64
    }

    /// Copies the answer, and the samples where asked for, to where the host can read them.
    pub fn copy_out(&self, encoder: &mut wgpu::CommandEncoder, samples: usize, detail: Detail) {
        let answer_bytes = size_of::<Answer>() as u64;
        encoder.copy_buffer_to_buffer(&self.answer, 0, &self.readback, 0, answer_bytes);
        let records = Self::readback_bytes(samples, detail) - answer_bytes;
        if records > 0 {
            encoder.copy_buffer_to_buffer(&self.records, 0, &self.readback, answer_bytes, records);
        }
    }
}

/// The bindings of `shaders/layout.wgsl`.
pub(super) fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
    let kinds = ACCESS.map(|access| match access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => storage(true),
        Access::ReadWrite => storage(false),
    });
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(kinds)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("inbye"),
        entries: &entries,
    })
}
