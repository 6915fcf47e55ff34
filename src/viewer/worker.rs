//! Thread that prepares sources. Requests of one role replace each other; the main setting goes first.

use super::frame::LoadedScene;
use super::prepared::{Prepared, ROLES, Role};
use super::threads;
use crate::error::{Error, Result};
use crate::filter::FootprintSizes;
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::render::frame::View;
use crate::render::object::ObjectSources;
use crate::render::sampling::Sampling;
use crate::render::source::Source;
use crate::scene::Mesh;
use crate::setup::{self, InUse, ObjectSurface, SourceSettings};
use crate::surface::statistics::Relief;
use crate::surface::{HeightField, SurfaceSource};
use crate::task::{Progress, Task};
use crate::vk::device::Device;
use crate::vk::selection::Candidate;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Request for a source.
#[derive(Clone)]
pub struct Request {
    /// Purpose.
    pub role: Role,
    /// Number, larger than that of any earlier request.
    pub number: u64,
    /// Height field.
    pub surface: SurfaceSource,
    /// Settings. Footprints of 0 are replaced by those of the picture.
    pub settings: SourceSettings,
    /// Picture it is for, whose footprints set the resolution of the source.
    pub picture: Option<RequestedPicture>,
}

/// Pictures that a source is made for.
#[derive(Clone)]
pub struct RequestedPicture {
    /// The scene.
    pub loaded: Arc<LoadedScene>,
    /// View of each picture.
    pub views: Vec<View>,
    /// Size \[pixels\].
    pub size: [u32; 2],
    /// Samples per pixel.
    pub sampling: Sampling,
}

/// Reply of the worker.
pub enum WorkerReply {
    /// `done` of `of` steps are done.
    Progress {
        /// Role of the request.
        role: Role,
        /// Steps done.
        done: usize,
        /// Steps in total, as far as known.
        of: usize,
    },
    /// The height field of the main picture was read; its spectra may take longer.
    Field(Arc<HeightField>),
    /// A setting is ready, with an optional note for the user.
    Ready(Role, Arc<Prepared>, Option<Error>),
    /// The request of this number failed.
    Failed(Role, u64, Error),
}

/// Request that is not done.
struct Waiting {
    request: Request,
    // True if it was begun and interrupted, so that it is known to take long.
    begun: bool,
}

/// Newest request of each role, and the one that is being done.
#[derive(Default)]
struct Requests {
    waiting: [Option<Waiting>; ROLES],
    running: Option<(Role, Task)>,
    // True once the window has colours.
    has_prepared: bool,
}

impl Requests {
    /// Returns true if a request at least as urgent as those for `role` waits.
    fn interrupt(&self, role: Role) -> bool {
        self.waiting[..=role as usize].iter().any(Option::is_some)
    }

    /// Cancels the request that is being done if it is to give way.
    fn make_way(&self) {
        if let Some((role, task)) = &self.running
            && self.interrupt(*role)
        {
            task.cancel();
        }
    }
}

/// Requests that the window's thread and the worker share.
#[derive(Default)]
struct RequestQueue {
    requests: Mutex<Requests>,
    changed: Condvar,
    stop: AtomicBool,
}

impl RequestQueue {
    fn requests(&self) -> MutexGuard<'_, Requests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Waits for the most urgent request; `None` if the worker is to end.
    fn next(&self) -> Option<Request> {
        let mut requests = self.requests();
        loop {
            if self.is_stopped() {
                return None;
            }
            // The main setting is begun before its preview, because it may be in the cache; otherwise it gives way at
            // its first step. The first colours of a window are the preview's: the main setting takes a second to find
            // the footprints of its picture, by which the cache knows it.
            let may_begin = requests.has_prepared;
            let foremost =
                requests.waiting[Role::Own as usize].take_if(|waiting| may_begin && !waiting.begun);
            if let Some(waiting) = foremost.or_else(|| requests.waiting.iter_mut().find_map(Option::take)) {
                return Some(waiting.request);
            }
            requests = self.changed.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Names `task` as that of the request for `role` that is being done.
    fn begin(&self, role: Role, task: &Task) {
        let mut requests = self.requests();
        requests.running = Some((role, task.clone()));
        requests.make_way();
    }

    /// Adds a request in place of the former one of its role.
    fn add(&self, request: Request) {
        let mut requests = self.requests();
        let role = request.role as usize;
        requests.waiting[role] = Some(Waiting { request, begun: false });
        requests.make_way();
        self.changed.notify_one();
    }

    /// Puts back an interrupted request, unless a newer one has replaced it.
    fn put_back(&self, request: Request) {
        let role = request.role as usize;
        self.requests().waiting[role].get_or_insert(Waiting { request, begun: true });
    }

    /// Ends the worker, and what it does.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        // The lock ensures that the thread either has yet to read `stop` or is waiting already.
        if let Some((_, task)) = &self.requests().running {
            task.cancel();
        }
        self.changed.notify_one();
    }

    /// Drops the preview of request `number`, which is done.
    fn skip_preview(&self, number: u64) {
        self.requests().waiting[Role::Preview as usize].take_if(|waiting| waiting.request.number < number);
    }
}

/// Handle of the worker thread. Dropping it ends the thread and waits for it.
pub struct Worker {
    queue: Arc<RequestQueue>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts a thread that prepares sources for a device of these `limits`, bakes tables on `device`, and sends its
    /// replies to `reply`. Sources share the data `in_use`.
    ///
    /// # Errors
    /// Fails if the system refuses a thread.
    pub fn new(
        limits: &Candidate,
        device: Option<Arc<Device>>,
        in_use: InUse,
        reply: impl Fn(WorkerReply) + Send + Sync + 'static,
    ) -> Result<Self> {
        let queue = Arc::<RequestQueue>::default();
        let requests = queue.clone();
        let mut preparer = Preparer {
            limits: limits.clone(),
            device,
            field: None,
            relief: None,
            of_objects: Vec::new(),
            in_use,
        };
        let reply: Arc<Reply> = Arc::new(reply);
        let work = move || preparer.run(&requests, &reply);
        let thread = threads::spawn("layers", work)?;
        Ok(Self { queue, thread: Some(thread) })
    }

    /// Requests a setting. It replaces the former request of its role, even one in progress.
    pub fn request(&self, request: Request) {
        self.queue.add(request);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.queue.stop();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // the thread reports its errors itself
        }
    }
}

/// Receiver of the worker's replies.
type Reply = dyn Fn(WorkerReply) + Send + Sync;

/// State of the worker thread.
struct Preparer {
    limits: Candidate,
    device: Option<Arc<Device>>,
    // Last height field, for requests that share it.
    field: Option<(SurfaceSource, Arc<HeightField>)>,
    // Relief of the last height field that was measured.
    relief: Option<(Arc<HeightField>, Relief)>,
    // Height fields of the scene's other objects.
    of_objects: Vec<(SurfaceSource, Arc<HeightField>)>,
    in_use: InUse,
}

impl Preparer {
    fn run(&mut self, queue: &RequestQueue, reply: &Arc<Reply>) {
        while let Some(request) = queue.next() {
            let role = request.role;
            let task = Task::reporting({
                let reply = Arc::clone(reply);
                move |Progress { done, of, .. }| reply(WorkerReply::Progress { role, done, of })
            });
            queue.begin(role, &task);
            match self.prepare(&request, &task, &**reply) {
                _ if queue.is_stopped() => {}
                Ok((prepared, note)) => {
                    queue.requests().has_prepared = true;
                    if role == Role::Own {
                        queue.skip_preview(request.number);
                    }
                    reply(WorkerReply::Ready(role, prepared, note));
                }
                Err(e) if e.is_cancelled() => queue.put_back(request),
                Err(e) => reply(WorkerReply::Failed(role, request.number, e)),
            }
        }
    }

    /// Makes the source of `request`, with a note for the user if the cache could not keep it.
    fn prepare(
        &mut self,
        request: &Request,
        task: &Task,
        reply: &Reply,
    ) -> Result<(Arc<Prepared>, Option<Error>)> {
        let field = self.field(&request.surface, task)?;
        if matches!(request.role, Role::Own | Role::Preview) {
            reply(WorkerReply::Field(field.clone()));
        }
        let mut note = None;
        let objects = match &request.picture {
            Some(picture) => self.objects(request, &field, picture, &mut note, task)?,
            None => {
                let picture_source =
                    ObjectSurface { field: Some(field.clone()), source: request.settings.clone() };
                vec![
                    picture_source
                        .sources(&[], &mut |picture_source| self.source(picture_source, &mut note, task))?,
                ]
            }
        };
        let relief = self.relief(&field, request.role);
        let optics = &request.settings.optics;
        let colour = LightColour::Spectrum(&optics.illuminant);
        let scalar_theory = relief.map(|relief| ScalarTheory::new(relief, &optics.reflectance, colour));
        let prepared = Prepared { number: request.number, field, objects, scalar_theory };
        Ok((Arc::new(prepared), note))
    }

    /// Returns the relief of `field`, measured once per field, and only for the main picture.
    fn relief(&mut self, field: &Arc<HeightField>, role: Role) -> Option<Relief> {
        if let Some((of, relief)) = &self.relief
            && Arc::ptr_eq(of, field)
        {
            return Some(*relief);
        }
        let measured = (role == Role::Own).then(|| Relief::of(field).ok()).flatten()?;
        self.relief = Some((field.clone(), measured));
        Some(measured)
    }

    /// Makes the sources of all objects of a scene, the first of which has the surface `field`.
    fn objects(
        &mut self,
        request: &Request,
        field: &Arc<HeightField>,
        picture: &RequestedPicture,
        note: &mut Option<Error>,
        task: &Task,
    ) -> Result<Vec<ObjectSources>> {
        let scene = &picture.loaded.scene;
        let mut known = std::mem::take(&mut self.of_objects);
        let mut load = |surface: &SurfaceSource| match known
            .iter()
            .find(|(known_surface, _)| known_surface == surface)
        {
            Some((_, field)) => Ok(field.clone()),
            None => {
                let field = Arc::new(surface.load(task)?);
                known.push((surface.clone(), field.clone()));
                Ok(field)
            }
        };
        let surfaces = ObjectSurface::of(scene, field, &request.settings, &mut load);
        known.retain(|(surface, _)| {
            scene.objects.iter().any(|object| object.surface.as_ref() == Some(surface))
        });
        self.of_objects = known;
        let surfaces = surfaces?;
        let objects = surfaces.iter().zip(scene.meshes());
        objects.map(|(surface, mesh)| self.object(surface, mesh, picture, note, task)).collect()
    }

    /// Makes the sources of an object with this `surface` and `mesh`. The last `note` for the user is kept.
    fn object(
        &mut self,
        surface: &ObjectSurface,
        mesh: &Mesh,
        picture: &RequestedPicture,
        note: &mut Option<Error>,
        task: &Task,
    ) -> Result<ObjectSources> {
        let RequestedPicture { views, size, sampling, .. } = picture;
        let surface = match &self.device {
            Some(device) if surface.source.footprints == FootprintSizes::default() => {
                surface.seen(device, mesh, views, *size, sampling)?
            }
            _ => surface.clone(),
        };
        surface.sources(views, &mut |picture_source| self.source(picture_source, note, task))
    }

    /// Makes the source of `surface` under one illuminant.
    fn source(&mut self, surface: &ObjectSurface, note: &mut Option<Error>, task: &Task) -> Result<Source> {
        let Some(field) = &surface.field else { return Ok(setup::pigment_alone()) };
        let made = setup::source(field, &surface.source, &self.limits, &mut self.in_use, task)?;
        *note = made.note.or(note.take());
        Ok(made.source)
    }

    fn field(&mut self, surface: &SurfaceSource, task: &Task) -> Result<Arc<HeightField>> {
        if let Some((_, field)) = self.field.as_ref().filter(|(known, _)| known == surface) {
            return Ok(field.clone());
        }
        let field = Arc::new(surface.load(task)?);
        self.field = Some((surface.clone(), field.clone()));
        Ok(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::coherence::{Coherence, Windows};
    use crate::settings::Optics;
    use crate::surface::synth::SurfaceKind;
    use crate::vk::instance::API_VERSION;
    use ash::vk;
    use std::sync::mpsc;

    fn device() -> Candidate {
        Candidate {
            raw: vk::PhysicalDevice::null(),
            name: String::new(),
            driver: String::new(),
            kind: vk::PhysicalDeviceType::CPU,
            vendor: 0,
            uuid: String::new(),
            bus: None,
            version: API_VERSION,
            queue_family: Some(0),
            memory: 1 << 30,
            max_side: 16_384,
            max_layers: 2048,
            timestamp_period: 1.0,
            missing: Vec::new(),
        }
    }

    fn request(role: Role, number: u64, name: &str, tolerance: f64) -> Request {
        let surface = SurfaceSource { name: name.into(), ..SurfaceSource::built_in(SurfaceKind::Blaze) };
        let coherence = Coherence::Gaussian { length: 8.0 };
        let optics = Optics { tolerance, coherence, windows: Windows::ONE, ..Optics::default() };
        Request { role, number, surface, settings: SourceSettings::new(optics), picture: None }
    }

    #[test]
    fn a_preview_comes_before_what_takes_its_time() {
        let (sender, reports) = mpsc::channel();
        let worker = Worker::new(&device(), None, InUse::default(), move |report| {
            if !matches!(report, WorkerReply::Progress { .. } | WorkerReply::Field(_)) {
                let _ = sender.send(report);
            }
        })
        .unwrap();
        worker.request(request(Role::Preview, 1, "bumps", 0.3));
        worker.request(request(Role::Own, 2, "bumps", 0.1));
        let roles =
            [(); 2].map(|()| match reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                WorkerReply::Ready(role, ..) => role,
                _ => panic!("refused"),
            });
        assert_eq!(roles, [Role::Preview, Role::Own]);
    }

    #[test]
    fn the_newest_request_wins_and_the_others_get_their_turn() {
        let (sender, reports) = mpsc::channel();
        let worker = Worker::new(&device(), None, InUse::default(), move |report| {
            if !matches!(report, WorkerReply::Progress { .. } | WorkerReply::Field(_)) {
                let _ = sender.send(report);
            }
        })
        .unwrap();
        worker.request(request(Role::Other, 1, "bumps", 0.5));
        for number in 2..6 {
            worker.request(request(Role::Own, number, "bumps", 0.1 + number as f64 * 0.01));
        }
        worker.request(request(Role::Own, 6, "flat", 0.1));
        let mut ready = Vec::new();
        while !(ready.contains(&(Role::Own, 6)) && ready.contains(&(Role::Other, 1))) {
            match reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                WorkerReply::Ready(role, prepared, _) => ready.push((role, prepared.number)),
                WorkerReply::Failed(_, _, e) => panic!("{e}"),
                WorkerReply::Progress { .. } | WorkerReply::Field(_) => {}
            }
        }
        let numbers: Vec<u64> = ready.iter().filter(|r| r.0 == Role::Own).map(|r| r.1).collect();
        assert!(numbers.is_sorted(), "{numbers:?}");
        worker.request(request(Role::Own, 7, "nothing.png", 0.1));
        let refused = reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap();
        assert!(matches!(refused, WorkerReply::Failed(Role::Own, 7, _)));
    }
}
