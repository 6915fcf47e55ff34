//! Colours of a surface over all directions: an overview for the page of `surface info`, computed on the CPU.

use crate::brdf::hemisphere::{HemisphereMap, views};
use crate::cli::console::Console;
use crate::cli::progress::ProgressBar;
use crate::error::Result;
use crate::figure::{Mark, MarkShape, Panel, Raster, palette};
use crate::filter::Covariance;
use crate::optics::coherence::{Beyond, Coherence};
use crate::optics::color::{display, xyz_to_linear_srgb};
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::Illuminant;
use crate::spectra::power::{OrderSeries, PowerSettings};
use crate::surface::{HeightField, Statistics};
use crate::table::{ColorTable, TableReader, TableSettings, bake};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// Pixels on a side of a map.
const SIDE: u32 = 600;
/// Standard deviation of the directions that a point of a map averages over: a quarter of a degree, about the blur of light of 65 µm
/// coherence.
const SPREAD: f64 = 0.004;
/// Tolerance of the colours; an overview needs no smaller one.
const TOLERANCE: f64 = 0.07;
/// Samples on a side from which the colours are computed: the middle of a larger field.
const MOST_SAMPLES: usize = 1024;
/// Largest size of the colour table \[bytes\].
const MEMORY: usize = 1 << 30;
/// Largest number of texels along a side of the table.
const MOST_TEXELS: usize = 1 << 14;
/// Coherence length of the light \[µm\], and refractive index of the surface: the defaults of all commands.
const COHERENCE: f64 = 65.0;
const IOR: f64 = 1.5;
/// Polar angle of the second light \[degrees\].
const SLANTED: f64 = 45.0;

/// Returns panels of the colours in light from straight above and from aside, across the strongest grooves, and words for the caption.
///
/// # Errors
/// A surface that is too high for the series in z, or too little memory.
pub fn panels(
    field: &HeightField,
    statistics: &Statistics,
    console: &Console,
) -> Result<(Vec<Panel>, String)> {
    let part = middle(field);
    let table = table(&part, console)?;
    let across = statistics.periods.first().map_or(0.0, |period| period.direction.round());
    let across = if across == 0.0 { 0.0 } else { across }; // −0° reads oddly
    let above = panel(&table, 0.0, 0.0, "straight above".to_owned()).called("colours-above");
    let from = format!("θ\u{a0}=\u{a0}{SLANTED}°, φ\u{a0}=\u{a0}{across}°");
    let aside = panel(&table, SLANTED, across, from).called("colours-aside");
    let of_part = match part {
        Cow::Borrowed(_) => "",
        Cow::Owned(_) => " of the middle of the field",
    };
    let words = format!(
        "Colours{of_part}: what a pixel sees from each direction (mean over coherence areas), from above, x to the right, y up, rings of \
         polar angle every 15°; D65, coherence {COHERENCE} µm, refractive index {IOR}, {} beyond the patch.",
        Beyond::suited_to(&part).name()
    );
    Ok((vec![above, aside], words))
}

/// Bakes the colour table of `field`.
fn table(field: &HeightField, console: &Console) -> Result<Arc<ColorTable>> {
    let sigma = Coherence::Gaussian { length: COHERENCE }.sigma().unwrap_or(COHERENCE);
    let powers = PowerSettings::new(sigma, Beyond::suited_to(field), TOLERANCE);
    let colours = TableSettings {
        finest: SPREAD,
        side_limit: MOST_TEXELS,
        memory_limit: MEMORY,
        ..TableSettings::new(Illuminant::D65, TOLERANCE)
    };
    let bar = ProgressBar::new(console, "orders", "a part of the surface (--crop)");
    let series = OrderSeries::new(field, &powers, &bar.task())?;
    Ok(Arc::new(bake(&series, &colours, &bar.task())?))
}

/// Returns `field`, or the middle of a large one.
fn middle(field: &HeightField) -> Cow<'_, HeightField> {
    let size = [field.columns(), field.rows()];
    let [columns, rows] = size.map(|n| n.min(MOST_SAMPLES));
    if [columns, rows] == size {
        return Cow::Borrowed(field);
    }
    let [left, top] = [(size[0] - columns) / 2, (size[1] - rows) / 2];
    let heights = (top..top + rows).flat_map(|row| &field.row(row)[left..left + columns]).copied().collect();
    HeightField::new(columns, rows, field.pixel_size(), heights).map_or(Cow::Borrowed(field), Cow::Owned)
}

/// Returns the panel of the colours in light from the polar angle `theta` and the azimuth `phi` \[degrees\], which `from` says in words.
fn panel(table: &Arc<ColorTable>, theta: f64, phi: f64, from: String) -> Panel {
    let light = direction(theta, phi);
    let map = map(table, light);
    let stops = exposure(&map, light);
    let pixel = |[r, g, b, inside]: &[f32; 4]| {
        let [r, g, b] = display(DVec3::new((*r).into(), (*g).into(), (*b).into()), stops);
        [r, g, b, if *inside > 0.0 { 255 } else { 0 }]
    };
    let raster = Raster::colors(SIDE as usize, map.pixels.iter().map(pixel).collect());
    let exposure = format!("{stops:+.1}").replace('-', "−");
    let mirror = vec![[-light.x, -light.y]];
    let ring = Mark::Points { points: mirror, color: palette::SKY, shape: MarkShape::Ring, radius: 7.0 };
    Panel::hemisphere(raster)
        .titled(format!("Colours, light from {from}, {exposure} EV"))
        .named("mirror direction", ring)
}

/// Returns the linear sRGB of the BRDF \[sr⁻¹\] toward every direction.
fn map(table: &Arc<ColorTable>, light: DVec3) -> HemisphereMap {
    let reader = TableReader::new(Arc::clone(table));
    let footprint = Covariance { uu: SPREAD * SPREAD, uv: 0.0, vv: SPREAD * SPREAD };
    let views: Vec<(usize, DVec3)> = views(SIDE, 0..SIDE).collect();
    let color = |&(place, view): &(usize, DVec3)| {
        let f = reader.xyz(&Pair::new(light, view), &IOR.into(), &footprint) / light.z;
        (place, xyz_to_linear_srgb(f).as_vec3().extend(1.0).to_array())
    };
    let mut pixels = vec![[0.0; 4]; (SIDE * SIDE) as usize];
    for (place, color) in views.par_iter().map(color).collect::<Vec<_>>() {
        pixels[place] = color;
    }
    HemisphereMap { side: SIDE, pixels, of_orders: None }
}

/// Returns the exposure \[stops\] that brings the typical direction beside the specular peak to middle brightness: a quarter of the
/// scattered light is in fainter directions.
fn exposure(map: &HemisphereMap, light: DVec3) -> f64 {
    /// Radius of the specular peak that is left out.
    const SPOT: f64 = 0.08;
    /// Luminance of the typical direction on the display.
    const MIDDLE: f64 = 0.5;
    /// Share of the scattered light in fainter directions.
    const FAINTER: f64 = 0.25;
    /// Radiance relative to the peak below which it is rounding, not light.
    const NOTHING: f64 = 1e-7;
    /// Largest absolute exposure \[stops\].
    const MOST: f64 = 20.0;
    let luminances = map.values();
    let brightest = luminances.iter().copied().fold(0.0, f64::max);
    let beside = |&(_, view): &(usize, DVec3)| (view + light).truncate().length() > SPOT;
    let mut scattered: Vec<f64> = views(map.side, 0..map.side)
        .filter(beside)
        .map(|(place, _)| luminances[place])
        .filter(|l| *l > NOTHING * brightest)
        .collect();
    scattered.sort_unstable_by(f64::total_cmp);
    let share = FAINTER * scattered.iter().sum::<f64>();
    let mut below = 0.0;
    let typical = scattered.into_iter().find(|l| {
        below += l;
        below >= share
    });
    // A mirror scatters nothing: only its specular peak is visible.
    let typical = typical.unwrap_or(brightest).max(f64::MIN_POSITIVE);
    ((MIDDLE / typical).log2().clamp(-MOST, MOST) * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::mean::MeanBrdf;
    use crate::brdf::tabulated::{SummedOrders, TabulatedMean};
    use crate::optics::spectrum::SHORTEST;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use crate::task::Task;

    fn small(kind: SurfaceKind) -> HeightField {
        generate(&Spec { patch: Some([20.0; 2]), ..Spec::new(kind) }).unwrap()
    }

    #[test]
    fn the_colours_are_those_of_the_mean_in_f64_averaged_alike() {
        let console = &Console::silent();
        /// Bound a little above the measured value of *Elaphe*.
        const MEASURED: f64 = 0.125;
        for kind in [SurfaceKind::Elaphe, SurfaceKind::Bumps] {
            let field = small(kind);
            let table = table(&field, console).unwrap();
            let light = direction(SLANTED, 20.0);
            let map = map(&table, light);
            let sigma = COHERENCE / 4.0;
            let mean = MeanBrdf {
                field: field.clone(),
                sigma,
                beyond: Beyond::suited_to(&field),
                reflectance: IOR.into(),
            };
            let exact = TabulatedMean::new(mean, SHORTEST, &Task::silent()).unwrap();
            let footprint = Covariance { uu: SPREAD * SPREAD, uv: 0.0, vv: SPREAD * SPREAD };
            let some: Vec<_> = views(SIDE, 0..SIDE).step_by(101).collect();
            let pairs: Vec<_> = some.iter().map(|(_, view)| (Pair::new(light, *view), footprint)).collect();
            let colours = exact.xyz(&Illuminant::D65, &pairs, SummedOrders::All, &Task::silent()).unwrap();
            let (mut error, mut all) = (0.0, 0.0);
            for ((place, _), xyz) in some.iter().zip(colours) {
                let expected = xyz_to_linear_srgb(xyz / light.z);
                let [r, g, b, _] = map.pixels[*place].map(f64::from);
                error += (DVec3::new(r, g, b) - expected).length_squared();
                all += expected.length_squared();
            }
            let error = f64::sqrt(error / all);
            assert!(error < MEASURED, "{kind:?}: {error}");
        }
    }

    #[test]
    fn the_orders_of_a_grating_stand_where_the_grating_equation_says() {
        let console = &Console::silent();
        // 2.5 µm along x in light from above: the first order of green, 550 nm, at sin θ = 0.22 on the x axis.
        let field = small(SurfaceKind::Blaze);
        let map = map(&table(&field, console).unwrap(), DVec3::Z);
        let at = |x: f64, y: f64| {
            let place = |s: f64| ((s + 1.0) / 2.0 * f64::from(SIDE)) as usize;
            map.pixels[place(-y) * SIDE as usize + place(x)]
        };
        let largest = |x: f64| at(x, 0.0)[1].max(at(-x, 0.0)[1]);
        assert!(largest(0.22) > 100.0 * at(0.0, 0.22)[1].max(at(0.0, -0.22)[1]), "{:?}", at(0.22, 0.0));
        assert!(largest(0.22) > 100.0 * largest(0.1), "nothing is seen before violet, at 0.15");
    }

    #[test]
    fn a_page_can_have_colours_of_the_smallest_fields_and_of_a_mirror() {
        let console = &Console::silent();
        let fields = [
            HeightField::new(1, 1, [0.1; 2], vec![0.0]).unwrap(),
            HeightField::new(9, 1, [0.1; 2], vec![0.02; 9]).unwrap(),
            small(SurfaceKind::Flat),
        ];
        for field in fields {
            let (panels, words) =
                panels(&field, &Statistics::of(&field, &Task::silent()).unwrap(), console).unwrap();
            assert!(panels.len() == 2 && words.contains("D65"), "{words}");
        }
    }
}
