//! `diffract lights`: surroundings as directional lights for other programs.

use super::console::Console;
use super::write;
use crate::error::Result;
use crate::scene::environment::{Environment, Placement};
use crate::units;
use clap::Args;
use serde::Serialize;
use std::f64::consts::PI;
use std::ffi::OsString;
use std::path::PathBuf;

/// Arguments of `lights`.
#[derive(Args, Debug)]
#[command(
    after_help = "Each light stands for a part of the surroundings; all parts have about the same light, so that bright ones \
are small, and dark parts have none. The JSON has for each its direction, a unit vector toward the light (z up), the irradiance of a plane \
that faces it, linear sRGB with the radiance of the picture as unit, and in degrees the standard deviation over which to average it along each \
axis: twice that of its part, so that neighbours overlap. The irradiances of all add up to that of the whole sphere.

Examples:
  diffract lights sky.hdr -n 64 -o lights.json
  diffract lights studio -n 16"
)]
pub struct Arguments {
    /// Surroundings: sky, studio, or an equirectangular picture twice as wide as high (.exr, .hdr)
    environment: OsString,
    /// Largest number of lights
    #[arg(short = 'n', long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u32).range(1..=4096), allow_hyphen_values = true)]
    count: u32,
    /// Rotation of the surroundings about the vertical, from +x toward +y, as in 90deg
    #[arg(long, value_name = "ANGLE", value_parser = units::angle, allow_hyphen_values = true, default_value = "0deg")]
    rotate_environment: f64,
    /// File of the result instead of standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Lights of some surroundings in the JSON.
#[derive(Serialize)]
struct LightList {
    /// Name or file of the surroundings.
    environment: String,
    lights: Vec<LightReport>,
}

/// Light in the JSON.
#[derive(Serialize)]
struct LightReport {
    /// Unit vector toward the light, z up.
    direction: [f64; 3],
    /// Irradiance of a plane that faces the light, linear sRGB.
    irradiance: [f64; 3],
    /// Standard deviation over which to average along each axis across the direction \[degrees\].
    deviation: f64,
}

impl LightReport {
    /// Returns light `number` of `count`.
    fn new(environment: &Environment, number: u32, count: u32) -> Self {
        let part = environment.incident(number, count);
        // The program's own lights are averaged, and have irradiances over π.
        let irradiance = part.irradiance.as_dvec3() * (PI / f64::from(count));
        Self {
            direction: part.direction.to_array(),
            irradiance: irradiance.to_array(),
            deviation: part.variance.sqrt().to_degrees(),
        }
    }
}

/// Writes the lights.
///
/// # Errors
/// Surroundings that cannot be read; a file that cannot be written.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let environment = Environment::open(&arguments.environment)
        .map_err(|e| e.at(arguments.environment.to_string_lossy()))?
        .placed(Placement::new(arguments.rotate_environment, 0.0)?);
    if let Some(note) = environment.note() {
        console.say(&note);
    }
    let all = (0..arguments.count).map(|i| LightReport::new(&environment, i, arguments.count));
    let lights = all.filter(|light| light.irradiance != [0.0; 3]).collect();
    let list = LightList { environment: environment.name.clone(), lights };
    match &arguments.output {
        Some(path) => write::json(path, &list),
        None => console.write(&write::json_text(&list)?),
    }
}
