//! Factor in front of the power |P|² on the device: its law, the refractive index, what depends on the wavelength, and
//! the limit of energy. They are the first bindings of set 1 of each source. Its twins are `shaders/brdf.glsl` and
//! `shaders/pair.glsl`.

use crate::brdf::energy_map::EnergyMap;
use crate::error::Result;
use crate::optics::energy::DirectionGrid;
use crate::optics::factor::IndexTriple;
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::{COLUMNS, ROWS, Reflectance};
use crate::optics::theory::Theory;
use crate::render::upload;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::Constant;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// First bindings of set 1 of every source.
pub(super) const BINDINGS: [(u32, vk::DescriptorType); 2] = [
    (REFLECTANCES, vk::DescriptorType::COMBINED_IMAGE_SAMPLER),
    (ENERGY, vk::DescriptorType::COMBINED_IMAGE_SAMPLER),
];
const REFLECTANCES: u32 = 0;
const ENERGY: u32 = 1;
/// First binding of a source's own.
pub(super) const FIRST: u32 = BINDINGS.len() as u32;

/// Law of the factor: values of the specialisation constant `FACTOR_LAW`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Law {
    Spectral = 0,
    Fresnel = 1,
    Schlick = 2,
    SmallSlope = 3,
    SmallSlopeIndices = 4,
    SmallSlopeSpectral = 5,
}

/// Factor of a source.
#[derive(Clone, Debug)]
pub(super) struct SurfaceFactor {
    law: Law,
    indices: IndexTriple,
    polarisation: Polarisation,
    energy: Option<Arc<EnergyMap>>,
    reflectance: Reflectance,
}

impl SurfaceFactor {
    /// Returns the factor of a source whose sums over wavelengths contain what depends on them.
    pub fn of_sums(reflectance: &Reflectance, energy: Option<&Arc<EnergyMap>>) -> Self {
        let law = match (reflectance.theory(), reflectance) {
            (Theory::Stam, r) if r.is_spectral() => Law::Spectral,
            (Theory::SmallSlope, r) if r.is_spectral() => Law::SmallSlopeSpectral,
            (Theory::SmallSlope, _) => Law::SmallSlope,
            (Theory::Stam, Reflectance::Schlick(_)) => Law::Schlick,
            (Theory::Stam, Reflectance::Fresnel { .. }) => Law::Fresnel,
        };
        Self {
            law,
            indices: IndexTriple::of(reflectance),
            polarisation: reflectance.polarisation(),
            energy: energy.cloned(),
            reflectance: reflectance.clone(),
        }
    }

    /// Returns the factor of a source that applies no spectral law inside sums over wavelengths.
    pub fn without_spectrum(reflectance: &Reflectance) -> Self {
        let stam = reflectance.clone().by(Theory::Stam);
        let law = if matches!(stam, Reflectance::Schlick(_)) { Law::Schlick } else { Law::Fresnel };
        let indices =
            IndexTriple { n: [stam.luminous_index(); 3], k: [0.0; 3], polarisation: Polarisation::None };
        Self { law, indices, ..Self::of_sums(&stam, None) }
    }

    /// Returns the factor of a table that holds R by Stam's theory, divided by its mean.
    pub fn held(reflectance: &Reflectance, energy: Option<&Arc<EnergyMap>>) -> Self {
        Self { law: Law::Spectral, ..Self::of_sums(reflectance, energy) }
    }

    /// Returns the factor of a table that holds the ratio of |B|² to that of `indices`.
    pub fn of_indices(
        indices: IndexTriple,
        reflectance: &Reflectance,
        energy: Option<&Arc<EnergyMap>>,
    ) -> Self {
        Self {
            law: Law::SmallSlopeIndices,
            indices,
            polarisation: indices.polarisation,
            ..Self::of_sums(reflectance, energy)
        }
    }

    /// Returns the reflectance at normal incidence by which the pigment is attenuated, if the sums over wavelengths
    /// contain R or the ratio to it.
    pub fn normal_of_pigment(&self) -> Option<f32> {
        let is_held = matches!(self.law, Law::Spectral | Law::SmallSlopeIndices | Law::SmallSlopeSpectral);
        // A baseline applies no spectral law, and its pigment is below the material all the same.
        let is_held = is_held || self.reflectance.is_spectral();
        is_held.then(|| self.reflectance.normal_of_pigment() as f32)
    }

    /// Returns the specialisation constants.
    pub fn constants(&self) -> [Constant; 3] {
        const FACTOR_LAW: u32 = 31;
        const POLARISATION: u32 = 32;
        const LIMITED: u32 = 33;
        [
            Constant::new(FACTOR_LAW, self.law as u32),
            Constant::new(POLARISATION, self.polarisation.number()),
            Constant::new(LIMITED, self.energy.is_some()),
        ]
    }

    /// Makes the images of the bindings, each with its number.
    pub fn images(&self, device: &Arc<Device>) -> Result<[(u32, Image); 2]> {
        Ok([(REFLECTANCES, self.reflectances(device)?), (ENERGY, self.energy(device)?)])
    }

    /// Returns the refractive indices for the source's block.
    pub fn medium(&self) -> MediumBlock {
        MediumBlock::new(&self.indices)
    }

    /// Makes the texture of R, or of n and k; a single 1 if sums over wavelengths contain neither.
    fn reflectances(&self, device: &Arc<Device>) -> Result<Image> {
        let is_spectral = self.reflectance.is_spectral();
        let (size, texels) = match self.law {
            Law::Spectral if is_spectral => {
                let values = self.reflectance.table().into_iter();
                ([COLUMNS, ROWS], values.map(|r| [r, 0.0, 0.0, 0.0]).collect())
            }
            Law::SmallSlopeSpectral => ([1, ROWS], self.reflectance.indices()),
            _ => ([1, 1], vec![[1.0, 0.0, 0.0, 0.0]]),
        };
        texture(device, "reflectances", size, &texels)
    }

    /// Makes the texture of the limit of energy; a single point without one.
    fn energy(&self, device: &Arc<Device>) -> Result<Image> {
        let texel = |[excess, passed]: &[f32; 2]| [*excess, *passed, 0.0, 0.0];
        match &self.energy {
            Some(map) => {
                let texels: Vec<_> = map.points().iter().map(texel).collect();
                texture(device, "energy", [DirectionGrid::SIDE; 2], &texels)
            }
            None => texture(device, "energy", [1, 1], &[[0.0, 1.0, 0.0, 0.0]]),
        }
    }
}

/// Makes a texture of 32-bit floats.
fn texture(device: &Arc<Device>, name: &str, size: [usize; 2], texels: &[[f32; 4]]) -> Result<Image> {
    upload::texture(device, name, vk::Format::R32G32B32A32_SFLOAT, size, None, bytemuck::cast_slice(texels))
}

/// `Medium` at the end of each source's block (std140): n and k that stand for X, Y and Z.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MediumBlock {
    n: [f32; 4],
    k: [f32; 4],
}

impl MediumBlock {
    fn new(indices: &IndexTriple) -> Self {
        let padded = |[x, y, z]: [f64; 3]| [x as f32, y as f32, z as f32, 0.0];
        Self { n: padded(indices.n), k: padded(indices.k) }
    }
}
