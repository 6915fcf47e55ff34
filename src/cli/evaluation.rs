//! Evaluation in `eval`, `brdf` and `peaks`: limits of the input, and the progress bar.

use super::options::{ColourOptions, DEFAULT_ILLUMINANT};
use super::prepare;
use crate::brdf::Brdf;
use crate::error::{Error, Result};
use crate::optics::geometry::Pair;
use crate::settings::Method;
use crate::units;
use glam::DVec3;
use indicatif::ProgressBar;

/// Range of wavelengths \[µm\]: from hard ultraviolet to far infrared.
pub const WAVELENGTHS: (f64, f64) = (0.01, 100.0);
/// Pairs of directions that are evaluated together: memory stays at a few megabytes.
pub const AT_ONCE: usize = 16_384;

/// Returns a progress bar over `count` directions.
pub fn bar(count: usize) -> ProgressBar {
    let bar = prepare::progress_bar("directions");
    bar.set_length(count as u64);
    bar
}

/// Evaluates f \[sr⁻¹\] of all `pairs`, in order: three times the value at `wavelength` \[µm\], or the XYZ of the colour.
///
/// # Errors
/// Those of [`Brdf`].
pub fn ask(
    brdf: &mut dyn Brdf,
    pairs: &[Pair],
    wavelength: Option<f64>,
    bar: &ProgressBar,
) -> Result<Vec<DVec3>> {
    let mut all = Vec::with_capacity(pairs.len());
    for part in pairs.chunks(brdf.batch()) {
        match wavelength {
            Some(wavelength) => all.extend(brdf.spectral(part, wavelength)?.into_iter().map(DVec3::splat)),
            None => all.extend(brdf.xyz(part)?),
        }
        bar.inc(part.len() as u64);
    }
    Ok(all)
}

/// Parses a wavelength \[µm\].
pub fn wavelength(text: &str) -> Result<f64> {
    let (low, high) = WAVELENGTHS;
    units::length(text).and_then(|length| {
        let refused = || Error::usage(format!("'{text}' is out of range"), "give 10nm to 100um");
        (low..=high).contains(&length).then_some(length).ok_or_else(refused)
    })
}

/// Fails if `method` has no single wavelengths.
pub fn check_single_wavelengths(method: Method) -> Result<()> {
    if method != Method::Table {
        return Ok(());
    }
    Err(Error::usage(
        "--method table holds colours, summed over the spectrum, and no single wavelength",
        "use --method spectral or --method reference",
    ))
}

/// Fails if the options name a spectrum for the colours of single wavelengths.
pub fn check_no_spectrum(colour: &ColourOptions) -> Result<()> {
    if colour.illuminant == DEFAULT_ILLUMINANT {
        return Ok(());
    }
    Err(Error::usage(
        "--illuminant is the spectrum of a colour, and a single wavelength has none",
        "leave out the illuminant or the wavelength",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_lengths() {
        assert!((wavelength("550nm").unwrap() - 0.55).abs() < 1e-12);
        assert!(wavelength("550").is_err() && wavelength("1nm").is_err() && wavelength("1mm").is_err());
    }
}
