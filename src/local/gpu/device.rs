//! Graphics adapters and devices, and what they say when something goes wrong.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;

use crate::local::{EngineError, GpuFailureKind};

/// How often hardware is asked whether it is done before the thread sleeps until it is: for about a millisecond. Many a
/// decision takes no longer than the system takes to wake a thread.
const POLLS: usize = 1000;

/// An adapter as people and records name it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterSummary {
    /// The adapter's own name.
    pub name: String,
    /// The interface it is reached by, such as `vulkan`.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// Whether it is a program on the CPU rather than hardware.
    pub software: bool,
}

/// An adapter that can be opened.
pub struct Adapter {
    inner: wgpu::Adapter,
    /// Its names.
    pub summary: AdapterSummary,
}

/// All adapters of this machine, hardware first, otherwise in the system's order.
#[must_use]
pub fn adapters() -> Vec<Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(descriptor);
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let mut adapters: Vec<Adapter> = found.into_iter().map(Adapter::new).collect();
    adapters.sort_by_key(|adapter| adapter.summary.software);
    adapters
}

impl Adapter {
    fn new(inner: wgpu::Adapter) -> Self {
        let info = inner.get_info();
        let summary = AdapterSummary {
            name: info.name,
            backend: info.backend.to_str().to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            software: info.device_type == wgpu::DeviceType::Cpu,
        };
        Self { inner, summary }
    }

    /// Opens a device with WebGPU's default limits, or the adapter's own where the large buffers of dense sampling
    /// need more.
    pub(super) fn open(&self) -> Result<Device, EngineError> {
        let own = self.inner.limits();
        let limits = wgpu::Limits {
            max_storage_buffer_binding_size: own.max_storage_buffer_binding_size,
            max_buffer_size: own.max_buffer_size,
            ..wgpu::Limits::default()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("inbye"),
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(self.inner.request_device(&descriptor)).map_err(|error| {
                EngineError::Setup {
                    adapter: self.summary.name.clone(),
                    message: error.to_string(),
                }
            })?;
        let faults = Faults::default();
        let (on_error, on_loss) = (faults.clone(), faults.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            on_error.report(kind_of(&error), error.to_string());
        }));
        device.set_device_lost_callback(move |reason, message| {
            let message = format!("device lost ({reason:?}): {message}");
            on_loss.report(GpuFailureKind::DeviceLost, message);
        });
        // Mesa's LP_MAX_TGSI_LOOP_ITERATIONS, shared by all loops of an invocation; the rest is left out in silence.
        let loop_iterations = self.summary.name.contains("llvmpipe").then_some(65_535);
        Ok(Device {
            inner: device,
            queue,
            faults,
            adapter: self.summary.name.clone(),
            // A software adapter needs the processor that would do the asking.
            polls: if self.summary.software { 0 } else { POLLS },
            loop_iterations,
        })
    }
}

/// A device, its queue and what it complained of.
pub(super) struct Device {
    pub inner: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: String,
    /// Turns of loops after which the adapter's driver abandons an invocation.
    pub loop_iterations: Option<u64>,
    polls: usize,
    faults: Faults,
}

impl Device {
    /// The first complaint since the device was opened, as an error.
    pub fn check(&self) -> Result<(), EngineError> {
        if self.faults.messages().is_none() {
            return Ok(());
        }
        // Calls on a lost device are refused as invalid, and only a poll makes it say that it is lost.
        let _ = self.inner.poll(wgpu::PollType::Poll);
        match self.faults.messages() {
            None => Ok(()),
            Some((kind, message)) => Err(self.lost(kind, message)),
        }
    }

    /// What went wrong by the device's own complaint, which says more than that something did not come.
    pub fn complaint_or(&self, kind: GpuFailureKind, message: impl Into<String>) -> EngineError {
        match self.check() {
            Err(complaint) => complaint,
            Ok(()) => self.lost(kind, message),
        }
    }

    /// Bytes of the largest buffer that the shaders can see whole; never more than words of 32 bits can count.
    pub fn largest_buffer(&self) -> u64 {
        let limits = self.inner.limits();
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        largest.min(u64::from(u32::MAX))
    }

    /// Waits for a submission until `outcome`, which its callbacks bring about, is there.
    pub fn wait<T>(
        &self,
        submission: wgpu::SubmissionIndex,
        deadline: Duration,
        mut outcome: impl FnMut() -> Option<T>,
    ) -> Result<T, EngineError> {
        let asks = core::iter::repeat_n(wgpu::PollType::Poll, self.polls);
        let sleep = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: Some(deadline),
        };
        for poll in asks.chain([sleep]) {
            self.inner.poll(poll).map_err(|error| {
                let kind = match error {
                    wgpu::PollError::Timeout => GpuFailureKind::TimedOut,
                    // A device takes no more work once it is lost, and says so only later.
                    wgpu::PollError::WrongSubmissionIndex(..) => GpuFailureKind::DeviceLost,
                };
                self.complaint_or(kind, error.to_string())
            })?;
            self.check()?;
            if let Some(outcome) = outcome() {
                return Ok(outcome);
            }
        }
        let message = "the answer could not be mapped in time";
        Err(self.lost(GpuFailureKind::TimedOut, message))
    }

    /// The error for a device that gave no answer.
    pub fn lost(&self, kind: GpuFailureKind, message: impl Into<String>) -> EngineError {
        EngineError::Lost {
            adapter: self.adapter.clone(),
            kind,
            message: message.into(),
        }
    }
}

const fn kind_of(error: &wgpu::Error) -> GpuFailureKind {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuFailureKind::OutOfMemory,
        wgpu::Error::Validation { .. } => GpuFailureKind::Validation,
        wgpu::Error::Internal { .. } => GpuFailureKind::Internal,
    }
}

/// The first complaint of a device, written by its callbacks. wgpu's own answer to an error would be a panic.
#[derive(Clone, Default)]
struct Faults(Arc<Mutex<Option<(GpuFailureKind, String)>>>);

impl Faults {
    /// Keeps the first complaint; the loss of the device is the reason of those before it.
    fn report(&self, kind: GpuFailureKind, message: String) {
        let mut messages = self.lock();
        match messages.take() {
            None => *messages = Some((kind, message)),
            Some((first, before))
                if kind == GpuFailureKind::DeviceLost && first != GpuFailureKind::DeviceLost =>
            {
                *messages = Some((kind, format!("{message}; before that: {before}")));
            }
            first => *messages = first,
        }
    }

    fn messages(&self) -> Option<(GpuFailureKind, String)> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Option<(GpuFailureKind, String)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use GpuFailureKind::{DeviceLost, Internal, OutOfMemory, Validation};

    /// No test can use up the memory of a machine that others share, so what wgpu would say then is said here.
    #[test]
    fn what_a_device_complains_of_keeps_its_kind_and_the_first_counts_unless_it_is_lost() {
        let source = || Box::new(core::fmt::Error);
        let description = String::new;
        let errors = [
            wgpu::Error::OutOfMemory { source: source() },
            wgpu::Error::Internal {
                source: source(),
                description: description(),
            },
            wgpu::Error::Validation {
                source: source(),
                description: description(),
            },
        ];
        let faults = Faults::default();
        let mut kinds = Vec::new();
        for error in &errors {
            kinds.push(kind_of(error));
            faults.report(kind_of(error), error.to_string());
        }
        assert_eq!(kinds, [OutOfMemory, Internal, Validation]);
        let messages = |faults: &Faults| faults.messages().expect("several errors were reported");
        assert_eq!(messages(&faults).0, OutOfMemory);
        faults.report(DeviceLost, "gone".to_owned());
        faults.report(DeviceLost, "gone again".to_owned());
        let (kind, message) = messages(&faults);
        assert_eq!(kind, DeviceLost);
        assert_eq!(message, "gone; before that: Out of Memory");
    }
}
