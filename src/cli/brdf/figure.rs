//! Maps as labelled figures.

use super::Arguments;
use super::variant::Variant;
use crate::brdf::hemisphere::HemisphereMap;
use crate::cli::captions;
use crate::cli::options::OpticsOptions;
use crate::figure::{Axis, ColorScale, Figure, Mark, MarkShape, Panel, Raster, number, palette};
use crate::optics::color;
use crate::optics::geometry::direction;
use crate::surface::HeightField;
use glam::DVec3;

/// Largest side of a figure's map \[pixels\].
const FINEST: u32 = 1000;
/// Decades of the colour scale: from the specular peak to its tails.
const DECADES: f64 = 6.0;
/// Floor of relative differences, relative to the peak.
const FLOOR: f64 = 1e-6;
/// Names of the panels: a map at one wavelength; a map in colour and its luminance; two maps and their difference.
const BRDF: &str = "brdf";
const COLOUR: &str = "colour";
const LUMINANCE: &str = "luminance";
const COMPARED: [&str; 3] = ["a", "b", "difference"];
/// Width and height of a map \[px\].
const PANEL: [f64; 2] = [540.0, 470.0];

/// Returns the names of the panels of the figure.
pub fn panel_names(arguments: &Arguments) -> &'static [&'static str] {
    match (&arguments.compare, arguments.wavelength) {
        (Some(_), _) => &COMPARED,
        (None, Some(_)) => &[BRDF],
        (None, None) => &[COLOUR, LUMINANCE],
    }
}

/// Describes the surface, the lights and the quantity in words.
fn settings(arguments: &Arguments, field: &HeightField) -> String {
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let shown = match arguments.wavelength {
        Some(wavelength) => format!("{} nm", (wavelength * 1e4).round() / 10.0),
        None => format!("colour under {}", arguments.colour.illuminant.display()),
    };
    format!(
        "Hemisphere of view directions from above, x to the right, y up; rings of polar angle every 15°. {}; light \
         from {}; {shown}; {size}×{size} directions.",
        captions::surface(&name, field),
        captions::lights(&arguments.light),
        size = arguments.size
    )
}

/// Returns a map in false colour.
fn panel(
    arguments: &Arguments,
    map: &HemisphereMap,
    title: &str,
    values: &[f64],
    scale: ColorScale,
) -> Panel {
    let panel = Panel::hemisphere(Raster::values(map.side as usize, values, scale));
    decorated(arguments, panel.titled(title))
}

/// Adds a scale bar, and rings at the specular directions of the lights.
fn decorated(arguments: &Arguments, panel: Panel) -> Panel {
    let mirrors = arguments.light.iter().map(|light| {
        let toward = direction(light.theta, light.phi);
        [-toward.x, -toward.y]
    });
    let rings =
        Mark::Points { points: mirrors.collect(), color: palette::SKY, shape: MarkShape::Ring, radius: 7.0 };
    panel.with_scale_bar(0.2, "Δ sin θ = 0.2").named("mirror direction", rings)
}

/// Returns a map as a display shows it.
fn colored(arguments: &Arguments, map: &HemisphereMap) -> Panel {
    let pixel = |[r, g, b, inside]: &[f32; 4]| {
        let [r, g, b] = color::display(DVec3::new((*r).into(), (*g).into(), (*b).into()), arguments.exposure);
        [r, g, b, if *inside > 0.0 { 255 } else { 0 }]
    };
    let pixels = map.pixels.iter().map(pixel).collect();
    let exposure = match arguments.exposure {
        0.0 => String::new(),
        stops => format!(" at {stops:+} EV"),
    };
    let panel = Panel::hemisphere(Raster::colors(map.side as usize, pixels));
    decorated(arguments, panel.called(COLOUR).titled(format!("Colour{exposure}")))
}

/// Returns the label of the values of `map`.
fn quantity(arguments: &Arguments) -> &'static str {
    if arguments.wavelength.is_some() { "BRDF [sr⁻¹]" } else { "luminance of the BRDF [sr⁻¹]" }
}

/// Returns the figure of one map: in colour and in luminance, or at its wavelength.
pub fn of_map(arguments: &Arguments, field: &HeightField, map: &HemisphereMap) -> Figure {
    let albedo = map.albedo();
    let map = map.reduced(FINEST);
    let values = map.values();
    let scale = ColorScale::decades(quantity(arguments), DECADES, &values);
    let mut panels = Vec::new();
    let (name, title) = match arguments.wavelength {
        Some(wavelength) => (BRDF, format!("{} nm", (wavelength * 1e4).round() / 10.0)),
        None => {
            panels.push(colored(arguments, &map));
            (LUMINANCE, "Luminance".to_owned())
        }
    };
    panels.push(panel(arguments, &map, &title, &values, scale).called(name));
    let caption = format!(
        "{} {} Albedo of the map, ∫\u{a0}f\u{a0}cos\u{a0}θ\u{a0}dω: {albedo:.4}.",
        settings(arguments, field),
        captions::sentence(&captions::optics(&arguments.optics))
    );
    Figure::new("").row(panels).panel_size(PANEL[0], PANEL[1]).caption(caption)
}

/// Returns the figure of two maps and their difference.
pub fn of_two(
    arguments: &Arguments,
    field: &HeightField,
    variants: &[Variant; 2],
    optics: &[OpticsOptions; 2],
    maps: &[HemisphereMap; 2],
) -> Figure {
    let albedos = maps.each_ref().map(HemisphereMap::albedo);
    let deviation = deviation(&maps[0].values(), &maps[1].values());
    let maps = maps.each_ref().map(|map| map.reduced(FINEST));
    let values = maps.each_ref().map(HemisphereMap::values);
    let both: Vec<f64> = values.iter().flatten().copied().collect();
    let scale = ColorScale::decades(quantity(arguments), DECADES, &both);
    let floor = FLOOR * scale.axis.high;
    let relative: Vec<f64> =
        values[0].iter().zip(&values[1]).map(|(a, b)| (a - b) / b.abs().max(floor)).collect();
    let mut panels: Vec<Panel> =
        (0..2).map(|i| panel(arguments, &maps[i], &variants[i].name, &values[i], scale.clone())).collect();
    let difference = ColorScale::differences("(A − B)/B", spread(&relative));
    panels.push(panel(arguments, &maps[0], "Relative difference", &relative, difference));
    let panels = panels.into_iter().zip(COMPARED).map(|(panel, name)| panel.called(name)).collect();
    let caption = format!(
        "{} A: {}. B: {}. Difference of the maps, ‖A\u{a0}−\u{a0}B‖/‖B‖: {}. Relative differences hold B for at \
         least {} of the peak; colours end where 98 % of the directions do. Albedo of A {:.4}, of B {:.4}.",
        settings(arguments, field),
        captions::optics(&optics[0]),
        captions::optics(&optics[1]),
        number(deviation, deviation / 30.0),
        number(FLOOR, FLOOR),
        albedos[0],
        albedos[1]
    );
    Figure::new("").row(panels).panel_size(PANEL[0], PANEL[1]).caption(caption)
}

/// Returns ‖a − b‖/‖b‖ over the disc.
pub fn deviation(a: &[f64], b: &[f64]) -> f64 {
    let inside = || a.iter().zip(b).filter(|(a, b)| !a.is_nan() && !b.is_nan());
    let of = |f: &dyn Fn(f64, f64) -> f64| inside().map(|(a, b)| f(*a, *b).powi(2)).sum::<f64>();
    let (difference, energy) = (of(&|a, b| a - b), of(&|_, b| b));
    if energy > 0.0 { (difference / energy).sqrt() } else { 0.0 }
}

/// Returns the end of a rounded axis from 0 that holds 98 % of the absolute `values`.
fn spread(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().filter(|x| !x.is_nan()).map(|x| x.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let place = (sizes.len() as f64 * 0.98) as usize;
    let found = sizes.get(place.min(sizes.len().saturating_sub(1))).copied().unwrap_or(0.0);
    Axis::linear("", 0.0, found).high
}
