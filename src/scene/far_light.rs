//! Lights that are far away: points and discs of the sky.

use super::incident::{Incident, concentric, share_of_sample, spread_of};
use crate::error::{Error, Result};
use crate::optics::coherence::Coherence;
use crate::optics::geometry::direction;
use crate::units;
use glam::Vec3;
use std::fmt;

/// Largest intensity of a light.
const MAX_INTENSITY: f64 = 1e6;

/// Distant light: `THETA,PHI[,INTENSITY]`, a point of the sky; `sun:THETA,PHI[,INTENSITY]`, the sun's disc; or
/// `disc:SIZE:THETA,PHI[,INTENSITY]`, a disc of this angular diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarLight {
    /// Angle from the surface normal \[degrees\], 0 ≤ theta ≤ 90.
    pub theta: f64,
    /// Angle from +x toward +y \[degrees\], −360 ≤ phi ≤ 360.
    pub phi: f64,
    /// Relative intensity, above 0; 1 by default.
    pub intensity: f64,
    /// Angular diameter of its disc \[degrees\]; 0 for a point.
    pub size: f64,
}

/// Mean angular diameter of the sun seen from the earth \[degrees\].
pub const SUN: f64 = 0.533;
/// Largest angular diameter of a light \[degrees\]: half of the sky.
const LARGEST_DISC: f64 = 180.0;

impl FarLight {
    /// Parses a light `THETA,PHI` or `THETA,PHI,INTENSITY`, angles in plain degrees.
    ///
    /// # Errors
    /// Another number of fields, 0 ≤ theta ≤ 90, |phi| ≤ 360 or 0 < intensity ≤ 10⁶ violated.
    pub fn parse(text: &str) -> Result<Self> {
        const FORM: &str = "write THETA,PHI or THETA,PHI,INTENSITY in plain degrees, as in 30,90, sun:30,90 or disc:5deg:30,90";
        let (size, place) = match text.split_once(':') {
            None => (0.0, text),
            Some((kind, place)) if kind.trim() == "sun" => (SUN, place),
            Some((kind, rest)) if kind.trim() == "disc" => {
                let (size, place) = rest
                    .split_once(':')
                    .ok_or_else(|| Error::usage(format!("'{text}' is not a light"), FORM))?;
                (disc(size, text)?, place)
            }
            Some(_) => return Err(Error::usage(format!("'{text}' is not a light"), FORM)),
        };
        let fields: Vec<&str> = place.split(',').map(str::trim).collect();
        let (theta, phi, intensity) = match fields[..] {
            [theta, phi] => (theta, phi, "1"),
            [theta, phi, intensity] => (theta, phi, intensity),
            _ => return Err(Error::usage(format!("'{text}' is not a light"), FORM)),
        };
        let number = |field: &str| {
            units::number(field)
                .ok_or_else(|| Error::usage(format!("'{field}' in the light '{text}' is not a number"), FORM))
        };
        let light = Self { theta: number(theta)?, phi: number(phi)?, intensity: number(intensity)?, size };
        let refuse = |what: String, remedy: &'static str| {
            Err(Error::usage(what + &format!(" in the light '{text}'"), remedy))
        };
        if !(0.0..=90.0).contains(&light.theta) {
            return refuse(
                format!("the angle THETA of {theta} degrees"),
                "give 0 (straight above) to 90 (grazing)",
            );
        }
        if !(-360.0..=360.0).contains(&light.phi) {
            return refuse(format!("the angle PHI of {phi} degrees"), "give -360 to 360");
        }
        if !(light.intensity > 0.0 && light.intensity <= MAX_INTENSITY) {
            return refuse(format!("the intensity {intensity}"), "give a number above 0, at most 1000000");
        }
        Ok(light)
    }

    /// Returns the unit vector to the light's centre, `theta` from the world's up (+z), `phi` from +x toward +y. The intensity is the
    /// irradiance over π: a white diffuse surface that faces a light of intensity 1 has a radiance of 1.
    pub fn direction(&self) -> Vec3 {
        direction(self.theta, self.phi).as_vec3()
    }

    /// Returns the sample at `point` (uniform in 0 … 1) of `count` samples. The map of Shirley and Chiu (1997) spreads the directions
    /// evenly over a disc around the light's centre and keeps neighbours together. Each sample has four times the variance of its part of
    /// the disc, or more below 16 samples. The disc of the directions is smaller by as much, so that all samples together have the variance
    /// of the light. Up to eight samples are all at the centre. Samples that faced the surface would each give the whole disc's irradiance over the mean of its
    /// cosines.
    pub fn incident(&self, point: [f64; 2], count: u32) -> Incident {
        let centre = direction(self.theta, self.phi);
        let share = share_of_sample(count);
        let disc = 1.0 - (0.5 * self.size).to_radians().cos();
        let cap = disc * (1.0 - share);
        // The cosine to the centre is spread evenly over a cap.
        let mean_of = |cap: f64| 1.0 - 0.5 * cap;
        let (radius, angle) = concentric(point);
        let height = radius * radius * cap; // 1 − cos α
        let sine = (height * (2.0 - height)).max(0.0).sqrt();
        let (across, along) = centre.any_orthonormal_pair();
        let direction = centre * (1.0 - height) + (across * angle.cos() + along * angle.sin()) * sine;
        Incident {
            direction,
            place: None,
            irradiance: Vec3::splat((self.intensity / mean_of(disc)) as f32),
            variance: self.variance() * share,
            mean: mean_of(disc) / mean_of(cap),
        }
    }

    /// Returns the variance of the disc's directions along each axis across its centre: ⟨sin² α⟩/2 over its solid angle.
    fn variance(&self) -> f64 {
        let cap = 1.0 - (0.5 * self.size).to_radians().cos();
        (cap - cap * cap / 3.0) / 2.0
    }

    /// Subtracts from the light's extent the part that `coherence` contains already: light of coherence length σ has directions that spread
    /// by λ/(√8 π σ), the sun's disc for sunlight.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence) -> Self {
        let held = spread_of(coherence);
        let whole = self.variance();
        let left = if whole > 0.0 { (1.0 - held / whole).max(0.0).sqrt() } else { 0.0 };
        Self { size: self.size * left, ..self }
    }
}

impl fmt::Display for FarLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.size == SUN {
            write!(f, "sun:")?;
        } else if self.size > 0.0 {
            write!(f, "disc:{}deg:", self.size)?;
        }
        write!(f, "{},{},{}", self.theta, self.phi, self.intensity)
    }
}

/// Parses the angular diameter of a disc, as in `5deg` \[degrees\].
fn disc(size: &str, light: &str) -> Result<f64> {
    let degrees = units::angle(size).map_err(|e| e.at(format!("'{light}'")))?;
    if degrees > 0.0 && degrees <= LARGEST_DISC {
        return Ok(degrees);
    }
    Err(Error::usage(
        format!("the size {size} in the light '{light}'"),
        format!("give a diameter above 0deg, at most {LARGEST_DISC}deg"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::spectrum::MIDDLE;
    use glam::DVec3;
    use std::f64::consts::PI;

    #[test]
    fn samples_of_a_disc_cover_its_solid_angle_evenly() {
        let light = FarLight::parse("disc:40deg:30,70").unwrap();
        let centre = light.direction().as_dvec3();
        let side = 200;
        let place = |i: usize| (i as f64 + 0.5) / f64::from(side);
        let points = (0..side * side).map(|i| [place((i % side) as usize), place((i / side) as usize)]);
        let directions: Vec<DVec3> = points.map(|p| light.incident(p, 1 << 20).direction).collect();
        let count = directions.len() as f64;
        let cosines: Vec<f64> = directions.iter().map(|d| d.dot(centre)).collect();
        let edge = 20f64.to_radians().cos();
        assert!(cosines.iter().all(|c| *c >= edge - 1e-12));
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
        // The cosine is uniform over a cap.
        assert!((cosines.iter().sum::<f64>() / count - (1.0 + edge) / 2.0).abs() < 1e-4);
        let across = centre.any_orthonormal_vector();
        let variance = directions.iter().map(|d| d.dot(across).powi(2)).sum::<f64>() / count;
        assert!((variance / light.variance() - 1.0).abs() < 1e-3);
        assert!((light.incident([0.1, 0.2], 8).direction - centre).length() < 1e-7);
        // For any number of samples, their spread and the variance of each add up to the light's variance.
        for count in [9, 16, 100] {
            let all = (0..side * side)
                .map(|i| light.incident([place((i % side) as usize), place((i / side) as usize)], count));
            let spread = all.map(|i| i.direction.dot(across).powi(2)).sum::<f64>() / f64::from(side * side);
            let sum = spread + light.incident([0.1, 0.2], count).variance;
            assert!((sum / light.variance() - 1.0).abs() < 0.01, "{count}: {sum}");
        }
    }

    #[test]
    fn the_sun_is_no_more_than_what_the_coherence_of_sunlight_holds() {
        let sun = FarLight::parse("sun:30,70").unwrap();
        assert_eq!(sun.beyond(&Coherence::SUNLIGHT).size, 0.0);
        assert_eq!(sun.beyond(&Coherence::Repeats([3, 3])), sun);
        let disc = FarLight::parse("disc:5deg:30,70").unwrap();
        let left = disc.beyond(&Coherence::SUNLIGHT);
        let held = (MIDDLE / (8f64.sqrt() * PI * 65.0 / 4.0)).powi(2);
        assert!((left.variance() + held - disc.variance()).abs() < 1e-3 * held, "{left:?}");
        assert_eq!(FarLight::parse("30,70").unwrap().beyond(&Coherence::SUNLIGHT).size, 0.0);
    }

    #[test]
    fn a_light_has_two_or_three_fields_in_range() {
        assert_eq!(
            FarLight::parse("30,90").unwrap(),
            FarLight { theta: 30.0, phi: 90.0, intensity: 1.0, size: 0.0 }
        );
        assert_eq!(FarLight::parse("sun:30,90").unwrap().size, SUN);
        let disc = FarLight::parse("disc:5deg:30,90,2").unwrap();
        assert_eq!(disc, FarLight { theta: 30.0, phi: 90.0, intensity: 2.0, size: 5.0 });
        assert_eq!(
            FarLight::parse(" 0 , -180 , 2.5 ").unwrap(),
            FarLight { theta: 0.0, phi: -180.0, intensity: 2.5, size: 0.0 }
        );
        assert!(FarLight::parse("90,360").is_ok());
        for text in [
            "",
            "30",
            "30,",
            ",",
            "1,2,3,4",
            "91,0",
            "-1,0",
            "0,361",
            "0,0,0",
            "0,0,-1",
            "0,0,1e7",
            "NaN,0",
            "0,inf",
            "30deg,0",
            "0,0,NaN",
            "sun",
            "sun:",
            "sun:30",
            "moon:30,90",
            "disc:30,90",
            "disc:0deg:30,90",
            "disc:181deg:30,90",
            "disc:5:30,90",
            "disc:5deg",
            ":30,90",
        ] {
            assert_eq!(FarLight::parse(text).unwrap_err().kind(), crate::error::ErrorKind::Usage, "{text}");
        }
    }
}
