//! Colour table: the sum over the spectrum is precomputed, and shading reads it. Its twin is
//! `shaders/source_table.glsl`; its CPU version is [`crate::table::TableReader`].

use super::bound::{BoundSource, Kind, uniform};
use super::cost::Cost;
use super::surface_factor::{MediumBlock, SurfaceFactor};
use super::{Extent, SourceSummary, stages};
use crate::brdf::energy_map::EnergyMap;
use crate::error::Result;
use crate::render::directions::Directions;
use crate::render::upload;
use crate::settings::Optics;
use crate::table::{ColorTable, SPECULAR_SAMPLES, TableReader};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::Constant;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// A colour table.
#[derive(Clone, Debug)]
pub struct Table {
    /// The table.
    pub table: Arc<ColorTable>,
    /// Limit of energy, if the theory has one.
    pub energy: Option<Arc<EnergyMap>>,
}

/// Binding numbers of set 1.
mod binding {
    pub const BLOCK: u32 = 2;
    pub const COLOURS: u32 = 3;
    pub const SPECULAR: u32 = 4;
    pub const BASIS: u32 = 5;
}

const KINDS: [Kind; 4] = [
    Kind::UNIFORM_BUFFER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
];

/// The `Table` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TableBlock {
    /// Texture coordinate per unit of u.
    pub texture_per_uv: f32,
    /// Variance of u due to coherence.
    pub coherence: f32,
    /// BRDF value of a stored 1 \[sr⁻¹\].
    pub unit: f32,
    /// Variance of u of the finest level.
    pub finest: f32,
    /// Reciprocal of the variance added by level 1.
    pub per_growth: f32,
    /// Pieces of the range of |w|.
    pub pieces: f32,
    /// Number of the coarsest level.
    pub last_level: f32,
    /// std140 aligns structures to 16 bytes.
    pub padding: f32,
    /// Refractive indices of the surface.
    pub medium: MediumBlock,
}

impl Table {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        /// Texels read per direction and tap.
        const TEXELS: u32 = 11;
        let basis = &self.table.header.basis;
        /// Bands of the specular order.
        const BANDS: u32 = 16;
        let bands = self.table.header.specular.variances.len() as u32;
        let constants = vec![Constant::new(TEXELS, basis.texels() as u32), Constant::new(BANDS, bands)];
        let factor = self.factor(optics);
        let mut bound = BoundSource::new(device, "table set", &KINDS, stages!("table"), constants, &factor)?;
        bound.spectral = false;
        let header = &self.table.header;
        bound.specular_spread = optics.specular_spread().map(|spread| spread as f32);
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let layers = header.layers() as u32;
        let description = Description {
            name: "colour table",
            format: vk::Format::R16G16B16A16_SFLOAT,
            size: [header.grid.side as u32; 2],
            layers,
            array: true,
            usage,
        };
        let image = Image::with_levels(device, &description, header.grid.mips() as u32)?;
        let mips: Vec<&[u8]> = self.table.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
        upload::levels(device, &image, layers, &mips)?;
        bound.data(binding::COLOURS, image, Sampler::levels_that_end(device, "colour table sampler")?);
        let weights = header.specular_rows();
        let format = vk::Format::R32G32B32A32_SFLOAT;
        let size = [SPECULAR_SAMPLES, weights.len() / SPECULAR_SAMPLES];
        let image =
            upload::texture(device, "specular order", format, size, None, bytemuck::cast_slice(&weights))?;
        let edge = Sampler::linear(device, "specular sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        bound.data(binding::SPECULAR, image, edge);
        let (size, cubics) = ([3 * basis.components, basis.pieces], bytemuck::cast_slice(&basis.cubics));
        let image = upload::texture(device, "basis of colours", format, size, None, cubics)?;
        let edge = Sampler::linear(device, "basis sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        bound.data(binding::BASIS, image, edge);
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    /// Uploads the block; the reflectance is the only part that depends on more than the table.
    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let header = &self.table.header;
        let (grid, factor) = (&header.grid, self.factor(optics));
        let block = TableBlock {
            texture_per_uv: (0.5 / grid.extent) as f32,
            coherence: header.coherence_blur as f32,
            unit: header.unit as f32,
            finest: grid.finest.powi(2) as f32,
            per_growth: grid.growth.powi(-2) as f32,
            pieces: header.basis.pieces as f32,
            last_level: (grid.levels - 1) as f32,
            padding: 0.0,
            medium: factor.medium(),
        };
        let block = uniform(device, "table block", &block)?;
        bound.replace(device, Vec::new(), vec![(binding::BLOCK, block)], &factor)
    }

    /// Returns the factor in front of the table.
    fn factor(&self, optics: &Optics) -> SurfaceFactor {
        let (header, reflectance, energy) = (&self.table.header, &optics.reflectance, self.energy.as_ref());
        match header.indices {
            Some(indices) => SurfaceFactor::of_indices(indices, reflectance, energy),
            None if header.mean_reflectance.is_some() => SurfaceFactor::held(reflectance, energy),
            None => SurfaceFactor::of_sums(reflectance, energy),
        }
    }

    pub(super) fn extent(&self) -> Extent {
        let header = &self.table.header;
        Extent { layers: header.layers(), size: [header.grid.side; 2], bytes: self.table.bytes() as u64 }
    }

    pub(super) fn summary(&self) -> SourceSummary {
        let basis = &self.table.header.basis;
        SourceSummary {
            method: "table",
            basis: None,
            terms: basis.components,
            layers: basis.texels(),
            kernel: "linear".to_owned(),
        }
    }

    /// Counts the samples along the footprints of `directions`.
    pub(super) fn cost(&self, directions: &[Directions]) -> Cost {
        let reader = TableReader::new(Arc::clone(&self.table));
        let texels = self.table.header.basis.texels();
        Cost::counted(directions, |pixel| (0, texels * reader.taps(&pixel.footprint).1.count()))
    }
}
