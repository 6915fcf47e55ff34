//! What pictures by `--method spectral` are shaded from: layers of the window, or of one period and how it repeats.

use super::prepare;
use crate::error::Result;
use crate::measure::cost::Cost;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::Layers;
use crate::render::picture::{Directions, Painter};
use crate::render::repeating::Repeating;
use crate::render::resources::Optics;
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;

/// Layers, and how they repeat where there is no window.
pub struct Spectral {
    /// The layers.
    pub layers: Layers,
    repeats: Option<Repeating>,
}

impl Spectral {
    /// For `field` under `shading` on `device`: layers from the cache, or made with a progress bar.
    ///
    /// # Errors
    /// For settings that layers cannot do, and where they do not fit.
    pub fn prepare(field: &HeightField, shading: &Shading, device: &Device) -> Result<Self> {
        let Some(repeats) = Repeating::of(field, shading) else {
            let layers = prepare::layers(field, shading, SHORTEST, device)?;
            return Ok(Self { layers, repeats: None });
        };
        shading.check_wavelengths()?;
        let layers = prepare::windowed_layers(field, shading, f64::INFINITY, SHORTEST, device)?;
        Ok(Self { layers, repeats: Some(repeats) })
    }

    /// As a painter takes it.
    pub fn optics(&self) -> Optics<'_> {
        match &self.repeats {
            Some(repeating) => Optics::Repeats(&self.layers, repeating.repeats),
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
        self.repeats.as_ref().map_or(Ok(()), |repeating| repeating.check(directions))
    }

    /// What a frame of `painter` does that shades `directions`.
    pub fn cost(&self, painter: &Painter, directions: &[Directions]) -> Cost {
        match &self.repeats {
            Some(repeating) => Cost::of_repeats(&self.layers, repeating, directions),
            None => Cost::of(&self.layers, painter.combs(), directions),
        }
    }
}
