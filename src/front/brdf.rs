//! BRDF of a surface, and its orders.

use super::pair;
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::TabulatedMean;
use crate::brdf::{Brdf, DiffractionOrder, DirectSum, MeanFromOrders, MeanReference};
use crate::error::{Error, Remedy, Result};
use crate::optics::coherence::{SUNLIGHT_LENGTH, Windows};
use crate::optics::energy::EnergyLimit;
use crate::optics::geometry::{Pair, angles};
use crate::optics::reference::Reference;
use crate::optics::spectrum::SHORTEST;
use crate::settings::{Method, Optics};
use crate::surface::HeightField;
use crate::task::Task;
use std::fmt;
use std::sync::Arc;

/// BRDF f of a surface \[1/sr\], from any thread. Clones share what an answer needs beyond its directions, which is computed once.
#[derive(Clone)]
pub struct SurfaceBrdf {
    brdf: Arc<dyn Brdf>,
}

impl SurfaceBrdf {
    /// Returns the BRDF of `field` under `optics`.
    ///
    /// # Errors
    /// Fails for settings that do not go together, if there is too little memory, or if the task is cancelled.
    pub fn new(field: &HeightField, optics: &Optics, task: &Task) -> Result<Self> {
        optics.check()?;
        let illuminant = optics.illuminant.clone();
        let brdf: Arc<dyn Brdf> = match (optics.method, optics.windows) {
            (Method::Spectral, Windows::All) => {
                Arc::new(MeanFromOrders::new(mean(field, optics), illuminant, optics.tolerance))
            }
            (Method::Reference, Windows::All) => {
                Arc::new(MeanReference::new(mean(field, optics), illuminant, SHORTEST))
            }
            (Method::Reference, Windows::Grid(windows)) => {
                let limit = TabulatedMean::limit_of(mean(field, optics), SHORTEST, task)?;
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
        Ok(Self { brdf })
    }

    /// Returns f \[1/sr\] at `wavelength` \[µm\] for every pair of directions to the light and to the viewer; 0 below the horizon.
    ///
    /// # Errors
    /// Fails if there is too little memory, or if the task is cancelled.
    pub fn spectral(&self, directions: &[[[f64; 3]; 2]], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
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
            period: order.period,
        }
    }
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
