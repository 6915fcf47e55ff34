//! Resources of the render thread: a renderer for each setting, and results that are kept between frames.

use super::compare::{Compare, Side};
use super::difference;
use super::error_probe::{self, ProbeTask};
use super::frame::{FrameRequest, LoadedScene, Pace, PictureCost, RenderedFrame};
use super::inset::{self, Inset, InsetRequest};
use super::inspector::reading::Reading;
use super::job_queue::{Job, JobQueue, PixelRequest, RenderReply, RenderWork};
use super::prepared::Prepared;
use super::quality::Quality;
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::render::exposure;
use crate::render::frame::{Shown, View};
use crate::render::object::objects;
use crate::render::renderer::{PictureRequest, Renderer, RendererSettings};
use crate::render::sampling::Sampling;
use crate::render::source::Source;
use crate::render::target;
use crate::render::upload;
use crate::task::{Progress, Task};
use crate::vk::device::Device;
use crate::vk::image::Image;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Renderer and the data it was made for.
struct Slot {
    renderer: Renderer,
    prepared: Arc<Prepared>,
    loaded: Arc<LoadedScene>,
    displayed: Option<Displayed>,
}

/// Contents of the displayed image of a renderer.
#[derive(Clone, PartialEq)]
struct Displayed {
    view: View,
    shown: Shown,
    size: [u32; 2],
    // A single sample, or the samples of the mean.
    sampling: Sampling,
}

impl Slot {
    /// Returns true if the textures of `prepared` and the scene of `request` are on the device already.
    fn serves(&self, prepared: &Prepared, request: &FrameRequest) -> bool {
        Arc::ptr_eq(&self.loaded, &request.loaded)
            && self
                .prepared
                .of_objects(self.objects())
                .zip(prepared.of_objects(self.objects()))
                .all(|(full, other)| full.shares_data_with(other))
    }

    /// Returns the number of objects of the scene.
    fn objects(&self) -> usize {
        self.loaded.textures.len()
    }

    /// Returns true if it shows `request`, as one sample or as a mean, so that samples can be added.
    fn is_ready_for(&self, request: &FrameRequest) -> bool {
        self.prepared.number == request.full.number
            && self.displayed.as_ref().is_some_and(|shown| {
                let FrameRequest { view, sampling, .. } = request;
                // The exposure is not compared: it may have been measured.
                let Displayed { view: seen, size, sampling: of, .. } = shown;
                (seen, *size) == (view, request.size) && [Sampling::ONE, *sampling].contains(of)
            })
    }

    /// Adds samples to the displayed `request` and shows the mean. Returns the number of samples.
    fn add_samples(&mut self, request: &FrameRequest, task: &Task) -> Result<u32> {
        let FrameRequest { view, sampling, size, .. } = request;
        let shown = self.displayed.as_ref().map_or(request.shown, |displayed| displayed.shown);
        let added =
            self.renderer.draw(&PictureRequest { view, sampling: *sampling, size: *size, shown }, task)?;
        self.displayed = Some(Displayed { view: view.clone(), shown, size: *size, sampling: *sampling });
        Ok(added.samples)
    }

    /// Shades with `prepared` from now on. The textures on the device stay; only the parts that depend on other
    /// settings are rebuilt.
    fn take_over(&mut self, prepared: &Arc<Prepared>) -> Result<()> {
        if self.prepared.number != prepared.number {
            self.displayed = None;
            self.renderer.set_sources(prepared.of_objects(self.loaded.textures.len()))?;
            self.prepared = prepared.clone();
        }
        Ok(())
    }
}

/// Time of a frame \[ms\]; 0 if only its display changed.
#[derive(Clone, Copy, Default)]
struct FrameTime {
    gpu: f64,
    wall: f64,
}

/// [`PictureCost`] and the picture it was counted for.
struct CountedPicture {
    number: u64,
    view: View,
    size: [u32; 2],
    cost: PictureCost,
}

/// State that the render thread keeps between frames.
pub struct FrameRenderer {
    full: Option<Slot>,
    other: Option<Slot>,
    // With the number of the setting it was computed for.
    inset: Option<(Arc<Inset>, u64)>,
    counted: Option<CountedPicture>,
    device: Arc<Device>,
}

/// Time between two progress reports of a picture \[ms\].
const BETWEEN_REPORTS: f64 = 250.0;
/// Time after which a frame of a moving scene is abandoned if there is a newer request and a lower resolution \[ms\].
const LONGEST_MOVING_FRAME: f64 = 400.0;

impl FrameRenderer {
    /// Makes the state before the first frame.
    pub fn new(device: Arc<Device>) -> Self {
        Self { full: None, other: None, inset: None, counted: None, device }
    }

    /// Works on the tasks of `queue` until it is stopped.
    pub fn run(mut self, queue: &Arc<JobQueue>, reply: &Arc<Receiver>) {
        while let Some(task) = queue.next() {
            let result = match task {
                RenderWork::Frame(request) => {
                    let drawn = unless_cancelled(self.draw(&request, queue, reply));
                    match drawn {
                        Ok(None) => queue.resume(request),
                        Ok(Some(RenderReply::Frame(_))) => go_on_with(request, queue),
                        _ => {}
                    }
                    drawn
                }
                RenderWork::Pixel(request) => self.read_pixel(request),
                RenderWork::Refine(request) => self.refine(request, queue),
                RenderWork::Job(job) => {
                    let done = unless_cancelled(self.perform(&job, queue, reply));
                    let done = match (done, &job) {
                        (Err(e), Job::Picture(_)) if !self.device.is_lost() => {
                            Ok(Some(RenderReply::Picture(Err(e))))
                        }
                        (done, _) => done,
                    };
                    match (&done, job) {
                        (Ok(None), job) => queue.put_back(job),
                        (_, Job::Picture(request) | Job::Samples(request)) => go_on_with(request, queue),
                    }
                    done
                }
            };
            match result {
                Ok(Some(done)) => reply(done),
                Ok(None) => {}
                Err(e) => reply(RenderReply::Failed(e)),
            }
        }
    }

    /// Draws `request` and reports progress to `reply` if it takes long. Work that a newer request replaces is cancelled.
    fn draw(
        &mut self,
        request: &FrameRequest,
        queue: &Arc<JobQueue>,
        reply: &Arc<Receiver>,
    ) -> Result<RenderReply> {
        let start = Instant::now();
        let (slot, prepared) = (&mut self.full, &request.full);
        let size = request.quality.size(request.size);
        let first = slot.as_ref().is_none_or(|slot| !slot.serves(prepared, request));
        let task = |side| frame_task(request, side, start, queue, reply);
        let mut time = match paint(&self.device, slot, prepared, request, size, &task(Side::Own)) {
            Err(e) if e.is_cancelled() && request.moving => {
                return Ok(RenderReply::TooSlow(request.quality, milliseconds_since(start)));
            }
            painted => painted?,
        };
        let measured = if request.measured { expose(slot, request.shown, size)? } else { None };
        let Some(left) = slot.as_ref().map(|s| s.renderer.target().display.clone()) else {
            return Err(Error::bug("there is no picture"));
        };
        let (mut right, mut difference) = (left.clone(), None);
        if let Some(other) = request.other.as_ref().filter(|_| request.compare != Compare::Alone) {
            let more = paint(&self.device, &mut self.other, other, request, size, &task(Side::Other))?;
            time = FrameTime { gpu: time.gpu + more.gpu, wall: time.wall + more.wall };
            if let Some((image, total)) = self.right_image(request, size)? {
                (right, difference) = (image, total);
            }
        } else {
            self.other = None;
        }
        let inset = request.inset.map(|wanted| self.hemisphere(request, wanted)).transpose()?.flatten();
        // A newer request counts its picture.
        let whole = request.quality == Quality::WHOLE && !queue.has_newer_frame();
        let cost = if whole { self.count(request)? } else { None };
        Ok(RenderReply::Frame(Box::new(RenderedFrame {
            images: [left, right],
            sizes: [size; 2],
            quality: request.quality,
            view: request.view.clone(),
            size: request.size,
            gpu_ms: time.gpu,
            wall_ms: time.wall,
            first,
            pace: if request.moving { Pace::Moving } else { Pace::AtRest },
            samples: 1,
            cost,
            exposure: measured,
            inset,
            difference,
            number: request.full.number,
        })))
    }

    /// Adds samples to the frame of `request`; `None` if it is no longer shown or was interrupted.
    fn refine(&mut self, request: FrameRequest, queue: &Arc<JobQueue>) -> Result<Option<RenderReply>> {
        let start = Instant::now();
        let Some(slot) = self.full.as_mut().filter(|slot| slot.is_ready_for(&request)) else {
            return Ok(None);
        };
        let task = Task::while_true({
            let queue = Arc::clone(queue);
            move |_| {
                queue.give_way();
                let pending = queue.pending();
                !pending.stop && pending.frame.is_none() && pending.pixel.is_none() && pending.jobs.is_empty()
            }
        });
        let Some(samples) = unless_cancelled(slot.add_samples(&request, &task))? else {
            queue.refine(request);
            return Ok(None);
        };
        let display = slot.renderer.target().display.clone();
        let frame = RenderedFrame {
            images: [display.clone(), display],
            sizes: [request.size; 2],
            quality: request.quality,
            view: request.view.clone(),
            size: request.size,
            gpu_ms: 0.0,
            wall_ms: start.elapsed().as_secs_f64() * 1e3,
            first: false,
            pace: Pace::AtRest,
            samples,
            cost: None,
            exposure: None,
            inset: None,
            difference: None,
            number: request.full.number,
        };
        if samples < request.sampling.count {
            queue.refine(request);
        }
        Ok(Some(RenderReply::Frame(Box::new(frame))))
    }

    /// Returns the image right of the split, of which `size` pixels are drawn: the picture of the other setting, or the
    /// difference of both with its value for the whole picture.
    fn right_image(
        &self,
        request: &FrameRequest,
        size: [u32; 2],
    ) -> Result<Option<(Arc<Image>, Option<f64>)>> {
        let (Some(full), Some(other)) = (&self.full, &self.other) else { return Ok(None) };
        let Compare::Difference(metric) = request.compare else {
            return Ok(Some((other.renderer.target().display.clone(), None)));
        };
        let [judged, judge] = [full.renderer.read_back()?, other.renderer.read_back()?];
        let map = difference::map(metric, &judged, &judge, request.shown, size);
        let (format, data) = (target::DISPLAY, bytemuck::cast_slice(&map.pixels));
        let size = size.map(|n| n as usize);
        let image = upload::texture(&self.device, "difference", format, size, None, data)?;
        Ok(Some((Arc::new(image), Some(map.total))))
    }

    /// Returns the hemisphere `wanted`, computed from a texture that is on the device already.
    fn hemisphere(&mut self, request: &FrameRequest, wanted: InsetRequest) -> Result<Option<Arc<Inset>>> {
        let number = request.full.number;
        if let Some((inset, of)) = &self.inset
            && (inset.request, *of) == (wanted, number)
        {
            return Ok(Some(inset.clone()));
        }
        let Some(slot) = self.full.as_mut().filter(|slot| slot.prepared.number == number) else {
            return Ok(None);
        };
        let inset = Arc::new(inset::hemisphere(&mut slot.renderer, wanted)?);
        self.inset = Some((inset.clone(), number));
        Ok(Some(inset))
    }

    /// Reads a pixel of a frame; `None` if the frame is not on the device.
    fn read_pixel(&mut self, request: PixelRequest) -> Result<Option<RenderReply>> {
        let PixelRequest { number, frame, at } = request;
        let is_there = |slot: &&mut Slot| {
            let shows = |shown: &Displayed| shown.view == frame.view && shown.size == frame.size;
            slot.prepared.number == frame.full.number && slot.displayed.as_ref().is_some_and(shows)
        };
        let Some(slot) = self.full.as_mut().filter(is_there) else { return Ok(None) };
        let pixel = slot.renderer.pixel(&frame.view, at)?;
        // The settings apply to the first object alone.
        let pixel = pixel.filter(|pixel| pixel.directions.iter().all(|seen| seen.object(0) == 0));
        let reading = pixel.map(|pixel| Box::new(Reading::new(number, frame.full, frame.view, pixel)));
        Ok(Some(RenderReply::Pixel(reading)))
    }

    /// Counts the cost of the whole picture, once per picture.
    fn count(&mut self, request: &FrameRequest) -> Result<Option<PictureCost>> {
        let (number, size) = (request.full.number, request.size);
        let known = self.counted.as_ref();
        if let Some(known) =
            known.filter(|c| c.number == number && c.view == request.view && c.size == request.size)
        {
            return Ok(Some(known.cost));
        }
        let Some(slot) = &mut self.full else { return Ok(None) };
        let pixels = size[0] as usize * size[1] as usize;
        let directions = error_probe::directions(&mut slot.renderer, &request.view)?;
        let (source, optics) = (request.full.source(), request.full.optics());
        let counted = match source {
            // The mip level of a table depends on the distance between neighbouring pixels, so that all pixels are
            // needed.
            Source::Table(_) => directions,
            _ => error_probe::thinned(&directions, pixels),
        };
        let cost = source.cost(optics, &counted);
        let seen = counted.first().map_or(1, |d| d.view.len()).max(1);
        let cost = PictureCost {
            covered: cost.covered as f64 / seen as f64,
            wavelengths: cost.wavelengths_per_pixel(),
            samples: cost.samples_per_pixel(),
        };
        self.counted = Some(CountedPicture { number, view: request.view.clone(), size, cost });
        Ok(Some(cost))
    }

    /// Does `job` and reports the progress of a picture to `reply`. A frame that the window waits for cancels it.
    fn perform(&mut self, job: &Job, queue: &Arc<JobQueue>, reply: &Arc<Receiver>) -> Result<RenderReply> {
        let (Job::Picture(request) | Job::Samples(request)) = job;
        // Errors are measured on a single sample.
        let sampling = if matches!(job, Job::Samples(_)) { Sampling::ONE } else { request.sampling };
        let watch = Reports::new(reply);
        let task = |samples: u32| {
            let (queue, watch, is_picture) =
                (Arc::clone(queue), watch.clone(), matches!(job, Job::Picture(_)));
            Task::while_true(move |progress| {
                if is_picture {
                    let part = (f64::from(samples) + fraction(progress)) / f64::from(sampling.count);
                    watch.tell(|| RenderReply::Saving(part as f32));
                }
                queue.give_way();
                !queue.interrupts_jobs()
            })
        };
        let drawn = FrameRequest { sampling, ..request.clone() };
        paint(&self.device, &mut self.full, &request.full, &drawn, request.size, &task(0))?;
        let Some(slot) = &mut self.full else {
            return Err(Error::bug("there is no picture"));
        };
        let done = match job {
            Job::Picture(request) => {
                let mut samples = 1;
                while samples < sampling.count {
                    samples = slot.add_samples(request, &task(samples))?;
                }
                let full = &request.full;
                let note = || {
                    let optics = full.optics();
                    let colour = LightColour::Spectrum(&optics.illuminant);
                    ScalarTheory::note(&full.field, &optics.reflectance, colour)
                };
                let scalar_theory =
                    full.scalar_theory.as_ref().map_or_else(note, |found| found.line().to_owned());
                let notes =
                    Notes::new(String::new(), full.field.prepared()).with_scalar_theory(scalar_theory);
                RenderReply::Picture(Ok((Box::new(slot.renderer.read_back()?), notes)))
            }
            Job::Samples(request) => RenderReply::Samples(Box::new(ProbeTask {
                samples: error_probe::samples(&mut slot.renderer, &request.view)?,
                prepared: request.full.clone(),
                view: request.view.clone(),
                exposure: request.shown.exposure,
            })),
        };
        Ok(done)
    }
}

/// Receiver of the replies of the render thread.
pub type Receiver = dyn Fn(RenderReply) + Send + Sync;

/// Replies about the progress of a picture, of which one in [`BETWEEN_REPORTS`] is sent.
#[derive(Clone)]
struct Reports {
    reply: Arc<Receiver>,
    last: Arc<Mutex<Instant>>,
}

impl Reports {
    /// Returns reports of which the first is sent after [`BETWEEN_REPORTS`].
    fn new(reply: &Arc<Receiver>) -> Self {
        Self { reply: Arc::clone(reply), last: Arc::new(Mutex::new(Instant::now())) }
    }

    /// Sends `report` if it is time.
    fn tell(&self, report: impl FnOnce() -> RenderReply) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if milliseconds_since(*last) > BETWEEN_REPORTS {
            *last = Instant::now();
            (self.reply)(report());
        }
    }
}

/// Returns the task of drawing `request`, begun at `start`, for `side`: it is cancelled when a newer request replaces it.
fn frame_task(
    request: &FrameRequest,
    side: Side,
    start: Instant,
    queue: &Arc<JobQueue>,
    reply: &Arc<Receiver>,
) -> Task {
    let (queue, reports) = (Arc::clone(queue), Reports::new(reply));
    let FrameRequest { moving, again, quality, .. } = *request;
    Task::while_true(move |progress| {
        let newer = || queue.has_newer_frame() || again && !queue.pending().jobs.is_empty();
        reports.tell(|| RenderReply::Drawing(side, fraction(progress) as f32));
        if moving {
            // A frame of a moving scene is short, and the window waits for it.
            let is_kept = quality == Quality::COARSEST || milliseconds_since(start) <= LONGEST_MOVING_FRAME;
            return is_kept && !queue.pending().stop || !newer();
        }
        queue.give_way();
        !newer()
    })
}

/// Returns the part of a stage that is done.
fn fraction(Progress { done, of, .. }: Progress) -> f64 {
    done as f64 / of.max(1) as f64
}

/// Returns the time since `start` \[ms\].
fn milliseconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Returns what was done, or `None` if it was cancelled.
fn unless_cancelled<T>(done: Result<T>) -> Result<Option<T>> {
    match done {
        Err(e) if e.is_cancelled() => Ok(None),
        done => done.map(Some),
    }
}

/// Adds samples to the frame of `request` from now on, if it has full quality and several samples.
fn go_on_with(request: FrameRequest, queue: &JobQueue) {
    if request.quality == Quality::WHOLE && !request.moving && request.sampling.count > 1 {
        queue.refine(request);
    }
}

/// Draws `request` from `prepared` with the renderer of `slot`, at `size` pixels. Makes the renderer if the slot has no
/// suitable one.
fn paint(
    device: &Arc<Device>,
    slot: &mut Option<Slot>,
    prepared: &Arc<Prepared>,
    request: &FrameRequest,
    size: [u32; 2],
    task: &Task,
) -> Result<FrameTime> {
    let slot = serving(device, slot, prepared, request)?;
    let (view, shown) = (&request.view, request.shown);
    let wanted = Displayed { view: view.clone(), shown, size, sampling: Sampling::ONE };
    if let Some(displayed) = &slot.displayed
        && !request.again
        && slot.renderer.has_picture()
        && slot.renderer.target().size() == request.size
        && [Sampling::ONE, request.sampling].contains(&displayed.sampling)
        && *displayed
            == (Displayed { shown: displayed.shown, sampling: displayed.sampling, ..wanted.clone() })
    {
        let wanted = Displayed { sampling: displayed.sampling, ..wanted.clone() };
        if displayed.shown == shown {
            return Ok(FrameTime::default());
        }
        if slot.renderer.display(size, shown)? {
            slot.displayed = Some(wanted);
            return Ok(FrameTime::default());
        }
    }
    if prepared.source().has_limits(prepared.optics()) {
        let directions = error_probe::directions(&mut slot.renderer, view)?;
        prepared.source().check(prepared.optics(), &directions)?;
    }
    slot.displayed = None;
    let start = Instant::now();
    let drawn = slot.renderer.draw(&PictureRequest::one_sample(view, size, shown), task)?;
    slot.displayed = Some(wanted);
    Ok(FrameTime { gpu: drawn.milliseconds, wall: start.elapsed().as_secs_f64() * 1e3 })
}

/// Displays the picture of `slot`, of `size` pixels, with automatic exposure \[stops\] and otherwise with the settings
/// `shown`; `None` if nothing is lit.
fn expose(slot: &mut Option<Slot>, shown: Shown, size: [u32; 2]) -> Result<Option<f64>> {
    let Some(slot) = slot else { return Ok(None) };
    let picture = slot.renderer.read_back()?;
    let rows = picture.radiance.chunks(picture.size[0].max(1) as usize).take(size[1] as usize);
    let radiance: Vec<_> = rows.flat_map(|row| row.iter().take(size[0] as usize)).copied().collect();
    let stops = exposure::automatic(&radiance);
    if let Some(exposure) = stops {
        let shown = Shown { exposure, ..shown };
        slot.renderer.display(size, shown)?;
        if let Some(displayed) = &mut slot.displayed {
            displayed.shown = shown;
        }
    }
    Ok(stops)
}

/// Returns the renderer of `slot`, made or adapted to draw `request` from `prepared`.
fn serving<'a>(
    device: &Arc<Device>,
    slot: &'a mut Option<Slot>,
    prepared: &Arc<Prepared>,
    request: &FrameRequest,
) -> Result<&'a mut Slot> {
    // An unsuitable renderer is dropped here, so that its memory is free for the next one.
    let ready = match slot.take().filter(|slot| slot.serves(prepared, request)) {
        Some(mut ready) => {
            ready.renderer.resize(request.size)?;
            ready.take_over(prepared)?;
            ready
        }
        None => {
            let LoadedScene { scene, textures } = &*request.loaded;
            let objects = objects(scene, textures, prepared.of_objects(textures.len()));
            let shadows = RendererSettings { shadows: scene.shadows, ..RendererSettings::default() };
            let renderer = Renderer::new(device, &objects, request.size, shadows)?;
            let (prepared, loaded) = (prepared.clone(), request.loaded.clone());
            Slot { renderer, prepared, loaded, displayed: None }
        }
    };
    Ok(slot.insert(ready))
}
