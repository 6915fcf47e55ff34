//! `diffract render`: a scene into a file.

use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, FilterOptions, Method, OpticsOptions, SurfaceOptions,
    ViewOptions, check_lights, sample_pixels,
};
use super::spectral::Spectral;
use super::{prepare, words};
use crate::error::{Error, Result};
use crate::files::Files;
use crate::measure::error;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::picture_file::{self, Format};
use crate::precompute::Layers;
use crate::render::frame::View;
use crate::render::picture::{Directions, Painter, Picture};
use crate::render::pigment::Pigment;
use crate::render::reference_picture::{self, displayed, reference_pixels};
use crate::render::resources::Optics;
use crate::render::shading::Shading;
use crate::scene::Scene;
use crate::surface::HeightField;
use crate::units;
use crate::vk::device::Device;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract render -o snake.png
  diffract render disc --surface blaze --light 20,90 --size 800x800 -o disc.png
  diffract render --tolerance 1e-3 -o exact.exr        EXR: linear radiance, before exposure")]
pub struct Arguments {
    /// snake, plate, sphere, disc, a scene file (.toml) or a mesh (.obj)
    #[arg(default_value = "snake")]
    scene: String,
    /// Where the picture goes: .png as displayed, .exr linear and signed
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "1280x720")]
    size: [u32; 2],
    #[command(flatten)]
    view: ViewOptions,
    /// Shade only so many random pixels of those that the mesh covers (--method reference only)
    #[arg(long, value_name = "N", value_parser = sample_pixels, allow_hyphen_values = true)]
    sample_pixels: Option<usize>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    filter: FilterOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// Draws and writes.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.cache.apply();
    let format = Format::of(&arguments.output)?;
    let files = Files::new()
        .reads([&arguments.scene])
        .reads(arguments.surface.files(None))
        .reads(arguments.colour.files())
        .writes([&arguments.output]);
    files.check()?;
    check_lights(&arguments.view.light)?;
    if arguments.sample_pixels.is_some() && arguments.optics.method() != Method::Reference {
        return Err(Error::usage(
            "--sample-pixels is for the reference picture only",
            "add --method reference, or leave it away",
        ));
    }
    let shading = arguments.optics.for_pictures(&arguments.colour)?;
    let mut scene = Scene::open(&arguments.scene)?;
    files.reads(&scene.files).check()?;
    arguments.view.apply(&mut scene)?;
    let field = arguments.surface.load(None, Some(&scene), "elaphe")?;
    let picture = draw(arguments, &scene, &field, &shading)?;
    picture_file::write(&arguments.output, format, &picture, &words::notes())
}

fn draw(arguments: &Arguments, scene: &Scene, field: &HeightField, shading: &Shading) -> Result<Picture> {
    let reference = arguments.optics.method() == Method::Reference;
    if reference && scene.pigment.is_some() {
        return Err(Error::usage(
            "--method reference knows no pigment texture",
            "leave `pigment` out of the scene",
        ));
    }
    let device = prepare::device(&arguments.device.wish())?;
    let pigment = scene.pigment.as_deref().map(Pigment::read).transpose()?;
    let view = View { pigment: pigment.is_some(), ..View::of(scene, scene.lights.clone()) };
    let pigment = pigment.unwrap_or_else(Pigment::white);
    let paint = |optics: Optics| {
        let (size, lights) = (arguments.size, view.lights.len());
        Painter::new(&device, optics, shading, &scene.mesh, &pigment, size, lights)
    };
    let mut painter = match arguments.optics.method() {
        Method::Spectral => {
            let spectral = Spectral::prepare(field, shading, &device)?;
            let mut painter = paint(spectral.optics())?;
            if spectral.repeats() {
                spectral.check(&directions_of(&mut painter, &view)?)?;
            }
            Ok(painter)
        }
        Method::Table => {
            let table = prepare::color_table(field, shading, &device)?;
            paint(Optics::Table(&table, arguments.filter.filter))
        }
        Method::Reference => paint((&directions_only(&device)?).into()),
    }?;
    let picture = if reference {
        let radiance = reference_radiance(&mut painter, &view, field, shading, arguments.sample_pixels)?;
        let display = displayed(&radiance, scene.exposure, scene.background);
        Picture { size: arguments.size, radiance, display }
    } else {
        painter.paint(&view, scene.exposure, scene.background)?
    };
    drop(painter);
    prepare::finish(&device)?;
    Ok(picture)
}

/// The reference needs the frame's directions only: these layers are the smallest there are, and always the same.
fn directions_only(device: &Device) -> Result<Layers> {
    let flat = HeightField::new(1, 1, [SHORTEST / 4.0; 2], vec![0.0])?;
    let coherence = Coherence::Gaussian { length: 1.0 };
    let shading = Shading { coherence, tolerance: 1e-1, ..Shading::default() };
    prepare::layers(&flat, &shading, SHORTEST, device)
}

/// The directions that each light of `view` comes from.
fn directions_of(painter: &mut Painter, view: &View) -> Result<Vec<Directions>> {
    (0..view.lights.len()).map(|light| painter.directions(view, light)).collect()
}

fn reference_radiance(
    painter: &mut Painter,
    view: &View,
    field: &HeightField,
    shading: &Shading,
    samples: Option<usize>,
) -> Result<Vec<[f32; 4]>> {
    prepare::warn_of_coarse_samples(field, SHORTEST);
    let directions = directions_of(painter, view)?;
    let mut pixels = reference_picture::covered(&directions);
    if let Some(count) = samples {
        pixels = error::sample(&pixels, count);
    }
    let bar = prepare::progress_bar("pixels");
    let colors = reference_pixels(field, shading, view, &directions, &pixels, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    });
    bar.finish_and_clear();
    let mut radiance = vec![[0.0; 4]; directions.first().map_or(0, |seen| seen.view.len())];
    for (pixel, color) in pixels.into_iter().zip(colors?) {
        radiance[pixel] = color.as_vec3().extend(1.0).to_array();
    }
    Ok(radiance)
}
