//! The benchmark scene that `profile` and `trade` measure: a frame on a device, and its f64 references.

use super::console::Console;
use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, MeshOptions, OpticsOptions, SurfaceOptions, light_by, real,
};
use super::prepare;
use super::progress::ProgressBar;
use crate::brdf::tabulated::ColourSampling;
use crate::error::{Error, ErrorKind, Result};
use crate::measure::budget::MeasuredBudget;
use crate::measure::error::{self, PixelErrors};
use crate::measure::profile::measure;
use crate::measure::trade::Measurement;
use crate::optics::coherence::Windows;
use crate::render::directions::Directions;
use crate::render::footprints;
use crate::render::frame::{Shown, View};
use crate::render::grooves::GrooveDirections;
use crate::render::light_passes::LightPass;
use crate::render::object::{ObjectData, ObjectSources};
use crate::render::pigment::Pigment;
use crate::render::rays::{RayObject, RayScene, RaySettings};
use crate::render::reference_picture::{PixelReference, covered, displayed};
use crate::render::renderer::{Picture, Renderer, RendererSettings};
use crate::render::sampling::Sampling;
use crate::render::source::cost::Cost;
use crate::render::source::{Source, SourceSummary};
use crate::scene::{Light, Scene};
use crate::settings::{Method, Optics};
use crate::setup::{self, InUse, SourceSettings};
use crate::surface::HeightField;
use crate::task::Task;
use crate::units;
use crate::vk::device::Device;
use clap::Args;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::sync::Arc;

/// Scene, shading and device of a benchmark.
#[derive(Args, Clone, Debug)]
pub struct BenchmarkOptions {
    /// snake, plate, sphere, disc, cd, skin, a scene file (.toml) or a mesh (.obj, .gltf, .glb, .ply, .stl)
    #[arg(default_value = "snake")]
    pub scene: OsString,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "640x480")]
    pub size: [u32; 2],
    /// A light instead of the scene's lights and surroundings, in degrees from up and around it; may be given several times
    #[arg(long, value_name = "[KIND:]THETA,PHI[,INTENSITY]", value_parser = Light::parse, allow_hyphen_values = true)]
    pub light: Vec<Light>,
    #[command(flatten)]
    pub mesh: MeshOptions,
    #[command(flatten)]
    pub surface: SurfaceOptions,
    #[command(flatten)]
    pub optics: OpticsOptions,
    #[command(flatten)]
    pub colour: ColourOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub cache: CacheOptions,
}

/// Returns true if `error` refuses a setting, and others may still be measured: it is beyond a limit, takes too much memory, or cannot be meant here.
pub fn is_impossible(error: &Error) -> bool {
    error.is_too_large() || error.kind() == ErrorKind::Usage
}

/// Parses a frame rate \[1/s\].
///
/// # Errors
/// Not a number from 1e-3 to 1e5.
pub fn fps(text: &str) -> Result<f64> {
    real(text, (1e-3, 1e5), "frame rate")
}

/// State that all settings of a benchmark share.
pub struct BenchmarkScene {
    pub console: Console,
    pub device: Arc<Device>,
    pub scene: Scene,
    pub field: HeightField,
    pub view: View,
    pub size: [u32; 2],
}

/// Setting, ready to be measured.
pub struct Benchmark {
    /// Renderer of the frame.
    pub renderer: Renderer,
    /// Optics of the frame.
    pub optics: Optics,
    /// Summary of the source.
    pub summary: SourceSummary,
    /// Samples and wavelengths of the frame.
    pub cost: Cost,
    /// Error budget of the setting.
    pub budget: MeasuredBudget,
    /// The directions of each pixel, one entry per light.
    pub directions: Vec<Directions>,
}

/// Errors of a picture.
#[derive(Default)]
pub struct PictureErrors {
    /// Errors of shading: against f64 for the directions that the device shaded.
    pub pixels: Option<PixelErrors>,
    /// Errors of the whole: against f64 for the directions of rays that are cast in f64.
    pub whole: Option<PixelErrors>,
    /// Errors of geometry: between these two references.
    pub geometry: Option<PixelErrors>,
    /// Mean FLIP, if every covered pixel was compared.
    pub flip: Option<f64>,
    /// Relative L2 difference between one sample a pixel and [`MORE_SAMPLES`], over the same pixels.
    pub sampling: Option<f64>,
}

/// Samples a pixel in the comparison with one sample.
pub const MORE_SAMPLES: u32 = 4;

/// Limits of the time measurement.
#[derive(Clone, Copy)]
pub struct TimingLimits {
    /// Number of frames.
    pub frames: usize,
    /// Seconds after which no further frame is begun.
    pub seconds: f64,
}

/// The reference of a frame.
pub struct ReferencePixels {
    /// Numbers of the covered pixels.
    pub pixels: Vec<usize>,
    /// Linear sRGB of each.
    pub colors: Vec<DVec3>,
}

/// References of one frame by the window positions that they average over. Each is computed once.
#[derive(Default)]
pub struct References {
    pictures: Vec<(Windows, ReferencePixels)>,
}

impl References {
    /// Returns the reference of the frame that shades `directions`, for the window positions of `optics`.
    ///
    /// # Errors
    /// Too little memory.
    pub fn of(
        &mut self,
        scene: &BenchmarkScene,
        optics: &Optics,
        directions: &[Directions],
    ) -> Result<&ReferencePixels> {
        let windows = optics.windows;
        let index = match self.pictures.iter().position(|(known, _)| *known == windows) {
            Some(index) => index,
            None => {
                let pixels = covered(directions);
                let colors = scene.reference(optics, directions, &pixels)?;
                self.pictures.push((windows, ReferencePixels { pixels, colors }));
                self.pictures.len() - 1
            }
        };
        Ok(&self.pictures[index].1)
    }
}

impl BenchmarkScene {
    /// Opens scene, surface and device of `options`.
    ///
    /// # Errors
    /// One of them cannot be opened; `--method reference`.
    pub fn open(options: &BenchmarkOptions, console: &Console) -> Result<Self> {
        check_method(options)?;
        options.optics.for_pictures(&options.colour, console)?;
        let mut scene = prepare::scene(console, &options.scene, &options.mesh.overrides())?;
        light_by(&options.light, &mut scene);
        for light in scene.lights.iter_mut().filter(|light| light.spectrum.is_some()) {
            console.say(&format_args!(
                "the light {light} counts as light of the illuminant, as all lights that are measured do"
            ));
            light.spectrum = None;
        }
        // An environment map is left out here: a single sample of it says little.
        if !scene.lights.is_empty() {
            scene.environment = None;
        }
        let field = options.surface.load(None, Some(&scene), "elaphe", console)?;
        let view = View::under(&scene, &scene.lights, &options.optics.coherence);
        let device = console.context().device()?;
        Ok(Self { console: console.clone(), device, scene, field, view, size: options.size })
    }

    /// Returns the number of pixels of a picture.
    pub fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Returns the optics of `options`, with the material of the scene unless the options give one.
    ///
    /// # Errors
    /// Options that do not go together, a file that cannot be read.
    pub fn optics(&self, options: &BenchmarkOptions) -> Result<Optics> {
        Ok(options
            .optics
            .material_of(&self.scene, options.optics.for_pictures(&options.colour, &self.console)?))
    }

    /// Prepares the setting of `options`.
    ///
    /// # Errors
    /// A setting that does not fit on the device; `--method reference`.
    pub fn prepare(&self, options: &BenchmarkOptions) -> Result<Benchmark> {
        check_method(options)?;
        let optics = self.optics(options)?;
        let mut settings = SourceSettings::new(optics.clone());
        if setup::averages_footprints(&settings) {
            let views = std::slice::from_ref(&self.view);
            settings.footprints = footprints::sizes(
                &self.device,
                &self.scene.main_object().mesh,
                views,
                self.size,
                &Sampling::ONE,
            )?;
        }
        let source = prepare::source(
            &self.console,
            &self.field,
            &settings,
            &self.device,
            &mut InUse::new(self.console.context()),
        )?;
        let (renderer, directions) = self.renderer(&source, &optics)?;
        Ok(Benchmark {
            renderer,
            summary: source.summary(&optics),
            cost: source.cost(&optics, &directions),
            budget: MeasuredBudget::of(&source, &optics),
            optics,
            directions,
        })
    }

    /// Returns a renderer of this frame from `source`, and the directions of each pixel, one entry per light.
    ///
    /// # Errors
    /// A frame that does not fit on the device, directions that `source` cannot shade.
    pub fn renderer(&self, source: &Source, optics: &Optics) -> Result<(Renderer, Vec<Directions>)> {
        let (mesh, grooves) =
            (&self.scene.main_object().mesh, &GrooveDirections::of(&self.scene.main_object().grooves)?);
        let (pigment, casts_shadows) = (&Pigment::white(), true);
        let sources = &ObjectSources::new(source.clone(), optics.clone());
        let object = ObjectData { mesh, pigment, grooves, casts_shadows, sources };
        let settings = RendererSettings { shadows: self.scene.shadows, ..RendererSettings::default() };
        let mut renderer = Renderer::new(&self.device, &[object], self.size, settings)?;
        let directions = (0..self.view.light_count())
            .map(|light| renderer.directions(&self.view, light))
            .collect::<Result<Vec<_>>>()?;
        source.check(optics, &directions)?;
        Ok((renderer, directions))
    }

    /// Draws the picture of `renderer`.
    ///
    /// # Errors
    /// A lost device.
    pub fn paint(&self, renderer: &mut Renderer) -> Result<Picture> {
        self.render(renderer, Sampling::ONE)
    }

    /// Measures the errors of the picture at `count` random pixels that the device or the reference covers.
    ///
    /// # Errors
    /// A lost device, too little memory for the reference.
    pub fn compare(&self, benchmark: &mut Benchmark, count: usize) -> Result<PictureErrors> {
        let picture = self.paint(&mut benchmark.renderer)?;
        let cast = self.cast(&benchmark.optics)?;
        let covered: BTreeSet<usize> =
            [&benchmark.directions, &cast].into_iter().flat_map(|seen| covered(seen)).collect();
        let covered: Vec<usize> = covered.into_iter().collect();
        let pixels = error::sample(&covered, count);
        let colors = self.reference(&benchmark.optics, &benchmark.directions, &pixels)?;
        let of_rays = self.reference(&benchmark.optics, &cast, &pixels)?;
        let one = shown(&picture, &pixels);
        let errors =
            |found: &[DVec3], exact: &[DVec3]| PixelErrors::of(found, exact, self.scene.display.exposure);
        let sampling = Sampling { count: MORE_SAMPLES, seed: 0 };
        let more = shown(&self.render(&mut benchmark.renderer, sampling)?, &pixels);
        let mut all = PictureErrors {
            pixels: Some(errors(&one, &colors)),
            whole: Some(errors(&one, &of_rays)),
            geometry: Some(errors(&colors, &of_rays)),
            flip: None,
            sampling: Some(errors(&one, &more).relative_l2),
        };
        if pixels.len() == covered.len() {
            all.flip = Some(self.flip(&picture, &ReferencePixels { pixels, colors }));
        }
        Ok(all)
    }

    /// Casts the rays of each light in f64.
    fn cast(&self, optics: &Optics) -> Result<Vec<Directions>> {
        let grooves = &GrooveDirections::of(&self.scene.main_object().grooves)?;
        let rays = RayScene::new(vec![RayObject {
            mesh: &self.scene.main_object().mesh,
            grooves,
            casts_shadows: true,
        }]);
        let settings = RaySettings::new(self.size, self.scene.shadows, optics);
        let pass = |light| LightPass::of_all(light, Sampling::ONE.sample(0));
        let lights = 0..self.view.light_count();
        Ok(lights.map(|light| rays.directions(&self.view, &pass(light), &settings)).collect())
    }

    /// Draws the picture of `renderer` from all samples of `sampling`, displayed as the scene says.
    fn render(&self, renderer: &mut Renderer, sampling: Sampling) -> Result<Picture> {
        renderer.render(&self.view, &sampling, Shown::of(&self.scene), &Task::silent())
    }

    /// Times the frame and measures the errors of its picture; the fields that depend on the setting stay empty.
    ///
    /// # Errors
    /// A lost device.
    pub fn measure(
        &self,
        renderer: &mut Renderer,
        exact: &ReferencePixels,
        limits: TimingLimits,
    ) -> Result<Measurement> {
        let times = measure(renderer, &self.view, limits.frames, limits.seconds, &Task::silent())?;
        let picture = self.paint(renderer)?;
        let errors =
            PixelErrors::of(&shown(&picture, &exact.pixels), &exact.colors, self.scene.display.exposure);
        Ok(Measurement {
            frame_ms: times.frame.p50,
            fastest_ms: times.frame.min,
            gpu_ms: times.gpu.p50,
            spread: times.spread,
            relative_l2: errors.relative_l2,
            p99: errors.p99,
            flip: self.flip(&picture, exact),
            ..Measurement::default()
        })
    }

    /// Computes the f64 reference of `pixels`, linear sRGB; black for uncovered pixels.
    fn reference(&self, optics: &Optics, directions: &[Directions], pixels: &[usize]) -> Result<Vec<DVec3>> {
        let bar = ProgressBar::new(&self.console, "reference", "a smaller number of compared pixels");
        let task = bar.task().named("reference");
        let is_covered = |pixel: &&usize| directions.iter().any(|seen| seen.view[**pixel][3] != 0.0);
        let seen: Vec<usize> = pixels.iter().filter(is_covered).copied().collect();
        /// Error of the reference relative to the smallest tolerance of a sweep.
        const PART: f64 = 0.2;
        let sampling = ColourSampling::within(PART * optics.tolerance.min(1e-2));
        let colors = PixelReference::with_sampling(&self.field, optics, sampling, &task)
            .and_then(|reference| reference.colors(&self.view, 0, directions, &seen, &task));
        let colors: BTreeMap<usize, DVec3> = seen.into_iter().zip(colors?).collect();
        Ok(pixels.iter().map(|pixel| colors.get(pixel).copied().unwrap_or(DVec3::ZERO)).collect())
    }

    /// Returns the mean FLIP between `picture` and the reference, both as displayed.
    fn flip(&self, picture: &Picture, exact: &ReferencePixels) -> f64 {
        let mut radiance = vec![[0.0; 4]; picture.radiance.len()];
        for (&pixel, color) in exact.pixels.iter().zip(&exact.colors) {
            radiance[pixel] = color.as_vec3().extend(1.0).to_array();
        }
        let exact = displayed(&radiance, Shown::of(&self.scene));
        error::flip(&picture.display, &exact, picture.size)
    }
}

fn check_method(options: &BenchmarkOptions) -> Result<()> {
    if options.optics.picture_method() == Method::Reference {
        return Err(Error::usage(
            "--method reference has no frames to time",
            "leave it out, or use --method table",
        ));
    }
    Ok(())
}

/// Returns the linear sRGB of `pixels` of `picture`.
pub fn shown(picture: &Picture, pixels: &[usize]) -> Vec<DVec3> {
    let color = |&i: &usize| {
        let [r, g, b, _] = picture.radiance[i];
        DVec3::new(r.into(), g.into(), b.into())
    };
    pixels.iter().map(color).collect()
}
