//! Offscreen picture, as written by `diffract render`.

use super::evaluator::{Query, QueryPass};
use super::frame::{Shown, View};
use super::frame_set::LIGHT_SLOTS;
use super::gbuffer::{GBuffer, GBufferSettings};
use super::light_passes::LightPass;
use super::object::{DeviceObject, ObjectData, ObjectSource, ObjectSources};
use super::passes::accumulate::{Accumulation, Addition};
use super::passes::background::BackgroundPass;
use super::passes::display::DisplayPass;
use super::passes::geometry::GeometryPass;
use super::passes::light_directions::LightDirections;
use super::passes::probe::{Probe, ProbePass};
use super::passes::shade;
use super::passes::shadow::{ShadowPass, WantedMaps};
use super::source::Source;
use super::target::{self, Target};
use crate::error::{Error, Result};
use crate::settings::Optics;
use crate::task::{PIECES, Task};
use crate::vk::access::Access;
use crate::vk::commands::{Commands, Recorder};
use crate::vk::device::Device;
use crate::vk::queries::Timestamps;
use glam::DVec3;
use std::sync::Arc;

mod display;
mod in_flight;
mod read_back;
mod samples;
mod shadings;
mod tiles;
pub mod timing;

use display::Display;
use in_flight::{Finished, InFlight};
pub use samples::{PictureProgress, PictureRequest};

use shadings::Shadings;
use tiles::{Piece, Tiles};
use timing::DrawTimes;

/// Draws pictures of one object or of several.
pub struct Renderer {
    commands: Commands,
    in_flight: InFlight,
    geometry_pass: GeometryPass,
    // Present if the objects cast shadows.
    shadow_pass: Option<ShadowPass>,
    // At least one.
    objects: Vec<DeviceObject>,
    shadings: Shadings,
    gbuffer: GBuffer,
    display: DisplayPass,
    target: Target,
    timestamps: Timestamps,
    query_pass: Option<QueryPass>,
    // Milliseconds per shaded pixel of the last picture that was drawn in tiles.
    pixel_time: Option<f64>,
    // Content of the displayed image.
    shows: Content,
    // Made for the first picture of several samples.
    accumulation: Option<Accumulation>,
    // Made for the first picture that shows its surroundings.
    background: Option<BackgroundPass>,
    // Made for the first read-back.
    light_directions: Option<LightDirections>,
    // Settings of the samples in the sum.
    summed: Option<samples::Summed>,
    // Settings of the `Frame` block, and of the last draw that used the G-buffer.
    block_input: Option<PassInput>,
    image_input: Option<PassInput>,
    device: Arc<Device>,
}

/// Settings of a renderer, which hold for all of its pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RendererSettings {
    /// True if the objects cast shadows on themselves and on each other.
    pub shadows: bool,
    /// Variance of (u, v) of the specular order in [`Directions::mirrored`](super::directions::Directions::mirrored), in
    /// place of that of the sources. Sources without a separate specular order mirror nothing by default.
    pub specular_spread: Option<f64>,
}

/// Input of a pass: view, light and sample.
#[derive(Clone, PartialEq)]
struct PassInput {
    view: View,
    pass: LightPass,
    size: [u32; 2],
}

impl PassInput {
    /// Returns true if pixels see the same surface points, whatever the lights.
    fn sees_the_same_as(&self, other: &Self) -> bool {
        let sample = |input: &Self| (input.pass.sample.jitter, input.pass.sample.footprint);
        self.size == other.size && sample(self) == sample(other) && self.view.sees_the_same_as(&other.view)
    }
}

/// View, size and passes to draw into the radiance.
#[derive(Clone, Copy)]
struct DrawRequest<'a> {
    view: &'a View,
    size: [u32; 2],
    /// Passes to draw one after the other; at least one.
    passes: &'a [LightPass],
}

/// Content of the images for display and read-back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// Nothing: the radiance belongs to no picture, or to parts of several.
    Nothing,
    /// Nothing yet: the radiance holds a part of a picture, and more tiles may follow.
    PictureArea,
    /// One sample, in the radiance.
    Sample,
    /// Mean of the summed samples.
    Mean,
}

/// Step after the last piece.
#[derive(Clone, Copy)]
enum FinalStep {
    /// Display the radiance.
    Display(Shown),
    /// Add each pass, a picture in itself, to the sum of `before` samples. All passes together are `samples` samples.
    /// If `shown` is given, display the mean of all.
    Add { before: u32, samples: u32, shown: Option<Shown> },
}

/// Finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Linear radiance, signed, RGBA, row by row from the top. Alpha is the fraction of the samples in which an object
    /// covers the pixel; colours are premultiplied by alpha.
    pub radiance: Vec<[f32; 4]>,
    /// Displayed picture, sRGB-encoded opaque RGBA, over the background.
    pub display: Vec<[u8; 4]>,
    /// True if the background is part of the picture: surroundings, or a background that was asked for.
    pub is_opaque: bool,
}

impl Renderer {
    /// Uploads everything for pictures of `objects`, `size` pixels large. Single directions are evaluated by the source of the first object.
    ///
    /// # Errors
    /// Fails if the device is out of memory, or if there is no object.
    pub fn new(
        device: &Arc<Device>,
        objects: &[ObjectData<'_>],
        size: [u32; 2],
        settings: RendererSettings,
    ) -> Result<Self> {
        if objects.is_empty() {
            return Err(Error::bug("there is no object"));
        }
        let bind = |of: &'_ ObjectSource| of.source.bind(device, &of.optics);
        let mut sources = Vec::with_capacity(objects.len());
        for object in objects {
            sources.push(object.sources.all().map(bind).collect::<Result<Vec<_>>>()?);
        }
        let gbuffer_settings = GBufferSettings {
            textured: objects.iter().any(|object| object.pigment.is_textured()),
            several: objects.len() > 1,
        };
        let gbuffer = GBuffer::new(device, size, gbuffer_settings)?;
        let target = Target::new(device, size)?;
        let display = DisplayPass::new(device, target::DISPLAY, gbuffer_settings.depth_format())?;
        display.read_from(&target.radiance);
        let mut shadings = Shadings::new(settings.shadows);
        for (number, (object, bound)) in objects.iter().zip(sources).enumerate() {
            let illuminants = object.sources.all().map(|of| &of.optics.illuminant);
            shadings.add(number, bound.into_iter().zip(illuminants), settings.specular_spread);
        }
        let upload = |object: &ObjectData<'_>| DeviceObject::new(device, object, &gbuffer);
        let objects = objects.iter().map(upload).collect::<Result<Vec<_>>>()?;
        let shadow_pass = settings.shadows.then(|| ShadowPass::new(device, &objects)).transpose()?;
        Ok(Self {
            commands: Commands::new(device, "frame")?,
            in_flight: InFlight::new(device)?,
            geometry_pass: GeometryPass::new(device, &objects, &gbuffer)?,
            shadow_pass,
            shadings,
            objects,
            gbuffer,
            display,
            target,
            timestamps: Timestamps::new(device, 4)?,
            query_pass: None,
            pixel_time: None,
            shows: Content::Nothing,
            accumulation: None,
            background: None,
            light_directions: None,
            summed: None,
            block_input: None,
            image_input: None,
            device: device.clone(),
        })
    }

    /// Sets the size of the following pictures \[pixels\].
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        if self.target.size() == size && self.gbuffer.size() == size {
            return Ok(());
        }
        self.invalidate();
        let gbuffer = GBuffer::new(&self.device, size, self.gbuffer.settings)?;
        self.objects.iter().for_each(|object| object.frame.read_from(&gbuffer));
        (self.gbuffer, self.light_directions) = (gbuffer, None);
        self.target = Target::new(&self.device, size)?;
        self.display.read_from(&self.target.radiance);
        if let Some(mut accumulation) = self.accumulation.take() {
            accumulation.resize(&self.device, &self.target)?;
            self.accumulation = Some(accumulation);
        }
        self.bind_background();
        Ok(())
    }

    /// Sets the surroundings of the following frames to those of `view`, if they are shown or mirrored. Returns the
    /// radiance of a stored 1 of the uploaded picture.
    fn bind_environment(&mut self, view: &View) -> Result<f32> {
        let shown = view.background();
        if shown.is_some() && self.background.is_none() {
            let depth_format = self.gbuffer.settings.depth_format();
            self.background = Some(BackgroundPass::new(&self.device, &self.objects[0].frame, depth_format)?);
            self.bind_background();
        }
        let mirrored = view.environment.as_ref().filter(|_| self.shadings.mirrors_surroundings());
        let Some(environment) = mirrored.or(shown) else { return Ok(0.0) };
        let Some((first, others)) = self.objects.split_first_mut() else { return Ok(0.0) };
        let unit = first.frame.bind_environment(&self.device, environment)?;
        others.iter_mut().for_each(|object| object.frame.share_surroundings(&first.frame));
        Ok(unit)
    }

    /// Points the background pass at the foreground it draws behind.
    fn bind_background(&self) {
        if let Some(background) = &self.background {
            let sum =
                self.accumulation.as_ref().map_or(&self.target.radiance, |accumulation| &accumulation.sum);
            background.read_from(sum);
        }
    }

    /// Marks the displayed picture and the sum as invalid.
    fn invalidate(&mut self) {
        self.shows = Content::Nothing;
        self.summed = None;
        self.image_input = None;
    }

    /// Sets the source of the first object and its optics, as [`Self::set_sources`].
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn set_source(&mut self, source: &Source, optics: &Optics) -> Result<()> {
        self.set_sources([&ObjectSources::new(source.clone(), optics.clone())])
    }

    /// Sets the sources of the objects. Their large data must be uploaded already; only the parts that depend on the
    /// index, the illuminant or the number of copies are uploaded.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn set_sources<'a>(&mut self, sources: impl IntoIterator<Item = &'a ObjectSources>) -> Result<()> {
        self.invalidate();
        self.pixel_time = None;
        self.shadings.rebind(&self.device, sources.into_iter().flat_map(ObjectSources::all))
    }

    /// Draws `drawn` pass by pass in pieces, as [`Self::draw`] describes. Returns the device time.
    ///
    /// # Errors
    /// Fails if the device is lost, or if the task is cancelled.
    fn draw_tiles(&mut self, drawn: DrawRequest<'_>, finish: FinalStep, task: &Task) -> Result<DrawTimes> {
        let DrawRequest { view, size, passes } = drawn;
        let count = passes.len() as f64;
        let pixels = size[0] as usize * size[1] as usize;
        let mut total = DrawTimes::default();
        for (number, pass) in passes.iter().enumerate() {
            self.write(view, size, pass)?;
            let (iterations, parts) = (self.shadings.iterations(view, pass), self.shadings.parts(view, pass));
            let mut tiles = Tiles::new(size, self.pixel_time, iterations, parts);
            loop {
                let done = ((number as f64 + tiles.drawn()) * pixels as f64) as usize;
                let Some(piece) = tiles.next_piece() else { break };
                if let Err(cancelled) = task.report(PIECES, done, passes.len() * pixels) {
                    self.in_flight.finish()?;
                    return Err(cancelled);
                }
                if let Some(Finished { pixels, times }) = self.submit(drawn, number, piece, finish)? {
                    tiles.took(pixels, times.shading);
                    total.add(times);
                }
            }
            self.in_flight.finish()?.into_iter().for_each(|finished| total.add(finished.times));
        }
        self.pixel_time = Some(total.shading / (count * f64::from(size[0]) * f64::from(size[1])));
        Ok(total)
    }

    /// Displays the last picture with other settings; returns false if there is no complete picture.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn display(&mut self, size: [u32; 2], shown: Shown) -> Result<bool> {
        self.write_shown()?;
        let target = &self.target;
        let frame = &self.objects[0].frame.descriptors;
        let (background, block_input) = (self.background.as_ref(), self.block_input.as_ref());
        let display = Display::new((&self.gbuffer, target), &self.display, background, frame, block_input);
        match self.shows {
            Content::Nothing | Content::PictureArea => return Ok(false),
            Content::Sample => self.commands.run(|record| {
                record.images(&[(&target.radiance, Access::ShaderRead, Access::ColorAttachment)]);
                let all = record.within(size, 0..size[1]);
                record_display(&all, target, |all| display.sample(all, shown));
                Ok(())
            })?,
            Content::Mean => {
                let sum = self.accumulation.as_ref().zip(self.summed.as_ref());
                let (accumulation, summed) =
                    sum.ok_or_else(|| Error::bug("a mean is displayed that has no samples"))?;
                self.commands.run(|record| {
                    let all = record.within(size, 0..size[1]);
                    record_display(&all, target, |all| {
                        display.mean(all, accumulation, summed.samples, shown);
                    });
                    Ok(())
                })?
            }
        }
        Ok(true)
    }

    /// Draws a `piece` of pass number `number`, whose `Frame` block is written. The first piece of a pass includes the
    /// depth from its light and the G-buffer, unless they are up to date, the last piece of a pass its addition, and the
    /// last piece of all the remaining steps of `finish`. Returns the piece before the last one, which has finished.
    fn submit(
        &mut self,
        drawn: DrawRequest<'_>,
        number: usize,
        piece: Piece,
        finish: FinalStep,
    ) -> Result<Option<Finished>> {
        let DrawRequest { view, size, passes } = drawn;
        let pass = &passes[number];
        let (first, last) = (piece.is_first(), piece.is_last(size, self.shadings.parts(view, pass)));
        // Added passes are pictures in themselves; others accumulate in the radiance.
        let is_new = number == 0 || matches!(finish, FinalStep::Add { .. });
        let finishes = last && number + 1 == passes.len();
        let Piece { tile, parts, pixels } = piece;
        let is_stale = first && !self.gbuffer_is_current();
        let (gbuffer, target) = (&self.gbuffer, &self.target);
        let accumulation = &self.accumulation;
        if matches!(finish, FinalStep::Add { .. }) && accumulation.is_none() {
            return Err(Error::bug("there is no sum to which a sample can be added"));
        }
        let objects = &self.objects;
        let frame = &self.objects[0].frame.descriptors;
        let (background, block_input) = (self.background.as_ref(), self.block_input.as_ref());
        let shaded = self.shadings.draws(objects, view, pass);
        let display = Display::new((gbuffer, target), &self.display, background, frame, block_input);
        if self.shows == Content::Sample {
            self.shows = Content::Nothing;
        }
        if is_stale {
            self.image_input = None;
        }
        let finished = self.in_flight.submit(pixels, |record, stamps| {
            let (all, some) = (record.within(size, 0..size[1]), record.tile(size, tile));
            record.timestamp(stamps, 0);
            if let Some(shadow_pass) = self.shadow_pass.as_ref().filter(|_| first) {
                shadow_pass.record(&all, objects);
            }
            if is_stale {
                self.geometry_pass.record(&all, gbuffer, objects);
            }
            record.timestamp(stamps, 1);
            if first && is_new {
                shade::begin(&some, target);
            }
            let begins = is_new && parts.start == 0;
            shade::record(&some, (gbuffer, target), &shaded, parts, begins);
            record.timestamp(stamps, 2);
            match (finish, accumulation) {
                (FinalStep::Add { before, samples, shown }, Some(accumulation)) if last => {
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
                (FinalStep::Display(shown), _) if finishes => {
                    record_display(&all, target, |all| display.sample(all, shown));
                }
                _ => {}
            }
            record.timestamp(stamps, 3);
        })?;
        if first {
            self.image_input = self.block_input.clone();
        }
        if finishes {
            self.shows = match finish {
                FinalStep::Display(_) => Content::Sample,
                FinalStep::Add { shown: Some(_), .. } => Content::Mean,
                FinalStep::Add { shown: None, .. } => Content::Nothing,
            };
        } else if self.shows != Content::Mean {
            self.shows = Content::PictureArea;
        }
        Ok(finished)
    }

    /// Returns true if the G-buffer holds the surfaces that the written `Frame` block describes.
    fn gbuffer_is_current(&self) -> bool {
        let inputs = self.image_input.as_ref().zip(self.block_input.as_ref());
        inputs.is_some_and(|(found, wanted)| found.sees_the_same_as(wanted))
    }

    /// Returns the device that draws.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the images of the pictures.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// Returns f·cos θ_i \[sr⁻¹\] of single directions, as [`super::evaluator::Evaluator::cosine_weighted`].
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory.
    pub fn cosine_weighted(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        let query_pass = match &mut self.query_pass {
            Some(query_pass) => query_pass,
            none => none.insert(QueryPass::new(&self.device, self.shadings.first_source())?),
        };
        query_pass.ask(self.shadings.first_source(), queries, 0.0)
    }

    /// Returns the milliseconds in which the device reads `samples` bilinear samples per pixel of its texture and does
    /// nothing else: the lower bound of a frame. Neighbouring pixels read neighbouring texels, or, if `scattered`, each
    /// pixel reads at a random place.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn probe(&mut self, samples: u32, scattered: bool) -> Result<f64> {
        let probe = Probe { samples, scattered: scattered.into() };
        let pass =
            ProbePass::new(&self.device, &self.objects[0].frame.descriptors, self.shadings.first_source())?;
        self.invalidate();
        let target = &self.target;
        let sets = [&self.objects[0].frame.descriptors, &self.shadings.first_source().descriptors];
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            self.commands.run(|record| {
                record.reset(&self.timestamps);
                record.timestamp(&self.timestamps, 0);
                pass.record(record, target, sets, probe);
                (1..4).for_each(|stamp| record.timestamp(&self.timestamps, stamp));
                Ok(())
            })?;
            best = best.min(self.timestamps.intervals()?[0]);
        }
        Ok(best)
    }

    /// Returns true if the images hold a picture for display and read-back: not a part of one that was abandoned.
    pub fn has_picture(&self) -> bool {
        matches!(self.shows, Content::Sample | Content::Mean)
    }

    /// Writes the `Frame` block of `view` for a `pass` in pictures of `size` pixels.
    fn write(&mut self, view: &View, size: [u32; 2], pass: &LightPass) -> Result<()> {
        self.block_input = None; // in case of an error
        let unit = self.bind_environment(view)?;
        let mut block = view.block(size, pass);
        block.surroundings[2] *= unit;
        for (number, (object, shading)) in self.objects.iter_mut().zip(self.shadings.defaults()).enumerate() {
            let spread = shading.specular_spread.unwrap_or_default();
            let block = object.block(block, view.base_color(number), spread);
            object.frame.write(&block)?;
        }
        if let Some(shadow_pass) = &mut self.shadow_pass {
            let chosen = pass.choices.is_some();
            let places = if chosen {
                (0..LIGHT_SLOTS).collect()
            } else {
                pass.numbers().map(|n| pass.place_of(n)).collect::<Vec<_>>()
            };
            let maps =
                places.into_iter().map(|place| (place, block.lights[place].shadow_from_world)).collect();
            let sphere = view.shadow_sphere(size);
            let side = if chosen { sphere.side_of_many() } else { sphere.side() };
            shadow_pass.select(&self.device, &self.objects, WantedMaps { chosen, side, maps })?;
        }
        self.shadings.prepare(&self.device, &self.objects, self.gbuffer.settings, (view, pass))?;
        self.block_input = Some(PassInput { view: view.clone(), pass: *pass, size });
        Ok(())
    }

    /// Restores the `Frame` block of the displayed picture after an abandoned draw.
    fn write_shown(&mut self) -> Result<()> {
        let shown = match self.shows {
            Content::Nothing | Content::PictureArea => None,
            Content::Sample => self.image_input.clone(),
            Content::Mean => self.summed.as_ref().map(samples::Summed::first),
        };
        match shown.filter(|shown| self.block_input.as_ref() != Some(shown)) {
            Some(PassInput { view, pass, size }) => self.write(&view, size, &pass),
            None => Ok(()),
        }
    }
}

/// Records `display`, which draws into the displayed image that a window may be showing, and makes the image readable
/// by shaders again.
fn record_display(record: &Recorder<'_>, target: &Target, display: impl FnOnce(&Recorder<'_>)) {
    record.memory(Access::ShaderRead, Access::ColorAttachment);
    display(record);
    record.images(&[(&target.display, Access::ColorAttachment, Access::ShaderRead)]);
}
