//! Results in f64 that several tests need, each made by the first of them: references, and the limits of energy of surfaces.

use crate::kept::Kept;
use diffract::internals::brdf::energy_map::EnergyMap;
use diffract::internals::error::Result;
use diffract::internals::render::directions::Directions;
use diffract::internals::render::frame::View;
use diffract::internals::render::light_passes::LightPass;
use diffract::internals::render::reference_picture::{
    PixelReference, ReferenceSamples, covered, reference_mean_of,
};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::Source;
use diffract::internals::settings::Optics;
use diffract::internals::setup::{self, InUse, SourceSettings, colour_limit};
use diffract::internals::surface::HeightField;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// Values by key, each of which is made once; tests that need the same one wait for it.
struct Shared<T>(LazyLock<Mutex<HashMap<String, Arc<Mutex<T>>>>>);

impl<T: Default> Shared<T> {
    const fn new() -> Self {
        Self(LazyLock::new(Mutex::default))
    }

    /// Returns the value of `key`. A test that failed with it held leaves it as it was.
    fn of(&self, key: &str) -> Arc<Mutex<T>> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.entry(key.to_owned()).or_default().clone()
    }
}

/// Data that the sources of a surface have in common, and the limits that keep it in use.
#[derive(Default)]
struct SurfaceData {
    in_use: InUse,
    limits: Vec<Arc<EnergyMap>>,
}

static KEPT: Shared<SurfaceData> = Shared::new();

/// Returns all of a field in short: sides, spacings and the hash of the heights' bits.
fn name_of(field: &HeightField) -> String {
    let mut hash = DefaultHasher::new();
    field.heights().iter().for_each(|height| height.to_bits().hash(&mut hash));
    format!("{} {} {:?} {:x}", field.columns(), field.rows(), field.pixel_size(), hash.finish())
}

/// Returns the reference of `field` under `optics`, whose tolerance a reference does not know.
pub fn reference(field: &HeightField, optics: &Optics) -> Arc<PixelReference> {
    static REFERENCES: Shared<Option<Arc<PixelReference>>> = Shared::new();
    let any = Optics { tolerance: 1.0, ..optics.clone() };
    let place = REFERENCES.of(&format!("{} {any:?}", name_of(field)));
    let mut made = place.lock().unwrap_or_else(PoisonError::into_inner);
    let new = || Arc::new(PixelReference::new(field, &any, &Task::silent()).unwrap());
    made.get_or_insert_with(new).clone()
}

/// Returns the `chosen` pixels by `reference` for `directions`, one entry per light; others are empty.
pub fn shaded(
    reference: &PixelReference,
    view: &View,
    directions: &[Directions],
    chosen: &dyn Fn(usize) -> bool,
) -> Vec<[f32; 4]> {
    let mut picture = vec![[0.0; 4]; directions[0].view.len()];
    let pixels: Vec<usize> = covered(directions).into_iter().filter(|&pixel| chosen(pixel)).collect();
    let colors = reference.colors(view, 0, directions, &pixels, &Task::silent()).unwrap();
    for (pixel, color) in pixels.into_iter().zip(colors) {
        picture[pixel] = color.as_vec3().extend(1.0).to_array();
    }
    picture
}

/// Contents of a reference picture: the main object of a view, with a surface.
pub struct Pictured<'a> {
    pub field: &'a HeightField,
    pub optics: &'a Optics,
    pub view: &'a View,
    /// Width and height \[pixels\].
    pub size: [u32; 2],
}

impl Pictured<'_> {
    fn reference(&self) -> Arc<PixelReference> {
        reference(self.field, self.optics)
    }

    /// Returns this picture as one that is kept under `name`, which tells scene and lights.
    fn kept(&self, name: &str, samples: u32) -> Kept {
        let Self { field, optics, size, .. } = *self;
        let ((low, high), [dx, dy]) = (field.range(), field.pixel_size());
        let Optics { coherence, windows, beyond, illuminant, .. } = optics;
        let follows_from = format!(
            "{name}: {samples} samples of {} x {} heights {dx:.6} x {dy:.6} um apart from {low:.6} to {high:.6} um by {coherence:?} {windows:?} {beyond:?} {}",
            field.columns(),
            field.rows(),
            illuminant.name()
        );
        Kept { name: name.to_owned(), follows_from, size }
    }

    /// Returns the reference picture for `directions`, one entry per light.
    pub fn by(&self, directions: &[Directions]) -> Vec<[f32; 4]> {
        self.part_by(directions, &|_| true)
    }

    /// Returns the reference picture for `directions` of `device`, which is kept under `name`.
    pub fn kept_by(&self, device: &Device, name: &str, directions: &[Directions]) -> Vec<[f32; 4]> {
        self.kept(name, 1).picture(device, &mut |chosen| self.part_by(directions, chosen))
    }

    fn part_by(&self, directions: &[Directions], chosen: &dyn Fn(usize) -> bool) -> Vec<[f32; 4]> {
        shaded(&self.reference(), self.view, directions, chosen)
    }

    /// Returns the mean of samples, which is kept under `name`; `directions` returns those of a pass.
    pub fn kept_mean(
        &self,
        device: &Device,
        name: &str,
        sampling: &Sampling,
        directions: &mut dyn FnMut(&LightPass) -> Result<Directions>,
    ) -> Vec<[f32; 4]> {
        let mut compute = |chosen: &dyn Fn(usize) -> bool| {
            let samples = ReferenceSamples { sampling, size: self.size, chosen };
            let reference = self.reference();
            reference_mean_of(&[&*reference], self.view, &samples, directions, &Task::silent()).unwrap()
        };
        self.kept(name, sampling.count).picture(device, &mut compute)
    }
}

/// Returns the source of `field` under `settings`; its orders and its limit of energy may be those of an earlier one.
pub fn source(device: &Device, field: &HeightField, settings: &SourceSettings) -> Source {
    let place = KEPT.of(&name_of(field));
    let mut kept = place.lock().unwrap_or_else(PoisonError::into_inner);
    let made = setup::source(field, settings, device.candidate(), &mut kept.in_use, &Task::silent()).unwrap();
    kept.limits.extend(made.source.energy().cloned());
    made.source
}

/// Returns the limit of energy of `field` for the colours of `settings`, if there is one.
pub fn limit(field: &HeightField, settings: &SourceSettings) -> Option<Arc<EnergyMap>> {
    let place = KEPT.of(&name_of(field));
    let mut kept = place.lock().unwrap_or_else(PoisonError::into_inner);
    let (limit, _) = colour_limit(field, settings, &mut kept.in_use, &Task::silent()).unwrap();
    kept.limits.extend(limit.clone());
    limit
}
