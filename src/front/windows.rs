//! Responses through single windows, on the device.

use crate::context::Context;
use crate::error::Result;
use crate::measure::sweep::SweepPlane;
use crate::optics::geometry::Pair;
use crate::settings::Optics;
use crate::setup::{self, SourceSettings};
use crate::surface::HeightField;
use crate::task::Task;

/// Pairs of directions that are evaluated together: memory stays at a few megabytes.
const AT_ONCE: usize = 16_384;

/// Returns the responses in `plane` through the windows of `optics`, window by window and wavelength by wavelength.
///
/// # Errors
/// Those of [`setup::for_each_window`].
pub fn responses(
    plane: &SweepPlane,
    optics: &Optics,
    field: &HeightField,
    context: &Context,
    task: &Task,
) -> Result<Vec<f64>> {
    let pairs: Vec<Pair> = plane.pairs();
    let mut responses = Vec::with_capacity(plane.evaluations());
    // Single wavelengths of single directions, as the command line answers them.
    let optics = Optics { basis: optics.suited_basis(field), ..optics.clone() };
    let settings =
        SourceSettings { shortest: plane.wavelengths[0], windows_apart: true, ..SourceSettings::new(optics) };
    setup::for_each_window(field, &settings, context, task, |brdf, _| {
        for wavelength in &plane.wavelengths {
            for part in pairs.chunks(brdf.batch().clamp(1, AT_ONCE)) {
                task.check()?;
                responses.extend(brdf.spectral(part, *wavelength, task)?);
            }
        }
        Ok(())
    })?;
    Ok(responses)
}
