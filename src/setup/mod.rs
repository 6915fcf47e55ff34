//! From a height field and settings to what is shaded from: what every command and the viewer start with.

mod brdf;
mod picture;

pub use brdf::for_each_window;
pub use picture::{ObjectSurface, PictureSettings, PreparedScene, own_view, picture};

use crate::budget::{ErrorBudget, Purpose};
use crate::cache::{Kept, Key, Store};
use crate::error::{Error, Remedy, Result};
use crate::filter::FootprintSizes;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::orders::Repeats;
use crate::optics::spectrum::{MIDDLE, SHORTEST};
use crate::render::shading::Shading;
use crate::render::source::{Grating, Source, Table};
use crate::spectra::amplitude::{self, Layers, compute_at};
use crate::spectra::power::{Blur, OrderSeries, PowerSettings};
use crate::surface::{HeightField, tiling};
use crate::table::{ColorTable, TableSettings, bake};
use crate::vk::selection::Candidate;
use std::sync::{Arc, LazyLock, Weak};

/// How the optics is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// A sum over wavelengths: of one window or a finite grating on the device, of the mean for single directions on the CPU.
    #[default]
    Spectral,
    /// A colour table of the mean, read on the device.
    Table,
    /// The f64 reference, on the CPU.
    Reference,
}

impl Method {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spectral => "spectral",
            Self::Table => "table",
            Self::Reference => "reference",
        }
    }
}

/// Everything that a source follows from beside the height field.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// By which method.
    pub method: Method,
    /// The optics.
    pub shading: Shading,
    /// Shortest wavelength that will be asked for \[µm\].
    pub shortest: f64,
    /// The window's centre from that of the patch \[µm\].
    pub shift: [f64; 2],
    /// Whether the result is worth a place in the cache on disk.
    pub cached: bool,
    /// How large the pixels' footprints are; 0 where single directions are asked for.
    pub footprints: FootprintSizes,
}

impl Settings {
    /// A window in the middle, for colours.
    pub fn new(method: Method, shading: Shading) -> Self {
        Self {
            method,
            shading,
            shortest: SHORTEST,
            shift: [0.0; 2],
            cached: true,
            footprints: FootprintSizes::default(),
        }
    }
}

/// Called with what is made, steps done and steps in all, as far as they are known; an error from it cancels the work.
pub type Progress<'a> = dyn Fn(&'static str, usize, usize) -> Result<()> + 'a;

/// A source, and why it could not be kept for next time, where that is so.
pub struct Made {
    /// The source.
    pub source: Source,
    /// For the user.
    pub note: Option<Error>,
}

pub use crate::table::LEAST_TOLERANCE as LEAST_TABLE_TOLERANCE;

/// Data that is still in use somewhere, for requests that share it, and the series that the last table was baked from.
#[derive(Default)]
pub struct InUse {
    layers: Known<Layers>,
    tables: Known<ColorTable>,
    series: Option<KeptSeries>,
}

/// Series that the next table of the same surface is baked from, too: under another light, of another tolerance.
struct KeptSeries {
    // Hash of the field and of all settings but the error.
    key: Key,
    // Error that it was asked for.
    asked: f64,
    series: Arc<OrderSeries>,
}

impl InUse {
    /// Most bytes of series that are kept.
    const MOST_KEPT: usize = 64 << 20;

    /// Returns the series of `field` under `settings`: the kept one if making it anew would give the same, else a new one.
    fn series(
        &mut self,
        field: &HeightField,
        settings: &PowerSettings,
        progress: &Progress<'_>,
    ) -> Result<Arc<OrderSeries>> {
        let key = Key::new(&ColorTable::FORMAT, &PowerSettings { error: 0.0, ..*settings }, field)?;
        // Making takes ever more terms until the measured error suffices.
        let serves = |kept: &&KeptSeries| {
            kept.key == key && kept.asked >= settings.error && kept.series.error <= settings.error
        };
        if let Some(kept) = self.series.as_ref().filter(serves) {
            return Ok(kept.series.clone());
        }
        self.series = None;
        let series = Arc::new(OrderSeries::new(field, settings, &|done, of| progress("orders", done, of))?);
        if size_of_val(series.coefficients()) <= Self::MOST_KEPT {
            self.series = Some(KeptSeries { key, asked: settings.error, series: series.clone() });
        }
        Ok(series)
    }
}

/// Data of one kind by its key, as long as it is in use.
type Known<T> = Vec<(Key, Weak<T>)>;

/// The source of `field` under `settings` on a device of these `limits`: from what is `in_use`, from the cache on disk, or made and kept there.
///
/// # Errors
/// For settings that the method cannot do, where the data does not fit into the device or this machine, and what `progress` returns.
pub fn source(
    field: &HeightField,
    settings: &Settings,
    limits: &Candidate,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<Made> {
    let shading = &settings.shading;
    check(settings)?;
    match (settings.method, shading.coherence) {
        (Method::Reference, _) => Err(Error::usage(
            "the f64 reference has no device to shade on",
            [Remedy::SpectralMethod, Remedy::TableMethod],
        )),
        (Method::Table, _) => {
            let (table, note) = table(field, settings, limits, in_use, progress)?;
            Ok(Made { source: Source::Table(Table { table }), note })
        }
        (Method::Spectral, Coherence::Gaussian { length }) => {
            let (layers, note) = layers(field, settings, length / 4.0, limits, in_use, progress)?;
            Ok(Made { source: Source::window(layers), note })
        }
        (Method::Spectral, Coherence::Repeats(copies)) => {
            shading.check_wavelengths()?;
            let repeats = Repeats { copies, period: field.patch_size() };
            // A grating that begins elsewhere is the grating of a surface that does.
            let begun = field.begun_at(settings.shift);
            let settings = Settings { shift: [0.0; 2], ..settings.clone() };
            let (layers, note) = layers(&begun, &settings, f64::INFINITY, limits, in_use, progress)?;
            Ok(Made { source: Source::Grating(Grating { layers, repeats }), note })
        }
    }
}

/// Spectra through a Gaussian of standard deviation `sigma` \[µm\], or, where that is infinite, of one period.
fn layers(
    field: &HeightField,
    settings: &Settings,
    sigma: f64,
    limits: &Candidate,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<(Arc<Layers>, Option<Error>)> {
    let own = settings.shading.windowed_settings(sigma, settings.shortest, limits)?;
    let key = amplitude::cache::key(field, &own, settings.shift)?;
    let wanted = Wanted {
        key,
        name: "the spectra",
        memory_limit: amplitude::cache::memory_limit(&own),
        cached: settings.cached,
    };
    let make =
        |_: &mut InUse| compute_at(field, &own, settings.shift, &|done, of| progress("spectra", done, of));
    wanted.obtain(in_use, |in_use| &mut in_use.layers, make)
}

/// The colour table of the mean.
fn table(
    field: &HeightField,
    settings: &Settings,
    limits: &Candidate,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<(Arc<ColorTable>, Option<Error>)> {
    let own = settings.table_settings(limits);
    let wanted = Wanted {
        key: Key::new(&ColorTable::FORMAT, &(settings.power_settings()?, &own), field)?,
        name: "the colour table",
        memory_limit: own.memory_limit as u64,
        cached: settings.cached,
    };
    let powers = settings.power_settings()?;
    let make = |in_use: &mut InUse| {
        let series = in_use.series(field, &powers, progress)?;
        bake(&series, &own, &|done, of| progress("colours", done, of))
    };
    wanted.obtain(in_use, |in_use| &mut in_use.tables, make)
}

/// Data that a source needs.
struct Wanted {
    key: Key,
    // For the user.
    name: &'static str,
    // Most bytes that it may take.
    memory_limit: u64,
    // Whether the cache on disk keeps it.
    cached: bool,
}

impl Wanted {
    /// The data: from the list `known` of what is in use, from the cache on disk, or from `make`. Beside it, why it could not be kept, where
    /// that is so.
    fn obtain<T: Kept>(
        &self,
        in_use: &mut InUse,
        known: impl Fn(&mut InUse) -> &mut Known<T>,
        make: impl FnOnce(&mut InUse) -> Result<T>,
    ) -> Result<(Arc<T>, Option<Error>)> {
        if let Some(data) = find(known(in_use), &self.key) {
            return Ok((data, None));
        }
        let store = if self.cached { Store::open() } else { None };
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

/// A source that diffracts nothing, so that the pigment is seen alone. It takes no time to make.
pub fn pigment_alone() -> Source {
    static DARK: LazyLock<Arc<ColorTable>> = LazyLock::new(|| Arc::new(ColorTable::dark()));
    Source::Table(Table { table: DARK.clone() })
}

/// How the surface goes on beyond a patch like `field`, unless the user says: copies where they join without visible steps.
pub fn beyond_of(field: &HeightField) -> Beyond {
    match tiling::tiles(field).verdict {
        tiling::Verdict::Tiles => Beyond::Copies,
        _ => Beyond::Alike,
    }
}

/// True if the source of `settings` averages over the footprints of pixels.
pub fn averages_footprints(settings: &Settings) -> bool {
    settings.method == Method::Table
}

/// Fails for combinations that cannot be.
///
/// # Errors
/// With what to change.
pub fn check(settings: &Settings) -> Result<()> {
    let shading = &settings.shading;
    let gaussian = shading.coherence.sigma().is_some();
    match (settings.method, shading.windows) {
        (_, Windows::All) if !gaussian => Err(Error::usage(
            "a finite grating stands at one place, and a mean over all windows is of Gaussian coherence",
            [Remedy::OneWindow, Remedy::GaussianCoherence],
        )),
        (Method::Spectral, Windows::All) if shading.purpose == Purpose::Picture => Err(Error::usage(
            "pictures of the mean over all windows are read from a colour table",
            [Remedy::TableMethod, Remedy::OneWindow],
        )),
        (Method::Table, Windows::Grid(_)) => Err(Error::usage(
            "a colour table holds the mean over all windows",
            [Remedy::AllWindows, Remedy::SpectralMethod],
        )),
        (Method::Table, Windows::All) if shading.tolerance < LEAST_TABLE_TOLERANCE => Err(Error::usage(
            format!(
                "colours of a table err by about 1e-3 whatever the tolerance; the least that it keeps is {:e}",
                LEAST_TABLE_TOLERANCE
            ),
            match shading.purpose {
                Purpose::Directions => [Remedy::LargerTolerance, Remedy::SpectralMethod],
                Purpose::Picture => [Remedy::LargerTolerance, Remedy::OneWindow],
            },
        )),
        (_, Windows::All) if shading.terms.is_some() => Err(Error::usage(
            "the number of terms is that of the expansion for one window",
            [Remedy::OneWindow, Remedy::AutomaticTerms],
        )),
        _ => Ok(()),
    }
}

impl Settings {
    /// Share of the device's memory that a source may take; pictures and the rest need some.
    const DEVICE_SHARE: f64 = 0.75;

    fn memory_limit(limits: &Candidate) -> usize {
        (limits.memory as f64 * Self::DEVICE_SHARE) as usize
    }

    /// Standard deviation of the coherence window that the mean is of \[µm\].
    fn power_sigma(&self) -> Result<f64> {
        self.shading.coherence.sigma().ok_or_else(|| {
            Error::usage("the mean over all windows is of Gaussian coherence", Remedy::GaussianCoherence)
        })
    }

    /// Standard deviation of (u, v) that the coherence of light of the middle of the spectrum averages over; `None` for finite gratings.
    fn coherence_spread(&self) -> Option<f64> {
        let sigma = self.shading.coherence.sigma()?;
        Some(MIDDLE * Blur::of_coherence(sigma).variance[0].sqrt())
    }

    /// The least standard deviation of (u, v) that is averaged over, as far as it counts beside the blur by coherence: that of light of the middle of
    /// the spectrum times a power of 2, or 0 below. So all views from near share a source.
    fn finest(&self) -> f64 {
        let Some(coherence) = self.coherence_spread() else { return 0.0 };
        let octave = (self.footprints.shorter / coherence).log2().floor();
        if octave >= 0.0 { coherence * octave.exp2() } else { 0.0 }
    }

    /// Returns the shares of the tolerance. A plate sees few orders of any surface: nothing averages what its pixels read.
    fn budget(&self) -> ErrorBudget {
        /// Ratio of footprint and blur from which a row of taps stands for a footprint.
        const LONG: f64 = 2.0;
        let FootprintSizes { shorter, longer } = self.footprints;
        let is_long =
            self.coherence_spread().is_some_and(|coherence| longer > LONG * coherence.hypot(shorter));
        self.shading.budget_of_footprints(is_long && self.shading.purpose == Purpose::Picture)
    }

    /// Returns the settings of the orders' series that a colour table is baked from.
    fn power_settings(&self) -> Result<PowerSettings> {
        Ok(PowerSettings {
            sigma: self.power_sigma()?,
            beyond: self.shading.beyond,
            shortest: self.shortest,
            error: self.budget().mean.series,
        })
    }

    /// Returns the settings of the colour table.
    fn table_settings(&self, limits: &Candidate) -> TableSettings {
        TableSettings {
            illuminant: self.shading.illuminant.clone(),
            reflectance: Some(&self.shading.reflectance).filter(|r| r.is_spectral()).cloned(),
            wavelengths: self.shading.wavelengths,
            budget: self.budget().mean,
            finest: self.finest(),
            side_limit: limits.max_side as usize,
            memory_limit: Self::memory_limit(limits),
        }
    }
}

/// What is known by `key`; forgets what nobody uses any more.
fn find<T>(known: &mut Known<T>, key: &Key) -> Option<Arc<T>> {
    known.retain(|(_, data)| data.strong_count() > 0);
    known.iter().find(|(own, _)| own == key).and_then(|(_, data)| data.upgrade())
}
