//! A small kernel that runs one shared operation at a time on an adapter.

use inbye::local::{Adapter, internals::gpu as shaders};
use libtest_mimic::Failed;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::operations::{Arguments, OPERATIONS, Operation, Outcome, cases, differences};

/// Numbers of the bindings: cases and results.
pub const BINDINGS: [u32; 2] = [20, 21];

/// The parts of the shaders without entry points, and an entry point per operation.
pub fn source() -> String {
    let parts = shaders::PARTS.iter().filter(|(_, text)| !text.contains("@compute"));
    let mut source: Vec<String> = parts.map(|(_, text)| (*text).to_owned()).collect();
    source.push(
        "
@group(0) @binding(20) var<storage, read> cases: array<array<u32, 6>>;
@group(0) @binding(21) var<storage, read_write> outcomes: array<vec4<u32>>;
fn one(word: u32) -> vec4<u32> { return vec4<u32>(word, 0u, 0u, 0u); }
fn int(word: i32) -> vec4<u32> { return one(bitcast<u32>(word)); }
fn two(wide: vec2<u32>) -> vec4<u32> { return vec4<u32>(wide, 0u, 0u); }
fn of_normalizer(by: Normalizer) -> vec4<u32> { return vec4<u32>(by.offset, by.mantissa, bitcast<u32>(by.bits), 0u); }
fn of_candidate(best: Candidate) -> vec4<u32> { return vec4<u32>(best.score, best.index, 0u); }
"
        .to_owned(),
    );
    for (number, operation) in OPERATIONS.iter().enumerate() {
        let expression = operation.wgsl;
        source.push(format!(
            "@compute @workgroup_size(64)
fn operation_{number}(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x < arrayLength(&cases) {{
        let a = cases[id.x];
        outcomes[id.x] = {expression};
    }}
}}"
        ));
    }
    source.join("\n")
}

/// The entry point of an operation.
pub fn entry_point(operation: &Operation) -> Result<String, Failed> {
    let number = OPERATIONS.iter().position(|one| one.name == operation.name);
    let number = number.ok_or("not an operation of the kernel")?;
    Ok(format!("operation_{number}"))
}

/// Workgroups for all cases.
pub fn workgroups(cases: &[Arguments]) -> u32 {
    (cases.len() as u32).div_ceil(64)
}

/// Describes the differences of every operation, computed by `run`.
pub fn every_difference(
    mut run: impl FnMut(&Operation, &[Arguments]) -> Result<Vec<Outcome>, Failed>,
) -> Result<Vec<String>, Failed> {
    let rng = &mut Pcg64Mcg::seed_from_u64(41);
    let mut all = Vec::new();
    for operation in &OPERATIONS {
        let cases = cases(operation, rng);
        let found = run(operation, &cases)?;
        all.extend(differences(operation, &cases, &found));
    }
    Ok(all)
}

/// The kernel on its own device.
pub struct Kernel {
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
}

impl Kernel {
    /// The kernel on the adapter with the same name and driver.
    pub fn new(adapter: &Adapter) -> Result<Self, Failed> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(descriptor);
        let all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        let wanted = &adapter.summary;
        let same = |one: &wgpu::Adapter| {
            let info = one.get_info();
            info.name == wanted.name && info.backend.to_str() == wanted.backend
        };
        let one = all.into_iter().find(same).ok_or("the adapter is gone")?;
        let (device, queue) =
            pollster::block_on(one.request_device(&wgpu::DeviceDescriptor::default()))?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("operations"),
            source: wgpu::ShaderSource::Wgsl(source().into()),
        });
        Ok(Self { device, queue, module })
    }

    /// Runs one operation over all cases.
    pub fn run(&self, operation: &Operation, cases: &[Arguments]) -> Result<Vec<Outcome>, Failed> {
        use wgpu::BufferUsages as Usage;
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(operation.name),
            layout: None,
            module: &self.module,
            entry_point: Some(&entry_point(operation)?),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let make = |size, usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let outcome_bytes = size_of::<Outcome>() as u64 * cases.len() as u64;
        let input = make(size_of_val(cases) as u64, Usage::STORAGE | Usage::COPY_DST);
        let output = make(outcome_bytes, Usage::STORAGE | Usage::COPY_SRC);
        let readback = make(outcome_bytes, Usage::MAP_READ | Usage::COPY_DST);
        self.queue.write_buffer(&input, 0, bytemuck::cast_slice(cases));
        let [input_at, output_at] = BINDINGS;
        let entries = [(input_at, &input), (output_at, &output)].map(|(binding, buffer)| {
            wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
        });
        let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(workgroups(cases), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &readback, 0, outcome_bytes);
        self.queue.submit([encoder.finish()]);
        readback.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let view = readback.slice(..).get_mapped_range()?;
        Ok(bytemuck::cast_slice(&view).to_vec())
    }
}
