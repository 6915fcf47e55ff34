//! `diffract brdf`: the hemisphere of one light direction, as a picture.

use super::answers::{self, Answers};
use super::options::{
    ColourOptions, DeviceOptions, Method, OpticsOptions, SurfaceOptions, check_lights, exposure,
};
use super::{say, write};
use crate::error::{Error, Result};
use crate::optics::color;
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::SHORTEST;
use crate::output;
use crate::render::evaluator::Query;
use crate::render::picture::Picture;
use crate::scene::Light;
use crate::units;
use clap::Args;
use glam::DVec3;
use std::path::PathBuf;

/// Longest side of a map \[pixels\]: one of it takes a gigabyte of memory to make.
const MAX_SIDE: u32 = 4096;
/// Directions by the direct sum from which on a word of warning is due.
const MANY_SUMS: usize = 5_000;

/// Arguments of `brdf`.
#[derive(Args, Debug)]
#[command(
    after_help = "The map looks down on the surface: the disc is the hemisphere of view directions, x to the right, y up, the normal in
the middle, the horizon at the rim. A mirror's spot stands opposite the light. Values are the BRDF [1/sr], without a
cosine, as linear sRGB; several lights are summed, each times its intensity.

Examples:
  diffract brdf blaze --light 30,0 -o blaze.png
  diffract brdf elaphe --light 60,90 --wavelength 550nm --exposure 4 -o green.png
  diffract brdf elaphe --light 30,0 --size 256x256 -o elaphe.exr        EXR: linear and signed, before exposure"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<String>,
    /// Where the map goes: .png as displayed, .exr linear and signed
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Where the light stands, in degrees from the normal and from +x toward +y; up to four
    #[arg(
        long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true,
        required = true
    )]
    light: Vec<Light>,
    /// Width and height in pixels, equal
    #[arg(long, value_name = "NxN", value_parser = side, allow_hyphen_values = true, default_value = "512x512")]
    size: u32,
    /// One wavelength, as in 550nm, in grey instead of the colour
    #[arg(long, value_name = "LENGTH", value_parser = wavelength, allow_hyphen_values = true)]
    wavelength: Option<f64>,
    /// Exposure of a PNG in stops
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true, default_value = "0")]
    exposure: f64,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
}

/// A square size.
fn side(text: &str) -> Result<u32> {
    match units::size(text)? {
        [x, y] if x == y && x <= MAX_SIDE => Ok(x),
        _ => Err(Error::usage(
            format!("'{text}' is no size of a map"),
            format!("give NxN, as in 512x512, of at most {MAX_SIDE}x{MAX_SIDE}"),
        )),
    }
}

fn wavelength(text: &str) -> Result<f64> {
    let (low, high) = answers::WAVELENGTHS;
    units::length(text).and_then(|length| {
        let refused = || Error::usage(format!("'{text}' is out of range"), "give 10nm to 100um");
        (low..=high).contains(&length).then_some(length).ok_or_else(refused)
    })
}

/// Evaluates and writes.
pub fn run(arguments: &Arguments) -> Result<()> {
    let format = write::PictureFormat::of(&arguments.output)?;
    output::check(&arguments.output)?;
    check_lights(&arguments.light)?;
    if arguments.wavelength.is_some() {
        answers::check_single_wavelengths(arguments.optics.method)?;
    }
    let radiance = map(arguments)?;
    let display = radiance.iter().map(|pixel| displayed(*pixel, arguments.exposure)).collect();
    let picture = Picture { size: [arguments.size; 2], radiance, display };
    write::picture(&arguments.output, format, &picture)
}

/// The map, row by row from the top: linear sRGB \[sr⁻¹\], alpha 1 in the disc, 0 outside.
fn map(arguments: &Arguments) -> Result<Vec<[f32; 4]>> {
    let shading = arguments.optics.shading(&arguments.colour)?;
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe")?;
    let pixels = views(arguments.size);
    let directions = pixels.len() * arguments.light.len();
    if arguments.optics.method == Method::Reference && directions > MANY_SUMS {
        say(&format_args!("{directions} direct sums take their time; a smaller --size is faster"));
    }
    let shortest = arguments.wavelength.unwrap_or(SHORTEST);
    let method = arguments.optics.method;
    let mut answers = Answers::prepare(method, &arguments.device.wish(), &field, &shading, shortest)?;
    answers.announce(directions);
    let mut map = vec![[0.0; 4]; (arguments.size as usize).pow(2)];
    for part in pixels.chunks(answers::AT_ONCE) {
        let mut sums = vec![DVec3::ZERO; part.len()];
        for light in &arguments.light {
            let toward = direction(light.theta, light.phi);
            let query =
                |&(_, view)| Query { pair: Pair::new(toward, view), wavelength: arguments.wavelength };
            let values = answers.brdf(&part.iter().map(query).collect::<Vec<_>>())?;
            sums.iter_mut().zip(values).for_each(|(sum, f)| *sum += f * light.intensity);
        }
        for (&(place, _), sum) in part.iter().zip(sums) {
            let rgb = arguments.wavelength.map_or_else(|| color::xyz_to_linear_srgb(sum), |_| sum);
            map[place] = rgb.as_vec3().extend(1.0).to_array();
        }
    }
    answers.finish()?;
    Ok(map)
}

/// The pixels of the disc in a map of `side` pixels, and ω_r of each: pixel centre (i+½, j+½) is
/// (s_x, s_y, √(1 − s²)), s_x = 2(i+½)/N − 1, s_y = 1 − 2(j+½)/N.
fn views(side: u32) -> Vec<(usize, DVec3)> {
    let centre = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
    let pixel = |(i, j): (u32, u32)| {
        let (x, y) = (centre(i), -centre(j));
        let z = 1.0 - x * x - y * y;
        (z > 0.0).then(|| (j as usize * side as usize + i as usize, DVec3::new(x, y, z.sqrt())))
    };
    (0..side).flat_map(|j| (0..side).map(move |i| (i, j))).filter_map(pixel).collect()
}

/// As a display shows it; black outside the disc.
fn displayed([r, g, b, _]: [f32; 4], exposure: f64) -> [u8; 4] {
    let [r, g, b] = color::display(DVec3::new(r.into(), g.into(), b.into()), exposure);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_centres_are_unit_vectors_with_y_up_and_the_corners_are_outside() {
        let views = views(4);
        assert_eq!(views.len(), 12, "4 of 16 pixels are corners");
        let at = |i: usize, j: usize| views.iter().find(|(place, _)| *place == j * 4 + i).map(|(_, v)| *v);
        assert_eq!(at(0, 0), None);
        let (right, top) = (at(3, 1).unwrap(), at(2, 0).unwrap());
        assert_eq!((right.x, right.y, top.x, top.y), (0.75, 0.25, 0.25, 0.75));
        assert!(views.iter().all(|(_, v)| (v.length() - 1.0).abs() < 1e-15 && v.z > 0.0));
        assert_eq!(super::views(1), [(0, DVec3::Z)]);
    }

    #[test]
    fn sizes_are_square_and_wavelengths_lengths() {
        assert_eq!(side("256x256").unwrap(), 256);
        assert!(side("256x255").is_err() && side("4097x4097").is_err() && side("0x0").is_err());
        assert!((wavelength("550nm").unwrap() - 0.55).abs() < 1e-12);
        assert!(wavelength("550").is_err() && wavelength("1nm").is_err() && wavelength("1mm").is_err());
    }
}
