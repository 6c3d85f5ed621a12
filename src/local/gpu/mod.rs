//! The GPU engine: transport only. One upload, one submission of a few dispatches, one small answer back.
//!
//! Every decision is a batch, usually of one problem. A call with more problems than one submission takes writes the inputs of
//! the next submission while the device works. Pipelines, buffers and distance fields stay on the device. The
//! constructor takes a first decision, so its cost does not fall into the first control tick.

pub mod batch;
mod buffers;
mod device;
pub mod layout;
pub mod pipelines;

use std::sync::{Arc, mpsc};
use std::time::Duration;

use batch::{Batch, Dispatch, Sizes};
use buffers::{Buffers, Transfer};
use device::Device;
use pipelines::Pipeline;

pub use device::{Adapter, AdapterSummary, adapters};

use super::engine::{Detail, Engine, Evaluation};
use super::kernel_inputs::{Header, ProfileSegment, QuantizedDisc, TurnProfile, VxSample};
use layout::STEPS_PER_GROUP;

use super::{ClearanceField, EngineError, GpuFailureKind, QuantizedProblem};
use crate::geometry::Pose;
use crate::map::{GridFrame, ObstacleGrid};

/// Timeout per problem: far longer than any decision takes, on software too.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Evaluates on a graphics adapter.
pub struct GpuEngine {
    device: Device,
    /// In the order of [`Pipeline::ALL`].
    pipelines: [wgpu::ComputePipeline; Pipeline::ALL.len()],
    layout: wgpu::BindGroupLayout,
    /// Buffers of the last answer.
    buffers: Option<Buffers>,
    stamp: u32,
    timeout: Duration,
}

crate::settings::opaque_debug!(GpuEngine);

impl GpuEngine {
    /// Opens an adapter, creates the pipelines and takes a first tiny decision. The first decision of the robot then
    /// takes no longer than later ones, except for buffers that must grow.
    ///
    /// # Errors
    /// When the adapter gives no device, refuses a pipeline or does not answer.
    pub fn new(adapter: &Adapter) -> Result<Self, EngineError> {
        let device = adapter.open()?;
        let layout = buffers::bind_group_layout(&device.inner);
        let pipelines = pipelines::make(&device, &layout)?;
        let mut engine =
            Self { device, pipelines, layout, buffers: None, stamp: 0, timeout: TIMEOUT };
        engine.evaluate(&warm_up_problem(), Detail::Samples)?;
        Ok(engine)
    }

    /// Returns a function that destroys the device, from any thread and at any time, also while an answer is pending.
    #[doc(hidden)]
    pub fn destroyer(&self) -> impl FnOnce() + Send + 'static {
        let device = self.device.inner.clone();
        move || device.destroy()
    }

    /// Sets the timeout of each problem; the default is 20 s. A later answer is an error of the kind
    /// [`GpuFailureKind::TimedOut`]; it is never taken for the answer to another problem. The timeout limits the wait for the
    /// device. It cannot end a call in which the driver blocks, see [`Failover::with_timeout`](crate::local::Failover::with_timeout).
    pub const fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }

    /// Takes the buffers of the last answer if they are large enough for these sizes, otherwise allocates larger ones.
    fn take_buffers(&mut self, sizes: &Sizes) -> Buffers {
        let grown = match self.buffers.take() {
            Some(buffers) if buffers.sizes == buffers.sizes.union(sizes) => return buffers,
            Some(buffers) => buffers.sizes.union(sizes),
            None => *sizes,
        };
        Buffers::new(&self.device.inner, &self.layout, &grown)
    }

    /// Rejects a single problem that exceeds the adapter's largest buffer; batches of several are smaller.
    fn check_sizes(&self, batch: &Batch<'_>) -> Result<(), EngineError> {
        let (largest, limit) = (batch.sizes().largest(), self.device.largest_buffer());
        match batch.problems {
            [problem] if largest > limit => Err(self.device.too_large(format!(
                "{} samples of {} steps need a buffer of {largest} bytes, the adapter allows {limit}: sample less densely",
                problem.len(),
                problem.header.steps,
            ))),
            _ => Ok(()),
        }
    }

    /// Rejects a problem that exceeds the driver's limit of loop iterations.
    fn check_loops(&self, problem: &QuantizedProblem, rounds: u32) -> Result<(), EngineError> {
        let header = &problem.header;
        let (steps, discs) = (u64::from(header.steps), u64::from(header.disc_count));
        let moving = u64::from(header.obstacle_count);
        // For each step, disc and obstacle: one iteration, and up to three more for the square root of a distance. Before the
        // steps: one for each disc and obstacle. The search of the problem in its batch, the roots of the terms and the
        // reduction of the workgroup take 40.
        let evaluation = steps * (1 + discs * (1 + 4 * moving)) + discs + moving + 40;
        // For each chunk of steps of a turn profile: its segments, its discs, and the rounds of the sum over the steps.
        let per_chunk = 8 + u64::from(header.segment_count) + discs;
        let chunks = steps.div_ceil(u64::from(STEPS_PER_GROUP));
        let tabulation = u64::from(rounds) * (1 + chunks * per_chunk) + 8;
        let needed = evaluation.max(tabulation);
        match self.device.loop_iterations {
            Some(most) if needed > most => Err(self.device.too_large(format!(
                "{steps} steps of {discs} discs among {moving} moving obstacles need up to {needed} loop iterations, the driver allows {most}: use the CPU engine"
            ))),
            _ => Ok(()),
        }
    }

    /// Writes the inputs of a batch and submits the work.
    fn start<'a>(
        &mut self,
        buffers: &mut Buffers,
        batch: Batch<'a>,
        detail: Detail,
    ) -> Result<Submission<'a>, EngineError> {
        let first_stamp = self.stamp;
        self.stamp = first_stamp.wrapping_add(batch.problems.len() as u32);
        let Device { inner: device, queue, .. } = &self.device;
        let idle = buffers.transfers.pop();
        let transfer = idle.unwrap_or_else(|| Transfer::new(device, &buffers.sizes));
        buffers
            .write(queue, &transfer, &batch, first_stamp)
            .map_err(|error| self.unmapped(&error.to_string()))?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        transfer.copy_in(&mut encoder, buffers, batch.input_bytes());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, &buffers.bind_group, &[]);
            for Dispatch { pipeline, workgroups } in batch.dispatches() {
                pass.set_pipeline(&self.pipelines[pipeline as usize]);
                pass.dispatch_workgroups(workgroups, 1, 1);
            }
        }
        let bytes = transfer.copy_out(&mut encoder, buffers, &batch.sizes(), detail);
        let index = queue.submit([encoder.finish()]);
        let (sender, mapped) = mpsc::channel();
        // The inputs of a later batch can be written as soon as this one is done.
        let upload = (transfer.upload.slice(..), wgpu::MapMode::Write);
        let readback = (transfer.readback.slice(..bytes), wgpu::MapMode::Read);
        for (slice, mode) in [upload, readback] {
            let sender = sender.clone();
            slice.map_async(mode, move |outcome| {
                // The receiver is gone only after a failure.
                let _ = sender.send(outcome);
            });
        }
        Ok(Submission { batch, first_stamp, index, transfer, bytes, mapped })
    }

    /// Waits for a submission and decodes its answers.
    fn finish(
        &self,
        buffers: &mut Buffers,
        submission: Submission<'_>,
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let Submission { batch, first_stamp, index, transfer, bytes, mapped } = submission;
        let deadline = self.timeout.saturating_mul(batch.problems.len() as u32);
        let mut outcomes = Vec::with_capacity(2);
        self.device.wait(index, deadline, || {
            outcomes.extend(mapped.try_iter());
            (outcomes.len() == 2).then_some(())
        })?;
        for outcome in outcomes {
            outcome.map_err(|error| self.unmapped(&error.to_string()))?;
        }
        let evaluations = {
            let slice = transfer.readback.slice(..bytes);
            let view =
                slice.get_mapped_range().map_err(|error| self.unmapped(&error.to_string()))?;
            batch.read(&view, first_stamp, detail)
        };
        transfer.readback.unmap();
        buffers.transfers.push(transfer);
        evaluations.ok_or_else(|| {
            let message = "the answer is stale";
            self.device.failure(GpuFailureKind::Stale, message)
        })
    }

    /// The error of a buffer that cannot be mapped: the device is lost.
    fn unmapped(&self, message: &str) -> EngineError {
        self.device.reported_or(GpuFailureKind::DeviceLost, message)
    }
}

/// Work of the device, with the memory that it uses.
struct Submission<'a> {
    batch: Batch<'a>,
    first_stamp: u32,
    index: wgpu::SubmissionIndex,
    transfer: Transfer,
    /// Bytes to read back.
    bytes: u64,
    /// The outcomes of mapping both buffers of the transfer.
    mapped: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Engine for GpuEngine {
    fn name(&self) -> String {
        self.device.adapter.clone()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut evaluations = self.evaluate_batch(core::slice::from_ref(problem), detail)?;
        Ok(evaluations.swap_remove(0))
    }

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        self.device.check()?;
        let batches = Batch::split(problems);
        let mut sizes = Sizes::default();
        for batch in &batches {
            self.check_sizes(batch)?;
            for problem in batch.problems {
                self.check_loops(problem, batch.tabulation_rounds())?;
            }
            sizes = sizes.union(&batch.sizes());
        }
        // Kept only after the last answer: after a failure they may still be mapped, or be written late.
        let mut buffers = self.take_buffers(&sizes);
        let mut evaluations = Vec::with_capacity(problems.len());
        let mut running = None;
        for batch in batches {
            let next = self.start(&mut buffers, batch, detail)?;
            if let Some(before) = running.replace(next) {
                evaluations.extend(self.finish(&mut buffers, before, detail)?);
            }
        }
        if let Some(last) = running {
            evaluations.extend(self.finish(&mut buffers, last, detail)?);
        }
        self.buffers = Some(buffers);
        Ok(evaluations)
    }
}

/// The smallest problem: one sample of one step at rest on a free cell.
fn warm_up_problem() -> QuantizedProblem {
    let frame = GridFrame { width: 1, height: 1, resolution_m: 0.1, origin: Pose::default() };
    let field = ClearanceField::new(&ObstacleGrid::new(frame, vec![false]))
        .expect("10 cm is within the range of resolutions");
    QuantizedProblem {
        header: Header {
            vx_count: 1,
            profile_count: 1,
            steps: 1,
            segment_count: 1,
            disc_count: 1,
            width: 1,
            height: 1,
            ..Header::default()
        },
        vx_samples: vec![VxSample::default()],
        profiles: vec![TurnProfile::default()],
        segments: vec![ProfileSegment { end: 1, ..ProfileSegment::default() }],
        discs: vec![QuantizedDisc::default()],
        obstacles: Vec::new(),
        field: Arc::new(field),
    }
}
