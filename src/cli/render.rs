//! `diffract render`: a scene into a file.

use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, OpticsOptions, SurfaceOptions, ViewOptions, check_lights,
    sample_pixels,
};
use super::{captions, prepare, scale};
use crate::error::{Error, Result};
use crate::files::Files;
use crate::measure::error;
use crate::optics::coherence::Windows;
use crate::optics::spectrum::SHORTEST;
use crate::picture_file::{self, Format};
use crate::render::frame::{Shown, View};
use crate::render::picture::{Directions, Painter, Picture};
use crate::render::pigment::Pigment;
use crate::render::reference_picture::{self, displayed, reference_mean};
use crate::render::sampling::{Sample, Sampling};
use crate::render::shading::Shading;
use crate::render::source::{ClassicalGrating, Source};
use crate::scene::Scene;
use crate::setup::{self, Method, Settings};
use crate::surface::HeightField;
use crate::units;
use clap::Args;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::PathBuf;

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract render -o snake.png
  diffract render disc --surface blaze --light 20,90 --size 800x800 -o disc.png
  diffract render --tolerance 1e-3 -o exact.exr        EXR: linear radiance, before exposure
  diffract render --samples 64 -o fine.png             smoother edges and highlights than the default 16")]
pub struct Arguments {
    /// snake, plate, sphere, disc, a scene file (.toml) or a mesh (.obj)
    #[arg(default_value = "snake")]
    scene: OsString,
    /// Where the picture goes: .png as displayed, .exr linear and signed, premultiplied; alpha is the coverage of the pixel
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "1280x720")]
    size: [u32; 2],
    #[command(flatten)]
    view: ViewOptions,
    /// Samples a pixel, each with the camera moved inside the pixel: 1 to 4096; 1 looks at pixel centres only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), allow_hyphen_values = true, default_value = "16")]
    samples: u32,
    /// Shade only so many random pixels of those that the mesh covers (--method reference only)
    #[arg(long, value_name = "N", value_parser = sample_pixels, allow_hyphen_values = true)]
    sample_pixels: Option<usize>,
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

/// Draws and writes.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.cache.apply();
    let format = Format::of(&arguments.output)?;
    let files = Files::new()
        .reads([&arguments.scene])
        .reads(arguments.surface.files(None))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes([&arguments.output]);
    files.check()?;
    check_lights(&arguments.view.light)?;
    if arguments.sample_pixels.is_some() && arguments.optics.picture_method() != Method::Reference {
        return Err(Error::usage(
            "--sample-pixels is for the reference picture only",
            "add --method reference, or leave it away",
        ));
    }
    let shading = arguments.optics.for_pictures(&arguments.colour)?;
    let mut scene = prepare::scene(&arguments.scene)?;
    files.reads(&scene.files).check()?;
    arguments.view.apply(&mut scene)?;
    let field = arguments.surface.load(None, Some(&scene), "elaphe")?;
    let shading = arguments.optics.material_of(&scene, arguments.optics.beyond_of(&field, shading));
    let picture = draw(arguments, &scene, &field, &shading)?;
    picture_file::write(&arguments.output, format, &picture, &captions::notes(&field))
}

fn draw(arguments: &Arguments, scene: &Scene, field: &HeightField, shading: &Shading) -> Result<Picture> {
    let method = arguments.optics.picture_method();
    let reference = method == Method::Reference;
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
    let sampling = Sampling { count: arguments.samples, seed: arguments.surface.seed };
    let source = if reference {
        // The frame's directions are all that the reference needs, and this source has no data.
        Source::ClassicalGrating(ClassicalGrating::default())
    } else {
        let mut settings = Settings::new(method, shading.clone());
        if setup::averages_footprints(&settings) {
            let sample = sampling.sample(0);
            settings.footprints = prepare::footprint_sizes(&device, scene, &view, arguments.size, &sample)?;
        }
        prepare::source(field, &settings, &device)?
    };
    let (size, lights) = (arguments.size, view.lights.len());
    let mut painter = Painter::new(&device, &source, shading, &scene.mesh, &pigment, size, lights)?;
    if source.has_limits(shading) {
        source.check(shading, &directions_of(&mut painter, &view, &Sampling::ONE.sample(0))?)?;
    }
    if reference && shading.windows == Windows::All {
        painter.ask_for_footprints()?;
    }
    scale::tell(&mut painter, &view, scene, shading.coherence)?;
    let picture = if reference {
        let chosen = arguments.sample_pixels;
        let radiance = reference_radiance(&mut painter, &view, &sampling, field, shading, chosen)?;
        let display = displayed(&radiance, scene.exposure, scene.background);
        Picture { size: arguments.size, radiance, display }
    } else {
        let bar = prepare::progress_bar("samples");
        bar.set_length(sampling.count.into());
        let shown = Shown { exposure: scene.exposure, background: scene.background };
        let picture = painter.paint_samples(&view, &sampling, shown, &mut |done| {
            bar.set_position(done.into());
            Ok(())
        });
        bar.finish_and_clear();
        picture?
    };
    drop(painter);
    prepare::finish(&device)?;
    Ok(picture)
}

/// The directions that each light of `view` comes from in `sample`.
fn directions_of(painter: &mut Painter, view: &View, sample: &Sample) -> Result<Vec<Directions>> {
    (0..view.lights.len()).map(|light| painter.directions_of(view, light, sample)).collect()
}

/// The f64 picture, of all pixels that a sample covers or of `count` random ones of them.
fn reference_radiance(
    painter: &mut Painter,
    view: &View,
    sampling: &Sampling,
    field: &HeightField,
    shading: &Shading,
    count: Option<usize>,
) -> Result<Vec<[f32; 4]>> {
    prepare::warn_of_coarse_samples(field, SHORTEST);
    let mut directions = |sample: &Sample| directions_of(painter, view, sample);
    let chosen = match count {
        Some(count) => {
            let mut covered = BTreeSet::new();
            for index in 0..sampling.count {
                covered.extend(reference_picture::covered(&directions(&sampling.sample(index))?));
            }
            let covered: Vec<usize> = covered.into_iter().collect();
            Some(error::sample(&covered, count))
        }
        None => None,
    };
    // The sample's pixels grow.
    let chosen = |pixel| chosen.as_ref().is_none_or(|chosen| chosen.binary_search(&pixel).is_ok());
    let bar = prepare::progress_bar("pixels");
    let radiance = reference_mean(field, shading, view, sampling, &mut directions, &chosen, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    });
    bar.finish_and_clear();
    radiance
}
