//! Source on the device: descriptor set 1 and the shaders that read it.

use super::part::Iterations;
use super::surface_factor::{BINDINGS, FIRST, SurfaceFactor};
use crate::error::Result;
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Code, Constant};
use crate::vk::sampler::Sampler;
use ash::vk;
use std::sync::Arc;

/// Shader stages of one source.
#[derive(Clone, Copy)]
pub(super) struct Stages {
    pub shade: Code<'static>,
    pub eval: Code<'static>,
    pub probe: Code<'static>,
}

/// Descriptor set 1, its images and buffers, and the shaders that read them.
pub struct BoundSource {
    /// Descriptor set of the pipelines.
    pub descriptors: Descriptors,
    /// Variance of (u, v) of the specular order due to coherence, at the middle of the spectrum, if the source provides
    /// that order separately.
    pub specular_spread: Option<f32>,
    /// True if single wavelengths can be evaluated.
    pub spectral: bool,
    /// Loop iterations of the sum over wavelengths.
    pub iterations: Iterations,
    // R₀ that attenuates the pigment, if the source already contains R.
    normal_of_pigment: Option<f32>,
    stages: Stages,
    constants: Vec<Constant>,
    // Held for the descriptor set. Fields are dropped in order, so the set is dropped first.
    data: Vec<Image>,
    tables: Vec<Image>,
    buffers: Vec<Buffer>,
    samplers: Vec<Sampler>,
}

/// Kinds of bindings.
pub(super) use vk::DescriptorType as Kind;

impl BoundSource {
    /// Makes a source with the bindings of `factor` and then those of these `kinds`.
    pub(super) fn new(
        device: &Arc<Device>,
        name: &str,
        kinds: &[Kind],
        stages: Stages,
        mut constants: Vec<Constant>,
        factor: &SurfaceFactor,
    ) -> Result<Self> {
        let visible = vk::ShaderStageFlags::FRAGMENT | vk::ShaderStageFlags::COMPUTE;
        let numbered = BINDINGS.into_iter().chain((FIRST..).zip(kinds.iter().copied()));
        let bindings: Vec<Binding> =
            numbered.map(|(number, kind)| Binding { number, kind, stages: visible }).collect();
        constants.extend(factor.constants());
        Ok(Self {
            descriptors: Descriptors::new(device, name, &bindings)?,
            specular_spread: None,
            spectral: true,
            iterations: Iterations::default(),
            normal_of_pigment: factor.normal_of_pigment(),
            stages,
            constants,
            data: Vec::new(),
            tables: Vec::new(),
            buffers: Vec::new(),
            samplers: Vec::new(),
        })
    }

    /// Points binding `number` at an image of the data, which lives as long as the source.
    pub(super) fn data(&mut self, number: u32, image: Image, sampler: Sampler) {
        self.descriptors.image(number, &image, &sampler);
        self.data.push(image);
        self.samplers.push(sampler);
    }

    /// Replaces the tables and buffers that depend on the shading, each given with its binding number, and those of the factor.
    pub(super) fn replace(
        &mut self,
        device: &Arc<Device>,
        mut tables: Vec<(u32, Image)>,
        buffers: Vec<(u32, Buffer)>,
        factor: &SurfaceFactor,
    ) -> Result<()> {
        tables.extend(factor.images(device)?);
        let edge = Sampler::linear(device, "table sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        for (number, image) in &tables {
            self.descriptors.image(*number, image, &edge);
        }
        for (number, buffer) in &buffers {
            self.descriptors.buffer(*number, buffer);
        }
        self.tables = tables.into_iter().map(|(_, image)| image).collect();
        self.buffers = buffers.into_iter().map(|(_, buffer)| buffer).collect();
        self.samplers.truncate(self.data.len());
        self.samplers.push(edge);
        Ok(())
    }

    /// Returns the constants of the shading stage, without those of the light.
    pub(in crate::internals::render) fn shade_constants(&self) -> Vec<Constant> {
        /// Constants of `shade.frag`.
        const SOURCE_HAS_REFLECTANCE: u32 = 1;
        const NORMAL_OF_PIGMENT: u32 = 2;
        let stage_constants = [
            Constant::new(SOURCE_HAS_REFLECTANCE, self.normal_of_pigment.is_some()),
            Constant::float(NORMAL_OF_PIGMENT, self.normal_of_pigment.unwrap_or_default()),
        ];
        [stage_constants.as_slice(), &self.constants].concat()
    }

    /// Returns the number of parts of a pixel's sum under one light. `surrounded`: the specular order of surroundings
    /// needs a second direction of light.
    pub(in crate::internals::render) fn parts(&self, surrounded: bool) -> u32 {
        self.iterations.parts_of_pixel(1 + usize::from(surrounded))
    }

    /// Returns the largest number of loop iterations of that sum.
    pub(in crate::internals::render) fn iterations_of_pixel(&self, surrounded: bool) -> usize {
        self.iterations.of_pixel(1 + usize::from(surrounded))
    }

    /// Returns the constants of the source alone.
    pub(in crate::internals::render) fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Returns the shading stage.
    pub(in crate::internals::render) fn shade(&self) -> Code<'static> {
        self.stages.shade
    }

    /// Returns the evaluation stage.
    pub(in crate::internals::render) fn eval(&self) -> Code<'static> {
        self.stages.eval
    }

    /// Returns the stage that measures the texture read rate.
    pub(in crate::internals::render) fn probe(&self) -> Code<'static> {
        self.stages.probe
    }
}

/// Makes a small uniform buffer of `block`.
pub(super) fn uniform(device: &Arc<Device>, name: &str, block: &impl bytemuck::Pod) -> Result<Buffer> {
    Buffer::with_data(device, name, vk::BufferUsageFlags::UNIFORM_BUFFER, bytemuck::bytes_of(block))
}
