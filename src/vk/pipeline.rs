//! Pipelines and their layouts, from SPIR-V compiled at build time.

use super::descriptors::Descriptors;
use super::device::Device;
use super::failure;
use super::idle_pipelines::PipelineHandles;
use super::image::has_stencil;
use crate::error::{Error, Result};
use ash::vk;
use std::fmt::Debug;
use std::sync::Arc;

/// Shader module, needed only to create pipelines.
struct Module<'a> {
    raw: vk::ShaderModule,
    entries: Vec<vk::SpecializationMapEntry>,
    values: Vec<u32>,
    device: &'a Device,
}

impl<'a> Module<'a> {
    fn new(device: &'a Device, Code { name, spirv, constants }: Code<'a>) -> Result<Self> {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(spirv))
            .map_err(|e| Error::bug(format!("the shader {name} is damaged ({e})")).caused_by(e))?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the device is live; the words are SPIR-V that the build's compiler wrote.
        let raw = unsafe { device.raw().create_shader_module(&info, None) }
            .map_err(|c| failure(&format!("load the shader {name}"), c))?;
        device.name(raw, name);
        let entry = |(index, constant): (usize, &Constant)| vk::SpecializationMapEntry {
            constant_id: constant.id,
            offset: (index * size_of::<u32>()) as u32,
            size: size_of::<u32>(),
        };
        let entries = constants.iter().enumerate().map(entry).collect();
        let values = constants.iter().map(|constant| constant.value).collect();
        Ok(Self { raw, entries, values, device })
    }

    /// Returns the values of the stage's constants.
    fn specialization(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(bytemuck::cast_slice(&self.values))
    }

    fn stage<'b>(
        &self,
        stage: vk::ShaderStageFlags,
        specialization: &'b vk::SpecializationInfo<'_>,
    ) -> vk::PipelineShaderStageCreateInfo<'b> {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(stage)
            .module(self.raw)
            .name(c"main")
            .specialization_info(specialization)
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: a module may go as soon as its pipelines are made.
        unsafe { self.device.raw().destroy_shader_module(self.raw, None) };
    }
}

/// Vertex input and attachments of a graphics pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// Size of a vertex in bytes; 0 without a vertex buffer.
    pub vertex_stride: u32,
    /// Attributes of a vertex.
    pub attributes: &'a [vk::VertexInputAttributeDescription],
    /// Formats of the colour attachments.
    pub colors: &'a [vk::Format],
    /// Depth test; `None` without depth.
    pub depth: Option<Depth>,
}

/// Depth test, and the use of the stencil for fragments that pass it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Depth {
    /// Format of the attachment.
    pub format: vk::Format,
    /// Comparison that passes.
    pub compare: vk::CompareOp,
    /// True if the depth of passing fragments is written.
    pub write: bool,
    /// Use of the stencil, if any.
    pub stencil: Option<Stencil>,
}

/// Use of the stencil by a draw. The number is that of [`super::commands::Recorder::stencil`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stencil {
    /// Write the number wherever something is drawn.
    Write,
    /// Draw only where the stencil equals the number.
    Match,
}

impl Stencil {
    fn state(self) -> vk::StencilOpState {
        let (compare_op, pass_op) = match self {
            Self::Write => (vk::CompareOp::ALWAYS, vk::StencilOp::REPLACE),
            Self::Match => (vk::CompareOp::EQUAL, vk::StencilOp::KEEP),
        };
        let (fail_op, depth_fail_op) = (vk::StencilOp::KEEP, vk::StencilOp::KEEP);
        let all = u8::MAX.into();
        vk::StencilOpState {
            fail_op,
            pass_op,
            depth_fail_op,
            compare_op,
            compare_mask: all,
            write_mask: all,
            reference: 0,
        }
    }
}

/// Specialisation constant of 4 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Constant {
    /// `constant_id` in the shader.
    pub id: u32,
    /// Bits of the value, also of a float; 0 or 1 for a bool.
    pub value: u32,
}

impl Constant {
    /// Makes constant `id` with `value`.
    pub fn new(id: u32, value: impl Into<u32>) -> Self {
        Self { id, value: value.into() }
    }

    /// Makes constant `id` with a float value.
    pub fn float(id: u32, value: f32) -> Self {
        Self { id, value: value.to_bits() }
    }
}

/// Shader code of a stage.
#[derive(Clone, Copy, Debug)]
pub struct Code<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// SPIR-V code.
    pub spirv: &'a [u8],
    /// Specialisation constants; those that the stage does not declare are ignored.
    pub constants: &'a [Constant],
}

impl<'a> Code<'a> {
    /// Returns the same stage with `constants`.
    pub fn with(self, constants: &'a [Constant]) -> Self {
        Self { constants, ..self }
    }
}

/// Pipeline and its layout.
pub struct Pipeline {
    handles: PipelineHandles,
    key: blake3::Hash,
    bind_point: vk::PipelineBindPoint,
    push_stages: vk::ShaderStageFlags,
    device: Arc<Device>,
}

/// Returns the hash of all that a pipeline follows from: its stages, its `state`, and its layout.
fn key_of(stages: &[Code<'_>], state: impl Debug, sets: &[&Descriptors], push_bytes: u32) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for Code { name, spirv, constants } in stages {
        hasher.update(format!("{name:?} {constants:?} {} ", spirv.len()).as_bytes()).update(spirv);
    }
    let bindings: Vec<_> = sets.iter().map(|set| set.bindings()).collect();
    hasher.update(format!("{state:?} {bindings:?} {push_bytes}").as_bytes()).finalize()
}

impl Pipeline {
    /// Returns an idle pipeline that follows from what `key` is the hash of, or a layout without a pipeline.
    fn idle_or_empty(
        device: &Arc<Device>,
        key: blake3::Hash,
        sets: &[&Descriptors],
        bind_point: vk::PipelineBindPoint,
        push_bytes: u32,
    ) -> Result<Self> {
        let push_stages = match bind_point {
            vk::PipelineBindPoint::COMPUTE => vk::ShaderStageFlags::COMPUTE,
            _ => vk::ShaderStageFlags::FRAGMENT,
        };
        let with = |handles| Self { handles, key, bind_point, push_stages, device: device.clone() };
        if let Some(handles) = device.idle_pipelines().take(&key) {
            return Ok(with(handles));
        }
        let layouts: Vec<_> = sets.iter().map(|set| set.layout()).collect();
        let ranges = [vk::PushConstantRange::default().stage_flags(push_stages).size(push_bytes)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
        if push_bytes > 0 {
            info = info.push_constant_ranges(&ranges);
        }
        // SAFETY: the device and the set layout are live.
        let layout = unsafe { device.raw().create_pipeline_layout(&info, None) }
            .map_err(|c| failure("make a pipeline layout", c))?;
        Ok(with(PipelineHandles { raw: vk::Pipeline::null(), layout }))
    }

    fn is_made(&self) -> bool {
        self.handles.raw != vk::Pipeline::null()
    }

    /// Makes a compute pipeline over `sets`, set 0 first.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn compute(
        device: &Arc<Device>,
        code: Code<'_>,
        sets: &[&Descriptors],
        push_bytes: u32,
    ) -> Result<Self> {
        let key = key_of(&[code], (), sets, push_bytes);
        let mut made = Self::idle_or_empty(device, key, sets, vk::PipelineBindPoint::COMPUTE, push_bytes)?;
        if made.is_made() {
            return Ok(made);
        }
        let module = Module::new(device, code)?;
        let constants = module.specialization();
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(module.stage(vk::ShaderStageFlags::COMPUTE, &constants))
            .layout(made.handles.layout);
        // SAFETY: module and layout are live and agree with the shader's declarations.
        made.handles.raw =
            unsafe { device.raw().create_compute_pipelines(device.pipelines(), &[info], None) }
                .map_err(|(_, c)| failure(&format!("make the pipeline of {}", code.name), c))?[0];
        made.named(code.name);
        Ok(made)
    }

    /// Makes a graphics pipeline over `sets`, set 0 first, with dynamic viewport and scissor. Without `fragment` it
    /// writes depth only.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn graphics(
        device: &Arc<Device>,
        vertex: Code<'_>,
        fragment: Option<Code<'_>>,
        drawing: &Drawing<'_>,
        sets: &[&Descriptors],
        push_bytes: u32,
    ) -> Result<Self> {
        let replace = vk::PipelineColorBlendAttachmentState::default();
        Self::blended(device, (vertex, fragment), drawing, sets, push_bytes, replace)
    }

    /// Makes a graphics pipeline with additive blending.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn adding(
        device: &Arc<Device>,
        vertex: Code<'_>,
        fragment: Code<'_>,
        drawing: &Drawing<'_>,
        sets: &[&Descriptors],
        push_bytes: u32,
    ) -> Result<Self> {
        let one = vk::BlendFactor::ONE;
        let add = vk::PipelineColorBlendAttachmentState::default()
            .blend_enable(true)
            .src_color_blend_factor(one)
            .dst_color_blend_factor(one)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(one)
            .dst_alpha_blend_factor(one)
            .alpha_blend_op(vk::BlendOp::ADD);
        Self::blended(device, (vertex, Some(fragment)), drawing, sets, push_bytes, add)
    }

    fn blended(
        device: &Arc<Device>,
        (vertex, fragment): (Code<'_>, Option<Code<'_>>),
        drawing: &Drawing<'_>,
        sets: &[&Descriptors],
        push_bytes: u32,
        blend: vk::PipelineColorBlendAttachmentState,
    ) -> Result<Self> {
        let stages: Vec<_> = [vertex].into_iter().chain(fragment).collect();
        let key = key_of(&stages, (drawing, blend), sets, push_bytes);
        let mut made = Self::idle_or_empty(device, key, sets, vk::PipelineBindPoint::GRAPHICS, push_bytes)?;
        if made.is_made() {
            return Ok(made);
        }
        let vertex_module = Module::new(device, vertex)?;
        let fragment_module = fragment.map(|code| Module::new(device, code)).transpose()?;
        let vertex_constants = vertex_module.specialization();
        let fragment_constants = fragment_module.as_ref().map(Module::specialization);
        let mut stages = vec![vertex_module.stage(vk::ShaderStageFlags::VERTEX, &vertex_constants)];
        let fragment_stage = fragment_module.iter().zip(&fragment_constants);
        stages.extend(
            fragment_stage.map(|(module, constants)| module.stage(vk::ShaderStageFlags::FRAGMENT, constants)),
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
        // No culling: meshes need not be closed, and their winding may be wrong.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let mut depth = vk::PipelineDepthStencilStateCreateInfo::default();
        let mut states = vec![vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        if let Some(Depth { compare, write, stencil, .. }) = drawing.depth {
            depth = depth.depth_test_enable(true).depth_write_enable(write).depth_compare_op(compare);
            if let Some(stencil) = stencil {
                let state = stencil.state();
                depth = depth.stencil_test_enable(true).front(state).back(state);
                states.push(vk::DynamicState::STENCIL_REFERENCE);
            }
        }
        let blends = vec![blend.color_write_mask(vk::ColorComponentFlags::RGBA); drawing.colors.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
        let depth_format = drawing.depth.map_or(vk::Format::UNDEFINED, |depth| depth.format);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(drawing.colors)
            .depth_attachment_format(depth_format);
        if has_stencil(depth_format) {
            rendering = rendering.stencil_attachment_format(depth_format);
        }
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
            .layout(made.handles.layout)
            .push_next(&mut rendering);
        // SAFETY: modules, layout and every state structure are live through the call and agree with the shaders.
        made.handles.raw =
            unsafe { device.raw().create_graphics_pipelines(device.pipelines(), &[info], None) }
                .map_err(|(_, c)| failure(&format!("make the pipeline of {}", vertex.name), c))?[0];
        made.named(fragment.map_or(vertex.name, |code| code.name));
        Ok(made)
    }

    fn named(&self, name: &str) {
        self.device.name(self.handles.raw, &format!("{name} pipeline"));
        self.device.name(self.handles.layout, &format!("{name} pipeline layout"));
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::Pipeline {
        self.handles.raw
    }

    /// Returns the layout.
    pub fn layout(&self) -> vk::PipelineLayout {
        self.handles.layout
    }

    /// Returns the bind point: graphics or compute.
    pub fn bind_point(&self) -> vk::PipelineBindPoint {
        self.bind_point
    }

    /// Returns the stages that receive push constants.
    pub fn push_stages(&self) -> vk::ShaderStageFlags {
        self.push_stages
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let unused = if self.is_made() {
            self.device.idle_pipelines().keep(self.key, self.handles)
        } else {
            Some(self.handles)
        };
        if let Some(handles) = unused {
            // SAFETY: pipelines of this device are dropped when no submitted work uses them, and idle ones were.
            unsafe { self.device.destroy_pipeline(handles) };
        }
    }
}
