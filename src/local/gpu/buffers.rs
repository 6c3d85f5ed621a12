//! The device's memory for a batch: allocated once, enlarged for a larger batch.

use super::batch::{Batch, MAX_BYTES, Sizes, field_words};
use super::layout::{ACCESS, Access};
use crate::local::ClearanceField;
use crate::local::engine::Detail;

/// Smallest size of a buffer: most problems of a driving robot fit into the first buffers.
const MIN_BYTES: u64 = 1 << 20;

/// The buffers and their bind group.
pub(super) struct Buffers {
    pub sizes: Sizes,
    input: wgpu::Buffer,
    field: wgpu::Buffer,
    fields: ResidentFields,
    records: wgpu::Buffer,
    answers: wgpu::Buffer,
    pub bind_group: wgpu::BindGroup,
    /// Those that no submission uses. A second one exists after the first call with several submissions.
    pub transfers: Vec<Transfer>,
}

/// The memory through which a submission exchanges data with the host.
pub(super) struct Transfer {
    /// The inputs on their way to the device; mapped for the host between submissions.
    pub upload: wgpu::Buffer,
    pub readback: wgpu::Buffer,
}

impl Transfer {
    pub fn new(device: &wgpu::Device, sizes: &Sizes) -> Self {
        use wgpu::BufferUsages as Usage;
        let make = |label, size, usage, mapped_at_creation| {
            let label = Some(label);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let upload_usage = Usage::MAP_WRITE | Usage::COPY_SRC;
        let readback_usage = Usage::MAP_READ | Usage::COPY_DST;
        Self {
            upload: make("upload", sizes.input, upload_usage, true),
            readback: make("readback", sizes.readback(), readback_usage, false),
        }
    }

    /// Copies the inputs that were written to the buffer of the shaders.
    pub fn copy_in(&self, encoder: &mut wgpu::CommandEncoder, buffers: &Buffers, bytes: u64) {
        encoder.copy_buffer_to_buffer(&self.upload, 0, &buffers.input, 0, bytes);
    }

    /// Copies the answers, and the records if requested, to the readback buffer. Returns the number of bytes.
    pub fn copy_out(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        sizes: &Sizes,
        detail: Detail,
    ) -> u64 {
        encoder.copy_buffer_to_buffer(&buffers.answers, 0, &self.readback, 0, sizes.answers);
        match detail {
            Detail::Answer => sizes.answers,
            Detail::Samples => {
                let (after, bytes) = (sizes.answers, sizes.records);
                encoder.copy_buffer_to_buffer(&buffers.records, 0, &self.readback, after, bytes);
                sizes.readback()
            }
        }
    }
}

impl Buffers {
    /// Allocates buffers of at least these sizes; rounds up, so that similar problems share them.
    pub fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, least: &Sizes) -> Self {
        use wgpu::BufferUsages as Usage;
        let sizes = least.zip(least, |bytes, _| {
            let rounded = bytes.max(MIN_BYTES).next_power_of_two();
            rounded.min(MAX_BYTES).max(bytes)
        });
        let make = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let input_usage = Usage::UNIFORM | Usage::STORAGE | Usage::COPY_DST;
        let input = make("input", sizes.input, input_usage);
        let field = make("field", sizes.field, Usage::STORAGE | Usage::COPY_DST);
        let table = make("table", sizes.table, Usage::STORAGE);
        let records = make("records", sizes.records, Usage::STORAGE | Usage::COPY_SRC);
        let partials = make("partials", sizes.partials, Usage::STORAGE);
        let answers = make("answers", sizes.answers, Usage::STORAGE | Usage::COPY_SRC);
        let buffers =
            [&input, &input, &input, &input, &field, &table, &records, &partials, &answers];
        let resources = buffers.into_iter().zip(sizes.bindings());
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(resources)
            .map(|(binding, (buffer, bytes))| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(bytes),
                }),
            })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("inbye"),
            layout,
            entries: &entries,
        });
        Self {
            sizes,
            input,
            field,
            fields: ResidentFields::default(),
            records,
            answers,
            bind_group,
            transfers: Vec::with_capacity(2),
        }
    }

    /// Writes a batch to memory that the device can read: the inputs, and the fields that the device does not hold yet.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn write(
        &mut self,
        queue: &wgpu::Queue,
        transfer: &Transfer,
        batch: &Batch<'_>,
        first_stamp: u32,
    ) -> Result<(), wgpu::MapRangeError> {
        let buffer = &self.field;
        self.fields.hold(&batch.fields, self.sizes.field, |at, field| {
            write_field(queue, buffer, at, field);
        });
        let first_field = |field: &ClearanceField| {
            let held = self.fields.find(field);
            held.expect("the fields of a batch are held by now")
        };
        {
            let mut view = transfer.upload.get_mapped_range_mut(..batch.input_bytes())?;
            let mut memory = view.slice(..);
            let put = |at: usize, bytes: &[u8]| {
                memory.slice(at..at + bytes.len()).copy_from_slice(bytes);
            };
            batch.write(put, first_stamp, first_field);
        }
        transfer.upload.unmap();
        Ok(())
    }
}

fn write_field(queue: &wgpu::Queue, buffer: &wgpu::Buffer, at: u32, field: &ClearanceField) {
    let first = u64::from(at) * 4;
    let units = field.units();
    let (pairs, last) = units.split_at(units.len() / 2 * 2);
    queue.write_buffer(buffer, first, bytemuck::cast_slice(pairs));
    if let [last] = last {
        // Copies are whole words; the shaders do not read the upper half of the last one.
        let word = u32::from(*last).to_le_bytes();
        queue.write_buffer(buffer, first + pairs.len() as u64 * 2, &word);
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
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("inbye"),
        entries: &entries,
    })
}

/// Positions of the fields in their buffer.
#[derive(Default)]
struct ResidentFields {
    /// Id and first word of each field.
    held: Vec<(u64, u32)>,
    used_words: u64,
}

impl ResidentFields {
    /// Makes the device hold these fields, which fit into `capacity` bytes: calls `write` with the first word of each
    /// field that it does not hold yet. Earlier fields stay if there is room for them.
    pub fn hold(
        &mut self,
        fields: &[&ClearanceField],
        capacity: u64,
        mut write: impl FnMut(u32, &ClearanceField),
    ) {
        let missing = fields.iter().filter(|field| self.find(field).is_none());
        let missing_words: u64 = missing.map(|field| field_words(field)).sum();
        if (self.used_words + missing_words) * 4 > capacity {
            self.held.clear();
            self.used_words = 0;
        }
        for field in fields {
            if self.find(field).is_none() {
                let at = self.used_words as u32;
                write(at, field);
                self.held.push((field.id(), at));
                self.used_words += field_words(field);
            }
        }
    }

    /// The first word of a field that the device holds.
    pub fn find(&self, field: &ClearanceField) -> Option<u32> {
        let held = self.held.iter().find(|(id, _)| *id == field.id());
        held.map(|(_, at)| *at)
    }
}
