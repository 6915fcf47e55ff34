//! Evaluation in `eval`, `brdf`, `colour` and `peaks`: limits of the input, and batches of directions.

use super::options::{ColourOptions, DEFAULT_ILLUMINANT};
use super::progress::ProgressBar;
use crate::brdf::Brdf;
use crate::error::{Error, Result};
use crate::optics::geometry::Pair;
pub use crate::optics::spectrum::ANSWERED as WAVELENGTHS;
use crate::settings::Method;
use crate::units;
use glam::DVec3;
use std::time::{Duration, Instant};

/// Pairs of directions that are evaluated together: memory stays at a few megabytes.
const AT_ONCE: usize = 16_384;

/// Size of the first batch. It includes preparations, such as the series of the orders.
const FIRST_BATCH: usize = 16;
/// Time that a batch takes about, so that progress moves.
const OF_A_BATCH: Duration = Duration::from_secs(1);

/// Evaluates f \[sr⁻¹\] of all `pairs`, in order: three times the value at `wavelength` \[µm\], or the XYZ of the colour.
///
/// # Errors
/// Those of [`Brdf`].
pub fn ask(
    brdf: &dyn Brdf,
    pairs: &[Pair],
    wavelength: Option<f64>,
    bar: &ProgressBar,
) -> Result<Vec<DVec3>> {
    let mut all = Vec::with_capacity(pairs.len());
    let task = bar.task_of_parts();
    let mut size = FIRST_BATCH;
    while all.len() < pairs.len() {
        let left = &pairs[all.len()..];
        let part = &left[..size.min(brdf.batch()).min(left.len())];
        let begun = Instant::now();
        match wavelength {
            Some(wavelength) => {
                all.extend(brdf.spectral(part, wavelength, &task)?.into_iter().map(DVec3::splat))
            }
            None => all.extend(brdf.xyz(part, &task)?),
        }
        bar.add(part.len());
        let batches_in_time = OF_A_BATCH.as_secs_f64() / begun.elapsed().as_secs_f64();
        size = ((part.len() as f64 * batches_in_time) as usize).clamp(FIRST_BATCH, AT_ONCE);
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
