//! What `trade` measures beside the program's own settings: what a user would take instead.

use super::profile::Arguments;
use super::stage::{References, Stage, shown};
use super::trade::row;
use crate::error::Result;
use crate::measure::trade::{GRATING, Row, THESIS};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::thesis;
use crate::render::picture::Painter;
use crate::render::pigment::Pigment;
use crate::render::resources::Optics;
use crate::surface::statistics::line_periods;

/// The row of `series`, drawn for the frame that `own` sets up; `None` where it is nothing for this surface.
pub fn measured(
    series: &str,
    stage: &Stage,
    own: &Arguments,
    references: &mut References,
) -> Result<Option<Row>> {
    match series {
        GRATING => grating(stage, own, references),
        _ => of_thesis(stage, own, references),
    }
}

/// The classical shader of a grating of one period, at the brightness that suits it best. `None` for surfaces that do not repeat.
fn grating(stage: &Stage, own: &Arguments, references: &mut References) -> Result<Option<Row>> {
    let [along_x, along_y] = line_periods(&stage.field);
    let (axis, period) = match (along_x, along_y) {
        (Some(period), _) => ([1.0, 0.0], period),
        (None, Some(period)) => ([0.0, 1.0], period),
        (None, None) => return Ok(None),
    };
    let shading = own.optics.for_pictures(&own.colour)?;
    let (mut painter, _, _, directions) = stage.prepare(own, &shading)?;
    let exact = references.of(stage, &shading, &directions)?;
    let mut colors = |strength: f32| {
        painter.shade_as_grating(axis, period as f32, strength)?;
        painter.paint(&stage.view, stage.scene.exposure, stage.scene.background)
    };
    // The picture is linear in the strength: least squares between that of 0 and that of 1.
    let (pigment, one) = (shown(&colors(0.0)?, &exact.pixels), shown(&colors(1.0)?, &exact.pixels));
    let parts = pigment.iter().zip(&one).zip(&exact.colors);
    let (product, square) = parts.fold((0.0, 0.0), |(p, s), ((pigment, one), exact)| {
        let orders = *one - *pigment;
        (p + orders.dot(*exact - *pigment), s + orders.length_squared())
    });
    let strength = if square > 0.0 { (product / square).max(0.0) as f32 } else { 0.0 };
    painter.shade_as_grating(axis, period as f32, strength)?;
    Ok(Some(Row {
        flags: format!("grating equation, one period of {:.0} nm, for comparison", period * 1e3),
        series: GRATING.to_owned(),
        kernel: "none".to_owned(),
        ..row(stage, &mut painter, exact)?
    }))
}

/// What the thesis' own shader sums. `None` for repeats, which it sums in another way.
fn of_thesis(stage: &Stage, own: &Arguments, references: &mut References) -> Result<Option<Row>> {
    let shading = own.optics.for_pictures(&own.colour)?;
    let Coherence::Gaussian { length } = shading.coherence else { return Ok(None) };
    let layers = thesis::layers(&stage.field, length / 4.0, SHORTEST)?;
    let (low, high) = stage.field.range();
    let optics = Optics::Thesis(&layers, (high - low) / 2.0);
    let lights = stage.view.lights.len();
    let (mesh, pigment) = (&stage.scene.mesh, Pigment::white());
    let mut painter = Painter::new(&stage.device, optics, &shading, mesh, &pigment, stage.size, lights)?;
    let directions =
        (0..lights).map(|light| painter.directions(&stage.view, light)).collect::<Result<Vec<_>>>()?;
    let exact = references.of(stage, &shading, &directions)?;
    // Two terms share a texel.
    let reads = thesis::WAVELENGTHS * thesis::TERMS.div_ceil(2) * thesis::TAPS * lights;
    Ok(Some(Row {
        flags: "the thesis' sum: 37 terms, 81 wavelengths, 3 x 3 reads, for comparison".to_owned(),
        series: THESIS.to_owned(),
        terms: thesis::TERMS,
        layers: thesis::TERMS,
        kernel: "3 x 3 bins".to_owned(),
        wavelengths: (thesis::WAVELENGTHS * lights) as f64,
        samples: reads as f64,
        ..row(stage, &mut painter, exact)?
    }))
}
