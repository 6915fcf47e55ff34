//! Limit of energy of a surface, for single directions and for the colours of pictures.

use super::{InUse, SourceSettings, Wanted};
use crate::brdf::albedo::{Decimation, DirectionalAlbedo};
use crate::brdf::energy_map::EnergyMap;
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::TabulatedMean;
use crate::cache::{Kept, Key};
use crate::error::{Error, Result};
use crate::optics::coherence::SUNLIGHT_LENGTH;
use crate::spectra::power::OrderSeries;
use crate::surface::HeightField;
use crate::task::Task;
use std::sync::Arc;

/// Limit of energy, and a note for the user.
type Limited<T> = (Option<Arc<T>>, Option<Error>);

/// Returns the note of a surface that is too high for a series of its orders.
fn too_high() -> Error {
    Error::limit(
        "the heights are too large for the sum over all orders that limits the energy: brightness has no limit",
        "check the height and its unit",
    )
}

/// Returns the limit of `field` for single directions, at wavelengths from the shortest of `settings` on; none where
/// the theory has none.
///
/// # Errors
/// Fails if there is too little memory, or if the task is cancelled.
pub fn single_limit(
    field: &HeightField,
    settings: &SourceSettings,
    task: &Task,
) -> Result<Limited<DirectionalAlbedo>> {
    let optics = &settings.optics;
    let sigma = optics.coherence.sigma().unwrap_or(SUNLIGHT_LENGTH / 4.0);
    let mean = MeanBrdf {
        field: field.clone(),
        sigma,
        beyond: optics.beyond,
        reflectance: optics.reflectance.clone(),
    };
    let limit = TabulatedMean::limit_of(mean, settings.shortest, task)?;
    let note = (limit.is_none() && optics.reflectance.is_limited()).then(too_high);
    Ok((limit, note))
}

/// Returns the limit of `field` for the colours of `settings`, from the data `in_use`, from the cache on disk, or made
/// and cached; none where the theory has none.
///
/// # Errors
/// Fails if there is too little memory, or if the task is cancelled.
pub fn colour_limit(
    field: &HeightField,
    settings: &SourceSettings,
    in_use: &mut InUse,
    task: &Task,
) -> Result<Limited<EnergyMap>> {
    let optics = &settings.optics;
    if !optics.reflectance.is_limited() {
        return Ok((None, None));
    }
    let sigma = optics.coherence.sigma().unwrap_or(SUNLIGHT_LENGTH / 4.0);
    // Those of the colour table, which then shares the series. A finite grating has the same orders as sunlight, whose
    // blur the albedo leaves out.
    let powers = settings.power_settings_of(sigma);
    if OrderSeries::estimate(field, &powers).is_none() {
        return Ok((None, Some(too_high())));
    }
    let wanted = Wanted {
        key: Key::new(&EnergyMap::FORMAT, &(powers, &optics.reflectance, &optics.illuminant), field)?,
        name: "the limit of energy",
        memory_limit: u64::from(u32::MAX),
    };
    let make = |in_use: &mut InUse| {
        let series = in_use.series(field, &powers, task)?;
        let albedo = DirectionalAlbedo::new(&series, &optics.reflectance, Decimation::Coarse);
        albedo.make_table(task)?;
        Ok(EnergyMap::measured(&albedo, &optics.illuminant))
    };
    let (map, note) = wanted.obtain(in_use, |in_use| &mut in_use.energies, make)?;
    Ok((Some(map), note))
}
