//! The GPU engine: transport only. One upload, one submission of five dispatches, one small answer back.

pub mod bindings;
mod buffers;
mod device;
pub mod layout;
pub mod shaders;

use std::sync::mpsc;
use std::time::Duration;

use buffers::{Buffers, Sizes};
use device::Device;
use layout::{Answer, sample_records};

pub use device::{Adapter, AdapterSummary, adapters};

use super::contract::{Detail, Engine, Evaluation};
use super::{EngineError, Prepared};

/// A decision that takes longer than this has hung.
const DEADLINE: Duration = Duration::from_secs(20);

/// Evaluates on a graphics adapter.
pub struct GpuEngine {
    device: Device,
    pipelines: [wgpu::ComputePipeline; 5],
    layout: wgpu::BindGroupLayout,
    /// Those of the last answer.
    buffers: Option<Buffers>,
    stamp: u32,
}

impl GpuEngine {
    /// An engine on an adapter, with its pipelines made.
    ///
    /// # Errors
    /// When the adapter gives no device or refuses a pipeline.
    pub fn new(adapter: &Adapter) -> Result<Self, EngineError> {
        let device = adapter.open()?;
        let layout = buffers::bind_group_layout(&device.inner);
        let pipelines = make_pipelines(&device, &layout)?;
        Ok(Self {
            device,
            pipelines,
            layout,
            buffers: None,
            stamp: 0,
        })
    }

    /// Drops the device as a driver reset would, for tests of what follows.
    pub fn destroy_device(&self) {
        self.device.inner.destroy();
    }

    /// Takes out buffers that hold this problem: those of the last one when they are large enough.
    fn take_buffers(&mut self, problem: &Prepared) -> Result<Buffers, EngineError> {
        let sizes = Sizes::of(problem);
        let grown = match self.buffers.take() {
            Some(buffers) if buffers.sizes().hold(&sizes) => return Ok(buffers),
            Some(buffers) => buffers.sizes().union(&sizes),
            None => sizes,
        };
        let limit = self.device.inner.limits().max_storage_buffer_binding_size;
        if sizes.largest() > limit {
            return Err(EngineError::Setup {
                adapter: self.device.adapter.clone(),
                what: format!(
                    "{} samples of {} steps need a buffer of {} bytes, the adapter allows {limit}: sample less densely",
                    problem.len(),
                    problem.header.steps,
                    sizes.largest(),
                ),
            });
        }
        Ok(Buffers::new(&self.device.inner, &self.layout, grown))
    }

    /// Refuses a problem that the adapter's driver would leave unfinished.
    fn check_loops(&self, problem: &Prepared) -> Result<(), EngineError> {
        let header = &problem.header;
        let (steps, discs) = (u64::from(header.steps), u64::from(header.disc_count));
        let moving = u64::from(header.obstacle_count);
        // A turn for each step, disc and obstacle, and up to three more for the square root of a distance.
        let needed = steps * (1 + discs * (1 + 4 * moving));
        match self.device.loop_turns {
            Some(most) if needed > most => Err(EngineError::Setup {
                adapter: self.device.adapter.clone(),
                what: format!(
                    "{steps} steps of {discs} discs among {moving} moving obstacles take up to {needed} turns of loops, the driver allows {most}: use --engine cpu"
                ),
            }),
            _ => Ok(()),
        }
    }

    fn submit(
        &self,
        buffers: &Buffers,
        problem: &Prepared,
        detail: Detail,
    ) -> wgpu::SubmissionIndex {
        let mut encoder = self
            .device
            .inner
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, buffers.bind_group(), &[]);
            for (pipeline, groups) in self.pipelines.iter().zip(bindings::workgroups(problem)) {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
        buffers.copy_out(&mut encoder, problem.len(), detail);
        self.device.queue.submit([encoder.finish()])
    }

    /// Waits for the submission and hands the bytes of the answer, and of the samples where asked for, to `read`.
    fn read_back<T>(
        &self,
        buffers: &Buffers,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, EngineError> {
        let (sender, receiver) = mpsc::channel();
        let slice = buffers.readback().slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, move |outcome| {
            // The receiver is gone only when the wait below gave up.
            let _ = sender.send(outcome);
        });
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: Some(DEADLINE),
        };
        self.device
            .inner
            .poll(wait)
            // A complaint of the device says more than that there is nothing to wait for.
            .map_err(|error| match self.device.check() {
                Err(complaint) => complaint,
                Ok(()) => self.device.lost(error.to_string()),
            })?;
        self.device.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.device.lost(error.to_string())),
            Err(_) => return Err(self.device.lost("the answer could not be mapped in time")),
        }
        let result = {
            let view = slice
                .get_mapped_range()
                .map_err(|error| self.device.lost(error.to_string()))?;
            read(&view)
        };
        buffers.readback().unmap();
        Ok(result)
    }
}

impl Engine for GpuEngine {
    fn name(&self) -> String {
        self.device.adapter.clone()
    }

    fn kind(&self) -> &'static str {
        "gpu"
    }

    fn threads(&self) -> usize {
        0
    }

    fn evaluate(&mut self, problem: &Prepared, detail: Detail) -> Result<Evaluation, EngineError> {
        self.device.check()?;
        self.check_loops(problem)?;
        // Put back only after an answer: those of a failed attempt may still be mapped, or be written late.
        let mut buffers = self.take_buffers(problem)?;
        self.stamp = self.stamp.wrapping_add(1);
        buffers.upload(&self.device.queue, problem, self.stamp);
        let submission = self.submit(&buffers, problem, detail);
        let bytes = Buffers::readback_bytes(problem.len(), detail);
        let answer_bytes = size_of::<Answer>();
        let (answer, samples) = self.read_back(&buffers, bytes, submission, |bytes| {
            let answer: Answer = bytemuck::pod_read_unaligned(&bytes[..answer_bytes]);
            let samples = (detail == Detail::Samples)
                .then(|| sample_records(problem, &bytes[answer_bytes..]));
            (answer, samples)
        })?;
        if answer.stamp != self.stamp {
            return Err(self.device.lost("a stale answer came back"));
        }
        self.buffers = Some(buffers);
        Ok(answer.evaluation(samples))
    }
}

fn make_pipelines(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
) -> Result<[wgpu::ComputePipeline; 5], EngineError> {
    let scope = device.inner.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device
        .inner
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("inbye"),
            source: wgpu::ShaderSource::Wgsl(shaders::source().into()),
        });
    let pipeline_layout = device
        .inner
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("inbye"),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        });
    let pipelines = shaders::ENTRY_POINTS.map(|entry_point| {
        device
            .inner
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
    });
    match pollster::block_on(scope.pop()) {
        None => Ok(pipelines),
        Some(error) => Err(EngineError::Setup {
            adapter: device.adapter.clone(),
            what: error.to_string(),
        }),
    }
}
