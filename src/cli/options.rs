//! Options that several commands share, with the same word and meaning in each.

use super::say;
use crate::error::{Error, Result};
use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::render::color_table::Filter;
use crate::render::shading::Shading;
use crate::scene::{Camera, Light, MAX_LIGHTS, Scene};
use crate::surface::files::Topography;
use crate::surface::{HeightField, Level, Source};
use crate::units;
use crate::vk::selection::Wish;
use clap::{Args, ValueEnum};
use glam::Vec3;
use std::ffi::{OsStr, OsString};

/// Smallest and largest tolerance that mean something: below the first, 32-bit floats are in the way everywhere.
const TOLERANCES: (f64, f64) = (1e-6, 1.0);
/// Most terms that can be named.
const MAX_TERMS: usize = 128;
/// Fewest and most wavelengths that can be named.
const WAVELENGTHS: (usize, usize) = (4, 4096);
/// Refractive indices of real materials, with room.
const IORS: (f64, f64) = (1.0, 10.0);
/// Coherence lengths that make a window: from less than a wavelength to a laser's.
const COHERENCE_LENGTHS: (f64, f64) = (0.01, 1e5);
/// Most pixels of a sample: every pixel of the largest picture.
const MAX_SAMPLED: usize = 1 << 28;
/// Most copies of the patch along an axis, and most windows.
const MAX_REPEATS: u32 = 10_000;
const MAX_WINDOWS: u32 = 64;

/// How the optics is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Vulkan: sums wavelengths over precomputed spectra
    #[default]
    Spectral,
    /// Vulkan: reads a colour table that the spectrum was summed into once
    Table,
    /// The direct sum in 64-bit floats, on the CPU
    Reference,
}

/// The height field.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceOptions {
    /// Height field: a microscope's file (.gsf .gwy .spm .ibw .sur .x3p .sdf .npy .txt .csv .xyz), a TIFF or PNG, or flat, sinusoid,
    /// blaze, bumps, elaphe, xenopeltis
    #[arg(long, value_name = "FILE|BUILTIN")]
    pub surface: Option<OsString>,
    /// Distance between samples, as in 97.66nm or 80nmx90nm, instead of the file's
    #[arg(long, value_name = "LENGTH", value_parser = units::length_pair, allow_hyphen_values = true)]
    pub pixel_size: Option<[f64; 2]>,
    /// Height that an image's largest code stands for, as in 434.7nm; full height of a built-in, or of a file instead of its own
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true)]
    pub height: Option<f64>,
    /// Channel of a file that has several, by name or number [default: the first height]
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// What to subtract from the heights: none, mean or plane
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "none")]
    pub level: Level,
    /// Which one of the many skins of one kind
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true, default_value = "1")]
    pub seed: u64,
}

fn level(text: &str) -> Result<Level> {
    Level::from_name(text)
        .ok_or_else(|| Error::usage(format!("there is no level `{text}`"), "give none, mean or plane"))
}

impl SurfaceOptions {
    /// The height field that the options name, or `scene`'s, or `fallback`.
    pub fn load(
        &self,
        positional: Option<&OsStr>,
        scene: Option<&Scene>,
        fallback: &str,
    ) -> Result<HeightField> {
        let source = self.source(positional, scene, fallback)?;
        source.prepare(self.read(&source)?.into_field()?)
    }

    /// The heights of `source` as they are; tells what a user should know about them.
    pub fn read(&self, source: &Source) -> Result<Topography> {
        let scan = source.read()?;
        for warning in scan.origin().into_iter().flat_map(|origin| &origin.warnings) {
            say(&format_args!("{}: {warning}", source.name.display()));
        }
        Ok(scan)
    }

    /// What [`SurfaceOptions::load`] loads.
    pub fn source(
        &self,
        positional: Option<&OsStr>,
        scene: Option<&Scene>,
        fallback: &str,
    ) -> Result<Source> {
        if positional.is_some() && self.surface.is_some() {
            return Err(Error::usage(
                "the surface is given twice",
                "give it as an argument or by --surface, not both",
            ));
        }
        let own = positional.or(self.surface.as_deref());
        let name = own.or(scene.map(|s| s.surface.as_os_str())).unwrap_or(OsStr::new(fallback));
        // A scene's units belong to the scene's surface.
        let of_scene = scene.filter(|_| own.is_none());
        let pixel_size = self.pixel_size.or(of_scene.and_then(|s| s.pixel_size));
        let height = self.height.or(of_scene.and_then(|s| s.full_height));
        let channel = self.channel.clone();
        Ok(Source { name: name.to_owned(), pixel_size, height, channel, level: self.level, seed: self.seed })
    }
}

/// The optics.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Optics")]
pub struct OpticsOptions {
    /// How the optics is computed [default: spectral]
    #[arg(long, value_enum)]
    pub method: Option<Method>,
    /// Which expansion the precomputed spectra hold: taylor (the thesis'), chebyshev or optimal (fewest terms) [default: optimal for
    /// pictures; else taylor where 32-bit floats hold it]
    #[arg(long, value_name = "BASIS", value_parser = basis)]
    pub basis: Option<Basis>,
    /// Relative error that you accept; everything else follows from it unless named [default: 1e-2]
    #[arg(long, value_name = "E", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Terms of the expansion, instead of what the tolerance asks for
    #[arg(long, value_name = "N", value_parser = terms, allow_hyphen_values = true)]
    pub terms: Option<usize>,
    /// What surrounds the patch: gaussian:LENGTH, or repeats:NxM copies of it and nothing else
    #[arg(long, value_name = "KIND", value_parser = coherence, default_value = "gaussian:65um")]
    pub coherence: Coherence,
    /// Window centres to average over (not in pictures by --method spectral)
    #[arg(long, value_name = "NxM", value_parser = windows, allow_hyphen_values = true, default_value = "1x1")]
    pub windows: [u32; 2],
    /// Refractive index of the surface
    #[arg(long, value_name = "N", value_parser = ior, allow_hyphen_values = true, default_value = "1.5")]
    pub ior: f64,
}

impl OpticsOptions {
    /// How the optics is computed.
    pub fn method(&self) -> Method {
        self.method.unwrap_or_default()
    }

    /// Relative error that the user accepts.
    pub fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(Shading::default().tolerance)
    }

    /// The settings that the options stand for, where single wavelengths of single directions of `field` are asked for.
    pub fn monochrome(&self, field: &HeightField) -> Shading {
        let shading = self.with_basis(Basis::Taylor);
        match self.basis {
            Some(_) => shading,
            None => Shading { basis: shading.suited_basis(field), ..shading },
        }
    }

    /// The settings that the options stand for, where colours of single directions of `field` are asked for.
    pub fn shading(&self, colour: &ColourOptions, field: &HeightField) -> Result<Shading> {
        colour.of(self.monochrome(field))
    }

    /// The settings that the options stand for, where pictures are asked for.
    pub fn for_pictures(&self, colour: &ColourOptions) -> Result<Shading> {
        Ok(colour.of(self.with_basis(self.basis_of_pictures()))?.for_pictures())
    }

    /// The expansion of pictures: of every sweep that `trade` made, the one with the fewest reads for the same error.
    pub fn basis_of_pictures(&self) -> Basis {
        self.basis.unwrap_or(Basis::Optimal)
    }

    fn with_basis(&self, unless_named: Basis) -> Shading {
        Shading {
            coherence: self.coherence,
            windows: self.windows,
            ior: self.ior,
            tolerance: self.tolerance(),
            basis: self.basis.unwrap_or(unless_named),
            terms: self.terms,
            ..Shading::default()
        }
    }
}

/// How a picture reads a colour table.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Optics")]
pub struct FilterOptions {
    /// What a pixel of --method table shows: its centre, as the other methods do and the tolerance is promised for, or the average
    /// over all that it sees
    #[arg(long, value_name = "point|pixel", value_parser = filter, default_value = "point")]
    pub filter: Filter,
}

/// From wavelengths to a colour.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Optics")]
pub struct ColourOptions {
    /// Wavelengths of a colour, instead of what the tolerance asks for
    #[arg(long, value_name = "N", value_parser = wavelengths, allow_hyphen_values = true)]
    pub wavelengths: Option<usize>,
    /// The light's spectrum: d65, a, e, or a CSV file of wavelength in nm and power
    #[arg(long, value_name = "NAME|FILE", default_value = "d65")]
    pub illuminant: String,
}

impl ColourOptions {
    /// `shading` with what the options say of colours.
    fn of(&self, shading: Shading) -> Result<Shading> {
        let illuminant = Illuminant::from_name_or_file(&self.illuminant)?;
        Ok(Shading { illuminant, wavelengths: self.wavelengths, ..shading })
    }
}

/// The Vulkan device.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Device")]
pub struct DeviceOptions {
    /// Vulkan device: a part of its name, its number in `diffract devices`, or cpu for a software one
    #[arg(long, value_name = "NAME|INDEX|cpu", value_parser = Wish::parse)]
    pub device: Option<Wish>,
}

impl DeviceOptions {
    /// What the user wishes for.
    pub fn wish(&self) -> Wish {
        self.device.clone().unwrap_or_default()
    }
}

/// How a scene is looked at, each instead of the scene's own.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "View")]
pub struct ViewOptions {
    /// Exposure in stops, instead of the scene's
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true)]
    pub exposure: Option<f64>,
    /// A light instead of the scene's, in degrees from up and around it; up to four
    #[arg(long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true)]
    pub light: Vec<Light>,
    /// Where the camera stands, instead of the scene's
    #[arg(long, value_name = "X,Y,Z", value_parser = units::triple, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// What the camera looks at, instead of the scene's
    #[arg(long, value_name = "X,Y,Z", value_parser = units::triple, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,
    /// Vertical field of view, as in 35deg, instead of the scene's
    #[arg(long, value_name = "ANGLE", value_parser = units::angle, allow_hyphen_values = true)]
    pub field_of_view: Option<f64>,
    /// Albedo of the pigment, linear sRGB from 0 to 1, instead of the scene's
    #[arg(long, value_name = "R,G,B", value_parser = units::color, allow_hyphen_values = true)]
    pub base_color: Option<[f64; 3]>,
}

impl ViewOptions {
    /// Changes what the options name in `scene`.
    ///
    /// # Errors
    /// Too many lights; a camera that cannot be.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        check_lights(&self.light)?;
        if !self.light.is_empty() {
            scene.lights = self.light.clone();
        }
        if let Some(exposure) = self.exposure {
            scene.exposure = exposure;
        }
        if let Some(color) = self.base_color {
            scene.base_color = color.map(|c| c as f32).into();
        }
        let vector = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
        if self.eye.is_some() || self.target.is_some() || self.field_of_view.is_some() {
            let old = scene.camera;
            scene.camera = Camera::looking(
                self.eye.map_or(old.eye(), vector),
                self.target.map_or(old.target, vector),
                self.field_of_view.map_or(old.field_of_view, |deg| deg.to_radians() as f32),
            )?;
        }
        Ok(())
    }
}

/// Fails where there are more lights than a picture takes.
pub fn check_lights(lights: &[Light]) -> Result<()> {
    if lights.len() <= MAX_LIGHTS {
        return Ok(());
    }
    Err(Error::usage("there are too many lights", format!("give at most {MAX_LIGHTS}")))
}

/// The lights that the user names, or else the scene's.
pub fn lights_of(named: &[Light], scene: &Scene) -> Vec<Light> {
    if named.is_empty() { scene.lights.clone() } else { named.to_vec() }
}

/// A finite number within `range`, ends included; `what` it is stands in the error.
pub fn real(text: &str, range: (f64, f64), what: &str) -> Result<f64> {
    let value = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    value.filter(|x| (range.0..=range.1).contains(x)).ok_or_else(|| {
        Error::usage(
            format!("`{text}` is no {what}"),
            format!("give a number from {} to {}", range.0, range.1),
        )
    })
}

/// A length within `range` \[µm\], ends included; `what` it is stands in the error.
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

/// A seed: any whole number of 64 bits.
pub fn seed(text: &str) -> Result<u64> {
    text.trim().parse().map_err(|_| {
        Error::usage(format!("`{text}` is no seed"), format!("give a whole number from 0 to {}", u64::MAX))
    })
}

fn filter(text: &str) -> Result<Filter> {
    match text {
        "pixel" => Ok(Filter::Pixel),
        "point" => Ok(Filter::Point),
        _ => Err(Error::usage(format!("there is no filter `{text}`"), "give point or pixel")),
    }
}

fn basis(text: &str) -> Result<Basis> {
    let named = Basis::ALL.into_iter().find(|basis| basis.name() == text);
    named.ok_or_else(|| {
        Error::usage(format!("there is no basis `{text}`"), "give taylor, chebyshev or optimal")
    })
}

/// A relative error.
pub fn tolerance(text: &str) -> Result<f64> {
    real(text, TOLERANCES, "tolerance")
}

fn terms(text: &str) -> Result<usize> {
    whole(text, (1, MAX_TERMS), "terms")
}

fn wavelengths(text: &str) -> Result<usize> {
    whole(text, WAVELENGTHS, "wavelengths")
}

/// A refractive index.
pub fn ior(text: &str) -> Result<f64> {
    real(text, IORS, "refractive index")
}

/// How many pixels are compared with the reference.
pub fn sample_pixels(text: &str) -> Result<usize> {
    whole(text, (1, MAX_SAMPLED), "pixels")
}

/// Exposure in stops.
pub fn exposure(text: &str) -> Result<f64> {
    real(text, (-40.0, 40.0), "exposure in stops")
}

fn windows(text: &str) -> Result<[u32; 2]> {
    units::counts(text).and_then(|n| bounded(text, n, MAX_WINDOWS, "windows"))
}

fn bounded(text: &str, counts: [u32; 2], most: u32, what: &str) -> Result<[u32; 2]> {
    if counts.iter().all(|&n| n <= most) {
        return Ok(counts);
    }
    Err(Error::usage(format!("`{text}` are too many {what}"), format!("give at most {most}x{most}")))
}

/// What surrounds the patch, as the command line has it.
pub fn coherence(text: &str) -> Result<Coherence> {
    const FORM: &str = "give gaussian:LENGTH as in gaussian:65um, or repeats:NxM as in repeats:3x3";
    match text.split_once(':') {
        Some(("gaussian", length)) => {
            let length = units::length(length)?;
            if (COHERENCE_LENGTHS.0..=COHERENCE_LENGTHS.1).contains(&length) {
                return Ok(Coherence::Gaussian { length });
            }
            Err(Error::usage(format!("the coherence length `{text}` is out of range"), "give 10nm to 100mm"))
        }
        Some(("repeats", n)) => {
            let n = units::counts(n).and_then(|n| bounded(text, n, MAX_REPEATS, "repeats"))?;
            Ok(Coherence::Repeats(n))
        }
        _ => Err(Error::usage(format!("`{text}` is no coherence"), FORM)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_without_meaning_are_refused_and_others_kept() {
        for bad in ["", "nan", "inf", "0", "-1", "2", "x", "1e-9"] {
            assert!(tolerance(bad).is_err(), "tolerance {bad}");
        }
        assert_eq!(tolerance("1e-3").unwrap(), 1e-3);
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
