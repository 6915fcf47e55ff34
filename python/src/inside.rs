//! Uses of the library beyond its front: samples that were not measured, the origin of heights, and the report of `surface info` name a dozen types, which only this module
//! needs. They may change in any version; the module is built with the library that it belongs to.

use diffract::internals::notes::PreparationRecord;
use diffract::internals::optics::surface_report::SurfaceReport;
use diffract::internals::optics::validity::{LightColour, ScalarTheory};
use diffract::internals::surface::Statistics;
use diffract::internals::surface::files::plausible::HeightSource;
use diffract::internals::surface::files::{self, ScanOrigin, Spacing, Topography};
use diffract::{HeightField, Optics, ReadSettings, Result, Scene, Task};
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

/// Micrometres of a metre.
const UM: f64 = 1e6;

/// Origin of a height field.
#[derive(Clone)]
pub struct Origin {
    /// Name of the file or of the surface.
    pub name: OsString,
    /// File that the heights come from.
    scan: Option<ScanOrigin>,
    /// Number of samples that were not measured.
    invalid: usize,
    /// Report of the heights as they were read, with gaps; `None` after a preparation.
    report: Option<Arc<SurfaceReport>>,
}

impl Origin {
    /// Returns the origin of heights called `name` that were computed.
    pub fn computed(name: &str) -> Self {
        Self { name: name.into(), scan: None, invalid: 0, report: None }
    }

    /// Returns the origin of the same heights after a preparation.
    pub fn prepared(&self) -> Self {
        Self { report: None, ..self.clone() }
    }

    fn of(name: OsString, heights: &Topography) -> Self {
        let (scan, invalid) = (heights.origin().cloned(), heights.missing());
        let report = Some(Arc::new(SurfaceReport::new(&name, heights, scan.as_ref(), invalid)));
        Self { name, scan, invalid, report }
    }
}

/// Height field with its origin and what a user should know of it.
pub struct ReadField {
    /// The heights, gaps filled.
    pub field: HeightField,
    /// Origin of the heights.
    pub origin: Origin,
    /// Facts, one line each.
    pub warnings: Vec<String>,
}

/// Reads the file `path`.
pub fn read(path: &Path, settings: &ReadSettings<'_>, task: &Task) -> Result<ReadField> {
    let heights = files::read(path, settings, task)?;
    let origin = Origin::of(path.as_os_str().to_owned(), &heights);
    let warnings = heights.origin().map(|origin| origin.warnings.clone()).unwrap_or_default();
    Ok(ReadField { field: heights.into_field().map_err(|e| e.at(path.display()))?, origin, warnings })
}

/// Returns the field of `heights` \[m\], rows of `size` from the top, `pixel_size` \[µm\] apart. NaN are samples that were not measured.
pub fn from_metres(size: [usize; 2], pixel_size: [f64; 2], heights: Vec<f64>) -> Result<ReadField> {
    // An empty field has no unmeasured sample, and its own error.
    if heights.is_empty() {
        HeightField::new(size[0], size[1], pixel_size, Vec::new()).map_err(|e| e.at("heights"))?;
    }
    let spacing = Spacing::Micrometres(pixel_size);
    let heights = Topography::new(size, spacing, heights, UM, None).map_err(|e| e.at("heights"))?;
    let origin = Origin::of("array".into(), &heights);
    let (missing, count) = (heights.missing(), size[0] * size[1]);
    let mut warnings = heights.questions(HeightSource::File);
    if missing > 0 {
        warnings.push(format!("{missing} of {count} samples were not measured; {}", files::invalid::METHOD));
    }
    Ok(ReadField { field: heights.into_field().map_err(|e| e.at("heights"))?, origin, warnings })
}

/// Returns the questions about the scales of a generated `field`.
pub fn questions(field: &HeightField) -> Vec<String> {
    Topography::of(field.clone()).questions(HeightSource::Given)
}

/// Returns the steps that prepared `field`, in words.
pub fn steps(field: &HeightField) -> Vec<String> {
    field.prepared().steps().to_vec()
}

/// Returns `field` with the record of these steps.
pub fn with_steps(field: HeightField, steps: &[String]) -> HeightField {
    let mut record = PreparationRecord::default();
    steps.iter().for_each(|step| record.push(step));
    field.with_record(record)
}

/// Returns the report of `field` as JSON, as the command `surface info` writes it, with the errors of scalar theory under `optics`.
pub fn report(field: &HeightField, origin: &Origin, optics: &Optics, task: &Task) -> Result<String> {
    let report = match &origin.report {
        Some(report) => SurfaceReport::clone(report),
        None => {
            let heights = Topography::of(field.clone());
            SurfaceReport::new(&origin.name, &heights, origin.scan.as_ref(), origin.invalid)
        }
    };
    let statistics = Statistics::of(field, task)?;
    let light = LightColour::Spectrum(&optics.illuminant);
    let theory = ScalarTheory::of_field(field, &optics.reflectance, light)?;
    let report = report.with_statistics(field, statistics, theory)?;
    serde_json::to_string(&report).map_err(|e| diffract::Error::bug(format!("the report is no JSON ({e})")))
}

/// Returns `optics` with the material that the first object of `scene` names, if it does.
pub fn with_material_of(optics: Optics, scene: &Scene) -> Optics {
    let Some(material) = scene.main_object().reflectance.clone() else { return optics };
    let former = optics.reflectance.clone();
    let reflectance = material.by(former.stated_theory()).polarised(former.polarisation());
    Optics { reflectance, ..optics }
}
