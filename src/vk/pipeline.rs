//! Pipelines and their layouts, from SPIR-V that the build made.

use super::descriptors::Descriptors;
use super::device::Device;
use super::failure;
use crate::error::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// A shader module, needed only while pipelines are made.
struct Module<'a> {
    raw: vk::ShaderModule,
    device: &'a Device,
}

impl<'a> Module<'a> {
    fn new(device: &'a Device, name: &str, spirv: &[u8]) -> Result<Self> {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(spirv)).map_err(|e| {
            Error::failed(format!("the shader {name} is damaged ({e})"), "build diffract again")
        })?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the device is live; the words are SPIR-V that the build's compiler wrote.
        let raw = unsafe { device.raw().create_shader_module(&info, None) }
            .map_err(|c| failure(&format!("load the shader {name}"), c))?;
        device.name(raw, name);
        Ok(Self { raw, device })
    }

    fn stage(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'static> {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(self.raw).name(c"main")
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: a module may go as soon as its pipelines are made.
        unsafe { self.device.raw().destroy_shader_module(self.raw, None) };
    }
}

/// How triangles become fragments of a graphics pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// Size of a vertex in bytes; 0 where the shader makes its own.
    pub vertex_stride: u32,
    /// Attributes of a vertex.
    pub attributes: &'a [vk::VertexInputAttributeDescription],
    /// Formats of the colour attachments.
    pub colors: &'a [vk::Format],
    /// Depth comparison and whether depth is written; `None`: no depth.
    pub depth: Option<(vk::CompareOp, bool)>,
}

/// Code of a stage: its file's name and its SPIR-V.
pub type Code<'a> = (&'a str, &'a [u8]);

/// Where each of `constants` stands: number i at its i-th place.
fn entries(constants: &[i32]) -> Vec<vk::SpecializationMapEntry> {
    let size = size_of::<i32>();
    let at = |i: usize| {
        vk::SpecializationMapEntry::default().constant_id(i as u32).offset((i * size) as u32).size(size)
    };
    (0..constants.len()).map(at).collect()
}

fn specialization<'a>(
    constants: &'a [i32],
    entries: &'a [vk::SpecializationMapEntry],
) -> vk::SpecializationInfo<'a> {
    vk::SpecializationInfo::default().map_entries(entries).data(bytemuck::cast_slice(constants))
}

/// A pipeline and its layout.
pub struct Pipeline {
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
    bind_point: vk::PipelineBindPoint,
    push_stages: vk::ShaderStageFlags,
    device: Arc<Device>,
}

impl Pipeline {
    fn empty(
        device: &Arc<Device>,
        descriptors: &Descriptors,
        bind_point: vk::PipelineBindPoint,
        push_bytes: u32,
    ) -> Result<Self> {
        let push_stages = match bind_point {
            vk::PipelineBindPoint::COMPUTE => vk::ShaderStageFlags::COMPUTE,
            _ => vk::ShaderStageFlags::FRAGMENT,
        };
        let layouts = [descriptors.layout()];
        let ranges = [vk::PushConstantRange::default().stage_flags(push_stages).size(push_bytes)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
        if push_bytes > 0 {
            info = info.push_constant_ranges(&ranges);
        }
        // SAFETY: the device and the set layout are live.
        let layout = unsafe { device.raw().create_pipeline_layout(&info, None) }
            .map_err(|c| failure("make a pipeline layout", c))?;
        Ok(Self { raw: vk::Pipeline::null(), layout, bind_point, push_stages, device: device.clone() })
    }

    /// A compute pipeline.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn compute(
        device: &Arc<Device>,
        code: Code<'_>,
        descriptors: &Descriptors,
        push_bytes: u32,
    ) -> Result<Self> {
        Self::compute_with(device, code, descriptors, push_bytes, &[])
    }

    /// A compute pipeline whose specialization constants 0, 1, … are `constants`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn compute_with(
        device: &Arc<Device>,
        code: Code<'_>,
        descriptors: &Descriptors,
        push_bytes: u32,
        constants: &[i32],
    ) -> Result<Self> {
        let entries = entries(constants);
        let special = specialization(constants, &entries);
        let mut own = Self::empty(device, descriptors, vk::PipelineBindPoint::COMPUTE, push_bytes)?;
        let module = Module::new(device, code.0, code.1)?;
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(module.stage(vk::ShaderStageFlags::COMPUTE).specialization_info(&special))
            .layout(own.layout);
        // SAFETY: module and layout are live and agree with the shader's declarations.
        own.raw = unsafe { device.raw().create_compute_pipelines(vk::PipelineCache::null(), &[info], None) }
            .map_err(|(_, c)| failure(&format!("make the pipeline of {}", code.0), c))?[0];
        own.named(code.0);
        Ok(own)
    }

    /// A graphics pipeline over dynamic viewport and scissor; without `fragment` it writes depth alone.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn graphics(
        device: &Arc<Device>,
        vertex: Code<'_>,
        fragment: Option<Code<'_>>,
        drawing: &Drawing<'_>,
        descriptors: &Descriptors,
        push_bytes: u32,
    ) -> Result<Self> {
        Self::graphics_with(device, vertex, fragment, drawing, descriptors, push_bytes, &[])
    }

    /// As [`Self::graphics`], with `constants` as specialization constants 0, 1, … of the fragment stage.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn graphics_with(
        device: &Arc<Device>,
        vertex: Code<'_>,
        fragment: Option<Code<'_>>,
        drawing: &Drawing<'_>,
        descriptors: &Descriptors,
        push_bytes: u32,
        constants: &[i32],
    ) -> Result<Self> {
        let entries = entries(constants);
        let special = specialization(constants, &entries);
        let mut own = Self::empty(device, descriptors, vk::PipelineBindPoint::GRAPHICS, push_bytes)?;
        let vertex_module = Module::new(device, vertex.0, vertex.1)?;
        let fragment_module = fragment.map(|code| Module::new(device, code.0, code.1)).transpose()?;
        let mut stages = vec![vertex_module.stage(vk::ShaderStageFlags::VERTEX)];
        stages.extend(
            fragment_module
                .iter()
                .map(|m| m.stage(vk::ShaderStageFlags::FRAGMENT).specialization_info(&special)),
        );

        let bindings = [vk::VertexInputBindingDescription::default().stride(drawing.vertex_stride)];
        let mut input = vk::PipelineVertexInputStateCreateInfo::default();
        if drawing.vertex_stride > 0 {
            input = input
                .vertex_binding_descriptions(&bindings)
                .vertex_attribute_descriptions(drawing.attributes);
        }
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        // Both sides: a mesh need not be closed, and its windings need not be right.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let (compare, depth_write) = drawing.depth.unwrap_or((vk::CompareOp::ALWAYS, false));
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(drawing.depth.is_some())
            .depth_write_enable(depth_write)
            .depth_compare_op(compare);
        let blends = vec![
            vk::PipelineColorBlendAttachmentState::default()
                .color_write_mask(vk::ColorComponentFlags::RGBA);
            drawing.colors.len()
        ];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
        let depth_format =
            if drawing.depth.is_some() { vk::Format::D32_SFLOAT } else { vk::Format::UNDEFINED };
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(drawing.colors)
            .depth_attachment_format(depth_format);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(own.layout)
            .push_next(&mut rendering);
        // SAFETY: modules, layout and every state structure are live through the call and agree with the shaders.
        own.raw = unsafe { device.raw().create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) }
            .map_err(|(_, c)| failure(&format!("make the pipeline of {}", vertex.0), c))?[0];
        own.named(fragment.map_or(vertex.0, |code| code.0));
        Ok(own)
    }

    fn named(&self, name: &str) {
        self.device.name(self.raw, &format!("{name} pipeline"));
        self.device.name(self.layout, &format!("{name} pipeline layout"));
    }

    /// The handle.
    pub fn raw(&self) -> vk::Pipeline {
        self.raw
    }

    /// The layout.
    pub fn layout(&self) -> vk::PipelineLayout {
        self.layout
    }

    /// Graphics or compute.
    pub fn bind_point(&self) -> vk::PipelineBindPoint {
        self.bind_point
    }

    /// The stage that push constants go to.
    pub fn push_stages(&self) -> vk::ShaderStageFlags {
        self.push_stages
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: dropped when no submitted work uses it; null handles are allowed.
        unsafe {
            self.device.raw().destroy_pipeline(self.raw, None);
            self.device.raw().destroy_pipeline_layout(self.layout, None);
        }
    }
}
