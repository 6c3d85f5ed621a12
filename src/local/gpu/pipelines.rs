//! The source of the shaders and the five compute pipelines, one per entry point.

use super::device::Device;
use crate::local::EngineError;

/// Name and text of each part, in the order of their dependencies.
pub const PARTS: [(&str, &str); 6] = [
    ("numeric.wgsl", include_str!("../../../shaders/numeric.wgsl")),
    ("layout.wgsl", include_str!("../../../shaders/layout.wgsl")),
    ("rollout.wgsl", include_str!("../../../shaders/rollout.wgsl")),
    ("score.wgsl", include_str!("../../../shaders/score.wgsl")),
    ("select.wgsl", include_str!("../../../shaders/select.wgsl")),
    ("evaluate.wgsl", include_str!("../../../shaders/evaluate.wgsl")),
];

/// The entry points of `evaluate.wgsl`, in the order of their dispatches.
pub const ENTRY_POINTS: [&str; 5] =
    ["tabulate_profiles", "evaluate_samples", "normalize", "score_samples", "select_winner"];

/// One module of all parts.
#[must_use]
pub fn source() -> String {
    PARTS.map(|(_, text)| text).join("\n")
}

/// Compiles the shaders. Returns what the driver rejects as an error; wgpu alone would panic.
pub(super) fn make(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
) -> Result<[wgpu::ComputePipeline; 5], EngineError> {
    let scope = device.inner.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device.inner.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("inbye"),
        source: wgpu::ShaderSource::Wgsl(source().into()),
    });
    let pipeline_layout = device.inner.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("inbye"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    // Workgroup memory is written before it is read. On one software adapter clearing it took as long as all the rest.
    let compilation_options = || wgpu::PipelineCompilationOptions {
        zero_initialize_workgroup_memory: false,
        ..Default::default()
    };
    let pipelines = ENTRY_POINTS.map(|entry_point| {
        device.inner.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: compilation_options(),
            cache: None,
        })
    });
    match pollster::block_on(scope.pop()) {
        None => Ok(pipelines),
        Some(error) => {
            Err(EngineError::Setup { adapter: device.adapter.clone(), message: error.to_string() })
        }
    }
}
