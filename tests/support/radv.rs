//! Compiles the compute pipelines for Radeons that this machine lacks: Mesa's RADV takes the model from a variable and then
//! compiles with its real compiler on a device that runs nothing.
#![expect(unsafe_code, reason = "wgpu opens no such device, so this calls Vulkan itself")]

use std::error::Error;
use std::ffi::{CStr, CString};
use std::path::{Path, PathBuf};
use std::process::Command;

use ash::khr::pipeline_executable_properties as executables;
use ash::vk;
use inbye::local::internals::gpu::{ACCESS, Access, Pipeline, source};
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use serde::{Deserialize, Serialize};

use super::machine_code::largest_loop_cycles;

/// RADV's variable for the model, which also makes this program print statistics instead of running tests.
const FAMILY: &str = "RADV_FORCE_FAMILY";
const PRINTS_STATISTICS: &str = "INBYE_PRINT_SHADER_STATISTICS";

type Result<T> = core::result::Result<T, Box<dyn Error>>;

/// What the compiler reports about a pipeline. Times are the compiler's own estimates, in cycles; it takes each loop for
/// eight iterations.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    pub family: String,
    pub pipeline: String,
    pub wave: u64,
    pub vgprs: u64,
    pub spilled: u64,
    pub workgroup_bytes: u64,
    pub waves_per_simd: u64,
    pub instructions: u64,
    pub latency: u64,
    pub inverse_throughput: u64,
    pub largest_loop_cycles: u64,
}

/// Mesa's version and the statistics of all pipelines for one model.
#[derive(Debug, Serialize, Deserialize)]
pub struct Report {
    pub driver: String,
    pub pipelines: Vec<Statistics>,
}

/// The loader's description of RADV, if it is installed.
pub fn driver_file() -> Option<PathBuf> {
    ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"].iter().find_map(|folder| {
        let files = Path::new(folder).read_dir().ok()?;
        let mut paths = files.filter_map(|file| Some(file.ok()?.path()));
        paths.find(|path| path.to_string_lossy().contains("radeon_icd"))
    })
}

/// Statistics for one model, from a process of its own: RADV reads the variable when it looks for devices.
pub fn statistics(driver_file: &Path, family: &str) -> Result<Report> {
    let output = Command::new(std::env::current_exe()?)
        .env(PRINTS_STATISTICS, "1")
        .env(FAMILY, family)
        .env("VK_DRIVER_FILES", driver_file)
        .env("VK_ICD_FILENAMES", driver_file)
        .env_remove("VK_ADD_DRIVER_FILES")
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// In the process for one model: prints its statistics. Returns whether this is such a process.
pub fn print_if_asked() -> Result<bool> {
    if std::env::var_os(PRINTS_STATISTICS).is_none() {
        return Ok(false);
    }
    let family = std::env::var(FAMILY)?;
    // SAFETY: this process only creates Vulkan objects, on this thread, and ends with them.
    let report = unsafe { Compiler::open(family)?.report() }?;
    #[expect(clippy::print_stdout, reason = "the process that asks reads it")]
    {
        println!("{}", serde_json::to_string(&report)?);
    }
    Ok(true)
}

/// A device that compiles.
struct Compiler {
    family: String,
    driver: String,
    device: ash::Device,
    executables: executables::Device,
    layout: vk::PipelineLayout,
    // Unloads the driver.
    _instance: ash::Instance,
    _entry: ash::Entry,
}

impl Compiler {
    unsafe fn open(family: String) -> Result<Self> {
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let create = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: the loader is the system's, and all pointers outlive the calls below.
        unsafe {
            let entry = ash::Entry::load()?;
            let instance = entry.create_instance(&create, None)?;
            let adapters = instance.enumerate_physical_devices()?;
            let adapter = *adapters.first().ok_or("RADV shows no device")?;
            let mut about_driver = vk::PhysicalDeviceDriverProperties::default();
            let mut about = vk::PhysicalDeviceProperties2::default().push_next(&mut about_driver);
            instance.get_physical_device_properties2(adapter, &mut about);
            let driver = about_driver.driver_info_as_c_str()?.to_string_lossy().into_owned();
            let device = Self::device(&instance, adapter)?;
            Ok(Self {
                family,
                driver,
                executables: executables::Device::new(&instance, &device),
                layout: Self::pipeline_layout(&device)?,
                device,
                _instance: instance,
                _entry: entry,
            })
        }
    }

    /// With the features that wgpu enables for a compute shader.
    unsafe fn device(instance: &ash::Instance, adapter: vk::PhysicalDevice) -> Result<ash::Device> {
        let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
        let extensions = [executables::NAME.as_ptr(), ash::ext::robustness2::NAME.as_ptr()];
        let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
        let mut robustness =
            vk::PhysicalDeviceRobustness2FeaturesEXT::default().robust_buffer_access2(true);
        let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features)
            .push_next(&mut robustness)
            .push_next(&mut statistics);
        // SAFETY: the adapter is the instance's.
        Ok(unsafe { instance.create_device(adapter, &create, None) }?)
    }

    unsafe fn pipeline_layout(device: &ash::Device) -> Result<vk::PipelineLayout> {
        let bindings: Vec<_> = (0..)
            .zip(ACCESS)
            .map(|(binding, access)| {
                let kind = match access {
                    Access::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
                    Access::Read | Access::ReadWrite => vk::DescriptorType::STORAGE_BUFFER,
                };
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the bindings outlive the calls.
        unsafe {
            let sets = [device.create_descriptor_set_layout(&create, None)?];
            let create = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            Ok(device.create_pipeline_layout(&create, None)?)
        }
    }

    unsafe fn report(&self) -> Result<Report> {
        // SAFETY: the device is open.
        let each = Pipeline::ALL.into_iter().map(|pipeline| unsafe { self.compile(pipeline) });
        Ok(Report { driver: self.driver.clone(), pipelines: each.collect::<Result<_>>()? })
    }

    unsafe fn compile(&self, pipeline: Pipeline) -> Result<Statistics> {
        let words = spirv(pipeline)?;
        let entry_point = CString::new(pipeline.entry_point())?;
        let create = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are valid SPIR-V, and all pointers outlive the calls.
        let (size, found, code) = unsafe {
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(self.device.create_shader_module(&create, None)?)
                .name(&entry_point);
            let create =
                vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout).flags(
                    vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR
                        | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR,
                );
            let made =
                self.device.create_compute_pipelines(vk::PipelineCache::null(), &[create], None);
            let made = made.map_err(|(_, error)| error)?[0];
            let all = vk::PipelineInfoKHR::default().pipeline(made);
            let size = self.executables.get_pipeline_executable_properties(&all)?;
            let first = vk::PipelineExecutableInfoKHR::default().pipeline(made);
            let found = self.executables.get_pipeline_executable_statistics(&first)?;
            (size[0].subgroup_size, found, self.machine_code(&first)?)
        };
        let value = |name: &str| {
            let of_name = |one: &&vk::PipelineExecutableStatisticKHR<'_>| {
                one.name_as_c_str().is_ok_and(|found| found.to_bytes() == name.as_bytes())
            };
            let one = found.iter().find(of_name).ok_or(format!("RADV reports no {name}"))?;
            // SAFETY: RADV's statistics are all whole numbers.
            Ok::<u64, Box<dyn Error>>(unsafe { one.value.u64 })
        };
        Ok(Statistics {
            family: self.family.clone(),
            pipeline: serde_json::to_value(pipeline)?.as_str().ok_or("no name")?.to_owned(),
            wave: u64::from(size),
            vgprs: value("VGPRs")?,
            spilled: value("Spilled VGPRs")? + value("Spilled SGPRs")?,
            workgroup_bytes: value("LDS size")?,
            waves_per_simd: value("Subgroups per SIMD")?,
            instructions: value("Instructions")?,
            latency: value("Latency")?,
            inverse_throughput: value("Inverse Throughput")?,
            largest_loop_cycles: largest_loop_cycles(&code),
        })
    }

    /// The last of the compiler's representations of a program.
    unsafe fn machine_code(&self, info: &vk::PipelineExecutableInfoKHR<'_>) -> Result<String> {
        let device = self.executables.device();
        let call = self.executables.fp().get_pipeline_executable_internal_representations_khr;
        let mut count = 0;
        // SAFETY: the first call counts, the second returns sizes, the third fills buffers of these sizes.
        unsafe {
            call(device, info, &raw mut count, core::ptr::null_mut()).result()?;
            let mut all =
                vec![vk::PipelineExecutableInternalRepresentationKHR::default(); count as usize];
            call(device, info, &raw mut count, all.as_mut_ptr()).result()?;
            let mut texts: Vec<Vec<u8>> = all.iter().map(|one| vec![0; one.data_size]).collect();
            for (one, text) in all.iter_mut().zip(&mut texts) {
                one.p_data = text.as_mut_ptr().cast();
            }
            call(device, info, &raw mut count, all.as_mut_ptr()).result()?;
            let last = texts.last().ok_or("RADV returns no machine code")?;
            Ok(CStr::from_bytes_until_nul(last)?.to_string_lossy().into_owned())
        }
    }
}

/// The SPIR-V of a pipeline as wgpu gives it to a driver of Vulkan 1.3.
fn spirv(pipeline: Pipeline) -> Result<Vec<u32>> {
    let source = source();
    let module = naga::front::wgsl::parse_str(&source)?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module)?;
    let constants = pipeline.constants().iter().map(|(name, value)| ((*name).to_owned(), *value));
    let stage = (naga::ShaderStage::Compute, pipeline.entry_point());
    let constants = constants.collect();
    let (module, info) =
        naga::back::pipeline_constants::process_overrides(&module, &info, Some(stage), &constants)?;
    let options = spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::FORCE_POINT_SIZE,
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            ..BoundsCheckPolicies::default()
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        ..spv::Options::default()
    };
    let pipeline_options = spv::PipelineOptions {
        shader_stage: naga::ShaderStage::Compute,
        entry_point: pipeline.entry_point().to_owned(),
    };
    Ok(spv::write_vec(&module, &info, &options, Some(&pipeline_options))?)
}
