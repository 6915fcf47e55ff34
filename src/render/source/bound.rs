//! A source on the device: descriptor set 1 and the code that reads it.

use super::part::Iterations;
use crate::error::Result;
use crate::optics::reflectance::Reflectance;
use crate::render::target::GeometrySettings;
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Code, Constant};
use crate::vk::sampler::Sampler;
use ash::vk;
use std::sync::Arc;

/// The stages that are compiled for one source.
#[derive(Clone, Copy)]
pub(super) struct Stages {
    pub shade: Code<'static>,
    pub eval: Code<'static>,
    pub probe: Code<'static>,
}

/// Descriptor set 1, what it points to, and the code that reads it.
pub struct BoundSource {
    /// The set that pipelines bind.
    pub descriptors: Descriptors,
    /// Whether shading asks which pixels are covered, beyond the depth test: a sum over wavelengths may go on for any time on the lanes of a
    /// pixel beside the mesh, and averages look at neighbours.
    pub asks_what_is_covered: bool,
    /// Whether shading averages over what a pixel covers.
    pub reads_footprints: bool,
    /// Variance of (u, v) over which coherence spreads the specular order in the middle of the spectrum, where the source knows that order
    /// apart from the others.
    pub specular_spread: Option<f32>,
    /// Whether it answers single wavelengths.
    pub spectral: bool,
    /// What its sum over wavelengths takes.
    pub iterations: Iterations,
    // R₀ of what the surface keeps from the pigment, where the source holds R.
    normal_of_pigment: Option<f32>,
    stages: Stages,
    constants: Vec<Constant>,
    // Held for the descriptor set; fields go in order, so it goes first.
    data: Vec<Image>,
    tables: Vec<Image>,
    buffers: Vec<Buffer>,
    samplers: Vec<Sampler>,
}

/// Kinds of bindings.
pub(super) use vk::DescriptorType as Kind;

impl BoundSource {
    /// A source whose set has bindings of these `kinds`, numbered from 0, of a surface that reflects by `reflectance`.
    pub(super) fn new(
        device: &Arc<Device>,
        name: &str,
        kinds: &[Kind],
        stages: Stages,
        constants: Vec<Constant>,
        reflectance: &Reflectance,
    ) -> Result<Self> {
        let visible = vk::ShaderStageFlags::FRAGMENT | vk::ShaderStageFlags::COMPUTE;
        let bindings: Vec<Binding> =
            (0..).zip(kinds).map(|(number, &kind)| Binding { number, kind, stages: visible }).collect();
        Ok(Self {
            descriptors: Descriptors::new(device, name, &bindings)?,
            asks_what_is_covered: true,
            reads_footprints: false,
            specular_spread: None,
            spectral: true,
            iterations: Iterations::default(),
            normal_of_pigment: reflectance.is_spectral().then(|| reflectance.normal_of_pigment() as f32),
            stages,
            constants,
            data: Vec::new(),
            tables: Vec::new(),
            buffers: Vec::new(),
            samplers: Vec::new(),
        })
    }

    /// States that the source holds R by `reflectance`, whichever the law.
    pub(super) fn holds(&mut self, reflectance: &Reflectance) {
        self.normal_of_pigment = Some(reflectance.normal_of_pigment() as f32);
    }

    /// Points binding `number` at an image of the data, which stays as long as the source.
    pub(super) fn data(&mut self, number: u32, image: Image, sampler: Sampler) {
        self.descriptors.image(number, &image, &sampler);
        self.data.push(image);
        self.samplers.push(sampler);
    }

    /// Puts `tables` and `buffers` in the place of those that depend on the shading, each with its binding number.
    pub(super) fn replace(
        &mut self,
        device: &Arc<Device>,
        tables: Vec<(u32, Image)>,
        buffers: Vec<(u32, Buffer)>,
    ) -> Result<()> {
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

    /// The shading stage of what the geometry pass finds by its `settings` under a light that is drawn from surroundings whose specular order is
    /// `mirrored`, or under another.
    pub(in crate::render) fn shade_constants(
        &self,
        settings: GeometrySettings,
        mirrored: bool,
    ) -> Vec<Constant> {
        /// Constants of `shade.frag`.
        const MARKED: u32 = 0;
        const OWN_REFLECTANCE: u32 = 1;
        const NORMAL_OF_PIGMENT: u32 = 2;
        const MIRRORED: u32 = 3;
        const LAMPS: u32 = 4;
        let own = [
            Constant::new(MARKED, self.asks_what_is_covered),
            Constant::new(OWN_REFLECTANCE, self.normal_of_pigment.is_some()),
            Constant::float(NORMAL_OF_PIGMENT, self.normal_of_pigment.unwrap_or_default()),
            Constant::new(MIRRORED, mirrored),
            Constant::new(LAMPS, settings.lamps),
        ];
        [own.as_slice(), &self.constants].concat()
    }

    /// Parts of the sum of a pixel under one light, where surroundings are among the lights or not.
    pub(in crate::render) fn parts(&self, surrounded: bool) -> u32 {
        self.iterations.parts_of_pixel(1 + usize::from(surrounded))
    }

    /// Loop iterations of the sum of such a pixel, at most.
    pub(in crate::render) fn iterations_of_pixel(&self, surrounded: bool) -> usize {
        self.iterations.of_pixel(1 + usize::from(surrounded))
    }

    /// Constants of the source alone.
    pub(in crate::render) fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// The shading stage.
    pub(in crate::render) fn shade(&self) -> Code<'static> {
        self.stages.shade
    }

    /// The evaluation stage.
    pub(in crate::render) fn eval(&self) -> Code<'static> {
        self.stages.eval
    }

    /// The stage that reads as fast as the device can.
    pub(in crate::render) fn probe(&self) -> Code<'static> {
        self.stages.probe
    }
}

/// A small uniform block.
pub(super) fn uniform(device: &Arc<Device>, name: &str, block: &impl bytemuck::Pod) -> Result<Buffer> {
    Buffer::with_data(device, name, vk::BufferUsageFlags::UNIFORM_BUFFER, bytemuck::bytes_of(block))
}
