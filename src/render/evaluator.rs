//! Evaluation of single directions by the source that frames are shaded from.

use super::source::part::Part;
use super::source::{BoundSource, Source};
use crate::error::{Error, Result};
use crate::optics::geometry::Pair;
use crate::settings::Optics;
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::pipeline::Pipeline;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Queries of one submission; a software device evaluates this many in a few seconds.
pub const AT_ONCE: usize = 16_384;
/// `local_size_x` of `eval.comp`.
const GROUP: usize = 64;

/// Query of the BRDF at a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// The directions.
    pub pair: Pair,
    /// Wavelength \[µm\]; `None` for the colour.
    pub wavelength: Option<f64>,
}

/// A query as `eval.comp` reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct QueryBlock {
    /// To the light; w: wavenumber \[µm⁻¹\], or 0 for the colour.
    light: [f32; 4],
    /// To the viewer; w unused.
    view: [f32; 4],
}

/// Push constants of `eval.comp`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Asked {
    part: Part,
    queries: u32,
    // Standard deviation of u and of v that answers average over.
    footprint: f32,
}

/// Binding numbers of set 0.
mod binding {
    pub const QUERIES: u32 = 0;
    pub const ANSWERS: u32 = 1;
}

/// Makes a set of two storage buffers for the compute stage: queries and answers.
pub(super) fn queries_and_answers(
    device: &Arc<Device>,
    queries: &Buffer,
    answers: &Buffer,
) -> Result<Descriptors> {
    let binding = |number| Binding {
        number,
        kind: vk::DescriptorType::STORAGE_BUFFER,
        stages: vk::ShaderStageFlags::COMPUTE,
    };
    let bindings = [binding::QUERIES, binding::ANSWERS].map(binding);
    let set = Descriptors::new(device, "queries set", &bindings)?;
    set.buffer(binding::QUERIES, queries);
    set.written_buffer(binding::ANSWERS, answers);
    Ok(set)
}

/// Evaluates queries on the device.
pub struct Evaluator {
    pass: QueryPass,
    source: BoundSource,
    footprint: f64,
}

impl Evaluator {
    /// Uploads `source` and the small tables for `optics`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, source: &Source, optics: &Optics) -> Result<Self> {
        let source = source.bind(device, optics)?;
        Ok(Self { pass: QueryPass::new(device, &source)?, source, footprint: 0.0 })
    }

    /// Averages all further answers over a round footprint of standard deviation `footprint` of (u, v). Only tables do.
    pub fn average_over(&mut self, footprint: f64) {
        self.footprint = footprint;
    }

    /// Returns f·cos θ_i \[sr⁻¹\] of every query, in order: the value at the wavelength in the first component, or the
    /// XYZ of the colour.
    ///
    /// # Errors
    /// Fails if the device is lost, or if a source of colours is asked for a single wavelength.
    pub fn cosine_weighted(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        self.pass.ask(&self.source, queries, self.footprint)
    }

    /// Returns the same of one period of a grating, without the periodic factor.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub(super) fn of_one_period(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        self.pass.submit(&self.source, queries, 0.0)
    }
}

/// Evaluates queries of a source that is owned elsewhere.
pub struct QueryPass {
    commands: Commands,
    pipeline: Pipeline,
    descriptors: Descriptors,
    queries: Buffer,
    answers: Buffer,
}

impl QueryPass {
    /// Makes an evaluator of `source`; it must not be used with another source.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, source: &BoundSource) -> Result<Self> {
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = |one: usize| (AT_ONCE * one) as u64;
        let location = MemoryLocation::CpuToGpu;
        let queries = Buffer::new(device, "queries", bytes(size_of::<QueryBlock>()), storage, location)?;
        let answers = Buffer::new(device, "answers", bytes(16), storage, MemoryLocation::GpuToCpu)?;
        let descriptors = queries_and_answers(device, &queries, &answers)?;
        let code = source.eval().with(source.constants());
        let sets = [&descriptors, &source.descriptors];
        let pipeline = Pipeline::compute(device, code, &sets, size_of::<Asked>() as u32)?;
        let commands = Commands::new(device, "evaluation")?;
        Ok(Self { commands, pipeline, descriptors, queries, answers })
    }

    /// Returns f·cos θ_i as [`Evaluator::cosine_weighted`] does, averaged over a round footprint.
    ///
    /// # Errors
    /// Same as [`Evaluator::cosine_weighted`].
    pub fn ask(&mut self, source: &BoundSource, queries: &[Query], footprint: f64) -> Result<Vec<DVec3>> {
        if !source.spectral && queries.iter().any(|query| query.wavelength.is_some()) {
            return Err(Error::bug("a source of colours alone is asked for a single wavelength"));
        }
        self.submit(source, queries, footprint)
    }

    /// Evaluates `queries` without checking the wavelengths.
    fn submit(&mut self, source: &BoundSource, queries: &[Query], footprint: f64) -> Result<Vec<DVec3>> {
        let mut all = Vec::with_capacity(queries.len());
        for some in queries.chunks(AT_ONCE) {
            let blocks: Vec<QueryBlock> = some.iter().map(block).collect();
            self.queries.write(bytemuck::cast_slice(&blocks))?;
            let mut sums = vec![DVec3::ZERO; some.len()];
            for part in Part::each(source.iterations.parts_of_pair()) {
                let asked = Asked { part, queries: some.len() as u32, footprint: footprint as f32 };
                self.commands.run(|record| {
                    record.bind(&self.pipeline, &[&self.descriptors, &source.descriptors]);
                    record.push(&self.pipeline, bytemuck::bytes_of(&asked));
                    record.dispatch(some.len().div_ceil(GROUP) as u32);
                    record.memory(Access::ComputeWrite, Access::HostRead);
                    Ok(())
                })?;
                let answers: Vec<[f32; 4]> =
                    bytemuck::pod_collect_to_vec(&self.answers.bytes()?[..some.len() * 16]);
                for (sum, [x, y, z, _]) in sums.iter_mut().zip(answers) {
                    *sum += DVec3::new(x.into(), y.into(), z.into());
                }
            }
            all.extend(sums);
        }
        Ok(all)
    }
}

fn block(query: &Query) -> QueryBlock {
    let wavenumber = query.wavelength.map_or(0.0, |x| 1.0 / x) as f32;
    QueryBlock {
        light: query.pair.light.as_vec3().extend(wavenumber).to_array(),
        view: query.pair.view.as_vec3().extend(0.0).to_array(),
    }
}
