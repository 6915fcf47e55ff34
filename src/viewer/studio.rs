//! The thread that draws the scene, with the painters that `render` uses. The newest wish wins; a picture of something
//! that moves is finished, one that stands still is given up for a newer one.

use super::compare::Compare;
use super::easel::Easel;
use super::inset::Inset;
use super::judge::Samples;
use super::pace::{Degree, Rung};
use super::worker::Prepared;
use crate::error::{Error, Result};
use crate::render::frame::View;
use crate::render::picture::Picture;
use crate::render::pigment::Pigment;
use crate::scene::Scene;
use crate::vk::device::Device;
use crate::vk::image::Image;
use glam::DVec3;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// A scene, ready to be uploaded.
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its pigment texture.
    pub pigment: Pigment,
}

/// What is to be seen.
#[derive(Clone)]
pub struct Wish {
    /// Mesh and pigment.
    pub stage: Arc<Stage>,
    /// The user's setting.
    pub own: Arc<Prepared>,
    /// The setting to compare with.
    pub other: Option<Arc<Prepared>>,
    /// What the rung takes instead of the user's setting.
    pub lighter: Option<Arc<Prepared>>,
    /// How much is done.
    pub rung: Rung,
    /// Whether it moves: then it is finished before a newer wish is looked at, unless that takes too long.
    pub moving: bool,
    /// Whether it is drawn even if it is there already.
    pub again: bool,
    /// Camera, lights, pigment.
    pub view: View,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// What is displayed where nothing is covered.
    pub background: DVec3,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// What stands beside the picture.
    pub compare: Compare,
    /// Whether the hemisphere of the first light is wanted.
    pub inset: bool,
}

/// Work that is done once.
pub enum Errand {
    /// Draw all of the wish and give the picture back.
    Picture(Wish),
    /// Draw all of the wish and give some pixels back.
    Samples(Wish),
}

/// A picture that can be shown.
#[derive(Clone)]
pub struct Exhibit {
    /// The picture, and what stands right of the split.
    pub images: [Arc<Image>; 2],
    /// Pixels that were drawn of each.
    pub sizes: [[u32; 2]; 2],
    /// How much was done.
    pub rung: Rung,
    /// Milliseconds on the device.
    pub gpu: f64,
    /// Milliseconds on the wall.
    pub wall: f64,
    /// Whether it was the first of its painter.
    pub first: bool,
    /// What the whole picture costs, where it was counted.
    pub cost: Option<Counted>,
    /// The hemisphere, where it was asked for.
    pub inset: Option<Arc<Inset>>,
    /// Number of the setting that is shown.
    pub number: u64,
}

/// Cost of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted {
    /// Part of the picture that the mesh covers.
    pub covered: f64,
    /// Wavelengths of a covered pixel.
    pub wavelengths: f64,
    /// Samples of the layers for a covered pixel.
    pub samples: f64,
}

/// What the studio has to say.
pub enum Word {
    /// A picture is on the device.
    Drawn(Box<Exhibit>),
    /// A moving picture took at least so many milliseconds and was given up.
    TooSlow(Rung, f64),
    /// The device has no room for the spectra of moving pictures.
    NoRoom(Degree),
    /// The picture that was asked for.
    Picture(Box<Picture>),
    /// The samples that were asked for.
    Samples(Arc<Prepared>, Box<(View, f64)>, Samples),
    /// It cannot be drawn.
    Failed(Error),
}

/// What is asked for.
#[derive(Default)]
pub struct Desk {
    pub wish: Option<Wish>,
    pub errands: Vec<Errand>,
    pub stop: bool,
}

/// The desk, and how to wake who works at it.
#[derive(Default)]
pub struct Shared {
    desk: Mutex<Desk>,
    pub wake: Condvar,
}

impl Shared {
    /// The desk, locked.
    pub fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread that draws.
pub struct Studio {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Studio {
    /// A thread that draws on `device` and tells `say`.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(device: &Arc<Device>, say: impl Fn(Word) + Send + 'static) -> Result<Self> {
        let shared = Arc::<Shared>::default();
        let (own, device) = (shared.clone(), device.clone());
        let work = move || Easel::new(device).run(&own, &say);
        let thread = std::thread::Builder::new().name("pictures".to_owned()).spawn(work).map_err(|e| {
            Error::failed(format!("the system gives no thread ({e})"), "close other programs")
        })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for a picture instead of the one asked for before.
    pub fn wish(&self, wish: Wish) {
        self.shared.desk().wish = Some(wish);
        self.shared.wake.notify_one();
    }

    /// Asks for something beside.
    pub fn errand(&self, errand: Errand) {
        self.shared.desk().errands.push(errand);
        self.shared.wake.notify_one();
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        self.shared.desk().stop = true;
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // it reports its errors itself
        }
    }
}
