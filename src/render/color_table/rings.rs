//! Where a bake samples: rings around the mirror direction, from which the table's square grid is interpolated.
//!
//! Along a ray from the mirror direction the sum over wavelengths is a convolution over log |(u, v)|: what one wavelength sends
//! here the next one sends a little further out. So a table is as smooth outward as the colour functions are, and only around
//! is it as fine as the window makes it. Rings whose distance grows with their radius take a small part of the samples that
//! the square grid has texels.

use super::aperture::Aperture;
use super::grid::Square;
use super::nodes::largest_w;
use super::pyramid::Planes;
use crate::optics::orders::Colours;
use crate::optics::quadrature::SPAN;
use crate::optics::spectrum::LONGEST;
use crate::render::tables::Combs;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of the tolerance that goes to interpolating between rings, and as much along them.
pub const RING_SHARE: f64 = 0.2;
/// A wavelength in the blue third of the spectrum \[µm\]: frequencies are (u, v)/λ.
pub const WAVELENGTH: f64 = 0.45;
/// Fewest samples of half a ring.
const FEWEST: usize = 4;

/// The rings; samples of half of each, u ≤ 0, since the bake gives (u, v) and −(u, v) together.
#[derive(Clone, Debug, PartialEq)]
pub struct Rings {
    /// |(u, v)| of each, growing from 0.
    pub radii: Vec<f64>,
    /// First sample of each, and the number of all.
    pub begins: Vec<usize>,
}

/// Values at the samples of all rings: those of (u, v) and −(u, v), so twice the samples; `width` floats each.
pub struct Samples {
    /// Floats of a sample.
    pub width: usize,
    /// Sample by sample: of each ring the half that is baked, then the half opposite.
    pub values: Vec<f32>,
}

impl Rings {
    /// Rings for `aperture` that leave a share of `tolerance` when a table is interpolated from them, out to |(u, v)| = `outer`.
    /// `height`: standard deviation of the heights \[µm\]; `z_max`: the largest k|w| \[rad/µm\].
    pub fn new(
        aperture: &Aperture,
        tolerance: f64,
        wavelengths: &Wavelengths<'_>,
        [height, z_max]: [f64; 2],
        outer: f64,
    ) -> Self {
        /// Neighbouring distances differ by little, as the error of the interpolation is told for equal ones.
        const GROWTH: f64 = 1.2;
        let allowed = (RING_SHARE * tolerance).powi(2);
        let kernel = KernelError::new();
        let fine = largest_step(allowed, |step| aperture.mean(|x| kernel.at(step * x))) / aperture.band();
        let (mut radii, mut distance) = (vec![0.0, fine], fine);
        while radii[radii.len() - 1] < outer || radii.len() < 4 {
            let radius = radii[radii.len() - 1];
            let spectrum = Spectrum::new(wavelengths, radius, aperture);
            // d(k|w|)/d log r at a fixed share of the largest |w|: how fast heights turn the phase.
            let turning = 2f64.sqrt() * height * z_max * 2.0 / largest_w(radius);
            let step = largest_step(allowed, |step| spectrum.error(step, turning, &kernel));
            distance = (step * radius).clamp(fine.min(distance), GROWTH * distance);
            radii.push(radius + distance);
        }
        let mut begins = vec![0];
        for radius in &radii {
            let count = (PI * radius / fine).ceil() as usize;
            begins.push(begins[begins.len() - 1] + count.max(FEWEST));
        }
        Self { radii, begins }
    }

    /// −(u, v) of every sample that is baked, ring by ring; the first component is not negative.
    pub fn places(&self) -> Vec<[f32; 2]> {
        let ring = |i: usize| {
            let count = self.count(i);
            (0..count).map(move |j| {
                let (sin, cos) = (PI * (j as f64 / count as f64 - 0.5)).sin_cos();
                [(self.radii[i] * cos).max(0.0) as f32, (self.radii[i] * sin) as f32]
            })
        };
        (0..self.radii.len()).flat_map(ring).collect()
    }

    /// Samples of half a ring.
    pub fn count(&self, ring: usize) -> usize {
        self.begins[ring + 1] - self.begins[ring]
    }

    /// The values of `samples` at the places of `grid`, a plane for each number.
    pub fn resampled(&self, grid: &Square, samples: &Samples) -> Planes {
        /// Rows at once, so that little memory is taken beside the planes.
        const ROWS: usize = 32;
        let mut planes: Planes = vec![vec![0.0; grid.side * grid.side]; samples.width];
        for first in (0..grid.side).step_by(ROWS) {
            let rows = first..(first + ROWS).min(grid.side);
            let values: Vec<Vec<f32>> =
                rows.clone().into_par_iter().map(|row| self.row(grid, samples, row)).collect();
            planes.par_iter_mut().enumerate().for_each(|(number, plane)| {
                for (row, values) in rows.clone().zip(&values) {
                    plane[row * grid.side..][..grid.side]
                        .copy_from_slice(&values[number * grid.side..][..grid.side]);
                }
            });
        }
        planes
    }

    /// One row of every plane.
    fn row(&self, grid: &Square, samples: &Samples, row: usize) -> Vec<f32> {
        let mut out = vec![0f32; samples.width * grid.side];
        let mut sum = vec![0f32; samples.width];
        let y = grid.at(row);
        for column in 0..grid.side {
            let x = grid.at(column);
            if x.hypot(y) <= grid.outer {
                sum.fill(0.0);
                self.add(samples, x, y, &mut sum);
                sum.iter().enumerate().for_each(|(number, value)| out[number * grid.side + column] = *value);
            }
        }
        out
    }

    /// Adds the value at (x, y) to `sum`, by cubic Lagrange interpolation along four rings and between them.
    fn add(&self, samples: &Samples, x: f64, y: f64, sum: &mut [f32]) {
        let (radius, angle) = (x.hypot(y), y.atan2(x));
        let last = self.radii.len() - 3;
        let left = self.radii.partition_point(|r| *r <= radius).saturating_sub(1).min(last) as i64;
        // Before the first ring comes the second one, seen from the other side.
        let rings = [-1, 0, 1, 2].map(|k| left + k);
        let at = rings.map(|i| self.radii[i.unsigned_abs() as usize] * if i < 0 { -1.0 } else { 1.0 });
        let across: [f64; 4] = std::array::from_fn(|k| {
            (0..4).filter(|&l| l != k).map(|l| (radius - at[l]) / (at[k] - at[l])).product()
        });
        for (ring, weight) in rings.into_iter().zip(across) {
            let angle = if ring < 0 { angle + PI } else { angle };
            let ring = ring.unsigned_abs() as usize;
            let around = 2 * self.count(ring) as i64;
            let place = (angle / PI + 0.5) * self.count(ring) as f64;
            let whole = place.floor();
            for (k, share) in cubic(place - whole).into_iter().enumerate() {
                let index = (whole as i64 + k as i64 - 1).rem_euclid(around) as usize;
                let value = &samples.values[(2 * self.begins[ring] + index) * samples.width..];
                let share = (share * weight) as f32;
                sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += share * value);
            }
        }
    }
}

/// Lagrange's weights of the neighbours at −1, 0, 1, 2 of a point at `t` ∈ \[0, 1\].
fn cubic(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

/// The largest step whose squared error is `allowed`, for an error that grows with the step.
fn largest_step(allowed: f64, error: impl Fn(f64) -> f64) -> f64 {
    /// Steps looked at: from far below to far above what any tolerance asks for.
    const RANGE: (f64, f64) = (1e-5, 3.0);
    let (mut low, mut high) = RANGE;
    for _ in 0..24 {
        let middle = (low * high).sqrt();
        if error(middle) <= allowed {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The mean square of what cubic Lagrange interpolation leaves of a unit wave, by its angle per step.
struct KernelError {
    table: Vec<f64>,
}

impl KernelError {
    /// Angles of the table; beyond, nothing of a wave is met.
    const MOST: f64 = 4.0;
    const ENTRIES: usize = 512;

    fn new() -> Self {
        const PHASES: usize = 16;
        let error = |angle: f64| {
            let at = |phase: usize| {
                let t = (phase as f64 + 0.5) / PHASES as f64;
                let (mut re, mut im) = (-1.0, 0.0);
                for (k, weight) in cubic(t).into_iter().enumerate() {
                    let (sin, cos) = (angle * (k as f64 - 1.0 - t)).sin_cos();
                    re += weight * cos;
                    im += weight * sin;
                }
                re * re + im * im
            };
            (0..PHASES).map(at).sum::<f64>() / PHASES as f64
        };
        Self {
            table: (0..=Self::ENTRIES).map(|i| error(Self::MOST * i as f64 / Self::ENTRIES as f64)).collect(),
        }
    }

    fn at(&self, angle: f64) -> f64 {
        let place = (angle.abs() / Self::MOST).min(1.0) * Self::ENTRIES as f64;
        let left = (place as usize).min(Self::ENTRIES - 1);
        self.table[left] + (self.table[left + 1] - self.table[left]) * (place - left as f64)
    }
}

/// What a table is summed over along a ray: its power over log |(u, v)|, by angles per unit, were every wavelength seen alike.
pub enum Wavelengths<'a> {
    /// Combs, which may be named ones and few.
    Combs(&'a Combs),
    /// All of the colour functions: at each whole number of `STEP`s.
    Spectrum(Vec<f64>),
}

impl Wavelengths<'_> {
    /// Angle between entries of a spectrum: the visible range is 0.72 of log |(u, v)| wide, so power turns by 2π in 4.4 at the fastest.
    const STEP: f64 = 0.5;

    /// All wavelengths of `colours`, for what varies by at most `most` angles per unit of log |(u, v)|.
    pub fn spectrum(colours: &Colours, most: f64) -> Self {
        let last = colours.densities.len() - 1;
        let node = |(i, d): (usize, &DVec3)| {
            let q = 1.0 / LONGEST + SPAN * i as f64 / last as f64;
            [d.x as f32, d.y as f32, d.z as f32, q as f32]
        };
        let nodes: Vec<[f32; 4]> = colours.densities.iter().enumerate().map(node).collect();
        let count = (most / Self::STEP).ceil() as usize + 2;
        Self::Spectrum((0..count).into_par_iter().map(|i| power_of(&nodes, Self::STEP * i as f64)).collect())
    }

    /// The power by its angle, at `radius`.
    fn at(&self, radius: f64) -> Box<dyn Fn(f64) -> f64 + Sync + '_> {
        match self {
            Self::Combs(combs) => {
                let nodes = combs.nodes_at(radius);
                Box::new(move |angle| power_of(nodes, angle))
            }
            Self::Spectrum(values) => Box::new(move |angle| {
                let place = (angle / Self::STEP).min((values.len() - 2) as f64);
                let left = place as usize;
                values[left] + (values[left + 1] - values[left]) * (place - left as f64).min(1.0)
            }),
        }
    }
}

/// |Σ weight q² e^{i angle log q}|² of all channels of `nodes`.
fn power_of(nodes: &[[f32; 4]], angle: f64) -> f64 {
    let mut sums = [[0f64; 2]; 3];
    for &[x, y, z, q] in nodes {
        let q = f64::from(q);
        let (sin, cos) = (angle * q.ln()).sin_cos();
        for (sum, weight) in sums.iter_mut().zip([x, y, z]) {
            sum[0] += f64::from(weight) * q * q * cos;
            sum[1] += f64::from(weight) * q * q * sin;
        }
    }
    sums.iter().flatten().map(|s| s * s).sum()
}

/// Power of a table over log |(u, v)| at one radius, by angles per unit.
struct Spectrum {
    /// Angle, and power times the width of its interval.
    lines: Vec<[f64; 2]>,
}

impl Spectrum {
    /// At `radius`, where `wavelengths` are summed over, through `aperture`.
    fn new(wavelengths: &Wavelengths<'_>, radius: f64, aperture: &Aperture) -> Self {
        /// Lines, closer where the colour functions have their power.
        const LINES: usize = 320;
        let power = wavelengths.at(radius);
        let width = (aperture.band() * radius).max(1e-3);
        let edge = |i: f64| aperture.end() * width * (i / LINES as f64).powi(2);
        let line = |i: usize| {
            let angle = edge(i as f64 + 0.5);
            let blurred = power(angle) * aperture.along(angle / width);
            [angle, blurred * (edge(i as f64 + 1.0) - edge(i as f64))]
        };
        Self { lines: (0..LINES).into_par_iter().map(line).collect() }
    }

    /// The mean square error of interpolation in steps of `step`, relative, where phases turn by `turning` per unit besides.
    fn error(&self, step: f64, turning: f64, kernel: &KernelError) -> f64 {
        let (mut error, mut power) = (0.0, f64::MIN_POSITIVE);
        for [angle, own] in &self.lines {
            power += own;
            error += own * kernel.at(step * angle.hypot(turning));
        }
        error / power
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::spectrum::Illuminant;

    fn rings(tolerance: f64) -> Rings {
        let combs = Combs::new(&Illuminant::D65, 16.25, 0.02 * tolerance, None);
        Rings::new(&Aperture::Gaussian(16.25), tolerance, &Wavelengths::Combs(&combs), [0.1, 33.0], 2.01)
    }

    #[test]
    fn rings_cover_every_direction_and_grow_apart_outward() {
        let rings = rings(2e-2);
        assert!(rings.radii.is_sorted() && rings.radii[0] == 0.0);
        assert!(rings.radii[rings.radii.len() - 1] >= 2.01);
        let apart = |r: f64| {
            let i = rings.radii.partition_point(|x| *x < r);
            rings.radii[i + 1] - rings.radii[i]
        };
        let places = rings.places();
        eprintln!(
            "{} rings of {} places, {:.2e} apart at 0.01, {:.2e} at 0.1, {:.2e} at 1, {:.2e} at 1.9",
            rings.radii.len(),
            places.len(),
            apart(0.01),
            apart(0.1),
            apart(1.0),
            apart(1.9)
        );
        assert!(apart(1.0) > 5.0 * apart(0.01) && apart(1.0) < 0.1);
        assert_eq!(places.len(), rings.begins[rings.radii.len()]);
        assert!(places.iter().all(|p| p[0] >= 0.0));
        assert!(self::rings(5e-3).places().len() > 2 * places.len());
    }

    #[test]
    fn cubics_of_radius_and_waves_around_are_met() {
        let rings = rings(2e-2);
        // Two values: a smooth function of (x, y), and one that differs between opposite sides.
        let f =
            |x: f64, y: f64| [1.0 + 0.3 * x + 0.2 * x * y - 0.1 * y * y * y, (x + 0.5 * y) * (1.0 + x * x)];
        let count = rings.places().len();
        let mut values = vec![0f32; 4 * count];
        for ring in 0..rings.radii.len() {
            let half = rings.count(ring);
            for j in 0..2 * half {
                let angle = PI * (j as f64 / half as f64 - 0.5);
                let own = f(rings.radii[ring] * angle.cos(), rings.radii[ring] * angle.sin());
                let index = 2 * rings.begins[ring] + j;
                values[2 * index..2 * index + 2].copy_from_slice(&own.map(|v| v as f32));
            }
        }
        let samples = Samples { width: 2, values };
        for i in 0..2000 {
            let radius = 2.0 * (f64::from(i) * 0.618_034).fract().powi(2);
            let angle = 2.0 * PI * (f64::from(i) * 0.754_878).fract() - PI;
            let (x, y) = (radius * angle.cos(), radius * angle.sin());
            let mut found = [0f32; 2];
            rings.add(&samples, x, y, &mut found);
            for (found, exact) in found.into_iter().zip(f(x, y)) {
                assert!((f64::from(found) - exact).abs() < 2e-3, "{found} for {exact} at {x}, {y}");
            }
        }
    }
}
