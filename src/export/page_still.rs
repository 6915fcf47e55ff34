//! The sphere of a page as a still picture, for browsers that cannot draw it: the twin of `assets/export/scene.glsl` for the view that the page opens with.

use super::page_light::PageLight;
use crate::filter::Covariance;
use crate::optics::color::{LUMINANCE, neutral, srgb_transfer, xyz_to_linear_srgb};
use crate::optics::geometry::Pair;
use crate::optics::reflectance::Reflectance;
use crate::scene::incident::mean_cosine;
use crate::table::{ColorTable, TableReader};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Width and height \[pixels\].
pub const SIDE: usize = 320;
/// Angles of the camera \[rad\], as the page opens with.
const YAW: f64 = -0.42;
const PITCH: f64 = 0.36;
/// x and y of the direction of the light, and the standard deviation of its directions \[degrees\].
const LIGHT: [f64; 2] = [0.28, 0.42];
const SPREAD: f64 = 0.501_187;
/// Distance of the eye in radii of the sphere, and focal length over half a side of the picture.
const DISTANCE: f64 = 4.75;
const FOCAL: f64 = 3.2;
/// Displayed albedo of the matt layer.
const PIGMENT: f64 = 0.07;
/// Standard deviation of the pixel filter \[pixels\].
const FILTER: f64 = 0.5;
/// Step between pixels at which the surroundings are evaluated, which change slowly.
const STEP: usize = 4;

/// Sphere under the light of a page.
struct Still<'a> {
    reader: TableReader,
    reflectance: &'a Reflectance,
    around: &'a PageLight,
    camera: DMat3,
    to_light: DVec3,
    /// Variance of the directions of the light.
    spread: f64,
    /// Variance of (u, v) of the specular order.
    lobe: f64,
}

/// Point of the sphere that a pixel shows.
struct Spot {
    /// Columns tangent, bitangent and normal.
    frame: DMat3,
    /// Unit vectors to the light and to the eye, in the frame.
    light: DVec3,
    view: DVec3,
    /// Distance from the edge, negative within.
    outside: f64,
}

/// Returns sRGB and cover of the pixels, row by row from the top, of a sphere of `table` in its light and with `around`. The table holds the reflectance but for
/// a mean of it.
pub fn sphere(table: &Arc<ColorTable>, reflectance: &Reflectance, around: &PageLight) -> Vec<[u8; 4]> {
    let (yaw, pitch) = (YAW.sin_cos(), PITCH.sin_cos());
    let back = DVec3::new(yaw.0 * pitch.1, pitch.0, yaw.1 * pitch.1);
    let right = DVec3::new(yaw.1, 0.0, -yaw.0);
    let [x, y] = LIGHT;
    let still = Still {
        reader: TableReader::new(Arc::clone(table)),
        reflectance,
        around,
        camera: DMat3::from_cols(right, back.cross(right), back),
        to_light: DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()),
        spread: SPREAD.to_radians().powi(2),
        lobe: table.header.specular.variances.first().copied().unwrap_or_default(), // no bands: no lobe
    };
    let parts = still.of_parts();
    let pixels: Vec<_> =
        (0..SIDE * SIDE).into_par_iter().map(|i| still.pixel([i % SIDE, i / SIDE], &parts)).collect();
    let exposure = exposure(&pixels);
    let shown = |(radiance, matt, cover): &(DVec3, DVec3, f64)| {
        let [r, g, b] = neutral(*radiance * exposure + *matt).to_array().map(|c| code(srgb_transfer(c)));
        [r, g, b, code(*cover)]
    };
    pixels.iter().map(shown).collect()
}

/// Returns the code of a number from 0 to 1.
fn code(share: f64) -> u8 {
    (255.0 * share.clamp(0.0, 1.0)).round() as u8
}

/// Returns the factor by which a high percentile of the luminance is nearly white.
fn exposure(pixels: &[(DVec3, DVec3, f64)]) -> f64 {
    const SHARE: f64 = 0.985;
    const WHITE: f64 = 1.3;
    let seen = pixels.iter().filter(|(_, _, cover)| *cover > 0.5);
    let mut bright: Vec<f64> = seen.map(|(radiance, ..)| LUMINANCE.dot(*radiance)).collect();
    bright.sort_by(f64::total_cmp);
    // Without a lit pixel the factor is 1.
    let high = bright.get((SHARE * bright.len() as f64) as usize).copied().unwrap_or_default();
    if high > 0.0 { (WHITE / high).clamp(2f64.powi(-20), 2f64.powi(20)) } else { 1.0 }
}

impl Still<'_> {
    /// Returns the point of the sphere at a place in the picture, x to the right and y upward \[pixels\]; beside the sphere, that of its edge.
    fn spot(&self, [x, y]: [f64; 2]) -> Spot {
        let half = 0.5 * SIDE as f64;
        let ray = (self.camera * DVec3::new(x / half - 1.0, y / half - 1.0, -FOCAL)).normalize();
        let eye = DISTANCE * self.camera.z_axis;
        let nearest = -eye.dot(ray);
        let miss = (eye + nearest * ray).length();
        let normal = (eye + (nearest - (1.0 - miss * miss).max(0.0).sqrt()) * ray).normalize();
        // The frame of the z axis, turned to the normal by the shortest way, as in scene.glsl.
        let share = 1.0 / (1.0 + normal.z).max(1e-4);
        let twist = -normal.x * normal.y * share;
        let frame = DMat3::from_cols(
            DVec3::new(1.0 - normal.x * normal.x * share, twist, -normal.x),
            DVec3::new(twist, 1.0 - normal.y * normal.y * share, -normal.y),
            normal,
        );
        let local = |v: DVec3| frame.transpose() * v;
        Spot {
            frame,
            light: local(self.to_light),
            view: local((eye - normal).normalize()),
            outside: miss - 1.0,
        }
    }

    /// Returns radiance, matt layer and cover of a pixel, whose column and row count from the top left.
    fn pixel(&self, [column, row]: [usize; 2], parts: &[[DVec3; 2]]) -> (DVec3, DVec3, f64) {
        let place = [column as f64 + 0.5, (SIDE - row) as f64 - 0.5];
        let here = self.spot(place);
        let (right, above) = (self.spot([place[0] + 1.0, place[1]]), self.spot([place[0], place[1] + 1.0]));
        let change = (right.outside - here.outside).hypot(above.outside - here.outside);
        let cover = (0.5 - here.outside / change.max(1e-6)).clamp(0.0, 1.0);
        if cover == 0.0 {
            return (DVec3::ZERO, DVec3::ZERO, 0.0);
        }
        let [scattered, irradiance] = between(parts, [column, row]);
        let direct = self.of_light(&here, &right, &above);
        let matt = DVec3::splat(here.light.z.max(0.0)) + irradiance / PI;
        (direct + self.mirrored(&here) + scattered, PIGMENT * matt, cover)
    }

    /// Returns the radiance that the light gives a pixel: `on_shape` and `widen` of scene.glsl.
    fn of_light(&self, here: &Spot, right: &Spot, above: &Spot) -> DVec3 {
        let uv = |spot: &Spot| -(spot.light + spot.view).truncate();
        let (dx, dy) = (FILTER * (uv(right) - uv(here)), FILTER * (uv(above) - uv(here)));
        let turn = FILTER * (right.view.z - here.view.z).hypot(above.view.z - here.view.z);
        let sink = FILTER * (right.light.z - here.light.z).hypot(above.light.z - here.light.z);
        let lit = (here.light.z / (2.0 * (self.spread + sink * sink).sqrt())).clamp(0.0, 1.0);
        let across = here.light.truncate();
        let of_pixel = Covariance::of_footprint(dx, dy, 1.0);
        let footprint = Covariance {
            uu: of_pixel.uu + self.spread * (1.0 - across.x * across.x),
            uv: of_pixel.uv - self.spread * across.x * across.y,
            vv: of_pixel.vv + self.spread * (1.0 - across.y * across.y),
        };
        let view = here.view.truncate().extend(here.view.z.max(turn.min(1.0)));
        let xyz = self.reader.xyz(&Pair::new(here.light, view), self.reflectance, &footprint);
        xyz_to_linear_srgb(xyz) * PI * lit
    }

    /// Returns the radiance of the surroundings in the mirrored direction, averaged over the specular order and the texels of the page's picture of them.
    fn mirrored(&self, here: &Spot) -> DVec3 {
        /// Points on either side of the middle, and the distance between two in standard deviations.
        const REACH: i32 = 2;
        const APART: f64 = 0.9;
        if here.view.z <= 1e-3 {
            return DVec3::ZERO;
        }
        let apart = APART * (self.lobe + self.around.texel().powi(2) / 4.0).sqrt();
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (i, j) in (-REACH..=REACH).flat_map(|i| (-REACH..=REACH).map(move |j| (i, j))) {
            let off = DVec2::new(f64::from(i), f64::from(j));
            let across = (off * apart - here.view.truncate()).clamp_length_max(0.999);
            let toward = here.frame * across.extend((1.0 - across.length_squared()).sqrt());
            let weight = (-0.5 * APART * APART * off.length_squared()).exp();
            sum += self.around.radiance(toward) * weight;
            weights += weight;
        }
        let mirrored = xyz_to_linear_srgb(self.reader.mirrored(here.view, self.reflectance));
        mirrored * sum / (weights * here.view.z)
    }

    /// Returns what all parts of the surroundings scatter to the eye, and their irradiance, at every [`STEP`]th column and row.
    fn of_parts(&self) -> Vec<[DVec3; 2]> {
        let columns = SIDE / STEP + 1;
        let sample = |i: usize| {
            let (column, row) = (STEP * (i % columns), STEP * (i / columns));
            let here = self.spot([column as f64, (SIDE - row) as f64]);
            let view = here.view.truncate().extend(here.view.z.max(0.05)).normalize();
            let local = here.frame.transpose();
            let each = self.around.parts.iter().map(|part| {
                let light = local * part.direction;
                let pair = Pair::new(light, view);
                let footprint = Covariance::round(part.variance.sqrt());
                let xyz = self.reader.scattered(&pair, self.reflectance, &footprint);
                let matt = part.irradiance * mean_cosine(light.z, part.mean);
                [xyz_to_linear_srgb(xyz) * part.irradiance, matt]
            });
            each.fold([DVec3::ZERO; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        (0..columns * columns).into_par_iter().map(sample).collect()
    }
}

/// Interpolates the samples of [`Still::of_parts`] at a pixel.
fn between(samples: &[[DVec3; 2]], pixel: [usize; 2]) -> [DVec3; 2] {
    let columns = SIDE / STEP + 1;
    let share = DVec2::from(pixel.map(|n| ((n % STEP) as f64 + 0.5) / STEP as f64));
    let [column, row] = pixel.map(|n| n / STEP);
    let at = |i: usize, j: usize| samples[(row + j) * columns + column + i];
    [0, 1].map(|k| {
        let along = |j| at(0, j)[k].lerp(at(1, j)[k], share.x);
        along(0).lerp(along(1), share.y)
    })
}
