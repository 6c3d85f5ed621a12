//! The source of the shaders, and their compute pipelines.

use serde::Serialize;

use super::device::Device;
use crate::local::EngineError;

/// Name and text of each part, in the order of their dependencies.
pub const PARTS: [(&str, &str); 9] = [
    ("numeric.wgsl", include_str!("../../../shaders/numeric.wgsl")),
    ("layout.wgsl", include_str!("../../../shaders/layout.wgsl")),
    ("rollout.wgsl", include_str!("../../../shaders/rollout.wgsl")),
    ("score.wgsl", include_str!("../../../shaders/score.wgsl")),
    ("select.wgsl", include_str!("../../../shaders/select.wgsl")),
    ("batch.wgsl", include_str!("../../../shaders/batch.wgsl")),
    ("tabulate.wgsl", include_str!("../../../shaders/tabulate.wgsl")),
    ("evaluate.wgsl", include_str!("../../../shaders/evaluate.wgsl")),
    ("decide.wgsl", include_str!("../../../shaders/decide.wgsl")),
];

/// A compute pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pipeline {
    /// Fills the displacement table.
    TabulateProfiles,
    /// Evaluates samples of any problems.
    EvaluateSamples,
    /// Evaluates samples of problems with one disc and without moving obstacles.
    EvaluateOneStaticDisc,
    /// Finds the winner of a problem with few samples.
    Decide,
    /// Adds up the samples of a problem.
    Normalize,
    /// Scores samples.
    ScoreSamples,
    /// Selects the winner of the workgroups' best samples.
    SelectWinner,
}

impl Pipeline {
    /// All pipelines.
    pub const ALL: [Self; 7] = [
        Self::TabulateProfiles,
        Self::EvaluateSamples,
        Self::EvaluateOneStaticDisc,
        Self::Decide,
        Self::Normalize,
        Self::ScoreSamples,
        Self::SelectWinner,
    ];

    /// Name of its entry point.
    #[must_use]
    pub const fn entry_point(self) -> &'static str {
        match self {
            Self::TabulateProfiles => "tabulate_profiles",
            Self::EvaluateSamples | Self::EvaluateOneStaticDisc => "evaluate_samples",
            Self::Decide => "decide",
            Self::Normalize => "normalize",
            Self::ScoreSamples => "score_samples",
            Self::SelectWinner => "select_winner",
        }
    }

    /// Values of the shader's `override` declarations that differ from their defaults.
    #[must_use]
    pub const fn constants(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::EvaluateOneStaticDisc => &[("ONE_DISC", 1.0), ("MOVING_OBSTACLES", 0.0)],
            _ => &[],
        }
    }
}

/// One module of all parts.
#[must_use]
pub fn source() -> String {
    PARTS.map(|(_, text)| text).join("\n")
}

/// Compiles the shaders. Returns what the driver rejects as an error; wgpu alone would panic.
pub(super) fn make(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
) -> Result<[wgpu::ComputePipeline; Pipeline::ALL.len()], EngineError> {
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
    let pipelines = Pipeline::ALL.map(|pipeline| {
        device.inner.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(pipeline.entry_point()),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(pipeline.entry_point()),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: pipeline.constants(),
                zero_initialize_workgroup_memory: false,
            },
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
