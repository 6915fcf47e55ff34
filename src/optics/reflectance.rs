//! Share of the light that a surface reflects, and the factor in front of the power |P|² that follows from it by a [`Theory`].
//!
//! Materials have Fresnel's equations and a complex index n + ik, with fields that go as e^(−iωt), so that k ≥ 0 absorbs
//! (Born & Wolf, *Principles of Optics*, 1.5 and 14.2). A thin film is the sum of its reflections (Airy's formula; 1.6 there). The thesis takes
//! Schlick's approximation for one refractive index, which at 60° is a fifth below Fresnel's equations.

use super::brdf::{schlick, schlick_from};
use super::material::Material;
use super::polarisation::Polarisation;
use super::spectrum::{LONGEST, MIDDLE, SHORTEST, observer};
use super::theory::Theory;
use crate::error::{Error, Result};
use crate::units;
use rustfft::num_complex::Complex64;
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt;
use std::path::PathBuf;

/// Reflectance of a surface, with the theory of its factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Reflectance {
    /// Schlick's approximation for a dielectric of this refractive index at all wavelengths, with Stam's factor, as in the thesis.
    Schlick(f64),
    /// Fresnel's equations for a material below an optional thin film.
    Fresnel {
        /// Material of the surface.
        material: Material,
        /// Film on the material, following the profile.
        film: Option<Film>,
        /// Polarisation of the light.
        polarisation: Polarisation,
        /// Theory of the factor, if there is no film.
        theory: Theory,
    },
}

/// Equations for the reflectance of a dielectric that has one refractive index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DielectricLaw {
    /// Fresnel's equations.
    Fresnel,
    /// Schlick's approximation to them.
    Schlick,
}

impl DielectricLaw {
    /// All laws.
    pub const ALL: [Self; 2] = [Self::Fresnel, Self::Schlick];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fresnel => "fresnel",
            Self::Schlick => "schlick",
        }
    }

    /// Returns the reflectance of a dielectric of refractive index `ior`.
    pub fn of_index(self, ior: f64) -> Reflectance {
        match self {
            Self::Fresnel => Reflectance::dielectric(ior),
            Self::Schlick => Reflectance::Schlick(ior),
        }
    }
}

/// Steps of the cosine and of the wavenumber in [`Reflectance::table`]. Read between them, R errs by less than 5e-3 (RMS) below the thickest film,
/// of index 2, and by less than 2e-3 below thin ones. Single values err by more at grazing angles: a thick film on a metal has lines there that are
/// narrower than a step.
pub const COLUMNS: usize = 256;
/// See [`COLUMNS`].
pub const ROWS: usize = 512;

/// Transparent layer of constant thickness that follows the profile. It changes the reflectance and not the shape, because it is thin
/// against the structure's period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Film {
    /// Thickness \[µm\].
    pub thickness: f64,
    /// Refractive index.
    pub index: f64,
}

/// Thickest film \[µm\]. Thicker layers are not thin beside structures of a few micrometres, and their fringes need more [`ROWS`].
const THICKEST: f64 = 2.0;

impl Film {
    /// Parses a film of the command line, as in `120nm:1.7`.
    ///
    /// # Errors
    /// Fails for other text, a thickness above 2 µm, or an index outside of 1 to 10.
    pub fn parse(text: &str) -> Result<Self> {
        let form = "give thickness and refractive index as in 120nm:1.7";
        let (length, index) =
            text.split_once(':').ok_or_else(|| Error::usage(format!("invalid film `{text}`"), form))?;
        let thickness = units::length(length)?;
        let index =
            index.trim().parse::<f64>().ok().filter(|n| (1.0..=10.0).contains(n)).ok_or_else(|| {
                Error::usage(format!("`{index}` is no refractive index from 1 to 10"), form)
            })?;
        if thickness > THICKEST {
            return Err(Error::usage(
                format!("a film of {thickness} um is not thin"),
                format!("give at most {THICKEST}um"),
            ));
        }
        Ok(Self { thickness, index })
    }
}

impl fmt::Display for Film {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}um:{}", self.thickness, self.index)
    }
}

impl fmt::Display for Reflectance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schlick(ior) => write!(f, "refractive index {ior} by Schlick's approximation"),
            Self::Fresnel { material, film, polarisation, theory } => {
                match material.constant_index() {
                    Some(ior) => write!(f, "refractive index {ior}")?,
                    None => write!(f, "{}", material.name)?,
                }
                film.map_or(Ok(()), |film| write!(f, " below a film of {film}"))?;
                match polarisation {
                    Polarisation::None => {}
                    Polarisation::Te => write!(f, ", TE")?,
                    Polarisation::Tm => write!(f, ", TM")?,
                }
                if *theory == Theory::Stam { write!(f, ", Stam's factor") } else { Ok(()) }
            }
        }
    }
}

impl Default for Reflectance {
    fn default() -> Self {
        Self::dielectric(1.5)
    }
}

impl From<f64> for Reflectance {
    fn from(ior: f64) -> Self {
        Self::dielectric(ior)
    }
}

impl Reflectance {
    /// Returns Fresnel's equations for a transparent material of refractive index `ior` at all wavelengths.
    pub fn dielectric(ior: f64) -> Self {
        Self::of_material(Material::constant(ior), None)
    }

    /// Returns Fresnel's equations for `material` below `film` in unpolarised light.
    pub fn of_material(material: Material, film: Option<Film>) -> Self {
        Self::Fresnel { material, film, polarisation: Polarisation::None, theory: Theory::default() }
    }

    /// Returns the reflectance of the same surface in light of this polarisation. Schlick's approximation has one for all.
    pub fn polarised(self, polarisation: Polarisation) -> Self {
        match self {
            Self::Fresnel { material, film, theory, .. } => {
                Self::Fresnel { material, film, polarisation, theory }
            }
            Self::Schlick(_) => self,
        }
    }

    /// Returns the reflectance of the same surface with the factor of `theory`. Schlick's approximation always has Stam's.
    pub fn by(self, theory: Theory) -> Self {
        match self {
            Self::Fresnel { material, film, polarisation, .. } => {
                Self::Fresnel { material, film, polarisation, theory }
            }
            Self::Schlick(_) => self,
        }
    }

    /// Returns the theory of the factor: Stam's for Schlick's approximation and for films, whose two interfaces the small-slope approximation in
    /// [`super::small_slope`] does not have.
    pub fn theory(&self) -> Theory {
        match self {
            Self::Fresnel { film: None, theory, .. } => *theory,
            _ => Theory::Stam,
        }
    }

    /// Returns the theory that was asked for, which a film does not have.
    pub fn stated_theory(&self) -> Theory {
        match self {
            Self::Fresnel { theory, .. } => *theory,
            Self::Schlick(_) => Theory::Stam,
        }
    }

    /// Returns true if the BRDF is limited so that the surface reflects no more than it gets: unless the user names Stam's theory or Schlick's
    /// approximation.
    pub fn is_limited(&self) -> bool {
        matches!(self, Self::Fresnel { theory: Theory::SmallSlope, .. })
    }

    /// Returns the polarisation of the light.
    pub fn polarisation(&self) -> Polarisation {
        match self {
            Self::Schlick(_) => Polarisation::None,
            Self::Fresnel { polarisation, .. } => *polarisation,
        }
    }

    /// Returns the refractive index if the factor depends on it alone: no film, no dispersion, and by Stam's theory no polarisation.
    pub fn index(&self) -> Option<f64> {
        match self {
            Self::Schlick(ior) => Some(*ior),
            Self::Fresnel { material, film: None, theory: Theory::SmallSlope, .. } => {
                material.constant_index()
            }
            Self::Fresnel { material, film: None, polarisation: Polarisation::None, .. } => {
                material.constant_index()
            }
            Self::Fresnel { .. } => None,
        }
    }

    /// Returns the file that the material was read from; `None` for a built-in one.
    pub fn file(&self) -> Option<PathBuf> {
        match self {
            Self::Fresnel { material, .. } if material.constant_index().is_none() => {
                (!Material::is_built_in(&material.name)).then(|| PathBuf::from(&material.name))
            }
            _ => None,
        }
    }

    /// Returns the note of the material; see [`Material::note`].
    pub fn note(&self) -> Option<String> {
        match self {
            Self::Schlick(_) => None,
            Self::Fresnel { material, .. } => material.note(),
        }
    }

    /// Returns R at `wavelength` \[µm\] and the cosine `cos_half_angle` between either direction and the half vector.
    pub fn at(&self, wavelength: f64, cos_half_angle: f64) -> f64 {
        match self {
            Self::Schlick(ior) => schlick(*ior, cos_half_angle),
            Self::Fresnel { material, film, polarisation, .. } => {
                let index = material.index(wavelength);
                polarisation.share(fresnel(index, *film, wavelength, cos_half_angle.clamp(0.0, 1.0)))
            }
        }
    }

    /// Returns true if the factor depends on the wavelength, or on a polarisation by Stam's theory, and stands inside the sums over wavelengths.
    pub fn is_spectral(&self) -> bool {
        self.index().is_none()
    }

    /// Returns the law of a dielectric; Fresnel's for every material.
    pub fn law(&self) -> DielectricLaw {
        match self {
            Self::Schlick(_) => DielectricLaw::Schlick,
            Self::Fresnel { .. } => DielectricLaw::Fresnel,
        }
    }

    /// Returns true if shaders that are compiled for one serve the other.
    pub fn shares_stages_with(&self, other: &Self) -> bool {
        let indices = self.index().is_some() && other.index().is_some();
        let alike = self.law() == other.law()
            && self.theory() == other.theory()
            && self.polarisation() == other.polarisation();
        indices && alike || self == other
    }

    /// Returns the share of light that does not reach the pigment below the surface. For tabulated R it is Schlick's form from the luminous
    /// mean of R at normal incidence. Materials that absorb light within a few micrometres hide the pigment.
    pub fn kept_from_pigment(&self, cos_half_angle: f64) -> f64 {
        match self.index() {
            Some(_) => self.clone().polarised(Polarisation::None).at(MIDDLE, cos_half_angle),
            None => schlick_from(self.normal_of_pigment(), cos_half_angle),
        }
    }

    /// Returns [`Self::kept_from_pigment`] at normal incidence.
    pub fn normal_of_pigment(&self) -> f64 {
        match self {
            Self::Schlick(ior) => schlick(*ior, 1.0),
            Self::Fresnel { .. } if self.is_opaque() => 1.0,
            Self::Fresnel { .. } => self.luminous_normal(),
        }
    }

    /// Returns true if the material hides the pigment, because it absorbs light within a few micrometres.
    pub fn is_opaque(&self) -> bool {
        /// A material that is darker than 1/e at this depth hides the pigment \[µm\].
        const OPAQUE_WITHIN: f64 = 10.0;
        self.index_at(MIDDLE).im * 4.0 * PI / MIDDLE * OPAQUE_WITHIN > 1.0
    }

    /// Returns the mean of R at normal incidence over the visible range, weighted by the eye's sensitivity.
    pub fn luminous_normal(&self) -> f64 {
        self.luminous(1.0)
    }

    /// Returns the refractive index of a dielectric that reflects [`Self::luminous_normal`] at normal incidence.
    pub fn luminous_index(&self) -> f64 {
        let root = self.luminous_normal().sqrt();
        self.index().unwrap_or((1.0 + root) / (1.0 - root))
    }

    /// Returns the same mean at the cosine of a half angle.
    fn luminous(&self, cos_half_angle: f64) -> f64 {
        /// Wavelengths of the mean, 10 nm apart.
        const COUNT: usize = 41;
        let wavelengths = (0..COUNT).map(|i| SHORTEST + (LONGEST - SHORTEST) * i as f64 / (COUNT - 1) as f64);
        let (sum, total) = wavelengths.fold((0.0, 0.0), |(sum, total), wavelength| {
            let weight = observer(1e3 * wavelength).y;
            (sum + weight * self.at(wavelength, cos_half_angle), total + weight)
        });
        sum / total
    }

    /// Fails unless the material's index is known at `wavelength` \[µm\].
    ///
    /// # Errors
    /// That of [`Material::check_wavelength`].
    pub fn check_wavelength(&self, wavelength: f64) -> Result<()> {
        match self {
            Self::Schlick(_) => Ok(()),
            Self::Fresnel { material, .. } => material.check_wavelength(wavelength),
        }
    }

    /// Returns n + ik of the material at `wavelength` \[µm\].
    pub fn index_at(&self, wavelength: f64) -> Complex64 {
        match self {
            Self::Schlick(ior) => Complex64::from(*ior),
            Self::Fresnel { material, .. } => material.index(wavelength),
        }
    }

    /// Returns n and k at [`ROWS`] equal steps of the wavenumber over the visible range, ends included.
    pub fn indices(&self) -> Vec<[f32; 4]> {
        let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
        let at = |row: usize| {
            let index = self.index_at(1.0 / (first + (last - first) * row as f64 / (ROWS - 1) as f64));
            [index.re as f32, index.im as f32, 0.0, 0.0]
        };
        (0..ROWS).map(at).collect()
    }

    /// Returns R at [`ROWS`] equal steps of the wavenumber over the visible range and [`COLUMNS`] equal steps of the cosine over 0 … 1, ends
    /// included, row by row. Shaders interpolate between them.
    pub fn table(&self) -> Vec<f32> {
        let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
        let step = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        (0..ROWS)
            .flat_map(|row| {
                let wavelength = 1.0 / (first + (last - first) * step(row, ROWS));
                (0..COLUMNS).map(move |column| self.at(wavelength, step(column, COLUMNS)) as f32)
            })
            .collect()
    }
}

/// Returns R of both polarisations, TE and TM, for light from air onto a material of index `index`, below `film`.
fn fresnel(index: Complex64, film: Option<Film>, wavelength: f64, cosine: f64) -> [f64; 2] {
    let sine2 = 1.0 - cosine * cosine;
    // n cos θ on the far side by Snell's law; the root with Im ≥ 0 decays.
    let depth = |n: Complex64| {
        let root = (n * n - sine2).sqrt();
        if root.im < 0.0 { -root } else { root }
    };
    let air = (Complex64::ONE, Complex64::from(cosine));
    let below = (index, depth(index));
    let amplitudes = match film {
        None => step(air, below),
        Some(film) => {
            let inside = (film.index.into(), depth(film.index.into()));
            let turn = Complex64::I * (4.0 * PI * film.thickness / wavelength) * inside.1;
            let echo = turn.exp();
            let (top, bottom) = (step(air, inside), step(inside, below));
            std::array::from_fn(|i| (top[i] + bottom[i] * echo) / (1.0 + top[i] * bottom[i] * echo))
        }
    };
    amplitudes.map(|amplitude| amplitude.norm_sqr())
}

/// Returns the amplitudes that an interface between two indices reflects, TE and TM. Each side is given by its index n and its n cos θ.
fn step((n, q): (Complex64, Complex64), (m, p): (Complex64, Complex64)) -> [Complex64; 2] {
    let (a, b) = (m * m * q, n * n * p);
    // Grazing light between equal indices has 0/0.
    let ratio =
        |up: Complex64, down: Complex64| if down == Complex64::ZERO { -Complex64::ONE } else { up / down };
    [ratio(q - p, q + p), ratio(a - b, a + b)]
}

/// Luminous mean of R over the wavelengths, by the half angle. A colour table holds R divided by it, which changes little with the angle, so that a
/// footprint may read the table at other angles; the shader multiplies by the mean at the pixel's angle.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct MeanReflectance(Vec<f32>);

impl MeanReflectance {
    /// Number of equal steps of the cosine of the half angle over 0 … 1.
    pub const STEPS: usize = 512;
    /// Reflectance below which wavelengths are not told apart: a fortieth of glass at normal incidence.
    const DARK: f64 = 1e-3;

    /// Returns the mean of `reflectance`.
    pub fn new(reflectance: &Reflectance) -> Self {
        /// Smallest mean, so that none is 0, which no sound table has.
        const LEAST: f64 = 1e-9;
        let at = |i: usize| reflectance.luminous(i as f64 / Self::STEPS as f64).max(LEAST) as f32;
        Self((0..=Self::STEPS).map(at).collect())
    }

    /// Returns `reflectance`, that of a wavelength at the cosine of a half angle, divided by the mean. Where both are below ε = 0.001 the ratio tends to
    /// 1: at Brewster's angle, which depends on the wavelength, TM light has no reflection, and r/m would have a pole. The product with m is off by
    /// ε² (m − r)/(m² + ε²).
    pub fn ratio(&self, reflectance: f64, cos_half_angle: f64) -> f64 {
        let mean = self.at(cos_half_angle);
        (reflectance * mean + Self::DARK.powi(2)) / (mean * mean + Self::DARK.powi(2))
    }

    /// Interpolates the mean at the cosine of a half angle.
    pub fn at(&self, cos_half_angle: f64) -> f64 {
        let place = cos_half_angle.clamp(0.0, 1.0) * Self::STEPS as f64;
        let left = (place as usize).min(Self::STEPS - 1);
        let [a, b] = [left, left + 1].map(|i| f64::from(self.0[i]));
        a + (place - left as f64) * (b - a)
    }

    /// Returns true if the values can have been made by [`Self::new`].
    pub fn is_sound(&self) -> bool {
        self.0.len() == Self::STEPS + 1 && self.0.iter().all(|r| *r > 0.0 && *r <= 1.001)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> Reflectance {
        Reflectance::of_material(Material::from_name_or_file(name).unwrap(), None)
    }

    fn constant(n: f64, film: Option<Film>) -> Reflectance {
        Reflectance::of_material(Material::constant(n), film)
    }

    #[test]
    fn dielectrics_follow_the_real_equations() {
        for n in [1.33f64, 1.5, 2.4] {
            for degrees in [0.0f64, 10.0, 33.0, 56.0, 75.0, 89.0, 90.0] {
                let (i, t) = (degrees.to_radians(), (degrees.to_radians().sin() / n).asin());
                let s = (i.cos() - n * t.cos()) / (i.cos() + n * t.cos());
                let p = (n * i.cos() - t.cos()) / (n * i.cos() + t.cos());
                let expected = 0.5 * (s * s + p * p);
                let found = constant(n, None).at(0.55, i.cos());
                assert!((found - expected).abs() < 1e-12, "{n} at {degrees}: {found} {expected}");
            }
        }
    }

    #[test]
    fn at_brewster_s_angle_only_te_is_reflected() {
        let n = 1.5f64;
        let s = (1.0 - n * n) / (1.0 + n * n);
        let plain = constant(n, None);
        let at = |reflectance: &Reflectance| reflectance.at(0.55, n.atan().cos());
        assert!((at(&plain) - 0.5 * s * s).abs() < 1e-12);
        assert!((at(&plain.clone().polarised(Polarisation::Te)) - s * s).abs() < 1e-12);
        assert!(at(&plain.polarised(Polarisation::Tm)) < 1e-24);
    }

    #[test]
    fn unpolarised_light_has_the_mean_of_both_polarisations() {
        for plain in
            [constant(1.5, None), of("gold"), constant(2.0, Some(Film { thickness: 0.2, index: 1.4 }))]
        {
            let plain = plain.by(Theory::Stam);
            let [te, tm] = [Polarisation::Te, Polarisation::Tm].map(|p| plain.clone().polarised(p));
            assert!(te.is_spectral() && te.index().is_none());
            for cosine in [0.0, 0.2, 0.7, 1.0] {
                let [plain, te, tm] = [&plain, &te, &tm].map(|r| r.at(0.5, cosine));
                assert!((plain - 0.5 * (te + tm)).abs() < 1e-12 && te >= tm - 1e-12, "{te} {tm}");
            }
            assert!((te.at(0.5, 1.0) - tm.at(0.5, 1.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_mean_times_the_ratio_is_the_reflectance() {
        let film = Some(Film { thickness: 0.3, index: 1.4 });
        let surfaces = [of("glass"), of("gold"), constant(1.5, None), constant(2.0, film)];
        for (plain, has_film) in surfaces.into_iter().zip([false, false, false, true]) {
            for polarisation in Polarisation::ALL {
                let reflectance = plain.clone().polarised(polarisation);
                let mean = MeanReflectance::new(&reflectance);
                for cosine in (0..=2000).map(|i| f64::from(i) / 2000.0) {
                    let exact = reflectance.at(0.48, cosine);
                    let ratio = mean.ratio(exact, cosine);
                    let off = (ratio * mean.at(cosine) - exact).abs();
                    // By the bound of `ratio`, and the rounding of means to 32 bits.
                    let bound = 1e-6 * (mean.at(cosine) - exact).abs() / (mean.at(cosine).powi(2) + 1e-6);
                    assert!(off <= bound + 1e-9, "{reflectance} at {cosine}: {off}");
                    // Without a film wavelengths differ little, at Brewster's angle too.
                    let is_near_1 = ratio > 0.0 && ratio < 2.0;
                    assert!(is_near_1 || has_film, "{reflectance} at {cosine}: {ratio}");
                }
            }
        }
    }

    #[test]
    fn metals_have_their_published_reflectance_and_grazing_light_is_all_reflected() {
        for name in ["aluminium", "silver", "gold", "copper", "nickel", "silicon", "glass", "keratin"] {
            let material = Material::from_name_or_file(name).unwrap();
            for wavelength in [0.38, 0.45, 0.55, 0.65, 0.78] {
                let (n, k) = (material.index(wavelength).re, material.index(wavelength).im);
                let normal = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
                assert!((of(name).at(wavelength, 1.0) - normal).abs() < 1e-12, "{name}");
                assert!((of(name).at(wavelength, 0.0) - 1.0).abs() < 1e-12, "{name}");
            }
        }
        // Handbook values at normal incidence (Hass, AIP Handbook, 1972): 550 nm and 650 nm.
        for (name, wavelength, published, apart) in [
            ("aluminium", 0.55, 0.915, 0.01),
            ("silver", 0.55, 0.979, 0.015),
            ("gold", 0.65, 0.955, 0.025),
            ("gold", 0.45, 0.387, 0.03),
            ("copper", 0.65, 0.945, 0.03),
        ] {
            let found = of(name).at(wavelength, 1.0);
            assert!((found - published).abs() < apart, "{name} at {wavelength}: {found}");
        }
    }

    #[test]
    fn films_follow_their_closed_forms() {
        // A quarter wave of √n on n reflects nothing; a half wave changes nothing (Born & Wolf 1.6.4).
        let (n, wavelength) = (2.25f64, 0.6);
        let film = |thickness: f64, index: f64| Some(Film { thickness, index });
        let quarter = constant(n, film(wavelength / 4.0 / 1.5, 1.5));
        assert!(quarter.at(wavelength, 1.0).abs() < 1e-24);
        let half = constant(n, film(wavelength / 2.0 / 1.7, 1.7));
        assert!((half.at(wavelength, 1.0) - constant(n, None).at(wavelength, 1.0)).abs() < 1e-12);
        // R = 1 − |stack of transparent layers' transmission|² n/1, by the characteristic matrix at normal incidence.
        let (index, thickness) = (1.7, 0.123);
        let delta = 2.0 * PI * index * thickness / wavelength;
        let (s, c) = delta.sin_cos();
        let (b, e) = (Complex64::new(c, -s * n / index), Complex64::new(n * c, -s * index));
        let expected = ((b - e) / (b + e)).norm_sqr();
        let found = constant(n, film(thickness, index)).at(wavelength, 1.0);
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        // A film of the material itself changes nothing.
        let same = constant(n, film(0.3, n));
        assert!((same.at(0.5, 0.3) - constant(n, None).at(0.5, 0.3)).abs() < 1e-12);
    }

    #[test]
    fn energy_is_kept_for_every_film_on_every_metal() {
        for name in ["silver", "gold", "silicon"] {
            let material = Material::from_name_or_file(name).unwrap();
            for i in 0..2000 {
                let share = |k: u32| (f64::from(i) * 0.618_034f64.powi(k as i32)).fract();
                let film = Film { thickness: 2.0 * share(1), index: 1.0 + 3.0 * share(2) };
                let reflectance = Reflectance::of_material(material.clone(), Some(film));
                let r = reflectance.at(0.38 + 0.4 * share(3), share(4));
                assert!((0.0..=1.0 + 1e-12).contains(&r), "{name}, {film}: {r}");
            }
        }
    }

    #[test]
    fn schlick_errs_by_what_the_docs_say() {
        // Largest difference over angles from 0 to 85° at 550 nm, R₀ being exact: docs/EQUATIONS.md.
        for (name, least, most) in [
            ("glass", 0.03, 0.04),
            ("keratin", 0.03, 0.04),
            ("aluminium", 0.09, 0.1),
            ("silver", 0.005, 0.01),
            ("gold", 0.008, 0.012),
            ("copper", 0.03, 0.05),
            ("nickel", 0.12, 0.15),
            ("silicon", 0.19, 0.22),
        ] {
            let exact = of(name);
            let normal = exact.at(0.55, 1.0);
            let worst = (0..=850)
                .map(|tenth| f64::from(tenth / 10).to_radians().cos())
                .map(|c| (schlick_from(normal, c) - exact.at(0.55, c)).abs())
                .fold(0.0, f64::max);
            eprintln!("{name}: R0 {normal:.3}, Schlick differs by up to {worst:.3}");
            assert!((least..most).contains(&worst), "{name}: {worst}");
        }
    }

    #[test]
    fn between_the_entries_of_its_table_a_reflectance_errs_by_little() {
        let film = |thickness, index| Some(Film { thickness, index });
        let thick = film(THICKEST, 2.0);
        for (name, film, bound) in [
            ("glass", thick, 1e-3),
            ("silver", thick, 5e-3),
            ("gold", thick, 5e-3),
            ("silver", film(0.3, 1.5), 2e-3),
            ("silicon", None, 1e-4),
        ] {
            let reflectance = Reflectance::of_material(Material::from_name_or_file(name).unwrap(), film);
            let table = reflectance.table();
            let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
            let (mut squares, mut count) = (0.0f64, 0.0);
            for row in 0..ROWS - 1 {
                for column in 0..COLUMNS - 1 {
                    let corner = |i: usize, j: usize| f64::from(table[(row + j) * COLUMNS + column + i]);
                    let middle = (corner(0, 0) + corner(1, 0) + corner(0, 1) + corner(1, 1)) / 4.0;
                    let wavenumber = first + (last - first) * (row as f64 + 0.5) / (ROWS - 1) as f64;
                    let exact =
                        reflectance.at(1.0 / wavenumber, (column as f64 + 0.5) / (COLUMNS - 1) as f64);
                    squares += (middle - exact).powi(2);
                    count += 1.0;
                }
            }
            let rms = (squares / count).sqrt();
            eprintln!("{name}, {film:?}: {rms:.1e}");
            assert!(rms < bound, "{name}, {film:?}: {rms}");
        }
    }

    #[test]
    fn films_are_read_from_their_words() {
        assert_eq!(Film::parse("120nm:1.7").unwrap(), Film { thickness: 0.12, index: 1.7 });
        let film = Film { thickness: 0.25, index: 1.33 };
        assert_eq!(Film::parse(&film.to_string()).unwrap(), film);
        for wrong in ["", "120nm", "120:1.7", "120nm:0.5", "120nm:x", "3um:1.5", "-1um:1.5"] {
            assert!(Film::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn pigment_is_seen_through_glass_and_not_through_metal() {
        assert!((of("glass").normal_of_pigment() - 0.0423).abs() < 1e-3);
        assert!((of("gold").normal_of_pigment() - 1.0).abs() < 1e-15);
        assert!((Reflectance::Schlick(1.5).kept_from_pigment(0.5) - 0.07).abs() < 1e-15);
        assert!((Reflectance::dielectric(1.5).kept_from_pigment(0.5) - 0.089_18).abs() < 1e-5);
    }

    #[test]
    fn only_an_index_without_a_film_stands_outside_of_sums_over_wavelengths() {
        let film = Some(Film { thickness: 0.1, index: 1.4 });
        assert_eq!(Reflectance::Schlick(1.4).index(), Some(1.4));
        assert_eq!(Reflectance::dielectric(1.6).index(), Some(1.6));
        assert!(constant(1.6, film).is_spectral() && of("glass").is_spectral());
        assert!(Reflectance::dielectric(1.6).shares_stages_with(&Reflectance::dielectric(1.5)));
        assert!(!Reflectance::dielectric(1.5).shares_stages_with(&Reflectance::Schlick(1.5)));
        assert!(!of("glass").shares_stages_with(&Reflectance::dielectric(1.5)));
        assert!(of("glass").shares_stages_with(&of("glass")) && !of("glass").shares_stages_with(&of("gold")));
    }
}
