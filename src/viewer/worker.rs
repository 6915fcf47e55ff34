//! The thread that prepares layers and colour tables. Requests of one role replace each other; the user's own goes first.

use super::prepared::{Made, Prepared, ROLES, Role};
use crate::error::{Error, Result};
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{Layers, Settings, cache};
use crate::render::color_table::{ColorTable, Filter};
use crate::render::repeating::Repeating;
use crate::render::resources::Reads;
use crate::render::shading::Shading;
use crate::surface::{HeightField, Source};
use crate::vk::selection::Candidate;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Called with the steps done and in total; an error from it ends the work.
pub type Progress<'a> = &'a dyn Fn(usize, usize) -> Result<()>;

/// Bakes the colour table of a surface; the second result says why it could not be cached.
pub type Bake =
    Box<dyn Fn(&HeightField, &Shading, Progress<'_>) -> Result<(ColorTable, Option<Error>)> + Send>;

/// A setting to prepare.
#[derive(Clone)]
pub struct Request {
    /// What it is for.
    pub role: Role,
    /// A number larger than that of any request before.
    pub number: u64,
    /// The height field.
    pub source: Source,
    /// The settings.
    pub shading: Shading,
    /// The method.
    pub method: Reads,
    /// How a colour table is read.
    pub filter: Filter,
}

/// What the worker reports.
pub enum WorkerReply {
    /// `done` of `of` steps are done.
    Progress {
        /// Role of the request.
        role: Role,
        /// Steps done.
        done: usize,
        /// Steps in total, as far as is known.
        of: usize,
    },
    /// A setting is ready, with a note for the user if there is one.
    Ready(Role, Arc<Prepared>, Option<String>),
    /// The newest request of a role failed.
    Failed(Role, Error),
}

/// The newest request of each role, shared between the window's thread and the worker.
#[derive(Default)]
struct RequestQueue {
    requests: Mutex<[Option<Request>; ROLES]>,
    changed: Condvar,
    stop: AtomicBool,
}

impl RequestQueue {
    fn requests(&self) -> MutexGuard<'_, [Option<Request>; ROLES]> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Waits for the most urgent request; `None` when the worker is to end.
    fn next(&self) -> Option<Request> {
        let mut requests = self.requests();
        loop {
            if self.is_stopped() {
                return None;
            }
            if let Some(request) = requests.iter_mut().find_map(Option::take) {
                return Some(request);
            }
            requests = self.changed.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Whether to abandon work for `role`, because the worker is to end or a request at least as urgent waits.
    fn interrupts(&self, role: Role) -> bool {
        self.is_stopped() || self.requests()[..=role as usize].iter().any(Option::is_some)
    }
}

/// The worker thread. Dropping it ends the thread and waits for it.
pub struct Worker {
    queue: Arc<RequestQueue>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts a thread that prepares layers for `device`, bakes tables with `bake` and sends its replies to `reply`.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(device: &Candidate, bake: Bake, reply: impl Fn(WorkerReply) + Send + 'static) -> Result<Self> {
        let queue = Arc::<RequestQueue>::default();
        let requests = queue.clone();
        let mut preparer = Preparer { device: device.clone(), bake, recent: RecentResults::default() };
        let work = move || preparer.run(&requests, &reply);
        let thread = std::thread::Builder::new().name("layers".to_owned()).spawn(work).map_err(|e| {
            Error::failed(format!("the system refuses a thread ({e})"), "close other programs")
        })?;
        Ok(Self { queue, thread: Some(thread) })
    }

    /// Requests a setting. It replaces the former request of its role, even one in progress.
    pub fn request(&self, request: Request) {
        let role = request.role as usize;
        self.queue.requests()[role] = Some(request);
        self.queue.changed.notify_one();
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.queue.stop.store(true, Ordering::Relaxed);
        // The lock ensures that the thread either has yet to read `stop` or is waiting already.
        drop(self.queue.requests());
        self.queue.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // the thread reports its errors itself
        }
    }
}

/// Layers with the surface and the settings that they were made from.
struct RecentLayers {
    field: Arc<HeightField>,
    settings: Settings,
    layers: Arc<Layers>,
}

/// A colour table with the surface and the settings that it was baked from.
struct RecentTable {
    field: Arc<HeightField>,
    shading: Shading,
    table: Arc<ColorTable>,
}

/// The last result of each role, for requests that share it.
#[derive(Default)]
struct RecentResults {
    field: Option<(Source, Arc<HeightField>)>,
    layers: [Option<RecentLayers>; ROLES],
    tables: [Option<RecentTable>; ROLES],
}

/// What the worker thread owns.
struct Preparer {
    device: Candidate,
    bake: Bake,
    recent: RecentResults,
}

/// What is shaded from, with a note for the user if the cache could not keep it.
type MadeWithNote = (Made, Option<String>);

impl Preparer {
    fn run(&mut self, queue: &RequestQueue, reply: &dyn Fn(WorkerReply)) {
        while let Some(request) = queue.next() {
            let role = request.role;
            let progress = |done: usize, of: usize| {
                if queue.interrupts(role) {
                    return Err(Error::failed("a more urgent request waits", "wait for it"));
                }
                reply(WorkerReply::Progress { role, done, of });
                Ok(())
            };
            match self.prepare(&request, &progress) {
                _ if queue.is_stopped() => {}
                Ok((prepared, note)) => reply(WorkerReply::Ready(role, prepared, note)),
                Err(_) if queue.interrupts(role) => {
                    // Interrupted: the request is done later, unless a newer one replaces it.
                    queue.requests()[role as usize].get_or_insert(request);
                }
                Err(e) => reply(WorkerReply::Failed(role, e)),
            }
        }
    }

    fn prepare(
        &mut self,
        request: &Request,
        progress: Progress<'_>,
    ) -> Result<(Arc<Prepared>, Option<String>)> {
        let field = self.field(&request.source)?;
        let (made, note) = match request.method {
            Reads::Table => self.table(request, &field, progress)?,
            Reads::Layers => self.layers(request, &field, progress)?,
        };
        let prepared = Prepared { number: request.number, field, made, shading: request.shading.clone() };
        Ok((Arc::new(prepared), note))
    }

    fn field(&mut self, source: &Source) -> Result<Arc<HeightField>> {
        if let Some((_, field)) = self.recent.field.as_ref().filter(|(known, _)| known == source) {
            return Ok(field.clone());
        }
        let field = Arc::new(source.load()?);
        self.recent.field = Some((source.clone(), field.clone()));
        Ok(field)
    }

    fn table(
        &mut self,
        request: &Request,
        field: &Arc<HeightField>,
        progress: Progress<'_>,
    ) -> Result<MadeWithNote> {
        // A table depends neither on the refractive index nor on the basis.
        let (ior, basis) = (Shading::default().ior, Shading::default().basis);
        let shading = Shading { ior, basis, ..request.shading.clone() };
        let same = |known: &&RecentTable| Arc::ptr_eq(&known.field, field) && known.shading == shading;
        let (table, note) = match self.recent.tables.iter().flatten().find(same) {
            Some(known) => (known.table.clone(), None),
            None => {
                let (table, not_kept) = (self.bake)(field, &request.shading, progress)?;
                let note = not_kept.map(|e| format!("the colour table could not be cached: {e}"));
                (Arc::new(table), note)
            }
        };
        let role = request.role as usize;
        self.recent.layers[role] = None;
        self.recent.tables[role] = Some(RecentTable { field: field.clone(), shading, table: table.clone() });
        Ok((Made::Table(table, request.filter), note))
    }

    fn layers(
        &mut self,
        request: &Request,
        field: &Arc<HeightField>,
        progress: Progress<'_>,
    ) -> Result<MadeWithNote> {
        let shading = &request.shading;
        let repeating = Repeating::of(field, shading);
        let settings = match &repeating {
            None => shading.layer_settings(SHORTEST, &self.device)?,
            Some(_) => shading.windowed_settings(f64::INFINITY, SHORTEST, &self.device)?,
        };
        let same = |known: &&RecentLayers| Arc::ptr_eq(&known.field, field) && known.settings == settings;
        let (layers, note) = match self.recent.layers.iter().flatten().find(same) {
            Some(known) => (known.layers.clone(), None),
            None => {
                let (layers, not_kept) = cache::obtain(field, &settings, progress)?;
                let note = not_kept.map(|e| format!("the spectra could not be cached: {e}"));
                (Arc::new(layers), note)
            }
        };
        let role = request.role as usize;
        self.recent.tables[role] = None;
        self.recent.layers[role] =
            Some(RecentLayers { field: field.clone(), settings, layers: layers.clone() });
        let made = match repeating {
            None => Made::Layers(layers),
            Some(repeating) => Made::Repeats(layers, Arc::new(repeating)),
        };
        Ok((made, note))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Level;
    use crate::vk::instance::API_VERSION;
    use ash::vk;
    use std::sync::mpsc;

    fn device() -> Candidate {
        Candidate {
            raw: vk::PhysicalDevice::null(),
            name: String::new(),
            driver: String::new(),
            kind: vk::PhysicalDeviceType::CPU,
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
        let level = Level::None;
        let source = Source { name: name.to_owned(), pixel_size: None, height: None, level, seed: 1 };
        let shading = Shading { tolerance, ..Shading::default() };
        Request { role, number, source, shading, method: Reads::Layers, filter: Filter::Point }
    }

    #[test]
    fn the_newest_request_wins_and_the_others_get_their_turn() {
        let (sender, reports) = mpsc::channel();
        let bake: Bake = Box::new(|_, _, _| Err(Error::failed("no tables here", "ask for layers")));
        let worker = Worker::new(&device(), bake, move |report| {
            if !matches!(report, WorkerReply::Progress { .. }) {
                let _ = sender.send(report);
            }
        })
        .unwrap();
        worker.request(request(Role::Coarse, 1, "bumps", 0.5));
        for number in 2..6 {
            worker.request(request(Role::Own, number, "bumps", 0.1 + number as f64 * 0.01));
        }
        worker.request(request(Role::Own, 6, "flat", 0.1));
        let mut ready = Vec::new();
        while !(ready.contains(&(Role::Own, 6)) && ready.contains(&(Role::Coarse, 1))) {
            match reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                WorkerReply::Ready(role, prepared, _) => ready.push((role, prepared.number)),
                WorkerReply::Failed(_, e) => panic!("{e}"),
                WorkerReply::Progress { .. } => {}
            }
        }
        let own: Vec<u64> = ready.iter().filter(|r| r.0 == Role::Own).map(|r| r.1).collect();
        assert!(own.is_sorted(), "{own:?}");
        worker.request(request(Role::Own, 7, "nothing.png", 0.1));
        let refused = reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap();
        assert!(matches!(refused, WorkerReply::Failed(Role::Own, _)));
    }
}
