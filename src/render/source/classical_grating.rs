//! Classical shader of a grating of one period, as a baseline. Its twin is `shaders/source_classical_grating.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::surface_factor::{FIRST, MediumBlock, SurfaceFactor};
use super::{SourceSummary, stages};
use crate::error::Result;
use crate::settings::Optics;
use crate::vk::device::Device;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// A grating of one period. It has no data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClassicalGrating {
    /// Direction of the period: a unit vector in the tangent plane.
    pub axis: [f64; 2],
    /// The period \[µm\].
    pub period: f64,
    /// Radiance of the first order under a light of irradiance 1.
    pub strength: f64,
}

/// The `ClassicalGrating` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct ClassicalGratingBlock {
    period: f32,
    strength: f32,
    axis: [f32; 2],
    medium: MediumBlock,
}

impl ClassicalGrating {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        let stages = stages!("classical_grating");
        let kinds = [Kind::UNIFORM_BUFFER];
        let factor = SurfaceFactor::without_spectrum(&optics.reflectance);
        let mut bound =
            BoundSource::new(device, "classical grating set", &kinds, stages, Vec::new(), &factor)?;
        bound.spectral = false;
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let factor = SurfaceFactor::without_spectrum(&optics.reflectance);
        let block = ClassicalGratingBlock {
            period: self.period as f32,
            strength: self.strength as f32,
            axis: self.axis.map(|x| x as f32),
            medium: factor.medium(),
        };
        let block = uniform(device, "classical grating block", &block)?;
        bound.replace(device, Vec::new(), vec![(FIRST, block)], &factor)
    }

    pub(super) fn summary(&self) -> SourceSummary {
        let (method, kernel) = ("classical grating", "none".to_owned());
        SourceSummary { method, basis: None, terms: 0, layers: 0, kernel }
    }
}
