//! Plan of the transforms: their frequencies, spacing and memory.

use super::kernel::Interpolation;
use super::settings::LayerSettings;
use super::transform::{PaddedAxis, Samples, Transformer};
use crate::error::{Error, Remedy, Result};
use crate::memory;
use crate::surface::HeightField;

/// Returns the axes of the whole plane for spectra that are read by `interpolation`, checked against the memory limit of `settings` before any of it
/// is taken.
pub(super) fn axes(
    field: &HeightField,
    settings: &LayerSettings,
    interpolation: Interpolation,
    shift: [f64; 2],
) -> Result<[PaddedAxis; 2]> {
    let band = bands_of(field, settings.shortest_wavelength);
    let samples = Samples::of(field, shift);
    let sigma = settings.sigma;
    // The axes are as long as the window: a window that does not fit is refused before they are made.
    let extent = |axis: usize| if sigma.is_finite() { sigma } else { samples[axis].period() };
    let texels = |axis: usize| 2.0 * band[axis] * interpolation.ratios[axis] * extent(axis);
    let plane = if settings.basis.is_real() { 0.5 } else { 1.0 };
    let bytes = texels(0) * texels(1) * plane * 8.0 * settings.terms.unwrap_or(2) as f64;
    if bytes > settings.memory_limit as f64 {
        return Err(too_large(bytes, settings));
    }
    let axis = |i: usize| {
        let length = interpolation.ratios[i] * extent(i);
        PaddedAxis::new(&samples[i], sigma, length, Some(interpolation.kernels[i]), band[i])
    };
    let axes = [axis(0), axis(1)];
    let longest = axes.iter().map(PaddedAxis::kept).max().unwrap_or(0);
    if longest > settings.side_limit {
        return Err(Error::limit(
            format!("the spectra would be {} texels long, the device holds {}", longest, settings.side_limit),
            [Remedy::ShorterCoherence, Remedy::LargerTolerance, Remedy::ReferenceMethod],
        ));
    }
    ensure_room(&axes, &samples, settings).map(|()| axes)
}

/// Fails if the host has no room for the transforms of `settings`, whose buffers are reused from one to the next. Memory of the layers is
/// requested as they are made.
fn ensure_room([x, y]: &[PaddedAxis; 2], samples: &[Samples; 2], settings: &LayerSettings) -> Result<()> {
    // Real functions share a spectrum.
    let spectra = if settings.basis.is_real() { 1 } else { 2 };
    let transforms = Transformer::memory(x, y, &samples[1], spectra);
    // All heights once more, normalised to their range.
    let heights = (samples[0].count * samples[1].count * size_of::<f64>()) as u64;
    memory::ensure_room(transforms.saturating_add(heights), "the Fourier transforms")
}

pub(super) fn too_large(bytes: f64, settings: &LayerSettings) -> Error {
    Error::memory(
        format!(
            "the spectra would take {:.1} GiB or more, the limit is {:.1} GiB",
            bytes / f64::from(1 << 30),
            settings.memory_limit as f64 / f64::from(1 << 30)
        ),
        [Remedy::ShorterCoherence, Remedy::LargerTolerance, Remedy::FewerTerms, Remedy::ReferenceMethod],
    )
}

/// Returns the largest frequencies that directions at `shortest` \[µm\] need and the samples hold: min(2/λ, 1/(2dx)).
pub(super) fn bands_of(field: &HeightField, shortest: f64) -> [f64; 2] {
    field.pixel_size().map(|d| (2.0 / shortest).min(0.5 / d))
}
