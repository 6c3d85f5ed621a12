//! The GPU engine: transport only. One upload, one submission of a few dispatches, one small answer back.
//!
//! Every decision is a batch, usually of one problem. Pipelines, buffers and distance fields stay on the device. The
//! constructor takes a first decision, so its cost does not fall into the first control tick.

pub mod batch;
mod buffers;
mod device;
pub mod layout;
pub mod pipelines;

use std::sync::{Arc, mpsc};
use std::time::Duration;

use batch::{Batch, Dispatch};
use buffers::Buffers;
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
    /// [`GpuFailureKind::TimedOut`]; it is never taken for the answer to another problem.
    pub const fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }

    /// Takes the buffers of the last answer if they are large enough for the batch, otherwise allocates larger ones.
    fn take_buffers(&mut self, batch: &Batch<'_>) -> Result<Buffers, EngineError> {
        let sizes = batch.sizes();
        let grown = match self.buffers.take() {
            Some(buffers) if buffers.sizes == buffers.sizes.union(&sizes) => {
                return Ok(buffers);
            }
            Some(buffers) => buffers.sizes.union(&sizes),
            None => sizes,
        };
        let limit = self.device.largest_buffer();
        match batch.problems {
            [problem] if sizes.largest() > limit => Err(self.device.too_large(format!(
                "{} samples of {} steps need a buffer of {} bytes, the adapter allows {limit}: sample less densely",
                problem.len(),
                problem.header.steps,
                sizes.largest(),
            ))),
            _ => Ok(Buffers::new(&self.device.inner, &self.layout, &grown)),
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

    /// Evaluates a batch in one submission.
    fn evaluate_submission(
        &mut self,
        batch: &Batch<'_>,
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        self.device.check()?;
        for problem in batch.problems {
            self.check_loops(problem, batch.tabulation_rounds())?;
        }
        // Kept only after an answer: after a failure they may still be mapped, or be written late.
        let mut buffers = self.take_buffers(batch)?;
        let first_stamp = self.stamp;
        self.stamp = first_stamp.wrapping_add(batch.problems.len() as u32);
        buffers
            .write(&self.device.queue, batch, first_stamp)
            .map_err(|error| self.unmapped(&error.to_string()))?;
        let (submission, bytes) = self.submit(&buffers, batch, detail);
        let deadline = self.timeout.saturating_mul(batch.problems.len() as u32);
        let evaluations = self
            .read_back(&buffers, bytes, submission, deadline, |bytes| {
                batch.read(bytes, first_stamp, detail)
            })?
            .ok_or_else(|| {
                let message = "the answer is stale";
                self.device.failure(GpuFailureKind::Stale, message)
            })?;
        self.buffers = Some(buffers);
        Ok(evaluations)
    }

    /// Submits the work. Returns also the number of bytes to read back.
    fn submit(
        &self,
        buffers: &Buffers,
        batch: &Batch<'_>,
        detail: Detail,
    ) -> (wgpu::SubmissionIndex, u64) {
        let mut encoder =
            self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        buffers.copy_in(&mut encoder, batch);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, &buffers.bind_group, &[]);
            for Dispatch { pipeline, workgroups } in batch.dispatches() {
                pass.set_pipeline(&self.pipelines[pipeline as usize]);
                pass.dispatch_workgroups(workgroups, 1, 1);
            }
        }
        let bytes = buffers.copy_out(&mut encoder, batch, detail);
        (self.device.queue.submit([encoder.finish()]), bytes)
    }

    /// The error of a buffer that cannot be mapped: the device is lost.
    fn unmapped(&self, message: &str) -> EngineError {
        self.device.reported_or(GpuFailureKind::DeviceLost, message)
    }

    /// Waits for the submission and passes the bytes to `read`.
    fn read_back<T>(
        &self,
        buffers: &Buffers,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
        deadline: Duration,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, EngineError> {
        let (sender, receiver) = mpsc::channel();
        let slice = buffers.readback.slice(..bytes);
        // The inputs of the next batch can be written as soon as this one is done.
        let upload = (buffers.upload.slice(..), wgpu::MapMode::Write);
        for (slice, mode) in [upload, (slice, wgpu::MapMode::Read)] {
            let sender = sender.clone();
            slice.map_async(mode, move |outcome| {
                // The receiver is gone only after the wait below has failed.
                let _ = sender.send(outcome);
            });
        }
        let mut outcomes = Vec::with_capacity(2);
        self.device.wait(submission, deadline, || {
            outcomes.extend(receiver.try_iter());
            (outcomes.len() == 2).then_some(())
        })?;
        for outcome in outcomes {
            outcome.map_err(|error| self.unmapped(&error.to_string()))?;
        }
        let result = {
            let view =
                slice.get_mapped_range().map_err(|error| self.unmapped(&error.to_string()))?;
            read(&view)
        };
        buffers.readback.unmap();
        Ok(result)
    }
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
        let mut evaluations = Vec::with_capacity(problems.len());
        while evaluations.len() < problems.len() {
            let batch = Batch::first_of(&problems[evaluations.len()..]);
            evaluations.extend(self.evaluate_submission(&batch, detail)?);
        }
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
