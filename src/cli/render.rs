//! `diffract render`: a scene into a file.

use super::options::{
    ColourOptions, DeviceOptions, Method, OpticsOptions, SurfaceOptions, check_lights, exposure, lights_of,
    sample_pixels,
};
use super::{prepare, write};
use crate::error::{Error, Result};
use crate::measure::error;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::render::frame::View;
use crate::render::picture::{Painter, Picture};
use crate::render::reference_picture::{self, displayed, reference_pixels};
use crate::render::resources::Pigment;
use crate::render::shading::Shading;
use crate::scene::{Light, Scene};
use crate::surface::HeightField;
use crate::{input, output, units};
use clap::Args;
use std::io::Read;
use std::path::{Path, PathBuf};

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
    /// Exposure in stops, instead of the scene's
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true)]
    exposure: Option<f64>,
    /// A light instead of the scene's, in degrees from up and around it; up to four
    #[arg(long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true)]
    light: Vec<Light>,
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
}

/// Draws and writes.
pub fn run(arguments: &Arguments) -> Result<()> {
    let format = write::PictureFormat::of(&arguments.output)?;
    output::check(&arguments.output)?;
    check_lights(&arguments.light)?;
    if arguments.sample_pixels.is_some() && arguments.optics.method != Method::Reference {
        return Err(Error::usage(
            "--sample-pixels is for the reference picture only",
            "add --method reference, or leave it away",
        ));
    }
    let shading = arguments.optics.shading(&arguments.colour)?;
    let scene = Scene::open(&arguments.scene)?;
    let field = arguments.surface.load(None, Some(&scene), "elaphe")?;
    let picture = draw(arguments, &scene, &field, &shading)?;
    write::picture(&arguments.output, format, &picture)
}

fn draw(arguments: &Arguments, scene: &Scene, field: &HeightField, shading: &Shading) -> Result<Picture> {
    let reference = arguments.optics.method == Method::Reference;
    if reference && scene.pigment.is_some() {
        return Err(Error::usage(
            "--method reference knows no pigment texture",
            "leave `pigment` out of the scene",
        ));
    }
    let device = prepare::device(&arguments.device.wish())?;
    // The reference needs the frame's directions only; these layers are the smallest there are, and always the same.
    let layers = if reference {
        let flat = HeightField::new(1, 1, [SHORTEST / 4.0; 2], vec![0.0])?;
        let coherence = Coherence::Gaussian { length: 1.0 };
        let shading = Shading { coherence, tolerance: 1e-1, ..Shading::default() };
        prepare::layers(&flat, &shading, SHORTEST, &device)?
    } else {
        prepare::layers(field, shading, SHORTEST, &device)?
    };
    let pigment = scene.pigment.as_deref().map(read_pigment).transpose()?;
    let view = View { pigment: pigment.is_some(), ..View::of(scene, lights_of(&arguments.light, scene)) };
    let pigment = pigment.unwrap_or_else(Pigment::white);
    let mut painter =
        Painter::new(&device, &layers, shading, &scene.mesh, &pigment, arguments.size, view.lights.len())?;
    let exposure = arguments.exposure.unwrap_or(scene.exposure);
    let picture = if reference {
        let radiance = reference_radiance(&mut painter, &view, field, shading, arguments.sample_pixels)?;
        let display = displayed(&radiance, exposure, scene.background);
        Picture { size: arguments.size, radiance, display }
    } else {
        painter.paint(&view, exposure, scene.background)?
    };
    drop(painter);
    prepare::finish(&device)?;
    Ok(picture)
}

fn reference_radiance(
    painter: &mut Painter,
    view: &View,
    field: &HeightField,
    shading: &Shading,
    samples: Option<usize>,
) -> Result<Vec<[f32; 4]>> {
    prepare::warn_of_coarse_samples(field, SHORTEST);
    let directions =
        (0..view.lights.len()).map(|light| painter.directions(view, light)).collect::<Result<Vec<_>>>()?;
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

/// Largest side of a pigment texture \[pixels\].
const MAX_PIGMENT: u32 = 8192;

fn read_pigment(path: &Path) -> Result<Pigment> {
    const EXPECTED: &str = "a PNG or TIFF picture for the pigment";
    let mut bytes = Vec::new();
    let file = input::open(path, EXPECTED, input::MAX_TEXT)?;
    let bad = |e: &dyn std::fmt::Display| {
        Error::failed(format!("it cannot be read as a picture ({e})"), format!("give {EXPECTED}"))
            .at(path.display())
    };
    file.take(input::MAX_TEXT).read_to_end(&mut bytes).map_err(|e| bad(&e))?;
    let mut reader =
        image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format().map_err(|e| bad(&e))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_PIGMENT);
    limits.max_image_height = Some(MAX_PIGMENT);
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| bad(&e))?.to_rgba8();
    Ok(Pigment { size: [picture.width(), picture.height()], texels: picture.into_raw() })
}
