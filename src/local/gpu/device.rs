//! Graphics adapters and devices, and their error reports.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;

use crate::local::{EngineError, GpuFailureKind};

/// Number of polls, about a millisecond, before the thread sleeps until the device is done. Many decisions take less
/// time than waking a thread.
const POLLS: usize = 1000;

/// Description of an adapter for display and records.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct AdapterSummary {
    /// Name of the adapter, unique on this machine: the second of the same name is called `NAME #2`.
    pub name: String,
    /// Graphics API, such as `vulkan`.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// Whether the adapter is software on the CPU.
    pub software: bool,
}

/// An adapter that can be opened.
pub struct Adapter {
    inner: wgpu::Adapter,
    /// Its description.
    pub summary: AdapterSummary,
}

/// Lists the adapters of this machine, hardware first, otherwise in the system's order.
#[must_use]
pub fn adapters() -> Vec<Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(descriptor);
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let mut adapters: Vec<Adapter> = found.into_iter().map(Adapter::new).collect();
    adapters.sort_by_key(|adapter| adapter.summary.software);
    number_equal_names(adapters.iter_mut().map(|adapter| &mut adapter.summary.name));
    adapters
}

/// Appends ` #2`, ` #3`... to the further names of several equal ones, so that each card of several can be named.
fn number_equal_names<'a>(names: impl Iterator<Item = &'a mut String>) {
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for name in names {
        let count = counts.entry(name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            *name = format!("{name} #{count}");
        }
    }
}

impl Adapter {
    fn new(inner: wgpu::Adapter) -> Self {
        let info = inner.get_info();
        let summary = AdapterSummary {
            name: info.name,
            backend: info.backend.to_str().to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            software: info.device_type == wgpu::DeviceType::Cpu,
        };
        Self { inner, summary }
    }

    /// Opens a device with WebGPU's default limits, except for buffer sizes: dense sampling needs the adapter's own.
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
        // Mesa's LP_MAX_TGSI_LOOP_ITERATIONS, shared by all loops of an invocation. The driver drops further iterations
        // without an error.
        let loop_iterations = self.summary.name.contains("llvmpipe").then_some(65_535);
        Ok(Device {
            inner: device,
            queue,
            faults,
            adapter: self.summary.name.clone(),
            // A software adapter needs the processor that would poll.
            polls: if self.summary.software { 0 } else { POLLS },
            loop_iterations,
        })
    }
}

/// A device, its queue and its reported faults.
pub(super) struct Device {
    pub inner: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: String,
    /// Number of loop iterations after which the driver abandons an invocation.
    pub loop_iterations: Option<u64>,
    polls: usize,
    faults: Faults,
}

impl Device {
    /// Returns the first fault since the device was opened as an error.
    pub fn check(&self) -> Result<(), EngineError> {
        if self.faults.first().is_none() {
            return Ok(());
        }
        // A lost device rejects calls as invalid; only a poll makes it report the loss.
        let _ = self.inner.poll(wgpu::PollType::Poll);
        match self.faults.first() {
            None => Ok(()),
            Some((kind, message)) => Err(self.failure(kind, message)),
        }
    }

    /// The error from the device's own report if there is one: it is more precise than a missing answer.
    pub fn reported_or(&self, kind: GpuFailureKind, message: impl Into<String>) -> EngineError {
        match self.check() {
            Err(reported) => reported,
            Ok(()) => self.failure(kind, message),
        }
    }

    /// Size of the largest buffer that the shaders can bind, bytes; at most what a `u32` can count.
    pub fn largest_buffer(&self) -> u64 {
        let limits = self.inner.limits();
        let largest = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        largest.min(u64::from(u32::MAX))
    }

    /// Waits for a submission until `outcome` returns a value, which its callbacks provide.
    pub fn wait<T>(
        &self,
        submission: wgpu::SubmissionIndex,
        deadline: Duration,
        mut outcome: impl FnMut() -> Option<T>,
    ) -> Result<T, EngineError> {
        let asks = core::iter::repeat_n(wgpu::PollType::Poll, self.polls);
        let sleep =
            wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(deadline) };
        for poll in asks.chain([sleep]) {
            self.inner.poll(poll).map_err(|error| {
                let kind = match error {
                    wgpu::PollError::Timeout => GpuFailureKind::TimedOut,
                    // A lost device rejects new work before it reports the loss.
                    wgpu::PollError::WrongSubmissionIndex(..) => GpuFailureKind::DeviceLost,
                };
                self.reported_or(kind, error.to_string())
            })?;
            self.check()?;
            if let Some(outcome) = outcome() {
                return Ok(outcome);
            }
        }
        let message = "the answer could not be mapped in time";
        Err(self.failure(GpuFailureKind::TimedOut, message))
    }

    /// The error of a device that gave no answer.
    pub fn failure(&self, kind: GpuFailureKind, message: impl Into<String>) -> EngineError {
        EngineError::Lost { adapter: self.adapter.clone(), kind, message: message.into() }
    }

    /// The error of a problem that the adapter cannot hold.
    pub fn too_large(&self, message: String) -> EngineError {
        EngineError::TooLarge { adapter: self.adapter.clone(), message }
    }
}

const fn kind_of(error: &wgpu::Error) -> GpuFailureKind {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuFailureKind::OutOfMemory,
        wgpu::Error::Validation { .. } => GpuFailureKind::Validation,
        wgpu::Error::Internal { .. } => GpuFailureKind::Internal,
    }
}

/// The first fault of a device, written by its callbacks. Without them wgpu panics at an error.
#[derive(Clone, Default)]
struct Faults(Arc<Mutex<Option<(GpuFailureKind, String)>>>);

impl Faults {
    /// Keeps the first fault. A loss of the device replaces it, because the loss is the cause.
    fn report(&self, kind: GpuFailureKind, message: String) {
        let mut first = self.lock();
        match first.take() {
            None => *first = Some((kind, message)),
            Some((before_kind, before))
                if kind == GpuFailureKind::DeviceLost
                    && before_kind != GpuFailureKind::DeviceLost =>
            {
                *first = Some((kind, format!("{message}; before that: {before}")));
            }
            earlier => *first = earlier,
        }
    }

    fn first(&self) -> Option<(GpuFailureKind, String)> {
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

    #[test]
    fn adapters_of_equal_names_are_numbered() {
        let mut names = ["A100", "A10", "A100", "A100"].map(str::to_owned);
        number_equal_names(names.iter_mut());
        assert_eq!(names, ["A100", "A10", "A100 #2", "A100 #3"]);
    }

    /// No test may exhaust the memory of a shared machine, so the test constructs wgpu's errors.
    #[test]
    fn faults_keep_first_error_until_device_is_lost() {
        let source = || Box::new(core::fmt::Error);
        let description = String::new;
        let errors = [
            wgpu::Error::OutOfMemory { source: source() },
            wgpu::Error::Internal { source: source(), description: description() },
            wgpu::Error::Validation { source: source(), description: description() },
        ];
        let faults = Faults::default();
        let mut kinds = Vec::new();
        for error in &errors {
            kinds.push(kind_of(error));
            faults.report(kind_of(error), error.to_string());
        }
        assert_eq!(kinds, [OutOfMemory, Internal, Validation]);
        let first = |faults: &Faults| faults.first().expect("several errors were reported");
        assert_eq!(first(&faults).0, OutOfMemory);
        faults.report(DeviceLost, "gone".to_owned());
        faults.report(DeviceLost, "gone again".to_owned());
        let (kind, message) = first(&faults);
        assert_eq!(kind, DeviceLost);
        assert_eq!(message, "gone; before that: Out of Memory");
    }
}
