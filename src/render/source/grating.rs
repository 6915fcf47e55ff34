//! Finite grating of n × m copies of the patch: spectra of one copy times the periodic factors. Its twin is
//! `shaders/source_grating.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::cost::{Cost, LitPixel};
use super::part::Iterations;
use super::surface_factor::SurfaceFactor;
use super::{SourceSummary, spectra, stages};
use crate::brdf::energy_map::EnergyMap;
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::orders::{ColourFunctions, Repeats};
use crate::render::directions::Directions;
use crate::render::tables::WavelengthTexture;
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;
use crate::vk::device::Device;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::sync::Arc;

/// One period of a surface and its number of copies.
#[derive(Clone, Debug)]
pub struct Grating {
    /// Spectra of one period.
    pub layers: Arc<Layers>,
    /// Number of copies and their period.
    pub repeats: Repeats,
    /// Limit of energy, if the theory has one.
    pub energy: Option<Arc<EnergyMap>>,
}

/// Binding number of set 1, after those of [`spectra::binding`].
const COPIES: u32 = 6;

/// The `Grating` block of the source (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CopiesBlock {
    /// Copies of the patch along x and y.
    pub count: [f32; 2],
    /// T_x, T_y \[µm\].
    pub period: [f32; 2],
    /// Lag beyond which the colour functions are negligible \[µm\].
    pub colour_lag: f32,
    /// Relative error of the sum over wavelengths.
    pub tolerance: f32,
    /// std140 rounds a block up to 16 bytes.
    pub padding: [f32; 2],
}

impl CopiesBlock {
    /// Makes the block of `repeats` for these colour functions.
    pub fn new(repeats: &Repeats, colours: &ColourFunctions, tolerance: f64) -> Self {
        Self {
            count: repeats.copies.map(|n| n as f32),
            period: repeats.period.map(|x| x as f32),
            colour_lag: colours.lag as f32,
            tolerance: tolerance as f32,
            padding: [0.0; 2],
        }
    }
}

impl Grating {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        let kinds = [spectra::KINDS.as_slice(), &[Kind::UNIFORM_BUFFER]].concat();
        let constants = spectra::constants(&self.layers);
        let factor = SurfaceFactor::of_sums(&optics.reflectance, self.energy.as_ref());
        let mut bound =
            BoundSource::new(device, "grating set", &kinds, stages!("grating"), constants, &factor)?;
        // The periodic factor of single wavelengths is multiplied in f64.
        bound.spectral = false;
        spectra::upload(device, &mut bound, &self.layers)?;
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let colours = self.colours(optics);
        let of = (&*self.layers, self.repeats.sigma());
        let factor = SurfaceFactor::of_sums(&optics.reflectance, self.energy.as_ref());
        let most = self.repeats.most_wavelengths(colours.lag).min(self.repeats.limit());
        bound.iterations = Iterations::new(most.ceil() as usize, self.layers.pairs());
        let nodes = WavelengthTexture::densities(&colours);
        let (tables, mut buffers) = spectra::settings(device, of, &nodes, factor.medium())?;
        let block = CopiesBlock::new(&self.repeats, &colours, optics.budget().window.wavelengths);
        buffers.push((COPIES, uniform(device, "grating block", &block)?));
        bound.replace(device, tables, buffers, &factor)
    }

    /// Returns the colour functions of `optics`.
    fn colours(&self, optics: &Optics) -> ColourFunctions {
        ColourFunctions::new(&optics.illuminant, optics.budget().window.wavelengths)
    }

    pub(super) fn summary(&self, optics: &Optics) -> SourceSummary {
        SourceSummary {
            method: "spectral",
            basis: Some(optics.basis),
            terms: self.layers.terms,
            layers: self.layers.pairs(),
            kernel: format!("{} kernel", self.layers.interpolation.name()),
        }
    }

    pub(super) fn cost(&self, optics: &Optics, directions: &[Directions]) -> Cost {
        let (colours, tolerance) = (self.colours(optics), optics.budget().window.wavelengths);
        let per_read = self.layers.interpolation.reads();
        Cost::counted(directions, |LitPixel { pair, .. }| {
            let wavelengths = self.repeats.wavelengths(pair.uvw().truncate(), &colours, tolerance);
            spectra::counted(&self.layers, pair, per_read, wavelengths.wavenumbers.into_iter())
        })
    }

    pub(super) fn has_limits(&self, optics: &Optics) -> bool {
        self.repeats.most_wavelengths(self.colours(optics).lag) > self.repeats.limit()
    }

    pub(super) fn check(&self, optics: &Optics, directions: &[Directions]) -> Result<()> {
        let (colours, tolerance) = (self.colours(optics), optics.budget().window.wavelengths);
        let uvs = directions.iter().flat_map(|seen| {
            let covered = seen.light.iter().zip(&seen.view).filter(|(_, view)| view[3] != 0.0);
            covered.map(|(light, view)| {
                let vector = |v: &[f32; 4]| Vec3::new(v[0], v[1], v[2]).as_dvec3();
                Pair::new(vector(light), vector(view)).uvw().truncate()
            })
        });
        let most = uvs.map(|uv| self.repeats.count(uv, &colours, tolerance)).fold(0.0, f64::max);
        self.repeats.check(most)
    }
}
