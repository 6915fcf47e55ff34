//! The mean over coherence areas, from power spectra: wavelengths are summed for every pixel. Its twin is `shaders/source_mean.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::cost::{Cost, LitPixel};
use super::part::Iterations;
use super::spectra::{kernel_constants, numbers};
use super::{Extent, SourceSummary, reflectance, stages};
use crate::error::Result;
use crate::filter::{self, Levels, Tap, Taps};
use crate::optics::spectrum::{BLUE, MIDDLE};
use crate::render::directions::Directions;
use crate::render::shading::Shading;
use crate::render::tables::Combs;
use crate::render::upload;
use crate::spectra::power::chebyshev::polynomials;
use crate::spectra::power::texture::level_of_ratio;
use crate::spectra::power::{Blur, PowerSpectra};
use crate::vk::buffer::Buffer;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::Constant;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::f64::consts::PI;
use std::sync::Arc;

/// Power spectra.
#[derive(Clone, Debug)]
pub struct Mean {
    /// The spectra.
    pub spectra: Arc<PowerSpectra>,
}

/// Binding numbers of set 1.
mod binding {
    pub const BLOCK: u32 = 0;
    pub const POWERS: u32 = 1;
    pub const SPECULAR: u32 = 2;
    pub const NODES: u32 = 3;
    pub const COMBS: u32 = 4;
    pub const REFLECTANCES: u32 = 5;
}

const KINDS: [Kind; 6] = [
    Kind::UNIFORM_BUFFER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::STORAGE_BUFFER,
    Kind::COMBINED_IMAGE_SAMPLER,
];

/// Samples of the specular order's power over z: between two, the phase of the farthest heights of 1 µm turns by a thirtieth of a radian.
const SPECULAR_SAMPLES: usize = 1024;

/// The `Mean` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MeanBlock {
    /// Texels of the finest level.
    pub texels: [f32; 2],
    /// Range of frequencies that the texture covers \[µm⁻¹\].
    pub range: [f32; 2],
    /// Largest |f_x|, |f_y| that the samples hold \[µm⁻¹\].
    pub band: [f32; 2],
    /// R₀ of Schlick.
    pub normal_reflectance: f32,
    /// 2 over the largest z \[µm\].
    pub x_per_z: f32,
    /// What a stored 1 stands for.
    pub unit: f32,
    /// Variance of an order's blur over that of the finest level.
    pub orders: f32,
    /// Variance of the finest level's blur \[µm⁻²\].
    pub finest: f32,
    /// Variance of the specular order's blur \[µm⁻²\].
    pub specular: f32,
    /// Number of the coarsest level.
    pub last_level: f32,
    /// |(u, v)| of a comb's bin per unit of |(u, v)| over the blur \[µm⁻¹\].
    pub rays: f32,
    /// Squared wavenumber in the middle of the spectrum \[µm⁻²\].
    pub middle: f32,
    /// Least variance of u that the finest level averages over: of blue light.
    pub blur: f32,
}

impl Mean {
    pub(super) fn bind(&self, device: &Arc<Device>, shading: &Shading) -> Result<BoundSource> {
        const LAYERS: u32 = 11;
        let header = &self.spectra.header;
        let layers = header.terms.div_ceil(4) as u32;
        let mut constants = kernel_constants(&header.grid.interpolation());
        constants.push(Constant::new(LAYERS, layers));
        constants.push(reflectance::constant(shading));
        let of = &shading.reflectance;
        let mut bound = BoundSource::new(device, "mean set", &KINDS, stages!("mean"), constants, of)?;
        bound.reads_footprints = true;
        bound.specular_spread = shading.specular_spread().map(|spread| spread as f32);
        let description = Description {
            name: "power spectra",
            format: vk::Format::R16G16B16A16_SFLOAT,
            size: header.grid.size.map(|n| n as u32),
            layers,
            array: true,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        };
        let image = Image::with_levels(device, &description, header.grid.levels as u32)?;
        let levels: Vec<&[u8]> =
            self.spectra.levels.iter().map(|level| bytemuck::cast_slice(level)).collect();
        upload::levels(device, &image, layers, &levels)?;
        bound.data(binding::POWERS, image, Sampler::levels(device, "power spectra sampler")?);
        let specular = self.specular();
        let format = vk::Format::R32G32B32A32_SFLOAT;
        let size = [specular.len(), 1];
        let image =
            upload::texture(device, "specular order", format, size, None, bytemuck::cast_slice(&specular))?;
        let edge = Sampler::linear(device, "specular sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        bound.data(binding::SPECULAR, image, edge);
        self.set(device, &mut bound, shading)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, shading: &Shading) -> Result<()> {
        let header = &self.spectra.header;
        let combs = self.combs(shading);
        // Beside those of the taps, the specular order is a sum of its own.
        bound.iterations = Iterations::new(combs.most(), 0, filter::MOST_TAPS + 1);
        let pair = |v: [f64; 2]| v.map(|x| x as f32);
        let mean = |v: [f64; 2]| 0.5 * (v[0] + v[1]);
        let (finest, orders) = (mean(header.grid.blur.variance), mean(header.orders_blur.variance));
        let block = MeanBlock {
            texels: header.grid.size.map(|n| n as f32),
            range: pair(header.grid.range),
            band: pair(header.band),
            normal_reflectance: shading.reflectance.normal_factor() as f32,
            x_per_z: (2.0 / header.z_max) as f32,
            unit: header.unit as f32,
            orders: (orders / finest) as f32,
            finest: finest as f32,
            specular: Blur::of_coherence(header.sigma).variance[0] as f32,
            last_level: (header.grid.levels - 1) as f32,
            rays: finest.sqrt() as f32,
            middle: MIDDLE.powi(-2) as f32,
            blur: (BLUE * BLUE * finest) as f32,
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bins = Buffer::with_data(device, "combs", storage, bytemuck::cast_slice(&combs.bins))?;
        let tables = vec![
            (binding::NODES, numbers(device, "nodes", &combs.nodes)?),
            (binding::REFLECTANCES, reflectance::texture(device, shading)?),
        ];
        bound.replace(
            device,
            tables,
            vec![(binding::BLOCK, uniform(device, "mean block", &block)?), (binding::COMBS, bins)],
        )
    }

    /// The wavelengths of each |(u, v)| at the blur of the finest level.
    fn combs(&self, shading: &Shading) -> Combs {
        let [x, y] = self.spectra.header.grid.blur.variance;
        // The blur of a coherence window of this standard deviation.
        let sigma = 1.0 / (PI * (4.0 * (x + y)).sqrt());
        Combs::new(&shading.illuminant, sigma, shading.quadrature(), shading.wavelengths)
    }

    /// |c_0|² over z, a texel a sample.
    fn specular(&self) -> Vec<[f32; 4]> {
        let series = &self.spectra.header.specular;
        let mut t = vec![0.0; series.len()];
        (0..SPECULAR_SAMPLES)
            .map(|i| {
                polynomials(2.0 * i as f64 / (SPECULAR_SAMPLES - 1) as f64 - 1.0, &mut t);
                let power: f64 = series.iter().zip(&t).map(|(a, t)| a * t).sum();
                [power.max(0.0) as f32, 0.0, 0.0, 0.0]
            })
            .collect()
    }

    pub(super) fn extent(&self) -> Extent {
        let header = &self.spectra.header;
        Extent {
            layers: header.terms.div_ceil(4),
            size: header.grid.size,
            bytes: header.grid.bytes(header.terms) as u64,
        }
    }

    pub(super) fn summary(&self) -> SourceSummary {
        let header = &self.spectra.header;
        SourceSummary {
            method: "spectral",
            basis: None,
            terms: header.terms,
            layers: header.terms.div_ceil(4),
            kernel: format!("{} kernel", header.grid.kernel.name()),
        }
    }

    /// Samples of the wavelengths of `directions`.
    pub(super) fn cost(&self, shading: &Shading, directions: &[Directions]) -> Cost {
        let header = &self.spectra.header;
        let combs = self.combs(shading);
        let per_wavelength = header.terms.div_ceil(4) * header.grid.interpolation().reads();
        let mean = |v: [f64; 2]| 0.5 * (v[0] + v[1]);
        let (finest, orders) = (mean(header.grid.blur.variance), mean(header.orders_blur.variance));
        let coherence = BLUE * BLUE * finest;
        let coarsest = MIDDLE.powi(2) * (finest * 4f64.powi(header.grid.levels as i32 - 1) - orders);
        Cost::counted(directions, |LitPixel { pair, around }| {
            let [_, shorter] = around.axes();
            let own = shorter.max(filter::least_own(around, coherence));
            let read = coarsest.clamp(0.0, own);
            let taps = Taps::new(around, own, Levels { read, next: None, blur: coherence });
            let toward = -pair.uvw().truncate();
            let rays = (finest / (orders + read / MIDDLE.powi(2))).sqrt();
            let reads_at = |node: &[f32; 4]| {
                let ratio = (orders + f64::from(node[3]).powi(2) * own) / finest;
                // One, where the blur is that of a level.
                if level_of_ratio(ratio, header.grid.levels).fract() > 0.0 { 2 } else { 1 }
            };
            let of_tap = |tap: Tap| {
                let nodes = combs.nodes_at((toward + tap.place).length() * rays);
                (nodes.len(), nodes.iter().map(reads_at).sum::<usize>() * per_wavelength)
            };
            taps.each().map(of_tap).fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
        })
    }
}
