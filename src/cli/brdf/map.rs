//! Maps of the hemisphere: directions, evaluated in tiles.

use super::Arguments;
use crate::brdf::Brdf;
use crate::cli::options::OpticsOptions;
use crate::cli::say;
use crate::cli::{evaluation, prepare};
use crate::error::Result;
use crate::memory;
use crate::optics::color;
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::SHORTEST;
use crate::settings::Method;
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use glam::{DVec3, Vec3};
use indicatif::ProgressBar;

/// Number of directions by the direct sum from which a warning is shown.
const MANY_SUMS: usize = 5_000;

/// A square map, row by row from the top: linear sRGB \[sr⁻¹\], alpha 1 in the disc, 0 outside. At a single wavelength the
/// three channels are equal.
#[derive(Clone, Debug)]
pub struct HemisphereMap {
    /// Pixels on a side.
    pub side: u32,
    /// All pixels.
    pub pixels: Vec<[f32; 4]>,
}

impl HemisphereMap {
    /// Evaluates the map of `field` that `arguments` describe, by `optics`.
    pub fn of(arguments: &Arguments, optics: &OpticsOptions, field: &HeightField) -> Result<Self> {
        let side = arguments.size;
        let count = u64::from(side) * u64::from(side);
        // Memory of the map, its displayed copy and the encoder of a picture.
        memory::ensure_room(count * 48, "the map")?;
        let optics = optics.for_directions(&arguments.colour, field)?;
        let directions = views(side, 0..side).count() * arguments.light.len();
        if optics.method == Method::Reference && directions > MANY_SUMS {
            say(&format_args!("{directions} direct sums take their time; a smaller --size is faster"));
        }
        if let Some(wavelength) = arguments.wavelength {
            optics.reflectance.check_wavelength(wavelength)?;
        }
        let shortest = arguments.wavelength.unwrap_or(SHORTEST);
        let mut pixels = vec![[0.0; 4]; count as usize];
        // A tile of whole rows at a time, so that memory beside the map stays at a few megabytes.
        let rows = (evaluation::AT_ONCE as u32 / side).max(1);
        let settings = SourceSettings { shortest, ..SourceSettings::new(optics) };
        prepare::for_each_window(field, &settings, &arguments.device.wish(), |brdf, share| {
            let bar = evaluation::bar(directions);
            for first in (0..side).step_by(rows as usize) {
                let tile: Vec<_> = views(side, first..side.min(first + rows)).collect();
                for (&(place, _), rgb) in tile.iter().zip(shade(arguments, brdf, &tile, &bar)?) {
                    let [r, g, b, _] = pixels[place];
                    let sum = Vec3::new(r, g, b) + (rgb * share).as_vec3();
                    pixels[place] = sum.extend(1.0).to_array();
                }
            }
            bar.finish_and_clear();
            Ok(())
        })?;
        Ok(Self { side, pixels })
    }

    /// Returns the value of each pixel \[sr⁻¹\]: the BRDF at a single wavelength, the luminance of a colour. NaN outside the disc.
    pub fn values(&self) -> Vec<f64> {
        // The row of Y in XYZ from linear sRGB (IEC 61966-2-1); the weights add up to 1.
        let luminance = |[r, g, b, _]: [f32; 4]| {
            0.212_639 * f64::from(r) + 0.715_169 * f64::from(g) + 0.072_192 * f64::from(b)
        };
        self.pixels.iter().map(|p| if p[3] > 0.0 { luminance(*p) } else { f64::NAN }).collect()
    }

    /// Returns the albedo toward the upper hemisphere, ∫ f cos θ_r dω_r: on the disc of direction cosines cos θ dω is the area.
    pub fn albedo(&self) -> f64 {
        let pixel = (2.0 / f64::from(self.side)).powi(2);
        self.values().into_iter().filter(|f| !f.is_nan()).sum::<f64>() * pixel
    }

    /// Averages blocks of pixels until the side of the map is at most `most`.
    pub fn reduced(&self, most: u32) -> Self {
        let block = self.side.div_ceil(most);
        if block < 2 {
            return self.clone();
        }
        let side = self.side.div_ceil(block);
        let mean = |(i, j): (u32, u32)| {
            let within = |k: u32| k * block..((k + 1) * block).min(self.side);
            let cells = within(j).flat_map(|y| within(i).map(move |x| (y * self.side + x) as usize));
            let seen = cells.map(|place| self.pixels[place]).filter(|p| p[3] > 0.0);
            let (sum, count) = seen.fold(([0.0f32; 3], 0u32), |(sum, count), p| {
                ([sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]], count + 1)
            });
            let [r, g, b] = sum.map(|x| x / count.max(1) as f32);
            [r, g, b, if count > 0 { 1.0 } else { 0.0 }]
        };
        let pixels = (0..side).flat_map(|j| (0..side).map(move |i| (i, j))).map(mean).collect();
        Self { side, pixels }
    }
}

/// Returns the linear sRGB of the directions of `tile`, all lights summed.
fn shade(
    arguments: &Arguments,
    brdf: &mut dyn Brdf,
    tile: &[(usize, DVec3)],
    bar: &ProgressBar,
) -> Result<Vec<DVec3>> {
    let mut sums = vec![DVec3::ZERO; tile.len()];
    for light in &arguments.light {
        let toward = direction(light.theta, light.phi);
        let pairs: Vec<Pair> = tile.iter().map(|&(_, view)| Pair::new(toward, view)).collect();
        let values = evaluation::ask(brdf, &pairs, arguments.wavelength, bar)?;
        sums.iter_mut().zip(values).for_each(|(sum, f)| *sum += f * light.intensity);
    }
    let rgb = |sum: DVec3| arguments.wavelength.map_or_else(|| color::xyz_to_linear_srgb(sum), |_| sum);
    Ok(sums.into_iter().map(rgb).collect())
}

/// Returns the pixels of the disc in `rows` of a map of `side` pixels, and ω_r of each: pixel centre (i+½, j+½) is (s_x, s_y, √(1 − s²)),
/// s_x = 2(i+½)/N − 1, s_y = 1 − 2(j+½)/N.
pub fn views(side: u32, rows: std::ops::Range<u32>) -> impl Iterator<Item = (usize, DVec3)> {
    let centre = move |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
    let pixel = move |(i, j): (u32, u32)| {
        let (x, y) = (centre(i), -centre(j));
        let z = 1.0 - x * x - y * y;
        (z > 0.0).then(|| (j as usize * side as usize + i as usize, DVec3::new(x, y, z.sqrt())))
    };
    rows.flat_map(move |j| (0..side).map(move |i| (i, j))).filter_map(pixel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_centres_are_unit_vectors_with_y_up_and_the_corners_are_outside() {
        let views: Vec<_> = views(4, 0..4).collect();
        assert_eq!(views.len(), 12, "4 of 16 pixels are corners");
        let at = |i: usize, j: usize| views.iter().find(|(place, _)| *place == j * 4 + i).map(|(_, v)| *v);
        assert_eq!(at(0, 0), None);
        let (right, top) = (at(3, 1).unwrap(), at(2, 0).unwrap());
        assert_eq!((right.x, right.y, top.x, top.y), (0.75, 0.25, 0.25, 0.75));
        assert!(views.iter().all(|(_, v)| (v.length() - 1.0).abs() < 1e-15 && v.z > 0.0));
        assert_eq!(super::views(1, 0..1).collect::<Vec<_>>(), [(0, DVec3::Z)]);
    }

    #[test]
    fn a_map_of_one_over_pi_has_an_albedo_of_1_and_keeps_it_when_reduced() {
        let (side, white) = (512, std::f32::consts::FRAC_1_PI);
        let mut pixels = vec![[0.0; 4]; (side * side) as usize];
        views(side, 0..side).for_each(|(place, _)| pixels[place] = [white, white, white, 1.0]);
        let map = HemisphereMap { side, pixels };
        assert!((map.albedo() - 1.0).abs() < 1e-3, "{}", map.albedo());
        let small = map.reduced(100);
        assert_eq!(small.side, 86);
        assert!(
            small
                .values()
                .iter()
                .filter(|f| !f.is_nan())
                .all(|f| (f - std::f64::consts::FRAC_1_PI).abs() < 1e-6)
        );
    }
}
