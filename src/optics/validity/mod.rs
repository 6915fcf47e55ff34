//! Errors of scalar theory for a surface, looked up in a table of rigorous efficiencies.
//!
//! The optics has the phase of light that is reflected once and a factor in front of its integral, the small-slope approximation of first order or
//! Stam's, a tangent plane at each point (the Kirchhoff approximation). `tools/validity` compares both with the C method [Chandezon et al. 1982, J. Opt. Soc. Am. 72, 839] for grooves in one direction, light in
//! the plane across them; `docs/VALIDITY.md` has the results. The angles of the orders follow from the period alone and are exact.

mod bands;
mod table;

use super::polarisation::Polarisation;
use super::reflectance::Reflectance;
use super::theory::Theory;
use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::statistics::{ProfileShape, Relief};
pub use bands::LightColour;
use serde::Serialize;
pub use table::AngleErrors;
use table::MaterialClass;

/// Errors of scalar theory for a surface, material and light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScalarTheory {
    /// [`Self::line`], for people.
    line: String,
    /// The profile that was looked up.
    grooves: Option<ProfileShape>,
    /// Mean wavelength of the light \[m\].
    wavelength_m: f64,
    /// Errors by the angle of incidence; empty if unknown.
    errors: Vec<AngleErrors>,
    /// Polarisation of the light, whose error the line tells.
    polarisation: Polarisation,
    /// The theory whose errors these are.
    theory: &'static str,
}

impl ScalarTheory {
    /// Looks up a surface of this shape, which reflects like this, in light of this colour.
    pub fn new(relief: Relief, reflectance: &Reflectance, colour: LightColour<'_>) -> Self {
        let bands = bands::bands(colour);
        let wavelength = bands::mean_wavelength(&bands);
        let unknown = |line: String| Self {
            line,
            grooves: None,
            wavelength_m: wavelength * 1e-6,
            errors: Vec::new(),
            polarisation: Polarisation::None,
            theory: reflectance.theory().name(),
        };
        let found = match relief {
            Relief::Flat => return unknown("diffracted orders err by 0 %: a mirror has none".to_owned()),
            Relief::Crossed([larger, smaller]) => Err(format!(
                "RMS slopes in two directions, {larger:.2} and {smaller:.2}; computed for grooves in one direction"
            )),
            Relief::FewPeriods => {
                Err("fewer than three periods over the field, whose copies do not join".to_owned())
            }
            Relief::OtherProfile => {
                Err("the profile is neither sinusoid, blaze, lamellar nor rough, which are what was computed"
                    .to_owned())
            }
            Relief::Grooves(grooves) => {
                bands::mean_errors(&grooves, reflectance, &bands).map(|errors| (grooves, errors))
            }
        };
        match found {
            Ok((grooves, errors)) => {
                let polarisation = reflectance.polarisation();
                let [errors_text, entry] =
                    [by_angle(&errors, polarisation), described(&grooves, reflectance, wavelength)];
                let known = unknown(format!("{errors_text}; {entry}"));
                Self { grooves: Some(grooves), errors, polarisation, ..known }
            }
            Err(reason) => unknown(format!("not known: {reason}; angles of orders are exact")),
        }
    }

    /// Measures `field` and looks it up.
    ///
    /// # Errors
    /// Too little memory for the spectrum.
    pub fn of_field(field: &HeightField, reflectance: &Reflectance, colour: LightColour<'_>) -> Result<Self> {
        Ok(Self::new(Relief::of(field)?, reflectance, colour))
    }

    /// Returns [`Self::line`] of `field` for a picture's metadata, or the reason why there is none.
    pub fn note(field: &HeightField, reflectance: &Reflectance, colour: LightColour<'_>) -> String {
        let found = Self::of_field(field, reflectance, colour);
        found.map_or_else(|e| format!("not known: {e}"), |found| found.line)
    }

    /// Returns the line of `surface info` and of a picture's metadata.
    pub fn line(&self) -> &str {
        &self.line
    }

    /// Returns the errors of the least and the greatest angle of incidence, for a row of a panel.
    pub fn brief(&self) -> String {
        match self.errors.as_slice() {
            [] => self.line.split([':', ';']).next().unwrap_or_default().to_owned(),
            [only] => self.error_at(only),
            [first, .., last] => format!("{}, {}", self.error_at(first), self.error_at(last)),
        }
    }

    /// Returns the errors at this angle of incidence \[degrees\], 0 to 90, between those of the angles that were computed; `None` where they are
    /// not known.
    pub fn at_angle(&self, angle: f64) -> Option<AngleErrors> {
        let after = self.errors.iter().position(|errors| errors.angle >= angle)?;
        let b = self.errors[after];
        if b.angle == angle {
            return Some(b);
        }
        let a = *self.errors.get(after.checked_sub(1)?)?;
        let share = (angle - a.angle) / (b.angle - a.angle);
        // Errors grow by factors, as between the periods and heights of the table.
        let between = |a: f64, b: f64| a * (b / a).powf(share);
        Some(AngleErrors {
            angle,
            mean: between(a.mean, b.mean),
            te: between(a.te, b.te),
            tm: between(a.tm, b.tm),
        })
    }

    /// Returns the error at an angle in a few words.
    fn error_at(&self, errors: &AngleErrors) -> String {
        let error = percent(errors.in_light(self.polarisation)).replace("more than", "over");
        format!("{error} at {}°", errors.angle)
    }
}

/// Describes the entry of the table in words, for light of this mean wavelength \[µm\].
fn described(grooves: &ProfileShape, reflectance: &Reflectance, wavelength: f64) -> String {
    let [period, height] = [grooves.period, grooves.height].map(|length| length / wavelength);
    let class = MaterialClass::of(reflectance, wavelength);
    let [profile, material] = [grooves.profile.name(), class.map_or("another material", MaterialClass::name)];
    let light = match reflectance.polarisation() {
        Polarisation::None => "",
        Polarisation::Te => " in TE light",
        Polarisation::Tm => " in TM light",
    };
    let factor = match reflectance.theory() {
        Theory::SmallSlope => "",
        Theory::Stam => " with Stam's factor",
    };
    /// Largest RMS slope along the grooves that is not mentioned.
    const NEARLY_STRAIGHT: f64 = 0.02;
    let left_out = match grooves.slope_along {
        slope if slope > NEARLY_STRAIGHT => format!(", RMS slope {slope:.2} along the grooves left out"),
        _ => String::new(),
    };
    format!(
        "mean over the light{factor}, {profile} on {material}{light}, period {period:.1} λ, height {height:.2} λ at {:.0} nm{left_out}; angles of orders are exact",
        wavelength * 1e3
    )
}

/// Describes the errors in light of this polarisation, one phrase for a range of angles with nearly equal errors.
fn by_angle(errors: &[AngleErrors], polarisation: Polarisation) -> String {
    /// Share below which errors form one group, like those below [`ALIKE`] times the first of a group.
    const SMALL: f64 = 0.02;
    const ALIKE: f64 = 1.5;
    let mut groups: Vec<(f64, f64, f64)> = Vec::new(); // first angle, last angle, largest error
    let mut limit = 0.0;
    for (angle, error) in errors.iter().map(|e| (e.angle, e.in_light(polarisation))) {
        match groups.last_mut() {
            Some((_, last, largest)) if error <= limit => (*last, *largest) = (angle, largest.max(error)),
            _ => {
                limit = (ALIKE * error).max(SMALL);
                groups.push((angle, angle, error));
            }
        }
    }
    let words = groups.iter().map(|(first, last, error)| match (first == last, *first == 0.0) {
        (true, _) => format!("{} at {first}°", percent(*error)),
        (false, true) => format!("{} up to {last}°", percent(*error)),
        (false, false) => format!("{} from {first}° to {last}°", percent(*error)),
    });
    format!("diffracted orders err by {}", words.collect::<Vec<_>>().join(", "))
}

/// Returns a share in whole percent, rounded up, or "more than 100 %".
fn percent(share: f64) -> String {
    if share > 1.0 {
        "more than 100 %".to_owned()
    } else {
        format!("{:.0} %", (share * 100.0).ceil().max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::material::Material;
    use crate::optics::reflectance::Film;
    use crate::optics::spectrum::{Illuminant, MIDDLE};
    use crate::surface::statistics::ProfileKind;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    const GREEN: LightColour<'static> = LightColour::Wavelength(MIDDLE);

    fn metal() -> Reflectance {
        let material = Material::from_name_or_file("aluminium").unwrap();
        Reflectance::of_material(material, None)
    }

    fn sinusoid(period: f64, height: f64) -> Relief {
        let [period, height] = [period, height].map(|length| length * MIDDLE);
        Relief::Grooves(ProfileShape { profile: ProfileKind::Sinusoid, period, height, slope_along: 0.0 })
    }

    fn at(theory: &ScalarTheory, angle: f64) -> f64 {
        theory.errors.iter().find(|e| e.angle == angle).unwrap().mean
    }

    #[test]
    fn long_shallow_sinusoids_err_little_and_with_stams_factor_more_at_grazing_angles() {
        let known = |relief, reflectance: &Reflectance| ScalarTheory::new(relief, reflectance, GREEN);
        let [metal, glass] = [metal(), Reflectance::default()].map(|r| known(sinusoid(9.0, 0.25), &r));
        assert!(at(&metal, 0.0) < 0.02 && at(&metal, 75.0) < 0.04, "{metal:?}");
        assert!(at(&glass, 0.0) < 0.02 && at(&glass, 75.0) < 0.04, "{glass:?}");
        assert!(
            metal.line().contains("light, sinusoid on metal, period 9.0 λ, height 0.25 λ at 550 nm"),
            "{metal:?}"
        );
        let stam = known(sinusoid(9.0, 0.25), &Reflectance::default().by(Theory::Stam));
        assert!(at(&stam, 0.0) < 0.02 && at(&stam, 75.0) > 0.2, "{stam:?}");
        assert!(stam.line().contains("mean over the light with Stam's factor, sinusoid"), "{stam:?}");
        assert!(
            stam.brief().starts_with("2 % at 0°, ") || stam.brief().starts_with("1 % at 0°, "),
            "{stam:?}"
        );
    }

    #[test]
    fn what_was_not_computed_is_not_known() {
        let line = |relief, reflectance: &Reflectance| {
            ScalarTheory::new(relief, reflectance, GREEN).line().to_owned()
        };
        let glass = Reflectance::default();
        for (relief, word) in [
            (sinusoid(1.0, 0.9), "steeper than"),
            (sinusoid(10.0, 3.0), "higher"),
            (sinusoid(0.4, 0.05), "shorter"),
            (Relief::Crossed([0.3, 0.2]), "two directions"),
            (Relief::FewPeriods, "three periods"),
            (Relief::OtherProfile, "neither sinusoid"),
        ] {
            let line = line(relief, &glass);
            assert!(line.starts_with("not known: ") && line.contains(word), "{line}");
        }
        assert_eq!(ScalarTheory::new(Relief::FewPeriods, &glass, GREEN).brief(), "not known");
        let film = Some(Film { thickness: 0.1, index: 1.7 });
        let silicon = Material::from_name_or_file("silicon").unwrap();
        for (reflectance, word) in [
            (Reflectance::of_material(Material::constant(1.5), film), "film"),
            (Reflectance::of_material(silicon, None), "refractive indices"),
            (Reflectance::Schlick(1.5), "Fresnel"),
        ] {
            let line = line(sinusoid(5.0, 0.2), &reflectance);
            assert!(line.starts_with("not known: ") && line.contains(word), "{line}");
        }
    }

    #[test]
    fn angles_with_like_errors_are_told_together() {
        let errors = |means: &[(f64, f64)]| -> Vec<AngleErrors> {
            means.iter().map(|&(angle, mean)| AngleErrors { angle, mean, te: mean, tm: mean }).collect()
        };
        let line = by_angle(
            &errors(&[(0.0, 0.021), (30.0, 0.01), (45.0, 0.03), (60.0, 0.114), (75.0, 1.4)]),
            Polarisation::None,
        );
        assert_eq!(line, "diffracted orders err by 3 % up to 45°, 12 % at 60°, more than 100 % at 75°");
        let line = by_angle(&errors(&[(30.0, 0.1), (45.0, 0.12)]), Polarisation::Te);
        assert_eq!(line, "diffracted orders err by 12 % from 30° to 45°");
    }

    #[test]
    fn built_in_surfaces_have_a_line_and_a_mirror_errs_by_nothing() {
        for kind in SurfaceKind::ALL {
            let field = generate(&Spec { patch: Some([20.0; 2]), ..Spec::new(kind) }).unwrap();
            let line = ScalarTheory::note(&field, &metal(), LightColour::Spectrum(&Illuminant::D65));
            let known = line.starts_with("diffracted orders err by ") && line.contains(" %");
            assert!(known || line.starts_with("not known: "), "{kind:?}: {line}");
            assert_eq!(line.contains("mirror"), kind == SurfaceKind::Flat, "{kind:?}: {line}");
        }
    }
}
