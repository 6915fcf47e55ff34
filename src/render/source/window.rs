//! Spectra through one Gaussian window, summed over wavelengths. Its twin is `shaders/source_window.glsl`.

use super::bound::{BoundSource, Kind};
use super::cost::{Cost, LitPixel};
use super::part::Iterations;
use super::surface_factor::SurfaceFactor;
use super::{SourceSummary, spectra, stages};
use crate::brdf::energy_map::EnergyMap;
use crate::error::Result;
use crate::render::directions::Directions;
use crate::render::tables::WavelengthTexture;
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;
use crate::vk::buffer::Buffer;
use crate::vk::device::Device;
use ash::vk;
use std::sync::Arc;

/// Spectra through a window.
#[derive(Clone, Debug)]
pub struct Window {
    /// The spectra.
    pub layers: Arc<Layers>,
    /// Limit of energy, if the theory has one.
    pub energy: Option<Arc<EnergyMap>>,
}

/// Binding number of set 1, after those of [`spectra::binding`].
const BINS: u32 = 6;

impl Window {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        let layers = &self.layers;
        let kinds = [spectra::KINDS.as_slice(), &[Kind::STORAGE_BUFFER]].concat();
        let constants = spectra::constants(layers);
        let factor = SurfaceFactor::of_sums(&optics.reflectance, self.energy.as_ref());
        let mut bound =
            BoundSource::new(device, "window set", &kinds, stages!("window"), constants, &factor)?;
        spectra::upload(device, &mut bound, layers)?;
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let layers = &self.layers;
        let wavelengths = WavelengthTexture::of(layers, optics);
        bound.iterations = Iterations::new(wavelengths.most(), layers.pairs());
        let of = (&**layers, layers.sigma);
        let factor = SurfaceFactor::of_sums(&optics.reflectance, self.energy.as_ref());
        let (tables, mut buffers) = spectra::settings(device, of, &wavelengths.nodes, factor.medium())?;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        buffers.push((
            BINS,
            Buffer::with_data(
                device,
                "wavelengths of directions",
                storage,
                bytemuck::cast_slice(&wavelengths.bins),
            )?,
        ));
        bound.replace(device, tables, buffers, &factor)
    }

    pub(super) fn summary(&self, optics: &Optics) -> SourceSummary {
        let layers = &self.layers;
        let kernel = format!("{} kernel", layers.interpolation.name());
        let (terms, basis) = (layers.terms, Some(optics.basis));
        SourceSummary { method: "spectral", basis, terms, layers: layers.pairs(), kernel }
    }

    pub(super) fn cost(&self, optics: &Optics, directions: &[Directions]) -> Cost {
        let (layers, wavelengths) = (&self.layers, WavelengthTexture::of(&self.layers, optics));
        let per_read = layers.interpolation.reads();
        Cost::counted(directions, |LitPixel { pair, .. }| {
            let nodes =
                wavelengths.nodes_at(pair.uvw().truncate().length()).iter().map(|node| f64::from(node[3]));
            spectra::counted(layers, pair, per_read, nodes)
        })
    }
}
