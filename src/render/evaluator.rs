//! Answers to single directions, by the same optics that frames shade with.

use super::interface::{CopiesBlock, QueryBlock, binding};
use super::pigment::Pigment;
use super::resources::{Optics, Reads, Resources};
use super::shader;
use super::shading::Shading;
use crate::error::{Error, Result};
use crate::optics::geometry::Pair;
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::pipeline::Pipeline;
use ash::vk;
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Queries of one submission: a software device answers as many in a few seconds.
const AT_ONCE: usize = 16_384;
/// `local_size_x` of `eval.comp`.
const GROUP: usize = 64;

/// What is asked of a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// The directions.
    pub pair: Pair,
    /// Wavelength \[µm\]; `None` asks for the colour.
    pub wavelength: Option<f64>,
}

/// Evaluates queries on the device.
pub struct Evaluator {
    asker: Asker,
    resources: Resources,
}

impl Evaluator {
    /// Uploads `optics` and the small tables for `shading`. A colour table answers in colours only.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new<'a>(device: &Arc<Device>, optics: impl Into<Optics<'a>>, shading: &Shading) -> Result<Self> {
        let resources = Resources::new(device, optics, shading, &Pigment::white())?;
        Ok(Self { asker: Asker::new(device, &resources)?, resources })
    }

    /// f·cos θ_i \[sr⁻¹\] of every query, in order: at a wavelength in the first component, as XYZ otherwise.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn cosine_weighted(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        self.asker.ask(&self.resources, queries)
    }
}

/// Asks queries of resources that someone else holds.
pub struct Asker {
    commands: Commands,
    pipeline: Pipeline,
    queries: Buffer,
    answers: Buffer,
}

impl Asker {
    /// For `resources`, whose set the device must not be using, and for no others.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, resources: &Resources) -> Result<Self> {
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = |one: usize| (AT_ONCE * one) as u64;
        let queries = Buffer::new(
            device,
            "queries",
            bytes(size_of::<QueryBlock>()),
            storage,
            MemoryLocation::CpuToGpu,
        )?;
        let answers = Buffer::new(device, "answers", bytes(16), storage, MemoryLocation::GpuToCpu)?;
        resources.descriptors.buffer(binding::QUERIES, &queries);
        resources.descriptors.buffer(binding::ANSWERS, &answers);
        let (code, push_bytes) = match (resources.reads, &resources.copies) {
            (Reads::Layers, None) => (shader!("eval.comp"), size_of::<u32>()),
            (Reads::Layers, Some(_)) => (shader!("repeats_eval.comp"), size_of::<CopiesBlock>()),
            (Reads::Table, _) => (shader!("table_eval.comp"), size_of::<u32>()),
        };
        let code = code.with(&resources.specialization);
        let pipeline = Pipeline::compute(device, code, &resources.descriptors, push_bytes as u32)?;
        Ok(Self { commands: Commands::new(device, "evaluation")?, pipeline, queries, answers })
    }

    /// As [`Evaluator::cosine_weighted`].
    ///
    /// # Errors
    /// Where the device is lost, and where single wavelengths are asked of layers that hold lines, or through repeats.
    pub fn ask(&mut self, resources: &Resources, queries: &[Query]) -> Result<Vec<DVec3>> {
        let colours_alone = resources.combs.sliding.is_some() || resources.copies.is_some();
        if colours_alone && queries.iter().any(|query| query.wavelength.is_some()) {
            // The plane of layers with lines ends where the lines begin.
            return Err(Error::failed(
                "layers for colours alone are asked for a single wavelength",
                "report this as a bug of diffract",
            ));
        }
        let mut all = Vec::with_capacity(queries.len());
        for part in queries.chunks(AT_ONCE) {
            let blocks: Vec<QueryBlock> = part.iter().map(block).collect();
            self.queries.write(bytemuck::cast_slice(&blocks))?;
            self.commands.run(|record| {
                record.bind(&self.pipeline, &resources.descriptors);
                let count = part.len() as u32;
                match resources.copies {
                    Some(copies) => {
                        let copies = CopiesBlock { queries: count, ..copies };
                        record.push(&self.pipeline, bytemuck::bytes_of(&copies));
                    }
                    None => record.push(&self.pipeline, &count.to_ne_bytes()),
                }
                record.dispatch(part.len().div_ceil(GROUP) as u32);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })?;
            let answers: Vec<[f32; 4]> =
                bytemuck::pod_collect_to_vec(&self.answers.bytes()?[..part.len() * 16]);
            all.extend(answers.into_iter().map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into())));
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
