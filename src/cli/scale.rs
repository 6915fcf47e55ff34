//! Size of a pixel on the surface relative to the light's coherence: is the mean over coherence areas a good approximation?

use super::console::Console;
use crate::error::Result;
use crate::optics::coherence::Coherence;
use crate::render::footprints::median_pixel_area;
use crate::render::frame::View;
use crate::render::renderer::Renderer;
use crate::scene::Scene;

/// Coherence areas in a pixel below which single areas still show as grain: the standard deviation of the mean of ten independent areas of
/// fully developed speckle is a third of the mean (1/√10; Goodman, Speckle Phenomena in Optics, 3.1).
const FEWEST: f64 = 10.0;
const MICROMETRES_PER_METRE: f64 = 1e6;

/// Pixels that the pixel filter, the quadratic B-spline B, averages over: 1/∫B² = 20/11 along each axis.
const FILTERED_PIXELS: f64 = (20.0 / 11.0) * (20.0 / 11.0);

/// Prints the number of coherence areas in the median covered pixel of `view`, and a warning if a pixel of a picture of these `samples` averages over few.
///
/// # Errors
/// A lost device.
pub fn tell(
    renderer: &mut Renderer,
    view: &View,
    scene: &Scene,
    coherence: Coherence,
    samples: u32,
    console: &Console,
) -> Result<()> {
    let Coherence::Gaussian { length } = coherence else { return Ok(()) };
    if console.is_quiet() || view.light_count() == 0 {
        return Ok(());
    }
    let Some(area) = median_pixel_area(renderer, view)? else { return Ok(()) };
    let micrometres = scene.unit * MICROMETRES_PER_METRE;
    let areas = area * micrometres.powi(2) / length.powi(2);
    console.detail(&format_args!(
        "a pixel shows {:.3} mm2 of the surface (median), {areas:.3} coherence areas of ({length} um)2; a unit of the scene is {} m",
        area * (scene.unit * 1e3).powi(2),
        // Rounded to a nanometre: no unit is known better.
        (scene.unit * 1e9).round() / 1e9
    ));
    // A single sample is not filtered.
    let averaged = if samples > 1 { FILTERED_PIXELS * areas } else { areas };
    if averaged < FEWEST {
        console.say(&format_args!(
            "a pixel averages over {averaged:.1} coherence areas of ({length} um)2 (median): with fewer than {FEWEST} the mean over them is not what is \
             seen; step back, take a smaller --size or a larger `scale` of the scene"
        ));
    }
    Ok(())
}
