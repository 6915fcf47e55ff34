//! Pictures through repeats: how the patch repeats, and whether a colour takes more wavelengths than it may.

use super::picture::Directions;
use super::shading::Shading;
use crate::error::Result;
use crate::optics::coherence::Coherence;
use crate::optics::geometry::Pair;
use crate::optics::orders::{Colours, Repeats};
use crate::surface::HeightField;
use glam::Vec3;

/// Copies of a height field, and the colours that are summed through them.
pub struct Repeating {
    /// The copies.
    pub repeats: Repeats,
    /// The colour functions.
    pub colours: Colours,
    /// Relative error of the sum over wavelengths.
    pub tolerance: f64,
}

impl Repeating {
    /// The copies of `field` that `shading` names; `None` where it names a window.
    pub fn of(field: &HeightField, shading: &Shading) -> Option<Self> {
        let Coherence::Repeats(copies) = shading.coherence else { return None };
        let tolerance = shading.quadrature();
        let repeats = Repeats { copies, period: field.patch_size() };
        Some(Self { repeats, colours: Colours::new(&shading.illuminant, tolerance), tolerance })
    }

    /// Whether some directions may take more wavelengths than a colour may.
    pub fn has_limits(&self) -> bool {
        self.repeats.most_wavelengths(self.colours.lag) > self.repeats.limit()
    }

    /// Fails where a colour of a picture of `directions` (one entry per light) would take too many wavelengths.
    ///
    /// # Errors
    /// With their number.
    pub fn check(&self, directions: &[Directions]) -> Result<()> {
        let uvs = directions.iter().flat_map(|seen| {
            let covered = seen.light.iter().zip(&seen.view).filter(|(_, view)| view[3] != 0.0);
            covered.map(|(light, view)| {
                let vector = |v: &[f32; 4]| Vec3::new(v[0], v[1], v[2]).as_dvec3();
                Pair::new(vector(light), vector(view)).uvw().truncate()
            })
        });
        uvs.map(|uv| self.repeats.sampling(uv, self.colours.lag, self.tolerance))
            .max_by(|a, b| a.wavelengths().total_cmp(&b.wavelengths()))
            .map_or(Ok(()), |most| self.repeats.check(&most))
    }
}
