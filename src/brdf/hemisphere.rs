//! Maps of the hemisphere of view directions: averages over pixels, evaluated in tiles.
//!
//! A method that averages over footprints has a Gaussian of standard deviation half a pixel for each, as pictures have. Others answer
//! several directions in each pixel.

use super::Brdf;
use crate::error::Result;
use crate::memory;
use crate::optics::coherence::Coherence;
use crate::optics::color;
use crate::optics::geometry::Pair;
use crate::optics::quadrature::gauss_legendre;
use crate::spectra::power::Blur;
use crate::surface::HeightField;
use crate::task::Task;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Directions that are evaluated together: memory beside the map stays at a few megabytes.
const AT_ONCE: u32 = 16_384;

/// Light of a map and the wavelength that it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MapLight {
    /// Direction and intensity of each light.
    pub lights: Vec<(DVec3, f64)>,
    /// Single wavelength \[µm\]; `None` for the colour.
    pub wavelength: Option<f64>,
}

/// Evaluates f \[sr⁻¹\] of pairs of directions, in order: three times the value at the wavelength of the map, or the XYZ of the colour.
pub type Ask<'a> = dyn FnMut(&dyn Brdf, &[Pair]) -> Result<Vec<DVec3>> + 'a;

/// A square map, row by row from the top: linear sRGB \[sr⁻¹\], alpha 1 in the disc, 0 outside. At a single wavelength the
/// three channels are equal.
#[derive(Clone, Debug)]
pub struct HemisphereMap {
    /// Pixels on a side.
    pub side: u32,
    /// All pixels.
    pub pixels: Vec<[f32; 4]>,
    /// Sum over the orders of the share of the lights that is sent into all directions; `None` if the method does not sum orders, or if nobody
    /// asks for it.
    pub of_orders: Option<f64>,
}

impl HemisphereMap {
    /// Returns a map of `side` pixels along each side without light.
    ///
    /// # Errors
    /// Fails if there is too little memory.
    pub fn dark(side: u32) -> Result<Self> {
        let count = u64::from(side) * u64::from(side);
        // Memory of the map, its displayed copy and the encoder of a picture.
        memory::ensure_room(count * 48, "the map")?;
        Ok(Self { side, pixels: vec![[0.0; 4]; count as usize], of_orders: None })
    }

    /// Averages all further answers of `brdf` over the pixels of this map, if it can; returns the `parts` of a pixel that are left to ask for.
    pub fn parts_of(&self, brdf: &mut dyn Brdf, parts: PixelParts) -> PixelParts {
        if brdf.average_over(Self::of_pixel(self.side)) { PixelParts::ONE } else { parts }
    }

    /// Returns the standard deviation of the filter of a pixel of a map of `side` pixels, half of what (u, v) changes by from one to the next.
    pub fn of_pixel(side: u32) -> f64 {
        1.0 / f64::from(side)
    }

    /// Adds the light of `brdf`, times its `share` in a mean over windows: `ask` answers the `parts` of each pixel.
    ///
    /// # Errors
    /// Fails with the error of `ask`.
    pub fn add(
        &mut self,
        brdf: &dyn Brdf,
        light: &MapLight,
        parts: PixelParts,
        share: f64,
        ask: &mut Ask<'_>,
    ) -> Result<()> {
        let side = self.side;
        let rule = gauss_legendre(parts.count);
        // A tile of whole rows at a time.
        let rows = (AT_ONCE / (side * parts.count.pow(2))).max(1);
        for first in (0..side).step_by(rows as usize) {
            let tile: Vec<_> = views(side, first..side.min(first + rows)).collect();
            let parts: Vec<_> = tile.iter().map(|(_, view)| views_of_pixel(side, *view, &rule)).collect();
            let asked: Vec<DVec3> = parts.iter().flatten().map(|(view, _)| *view).collect();
            let mut values = light.shade(brdf, &asked, ask)?.into_iter();
            for ((place, _), parts) in tile.iter().zip(&parts) {
                let values = values.by_ref().take(parts.len()).zip(parts);
                let mean: DVec3 = values.map(|(value, (_, weight))| value * *weight).sum();
                let [r, g, b, _] = self.pixels[*place];
                let sum = Vec3::new(r, g, b) + (mean * share).as_vec3();
                self.pixels[*place] = sum.extend(1.0).to_array();
            }
        }
        Ok(())
    }

    /// Returns the value of each pixel \[sr⁻¹\]: the BRDF at a single wavelength, the luminance of a colour. NaN outside the disc.
    pub fn values(&self) -> Vec<f64> {
        // The row of Y in XYZ from linear sRGB (IEC 61966-2-1); the weights add up to 1.
        let luminance = |[r, g, b, _]: [f32; 4]| {
            0.212_639 * f64::from(r) + 0.715_169 * f64::from(g) + 0.072_192 * f64::from(b)
        };
        self.pixels.iter().map(|p| if p[3] > 0.0 { luminance(*p) } else { f64::NAN }).collect()
    }

    /// Returns the albedo toward the upper hemisphere, ∫ f cos θ_r dω_r: the sum over the orders, or over the pixels, because on the disc of direction
    /// cosines cos θ dω is the area.
    pub fn albedo(&self) -> f64 {
        if let Some(sum) = self.of_orders {
            return sum;
        }
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
        Self { side, pixels, of_orders: self.of_orders }
    }
}

impl MapLight {
    /// Returns the linear sRGB toward `views`, all lights summed.
    fn shade(&self, brdf: &dyn Brdf, views: &[DVec3], ask: &mut Ask<'_>) -> Result<Vec<DVec3>> {
        let mut sums = vec![DVec3::ZERO; views.len()];
        for (toward, intensity) in &self.lights {
            let pairs: Vec<Pair> = views.iter().map(|view| Pair::new(*toward, *view)).collect();
            let values = ask(brdf, &pairs)?;
            sums.iter_mut().zip(values).for_each(|(sum, f)| *sum += f * *intensity);
        }
        let rgb = |sum: DVec3| self.wavelength.map_or_else(|| color::xyz_to_linear_srgb(sum), |_| sum);
        Ok(sums.into_iter().map(rgb).collect())
    }

    /// Returns the sum over the orders of the share of all lights that `brdf` sends into all directions, as a map sums it; `None` if it does not sum
    /// orders.
    ///
    /// # Errors
    /// Those of [`Brdf::albedo`].
    pub fn albedo(&self, brdf: &dyn Brdf, task: &Task) -> Result<Option<f64>> {
        let mut sum = 0.0;
        for (toward, intensity) in &self.lights {
            let Some(sent) = brdf.albedo(*toward, self.wavelength, task)? else { return Ok(None) };
            sum += sent * intensity;
        }
        Ok(Some(sum))
    }
}

/// Directions in each pixel of a map whose method answers single directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelParts {
    /// Number along each side of a pixel.
    pub count: u32,
    /// Number that would resolve the lobes of the light.
    needed: f64,
}

impl PixelParts {
    /// Middle of the pixel alone.
    pub const ONE: Self = Self { count: 1, needed: 1.0 };
    /// Largest number along a side.
    const MOST: u32 = 8;

    /// Returns the parts that resolve the lobes of light of this `coherence` on a map of `side` pixels, at the wavelength `shortest` \[µm\].
    pub fn new(coherence: Coherence, field: &HeightField, side: u32, shortest: f64) -> Self {
        /// Mean distance of directions that resolves the light through a Gaussian window, in standard deviations of its lobe, and the light of n copies, in
        /// distances between the zeros of an order. One direction more makes up for the ends of a pixel.
        const OF_DEVIATION: f64 = 1.0;
        const OF_ORDER: f64 = 0.6;
        let largest_step = match coherence {
            Coherence::Gaussian { length } => {
                OF_DEVIATION * Blur::of_coherence(length / 4.0).variance[0].sqrt() * shortest
            }
            Coherence::Repeats(copies) => {
                let sides = [0, 1].map(|axis| f64::from(copies[axis]) * field.patch_size()[axis]);
                OF_ORDER * shortest / sides[0].max(sides[1])
            }
        };
        let needed = (2.0 / (f64::from(side) * largest_step)).ceil() + 1.0;
        Self { count: needed.min(f64::from(Self::MOST)) as u32, needed }
    }

    /// Returns by how many times there are too few directions along each side for the lobes; `None` if there are enough.
    pub fn lack(self) -> Option<f64> {
        let count = f64::from(self.count);
        (self.needed > count).then(|| (self.needed / count).ceil())
    }

    /// Returns the number of directions of a map of `side` pixels.
    pub fn directions(self, side: u32) -> usize {
        views(side, 0..side).count() * (self.count as usize).pow(2)
    }
}

/// Returns the pixels of the disc in `rows` of a map of `side` pixels, and ω_r of each: pixel centre (i+½, j+½) is (s_x, s_y, √(1 − s²)),
/// s_x = 2(i+½)/N − 1, s_y = 1 − 2(j+½)/N.
pub fn views(side: u32, rows: Range<u32>) -> impl Iterator<Item = (usize, DVec3)> {
    let centre = move |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
    let pixel = move |(i, j): (u32, u32)| {
        let place = j as usize * side as usize + i as usize;
        above(centre(i), -centre(j)).map(|view| (place, view))
    };
    rows.flat_map(move |j| (0..side).map(move |i| (i, j))).filter_map(pixel)
}

/// Returns directions in the pixel whose middle is `view`, of a map of `side` pixels, and their weights in the mean: by `rule` along each side, or evenly over what is above
/// the horizon.
fn views_of_pixel(side: u32, view: DVec3, rule: &[(f64, f64)]) -> Vec<(DVec3, f64)> {
    /// Directions along a side of a pixel that the horizon cuts.
    const AT_HORIZON: u32 = 8;
    let pixel = 2.0 / f64::from(side);
    let at = |x: f64, y: f64| above(view.x + pixel * (x - 0.5), view.y + pixel * (y - 0.5));
    let whole: Option<Vec<_>> = rule
        .iter()
        .flat_map(|(x, a)| rule.iter().map(move |(y, b)| (x, y, a * b)))
        .map(|(x, y, weight)| at(*x, *y).map(|view| (view, weight)))
        .collect();
    whole.unwrap_or_else(|| {
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(AT_HORIZON);
        let places = (0..AT_HORIZON).flat_map(|i| (0..AT_HORIZON).map(move |j| (i, j)));
        let views: Vec<DVec3> = places.filter_map(|(i, j)| at(middle(i), middle(j))).collect();
        let weight = 1.0 / views.len() as f64;
        views.into_iter().map(|view| (view, weight)).collect()
    })
}

/// Returns the direction of these cosines above the surface; `None` beyond the horizon.
fn above(x: f64, y: f64) -> Option<DVec3> {
    let z = 1.0 - x * x - y * y;
    (z > 0.0).then(|| DVec3::new(x, y, z.sqrt()))
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
        let map = HemisphereMap { side, pixels, of_orders: None };
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
