//! Preparation of sources from a height field and settings; used by every command and by the viewer.

mod brdf;
mod energy;
mod picture;

pub use brdf::for_each_window;
pub use energy::{colour_limit, single_limit};
pub use picture::{ObjectSurface, PictureSettings, PreparedScene, own_view, picture};

use crate::brdf::energy_map::EnergyMap;
use crate::budget::{ErrorBudget, Purpose};
use crate::cache::{Kept, Key, Store};
use crate::context::Context;
use crate::error::{Error, Remedy, Result};
use crate::filter::FootprintSizes;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::orders::Repeats;
use crate::optics::spectrum::{MIDDLE, SHORTEST};
use crate::render::source::{Grating, Source, Table};
use crate::settings::{Method, Optics};
use crate::spectra::amplitude::{self, LayerSettings, Layers, compute_at};
use crate::spectra::power::{Blur, OrderSeries, PowerSettings};
use crate::surface::HeightField;
use crate::table::{self, ColorTable, TableSettings, bake};
use crate::task::Task;
use crate::tolerance;
use crate::vk::selection::Candidate;
use std::sync::{Arc, LazyLock, Weak};

/// Settings that determine a source, in addition to the height field.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSettings {
    /// Settings of the optics.
    pub optics: Optics,
    /// Shortest wavelength that is evaluated \[µm\].
    pub shortest: f64,
    /// Offset of the window's centre from that of the patch \[µm\].
    pub shift: [f64; 2],
    /// Sizes of the pixels' footprints; 0 for single directions.
    pub footprints: FootprintSizes,
    /// True for a BRDF of each window, even where their mean is computed at once.
    pub windows_apart: bool,
}

impl SourceSettings {
    /// Returns settings for colours, with the window at the centre of the patch.
    pub fn new(optics: Optics) -> Self {
        let footprints = FootprintSizes::default();
        Self { optics, shortest: SHORTEST, shift: [0.0; 2], footprints, windows_apart: false }
    }
}

/// Source, and the reason if the cache could not keep it.
pub struct Made {
    /// Source.
    pub source: Source,
    /// Note for the user.
    pub note: Option<Error>,
}

/// Data that requests share: that in use elsewhere, the series of the last table, and what a cache on disk keeps. The default has no cache.
#[derive(Default)]
pub struct InUse {
    store: Option<Store>,
    layers: Known<Layers>,
    tables: Known<ColorTable>,
    energies: Known<EnergyMap>,
    series: Option<KeptSeries>,
}

/// Series that is reused for further tables of the same surface, under another light or of another tolerance.
struct KeptSeries {
    // Hash of the field and of all settings except the error.
    key: Key,
    // Error that was requested.
    asked: f64,
    series: Arc<OrderSeries>,
}

impl InUse {
    /// Returns no data so far, with the cache of `context`.
    pub fn new(context: &Context) -> Self {
        Self { store: context.store().cloned(), ..Self::default() }
    }

    /// Largest size of a kept series \[bytes\].
    const MOST_KEPT: usize = 64 << 20;

    /// Returns the series of `field` under `settings`: the kept one if a new one would be the same, otherwise a new
    /// one.
    fn series(
        &mut self,
        field: &HeightField,
        settings: &PowerSettings,
        task: &Task,
    ) -> Result<Arc<OrderSeries>> {
        let key = Key::new(&ColorTable::FORMAT, &PowerSettings { error: 0.0, ..*settings }, field)?;
        // A series gets more terms until the measured error suffices.
        let serves = |kept: &&KeptSeries| {
            kept.key == key && kept.asked >= settings.error && kept.series.error <= settings.error
        };
        if let Some(kept) = self.series.as_ref().filter(serves) {
            return Ok(kept.series.clone());
        }
        self.series = None;
        let series = Arc::new(OrderSeries::new(field, settings, task)?);
        if size_of_val(series.coefficients()) <= Self::MOST_KEPT {
            self.series = Some(KeptSeries { key, asked: settings.error, series: series.clone() });
        }
        Ok(series)
    }
}

/// Data of one kind by key, as long as it is in use.
type Known<T> = Vec<(Key, Weak<T>)>;

/// Returns the source of `field` under `settings` on a device with these `limits`: from the data `in_use`, from the
/// cache on disk, or made and cached.
///
/// # Errors
/// Fails for settings that the method does not support, if the data does not fit into the device or this machine, or
/// if the task is cancelled.
pub fn source(
    field: &HeightField,
    settings: &SourceSettings,
    limits: &Candidate,
    in_use: &mut InUse,
    task: &Task,
) -> Result<Made> {
    settings.optics.check()?;
    let made = unlimited_source(field, settings, limits, in_use, task);
    let Made { source, note } = made.map_err(|refusal| {
        tolerance::with_least(refusal, settings.optics.tolerance, |tolerance| {
            let optics = Optics { tolerance, ..settings.optics.clone() };
            let settings = SourceSettings { optics, ..settings.clone() };
            check_source(field, &settings, limits, in_use, task)
        })
    })?;
    let (energy, other) = colour_limit(field, settings, in_use, task)?;
    Ok(Made { source: source.limited(energy), note: note.or(other) })
}

/// Returns [`source`] without a limit of energy.
fn unlimited_source(
    field: &HeightField,
    settings: &SourceSettings,
    limits: &Candidate,
    in_use: &mut InUse,
    task: &Task,
) -> Result<Made> {
    let optics = &settings.optics;
    match (optics.method, optics.coherence) {
        (Method::Reference, _) => Err(Error::usage(
            "the f64 reference has no device to shade on",
            [Remedy::SpectralMethod, Remedy::TableMethod],
        )),
        (Method::Table, _) => {
            let (table, note) = table(field, settings, limits, in_use, task)?;
            Ok(Made { source: Source::Table(Table { table, energy: None }), note })
        }
        (Method::Spectral, Coherence::Gaussian { length }) => {
            let (layers, note) = layers(field, settings, length / 4.0, limits, in_use, task)?;
            Ok(Made { source: Source::window(layers), note })
        }
        (Method::Spectral, Coherence::Repeats(copies)) => {
            let repeats = Repeats { copies, period: field.patch_size() };
            // Shifting a grating is equivalent to shifting the surface.
            let begun = field.begun_at(settings.shift);
            let settings = SourceSettings { shift: [0.0; 2], ..settings.clone() };
            let (layers, note) = layers(&begun, &settings, f64::INFINITY, limits, in_use, task)?;
            Ok(Made { source: Source::Grating(Grating { layers, repeats, energy: None }), note })
        }
    }
}

/// Fails if [`unlimited_source`] would. Spectra are made, and kept for the request that names their tolerance; a colour table, which takes far longer, is
/// planned only.
fn check_source(
    field: &HeightField,
    settings: &SourceSettings,
    limits: &Candidate,
    in_use: &mut InUse,
    task: &Task,
) -> Result<()> {
    settings.optics.check()?;
    if settings.optics.method == Method::Table {
        let series = in_use.series(field, &settings.power_settings()?, task)?;
        return table::check(&series, &settings.table_settings(limits));
    }
    unlimited_source(field, settings, limits, in_use, task).map(drop)
}

/// Returns spectra through a Gaussian window of standard deviation `sigma` \[µm\], or of one period if `sigma` is
/// infinite.
fn layers(
    field: &HeightField,
    settings: &SourceSettings,
    sigma: f64,
    limits: &Candidate,
    in_use: &mut InUse,
    task: &Task,
) -> Result<(Arc<Layers>, Option<Error>)> {
    let layers = layer_settings(&settings.optics, sigma, settings.shortest, limits)?;
    let key = amplitude::cache::key(field, &layers, settings.shift)?;
    let wanted = Wanted { key, name: "the spectra", memory_limit: amplitude::cache::memory_limit(&layers) };
    let make = |_: &mut InUse| compute_at(field, &layers, settings.shift, task);
    wanted.obtain(in_use, |in_use| &mut in_use.layers, make)
}

/// Returns the colour table of the mean.
fn table(
    field: &HeightField,
    settings: &SourceSettings,
    limits: &Candidate,
    in_use: &mut InUse,
    task: &Task,
) -> Result<(Arc<ColorTable>, Option<Error>)> {
    check_patch(field, settings.optics.beyond)?;
    let baked = settings.table_settings(limits);
    let wanted = Wanted {
        key: Key::new(&ColorTable::FORMAT, &(settings.power_settings()?, &baked), field)?,
        name: "the colour table",
        memory_limit: baked.memory_limit as u64,
    };
    let powers = settings.power_settings()?;
    let make = |in_use: &mut InUse| {
        let series = in_use.series(field, &powers, task)?;
        bake(&series, &baked, task)
    };
    wanted.obtain(in_use, |in_use| &mut in_use.tables, make)
}

/// Checks that a table of `field` is as exact as it promises.
fn check_patch(field: &HeightField, beyond: Beyond) -> Result<()> {
    /// Shortest side of a patch that goes on alike \[µm\]. The transform of the lag window is as wide as the sphere of directions for shorter ones,
    /// and its side lobes, which a table does not hold, err by up to 9 times the tolerance.
    const SHORTEST_ALIKE: f64 = 1.0;
    let [width, height] = field.patch_size();
    if beyond == Beyond::Copies || width.min(height) >= SHORTEST_ALIKE {
        return Ok(());
    }
    Err(Error::usage(
        format!(
            "a patch of {width:.3} x {height:.3} um says too little about a surface that goes on alike for a colour table, which takes {SHORTEST_ALIKE} um"
        ),
        [Remedy::LargerPatch, Remedy::CopiesBeyond],
    ))
}

/// Key and limits of data that a source needs.
struct Wanted {
    key: Key,
    // Name in progress and notes for the user.
    name: &'static str,
    // Largest size in memory \[bytes\].
    memory_limit: u64,
}

impl Wanted {
    /// Returns the data: from the list `known` of data in use, from the cache on disk, or from `make`; and the reason
    /// if the cache could not keep it.
    fn obtain<T: Kept>(
        &self,
        in_use: &mut InUse,
        known: impl Fn(&mut InUse) -> &mut Known<T>,
        make: impl FnOnce(&mut InUse) -> Result<T>,
    ) -> Result<(Arc<T>, Option<Error>)> {
        if let Some(data) = in_use_of(known(in_use), &self.key) {
            return Ok((data, None));
        }
        let store = in_use.store.clone();
        let kept = store.as_ref().and_then(|store| store.load_kept(&self.key, self.memory_limit));
        let (data, note) = match kept {
            Some(data) => (data, None),
            None => {
                let made = make(in_use)?;
                let outcome = store.map_or(Ok(()), |store| store.save_kept(&self.key, &made));
                let name = self.name;
                (made, outcome.err().map(|e| e.at(format!("{name} cannot be kept for next time"))))
            }
        };
        let data = Arc::new(data);
        known(in_use).push((self.key, Arc::downgrade(&data)));
        Ok((data, note))
    }
}

/// Returns a source that does not diffract, so that the pigment alone is visible. It takes no time to make.
pub fn pigment_alone() -> Source {
    static DARK: LazyLock<Arc<ColorTable>> = LazyLock::new(|| Arc::new(ColorTable::dark()));
    Source::Table(Table { table: DARK.clone(), energy: None })
}

/// Returns true if the source of `settings` averages over the footprints of pixels.
pub fn averages_footprints(settings: &SourceSettings) -> bool {
    settings.optics.method == Method::Table
}

/// Returns the memory for a source on a device with these `limits`; pictures and the rest share the remainder.
fn memory_limit(limits: &Candidate) -> usize {
    /// Fraction of the device's memory.
    const DEVICE_SHARE: f64 = 0.75;
    (limits.memory as f64 * DEVICE_SHARE) as usize
}

/// Returns the settings of layers for wavelengths from `shortest` \[µm\] on a device with these `limits`, for a Gaussian
/// window of standard deviation `sigma` \[µm\], or for one period if `sigma` is infinite.
///
/// # Errors
/// Fails if more than one window is to be averaged over.
pub fn layer_settings(
    optics: &Optics,
    sigma: f64,
    shortest: f64,
    limits: &Candidate,
) -> Result<LayerSettings> {
    if optics.windows != Windows::ONE {
        return Err(Error::usage(
            "spectra through a window are of one window",
            [Remedy::AllWindows, Remedy::OneWindow, Remedy::ReferenceMethod],
        ));
    }
    Ok(LayerSettings {
        sigma,
        shortest_wavelength: shortest,
        budget: optics.budget().window,
        basis: optics.basis,
        terms: optics.terms,
        memory_limit: memory_limit(limits),
        side_limit: limits.max_side as usize,
    })
}

impl SourceSettings {
    /// Returns the standard deviation of the coherence window of the mean \[µm\].
    fn power_sigma(&self) -> Result<f64> {
        self.optics.coherence.sigma().ok_or_else(|| {
            Error::usage("the mean over all windows is of Gaussian coherence", Remedy::GaussianCoherence)
        })
    }

    /// Returns the standard deviation of (u, v) due to coherence at the middle of the spectrum; `None` for finite
    /// gratings.
    fn coherence_spread(&self) -> Option<f64> {
        let sigma = self.optics.coherence.sigma()?;
        Some(MIDDLE * Blur::of_coherence(sigma).variance[0].sqrt())
    }

    /// Returns the standard deviation of the smallest footprint, rounded down to 2ⁿ times that of coherence at the
    /// middle of the spectrum, or 0 below it. Close views thus share a source.
    fn finest(&self) -> f64 {
        let Some(coherence) = self.coherence_spread() else { return 0.0 };
        let octave = (self.footprints.shorter / coherence).log2().floor();
        if octave >= 0.0 { coherence * octave.exp2() } else { 0.0 }
    }

    /// Returns the shares of the tolerance. A plate has few orders of any surface in view, so that its pixels do not
    /// average reading errors.
    fn budget(&self) -> ErrorBudget {
        /// Ratio of footprint to blur from which a footprint is averaged by a row of taps.
        const LONG: f64 = 2.0;
        let FootprintSizes { shorter, longer } = self.footprints;
        let is_long =
            self.coherence_spread().is_some_and(|coherence| longer > LONG * coherence.hypot(shorter));
        self.optics.budget_of_footprints(is_long && self.optics.purpose == Purpose::Picture)
    }

    /// Returns the settings of the series of orders for a colour table.
    fn power_settings(&self) -> Result<PowerSettings> {
        Ok(self.power_settings_of(self.power_sigma()?))
    }

    /// Returns the settings of a series of orders for a coherence window of standard deviation `sigma` \[µm\].
    fn power_settings_of(&self, sigma: f64) -> PowerSettings {
        PowerSettings {
            sigma,
            beyond: self.optics.beyond,
            shortest: self.shortest,
            error: self.budget().mean.series,
        }
    }

    /// Returns the settings of the colour table.
    fn table_settings(&self, limits: &Candidate) -> TableSettings {
        TableSettings {
            illuminant: self.optics.illuminant.clone(),
            reflectance: Some(&self.optics.reflectance).filter(|r| r.is_spectral()).cloned(),
            wavelengths: self.optics.wavelengths,
            budget: self.budget().mean,
            finest: self.finest(),
            side_limit: limits.max_side as usize,
            memory_limit: memory_limit(limits),
        }
    }
}

/// Returns the data with this `key`, and removes entries that are no longer in use.
fn in_use_of<T>(known: &mut Known<T>, key: &Key) -> Option<Arc<T>> {
    known.retain(|(_, data)| data.strong_count() > 0);
    known.iter().find(|(known_key, _)| known_key == key).and_then(|(_, data)| data.upgrade())
}
