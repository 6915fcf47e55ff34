//! Readings of a spectrophotometer: colours and spectra toward single directions, or averaged over an aperture.

use crate::brdf::Brdf;
use crate::cli::console::Console;
use crate::cli::progress::ProgressBar;
use crate::cli::{evaluation, prepare};
use crate::error::Result;
use crate::optics::color::{adapted_to_d65, display, xyz_to_linear_srgb};
use crate::optics::color_difference::lab_under;
use crate::optics::geometry::{Pair, direction};
use crate::optics::quadrature::gauss_legendre;
use crate::optics::spectrum::{LONGEST, SHORTEST};
use crate::settings::Optics;
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use crate::task::DIRECTIONS;
use glam::{DQuat, DVec2, DVec3};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Distance of the wavelengths of a spectrum \[µm\], that of CIE's tables for spectrophotometers.
const STEP: f64 = 5e-3;
/// Rings of directions in an aperture.
const RINGS: u32 = 8;
/// Directions on each ring.
const TURNS: u32 = 64;
/// Standard deviation of the Gaussian that each direction stands for, over the radius of the aperture: about half the distance of neighbours, so that
/// a lobe that is narrower does not fall between them.
const BLUR: f64 = 0.055;
/// A direction of view, and the answer to it.
#[derive(Clone, Debug, Serialize)]
pub struct AngleReading {
    /// Angle from the mirror direction toward the light \[degrees\]; `None` for a view by its own direction.
    pub aspecular: Option<f64>,
    pub theta_i: f64,
    pub phi_i: f64,
    pub theta_r: f64,
    pub phi_r: f64,
    /// XYZ of the radiance factor; Y is 100 for a white diffuse surface.
    pub xyz: [f64; 3],
    /// CIELAB under the white of the illuminant.
    pub lab: [f64; 3],
    /// Colour on a display, as in #80ff00.
    pub srgb: String,
    /// The same as 8-bit codes.
    #[serde(skip)]
    pub display: [u8; 3],
}

/// Returns the wavelengths of a spectrum \[µm\].
pub fn wavelengths() -> Vec<f64> {
    let count = ((LONGEST - SHORTEST) / STEP).round() as usize;
    (0..=count).map(|n| SHORTEST + STEP * n as f64).collect()
}

/// Detector of an instrument.
pub struct Detector<'a> {
    /// Full angle of the cone of directions that it averages over \[degrees\].
    pub aperture: f64,
    /// Wavelengths of a spectrum \[µm\]; none for colours alone.
    pub wavelengths: &'a [f64],
}

impl Detector<'_> {
    /// Answers `readings` of `field` under `optics`; returns f \[sr⁻¹\] by wavelength and reading.
    pub fn read(
        &self,
        readings: &mut [AngleReading],
        field: &HeightField,
        optics: Optics,
        console: &Console,
    ) -> Result<Vec<Vec<f64>>> {
        let cones: Vec<Cone> = readings.iter().map(|reading| Cone::of(reading, self.aperture)).collect();
        let white = optics.illuminant.white();
        let settings = SourceSettings { shortest: SHORTEST, ..SourceSettings::new(optics) };
        let mut colours = vec![DVec3::ZERO; cones.len()];
        let mut spectra = vec![vec![0.0; cones.len()]; self.wavelengths.len()];
        prepare::for_each_window(console, field, &settings, |brdf, share| {
            let count: usize = cones.iter().map(|cone| cone.pairs.len()).sum();
            let bar = ProgressBar::over(
                console,
                DIRECTIONS,
                "a smaller number of readings",
                count * (1 + self.wavelengths.len()),
            );
            for (place, cone) in cones.iter().enumerate() {
                colours[place] += cone.mean(brdf, None, &bar)? * share;
                for (spectrum, wavelength) in spectra.iter_mut().zip(self.wavelengths) {
                    spectrum[place] += cone.mean(brdf, Some(*wavelength), &bar)?.x * share;
                }
            }
            Ok(())
        })?;
        for (reading, f) in readings.iter_mut().zip(&colours) {
            reading.answer(PI * *f, white);
        }
        Ok(spectra)
    }
}

/// Directions over which a detector averages.
struct Cone {
    pairs: Vec<Pair>,
    /// Weights of the pairs; their sum is 1.
    weights: Vec<f64>,
    /// Standard deviation of the Gaussian of (u, v) that each direction stands for.
    deviation: f64,
}

impl Cone {
    /// Returns the cone around the view of `reading`, `aperture` degrees across: rings by Gauss and Legendre's rule. They are drawn in so far that
    /// the variance of the whole, with that of the Gaussians, is the cone's.
    fn of(reading: &AngleReading, aperture: f64) -> Self {
        let light = direction(reading.theta_i, reading.phi_i);
        let middle = direction(reading.theta_r, reading.phi_r);
        let radius = (0.5 * aperture).to_radians();
        if radius == 0.0 {
            return Self { pairs: vec![Pair::new(light, middle)], weights: vec![1.0], deviation: 0.0 };
        }
        // A disc has a quarter of its squared radius along each axis.
        let drawn_in = radius * (1.0 - 4.0 * BLUR * BLUR).sqrt();
        let to_middle = DQuat::from_rotation_arc(DVec3::Z, middle);
        let (mut pairs, mut weights) = (Vec::new(), Vec::new());
        for (ring, (place, share)) in gauss_legendre(RINGS).into_iter().enumerate() {
            let (sin, cos) = (drawn_in * place).sin_cos();
            for turn in 0..TURNS {
                // Every other ring is turned by half the distance of its directions.
                let turns = (f64::from(turn) + 0.5 * (ring % 2) as f64) / f64::from(TURNS);
                let across = DVec2::from_angle(TAU * turns) * sin;
                pairs.push(Pair::new(light, to_middle * across.extend(cos)));
                weights.push(share * sin);
            }
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        Self { pairs, weights, deviation: BLUR * radius }
    }

    /// Returns the mean of f \[sr⁻¹\] over the cone, at `wavelength` \[µm\] or as XYZ.
    fn mean(&self, brdf: &mut dyn Brdf, wavelength: Option<f64>, bar: &ProgressBar) -> Result<DVec3> {
        brdf.average_over(self.deviation);
        let found = evaluation::ask(brdf, &self.pairs, wavelength, bar)?;
        Ok(found.iter().zip(&self.weights).map(|(f, weight)| *f * *weight).sum())
    }
}

impl AngleReading {
    /// Returns an unanswered reading of light and view from these directions \[degrees\].
    pub fn unanswered([theta_i, phi_i]: [f64; 2], [theta_r, phi_r]: [f64; 2]) -> Self {
        let [xyz, lab] = [[0.0; 3]; 2];
        Self {
            aspecular: None,
            theta_i,
            phi_i,
            theta_r,
            phi_r,
            xyz,
            lab,
            srgb: String::new(),
            display: [0; 3],
        }
    }

    /// Returns an unanswered reading in the plane of incidence, at `angle` from the mirror direction toward the light \[degrees\].
    pub fn aspecular(light: [f64; 2], angle: f64) -> Self {
        // Signed in that plane, where the light is at theta_i and the mirror direction at −theta_i.
        Self { aspecular: Some(angle), ..Self::unanswered(light, [angle - light[0], light[1]]) }
    }

    /// Returns the geometry in words.
    pub fn name(&self) -> String {
        match self.aspecular {
            Some(angle) => format!("{}as{angle}", self.theta_i),
            None => format!("{},{}", self.theta_r, self.phi_r),
        }
    }

    /// Enters the colour of the radiance factor `factor`, XYZ in terms of the `white`.
    fn answer(&mut self, factor: DVec3, white: DVec3) {
        self.xyz = (100.0 * factor).to_array();
        self.lab = lab_under(factor, white).to_array();
        self.display = display(xyz_to_linear_srgb(adapted_to_d65(factor, white)), 0.0);
        let [r, g, b] = self.display;
        self.srgb = format!("#{r:02x}{g:02x}{b:02x}");
    }
}
