//! `diffract render`: a scene into a file, or a sequence of pictures into numbered ones.

use super::console::Console;
use super::exported::ExportedTable;
use super::finished::{self, KeptPicture, SequenceOrigin};
use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, MeshOptions, OpticsOptions, SurfaceOptions, ViewOptions,
    sample_pixels,
};
use super::progress::{ProgressBar, surface_task};
use super::sequence::SequenceOptions;
use super::{captions, prepare, scale};
use crate::error::{Error, Remedy, Result};
use crate::files::Files;
use crate::measure::error;
use crate::notes::Notes;
use crate::optics::spectrum::SHORTEST;
use crate::optics::validity::LightColour;
use crate::picture_file::{self, PictureFormat};
use crate::render::exposure;
use crate::render::frame::{Shown, View};
use crate::render::light_passes::LightPass;
use crate::render::object::ObjectTextures;
use crate::render::rays::{self, RayScene, RaySettings};
use crate::render::reference_picture::{
    self, ReferenceObject, ReferenceSamples, displayed_of, reference_mean,
};
use crate::render::renderer::Picture;
use crate::render::sampling::Sampling;
use crate::render::sequence::Sequence;
use crate::render::source::{ClassicalGrating, Source};
use crate::scene::Scene;
use crate::settings::Method;
use crate::setup::{self, InUse, ObjectSurface, PictureSettings, PreparedScene, SourceSettings};
use crate::surface::HeightField;
use crate::task::Task;
use crate::units;
use clap::Args;
use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract render -o snake.png
  diffract render disc --surface blaze --light 20,90 --size 800x800 -o disc.png
  diffract render --tolerance 5e-3 -o exact.exr        EXR: linear radiance, before exposure
  diffract render --exposure auto --tone neutral -o bright.png   as bright as suits it, highlights softly to white
  diffract render --samples 64 -o fine.png             smoother edges and highlights than the default 16
  diffract render --turntable 120 -o turn.png          once around the snake: turn-0000.png to turn-0119.png
  diffract render --light-sweep 90 --frames 0..45 -o sun.png   the first half of a turn of the lights")]
pub struct Arguments {
    /// snake, plate, sphere, disc, cd, skin, a scene file (.toml) or a mesh (.obj, .gltf, .glb, .ply, .stl)
    #[arg(default_value = "snake")]
    scene: OsString,
    /// Output file: .png as displayed, .exr linear and signed, premultiplied; alpha is the coverage of the pixel, in a .png before
    /// surroundings 1
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "1280x720")]
    size: [u32; 2],
    #[command(flatten)]
    view: ViewOptions,
    #[command(flatten)]
    mesh: MeshOptions,
    /// Write into the EXR a channel Z, too: the distance of what the pixel's centre shows from the viewer's plane, along the camera's axis, in the scene's
    /// units; infinite where that is no mesh
    #[arg(long, hide_short_help = true, conflicts_with_all = ["turntable", "light_sweep"])]
    depth: bool,
    /// Samples a pixel, each with the camera moved inside the pixel: 1 to 4096; 1 looks at pixel centres only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), allow_hyphen_values = true, default_value = "16")]
    samples: u32,
    /// Shade only this many random pixels of those that the mesh covers (--method reference only)
    #[arg(long, value_name = "N", value_parser = sample_pixels, allow_hyphen_values = true, hide_short_help = true)]
    sample_pixels: Option<usize>,
    #[command(flatten)]
    sequence: SequenceOptions,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    /// Read the colour table of an export of the same surface and settings instead of making one
    #[arg(long, value_name = "FOLDER", hide_short_help = true)]
    table: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

impl Arguments {
    /// Returns the scene.
    pub fn scene(&self) -> &OsStr {
        &self.scene
    }
}

/// Draws the pictures and writes them.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    let format = PictureFormat::of(&arguments.output)?;
    if arguments.depth && format != PictureFormat::Exr {
        return Err(Error::usage(
            "a PNG has no channel for --depth",
            "name the output .exr, or leave --depth away",
        ));
    }
    let sequence = arguments.sequence.chosen()?;
    let outputs = match &sequence {
        Some(sequence) => sequence.files(&arguments.output),
        None => vec![arguments.output.clone()],
    };
    let files = Files::new()
        .reads([&arguments.scene])
        .reads(arguments.surface.files(None))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .reads(arguments.view.files())
        .reads(arguments.mesh.files())
        .writes(outputs);
    files.check()?;
    let optics = arguments.optics.for_pictures(&arguments.colour, console)?;
    if arguments.sample_pixels.is_some() && optics.method != Method::Reference {
        return Err(Error::usage(
            "--sample-pixels is for the reference picture only",
            "add --method reference, or leave it away",
        ));
    }
    if arguments.table.is_some() && optics.method != Method::Table {
        return Err(Error::usage("--table reads a colour table", Remedy::TableMethod));
    }
    let mut scene = prepare::scene(console, &arguments.scene, &arguments.mesh.overrides())?;
    files.reads(&scene.files).check()?;
    arguments.view.apply(&mut scene, console)?;
    let field = Arc::new(arguments.surface.load(None, Some(&scene), "elaphe", console)?);
    let optics = arguments.optics.material_of(&scene, arguments.optics.beyond_of(&field, optics));
    let settings = PictureSettings {
        size: arguments.size,
        sampling: Sampling { count: arguments.samples, seed: arguments.surface.seed },
        source: SourceSettings::new(optics),
    };
    let shaded = arguments.sample_pixels;
    let measured = scene.display.auto_exposure;
    let surfaces = ObjectSurface::of(&scene, &field, &settings.source, &mut |s| {
        s.load(&surface_task(console)).map(Arc::new)
    })?;
    let work = PictureWork {
        console,
        scene: &scene,
        field: &field,
        surfaces: &surfaces,
        settings: &settings,
        shaded,
        measured,
    };
    let view = setup::own_view(&scene, &settings.source.optics);
    let shots = shots(&arguments.output, sequence.as_ref(), &view, &work)?;
    let views = sequence.map_or_else(|| vec![view.clone()], |sequence| sequence.typical_views(&view));
    draw(arguments, format, &work, &views, &shots)
}

/// State that all pictures of a run share.
struct PictureWork<'a> {
    console: &'a Console,
    scene: &'a Scene,
    field: &'a Arc<HeightField>,
    /// Surfaces of all objects.
    surfaces: &'a [ObjectSurface],
    settings: &'a PictureSettings,
    /// Number of random pixels of a reference picture; `None`: all.
    shaded: Option<usize>,
    /// True if the exposure is measured instead of the scene's.
    measured: bool,
}

impl PictureWork<'_> {
    /// Returns the notes of a picture, with the errors of scalar theory for the first object and the preparation of all surfaces.
    fn notes(&self) -> Notes {
        let first = self.surfaces.first();
        let optics = first.map_or(&self.settings.source.optics, |surface| &surface.source.optics);
        let colour = LightColour::Spectrum(&optics.illuminant);
        let mut notes = captions::picture_notes(self.console, self.field, &optics.reflectance, colour);
        for (number, surface) in self.surfaces.iter().enumerate().skip(1) {
            let field = surface.field.as_ref().filter(|field| !Arc::ptr_eq(field, self.field));
            notes.more.extend(field.map(|f| (format!("Prepared {}", number + 1), f.prepared().to_string())));
        }
        notes
    }
}

/// Picture to be drawn.
struct Shot {
    view: View,
    output: PathBuf,
    notes: Notes,
    /// True if the file gets a hash of its contents, by which a later run recognises a complete file.
    is_sealed: bool,
}

/// Returns the one picture of `view`, or the missing pictures of the `sequence` that begins with it.
fn shots(
    output: &Path,
    sequence: Option<&Sequence>,
    view: &View,
    work: &PictureWork<'_>,
) -> Result<Vec<Shot>> {
    let notes = work.notes();
    let Some(sequence) = sequence else {
        return Ok(vec![Shot { view: view.clone(), output: output.to_owned(), notes, is_sealed: false }]);
    };
    sequence.check(view)?;
    let settings = &(work.settings, work.shaded);
    let origin = SequenceOrigin::of(sequence, view, (work.scene, work.measured), work.surfaces, settings)?;
    let mut shots = Vec::new();
    for frame in sequence.frames.clone() {
        let (output, note) = (sequence.file(output, frame), origin.note(frame));
        let state = finished::frame(&output, &note)?;
        if state == KeptPicture::Finished {
            continue;
        }
        if state == KeptPicture::Damaged {
            work.console
                .say(&format_args!("{}: the picture is damaged and is drawn again", output.display()));
        }
        let notes = captions::notes_of_frame(work.console, &notes, frame, finished::NOTE, note);
        shots.push(Shot { view: sequence.view(view, frame), output, notes, is_sealed: true });
    }
    let asked = sequence.frames.len();
    if shots.len() < asked {
        work.console
            .say(&format_args!("{} of {asked} pictures are there already and stay", asked - shots.len()));
    }
    Ok(shots)
}

/// Draws `shots` from one source and writes each as it is finished. The source is made for all `views`; the exposure follows the first.
fn draw(
    arguments: &Arguments,
    format: PictureFormat,
    work: &PictureWork<'_>,
    views: &[View],
    shots: &[Shot],
) -> Result<()> {
    let Some(first) = shots.first() else { return Ok(()) };
    let PictureWork { console, scene, surfaces, settings, .. } = *work;
    let optics = &settings.source.optics;
    let reference = settings.source.optics.method == Method::Reference;
    let textured = scene.objects.iter().any(|object| object.pigment.is_some());
    if reference && textured {
        return Err(Error::usage(
            "--method reference knows no pigment texture",
            "leave `pigment` out of the scene",
        ));
    }
    let exported = arguments.table.as_deref().map(ExportedTable::open).transpose()?;
    let device = console.context().device()?;
    let mut in_use = InUse::new(console.context());
    let make = |surface: &ObjectSurface| match (&surface.field, surface.source.optics.method) {
        // The reference casts its rays in f64; this source has no data.
        (_, Method::Reference) => Ok(Source::ClassicalGrating(ClassicalGrating::default())),
        (None, _) => Ok(setup::pigment_alone()),
        (Some(field), _) if let Some(exported) = &exported => exported.source(field, &surface.source),
        (Some(field), _) => prepare::source(console, field, &surface.source, &device, &mut in_use),
    };
    let mut prepared = PreparedScene::new(&device, (scene, surfaces), settings, views, make)?;
    shots.iter().try_for_each(|shot| prepared.check(&shot.view))?;
    let textures = if reference { ObjectTextures::of(scene)? } else { Vec::new() };
    let rays = reference.then(|| RayScene::new(rays::objects(scene, &textures)));
    let mut shown = Shown::of(scene);
    if let Some(first) = views.first().filter(|_| work.measured) {
        prepared.check(first)?;
        let measured = match &rays {
            Some(rays) => reference_exposure(rays, first, work)?,
            None => prepared.meter(first)?,
        };
        shown.exposure = told_exposure(measured, scene, console);
        prepared.show(shown);
    }
    scale::tell(prepared.renderer(), &first.view, scene, optics.coherence, settings.sampling.count, console)?;
    let progress = SequenceProgress::over(console, shots.len(), if reference { "pixels" } else { "samples" });
    for (number, shot) in shots.iter().enumerate() {
        let task = progress.of_picture(number);
        let mut picture = match &rays {
            Some(rays) => reference_picture(rays, &shot.view, work, shown, &task)?,
            None => prepared.draw(&shot.view, &task)?,
        };
        picture.is_opaque |= scene.display.is_opaque;
        prepare::check(&device)?;
        let mut notes = shot.notes.clone();
        notes.more.extend(prepared.energy_note().map(|note| ("Limit of energy".to_owned(), note)));
        if shot.is_sealed {
            notes = finished::sealed(notes, format, &picture);
        }
        if arguments.depth {
            let distances = prepared.renderer().distances(&shot.view)?;
            picture_file::write_with_distances(&shot.output, &picture, &distances, &notes)?;
        } else {
            picture_file::write(&shot.output, format, &picture, &notes)?;
        }
    }
    drop((progress, prepared));
    prepare::finish(console, &device)
}

/// Progress of all pictures.
struct SequenceProgress {
    bar: ProgressBar,
    parts: &'static str,
    pictures: usize,
}

impl SequenceProgress {
    /// Returns the bar of so many pictures, each of which consists of `parts`.
    fn over(console: &Console, pictures: usize, parts: &'static str) -> Self {
        Self {
            bar: ProgressBar::new(console, parts, "a smaller --size, or a smaller number of --samples,"),
            parts,
            pictures,
        }
    }

    /// Returns the task of picture number `number`, from 0.
    fn of_picture(&self, number: usize) -> Task {
        let (bar, parts, pictures) = (self.bar.clone(), self.parts, self.pictures);
        let message = match pictures {
            1 => parts.to_owned(),
            _ => format!("picture {} of {pictures}", number + 1),
        };
        let show = Task::reporting(move |progress| bar.show_as(&progress, message.clone()));
        show.share(number, pictures).named(parts)
    }
}

/// Measures the exposure that suits `view` \[stops\] in one sample of random pixels of the reference; `None` without light.
fn reference_exposure(rays: &RayScene<'_>, view: &View, work: &PictureWork<'_>) -> Result<Option<f64>> {
    /// Number of pixels whose mean is certain to about a tenth of a stop; each pixel of the reference takes long.
    const PIXELS: usize = 2000;
    let settings = PictureSettings { sampling: Sampling::ONE, ..work.settings.clone() };
    let one = PictureWork { settings: &settings, shaded: Some(PIXELS), ..*work };
    let bar = ProgressBar::new(work.console, "exposure", "an --exposure in stops");
    let task = bar.task().named("exposure");
    let picture = reference_picture(rays, view, &one, Shown::of(work.scene), &task)?;
    Ok(exposure::automatic(&picture.radiance))
}

/// Prints and returns the `measured` exposure \[stops\], or that of `scene` without light.
fn told_exposure(measured: Option<f64>, scene: &Scene, console: &Console) -> f64 {
    let stops = measured.unwrap_or(scene.display.exposure);
    let unlit = if measured.is_none() { ", the scene's own: nothing is lit" } else { "" };
    console.say(&format_args!("exposure {stops:.1} stops{unlit}"));
    stops
}

/// Computes the f64 picture of `view`, of all pixels that a sample covers or of some random ones of them.
fn reference_picture(
    rays: &RayScene<'_>,
    view: &View,
    work: &PictureWork<'_>,
    shown: Shown,
    task: &Task,
) -> Result<Picture> {
    let PictureWork { field, surfaces, settings, shaded, .. } = *work;
    prepare::warn_of_coarse_samples(work.console, field, SHORTEST);
    let sampling = &settings.sampling;
    let cast = RaySettings::new(settings.size, work.scene.shadows, &settings.source.optics);
    let mut directions = |pass: &LightPass| Ok(rays.directions(view, pass, &cast));
    let chosen = match shaded {
        Some(count) => {
            let mut covered = BTreeSet::new();
            let schedule = view.schedule(sampling);
            let passes = schedule.groups().flat_map(|group| group.passes);
            for pass in passes.flat_map(LightPass::each_light) {
                covered.extend(reference_picture::covered(&[directions(&pass)?]));
            }
            let covered: Vec<usize> = covered.into_iter().collect();
            Some(error::sample(&covered, count))
        }
        None => None,
    };
    // Pixel indices increase, so that a binary search finds them.
    let chosen = |pixel| chosen.as_ref().is_none_or(|chosen| chosen.binary_search(&pixel).is_ok());
    let mut objects = Vec::new();
    for ObjectSurface { field, source } in surfaces {
        objects.push(ReferenceObject { field: field.as_deref(), optics: &source.optics });
    }
    let samples = ReferenceSamples { sampling, size: settings.size, chosen: &chosen };
    let radiance = reference_mean(&objects, view, &samples, &mut directions, task)?;
    let display = displayed_of(view, settings.size, &radiance, shown);
    let is_opaque = view.background().is_some();
    Ok(Picture { size: settings.size, radiance, display, is_opaque })
}
