//! Sum over 3 × 3 bins of a Fourier series, as in the thesis, as a baseline. Its twin is `shaders/source_thesis.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::cost::Cost;
use super::part::Iterations;
use super::spectra::{edge, format, numbers};
use super::surface_factor::{MediumBlock, SurfaceFactor};
use super::{SourceSummary, stages};
use crate::error::Result;
use crate::render::directions::Directions;
use crate::render::tables::WavelengthTexture;
use crate::render::upload;
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;
use crate::spectra::amplitude::expansion::Basis;
use crate::spectra::amplitude::thesis::{TAPS, WAVELENGTHS};
use crate::vk::device::Device;
use crate::vk::pipeline::Constant;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Result of [`crate::spectra::amplitude::thesis`].
#[derive(Clone, Debug)]
pub struct Thesis {
    /// Fourier series of the powers of the height.
    pub layers: Arc<Layers>,
    /// Half the range of heights \[µm\].
    pub half_range: f64,
}

/// Binding numbers of set 1.
mod binding {
    pub const BLOCK: u32 = 2;
    pub const SERIES: u32 = 3;
    pub const NODES: u32 = 4;
}

const KINDS: [Kind; 3] = [Kind::UNIFORM_BUFFER, Kind::COMBINED_IMAGE_SAMPLER, Kind::COMBINED_IMAGE_SAMPLER];

/// The `Thesis` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct ThesisBlock {
    sigma: f32,
    half_range: f32,
    wavelengths: i32,
    gap: f32,
    bins_per_frequency: [f32; 2],
    origin: [f32; 2],
    band: [f32; 2],
    padding: [f32; 2],
    medium: MediumBlock,
}

impl Thesis {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        const PAIRS: u32 = 10;
        let layers = &self.layers;
        let constants = vec![Constant::new(PAIRS, layers.pairs() as u32)];
        let factor = SurfaceFactor::of_sums(&optics.reflectance, None);
        let mut bound =
            BoundSource::new(device, "thesis set", &KINDS, stages!("thesis"), constants, &factor)?;
        let (count, texels) = (Some(layers.pairs() as u32), &layers.texels);
        let image =
            upload::texture(device, "Fourier series", format(texels), layers.size, count, texels.bytes())?;
        bound.data(binding::SERIES, image, edge(device)?);
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let pair = |v: [f64; 2]| v.map(|x| x as f32);
        let layers = &self.layers;
        let factor = SurfaceFactor::of_sums(&optics.reflectance, None);
        let block = ThesisBlock {
            sigma: layers.sigma as f32 * layers.texels.unit(),
            half_range: self.half_range as f32,
            wavelengths: WAVELENGTHS as i32,
            bins_per_frequency: pair(layers.length),
            // The shader truncates.
            origin: layers.origin.map(|n| n as f32 + 0.5),
            band: pair(layers.band),
            medium: factor.medium(),
            ..ThesisBlock::default()
        };
        bound.iterations = Iterations::new(WAVELENGTHS, self.layers.pairs());
        let wavelengths = WavelengthTexture::even(&optics.illuminant, WAVELENGTHS);
        let nodes = numbers(device, "nodes", &wavelengths.nodes)?;
        let block = uniform(device, "thesis block", &block)?;
        bound.replace(device, vec![(binding::NODES, nodes)], vec![(binding::BLOCK, block)], &factor)
    }

    pub(super) fn summary(&self) -> SourceSummary {
        let (terms, kernel) = (self.layers.terms, "3 x 3 bins".to_owned());
        SourceSummary { method: "thesis", basis: Some(Basis::Taylor), terms, layers: terms, kernel }
    }

    pub(super) fn cost(&self, directions: &[Directions]) -> Cost {
        // Two terms share a texel.
        Cost::counted(directions, |_| (WAVELENGTHS, WAVELENGTHS * self.layers.pairs() * TAPS))
    }
}
