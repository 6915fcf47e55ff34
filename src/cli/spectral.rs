//! What pictures by `--method spectral` are shaded from: layers of the window, or of one period and how it repeats.

use super::prepare;
use crate::error::Result;
use crate::measure::cost::Cost;
use crate::optics::coherence::Coherence;
use crate::optics::geometry::Pair;
use crate::optics::orders::{Colours, Repeats};
use crate::optics::spectrum::SHORTEST;
use crate::precompute::Layers;
use crate::render::picture::{Directions, Painter};
use crate::render::resources::Optics;
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;

/// Layers, and how they repeat where there is no window.
pub struct Spectral {
    /// The layers.
    pub layers: Layers,
    repeats: Option<(Repeats, Colours)>,
    tolerance: f64,
}

impl Spectral {
    /// For `field` under `shading` on `device`: layers from the cache, or made with a progress bar.
    ///
    /// # Errors
    /// For settings that layers cannot do, and where they do not fit.
    pub fn prepare(field: &HeightField, shading: &Shading, device: &Device) -> Result<Self> {
        let tolerance = shading.quadrature();
        let Coherence::Repeats(copies) = shading.coherence else {
            let layers = prepare::layers(field, shading, SHORTEST, device)?;
            return Ok(Self { layers, repeats: None, tolerance });
        };
        shading.check_wavelengths()?;
        let layers = prepare::windowed_layers(field, shading, f64::INFINITY, SHORTEST, device)?;
        let repeats = Repeats { copies, period: field.patch_size() };
        let colours = Colours::new(&shading.illuminant, tolerance);
        Ok(Self { layers, repeats: Some((repeats, colours)), tolerance })
    }

    /// As a painter takes it.
    pub fn optics(&self) -> Optics<'_> {
        match &self.repeats {
            Some((repeats, _)) => Optics::Repeats(&self.layers, *repeats),
            None => Optics::Layers(&self.layers),
        }
    }

    /// Whether [`Spectral::check`] needs the directions of a picture.
    pub fn repeats(&self) -> bool {
        self.repeats.is_some()
    }

    /// Fails where a colour of a picture of `directions` (one entry per light) would take too many wavelengths.
    ///
    /// # Errors
    /// With their number.
    pub fn check(&self, directions: &[Directions]) -> Result<()> {
        let Some((repeats, colours)) = &self.repeats else { return Ok(()) };
        let uvs = directions.iter().flat_map(|seen| {
            let covered = seen.light.iter().zip(&seen.view).filter(|(_, view)| view[3] != 0.0);
            covered.map(|(light, view)| {
                let vector = |v: &[f32; 4]| glam::Vec3::new(v[0], v[1], v[2]).as_dvec3();
                Pair::new(vector(light), vector(view)).uvw().truncate()
            })
        });
        uvs.map(|uv| repeats.sampling(uv, colours.lag, self.tolerance))
            .max_by(|a, b| a.wavelengths().total_cmp(&b.wavelengths()))
            .map_or(Ok(()), |most| repeats.check(&most))
    }

    /// What a frame of `painter` does that shades `directions`.
    pub fn cost(&self, painter: &Painter, directions: &[Directions]) -> Cost {
        match &self.repeats {
            Some((repeats, colours)) => {
                Cost::of_repeats(&self.layers, (repeats, colours, self.tolerance), directions)
            }
            None => Cost::of(&self.layers, painter.combs(), directions),
        }
    }
}
