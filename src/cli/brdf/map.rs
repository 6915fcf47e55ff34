//! The map of `brdf`, with progress bars and warnings.

use super::Arguments;
use crate::brdf::hemisphere::{HemisphereMap, MapLight, PixelParts};
use crate::cli::console::Console;
use crate::cli::options::OpticsOptions;
use crate::cli::progress::ProgressBar;
use crate::cli::{evaluation, prepare};
use crate::error::Result;
use crate::optics::geometry::direction;
use crate::optics::spectrum::SHORTEST;
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use crate::task::DIRECTIONS;

/// Evaluates the map of `field` that `arguments` describe, by `optics`.
pub fn of(
    arguments: &Arguments,
    optics: &OpticsOptions,
    field: &HeightField,
    console: &Console,
) -> Result<HemisphereMap> {
    let mut map = HemisphereMap::dark(arguments.size)?;
    let optics = optics.for_directions(&arguments.colour, field, console)?;
    if let Some(wavelength) = arguments.wavelength {
        optics.reflectance.check_wavelength(wavelength)?;
    }
    let shortest = arguments.wavelength.unwrap_or(SHORTEST);
    let parts = PixelParts::new(optics.coherence, field, arguments.size, shortest);
    let toward = |light: &crate::scene::FarLight| (direction(light.theta, light.phi), light.intensity);
    let lights = arguments.light.iter().map(toward).collect();
    let light = MapLight { lights, wavelength: arguments.wavelength };
    let settings = SourceSettings { shortest, ..SourceSettings::new(optics) };
    prepare::for_each_window(console, field, &settings, |brdf, share| {
        let parts = map.parts_of(brdf, parts);
        warn(parts, console);
        let directions = parts.directions(arguments.size) * light.lights.len();
        let bar = ProgressBar::over(console, DIRECTIONS, "a smaller --size", directions);
        // Figures alone say it.
        if arguments.plot.is_some() {
            map.of_orders = light.albedo(brdf, &bar.task_of_parts())?;
        }
        let ask = &mut |brdf: &dyn crate::brdf::Brdf, pairs: &[_]| {
            evaluation::ask(brdf, pairs, light.wavelength, &bar)
        };
        map.add(brdf, &light, parts, share, ask)
    })?;
    Ok(map)
}

/// Warns of lobes between the directions of a pixel.
fn warn(parts: PixelParts, console: &Console) {
    if let Some(times) = parts.lack() {
        console.say(&format_args!(
            "a pixel has {0} x {0} directions, {times} times too few along each side for orders as narrow as those of this light: a \
             larger --size has more of them",
            parts.count
        ));
    }
}
