//! The picture that the direct f64 sum gives for the very directions that a frame shaded: only shading differs.

use super::frame::View;
use super::picture::Directions;
use super::shading::Shading;
use crate::error::Result;
use crate::optics::brdf::schlick;
use crate::optics::color::xyz_to_linear_srgb;
use crate::optics::geometry::Pair;
use crate::optics::reference::Reference;
use crate::surface::HeightField;
use glam::DVec3;
use std::f64::consts::PI;

/// Shades `directions` (one entry per light of `view`) by the direct sum. RGBA as [`super::picture::Picture::radiance`].
/// A pigment texture does not count. `progress(done, of)` is called once a pixel; an error from it ends the work.
///
/// # Errors
/// As [`Reference::cosine_weighted_xyz`], and what `progress` returns.
pub fn reference_picture(
    field: &HeightField,
    shading: &Shading,
    view: &View,
    directions: &[Directions],
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<Vec<[f32; 4]>> {
    let reference = Reference::new(field, shading.coherence, shading.windows, shading.ior);
    let pixels = directions.first().map_or(0, |d| d.view.len());
    let mut picture = vec![[0.0; 4]; pixels];
    for (index, pixel) in picture.iter_mut().enumerate() {
        progress(index, pixels)?;
        if directions.iter().all(|d| d.view[index][3] == 0.0) {
            continue;
        }
        let mut color = DVec3::ZERO;
        for (light, seen) in view.lights.iter().zip(directions) {
            let pair = Pair::new(unit(seen.light[index]), unit(seen.view[index]));
            if !pair.above_horizon() {
                continue;
            }
            let diffracted = xyz_to_linear_srgb(reference.cosine_weighted_xyz(&pair, &shading.illuminant)?);
            let reflectance = schlick(shading.ior, pair.cos_half_angle());
            let pigmented = view.base_color.as_dvec3() * ((1.0 - reflectance) * pair.light.z / PI);
            color += (diffracted + pigmented) * (light.intensity * PI);
        }
        *pixel = color.as_vec3().extend(1.0).to_array();
    }
    progress(pixels, pixels)?;
    Ok(picture)
}

/// A direction of the frame, in f64 and of unit length to its last bit.
fn unit([x, y, z, _]: [f32; 4]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()).normalize_or_zero()
}
