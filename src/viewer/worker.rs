//! Layers and colour tables made in the background: the newest request of each role wins, the user's own goes first.

use crate::error::{Error, Result};
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{Layers, Settings, cache};
use crate::render::color_table::{ColorTable, Filter};
use crate::render::repeating::Repeating;
use crate::render::resources::{Optics, Reads};
use crate::render::shading::Shading;
use crate::surface::{HeightField, Source};
use crate::vk::selection::Candidate;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// What layers are for, the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The picture.
    Own,
    /// The setting that it is compared with.
    Other,
    /// Moving pictures, of fewer wavelengths and layers.
    Coarse,
    /// Moving pictures, of fewer wavelengths alone.
    FewerWavelengths,
}

/// Number of roles.
pub const ROLES: usize = 4;

/// A surface and settings that are ready to be drawn.
pub struct Prepared {
    /// Number of the request; no two are alike.
    pub number: u64,
    /// The height field.
    pub field: Arc<HeightField>,
    /// What it is shaded from.
    pub made: Made,
    /// The settings.
    pub shading: Shading,
}

/// What a surface is shaded from.
#[derive(Clone)]
pub enum Made {
    /// Layers.
    Layers(Arc<Layers>),
    /// Layers of one period, and how it repeats.
    Repeats(Arc<Layers>, Arc<Repeating>),
    /// A colour table, and how it is read.
    Table(Arc<ColorTable>, Filter),
}

impl Made {
    /// Layers of the texture, texels along its sides, and its bytes.
    pub fn texture(&self) -> (usize, [usize; 2], u64) {
        match self {
            Self::Layers(layers) | Self::Repeats(layers, _) => {
                // Lines hold nearly all of it, where there are any.
                let size = layers.lines.as_ref().map_or(layers.size, |lines| lines.size);
                (layers.count(), size, layers.bytes() as u64)
            }
            Self::Table(table, _) => (table.grid.layers(), [table.grid.side; 2], table.grid.bytes()),
        }
    }

    /// Whether both read the very same texture, however it is shaded.
    pub fn shares_all_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Layers(a), Self::Layers(b)) | (Self::Repeats(a, _), Self::Repeats(b, _)) => {
                Arc::ptr_eq(a, b)
            }
            (Self::Table(a, by), Self::Table(b, as_well)) => Arc::ptr_eq(a, b) && by == as_well,
            _ => false,
        }
    }

    /// Terms of the expansion, where one is summed.
    pub fn terms(&self) -> Option<usize> {
        match self {
            Self::Layers(layers) | Self::Repeats(layers, _) => Some(layers.terms),
            Self::Table(..) => None,
        }
    }
}

impl<'a> From<&'a Made> for Optics<'a> {
    fn from(made: &'a Made) -> Self {
        match made {
            Made::Layers(layers) => Self::Layers(layers),
            Made::Repeats(layers, repeating) => Self::Repeats(layers, repeating.repeats),
            Made::Table(table, filter) => Self::Table(table, *filter),
        }
    }
}

/// Makes the colour table of a surface; its last argument is called as work goes on, and an error from it ends the work.
pub type Bake = Box<
    dyn Fn(&HeightField, &Shading, &dyn Fn(usize, usize) -> Result<()>) -> Result<(ColorTable, Option<Error>)>
        + Send,
>;

/// What is asked for.
#[derive(Clone)]
pub struct Request {
    /// What for.
    pub role: Role,
    /// A number that grows with each request.
    pub number: u64,
    /// The height field.
    pub source: Source,
    /// The settings.
    pub shading: Shading,
    /// By which method.
    pub method: Reads,
    /// How a colour table is read.
    pub filter: Filter,
}

/// What the worker has to say.
pub enum Report {
    /// `done` steps of `of` are done.
    Progress {
        /// Of which request.
        role: Role,
        /// Steps done.
        done: usize,
        /// Steps in all, as far as is known.
        of: usize,
    },
    /// Layers are ready; beside them, what the user should know.
    Ready(Role, Arc<Prepared>, Option<String>),
    /// The newest request of a role cannot be met.
    Failed(Role, Error),
}

#[derive(Default)]
struct Shared {
    requests: Mutex<[Option<Request>; ROLES]>,
    wake: Condvar,
    stop: AtomicBool,
}

impl Shared {
    fn requests(&self) -> MutexGuard<'_, [Option<Request>; ROLES]> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether work for `role` is in vain by now, or something more urgent waits.
    fn interrupts(&self, role: Role) -> bool {
        self.stop.load(Ordering::Relaxed) || self.requests()[..=role as usize].iter().any(Option::is_some)
    }
}

/// The thread that makes layers.
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// A thread that makes layers for `device`, and tables by `bake`, and tells `report`.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(device: &Candidate, bake: Bake, report: impl Fn(Report) + Send + 'static) -> Result<Self> {
        let shared = Arc::<Shared>::default();
        let (own, device) = (shared.clone(), device.clone());
        let work = move || run(&own, (&device, &bake), &report);
        let thread = std::thread::Builder::new().name("layers".to_owned()).spawn(work).map_err(|e| {
            Error::failed(format!("the system gives no thread ({e})"), "close other programs")
        })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for layers; what was asked for in this role before is dropped, begun or not.
    pub fn ask(&self, request: Request) {
        let role = request.role as usize;
        self.shared.requests()[role] = Some(request);
        self.shared.wake.notify_one();
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        // Locked, so that the thread is either before its look at `stop` or waiting.
        drop(self.shared.requests());
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // it reports its errors itself
        }
    }
}

/// Layers and what they were made of and for.
type KeptLayers = (Arc<HeightField>, Settings, Arc<Layers>);
/// A table, the same.
type KeptTable = (Arc<HeightField>, Shading, Arc<ColorTable>);

/// What was made last, for requests that share it.
#[derive(Default)]
struct Kept {
    field: Option<(Source, Arc<HeightField>)>,
    layers: [Option<KeptLayers>; ROLES],
    tables: [Option<KeptTable>; ROLES],
}

fn run(shared: &Shared, by: (&Candidate, &Bake), report: &dyn Fn(Report)) {
    let mut kept = Kept::default();
    loop {
        let request = {
            let mut requests = shared.requests();
            loop {
                if shared.stop.load(Ordering::Relaxed) {
                    return;
                }
                if let Some(request) = requests.iter_mut().find_map(Option::take) {
                    break request;
                }
                requests = shared.wake.wait(requests).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let made = make(&request, &mut kept, by, shared, report);
        if !shared.stop.load(Ordering::Relaxed) {
            match made {
                Ok((prepared, note)) => report(Report::Ready(request.role, prepared, note)),
                Err(_) if shared.interrupts(request.role) => {
                    // Given up for something more urgent: its turn comes again unless there is a newer one.
                    shared.requests()[request.role as usize].get_or_insert(request);
                }
                Err(e) => report(Report::Failed(request.role, e)),
            }
        }
    }
}

fn make(
    request: &Request,
    kept: &mut Kept,
    (device, bake): (&Candidate, &Bake),
    shared: &Shared,
    report: &dyn Fn(Report),
) -> Result<(Arc<Prepared>, Option<String>)> {
    let Request { role, number, source, shading, .. } = request;
    let field = match &kept.field {
        Some((known, field)) if known == source => field.clone(),
        _ => {
            let field = Arc::new(source.load()?);
            kept.field = Some((source.clone(), field.clone()));
            field
        }
    };
    let progress = |done: usize, of: usize| {
        if shared.interrupts(*role) {
            return Err(Error::failed("there is something newer to do", "wait for it"));
        }
        report(Report::Progress { role: *role, done, of });
        Ok(())
    };
    if request.method == Reads::Table {
        // Neither has a say in a table.
        let same =
            Shading { ior: Shading::default().ior, basis: Shading::default().basis, ..shading.clone() };
        let known = |known: &&KeptTable| Arc::ptr_eq(&known.0, &field) && known.1 == same;
        let (table, note) = match kept.tables.iter().flatten().find(known) {
            Some((_, _, table)) => (table.clone(), None),
            None => {
                let (table, not_kept) = bake(&field, shading, &progress)?;
                let note = not_kept.map(|e| format!("the colour table is not kept for next time: {e}"));
                (Arc::new(table), note)
            }
        };
        kept.layers[*role as usize] = None;
        kept.tables[*role as usize] = Some((field.clone(), same, table.clone()));
        let made = Made::Table(table, request.filter);
        return Ok((Arc::new(Prepared { number: *number, field, made, shading: shading.clone() }), note));
    }
    let repeating = Repeating::of(&field, shading);
    let settings = match &repeating {
        None => shading.layer_settings(SHORTEST, device)?,
        Some(_) => shading.windowed_settings(f64::INFINITY, SHORTEST, device)?,
    };
    let same = |known: &&KeptLayers| Arc::ptr_eq(&known.0, &field) && known.1 == settings;
    let (layers, note) = match kept.layers.iter().flatten().find(same) {
        Some((_, _, layers)) => (layers.clone(), None),
        None => {
            let (layers, not_kept) = cache::obtain(&field, &settings, &progress)?;
            let note = not_kept.map(|e| format!("the spectra are not kept for next time: {e}"));
            (Arc::new(layers), note)
        }
    };
    kept.tables[*role as usize] = None;
    kept.layers[*role as usize] = Some((field.clone(), settings, layers.clone()));
    let made = match repeating {
        None => Made::Layers(layers),
        Some(repeating) => Made::Repeats(layers, Arc::new(repeating)),
    };
    let prepared = Prepared { number: *number, field, made, shading: shading.clone() };
    Ok((Arc::new(prepared), note))
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
        let source =
            Source { name: name.into(), pixel_size: None, height: None, channel: None, level, seed: 1 };
        let shading = Shading { tolerance, ..Shading::default() };
        Request { role, number, source, shading, method: Reads::Layers, filter: Filter::Point }
    }

    #[test]
    fn the_newest_request_wins_and_the_others_get_their_turn() {
        let (sender, reports) = mpsc::channel();
        let bake: Bake = Box::new(|_, _, _| Err(Error::failed("no tables here", "ask for layers")));
        let worker = Worker::new(&device(), bake, move |report| {
            if !matches!(report, Report::Progress { .. }) {
                let _ = sender.send(report);
            }
        })
        .unwrap();
        worker.ask(request(Role::Coarse, 1, "bumps", 0.5));
        for number in 2..6 {
            worker.ask(request(Role::Own, number, "bumps", 0.1 + number as f64 * 0.01));
        }
        worker.ask(request(Role::Own, 6, "flat", 0.1));
        let mut ready = Vec::new();
        while !(ready.contains(&(Role::Own, 6)) && ready.contains(&(Role::Coarse, 1))) {
            match reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                Report::Ready(role, prepared, _) => ready.push((role, prepared.number)),
                Report::Failed(_, e) => panic!("{e}"),
                Report::Progress { .. } => {}
            }
        }
        let own: Vec<u64> = ready.iter().filter(|r| r.0 == Role::Own).map(|r| r.1).collect();
        assert!(own.is_sorted(), "{own:?}");
        worker.ask(request(Role::Own, 7, "nothing.png", 0.1));
        let refused = reports.recv_timeout(std::time::Duration::from_secs(60)).unwrap();
        assert!(matches!(refused, Report::Failed(Role::Own, _)));
    }
}
