//! Where scalar theory holds for a surface.
//!
//! The optics takes each point of the surface for a part of its tangent plane (the Kirchhoff approximation) and light for a scalar wave. For
//! rough surfaces that is good within RMS slope < 0.25, k l > 6 and l² > 2.76 σλ, with the RMS height σ and the correlation length l
//! [Ulaby, Moore, Fung 1982, *Microwave Remote Sensing* II, chapter 12; Thorsos 1988, "The validity of the Kirchhoff approximation for
//! rough surface scattering", finds l/λ the most important of them]. Efficiencies of the orders of gratings come within ±5 % of rigorous
//! theory where their features are larger than 14 wavelengths [Pommet, Moharam, Grann 1994, "Limits of scalar diffraction theory for
//! diffractive phase elements"]. The angles of the orders follow from the period alone and are right everywhere.

use super::spectrum::{LONGEST, SHORTEST};
use crate::error::Result;
use crate::surface::statistics::slopes::rms_slopes;
use crate::surface::statistics::spectrum::{SurfaceSpectrum, analysed_part};
use crate::surface::statistics::{Texture, deviation, dominant_periods};
use crate::surface::{HeightField, Statistics};
use std::f64::consts::TAU;

/// The largest RMS slope along an axis.
const LARGEST_SLOPE: f64 = 0.25;
/// The smallest wavenumber times correlation length.
const SMALLEST_KL: f64 = 6.0;
/// The smallest l²/(σλ): the mean radius of curvature exceeds the wavelength.
const SMALLEST_CURVATURE: f64 = 2.76;
/// The smallest feature, half a period, in wavelengths.
const SMALLEST_FEATURE: f64 = 14.0;
/// Where a Gaussian autocorrelation exp(−τ²/l²) has fallen to the 0.2 of Sal: τ = l √(ln 5).
const SAL_OVER_L: f64 = 1.268_636_2;

/// A surface against the domain of scalar theory, over the visible wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Validity {
    /// The larger of the RMS slopes along `x` and `y`, which the domain is about; Sdq is both together, √(x² + y²).
    pub slope: f64,
    /// Which axis it is along.
    pub slope_axis: char,
    /// The strongest period over the longest and over the shortest wavelength; `None` where nothing repeats.
    pub period: Option<[f64; 2]>,
    /// RMS height over the longest and over the shortest wavelength.
    pub height: [f64; 2],
    /// k l at the longest wavelength; `None` where heights stay correlated over the field.
    pub kl: Option<f64>,
    /// l²/(σλ) at the longest wavelength; `None` for a flat surface and where `kl` is.
    pub curvature: Option<f64>,
}

impl Validity {
    /// The numbers of a surface.
    pub fn of(statistics: &Statistics) -> Self {
        let period = statistics.periods.first().map(|period| period.length);
        Self::from_numbers(statistics.slopes.rms, period, statistics.heights.sq, statistics.texture.sal)
    }

    /// The numbers of `field`, without the statistics that they do not need.
    ///
    /// # Errors
    /// Where the memory does not hold the spectrum.
    pub fn of_field(field: &HeightField) -> Result<Self> {
        let part = analysed_part(field);
        let power = SurfaceSpectrum::windowed(&part)?;
        let period = dominant_periods(&part, &power)?.first().map(|period| period.length);
        let sal = Texture::of(&part, &power)?.sal;
        Ok(Self::from_numbers(rms_slopes(field), period, deviation(field), sal))
    }

    /// [`Self::line`] of `field` for a picture's metadata, or why there is none.
    pub fn note(field: &HeightField) -> String {
        Self::of_field(field).map_or_else(|e| format!("not judged: {e}"), |validity| validity.line())
    }

    /// From the RMS slopes along `x` and `y`, the strongest period, RMS height and Sal \[µm\].
    fn from_numbers(slopes: [f64; 2], period: Option<f64>, sq: f64, sal: Option<f64>) -> Self {
        let over = |length: f64| [length / LONGEST, length / SHORTEST];
        let correlation = sal.map(|sal| sal / SAL_OVER_L);
        let [x, y] = slopes;
        Self {
            slope: x.max(y),
            slope_axis: if x >= y { 'x' } else { 'y' },
            period: period.map(over),
            height: over(sq),
            kl: correlation.map(|l| TAU * l / LONGEST),
            curvature: correlation.filter(|_| sq > 0.0).map(|l| l * l / (sq * LONGEST)),
        }
    }

    /// What is outside of the domain, in words; empty where nothing is.
    pub fn violations(&self) -> Vec<String> {
        let nm = LONGEST * 1e3;
        let slope = (self.slope >= LARGEST_SLOPE)
            .then(|| format!("RMS slope along {} {:.2} > {LARGEST_SLOPE}", self.slope_axis, self.slope));
        let kl = self.kl.filter(|kl| *kl <= SMALLEST_KL);
        let kl = kl.map(|kl| format!("k l = {kl:.1} < {SMALLEST_KL} at {nm:.0} nm"));
        let curvature = self.curvature.filter(|curvature| *curvature <= SMALLEST_CURVATURE);
        let curvature = curvature.map(|c| format!("l²/(σλ) = {c:.2} < {SMALLEST_CURVATURE} at {nm:.0} nm"));
        [slope, kl, curvature].into_iter().flatten().collect()
    }

    /// The line of `surface info` and of a picture's metadata.
    pub fn line(&self) -> String {
        let angle = self.slope.atan().to_degrees();
        let period = match self.period {
            Some([least, most]) => format!("period/λ {least:.1} to {most:.1}"),
            None => "no period".to_owned(),
        };
        let [low, high] = self.height;
        let axis = self.slope_axis;
        let numbers =
            format!("RMS slope along {axis} {angle:.1}°, {period}, RMS height/λ {low:.2} to {high:.2}");
        let violations = self.violations();
        let small_features = self.period.is_some_and(|[least, _]| least / 2.0 < SMALLEST_FEATURE);
        let verdict = match (violations.is_empty(), small_features) {
            (false, _) => format!(
                "outside of the Kirchhoff domain ({}); brightness is approximate",
                violations.join(", ")
            ),
            (true, true) => format!(
                "within the Kirchhoff domain; features below {SMALLEST_FEATURE:.0} λ, so that the brightness of orders may be off by more than 5 %"
            ),
            (true, false) => "within the Kirchhoff domain".to_owned(),
        };
        format!("{numbers}: {verdict}; angles of orders are exact")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::HeightField;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    fn validity(field: &HeightField) -> Validity {
        Validity::of(&Statistics::of(field).unwrap())
    }

    /// A sinusoid of `period` and full height `height` over eight periods.
    fn sinusoid(period: f64, height: f64) -> Validity {
        let (patch, pixel_size) = (Some([8.0 * period; 2]), Some([period / 24.0; 2]));
        let spec = Spec {
            patch,
            pixel_size,
            period: Some(period),
            height: Some(height),
            ..Spec::new(SurfaceKind::Sinusoid)
        };
        validity(&generate(&spec).unwrap())
    }

    #[test]
    fn a_long_shallow_sinusoid_is_within_and_a_short_steep_one_is_not() {
        let long = sinusoid(30.0, 0.2);
        assert!(long.violations().is_empty(), "{long:?}");
        assert!(
            long.line().ends_with("within the Kirchhoff domain; angles of orders are exact"),
            "{}",
            long.line()
        );
        let medium = sinusoid(10.0, 0.2);
        assert!(medium.violations().is_empty() && medium.line().contains("below 14 λ"), "{}", medium.line());
        // π·0.4/0.8/√2 is an RMS slope of 1.1.
        let steep = sinusoid(0.8, 0.4).line();
        for part in
            ["RMS slope along x 1.1", "k l = ", "l²/(σλ)", "brightness is approximate", "period/λ 1.0 to 2.1"]
        {
            assert!(steep.contains(part), "{part}: {steep}");
        }
    }

    #[test]
    fn the_numbers_are_those_of_the_sinusoid() {
        let v = sinusoid(10.0, 0.2);
        let slope = std::f64::consts::PI * 0.2 / 10.0 / 2_f64.sqrt();
        assert!((v.slope / slope - 1.0).abs() < 1e-2, "{v:?}");
        assert!((v.height[0] - 0.1 / 2_f64.sqrt() / LONGEST).abs() < 1e-6);
        assert!((v.period.unwrap()[1] - 10.0 / SHORTEST).abs() < 0.05, "{v:?}");
    }

    #[test]
    fn a_picture_says_of_its_surface_what_the_statistics_say() {
        for kind in SurfaceKind::ALL {
            let field = generate(&Spec { patch: Some([20.0; 2]), ..Spec::new(kind) }).unwrap();
            assert_eq!(Validity::note(&field), validity(&field).line(), "{kind:?}");
        }
    }

    #[test]
    fn the_steeper_axis_is_named() {
        let heights = |along_x: f64, along_y: f64| {
            let at = |i: usize| along_x * (i % 40) as f64 + along_y * (i / 40) as f64;
            HeightField::new(40, 40, [0.1; 2], (0..1600).map(at).collect()).unwrap()
        };
        let (x, y) = (validity(&heights(0.03, 0.01)), validity(&heights(0.01, 0.03)));
        assert!(
            (x.slope - 0.3).abs() < 1e-9 && x.line().starts_with("RMS slope along x 16.7°"),
            "{}",
            x.line()
        );
        assert!(
            (y.slope - 0.3).abs() < 1e-9 && y.line().contains("RMS slope along y 0.30 > 0.25"),
            "{}",
            y.line()
        );
    }

    #[test]
    fn a_mirror_is_within() {
        let mirror = validity(&generate(&Spec::new(SurfaceKind::Flat)).unwrap());
        assert!(mirror.violations().is_empty() && mirror.line().contains("no period"), "{}", mirror.line());
    }
}
