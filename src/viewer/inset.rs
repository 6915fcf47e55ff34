//! Inset of the BRDF of one light over the hemisphere.

use crate::error::Result;
use crate::optics::color;
use crate::optics::geometry::{Pair, direction};
use crate::render::evaluator::Query;
use crate::render::renderer::Renderer;
use crate::scene::FarLight;
use glam::DVec3;

/// Points along a side of a small or moving inset, and of a large one.
const SIDE: usize = 72;
const FINE_SIDE: usize = 180;

/// Requested hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsetRequest {
    /// Light.
    pub light: FarLight,
    /// True if it is large and at rest.
    pub fine: bool,
}

impl InsetRequest {
    fn side(self) -> usize {
        if self.fine { FINE_SIDE } else { SIDE }
    }
}

/// BRDF of a flat piece of the surface toward every direction, seen from above, as mapped by `diffract brdf`.
#[derive(Clone, Debug, PartialEq)]
pub struct Inset {
    /// Request.
    pub request: InsetRequest,
    /// Points along a side.
    pub side: usize,
    /// sRGB of each point from the upper left, `None` below the horizon.
    pub points: Vec<Option<[u8; 3]>>,
}

/// Returns ω_r of point `index` of `side` points along a side; `None` outside the disc.
fn view(index: usize, side: usize) -> Option<DVec3> {
    let centre = |i: usize| 2.0 * (i as f64 + 0.5) / side as f64 - 1.0;
    let (x, y) = (centre(index % side), -centre(index / side));
    let z = 1.0 - x * x - y * y;
    (z > 0.0).then(|| DVec3::new(x, y, z.sqrt()))
}

/// Evaluates the BRDF for the light of `request` with the source of `renderer`. The 97th percentile of brightness is
/// displayed as white.
///
/// # Errors
/// Fails if the device is lost.
pub fn hemisphere(renderer: &mut Renderer, request: InsetRequest) -> Result<Inset> {
    let (light, side) = (request.light, request.side());
    let toward = direction(light.theta.min(89.9), light.phi);
    let views: Vec<Option<DVec3>> = (0..side * side).map(|index| view(index, side)).collect();
    let query = |&view: &DVec3| Query { pair: Pair::new(toward, view), wavelength: None };
    let queries: Vec<Query> = views.iter().flatten().map(query).collect();
    let rgb: Vec<DVec3> =
        renderer.cosine_weighted(&queries)?.into_iter().map(color::xyz_to_linear_srgb).collect();
    let mut brightness: Vec<f64> = rgb.iter().map(|c| c.max_element()).collect();
    brightness.sort_by(f64::total_cmp);
    let white = brightness.get(brightness.len() * 97 / 100).copied().unwrap_or(1.0).max(1e-12);
    let mut colors = rgb.into_iter().map(|c| color::display(c / white, 0.0));
    let points = views.iter().map(|v| v.and_then(|_| colors.next())).collect();
    Ok(Inset { request, side, points })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_views_with_y_up_and_corners_are_none() {
        assert_eq!(view(0, SIDE), None);
        let top = view(SIDE / 2, SIDE).unwrap();
        assert!(top.y > 0.9 && (top.length() - 1.0).abs() < 1e-12);
        let right = view(SIDE * (SIDE / 2) + SIDE - 1, SIDE).unwrap();
        assert!(right.x > 0.9 && right.z > 0.0);
    }
}
