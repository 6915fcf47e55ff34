//! Classical shader of a grating of one period, as a baseline. Its twin is `shaders/source_classical_grating.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::{SourceSummary, reflectance, stages};
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
    index: f32,
    period: f32,
    strength: f32,
    gap: f32,
    axis: [f32; 2],
    padding: [f32; 2],
}

impl ClassicalGrating {
    pub(super) fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        let stages = stages!("classical_grating");
        let kinds = [Kind::UNIFORM_BUFFER];
        let of = &optics.reflectance;
        let constants = vec![reflectance::without_spectrum(optics)];
        let mut bound = BoundSource::new(device, "classical grating set", &kinds, stages, constants, of)?;
        bound.spectral = false;
        self.set(device, &mut bound, optics)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        let block = ClassicalGratingBlock {
            index: optics.reflectance.luminous_index() as f32,
            period: self.period as f32,
            strength: self.strength as f32,
            axis: self.axis.map(|x| x as f32),
            ..ClassicalGratingBlock::default()
        };
        bound.replace(device, Vec::new(), vec![(0, uniform(device, "classical grating block", &block)?)])
    }

    pub(super) fn summary(&self) -> SourceSummary {
        let (method, kernel) = ("classical grating", "none".to_owned());
        SourceSummary { method, basis: None, terms: 0, layers: 0, kernel }
    }
}
