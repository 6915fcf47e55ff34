//! The front of the library: what programs build on. Everything behind it may change in any version.
//!
//! It takes and returns numbers, arrays and its own types. Lengths are micrometres, angles degrees, directions unit vectors away from the surface in
//! its tangent frame: x along the rows of the height field, y up in its picture, z out of the surface.

mod brdf;
mod colours;
mod optics;
mod peaks;
#[cfg(feature = "vulkan")]
mod picture;
mod scene;
mod surface;
#[cfg(not(feature = "vulkan"))]
#[path = "no_windows.rs"]
mod windows;
#[cfg(feature = "vulkan")]
mod windows;

pub use brdf::{GratingOrder, SurfaceBrdf};
pub use colours::{SurfaceColours, check_export};
pub use peaks::{AngularPeak, MeasuredPeriod, PeakSettings, SurfacePeaks};
#[cfg(feature = "vulkan")]
pub use picture::{PictureDifference, draw};
pub use surface::SurfaceMeasures;

use crate::optics::geometry::Pair;
use glam::DVec3;

/// Returns the unit vector at the polar angle `theta` from the normal and the azimuth `phi` from +x toward +y \[degrees\].
pub fn direction(theta: f64, phi: f64) -> [f64; 3] {
    crate::optics::geometry::direction(theta, phi).to_array()
}

/// Returns the linear sRGB of a colour in XYZ.
pub fn linear_srgb(xyz: [f64; 3]) -> [f64; 3] {
    crate::optics::color::xyz_to_linear_srgb(xyz.into()).to_array()
}

/// Returns the 8-bit sRGB that shows a colour of linear sRGB after an exposure of so many `stops`. Colours out of gamut lose saturation, and keep their hue.
pub fn display_srgb(linear: [f64; 3], stops: f64) -> [u8; 3] {
    crate::optics::color::display(linear.into(), stops)
}

/// Returns the pair of directions to the light and to the viewer.
fn pair([light, view]: &[[f64; 3]; 2]) -> Pair {
    Pair::new(DVec3::from(*light), DVec3::from(*view))
}

#[cfg(test)]
mod tests {
    use crate::context::Context;
    use crate::error::Error;
    use crate::front::{SurfaceBrdf, SurfaceColours};
    use crate::scene::Scene;
    use crate::settings::Optics;
    use crate::surface::HeightField;
    use crate::task::Task;

    #[test]
    fn public_types_cross_threads_and_own_what_they_hold() {
        const fn crosses<T: Send + Sync + Clone + 'static>() {}
        const {
            crosses::<Context>();
            crosses::<Error>();
            crosses::<HeightField>();
            crosses::<Optics>();
            crosses::<Scene>();
            crosses::<SurfaceBrdf>();
            crosses::<SurfaceColours>();
            crosses::<Task>();
        }
    }
}
