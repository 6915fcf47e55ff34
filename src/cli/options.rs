//! Options that several commands share, with the same word and meaning in each.

mod display;
mod figure;
mod mesh;
mod preparation;
mod reflectance;
mod surface_options;
mod view;

pub use display::Exposure;
pub use figure::FigureOptions;
pub use mesh::MeshOptions;
#[cfg(any(feature = "viewer", test))] // for scene files that the viewer saves
pub use preparation::as_options;
pub use reflectance::{ReflectanceOptions, ior};
pub use surface_options::SurfaceOptions;
pub use view::{ViewOptions, light_by};

use super::console::Console;
use crate::error::{Error, Result};
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::Illuminant;
use crate::scene::Scene;
use crate::settings::{Method, Optics};
use crate::spectra::amplitude::expansion::Basis;
use crate::surface::HeightField;
use crate::tolerance::TOLERANCES;
use crate::units;
use crate::vk::selection::DeviceChoice;
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use std::ffi::{OsStr, OsString};

/// Largest number of terms.
const MAX_TERMS: usize = 128;
/// Smallest and largest number of wavelengths.
const WAVELENGTHS: (usize, usize) = (4, 4096);
/// Spectrum of the light unless another one is named.
pub const DEFAULT_ILLUMINANT: &str = "d65";
/// Range of refractive indices: those of real materials, with a margin.
const IORS: (f64, f64) = (1.0, 10.0);
/// Range of coherence lengths of a window \[µm\]: from less than a wavelength to a laser's.
const COHERENCE_LENGTHS: (f64, f64) = (0.01, 1e5);
/// Largest number of pixels of a sample: every pixel of the largest picture.
const MAX_SAMPLED: usize = 1 << 28;
/// Largest number of copies of the patch along an axis, and of windows.
const MAX_REPEATS: u32 = 10_000;
const MAX_WINDOWS: u32 = 64;

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Spectral, Self::Table, Self::Reference]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self {
            Self::Spectral => {
                "Sums wavelengths: over the orders on the CPU for the mean, over precomputed spectra on the device for one window"
            }
            Self::Table => "Vulkan: reads a colour table that the spectrum was summed into once",
            Self::Reference => "The mean, or the direct sum of windows, in 64-bit floats, on the CPU",
        };
        Some(PossibleValue::new(self.name()).help(help))
    }
}

/// The optics.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Optics")]
pub struct OpticsOptions {
    /// Method of the optics [default: table for pictures of the mean, else spectral]
    #[arg(long, value_enum, hide_short_help = true)]
    pub method: Option<Method>,
    /// Expansion of one window's spectra (--windows 1x1): taylor (the thesis') or optimal (fewest terms) [default: optimal for pictures;
    /// else taylor if 32-bit floats hold it]
    #[arg(long, value_name = "BASIS", value_parser = basis, hide_short_help = true)]
    pub basis: Option<Basis>,
    /// Relative error that you accept, as in 1e-2 or 1%: of pictures and by a table that of all colours together (relative L2), of other numbers that of each
    /// direction (RMS). All other accuracy settings follow from it unless named [default: 1e-2]
    #[arg(long, value_name = "E", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Terms of the expansion (--windows 1x1), instead of the number that the tolerance needs
    #[arg(long, value_name = "N", value_parser = terms, allow_hyphen_values = true, hide_short_help = true)]
    pub terms: Option<usize>,
    /// Coherence of the light: gaussian:LENGTH, or grating:NxM for a finite grating of that many copies of the patch (also repeats:NxM)
    #[arg(long, value_name = "KIND", value_parser = coherence, default_value = "gaussian:65um", hide_short_help = true)]
    pub coherence: Coherence,
    /// Positions of the coherence window to average over: all (as a pixel does), 1x1 (the thesis' single window, which shows speckle) or
    /// NxM of them [default: all; 1x1 for a finite grating]
    #[arg(long, value_name = "all|NxM", value_parser = windows, allow_hyphen_values = true, hide_short_help = true)]
    pub windows: Option<Windows>,
    /// Continuation of the surface beyond the patch (--windows all): copies (a periodic surface, whose orders show) or alike (a surface
    /// with the same statistics) [default: copies if the edges of the field meet, else alike]
    #[arg(long, value_name = "copies|alike", value_parser = beyond, hide_short_help = true)]
    pub beyond: Option<Beyond>,
    #[command(flatten)]
    pub surface_reflectance: ReflectanceOptions,
}

impl OpticsOptions {
    /// Returns the method for single directions.
    pub fn method(&self) -> Method {
        self.method.unwrap_or(Method::Spectral)
    }

    /// Returns the method for pictures: a colour table for the mean over all windows, unless the user names another.
    pub fn picture_method(&self) -> Method {
        self.method.unwrap_or(Method::of_pictures(self.windows()))
    }

    /// Returns the positions of the window.
    pub fn windows(&self) -> Windows {
        let unless_named = match self.coherence {
            Coherence::Gaussian { .. } => Windows::All,
            Coherence::Repeats(_) => Windows::ONE,
        };
        self.windows.unwrap_or(unless_named)
    }

    /// Fails for options that have no effect beside the others.
    ///
    /// # Errors
    /// Such an option, with the remedy.
    fn check(&self) -> Result<()> {
        self.surface_reflectance.check()?;
        let all = self.windows() == Windows::All;
        if self.basis.is_some() && all {
            return Err(Error::usage(
                "--basis is about the expansion for one window, and the mean over all windows has none",
                "add --windows 1x1, or leave --basis away",
            ));
        }
        if self.beyond.is_some() && !all {
            return Err(Error::usage(
                "--beyond is about the mean over all windows",
                "use --windows all, or leave --beyond away",
            ));
        }
        Ok(())
    }

    /// Returns the reflectance of the surface: that of the scene, unless the options name a material, in light of their polarisation.
    pub fn reflectance(&self, scene: Option<&Reflectance>) -> Reflectance {
        self.surface_reflectance.of_surface(scene)
    }

    /// Returns the file of the material; `None` for a built-in one.
    pub fn files(&self) -> Option<&OsStr> {
        self.surface_reflectance.files()
    }

    /// Returns `optics` with the material of `scene`, unless the options name another.
    pub fn material_of(&self, scene: &Scene, optics: Optics) -> Optics {
        Optics { reflectance: self.reflectance(scene.main_object().reflectance.as_ref()), ..optics }
    }

    /// Returns the relative error that the user accepts.
    pub fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(Optics::default().tolerance)
    }

    /// Returns the settings for single wavelengths of single directions of `field`.
    ///
    /// # Errors
    /// Options that do not go together, with the remedy.
    pub fn for_wavelengths(&self, field: &HeightField, console: &Console) -> Result<Optics> {
        self.check()?;
        self.surface_reflectance.tell(console);
        let mut optics = self.beyond_of(field, self.with_basis(Basis::Taylor));
        optics.basis = self.basis.unwrap_or_else(|| optics.suited_basis(field));
        optics.checked()
    }

    /// Returns the settings for colours of single directions of `field`.
    ///
    /// # Errors
    /// Options that do not go together, with the remedy; a spectrum that cannot be read.
    pub fn for_directions(
        &self,
        colour: &ColourOptions,
        field: &HeightField,
        console: &Console,
    ) -> Result<Optics> {
        colour.of(self.for_wavelengths(field, console)?, console)?.checked()
    }

    /// Returns the settings for pictures.
    ///
    /// # Errors
    /// Options that do not go together, with the remedy; a spectrum that cannot be read.
    pub fn for_pictures(&self, colour: &ColourOptions, console: &Console) -> Result<Optics> {
        self.check()?;
        self.surface_reflectance.tell(console);
        let optics = self.with_basis(self.basis_of_pictures()).for_pictures();
        colour.of(Optics { method: self.picture_method(), ..optics }, console)?.checked()
    }

    /// Returns `optics` with the continuation beyond the patch that the user names, or that suits `field`.
    pub fn beyond_of(&self, field: &HeightField, optics: Optics) -> Optics {
        Optics { beyond: self.beyond.unwrap_or_else(|| Beyond::suited_to(field)), ..optics }
    }

    /// Returns the expansion for pictures: in every sweep of `trade`, the one with the fewest reads for the same error.
    pub fn basis_of_pictures(&self) -> Basis {
        self.basis.unwrap_or(Basis::Optimal)
    }

    fn with_basis(&self, unless_named: Basis) -> Optics {
        Optics {
            method: self.method(),
            coherence: self.coherence,
            windows: self.windows(),
            beyond: self.beyond.unwrap_or_default(),
            reflectance: self.reflectance(None),
            tolerance: self.tolerance(),
            basis: self.basis.unwrap_or(unless_named),
            terms: self.terms,
            ..Optics::default()
        }
    }
}

/// Options of the conversion from wavelengths to a colour.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Optics")]
pub struct ColourOptions {
    /// Wavelengths of a colour, instead of the number that the tolerance needs
    #[arg(long, value_name = "N", value_parser = wavelengths, allow_hyphen_values = true, hide_short_help = true)]
    pub wavelengths: Option<usize>,
    /// Spectrum of the light: d65, d50, a, e, led, or a CSV file of wavelength in nm and power
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_ILLUMINANT)]
    pub illuminant: OsString,
}

impl ColourOptions {
    /// Returns the file of the spectrum; `None` for a built-in one.
    pub fn files(&self) -> Option<&OsStr> {
        Some(self.illuminant.as_os_str()).filter(|name| !Illuminant::is_built_in(name))
    }

    /// Returns `optics` with the colour settings of the options.
    fn of(&self, optics: Optics, console: &Console) -> Result<Optics> {
        let illuminant = Illuminant::from_name_or_file(&self.illuminant)?;
        tell_of_missing_light(&illuminant, console);
        Ok(Optics { illuminant, wavelengths: self.wavelengths, ..optics })
    }
}

/// Warns, once a run, if a spectrum does not cover the visible range.
fn tell_of_missing_light(illuminant: &Illuminant, console: &Console) {
    if let Some([first, last]) = illuminant.missing_light() {
        console.say_once(
            "missing light",
            &format_args!(
                "the illuminant is given from {first} to {last} nm; between 380 and 780 nm it counts as 0 elsewhere"
            ),
        );
    }
}

/// The Vulkan device.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Device")]
pub struct DeviceOptions {
    /// Vulkan device: a part of its name, its UUID, its number in `diffract devices`, or cpu for a software one
    #[arg(long, value_name = "NAME|UUID|INDEX|cpu", value_parser = DeviceChoice::parse, hide_short_help = true)]
    pub device: Option<DeviceChoice>,
}

impl DeviceOptions {
    /// Returns the run on the device that the user asks for, or that of its context.
    pub fn chosen(&self, console: &Console) -> Console {
        let choice = self.device.clone();
        console.clone().in_context(|context| match choice {
            Some(choice) => context.choosing(choice),
            None => context,
        })
    }
}

/// Options of the cache.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cache")]
pub struct CacheOptions {
    /// Largest size of the cache on disk, as in 500MiB; 0 turns it off (see `diffract cache`) [default: 2GiB]
    #[arg(long, value_name = "SIZE", value_parser = units::bytes, allow_hyphen_values = true, hide_short_help = true)]
    pub cache_size: Option<u64>,
}

impl CacheOptions {
    /// Returns the run with a cache of this limit, or with that of its context.
    pub fn limited(self, console: &Console) -> Console {
        console.clone().in_context(|context| match self.cache_size {
            Some(limit) => context.with_cache_limit(limit),
            None => context,
        })
    }
}

/// Parses a finite number within `range`, ends included; errors call it `what`.
pub fn real(text: &str, range: (f64, f64), what: &str) -> Result<f64> {
    let value = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    value.filter(|x| (range.0..=range.1).contains(x)).ok_or_else(|| {
        Error::usage(
            format!("`{text}` is no {what}"),
            format!("give a number from {} to {}", range.0, range.1),
        )
    })
}

/// Parses a length within `range` \[µm\], ends included; errors call it `what`.
pub fn length_within(text: &str, range: (f64, f64), what: &str) -> Result<f64> {
    let length = units::length(text)?;
    if (range.0..=range.1).contains(&length) {
        return Ok(length);
    }
    Err(Error::usage(format!("`{text}` is no {what}"), format!("give {}um to {}um", range.0, range.1)))
}

fn whole(text: &str, range: (usize, usize), what: &str) -> Result<usize> {
    text.trim().parse::<usize>().ok().filter(|n| (range.0..=range.1).contains(n)).ok_or_else(|| {
        Error::usage(
            format!("`{text}` is no number of {what}"),
            format!("give a whole number from {} to {}", range.0, range.1),
        )
    })
}

/// Parses a seed: any whole number of 64 bits.
pub fn seed(text: &str) -> Result<u64> {
    text.trim().parse().map_err(|_| {
        Error::usage(format!("`{text}` is no seed"), format!("give a whole number from 0 to {}", u64::MAX))
    })
}

fn basis(text: &str) -> Result<Basis> {
    let named = Basis::ALL.into_iter().find(|basis| basis.name() == text);
    named.ok_or_else(|| Error::usage(format!("there is no basis `{text}`"), "give taylor or optimal"))
}

/// Parses a share within `range`, ends included, as in `1e-2` or `1%`; errors call it `what`.
pub fn share(text: &str, (least, most): (f64, f64), what: &str) -> Result<f64> {
    const PERCENT: f64 = 100.0;
    match text.trim().strip_suffix('%') {
        Some(number) => real(number, (PERCENT * least, PERCENT * most), &format!("{what} in percent"))
            .map(|percent| percent / PERCENT),
        None => real(text, (least, most), what),
    }
}

/// Parses a relative error, as in `1e-2` or `1%`.
pub fn tolerance(text: &str) -> Result<f64> {
    share(text, TOLERANCES, "tolerance")
}

fn terms(text: &str) -> Result<usize> {
    whole(text, (1, MAX_TERMS), "terms")
}

fn wavelengths(text: &str) -> Result<usize> {
    whole(text, WAVELENGTHS, "wavelengths")
}

/// Parses the number of pixels that are compared with the reference.
pub fn sample_pixels(text: &str) -> Result<usize> {
    whole(text, (1, MAX_SAMPLED), "pixels")
}

/// Parses an exposure in stops.
pub fn exposure(text: &str) -> Result<f64> {
    real(text, (-40.0, 40.0), "exposure in stops")
}

fn windows(text: &str) -> Result<Windows> {
    if text == "all" {
        return Ok(Windows::All);
    }
    units::counts(text).and_then(|n| bounded(text, n, MAX_WINDOWS, "windows")).map(Windows::Grid)
}

fn beyond(text: &str) -> Result<Beyond> {
    [Beyond::Copies, Beyond::Alike]
        .into_iter()
        .find(|beyond| beyond.name() == text)
        .ok_or_else(|| Error::usage(format!("unknown --beyond `{text}`"), "give copies or alike"))
}

fn bounded(text: &str, counts: [u32; 2], most: u32, what: &str) -> Result<[u32; 2]> {
    if counts.iter().all(|&n| n <= most) {
        return Ok(counts);
    }
    Err(Error::usage(format!("`{text}` are too many {what}"), format!("give at most {most}x{most}")))
}

/// Parses a coherence.
pub fn coherence(text: &str) -> Result<Coherence> {
    const FORM: &str = "give gaussian:LENGTH as in gaussian:65um, or grating:NxM as in grating:3x3";
    match text.split_once(':') {
        Some(("gaussian", length)) => {
            let length = units::length(length)?;
            if (COHERENCE_LENGTHS.0..=COHERENCE_LENGTHS.1).contains(&length) {
                return Ok(Coherence::Gaussian { length });
            }
            Err(Error::usage(format!("the coherence length `{text}` is out of range"), "give 10nm to 100mm"))
        }
        Some(("grating" | "repeats", n)) => {
            let n = units::counts(n).and_then(|n| bounded(text, n, MAX_REPEATS, "repeats"))?;
            Ok(Coherence::Repeats(n))
        }
        _ => Err(Error::usage(format!("invalid --coherence `{text}`"), FORM)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_without_meaning_are_refused_and_others_kept() {
        for bad in ["", "nan", "inf", "0", "-1", "2", "x", "1e-9", "%", "0%", "101%", "1 %%"] {
            assert!(tolerance(bad).is_err(), "tolerance {bad}");
        }
        assert_eq!(["1e-3", "1%", " 0.5 %"].map(|text| tolerance(text).unwrap()), [1e-3, 1e-2, 5e-3]);
        for bad in ["0", "-1", "1.5", "999", "x", ""] {
            assert!(terms(bad).is_err(), "terms {bad}");
        }
        for bad in
            ["gaussian", "gaussian:65", "gaussian:0um", "repeats:0x1", "repeats:3", "laser:3", "gaussian:1m"]
        {
            assert!(coherence(bad).is_err(), "coherence {bad}");
        }
        assert_eq!(coherence("gaussian:65um").unwrap(), Coherence::SUNLIGHT);
        assert_eq!(coherence("repeats:3x2").unwrap(), Coherence::Repeats([3, 2]));
        assert!(
            ior("0.5").is_err()
                && exposure("99").is_err()
                && windows("0x1").is_err()
                && windows("65x1").is_err()
        );
    }
}
