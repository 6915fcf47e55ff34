//! The picture that f64 optics give for the very directions that a frame shaded: only shading differs.

use super::frame::View;
use super::picture::Directions;
use super::sampling::{Sample, Sampling};
use super::shading::Shading;
use crate::error::Result;
use crate::optics::brdf::schlick;
use crate::optics::color::{self, xyz_to_linear_srgb};
use crate::optics::geometry::Pair;
use crate::optics::nufft::{self, Progress};
use crate::optics::reference::Reference;
use crate::surface::HeightField;
use glam::{DVec3, DVec4};
use std::f64::consts::PI;

/// Shades `directions` (one entry per light of `view`) in f64. RGBA as [`super::picture::Picture::radiance`]. A pigment
/// texture does not count.
///
/// # Errors
/// As [`nufft::cosine_weighted_xyz`].
pub fn reference_picture(
    field: &HeightField,
    shading: &Shading,
    view: &View,
    directions: &[Directions],
    progress: Progress<'_>,
) -> Result<Vec<[f32; 4]>> {
    let covered = covered(directions);
    let mut picture = vec![[0.0; 4]; directions.first().map_or(0, |d| d.view.len())];
    let colors = reference_pixels(field, shading, view, directions, &covered, progress)?;
    for (pixel, color) in covered.into_iter().zip(colors) {
        picture[pixel] = color.as_vec3().extend(1.0).to_array();
    }
    Ok(picture)
}

/// Linear sRGB of the pixels number `pixels` of a frame, as [`reference_picture`] has them.
///
/// # Errors
/// As [`nufft::cosine_weighted_xyz`].
pub fn reference_pixels(
    field: &HeightField,
    shading: &Shading,
    view: &View,
    directions: &[Directions],
    pixels: &[usize],
    progress: Progress<'_>,
) -> Result<Vec<DVec3>> {
    let reference = Reference::new(field, shading.coherence, shading.windows, shading.ior);
    let pairs: Vec<Pair> = directions
        .iter()
        .flat_map(|seen| pixels.iter().map(|&i| Pair::new(unit(seen.light[i]), unit(seen.view[i]))))
        .collect();
    let diffracted = nufft::cosine_weighted_xyz(&reference, &shading.illuminant, &pairs, progress)?;
    let mut colors = vec![DVec3::ZERO; pixels.len()];
    let lit = pairs.chunks(pixels.len().max(1)).zip(diffracted.chunks(pixels.len().max(1)));
    for (light, (pairs, diffracted)) in view.lights.iter().zip(lit) {
        for (color, (pair, xyz)) in colors.iter_mut().zip(pairs.iter().zip(diffracted)) {
            if !pair.above_horizon() {
                continue;
            }
            let reflectance = schlick(shading.ior, pair.cos_half_angle());
            let pigmented = view.base_color.as_dvec3() * ((1.0 - reflectance) * pair.light.z / PI);
            *color += (xyz_to_linear_srgb(*xyz) + pigmented) * (light.intensity * PI);
        }
    }
    Ok(colors)
}

/// The pixels that the mesh covers.
pub fn covered(directions: &[Directions]) -> Vec<usize> {
    let pixels = directions.first().map_or(0, |seen| seen.view.len());
    (0..pixels).filter(|&i| directions.iter().any(|seen| seen.view[i][3] != 0.0)).collect()
}

/// What a display shows of `radiance`, whose colours are premultiplied by their alpha, by the f64 twin of the display pass.
pub fn displayed(radiance: &[[f32; 4]], exposure: f64, background: DVec3) -> Vec<[u8; 4]> {
    let shown = |pixel: &[f32; 4]| {
        let [r, g, b, coverage] = pixel.map(f64::from);
        let [r, g, b] = if coverage > 0.0 {
            color::display_over(DVec3::new(r, g, b) / coverage, exposure, coverage, background)
        } else {
            color::display(background, 0.0)
        };
        [r, g, b, 255]
    };
    radiance.iter().map(shown).collect()
}

/// The mean of `sampling`'s samples, each shaded in f64, for the pixels that are `chosen` by their number; the others stay empty.
/// `directions` gives those of a sample, one entry per light of `view`. RGBA as [`super::picture::Picture::radiance`]. Each sample shows what
/// is seen in one direction: the part of the pixel filter that is the samples' footprint is not averaged over.
///
/// # Errors
/// As [`nufft::cosine_weighted_xyz`], and what `directions` returns.
pub fn reference_mean(
    field: &HeightField,
    shading: &Shading,
    view: &View,
    sampling: &Sampling,
    directions: &mut dyn FnMut(&Sample) -> Result<Vec<Directions>>,
    chosen: &dyn Fn(usize) -> bool,
    progress: Progress<'_>,
) -> Result<Vec<[f32; 4]>> {
    let count = sampling.count.max(1);
    let mut sum: Vec<DVec4> = Vec::new();
    for index in 0..count {
        let seen = directions(&sampling.sample(index))?;
        sum.resize(seen.first().map_or(0, |seen| seen.view.len()), DVec4::ZERO);
        let mut pixels = covered(&seen);
        pixels.retain(|&pixel| chosen(pixel));
        let colors = reference_pixels(field, shading, view, &seen, &pixels, &|done, of| {
            progress(index as usize * of + done, count as usize * of)
        })?;
        for (pixel, color) in pixels.into_iter().zip(colors) {
            sum[pixel] += color.extend(1.0);
        }
    }
    Ok(sum.into_iter().map(|pixel| (pixel / f64::from(count)).as_vec4().to_array()).collect())
}

/// A direction of the frame, in f64 and of unit length to its last bit.
fn unit([x, y, z, _]: [f32; 4]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()).normalize_or_zero()
}
