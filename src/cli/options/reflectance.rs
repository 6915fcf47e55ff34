//! Options of the surface's reflectance.

use super::{IORS, real};
use crate::cli::console::Console;
use crate::error::{Error, Result};
use crate::optics::material::Material;
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::{DielectricLaw, Film, Reflectance};
use crate::optics::theory::Theory;
use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};
use std::ffi::OsStr;

/// Default refractive index of a surface.
const DEFAULT_IOR: f64 = 1.5;

/// The share of the light that the surface reflects.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Optics")]
pub struct ReflectanceOptions {
    /// Refractive index of the surface, at every wavelength [default: 1.5]
    #[arg(long, value_name = "N", value_parser = ior, allow_hyphen_values = true, hide_short_help = true)]
    pub ior: Option<f64>,
    /// Material of the surface, for Fresnel's equations at every wavelength: glass, keratin, aluminium, silver, gold, copper, nickel,
    /// silicon, or a CSV file of wavelength in nm or µm, n and k, also as two blocks of refractiveindex.info
    #[arg(long, value_name = "NAME|FILE", value_parser = OsStringValueParser::new().try_map(Material::from_name_or_file), conflicts_with = "ior")]
    pub material: Option<Material>,
    /// Equations for the share of light that an index reflects: fresnel (exact), or schlick (the approximation of the thesis, 20 % off at 60
    /// degrees) [default: fresnel]
    #[arg(long, value_name = "fresnel|schlick", value_parser = law, conflicts_with_all = ["material", "film"], hide_short_help = true)]
    pub reflectance: Option<DielectricLaw>,
    /// Thin transparent film on the surface, with thickness and refractive index, as in 120nm:1.7
    #[arg(long, value_name = "LENGTH:N", value_parser = Film::parse, allow_hyphen_values = true, hide_short_help = true)]
    pub film: Option<Film>,
    /// Theory of the brightness: small-slope (the small-slope approximation of first order, limited so that no surface reflects more than a flat one), or stam (the
    /// factor of the thesis, without a limit) [default: small-slope; stam with --reflectance schlick]
    #[arg(long, value_name = "small-slope|stam", value_parser = Theory::from_name, hide_short_help = true)]
    pub theory: Option<Theory>,
    /// Polarisation of the light that comes in: te (electric field perpendicular to the plane of incidence; by Stam's theory to the plane of light and viewer), tm (in it) or none [default: none]
    #[arg(long, value_name = "te|tm|none", value_parser = Polarisation::from_name, hide_short_help = true)]
    pub polarisation: Option<Polarisation>,
}

impl ReflectanceOptions {
    /// Checks that the options go together.
    ///
    /// # Errors
    /// Polarised light under an approximation that has none, and Schlick's approximation in another theory than its own.
    pub fn check(&self) -> Result<()> {
        let polarised = self.polarisation.is_some_and(|light| light != Polarisation::None);
        if polarised && self.reflectance == Some(DielectricLaw::Schlick) {
            return Err(Error::usage(
                "Schlick's approximation knows no polarisation",
                "leave --reflectance schlick away, for Fresnel's equations",
            ));
        }
        if self.reflectance == Some(DielectricLaw::Schlick) && self.theory == Some(Theory::SmallSlope) {
            return Err(Error::usage(
                "Schlick's approximation is a factor of Stam's theory",
                "leave --reflectance schlick away, or use --theory stam",
            ));
        }
        Ok(())
    }

    /// Tells, once a run, where the index of the material is not given.
    pub fn tell(&self, console: &Console) {
        if let Some(note) = self.material.as_ref().and_then(Material::note) {
            console.say_once("material", &note);
        }
    }

    /// Returns the reflectance of the surface: that of the scene, unless the options name a material, by their theory, in light of their polarisation.
    pub fn of_surface(&self, scene: Option<&Reflectance>) -> Reflectance {
        let named = self.named().or_else(|| scene.cloned());
        let reflectance = named.unwrap_or_default().by(self.theory.unwrap_or_default());
        reflectance.polarised(self.polarisation.unwrap_or_default())
    }

    /// Returns the reflectance that the options name, in unpolarised light.
    fn named(&self) -> Option<Reflectance> {
        if self.material.is_none() && self.film.is_none() {
            let named = self.ior.is_some() || self.reflectance.is_some();
            let law = self.reflectance.unwrap_or(DielectricLaw::Fresnel);
            return named.then(|| law.of_index(self.ior.unwrap_or(DEFAULT_IOR)));
        }
        let plain = || Material::constant(self.ior.unwrap_or(DEFAULT_IOR));
        Some(Reflectance::of_material(self.material.clone().unwrap_or_else(plain), self.film))
    }

    /// Returns the file of the material; `None` for a built-in one.
    pub fn files(&self) -> Option<&OsStr> {
        let name = self.material.as_ref().map(|material| OsStr::new(&material.name));
        name.filter(|name| !Material::is_built_in(name))
    }
}

/// Parses a refractive index.
pub fn ior(text: &str) -> Result<f64> {
    real(text, IORS, "refractive index")
}

fn law(text: &str) -> Result<DielectricLaw> {
    let named = DielectricLaw::ALL.into_iter().find(|law| law.name() == text);
    named.ok_or_else(|| Error::usage(format!("there is no reflectance `{text}`"), "give fresnel or schlick"))
}
