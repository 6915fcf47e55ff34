//! One picture, offscreen: what `diffract render` writes.

use super::accumulate::{Accumulation, Addition};
use super::around::AroundPass;
use super::evaluator::{Asker, Query};
use super::frame::{
    DisplayPass, GeometryPass, PixelPass, Probe, ShadedObject, Shown, View, begin_shading, record_shading,
};
use super::grooves::GrooveDirections;
use super::light_passes::{LightPass, all_lights};
use super::object::{DeviceObject, ObjectData, ObjectSource, ObjectSources};
use super::pigment::Pigment;
use super::sampling::{Sample, Sampling};
use super::shading::Shading;
use super::source::{BoundSource, Source};
use super::target::{self, Geometry, GeometrySettings, Target};
use crate::error::{Error, Result};
use crate::optics::color;
use crate::optics::spectrum::Illuminant;
use crate::scene::Mesh;
use crate::vk::access::Access;
use crate::vk::commands::{Commands, Recorder};
use crate::vk::device::Device;
use crate::vk::queries::Timestamps;
use glam::{DVec3, Vec3};
use std::sync::Arc;

mod display;
mod read_back;
pub mod samples;
mod tiles;
pub mod timing;

use display::Display;
use read_back::PictureArea;
use tiles::{Piece, Tiles};
use timing::DrawTimes;

/// Draws pictures of one object or of several.
pub struct Painter {
    commands: Commands,
    find: GeometryPass,
    // At least one.
    objects: Vec<DeviceObject>,
    // What shades them, object by object: one or more for each.
    shadings: Vec<ObjectShading>,
    geometry: Geometry,
    display: DisplayPass,
    target: Target,
    timestamps: Timestamps,
    asker: Option<Asker>,
    // Milliseconds in which a pixel of the last picture that was drawn in tiles was shaded.
    pixel_time: Option<f64>,
    // What the display shows.
    shows: Content,
    // Made with the first picture of several samples.
    accumulation: Option<Accumulation>,
    // Made with the first picture that shows its surroundings.
    around: Option<AroundPass>,
    // What the samples in its sum are of.
    summed: Option<samples::Summed>,
    // What the `Frame` block is of, and what the geometry images hold.
    written: Option<Written>,
    found: Option<Written>,
    device: Arc<Device>,
}

/// What an object is shaded by under the lights of one illuminant.
struct ObjectShading {
    /// Number of the object.
    object: usize,
    // Whether it is the object's first: that of the lights without an illuminant of their own.
    is_first: bool,
    illuminant: Illuminant,
    // Of its illuminant, linear sRGB.
    white: Vec3,
    source: BoundSource,
    pass: PixelPass,
    // Of the specular order, where surroundings are read in the mirrored direction.
    specular_spread: Option<f32>,
}

impl ObjectShading {
    /// The object, which is one of `objects`, as it is shaded under a light that is drawn from surroundings whose specular order is `mirrored`, or under
    /// another. Whether its pixels `count` as covered once more.
    fn of<'a>(&'a self, objects: &'a [DeviceObject], mirrored: bool, counts: bool) -> ShadedObject<'a> {
        let Self { object: number, white, source, pass, .. } = self;
        ShadedObject {
            number: *number,
            object: &objects[*number],
            source,
            pass,
            mirrored,
            white: *white,
            counts,
        }
    }
}

/// What shades `object` from `sources`, its geometry found by `settings`.
fn object_shadings(
    device: &Arc<Device>,
    (number, object): (usize, &DeviceObject),
    sources: Vec<(BoundSource, &Illuminant)>,
    settings: GeometrySettings,
) -> Result<Vec<ObjectShading>> {
    let shading = |(place, (source, illuminant)): (usize, (BoundSource, &Illuminant))| {
        Ok(ObjectShading {
            object: number,
            is_first: place == 0,
            illuminant: illuminant.clone(),
            white: white_of(illuminant),
            pass: PixelPass::shading(device, &object.frame.descriptors, &source, settings)?,
            specular_spread: source.specular_spread,
            source,
        })
    };
    sources.into_iter().enumerate().map(shading).collect()
}

/// A white diffuse surface under `illuminant`, linear sRGB.
fn white_of(illuminant: &Illuminant) -> Vec3 {
    color::xyz_to_linear_srgb(illuminant.white()).as_vec3()
}

/// What is asked of the geometry pass.
#[derive(Clone, PartialEq)]
struct Written {
    view: View,
    pass: LightPass,
    size: [u32; 2],
}

/// What is drawn into the radiance.
#[derive(Clone, Copy)]
struct Drawn<'a> {
    view: &'a View,
    size: [u32; 2],
    /// One after the other; at least one.
    passes: &'a [LightPass],
}

/// What can be displayed and read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// Nothing: radiance is of no picture, or of parts of several.
    Nothing,
    /// Nothing: radiance holds a part of a picture, and more tiles of it may follow.
    PictureArea,
    /// One sample: the radiance.
    Sample,
    /// The mean of the samples that are summed.
    Mean,
}

/// What follows the last row of what is drawn.
#[derive(Clone, Copy)]
enum Finish {
    /// It is displayed.
    Display(Shown),
    /// Each pass is a picture of its own. All of them, which are of so many `samples`, are added to the sum of those `before` them. Where they are to be `shown`,
    /// the mean of all is displayed.
    Add { before: u32, samples: u32, shown: Option<Shown> },
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Linear radiance, signed, RGBA, row by row from the top. Alpha is the part of the samples in which the mesh covers the pixel, and
    /// colours are premultiplied by it.
    pub radiance: Vec<[f32; 4]>,
    /// What is displayed, sRGB-encoded and opaque RGBA: the mesh over the background.
    pub display: Vec<[u8; 4]>,
    /// Whether the background is surroundings, which belong to the picture as the mesh does.
    pub surrounded: bool,
}

impl Painter {
    /// Uploads everything for pictures of `size` pixels, shaded from `source`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(
        device: &Arc<Device>,
        source: &Source,
        shading: &Shading,
        mesh: &Mesh,
        pigment: &Pigment,
        size: [u32; 2],
    ) -> Result<Self> {
        let grooves = &GrooveDirections::along();
        let (base_color, casts_shadows) = (None, true);
        let sources = &ObjectSources::new(source.clone(), shading.clone());
        let object = ObjectData { mesh, pigment, grooves, base_color, casts_shadows, sources };
        Self::of_objects(device, &[object], size)
    }

    /// Uploads everything for pictures of `objects`, as [`Self::new`]. What is asked of the source of a painter is asked of the first.
    ///
    /// # Errors
    /// Where the device has no room, and without any object.
    pub fn of_objects(device: &Arc<Device>, objects: &[ObjectData<'_>], size: [u32; 2]) -> Result<Self> {
        if objects.is_empty() {
            return Err(Error::failed("there is no object", "report this as a bug of diffract"));
        }
        let bind = |of: &'_ ObjectSource| of.source.bind(device, &of.shading);
        let mut sources = Vec::with_capacity(objects.len());
        for object in objects {
            sources.push(object.sources.all().map(bind).collect::<Result<Vec<_>>>()?);
        }
        let settings = GeometrySettings {
            textured: objects.iter().any(|object| object.pigment.is_textured()),
            marked: sources.iter().flatten().any(|source| source.asks_what_is_covered),
            footprints: sources.iter().flatten().any(|source| source.reads_footprints),
            several: objects.len() > 1,
            ..GeometrySettings::default()
        };
        let geometry = Geometry::new(device, size, settings)?;
        let target = Target::new(device, size)?;
        let display = DisplayPass::new(device, target::DISPLAY, settings.depth_format())?;
        display.read_from(&target.radiance);
        let upload = |object: &ObjectData<'_>| DeviceObject::new(device, object, &geometry);
        let data = objects;
        let objects = data.iter().map(upload).collect::<Result<Vec<_>>>()?;
        let mut shadings = Vec::new();
        for (number, (own, bound)) in data.iter().zip(sources).enumerate() {
            let illuminants = own.sources.all().map(|of| &of.shading.illuminant);
            let bound = bound.into_iter().zip(illuminants).collect();
            shadings.extend(object_shadings(device, (number, &objects[number]), bound, settings)?);
        }
        Ok(Self {
            commands: Commands::new(device, "frame")?,
            find: GeometryPass::new(device, &objects, &geometry)?,
            shadings,
            objects,
            geometry,
            display,
            target,
            timestamps: Timestamps::new(device, 4)?,
            asker: None,
            pixel_time: None,
            shows: Content::Nothing,
            accumulation: None,
            around: None,
            summed: None,
            written: None,
            found: None,
            device: device.clone(),
        })
    }

    /// Another size for the pictures from now on.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        if [self.target.size(), self.geometry.directions.size()] == [size; 2] {
            return Ok(());
        }
        self.forget();
        self.find_anew(size, self.geometry.settings)?;
        self.target = Target::new(&self.device, size)?;
        self.display.read_from(&self.target.radiance);
        if let Some(accumulation) = &mut self.accumulation {
            accumulation.resize(&self.device, &self.target)?;
        }
        self.point_around();
        Ok(())
    }

    /// Makes the images of the geometry pass, and the pass, for `size` pixels; also the shading pass, where it depends on them. Where one of
    /// them cannot be made, the former ones stay.
    fn find_anew(&mut self, size: [u32; 2], settings: GeometrySettings) -> Result<()> {
        let geometry = Geometry::new(&self.device, size, settings)?;
        let of_shading = |s: GeometrySettings| (s.mirrored, s.lamps);
        let same = of_shading(settings) == of_shading(self.geometry.settings);
        let shade = |own: &ObjectShading| {
            let frame = &self.objects[own.object].frame.descriptors;
            PixelPass::shading(&self.device, frame, &own.source, settings)
        };
        let changed = if same { &[] } else { self.shadings.as_slice() };
        let passes = changed.iter().map(shade).collect::<Result<Vec<_>>>()?;
        self.find = GeometryPass::new(&self.device, &self.objects, &geometry)?;
        self.shadings.iter_mut().zip(passes).for_each(|(shading, pass)| shading.pass = pass);
        self.objects.iter().for_each(|object| object.frame.read_from(&geometry));
        self.geometry = geometry;
        self.found = None;
        Ok(())
    }

    /// From now on the geometry pass writes footprints, too, and [`Self::directions`] have them.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn ask_for_footprints(&mut self) -> Result<()> {
        let settings = GeometrySettings { footprints: true, ..self.geometry.settings };
        if settings != self.geometry.settings {
            self.forget();
            self.find_anew(self.target.size(), settings)?;
        }
        Ok(())
    }

    /// From now on the geometry pass writes the radiance of surroundings in the mirrored direction, too, averaged over a specular order of this
    /// variance in (u, v), and [`Self::directions`] have it. Sources that know the specular order ask for it themselves.
    pub fn ask_for_mirrored(&mut self, spread: f64) {
        self.forget();
        self.shadings.iter_mut().for_each(|shading| shading.specular_spread = Some(spread as f32));
    }

    /// From now on the mesh casts shadows on itself.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn cast_shadows(&mut self) -> Result<()> {
        let settings = GeometrySettings { shadows: true, ..self.geometry.settings };
        if settings != self.geometry.settings {
            self.forget();
            self.find_anew(self.target.size(), settings)?;
        }
        Ok(())
    }

    /// The frames from now on are surrounded as `view` is. Where the source knows the specular order, the geometry pass writes the radiance in
    /// the mirrored direction. What a 1 of the picture on the device stands for.
    fn surround(&mut self, view: &View) -> Result<f32> {
        let known = self.shadings.iter().any(|shading| shading.specular_spread.is_some());
        let around = view.environment.as_ref().filter(|_| known);
        self.find_by(GeometrySettings {
            mirrored: around.is_some(),
            lamps: view.has_lamps(),
            ..self.geometry.settings
        })?;
        let shown = view.background();
        if shown.is_some() && self.around.is_none() {
            let depth_format = self.geometry.settings.depth_format();
            self.around = Some(AroundPass::new(&self.device, &self.objects[0].frame, depth_format)?);
            self.point_around();
        }
        let Some(environment) = around.or(shown) else { return Ok(0.0) };
        let Some((first, others)) = self.objects.split_first_mut() else { return Ok(0.0) };
        let unit = first.frame.surround(&self.device, environment)?;
        others.iter_mut().for_each(|object| object.frame.share_surroundings(&first.frame));
        Ok(unit)
    }

    /// Points what displays the surroundings at the images of the pictures.
    fn point_around(&self) {
        if let Some(around) = &self.around {
            let sum =
                self.accumulation.as_ref().map_or(&self.target.radiance, |accumulation| &accumulation.sum);
            around.read_from(sum);
        }
    }

    fn find_by(&mut self, settings: GeometrySettings) -> Result<()> {
        if settings == self.geometry.settings {
            return Ok(());
        }
        if self.shows == Content::Sample {
            self.shows = Content::Nothing;
        }
        self.find_anew(self.target.size(), settings)
    }

    /// Nothing that was drawn is shown or added to from now on.
    fn forget(&mut self) {
        self.shows = Content::Nothing;
        self.summed = None;
        self.found = None;
    }

    /// Shades the first object by `shading` from now on, from `source`, as [`Self::shade_objects_by`].
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn shade_by(&mut self, source: &Source, shading: &Shading) -> Result<()> {
        self.shade_objects_by([&ObjectSources::new(source.clone(), shading.clone())])
    }

    /// Shades the objects from `sources` from now on, the data of which the painter has: what depends on the index, the illuminant or the number of
    /// copies is uploaded, and the rest stays.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn shade_objects_by<'a>(
        &mut self,
        sources: impl IntoIterator<Item = &'a ObjectSources>,
    ) -> Result<()> {
        self.forget();
        let settings = self.geometry.settings;
        let sources = sources.into_iter().flat_map(ObjectSources::all);
        for (own, ObjectSource { source, shading }) in self.shadings.iter_mut().zip(sources) {
            source.rebind(&self.device, &mut own.source, shading)?;
            if own.illuminant != shading.illuminant {
                own.illuminant.clone_from(&shading.illuminant);
                own.white = white_of(&shading.illuminant);
            }
            own.pass.parts = own.source.parts(settings.mirrored);
        }
        Ok(())
    }

    /// Draws one sample of `view` at the centres of pixels, displays it without a tone and leaves the result on the device.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<()> {
        self.draw_sample(view, &Sampling::ONE.sample(0), Shown::plain(exposure, background))
    }

    /// Draws `sample` alone of `view`, under all lights, displayed as `shown` says.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw_sample(&mut self, view: &View, sample: &Sample, shown: Shown) -> Result<()> {
        let drawn =
            Drawn { view, size: self.target.size(), passes: &all_lights(view.light_count(), *sample) };
        self.draw_whole(drawn, Finish::Display(shown))
    }

    /// Draws one sample of `view` with `size` pixels, at most those of the pictures, in pieces of some ten milliseconds each, between which
    /// others get the device. `go_on` is asked before each piece, with the part of the picture that is drawn; where it says no, the former display stays. Milliseconds
    /// that the device took, or `None` for a picture that was given up.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw_while(
        &mut self,
        view: &View,
        shown: Shown,
        size: [u32; 2],
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<f64>> {
        let drawn = Drawn { view, size, passes: &all_lights(view.light_count(), Sampling::ONE.sample(0)) };
        let times = self.draw_tiles(drawn, Finish::Display(shown), go_on)?;
        Ok(times.map(|times| times.total()))
    }

    /// Parts of the sum of a pixel.
    fn parts(&self) -> u32 {
        self.shadings.iter().map(|own| own.pass.parts).max().unwrap_or(1)
    }

    /// Draws `drawn` pass by pass, each at once.
    fn draw_whole(&mut self, drawn: Drawn<'_>, finish: Finish) -> Result<()> {
        for number in 0..drawn.passes.len() {
            self.write(drawn.view, drawn.size, &drawn.passes[number])?;
            let piece = Piece::whole(drawn.size, self.parts());
            self.submit(drawn, number, piece, finish)?;
        }
        Ok(())
    }

    /// Draws `drawn` pass by pass in pieces, as [`Self::draw_while`] says; what that took.
    fn draw_tiles(
        &mut self,
        drawn: Drawn<'_>,
        finish: Finish,
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<DrawTimes>> {
        let Drawn { view, size, passes } = drawn;
        let count = passes.len() as f64;
        let mut total = DrawTimes::default();
        for (number, pass) in passes.iter().enumerate() {
            self.write(view, size, pass)?;
            let surrounded = self.geometry.settings.mirrored;
            let iterations = |own: &ObjectShading| own.source.iterations_of_pixel(surrounded);
            let iterations = self.shadings.iter().map(iterations).max().unwrap_or(0);
            let mut tiles = Tiles::new(size, self.pixel_time, iterations, self.parts());
            loop {
                let done = (number as f64 + tiles.drawn()) / count;
                let Some(piece) = tiles.next_piece() else { break };
                if !go_on(done) {
                    return Ok(None);
                }
                let times = self.submit(drawn, number, piece, finish)?;
                tiles.took(times.shading);
                total.add(times);
            }
        }
        self.pixel_time = Some(total.shading / (count * f64::from(size[0]) * f64::from(size[1])));
        Ok(Some(total))
    }

    /// Shows what was drawn last at another exposure, by another tone or before another background; false where there is nothing whole.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn display_again(&mut self, size: [u32; 2], shown: Shown) -> Result<bool> {
        self.write_shown()?;
        let target = &self.target;
        let frame = &self.objects[0].frame.descriptors;
        let (around, written) = (self.around.as_ref(), self.written.as_ref());
        let display = Display::new((&self.geometry, target), &self.display, around, frame, written);
        let sum = self.accumulation.as_ref().zip(self.summed.as_ref());
        match self.shows {
            Content::Nothing | Content::PictureArea => return Ok(false),
            Content::Sample => self.commands.run(|record| {
                record.images(&[(&target.radiance, Access::ShaderRead, Access::ColorAttachment)]);
                let all = record.within(size, 0..size[1]);
                record_display(&all, target, |all| display.sample(all, shown));
                Ok(())
            })?,
            Content::Mean => self.commands.run(|record| {
                let all = record.within(size, 0..size[1]);
                if let Some((accumulation, summed)) = sum {
                    record_display(&all, target, |all| {
                        display.mean(all, accumulation, summed.samples, shown);
                    });
                }
                Ok(())
            })?,
        }
        Ok(true)
    }

    /// Draws a `piece` of pass number `number`, which was written: with the first goes the geometry, with the last what adds the pass, and with the last of
    /// all the rest of the `finish`.
    fn submit(&mut self, drawn: Drawn<'_>, number: usize, piece: Piece, finish: Finish) -> Result<DrawTimes> {
        let Drawn { view, size, passes } = drawn;
        let pass = passes[number];
        let (first, last) = (piece.is_first(), piece.is_last(size, self.parts()));
        // Passes that are added are pictures of their own; others add up.
        let is_new = number == 0 || matches!(finish, Finish::Add { .. });
        let finishes = last && number + 1 == passes.len();
        let Piece { tile, parts } = piece;
        let (geometry, target) = (&self.geometry, &self.target);
        let accumulation = &self.accumulation;
        let objects = &self.objects;
        let frame = &self.objects[0].frame.descriptors;
        let (around, written) = (self.around.as_ref(), self.written.as_ref());
        let mirrored = self.mirrors(view, &pass);
        let shaded = shaded(&self.shadings, objects, view, &pass, mirrored);
        let display = Display::new((geometry, target), &self.display, around, frame, written);
        if self.shows == Content::Sample {
            self.shows = Content::Nothing;
        }
        if first {
            self.found = None;
        }
        self.commands.run(|record| {
            let (all, some) = (record.within(size, 0..size[1]), record.tile(size, tile));
            record.reset(&self.timestamps);
            record.timestamp(&self.timestamps, 0);
            if first {
                self.find.record(&all, geometry, objects, mirrored);
            }
            record.timestamp(&self.timestamps, 1);
            if first && is_new {
                begin_shading(&some, target);
            }
            let begins = is_new && parts.start == 0;
            record_shading(&some, (geometry, target), &shaded, parts, begins);
            record.timestamp(&self.timestamps, 2);
            match (finish, accumulation) {
                (Finish::Add { before, samples, shown }, Some(accumulation)) if last => {
                    let weights = pass.sample.weights();
                    let (passes, first) = (passes.len(), before == 0);
                    accumulation.record(
                        &all,
                        target,
                        Addition { weights, size, pass: number, passes, first },
                    );
                    if let Some(shown) = shown.filter(|_| finishes) {
                        record_display(&all, target, |all| {
                            display.mean(all, accumulation, before + samples, shown);
                        });
                    }
                }
                (Finish::Display(shown), _) if finishes => {
                    record_display(&all, target, |all| display.sample(all, shown));
                }
                _ => {}
            }
            record.timestamp(&self.timestamps, 3);
            Ok(())
        })?;
        if first {
            self.found = self.written.clone();
        }
        if finishes {
            self.shows = match finish {
                Finish::Display(_) => Content::Sample,
                Finish::Add { shown: Some(_), .. } => Content::Mean,
                Finish::Add { shown: None, .. } => Content::Nothing,
            };
        } else if self.shows != Content::Mean {
            self.shows = Content::PictureArea;
        }
        let times = self.timestamps.intervals()?;
        Ok(DrawTimes { geometry: times[0], shading: times[1], finish: times[2] })
    }

    /// Whether the light of `pass` is drawn from the surroundings of `view`, whose specular order is mirrored.
    fn mirrors(&self, view: &View, pass: &LightPass) -> bool {
        self.geometry.settings.mirrored && view.is_surroundings(pass.light)
    }

    /// What draws them.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The images of the pictures.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// What each of their pixels sees.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// f·cos θ_i \[sr⁻¹\] of single directions, as [`super::evaluator::Evaluator::cosine_weighted`].
    ///
    /// # Errors
    /// Where the device is lost or has no room.
    pub fn cosine_weighted(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        let asker = match &mut self.asker {
            Some(asker) => asker,
            none => none.insert(Asker::new(&self.device, &self.shadings[0].source)?),
        };
        asker.ask(&self.shadings[0].source, queries)
    }

    /// Milliseconds in which the device reads `samples` bilinear samples per pixel of its texture with nothing else to do: what
    /// it could reach, with neighbours for neighbouring pixels or, `scattered`, with a place of its own for each pixel.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn probe(&mut self, samples: u32, scattered: bool) -> Result<f64> {
        let probe = Probe { samples, scattered: scattered.into() };
        let pass =
            PixelPass::probe(&self.device, &self.objects[0].frame.descriptors, &self.shadings[0].source)?;
        self.forget();
        let target = &self.target;
        let sets = [&self.objects[0].frame.descriptors, &self.shadings[0].source.descriptors];
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            self.commands.run(|record| {
                record.reset(&self.timestamps);
                record.timestamp(&self.timestamps, 0);
                pass.record_probe(record, target, sets, probe);
                (1..4).for_each(|stamp| record.timestamp(&self.timestamps, stamp));
                Ok(())
            })?;
            best = best.min(self.timestamps.intervals()?[0]);
        }
        Ok(best)
    }

    /// Draws one sample of `view` at the centres of pixels, displays it without a tone and reads the picture back.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn paint(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<Picture> {
        self.draw(view, exposure, background)?;
        self.picture()
    }

    /// Reads back what was drawn last, in the size of the pictures. Where that was given up, it has no radiance and the former display.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        let sum = self.accumulation.as_ref().zip(self.summed.as_ref());
        let radiance = match sum.filter(|_| self.shows == Content::Mean) {
            Some((accumulation, summed)) => {
                let mut sum = self.read(&accumulation.sum, PictureArea::All)?;
                let samples = summed.samples as f32;
                sum.iter_mut().flatten().for_each(|x| *x /= samples);
                sum
            }
            None if self.shows == Content::PictureArea => {
                let [width, height] = self.target.size();
                vec![[0.0; 4]; width as usize * height as usize]
            }
            None => self.read(&self.target.radiance, PictureArea::All)?,
        };
        let display = target::read_back(&self.device, &self.target.display, Access::ShaderRead)?;
        let view = match self.shows {
            Content::Sample => self.found.as_ref().map(|found| &found.view),
            Content::Mean => self.summed.as_ref().map(|summed| &summed.view),
            Content::Nothing | Content::PictureArea => None,
        };
        Ok(Picture {
            size: self.target.size(),
            radiance,
            display: bytemuck::pod_collect_to_vec(&display),
            surrounded: view.is_some_and(|view| view.background().is_some()),
        })
    }

    /// Writes the `Frame` block of `view` for a `pass` in pictures of `size`.
    fn write(&mut self, view: &View, size: [u32; 2], pass: &LightPass) -> Result<()> {
        let unit = self.surround(view)?;
        let mut block = view.block(size, pass);
        block.surroundings[2] *= unit;
        let first = self.shadings.iter().filter(|shading| shading.is_first);
        for (object, shading) in self.objects.iter_mut().zip(first) {
            let own = object.block(block, shading.specular_spread.unwrap_or_default());
            object.frame.write(&own)?;
        }
        self.find.select_shadow(&self.device, &self.objects, pass.light, &block)?;
        self.written = Some(Written { view: view.clone(), pass: *pass, size });
        Ok(())
    }

    /// Writes the `Frame` block of what is shown, where that of a picture that was given up took its place.
    fn write_shown(&mut self) -> Result<()> {
        let shown = match self.shows {
            Content::Nothing | Content::PictureArea => None,
            Content::Sample => self.found.clone(),
            Content::Mean => self.summed.as_ref().map(samples::Summed::first),
        };
        match shown.filter(|shown| self.written.as_ref() != Some(shown)) {
            Some(Written { view, pass, size }) => self.write(&view, size, &pass),
            None => Ok(()),
        }
    }
}

/// The `objects` as `shadings` shade them in a `pass` of `view`, whose light is drawn from surroundings whose specular order is `mirrored` or is another.
fn shaded<'a>(
    shadings: &'a [ObjectShading],
    objects: &'a [DeviceObject],
    view: &View,
    pass: &LightPass,
    mirrored: bool,
) -> Vec<ShadedObject<'a>> {
    let lit = shadings.iter().filter(|own| shades(own, shadings, view.illuminant(pass.light)));
    lit.map(|own| own.of(objects, mirrored, pass.is_first)).collect()
}

/// Whether `own`, one of `shadings`, shades its object under a light of this `illuminant`: where it has the same; where no shading of the object has
/// it, or the light has none of its own, if it is the object's first.
fn shades(own: &ObjectShading, shadings: &[ObjectShading], illuminant: Option<&Illuminant>) -> bool {
    let mut of_object = shadings.iter().filter(|other| other.object == own.object);
    match illuminant {
        Some(illuminant) if of_object.any(|other| other.illuminant == *illuminant) => {
            *illuminant == own.illuminant
        }
        _ => own.is_first,
    }
}

/// Records with `display` what draws into the display, which a window may be showing, and leaves it readable.
fn record_display(record: &Recorder<'_>, target: &Target, display: impl FnOnce(&Recorder<'_>)) {
    record.memory(Access::ShaderRead, Access::ColorAttachment);
    display(record);
    record.images(&[(&target.display, Access::ColorAttachment, Access::ShaderRead)]);
}
