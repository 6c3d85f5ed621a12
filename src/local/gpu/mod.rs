//! The GPU engine: transport only. One upload, one submission of five dispatches, one small answer back.
//!
//! Every decision is a batch, most of them of one problem. Pipelines, buffers and distance fields stay on the device;
//! what the first submission of all costs is paid when the engine is made.

pub mod batch;
pub mod bindings;
mod buffers;
mod device;
mod fields;
pub mod layout;
mod pipelines;
pub mod shaders;
mod warm_up;

use std::sync::mpsc;
use std::time::Duration;

use batch::Batch;
use buffers::Buffers;
use device::Device;

pub use device::{Adapter, AdapterSummary, adapters};

use super::contract::{Detail, Engine, Evaluation};
use super::{EngineError, LossKind, Prepared};

/// A submission that takes longer than this for each of its problems has hung: far longer than any does, on software
/// too.
const PATIENCE: Duration = Duration::from_secs(20);

/// Evaluates on a graphics adapter.
pub struct GpuEngine {
    device: Device,
    pipelines: [wgpu::ComputePipeline; 5],
    layout: wgpu::BindGroupLayout,
    /// Those of the last answer.
    buffers: Option<Buffers>,
    stamp: u32,
    patience: Duration,
}

impl GpuEngine {
    /// An engine on an adapter, warm: it has made its pipelines and taken a first tiny decision, so the robot's first
    /// one takes no longer than those after it, but for buffers that must grow.
    ///
    /// # Errors
    /// When the adapter gives no device, refuses a pipeline, or does not answer.
    pub fn new(adapter: &Adapter) -> Result<Self, EngineError> {
        let device = adapter.open()?;
        let layout = buffers::bind_group_layout(&device.inner);
        let pipelines = pipelines::make(&device, &layout)?;
        let mut engine = Self {
            device,
            pipelines,
            layout,
            buffers: None,
            stamp: 0,
            patience: PATIENCE,
        };
        engine.evaluate(&warm_up::problem(), Detail::Samples)?;
        Ok(engine)
    }

    /// Drops the device as a driver reset would, for tests of what follows.
    pub fn destroy_device(&self) {
        self.device.inner.destroy();
    }

    /// As [`Self::destroy_device`], at any time and from any thread: also while an answer is waited for.
    pub fn destroyer(&self) -> impl FnOnce() + Send + 'static {
        let device = self.device.inner.clone();
        move || device.destroy()
    }

    /// How long to wait for the answer to each problem from now on; 20 s unless told. An answer that comes later is an
    /// error of the kind [`LossKind::TimedOut`], and is never taken for that of a later problem.
    pub const fn set_patience(&mut self, patience: Duration) {
        self.patience = patience;
    }

    /// Takes out buffers that hold this batch: those of the last one when they are large enough.
    fn take_buffers(&mut self, batch: &Batch<'_>) -> Result<Buffers, EngineError> {
        let sizes = batch.sizes();
        let grown = match self.buffers.take() {
            Some(buffers) if *buffers.sizes() == buffers.sizes().union(&sizes) => {
                return Ok(buffers);
            }
            Some(buffers) => buffers.sizes().union(&sizes),
            None => sizes,
        };
        let limit = self.device.largest_buffer();
        match batch.problems {
            [problem] if sizes.largest() > limit => Err(EngineError::TooLarge {
                adapter: self.device.adapter.clone(),
                what: format!(
                    "{} samples of {} steps need a buffer of {} bytes, the adapter allows {limit}: sample less densely",
                    problem.len(),
                    problem.header.steps,
                    sizes.largest(),
                ),
            }),
            _ => Ok(Buffers::new(&self.device.inner, &self.layout, &grown)),
        }
    }

    /// Refuses a problem that the adapter's driver would leave unfinished.
    fn check_loops(&self, problem: &Prepared) -> Result<(), EngineError> {
        let header = &problem.header;
        let (steps, discs) = (u64::from(header.steps), u64::from(header.disc_count));
        let moving = u64::from(header.obstacle_count);
        // A turn for each step, disc and obstacle, and up to three more for the square root of a distance; one for each
        // disc and obstacle before; some to find the problem in its batch, for the roots of the terms, and to add up
        // the workgroup.
        let needed = steps * (1 + discs * (1 + 4 * moving)) + discs + moving + 40;
        match self.device.loop_turns {
            Some(most) if needed > most => Err(EngineError::TooLarge {
                adapter: self.device.adapter.clone(),
                what: format!(
                    "{steps} steps of {discs} discs among {moving} moving obstacles take up to {needed} turns of loops, the driver allows {most}: use --engine cpu"
                ),
            }),
            _ => Ok(()),
        }
    }

    /// Evaluates a batch in one submission.
    fn answer(
        &mut self,
        batch: &Batch<'_>,
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        self.device.check()?;
        for problem in batch.problems {
            self.check_loops(problem)?;
        }
        // Put back only after an answer: those of a failed attempt may still be mapped, or be written late.
        let mut buffers = self.take_buffers(batch)?;
        let first_stamp = self.stamp;
        self.stamp = first_stamp.wrapping_add(batch.problems.len() as u32);
        buffers.upload(&self.device.queue, batch, first_stamp);
        let (submission, bytes) = self.submit(&buffers, batch, detail);
        let deadline = self.patience.saturating_mul(batch.problems.len() as u32);
        let evaluations = self
            .read_back(&buffers, bytes, submission, deadline, |bytes| {
                batch.read(bytes, first_stamp, detail)
            })?
            .ok_or_else(|| {
                let what = "a stale answer came back";
                self.device.lost(LossKind::Stale, what)
            })?;
        self.buffers = Some(buffers);
        Ok(evaluations)
    }

    /// Starts the work; says also how many bytes will come back.
    fn submit(
        &self,
        buffers: &Buffers,
        batch: &Batch<'_>,
        detail: Detail,
    ) -> (wgpu::SubmissionIndex, u64) {
        let mut encoder = self
            .device
            .inner
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, buffers.bind_group(), &[]);
            for (pipeline, groups) in self.pipelines.iter().zip(batch.workgroups()) {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
        let bytes = buffers.copy_out(&mut encoder, batch, detail);
        (self.device.queue.submit([encoder.finish()]), bytes)
    }

    /// Waits for the submission and hands the bytes that came back to `read`.
    fn read_back<T>(
        &self,
        buffers: &Buffers,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
        deadline: Duration,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, EngineError> {
        // Only a lost device keeps an answer from being mapped.
        let unmapped = |what| self.device.complaint_or(LossKind::DeviceLost, what);
        let (sender, receiver) = mpsc::channel();
        let slice = buffers.readback().slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, move |outcome| {
            // The receiver is gone only when the wait below gave up.
            let _ = sender.send(outcome);
        });
        self.device
            .wait(submission, deadline, || receiver.try_recv().ok())?
            .map_err(|error| unmapped(error.to_string()))?;
        let result = {
            let view = slice
                .get_mapped_range()
                .map_err(|error| unmapped(error.to_string()))?;
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
        let mut evaluations = self.evaluate_batch(core::slice::from_ref(problem), detail)?;
        Ok(evaluations.swap_remove(0))
    }

    fn evaluate_batch(
        &mut self,
        problems: &[Prepared],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let mut evaluations = Vec::with_capacity(problems.len());
        while evaluations.len() < problems.len() {
            let batch = Batch::first_of(&problems[evaluations.len()..]);
            evaluations.extend(self.answer(&batch, detail)?);
        }
        Ok(evaluations)
    }
}
