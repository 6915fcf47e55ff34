//! Settings of the optics, one by one.

use crate::error::Result;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::material::Material;
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::{Film, Reflectance};
use crate::optics::spectrum::Illuminant;
use crate::optics::theory::Theory;
use crate::settings::{Method, Optics};

impl Optics {
    /// Returns the default settings: sunlight of a coherence length of 65 µm under D65, the mean over all coherence windows, copies of the patch, a refractive
    /// index of 1.5, unpolarised light by small-slope theory, a tolerance of 1e-2.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the settings with light of this coherence `length` \[µm\].
    #[must_use]
    pub fn with_coherence_length(self, length: f64) -> Self {
        Self { coherence: Coherence::Gaussian { length }, ..self }
    }

    /// Returns the settings of one coherence window at the middle of the patch, whose amplitude the thesis computes: a grainy answer, by the direct sum.
    #[must_use]
    pub fn through_one_window(self) -> Self {
        Self { windows: Windows::ONE, method: Method::Reference, ..self }
    }

    /// Returns the settings of a finite grating of `copies` of the patch along x and y in fully coherent light, by the direct sum.
    #[must_use]
    pub fn with_copies(self, copies: [u32; 2]) -> Self {
        Self { coherence: Coherence::Repeats(copies), ..self.through_one_window() }
    }

    /// Returns the settings with this continuation of the surface beyond the patch.
    #[must_use]
    pub fn with_beyond(self, beyond: Beyond) -> Self {
        Self { beyond, ..self }
    }

    /// Returns the settings with a transparent material of this refractive index.
    #[must_use]
    pub fn with_refractive_index(self, index: f64) -> Self {
        self.with_material_below(Material::constant(index), None)
    }

    /// Returns the settings with a built-in material, such as `gold`, or one of a CSV file of wavelength \[nm\], n and k.
    ///
    /// # Errors
    /// Fails for a file that cannot be read or is no such table.
    pub fn with_material(self, name: &str) -> Result<Self> {
        Ok(self.with_material_below(Material::from_name_or_file(name)?, None))
    }

    /// Returns the settings with a built-in material, or one of a file, below a film as in `120nm:1.7`: its thickness and refractive index.
    ///
    /// # Errors
    /// Fails for a file that is no such table, and for text that is no film.
    pub fn with_coated_material(self, name: &str, film: &str) -> Result<Self> {
        Ok(self.with_material_below(Material::from_name_or_file(name)?, Some(Film::parse(film)?)))
    }

    /// Returns the settings with `polarisation` of the light.
    #[must_use]
    pub fn with_polarisation(self, polarisation: Polarisation) -> Self {
        Self { reflectance: self.reflectance.clone().polarised(polarisation), ..self }
    }

    /// Returns the settings with `theory` of the factor.
    #[must_use]
    pub fn with_theory(self, theory: Theory) -> Self {
        Self { reflectance: self.reflectance.clone().by(theory), ..self }
    }

    /// Returns the settings with a built-in spectrum of the light, such as `a`, or one of a CSV file of wavelength \[nm\] and power.
    ///
    /// # Errors
    /// Fails for a file that cannot be read or is no such table.
    pub fn with_illuminant(self, name: &str) -> Result<Self> {
        Ok(Self { illuminant: Illuminant::from_name_or_file(name)?, ..self })
    }

    /// Returns the settings with this relative error that is accepted.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Returns the settings of the 64-bit reference: no error but rounding, for many times the work.
    #[must_use]
    pub fn by_reference(self) -> Self {
        Self { method: Method::Reference, ..self }
    }

    /// Returns the settings with `material` below `film`, in the light and by the theory of before.
    fn with_material_below(self, material: Material, film: Option<Film>) -> Self {
        let Self { reflectance: former, .. } = &self;
        let reflectance = Reflectance::of_material(material, film).polarised(former.polarisation());
        Self { reflectance: reflectance.by(former.stated_theory()), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_keeps_the_light_and_the_theory_of_before() {
        let optics = Optics::new().with_polarisation(Polarisation::Te).with_theory(Theory::Stam);
        let gold = optics.with_material("gold").unwrap();
        assert_eq!(gold.reflectance.polarisation(), Polarisation::Te);
        assert_eq!(gold.reflectance.stated_theory(), Theory::Stam);
        assert!(Optics::new().with_material("unobtainium").is_err());
        assert!(Optics::new().with_coated_material("gold", "thick").is_err());
        assert_eq!(Optics::new().with_refractive_index(1.7).reflectance.index(), Some(1.7));
        Optics::new().with_copies([3, 2]).check().unwrap();
        Optics::new().with_coherence_length(20.0).through_one_window().check().unwrap();
    }
}
