//! Reference pictures by f64 optics: for the directions that a frame shaded, so that only shading differs, or for
//! directions of rays cast in f64 ([`super::rays`]), so that all steps are independent.

use super::directions::Directions;
use super::frame::{Shown, View};
use super::light_passes::{LightPass, SampleGroup};
use super::sampling::{PixelWeights, Sampling};
use crate::brdf::albedo::{Decimation, DirectionalAlbedo};
use crate::brdf::energy_map::EnergyMap;
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::{ColourSampling, SummedOrders, TabulatedMean};
use crate::brdf::without_cosine;
use crate::error::Result;
use crate::filter::Covariance;
use crate::optics::coherence::{SUNLIGHT_LENGTH, Windows};
use crate::optics::color::{self, xyz_to_linear_srgb};
use crate::optics::energy::EnergyLimit;
use crate::optics::geometry::Pair;
use crate::optics::nufft;
use crate::optics::reference::Reference;
use crate::optics::spectrum::{Illuminant, SHORTEST};
use crate::scene::camera::pixel_centre;
use crate::scene::incident::mean_cosine;
use crate::settings::Optics;
use crate::surface::HeightField;
use crate::task::Task;
use glam::{DVec3, DVec4};
use std::f64::consts::PI;
use std::sync::Arc;

/// Returns the linear sRGB colours of the pixels with the numbers `pixels` for `directions`, one entry per light of `view`. A pigment texture is ignored.
///
/// # Errors
/// Same as [`PixelReference::new`] and [`PixelReference::colors`].
pub fn reference_pixels(
    field: &HeightField,
    optics: &Optics,
    view: &View,
    directions: &[Directions],
    pixels: &[usize],
    task: &Task,
) -> Result<Vec<DVec3>> {
    PixelReference::new(field, optics, task)?.colors(view, 0, directions, pixels, task)
}

/// Shades pixels in f64.
pub struct PixelReference {
    optics: Optics,
    by: By,
    limit: Option<Arc<DirectionalAlbedo>>,
}

enum By {
    Windows(Box<Reference>),
    Mean(Box<TabulatedMean>),
    // The pigment alone is visible.
    Nothing,
}

impl PixelReference {
    /// Makes the reference of `field` under `optics`.
    ///
    /// # Errors
    /// Fails if there is not enough memory, or if the task is cancelled.
    pub fn new(field: &HeightField, optics: &Optics, task: &Task) -> Result<Self> {
        Self::with_sampling(field, optics, ColourSampling::EXACT, task)
    }

    /// Makes the reference of `field` under `optics`; the colours of the mean are summed by `sampling`.
    ///
    /// # Errors
    /// Same as [`PixelReference::new`].
    pub fn with_sampling(
        field: &HeightField,
        optics: &Optics,
        sampling: ColourSampling,
        task: &Task,
    ) -> Result<Self> {
        let sigma = optics.coherence.sigma();
        let mean = |sigma| MeanBrdf {
            field: field.clone(),
            sigma,
            beyond: optics.beyond,
            reflectance: optics.reflectance.clone(),
        };
        let (by, limit) = match (optics.windows, sigma) {
            (Windows::All, Some(sigma)) => {
                let table = TabulatedMean::with_sampling(mean(sigma), SHORTEST, sampling, task)?;
                let table = table.limited(Decimation::Coarse);
                let limit = table.limit().cloned();
                (By::Mean(Box::new(table)), limit)
            }
            (windows, _) => {
                let windows = windows.grid().unwrap_or([1, 1]);
                let of_sunlight = mean(sigma.unwrap_or(SUNLIGHT_LENGTH / 4.0));
                let limit = TabulatedMean::limit_of(of_sunlight, SHORTEST, task)?;
                let sum = Reference::new(field, optics.coherence, windows, optics.reflectance.clone());
                (By::Windows(Box::new(sum)), limit)
            }
        };
        Ok(Self { optics: optics.clone(), by, limit })
    }

    /// Makes the reference of an object that does not diffract.
    pub fn of_pigment(optics: &Optics) -> Self {
        Self { optics: optics.clone(), by: By::Nothing, limit: None }
    }

    /// Returns the linear sRGB colours of the pixels with the numbers `pixels`, which show object number `object`. The mean is averaged over the
    /// footprints in `directions`; a sum through windows is evaluated at the direction of the pixel centre.
    ///
    /// # Errors
    /// Same as [`nufft::cosine_weighted_xyz`].
    pub fn colors(
        &self,
        view: &View,
        object: usize,
        directions: &[Directions],
        pixels: &[usize],
        task: &Task,
    ) -> Result<Vec<DVec3>> {
        let base_color = view.base_color(object).as_dvec3();
        let mut colors = vec![DVec3::ZERO; pixels.len()];
        let lights = directions.len();
        for (number, seen) in directions.iter().enumerate() {
            let illuminant = view.illuminant(seen.light_number).unwrap_or(&self.optics.illuminant);
            let pair = |i: usize| Pair::new(unit(seen.light[i]), unit(seen.view[i]));
            let asked: Vec<(Pair, Covariance)> =
                pixels.iter().map(|&i| (pair(i), seen.covariance(i))).collect();
            let energy = self.limit.as_ref().map(|limit| EnergyMap::new(limit, illuminant));
            let diffracted = self.diffracted(seen, &asked, illuminant, &task.share(number, lights))?;
            let white = xyz_to_linear_srgb(illuminant.white());
            for ((color, &i), ((pair, _), xyz)) in
                colors.iter_mut().zip(pixels).zip(asked.iter().zip(diffracted))
            {
                // Nothing is lit in shadow or from behind.
                if pair.view.z <= 0.0 || pair.light == DVec3::NEG_Z {
                    continue;
                }
                let diffracted = if pair.above_horizon() { xyz_to_linear_srgb(xyz) } else { DVec3::ZERO };
                let limit = match (&self.by, &energy) {
                    // Sums through windows have no limit of their own here.
                    (By::Windows(_), Some(energy)) => energy.limit(pair),
                    _ => 1.0,
                };
                // The pigment is lit by the part above the horizon of a light whose middle is below it, too.
                let cosine = mean_cosine(pair.light.z, seen.incident(i).mean);
                let above = Pair { light: pair.light.with_z(pair.light.z.max(0.0)), ..*pair };
                let passed = self.passed_to_pigment(&above, energy.as_ref());
                let pigmented = white * base_color * (passed * cosine / PI);
                *color += (diffracted / limit + pigmented) * seen.irradiance(i) * PI;
            }
            self.add_mirrored(seen, pixels, &mut colors);
        }
        Ok(colors)
    }

    /// Returns the share of light that passes the surface to the pigment and back.
    fn passed_to_pigment(&self, pair: &Pair, energy: Option<&EnergyMap>) -> f64 {
        let reflectance = &self.optics.reflectance;
        match energy {
            Some(_) if reflectance.is_opaque() => 0.0,
            Some(energy) => energy.pigment(pair),
            None => 1.0 - reflectance.kept_from_pigment(pair.cos_half_angle()),
        }
    }

    /// Returns f \[sr⁻¹\] of `pair` at each of `wavelengths` \[µm\], not averaged over a footprint; 0 below the
    /// horizon.
    pub fn spectrum(&self, pair: &Pair, wavelengths: &[f64]) -> Vec<f64> {
        let at = |&wavelength: &f64| match &self.by {
            By::Mean(mean) => {
                let weighted = mean.cosine_weighted(pair, wavelength, &Covariance::default());
                without_cosine(pair, DVec3::splat(weighted)).x
            }
            By::Windows(reference) => {
                let limit = self.limit.as_ref().map_or(1.0, |limit| limit.single(pair, wavelength));
                reference.brdf(pair, wavelength) / limit
            }
            By::Nothing => 0.0,
        };
        wavelengths.iter().map(at).collect()
    }

    /// Returns XYZ of f \[sr⁻¹\] of `pair` under `illuminant`, or by default under that of the shading; not averaged
    /// over a footprint; 0 below the horizon.
    ///
    /// # Errors
    /// Fails if the colour needs too many wavelengths.
    pub fn xyz(&self, pair: &Pair, illuminant: Option<&Illuminant>) -> Result<DVec3> {
        let illuminant = illuminant.unwrap_or(&self.optics.illuminant);
        let weighted = match &self.by {
            By::Mean(mean) => {
                let asked = [(*pair, Covariance::default())];
                mean.xyz(illuminant, &asked, SummedOrders::All, &Task::silent())?[0]
            }
            By::Windows(reference) => {
                let limit = self.limit.as_ref().map_or(1.0, |limit| limit.colour(pair, illuminant));
                reference.cosine_weighted_xyz(pair, illuminant)? / limit
            }
            By::Nothing => DVec3::ZERO,
        };
        Ok(without_cosine(pair, weighted))
    }

    /// Returns XYZ of f cos θ_i \[sr⁻¹\] of the `asked` pairs of `seen`.
    fn diffracted(
        &self,
        seen: &Directions,
        asked: &[(Pair, Covariance)],
        illuminant: &Illuminant,
        task: &Task,
    ) -> Result<Vec<DVec3>> {
        match &self.by {
            By::Mean(mean) => {
                let orders =
                    if seen.mirrored.is_empty() { SummedOrders::All } else { SummedOrders::Scattered };
                mean.xyz(illuminant, asked, orders, task)
            }
            By::Windows(reference) => {
                let pairs: Vec<Pair> = asked.iter().map(|(pair, _)| *pair).collect();
                nufft::cosine_weighted_xyz(reference, illuminant, &pairs, task)
            }
            By::Nothing => Ok(vec![DVec3::ZERO; asked.len()]),
        }
    }

    /// Adds the reflection of the surroundings by the specular order to the `colors` of `pixels`.
    fn add_mirrored(&self, seen: &Directions, pixels: &[usize], colors: &mut [DVec3]) {
        let By::Mean(mean) = &self.by else { return };
        if seen.mirrored.is_empty() {
            return;
        }
        let views: Vec<DVec3> = pixels.iter().map(|&i| unit(seen.view[i])).collect();
        let sent = mean.mirrored(&self.optics.illuminant, &views);
        for (color, (xyz, &i)) in colors.iter_mut().zip(sent.into_iter().zip(pixels)) {
            *color += xyz_to_linear_srgb(xyz) * DVec3::from(seen.mirrored[i].map(f64::from));
        }
    }
}

/// Returns the numbers of the covered pixels.
pub fn covered(directions: &[Directions]) -> Vec<usize> {
    let pixels = directions.first().map_or(0, |seen| seen.view.len());
    (0..pixels).filter(|&i| directions.iter().any(|seen| seen.view[i][3] != 0.0)).collect()
}

/// Returns the displayed picture of `radiance`, premultiplied by alpha; the f64 twin of the display pass.
pub fn displayed(radiance: &[[f32; 4]], shown: Shown) -> Vec<[u8; 4]> {
    displayed_before(radiance, shown, &|_| shown.background)
}

/// Returns the displayed picture over the surroundings of `view`, for `size` pixels; without surroundings, as
/// [`displayed`].
pub fn displayed_of(view: &View, size: [u32; 2], radiance: &[[f32; 4]], shown: Shown) -> Vec<[u8; 4]> {
    let Some(environment) = view.background() else {
        return displayed(radiance, shown);
    };
    displayed_before(radiance, shown, &|i| {
        let toward = view.camera.sight(pixel_centre(i, size), size).direction.normalize();
        shown.tone.map(environment.radiance(toward) * shown.exposure.exp2())
    })
}

/// Displays `radiance` over `background`, which returns the displayed linear sRGB colour behind each pixel.
fn displayed_before(
    radiance: &[[f32; 4]],
    shown: Shown,
    background: &dyn Fn(usize) -> DVec3,
) -> Vec<[u8; 4]> {
    let Shown { exposure, tone, .. } = shown;
    let code = |(i, pixel): (usize, &[f32; 4])| {
        let [r, g, b, coverage] = pixel.map(f64::from);
        let background = background(i);
        let [r, g, b] = if coverage > 0.0 {
            color::display_over(DVec3::new(r, g, b) / coverage, exposure, tone, coverage, background)
        } else {
            color::display(background, 0.0)
        };
        [r, g, b, 255]
    };
    radiance.iter().enumerate().map(code).collect()
}

/// Object shaded in f64.
pub struct ReferenceObject<'a> {
    /// Height field; `None` for an object that does not diffract.
    pub field: Option<&'a HeightField>,
    /// Settings of the optics.
    pub optics: &'a Optics,
}

/// Settings of a reference picture of several samples.
#[derive(Clone, Copy)]
pub struct ReferenceSamples<'a> {
    /// Samples.
    pub sampling: &'a Sampling,
    /// Width and height of the picture \[pixels\].
    pub size: [u32; 2],
    /// Predicate of the pixels to compute, by pixel number; the others stay empty.
    pub chosen: &'a dyn Fn(usize) -> bool,
}

impl ReferenceSamples<'_> {
    /// Returns the pixel number `pixel` and its eight neighbours, each with the weight in `weights` of its sample for
    /// the pixel. Reads outside the picture are clamped to its edge.
    fn neighbours(&self, pixel: usize, weights: &PixelWeights) -> [(usize, f64); 9] {
        let [width, height] = self.size.map(|n| n as usize);
        let (x, y) = (pixel % width, pixel / width);
        let columns = [x.saturating_sub(1), x, (x + 1).min(width - 1)];
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        std::array::from_fn(|i| {
            let (row, column) = (i / 3, i % 3);
            (rows[row] * width + columns[column], weights.down[row] * weights.across[column])
        })
    }

    /// Returns true if the sample of `pixel` has weight for a chosen pixel.
    fn counts(&self, pixel: usize, weights: &PixelWeights) -> bool {
        self.neighbours(pixel, weights).iter().any(|(other, weight)| *weight > 0.0 && (self.chosen)(*other))
    }
}

/// Returns the mean of samples of `objects`, shaded in f64, as RGBA like [`super::renderer::Picture::radiance`].
/// `directions` returns the directions of a pass. The mean over windows is averaged over the footprint of each sample.
///
/// # Errors
/// Same as [`nufft::cosine_weighted_xyz`], or the error of `directions`.
pub fn reference_mean(
    objects: &[ReferenceObject<'_>],
    view: &View,
    samples: &ReferenceSamples<'_>,
    directions: &mut dyn FnMut(&LightPass) -> Result<Directions>,
    task: &Task,
) -> Result<Vec<[f32; 4]>> {
    let mut references = Vec::new();
    for &ReferenceObject { field, optics } in objects {
        let reference = match field {
            Some(field) => PixelReference::new(field, optics, task)?,
            None => PixelReference::of_pigment(optics),
        };
        references.push(reference);
    }
    reference_mean_of(&references.iter().collect::<Vec<_>>(), view, samples, directions, task)
}

/// Returns [`reference_mean`] of objects whose `references` are there already.
///
/// # Errors
/// Same as [`PixelReference::colors`], or the error of `directions`.
pub fn reference_mean_of(
    references: &[&PixelReference],
    view: &View,
    samples: &ReferenceSamples<'_>,
    directions: &mut dyn FnMut(&LightPass) -> Result<Directions>,
    task: &Task,
) -> Result<Vec<[f32; 4]>> {
    let sampling = samples.sampling;
    let count = sampling.count.max(1);
    let mut sum: Vec<DVec4> = Vec::new();
    let groups = view.schedule(sampling).groups().collect::<Vec<SampleGroup>>();
    let passes: Vec<LightPass> =
        groups.into_iter().flat_map(|group| group.passes).flat_map(LightPass::each_light).collect();
    for (place, pass) in passes.iter().enumerate() {
        let seen = [directions(pass)?];
        let weights = pass.sample.weights();
        sum.resize(seen[0].view.len(), DVec4::ZERO);
        let mut sample = vec![DVec4::ZERO; sum.len()];
        let mut pixels = covered(&seen);
        pixels.retain(|&pixel| samples.counts(pixel, &weights));
        let coverage = if pass.is_first { 1.0 } else { 0.0 };
        for (number, reference) in references.iter().enumerate() {
            let shows = |&&pixel: &&usize| seen[0].object(pixel) == number;
            let pixels: Vec<usize> = pixels.iter().filter(shows).copied().collect();
            let share = task.share(place * references.len() + number, passes.len() * references.len());
            let colors = reference.colors(view, number, &seen, &pixels, &share)?;
            for (pixel, color) in pixels.into_iter().zip(colors) {
                sample[pixel] = color.extend(coverage);
            }
        }
        for (pixel, sum) in sum.iter_mut().enumerate().filter(|(pixel, _)| (samples.chosen)(*pixel)) {
            *sum += samples
                .neighbours(pixel, &weights)
                .into_iter()
                .map(|(from, weight)| sample[from] * weight)
                .sum::<DVec4>();
        }
    }
    Ok(sum.into_iter().map(|pixel| (pixel / f64::from(count)).as_vec4().to_array()).collect())
}

/// Returns a direction of the frame in f64, normalised to full precision.
pub fn unit([x, y, z, _]: [f32; 4]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()).normalize_or_zero()
}
