//! The five compute pipelines, one for each entry point of the shaders.

use super::device::Device;
use super::shaders;
use crate::local::EngineError;

/// Has the adapter's driver compile the shaders; what it refuses is an error, not the panic that wgpu would make of it.
pub(super) fn make(
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
    // Every word of workgroup memory is written before it is read, and one software adapter took as long for the zeros
    // as for all the rest.
    let compilation_options = || wgpu::PipelineCompilationOptions {
        zero_initialize_workgroup_memory: false,
        ..Default::default()
    };
    let pipelines = shaders::ENTRY_POINTS.map(|entry_point| {
        device
            .inner
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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
        Some(error) => Err(EngineError::Setup {
            adapter: device.adapter.clone(),
            what: error.to_string(),
        }),
    }
}
