//! Reflectance law of the surface, and the table of a reflectance that depends on the wavelength. Its twins are
//! `shaders/brdf.glsl` and `shaders/reflectance.glsl`.

use crate::error::Result;
use crate::optics::reflectance::{COLUMNS, ROWS, Reflectance};
use crate::render::upload;
use crate::settings::Optics;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::Constant;
use ash::vk;
use std::sync::Arc;

/// Values of the specialisation constant.
#[derive(Clone, Copy)]
enum Law {
    Spectral = 0,
    Fresnel = 1,
    Schlick = 2,
}

impl Law {
    fn constant(self) -> Constant {
        const REFLECTANCE_LAW: u32 = 31;
        Constant::new(REFLECTANCE_LAW, self as u32)
    }
}

/// Returns the specialisation constant of the law.
pub(super) fn constant(optics: &Optics) -> Constant {
    if optics.reflectance.is_spectral() { Law::Spectral.constant() } else { without_spectrum(optics) }
}

/// Returns the specialisation constant for a source that holds R, whichever the law.
pub(super) fn held() -> Constant {
    Law::Spectral.constant()
}

/// Returns the constant for a source that does not apply a spectral law inside sums over wavelengths.
pub(super) fn without_spectrum(optics: &Optics) -> Constant {
    match optics.reflectance {
        Reflectance::Schlick(_) => Law::Schlick.constant(),
        Reflectance::Fresnel { .. } => Law::Fresnel.constant(),
    }
}

/// Makes the texture of R of `optics`; a single 1 if R does not depend on the wavelength and is applied per pair.
pub(super) fn texture(device: &Arc<Device>, optics: &Optics) -> Result<Image> {
    let reflectance = &optics.reflectance;
    let (size, values) = match reflectance.is_spectral() {
        true => ([COLUMNS, ROWS], reflectance.table()),
        false => ([1, 1], vec![1.0]),
    };
    let texels: Vec<[f32; 4]> = values.into_iter().map(|r| [r, 0.0, 0.0, 0.0]).collect();
    let format = vk::Format::R32G32B32A32_SFLOAT;
    upload::texture(device, "reflectances", format, size, None, bytemuck::cast_slice(&texels))
}
