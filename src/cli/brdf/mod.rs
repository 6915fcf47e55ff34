//! `diffract brdf`: the hemisphere of one light direction, as a picture or as numbers.

mod figure;
mod map;
mod numbers;
mod variant;

use super::answer::{AskedOptics, AskedSurface, TableAnswer};
use super::console::Console;
use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, FigureOptions, OpticsOptions, SurfaceOptions, exposure,
};
use super::{captions, evaluation, write};
use crate::brdf::hemisphere::HemisphereMap;
use crate::error::{Error, Result};
use crate::figure::{FigureFormat, FigureStyle};
use crate::files::Files;
use crate::optics::color;
use crate::optics::spectrum::Illuminant;
use crate::optics::validity::LightColour;
use crate::picture_file;
use crate::render::renderer::Picture;
use crate::scene::FarLight;
use crate::surface::HeightField;
use crate::units;
use clap::Args;
use glam::DVec3;
use numbers::MapFormat;
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use variant::Variant;

/// Longest side of a map \[pixels\]: that of the images of today's devices; it takes thirteen gigabytes.
const MAX_SIDE: u32 = 16_384;

/// Arguments of `brdf`.
#[derive(Args, Debug)]
#[command(
    after_help = "The map looks down on the surface: the disc is the hemisphere of view directions, x to the right, y up, the normal in \
the middle, the horizon at the rim. A mirror's spot stands opposite the light. Values are the BRDF [1/sr], without a \
cosine, averaged over each pixel, as linear sRGB; several lights are summed, each times its intensity. --plot draws a figure with angles, a colour \
bar and the settings: in colour and luminance, or at one wavelength in false colour.

A .csv has a row for each direction, from the top of the map: x and y, the direction cosines of the \
viewer; theta_r and phi_r [degrees]; r, g and b, or brdf at one wavelength. A .npy has 32-bit floats: an array of \
N x N x 3, or of N x N at one wavelength, NaN outside the hemisphere. Element [j, i] is at \
x = 2(i + 0.5)/N - 1, y = 1 - 2(j + 0.5)/N.

Examples:
  diffract brdf blaze --light 30,0 -o blaze.png
  diffract brdf blaze --light 30,0 --wavelength 550nm --plot orders.svg
  diffract brdf blaze --light 30,0 --wavelength 550nm --size 96x96 --compare spectral,reference --plot check.png
  diffract brdf elaphe --light 60,90 --wavelength 550nm --exposure 4 -o green.png
  diffract brdf elaphe --light 30,0 --size 256x256 -o elaphe.exr        EXR: linear and signed, before exposure
  diffract brdf elaphe --light 30,0 --wavelength 550nm --size 256x256 -o green.npy"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Output file: .png as displayed; .exr, .csv and .npy linear and signed
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["plot", "json"])]
    output: Option<PathBuf>,
    /// Write the answer as JSON too: input, settings, and a row for each direction
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    json: Option<PathBuf>,
    /// Draw a labelled figure of the map: .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Draw the figure of two variants and their difference: methods, bases or coherences, joined by + if both change
    #[arg(
        long, value_name = "A,B", value_parser = Variant::pair, allow_hyphen_values = true, requires = "plot",
        conflicts_with = "output", hide_short_help = true)]
    compare: Option<[Variant; 2]>,
    /// Direction of the light, in degrees from the normal and from +x toward +y; may be given several times
    #[arg(
        long, value_name = "THETA,PHI[,INTENSITY]", value_parser = FarLight::parse, allow_hyphen_values = true,
        required = true
    )]
    light: Vec<FarLight>,
    /// Width and height in pixels, equal
    #[arg(long, value_name = "NxN", value_parser = side, allow_hyphen_values = true, default_value = "512x512")]
    size: u32,
    /// Single wavelength, as in 550nm, in grey instead of the colour
    #[arg(long, value_name = "LENGTH", value_parser = evaluation::wavelength, allow_hyphen_values = true)]
    wavelength: Option<f64>,
    /// Exposure of a PNG in stops
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true, default_value = "0")]
    exposure: f64,
    #[command(flatten)]
    figure: FigureOptions,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// Parses a square size.
fn side(text: &str) -> Result<u32> {
    match units::size(text)? {
        [x, y] if x == y && x <= MAX_SIDE => Ok(x),
        _ => Err(Error::usage(
            format!("'{text}' is no size of a map"),
            format!("give NxN, as in 512x512, of at most {MAX_SIDE}x{MAX_SIDE}"),
        )),
    }
}

/// Evaluates the map and writes the results.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    let format = arguments.output.as_deref().map(MapFormat::of).transpose()?;
    arguments.plot.as_deref().map(FigureFormat::of).transpose()?;
    let style = arguments.figure.style(arguments.plot.is_some(), figure::panel_names(arguments))?;
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes([&arguments.output, &arguments.json, &arguments.plot].into_iter().flatten())
        .check()?;
    let ways = match &arguments.compare {
        Some(variants) => variants.iter().map(|v| v.of(&arguments.optics)).collect::<Result<Vec<_>>>()?,
        None => vec![arguments.optics.clone()],
    };
    if arguments.wavelength.is_some() {
        ways.iter().try_for_each(|optics| evaluation::check_single_wavelengths(optics.method()))?;
        evaluation::check_no_spectrum(&arguments.colour)?;
    }
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe", console)?;
    if let (Some(variants), Some(plot)) = (&arguments.compare, &arguments.plot) {
        return compare(arguments, &field, variants, plot, &style, console);
    }
    let map = map::of(arguments, &arguments.optics, &field, console)?;
    if let Some(plot) = &arguments.plot {
        figure::of_map(arguments, &field, &map).save(plot, &style, &captions::notes(&field, console))?;
    }
    let is_spectral = arguments.wavelength.is_some();
    if let Some(path) = &arguments.json {
        write_json(path, arguments, &field, &map, console)?;
    }
    let (Some(path), Some(format)) = (&arguments.output, format) else { return Ok(()) };
    let format = match format {
        MapFormat::Picture(format) => format,
        MapFormat::Csv => return numbers::write_csv(path, &map, is_spectral),
        MapFormat::Npy => return numbers::write_npy(path, &map, is_spectral),
    };
    let display = map.pixels.iter().map(|pixel| displayed(*pixel, arguments.exposure)).collect();
    let picture = Picture { size: [arguments.size; 2], radiance: map.pixels, display, is_opaque: false };
    let illuminant = Illuminant::from_name_or_file(&arguments.colour.illuminant)?;
    let colour = arguments.wavelength.map_or(LightColour::Spectrum(&illuminant), LightColour::Wavelength);
    let notes = captions::picture_notes(console, &field, &arguments.optics.reflectance(None), colour);
    picture_file::write(path, format, &picture, &notes)
}

/// Settings of a map in the JSON.
#[derive(Serialize)]
struct MapSettings {
    /// Polar angle, azimuth and intensity of each light.
    lights: Vec<[f64; 3]>,
    wavelength_nm: Option<f64>,
    #[serde(flatten)]
    optics: AskedOptics,
}

/// Writes `map` as JSON.
fn write_json(
    path: &Path,
    arguments: &Arguments,
    field: &HeightField,
    map: &HemisphereMap,
    console: &Console,
) -> Result<()> {
    let optics = arguments.optics.for_directions(&arguments.colour, field, console)?;
    let settings = MapSettings {
        lights: arguments.light.iter().map(|light| [light.theta, light.phi, light.intensity]).collect(),
        wavelength_nm: arguments.wavelength.map(|micrometres| 1e3 * micrometres),
        optics: AskedOptics::new(&optics),
    };
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let table = numbers::table(map, arguments.wavelength.is_some())?;
    let notes = captions::notes(field, console);
    write::json(path, &TableAnswer::new(AskedSurface::new(name, field), settings, &table, &notes))
}

/// Compares two maps, in a figure and in a line of text.
fn compare(
    arguments: &Arguments,
    field: &HeightField,
    variants: &[Variant; 2],
    plot: &Path,
    style: &FigureStyle,
    console: &Console,
) -> Result<()> {
    let [a, b] = variants.each_ref().map(|variant| variant.of(&arguments.optics));
    let optics = [a?, b?];
    let maps =
        [map::of(arguments, &optics[0], field, console)?, map::of(arguments, &optics[1], field, console)?];
    figure::of_two(arguments, field, variants, &optics, &maps).save(
        plot,
        style,
        &captions::notes(field, console),
    )?;
    let deviation = figure::deviation(&maps[0].values(), &maps[1].values());
    console.say(&format_args!("{} differs from {} by {deviation:.2e}", variants[0].name, variants[1].name));
    Ok(())
}

/// Returns a pixel as a display shows it; black outside the disc.
fn displayed([r, g, b, _]: [f32; 4], exposure: f64) -> [u8; 4] {
    let [r, g, b] = color::display(DVec3::new(r.into(), g.into(), b.into()), exposure);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_square() {
        assert_eq!(side("256x256").unwrap(), 256);
        assert!(side("256x255").is_err() && side("16385x16385").is_err() && side("0x0").is_err());
    }
}
