//! Materials for other programs: a folder with the colour table of a surface as files that any program can read, and with the numbers by which a port of
//! the reading function is tested.
//!
//! | file | content |
//! | --- | --- |
//! | `material.json` | [`MaterialDescription`]: units, axes, signs, settings, measured errors, check sums of the other files |
//! | `table.json` | [`TableHeader`](crate::table::TableHeader): grid, basis, specular order, mean reflectance |
//! | `table.ktx2` | the texels: a 2D array of RGBA16F with all levels ([`ktx2`]) |
//! | `functions.ktx2` | the functions of `table.json` as a texture |
//! | `table2d.exr`, `functions.exr` | the same texels and functions as plain images ([`flat`]) |
//! | `material.glsl`, `material.es.glsl`, `material.wgsl`, `material.hlsl` | the function that reads the textures ([`shader`], [`translation`]) |
//! | `material2d.glsl`, … | the function that reads the plain images |
//! | `material.gdshader`, `material.unity.hlsl`, `material.ush` | the same for game engines ([`engines`]) |
//! | `conformance.csv` | directions with footprints, their exact colours, and those of the table ([`Conformance`]) |

mod conformance;
mod description;
pub mod engines;
pub mod flat;
mod folder;
pub mod ktx2;
pub mod page;
pub mod page_light;
pub mod page_mesh;
pub mod page_still;
mod page_text;
mod parameters;
pub mod shader;
pub mod translation;

pub use conformance::{Conformance, ConformanceRow, PortErrors};
pub use description::{FileSum, MaterialDescription, MeasuredErrors};
pub use folder::{ExportReader, check_target, write};

use crate::brdf::albedo::{Decimation, DirectionalAlbedo};
use crate::brdf::energy_map::EnergyMap;
use crate::brdf::mean::MeanBrdf;
use crate::error::{Error, Remedy, Result};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::Illuminant;
use crate::spectra::power::{Beyond, OrderSeries, PowerSettings};
use crate::surface::HeightField;
use crate::table::{self, ColorTable, PlannedTable, TableSettings, bake};
use crate::task::Task;
use crate::tolerance;
use std::sync::Arc;

/// Settings of an exported material.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportSettings {
    /// Standard deviation of the coherence window \[µm\], a quarter of the coherence length.
    pub sigma: f64,
    /// Continuation of the surface beyond the patch.
    pub beyond: Beyond,
    /// Spectrum of the light.
    pub illuminant: Illuminant,
    /// Reflectance of the surface. The table holds it, so that its readers need no equations for it.
    pub reflectance: Reflectance,
    /// Relative error that the parts of the table share.
    pub tolerance: f64,
    /// Number of wavelengths, if the user names it.
    pub wavelengths: Option<usize>,
    /// Smallest footprint: the standard deviation of (u, v) that the finest level averages over; 0 for single directions.
    pub footprint: f64,
    /// Most bytes of the texels. The smallest footprint grows until the table keeps them.
    pub most_bytes: Option<u64>,
}

/// Largest footprint that an export is made for: (u, v) has a length of at most 2.
pub const LARGEST_FOOTPRINT: f64 = 0.5;

/// Colour table of a surface with its conformance numbers.
pub struct ExportedMaterial {
    /// The table.
    pub table: Arc<ColorTable>,
    /// Directions with exact colours and those of the table.
    pub conformance: Conformance,
}

impl ExportedMaterial {
    /// Bakes the table of `field` and evaluates the conformance directions. `task` is told of each step.
    ///
    /// # Errors
    /// Too little memory; a cancelled task.
    pub fn new(field: &HeightField, settings: &ExportSettings, task: &Task) -> Result<Self> {
        Self::of_table(Arc::new(Self::table(field, settings, task)?), field, settings, task)
    }

    /// Evaluates the conformance directions of the `table` of `field` that [`Self::table`] bakes by these `settings`. `task` is told of each step.
    ///
    /// # Errors
    /// Same as [`Self::new`].
    pub fn of_table(
        table: Arc<ColorTable>,
        field: &HeightField,
        settings: &ExportSettings,
        task: &Task,
    ) -> Result<Self> {
        let settings = &ExportSettings { footprint: table.header.grid.finest, ..settings.clone() };
        let mean = MeanBrdf {
            field: field.clone(),
            sigma: settings.sigma,
            beyond: settings.beyond,
            reflectance: settings.reflectance.clone(),
        };
        let exact = task.named("exact colours");
        let conformance = Conformance::new(mean, settings, &table, &exact)?;
        Ok(Self { table, conformance })
    }

    /// Bakes the table of `field`, with the limit of energy of its theory.
    ///
    /// # Errors
    /// Same as [`Self::new`].
    pub fn table(field: &HeightField, settings: &ExportSettings, task: &Task) -> Result<ColorTable> {
        let made = plan(field, settings, task).and_then(|(series, colours)| {
            let table = bake(&series, &colours, task)?;
            Ok((series, table))
        });
        let (series, mut table) = made.map_err(|refusal| {
            tolerance::with_least(refusal, settings.tolerance, |tolerance| {
                let (series, colours) = plan(field, &ExportSettings { tolerance, ..settings.clone() }, task)?;
                table::check(&series, &colours)
            })
        })?;
        if settings.reflectance.is_limited() {
            let albedo = DirectionalAlbedo::new(&series, &settings.reflectance, Decimation::Coarse);
            albedo.make_table(task)?;
            table.header.energy = Some(EnergyMap::new(&albedo, &settings.illuminant).points().to_vec());
        }
        Ok(table)
    }
}

/// Returns the series of orders of `field` and the settings of the table that `settings` ask for.
fn plan(field: &HeightField, settings: &ExportSettings, task: &Task) -> Result<(OrderSeries, TableSettings)> {
    let powers = PowerSettings::new(settings.sigma, settings.beyond, settings.tolerance);
    let mut colours = TableSettings {
        reflectance: Some(settings.reflectance.clone()),
        wavelengths: settings.wavelengths,
        finest: settings.footprint,
        ..TableSettings::new(settings.illuminant.clone(), settings.tolerance)
    };
    let series = OrderSeries::new(field, &powers, task)?;
    if let Some(most) = settings.most_bytes {
        colours.finest = footprint_within(most, &series, colours.clone())?;
    }
    Ok((series, colours))
}

/// Returns the smallest footprint, from that of `settings` on, for which the table of `series` has at most `most` bytes of texels.
fn footprint_within(most: u64, series: &OrderSeries, settings: TableSettings) -> Result<f64> {
    /// Sides are rounded up to multiples of a power of 2, by which the next table may be larger than the rule says.
    const ROOM: f64 = 1.05;
    let mut settings = settings;
    loop {
        let PlannedTable { bytes, coherence_blur } = PlannedTable::new(series, &settings)?;
        if bytes as u64 <= most {
            return Ok(settings.finest);
        }
        // Bytes fall as 1 over the variance that the finest level averages over, coherence included.
        let growth = bytes as f64 / most as f64 * ROOM;
        let variance = (settings.finest.powi(2) + coherence_blur) * growth - coherence_blur;
        settings.finest = variance.max(0.0).sqrt();
        if settings.finest > LARGEST_FOOTPRINT {
            return Err(Error::limit(
                format!("no table of this surface has as few as {most} bytes"),
                // Texels are as many as the tolerance is small.
                [
                    Remedy::Words("allow more bytes".into()),
                    Remedy::TimesTolerance(
                        (variance + coherence_blur) / (LARGEST_FOOTPRINT.powi(2) + coherence_blur),
                    ),
                ],
            ));
        }
    }
}
