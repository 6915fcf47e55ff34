//! BRDF of a surface, and its orders.

use super::pair;
use crate::brdf::hemisphere::{HemisphereMap, MapLight, PixelParts};
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::TabulatedMean;
use crate::brdf::{Brdf, DiffractionOrder, DirectSum, MeanFromOrders, MeanReference};
use crate::error::{Error, Remedy, Result};
use crate::optics::coherence::{SUNLIGHT_LENGTH, Windows};
use crate::optics::energy::EnergyLimit;
use crate::optics::geometry::{Pair, angles};
use crate::optics::reference::Reference;
use crate::optics::spectrum::{ANSWERED, SHORTEST};
use crate::settings::{Method, Optics};
use crate::surface::HeightField;
use crate::task::{DIRECTIONS, Task};
use crate::units::MAX_PIXELS;
use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// BRDF f of a surface \[1/sr\], from any thread. Clones share what an answer needs beyond its directions, which is computed once.
#[derive(Clone)]
pub struct SurfaceBrdf {
    brdf: Arc<dyn Brdf>,
    field: HeightField,
    optics: Optics,
    /// Shortest wavelength that is answered \[µm\].
    shortest: f64,
}

impl SurfaceBrdf {
    /// Returns the BRDF of `field` under `optics`.
    ///
    /// # Errors
    /// Fails for settings that do not go together, if there is too little memory, or if the task is cancelled.
    pub fn new(field: &HeightField, optics: &Optics, task: &Task) -> Result<Self> {
        Self::with_shortest(field, optics, SHORTEST, task)
    }

    /// Returns the BRDF of `field` under `optics`, whose reference answers wavelengths from `shortest` on \[µm\]; what is shorter takes it more work. Other methods answer all
    /// wavelengths.
    ///
    /// # Errors
    /// Those of [`Self::new`]; fails for a wavelength out of range.
    pub fn with_shortest(field: &HeightField, optics: &Optics, shortest: f64, task: &Task) -> Result<Self> {
        optics.check()?;
        check_range(shortest)?;
        let illuminant = optics.illuminant.clone();
        let brdf: Arc<dyn Brdf> = match (optics.method, optics.windows) {
            (Method::Spectral, Windows::All) => {
                Arc::new(MeanFromOrders::new(mean(field, optics), illuminant, optics.tolerance))
            }
            (Method::Reference, Windows::All) => {
                Arc::new(MeanReference::new(mean(field, optics), illuminant, shortest))
            }
            (Method::Reference, Windows::Grid(windows)) => {
                let limit = TabulatedMean::limit_of(mean(field, optics), shortest, task)?;
                let limit = limit.map(|limit| limit as Arc<dyn EnergyLimit>);
                let sum = Reference::new(field, optics.coherence, windows, optics.reflectance.clone());
                Arc::new(DirectSum { reference: sum.limited(limit), illuminant })
            }
            (Method::Table, _) | (Method::Spectral, Windows::Grid(_)) => {
                return Err(Error::usage(
                    "this is the BRDF on the CPU, without a device",
                    [Remedy::SpectralMethod, Remedy::ReferenceMethod],
                ));
            }
        };
        let shortest = if optics.method == Method::Reference { shortest } else { ANSWERED.0 };
        Ok(Self { brdf, field: field.clone(), optics: optics.clone(), shortest })
    }

    /// Returns f \[1/sr\] at `wavelength` \[µm\] for every pair of directions to the light and to the viewer; 0 below the horizon.
    ///
    /// # Errors
    /// Fails for a wavelength out of range, if there is too little memory, or if the task is cancelled.
    pub fn spectral(&self, directions: &[[[f64; 3]; 2]], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
        self.check_wavelength(wavelength)?;
        let pairs: Vec<Pair> = directions.iter().map(pair).collect();
        self.brdf.spectral(&pairs, wavelength, task)
    }

    /// Returns XYZ of f \[1/sr\] for every pair of directions to the light and to the viewer; 0 below the horizon. The mirror image of the light in a perfect mirror
    /// has Y = 1/cos θ_i, spread over its solid angle.
    ///
    /// # Errors
    /// Those of [`Self::spectral`].
    pub fn xyz(&self, directions: &[[[f64; 3]; 2]], task: &Task) -> Result<Vec<[f64; 3]>> {
        let pairs: Vec<Pair> = directions.iter().map(pair).collect();
        Ok(self.brdf.xyz(&pairs, task)?.into_iter().map(|xyz| xyz.to_array()).collect())
    }

    /// Returns the map of the hemisphere of view directions for light from `light`, of `side` × `side` pixels, row by row from the top: linear sRGB of f \[1/sr\], or f
    /// itself three times at a single `wavelength` \[µm\], averaged over each pixel; a fourth number is 1 inside the hemisphere and 0 outside. Pixel (i, j) is the
    /// direction of x = 2(i + ½)/side − 1 and y = 1 − 2(j + ½)/side.
    ///
    /// # Errors
    /// Those of [`Self::spectral`]; fails for a side of 0 or of more than 16384.
    pub fn map(
        &self,
        light: [f64; 3],
        side: u32,
        wavelength: Option<f64>,
        task: &Task,
    ) -> Result<Vec<[f32; 4]>> {
        if !(1..=MAX_PIXELS).contains(&side) {
            return Err(Error::usage(
                format!("a map cannot have {side} pixels along a side"),
                format!("give a size of 1 to {MAX_PIXELS}"),
            ));
        }
        wavelength.map_or(Ok(()), |wavelength| self.check_wavelength(wavelength))?;
        let mut map = HemisphereMap::dark(side)?;
        let shortest = wavelength.unwrap_or(SHORTEST);
        // Answers nothing, and makes what this BRDF shares with the averaged one.
        self.brdf.spectral(&[], shortest, task)?;
        let averaged = self.brdf.averaged_over(HemisphereMap::of_pixel(side));
        let (brdf, parts) = match &averaged {
            Some(brdf) => (&**brdf, PixelParts::ONE),
            None => (&*self.brdf, PixelParts::new(self.optics.coherence, &self.field, side, shortest)),
        };
        let light = MapLight { lights: vec![(light.into(), 1.0)], wavelength };
        let (mut done, all) = (0, parts.directions(side));
        map.add(brdf, &light, parts, 1.0, &mut |brdf, pairs| {
            task.report(DIRECTIONS, done, all)?;
            done += pairs.len();
            match wavelength {
                Some(w) => Ok(brdf.spectral(pairs, w, task)?.into_iter().map(DVec3::splat).collect()),
                None => brdf.xyz(pairs, task),
            }
        })?;
        task.report(DIRECTIONS, all, all)?;
        Ok(map.pixels)
    }

    /// Fails for a `wavelength` \[µm\] that is not answered.
    fn check_wavelength(&self, wavelength: f64) -> Result<()> {
        check_range(wavelength)?;
        if wavelength < self.shortest {
            return Err(Error::usage(
                format!(
                    "the reference was made for wavelengths from {} um on, and {wavelength} um is shorter",
                    self.shortest
                ),
                "make it for shorter ones",
            ));
        }
        self.optics.reflectance.check_wavelength(wavelength)
    }
}

impl fmt::Debug for SurfaceBrdf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SurfaceBrdf").finish_non_exhaustive()
    }
}

/// Order of a periodic surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GratingOrder {
    /// m and n: the direction cosines along x and y of light and order sum to −m λ/T_x and −n λ/T_y, for the periods T of the unit cell.
    pub numbers: [i64; 2],
    /// Direction that the light leaves in.
    pub direction: [f64; 3],
    /// Polar angle and azimuth of the direction \[degrees\].
    pub angles: [f64; 2],
    /// Share of the incident light, 0 to about 1.
    pub efficiency: f64,
    /// Reflectance with which Stam's factor would give the efficiency.
    pub reflectance: f64,
    /// Period of the grating whose first order this is \[µm\]; `None` for the specular order.
    pub period: Option<f64>,
}

impl HeightField {
    /// Returns the orders of copies of the field that light from `light` at `wavelength` \[µm\] sends above the horizon, on a surface that reflects as `optics` say.
    ///
    /// # Errors
    /// Fails if there is too little memory, or if the task is cancelled.
    pub fn orders(
        &self,
        optics: &Optics,
        light: [f64; 3],
        wavelength: f64,
        task: &Task,
    ) -> Result<Vec<GratingOrder>> {
        check_range(wavelength)?;
        optics.reflectance.check_wavelength(wavelength)?;
        let cell = MeanBrdf::in_sunlight(&self.unit_cell()?, optics.reflectance.clone());
        let orders = cell.orders(light.into(), wavelength, task)?;
        Ok(orders.into_iter().map(GratingOrder::from).collect())
    }
}

impl From<DiffractionOrder> for GratingOrder {
    fn from(order: DiffractionOrder) -> Self {
        let (theta, phi) = angles(order.view);
        Self {
            numbers: order.numbers,
            direction: order.view.to_array(),
            angles: [theta, phi],
            efficiency: order.efficiency,
            reflectance: order.reflectance,
            period: order.period,
        }
    }
}

/// Fails for a `wavelength` \[µm\] at which no surface is answered.
pub(super) fn check_range(wavelength: f64) -> Result<()> {
    let (low, high) = ANSWERED;
    if (low..=high).contains(&wavelength) {
        return Ok(());
    }
    Err(Error::usage(format!("the wavelength {wavelength} um is out of range"), "give 10 nm to 100 um"))
}

/// Returns the mean BRDF of `field` under `optics`; a finite grating counts as lit by the sun.
fn mean(field: &HeightField, optics: &Optics) -> MeanBrdf {
    MeanBrdf {
        field: field.clone(),
        sigma: optics.coherence.sigma().unwrap_or(SUNLIGHT_LENGTH / 4.0),
        beyond: optics.beyond,
        reflectance: optics.reflectance.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front::direction;
    use crate::surface::synth::{Spec, SurfaceKind};

    fn grating() -> HeightField {
        HeightField::generate(&Spec::new(SurfaceKind::Sinusoid)).unwrap()
    }

    #[test]
    fn the_orders_of_a_sinusoid_stand_where_the_grating_equation_says() {
        let light = direction(30.0, 0.0);
        let orders = grating().orders(&Optics::new(), light, 0.5, &Task::silent()).unwrap();
        for order in &orders {
            let expected = -light[0] - order.numbers[0] as f64 * 0.5 / 2.0;
            assert!((order.direction[0] - expected).abs() < 1e-9, "{order:?}");
        }
        let sum: f64 = orders.iter().map(|order| order.efficiency).sum();
        assert!(sum > 0.03 && sum < 0.06, "a dielectric of index 1.5 reflects about 4 %: {sum}");
    }

    #[test]
    fn fast_values_are_those_of_the_reference_within_the_tolerance() {
        let optics = Optics::new().with_coherence_length(20.0).with_tolerance(1e-3);
        let task = Task::silent();
        let [fast, exact] = [optics.clone(), optics.by_reference()]
            .map(|optics| SurfaceBrdf::new(&grating(), &optics, &task).unwrap());
        let asked = [10.0, 14.0, 20.0].map(|angle| [direction(30.0, 0.0), direction(angle, 180.0)]);
        let [fast, exact] = [fast, exact].map(|brdf| brdf.spectral(&asked, 0.55, &task).unwrap());
        for (fast, exact) in fast.iter().zip(exact) {
            assert!((fast - exact).abs() < 1e-3 * exact.abs().max(1e-3), "{fast} {exact}");
        }
    }

    #[test]
    fn a_map_has_the_averages_of_its_pixels_and_nothing_outside_the_hemisphere() {
        const SIDE: u32 = 16;
        let optics = Optics::new().with_coherence_length(20.0);
        let task = Task::silent();
        let brdf = SurfaceBrdf::new(&grating(), &optics, &task).unwrap();
        let light = direction(30.0, 0.0);
        let map = brdf.map(light, SIDE, Some(0.55), &task).unwrap();
        assert_eq!((map.len(), map[0], map[(SIDE * SIDE / 2 + SIDE / 2) as usize][3]), (256, [0.0; 4], 1.0));
        // On the disc of direction cosines cos θ dω is the area: the sum is the share of the light that is sent.
        let pixel = (2.0 / f64::from(SIDE)).powi(2);
        let sent: f64 = map.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() * pixel;
        let orders = grating().orders(&optics, light, 0.55, &task).unwrap();
        let expected: f64 = orders.iter().map(|order| order.efficiency).sum();
        assert!((sent / expected - 1.0).abs() < 0.1, "{sent} {expected}");
        assert!(brdf.map(light, 0, None, &task).is_err());
        let colours = brdf.map(light, 8, None, &task).unwrap();
        assert!(colours.iter().any(|pixel| pixel[0] != pixel[2]));
    }

    #[test]
    fn wavelengths_out_of_range_are_refused() {
        let task = Task::silent();
        let optics = Optics::new().with_theory(crate::optics::theory::Theory::Stam);
        let asked = [[direction(30.0, 0.0), direction(30.0, 180.0)]];
        let fast = SurfaceBrdf::new(&grating(), &optics, &task).unwrap();
        assert!(fast.spectral(&asked, 0.3, &task).unwrap()[0] > 0.0, "an octave of its own");
        for wrong in [0.0, 0.55e-6, 550.0, f64::NAN] {
            assert!(fast.spectral(&asked, wrong, &task).is_err(), "{wrong}");
            assert!(grating().orders(&optics, asked[0][0], wrong, &task).is_err(), "{wrong}");
        }
        let exact = SurfaceBrdf::new(&grating(), &optics.clone().by_reference(), &task).unwrap();
        assert!(exact.spectral(&asked, 0.3, &task).is_err(), "shorter than it was made for");
        let short = SurfaceBrdf::with_shortest(&grating(), &optics.by_reference(), 0.3, &task).unwrap();
        let [a, b] = [fast, short].map(|brdf| brdf.spectral(&asked, 0.3, &task).unwrap()[0]);
        assert!((a / b - 1.0).abs() < 1e-2, "{a} {b}");
    }

    #[test]
    fn one_window_is_summed_directly_and_cancelled() {
        let optics = Optics::new().with_copies([2, 2]);
        let task = Task::silent();
        let brdf = SurfaceBrdf::new(&grating(), &optics, &task).unwrap();
        let asked = [[direction(30.0, 0.0), direction(30.0, 180.0)]];
        assert!(brdf.spectral(&asked, 0.55, &task).unwrap()[0] > 0.0);
        task.cancel();
        assert!(brdf.spectral(&asked, 0.55, &task).unwrap_err().is_cancelled());
    }
}
