//! Sources made in the background: the newest request of each role wins, the user's own goes first.

use crate::error::{Error, Result};
use crate::render::shading::Shading;
use crate::render::source::Source;
use crate::setup::{self, InUse, Target};
use crate::surface::{HeightField, Source as Surface};
use crate::vk::device::Device;
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
    pub shaded_from: Source,
    /// The settings.
    pub shading: Shading,
}

/// What is asked for.
#[derive(Clone)]
pub struct Request {
    /// What for.
    pub role: Role,
    /// A number that grows with each request.
    pub number: u64,
    /// The height field.
    pub surface: Surface,
    /// The settings.
    pub settings: setup::Settings,
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
    /// A thread that makes sources for a device of these `limits`, tables on `device`, and tells `report`.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        limits: &Candidate,
        device: Option<Arc<Device>>,
        report: impl Fn(Report) + Send + 'static,
    ) -> Result<Self> {
        let shared = Arc::<Shared>::default();
        let (own, limits) = (shared.clone(), limits.clone());
        let work = move || {
            let target = Target { limits: &limits, device: device.as_ref() };
            run(&own, target, &report);
        };
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

/// What was made last, for requests that share it.
#[derive(Default)]
struct Kept {
    field: Option<(Surface, Arc<HeightField>)>,
    in_use: InUse,
}

fn run(shared: &Shared, target: Target<'_>, report: &dyn Fn(Report)) {
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
        let made = make(&request, &mut kept, target, shared, report);
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
    target: Target<'_>,
    shared: &Shared,
    report: &dyn Fn(Report),
) -> Result<(Arc<Prepared>, Option<String>)> {
    let Request { role, number, surface, settings } = request;
    let field = match &kept.field {
        Some((known, field)) if known == surface => field.clone(),
        _ => {
            let field = Arc::new(surface.load()?);
            kept.field = Some((surface.clone(), field.clone()));
            field
        }
    };
    let progress = |_: &'static str, done: usize, of: usize| {
        if shared.interrupts(*role) {
            return Err(Error::failed("there is something newer to do", "wait for it"));
        }
        report(Report::Progress { role: *role, done, of });
        Ok(())
    };
    let made = setup::source(&field, settings, target, &mut kept.in_use, &progress)?;
    let (shaded_from, shading) = (made.source, settings.shading.clone());
    Ok((Arc::new(Prepared { number: *number, field, shaded_from, shading }), made.note))
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
        let surface = Surface { name: name.to_owned(), pixel_size: None, height: None, level, seed: 1 };
        let shading = Shading { tolerance, ..Shading::default() };
        Request { role, number, surface, settings: setup::Settings::new(setup::Method::Spectral, shading) }
    }

    #[test]
    fn the_newest_request_wins_and_the_others_get_their_turn() {
        let (sender, reports) = mpsc::channel();
        let worker = Worker::new(&device(), None, move |report| {
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
