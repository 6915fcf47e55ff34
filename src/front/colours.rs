//! Colours of a surface in all directions, from a table, and its export for other programs.

use super::pair;
use crate::brdf::without_cosine;
use crate::cache::{Kept, Key};
use crate::context::Context;
use crate::error::{Error, Remedy, Result};
use crate::export::{self, ExportReader, ExportSettings, ExportedMaterial, MaterialDescription};
use crate::filter::Covariance;
use crate::notes;
use crate::optics::geometry::Pair;
use crate::settings::{Method, Optics};
use crate::surface::HeightField;
use crate::table::{ColorTable, TableReader};
use crate::task::Task;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// Colours of a surface in all directions, averaged over footprints, as a table that is read in no time.
#[derive(Clone)]
pub struct SurfaceColours {
    table: Arc<ColorTable>,
    reader: TableReader,
    optics: Optics,
    /// Surface and settings; `None` for the colours of an export.
    origin: Option<(HeightField, ExportSettings)>,
}

impl SurfaceColours {
    /// Makes the colours of `field` under `optics`, for footprints of a standard deviation of (u, v) from `footprint` on; 0 for single directions. They are kept in the cache
    /// of `context`, or come from there.
    ///
    /// # Errors
    /// Fails for settings that a table cannot have, if there is too little memory, or if the task is cancelled.
    pub fn new(
        field: &HeightField,
        optics: &Optics,
        footprint: f64,
        context: &Context,
        task: &Task,
    ) -> Result<Self> {
        let settings = settings(optics, footprint)?;
        let key = Key::new(
            &ColorTable::FORMAT,
            &(
                ("export", settings.sigma, settings.beyond, &settings.illuminant, &settings.reflectance),
                (settings.tolerance, settings.wavelengths, settings.footprint),
            ),
            field,
        )?;
        let kept = context.store().and_then(|store| store.load_kept(&key, u64::MAX));
        let table = match kept {
            Some(table) => table,
            None => {
                let table = context.run(|| ExportedMaterial::table(field, &settings, task))?;
                if let Some(Err(e)) = context.store().map(|store| store.save_kept(&key, &table)) {
                    context.tell(&e.at("the colour table cannot be kept for next time"));
                }
                table
            }
        };
        Ok(Self { origin: Some((field.clone(), settings)), ..Self::of(table, optics.clone()) })
    }

    /// Reads the colours of the export in `folder`.
    ///
    /// # Errors
    /// Fails for a folder that is no export, and for one that is damaged or of a newer version.
    pub fn open(folder: impl AsRef<Path>) -> Result<Self> {
        Ok(Self::of(ExportReader::open(folder.as_ref())?.table()?, Optics::default()))
    }

    fn of(table: ColorTable, optics: Optics) -> Self {
        let table = Arc::new(table);
        Self { reader: TableReader::new(Arc::clone(&table)), table, optics, origin: None }
    }

    /// Returns the size of the table \[bytes\].
    pub fn bytes(&self) -> usize {
        self.table.bytes()
    }

    /// Returns XYZ of f \[1/sr\] for every pair of directions to the light and to the viewer, averaged over a round footprint of the standard deviation `footprint` of
    /// (u, v); 0 below the horizon.
    pub fn xyz(&self, directions: &[[[f64; 3]; 2]], footprint: f64) -> Vec<[f64; 3]> {
        let footprint = Covariance::round(footprint);
        directions.iter().map(|directions| self.read(pair(directions), &footprint)).collect()
    }

    /// Returns XYZ of f \[1/sr\] as [`Self::xyz`], each averaged over the footprint of its own with these variances and this covariance of (u, v): uu, uv, vv.
    pub fn xyz_over(&self, questions: &[([[f64; 3]; 2], [f64; 3])]) -> Vec<[f64; 3]> {
        let read = |(directions, [uu, uv, vv]): &([[f64; 3]; 2], [f64; 3])| {
            self.read(pair(directions), &Covariance { uu: *uu, uv: *uv, vv: *vv })
        };
        questions.iter().map(read).collect()
    }

    fn read(&self, pair: Pair, footprint: &Covariance) -> [f64; 3] {
        let weighted = self.reader.xyz(&pair, &self.optics.reflectance, footprint);
        without_cosine(&pair, weighted).to_array()
    }

    /// Writes these colours into a `folder` for other programs, as [`Self::export`] does.
    ///
    /// # Errors
    /// Fails for colours that were read from an export, for a folder that is no export or cannot be written, or if the task is cancelled.
    pub fn save(&self, folder: impl AsRef<Path>, task: &Task) -> Result<()> {
        let Some((field, settings)) = &self.origin else {
            return Err(Error::usage("these colours are those of an export", "copy its folder"));
        };
        export::check_target(folder.as_ref())?;
        let material = ExportedMaterial::of_table(Arc::clone(&self.table), field, settings, task)?;
        write(folder.as_ref(), field, settings, &material)
    }

    /// Writes the colours of `field` under `optics` into a `folder` for other programs: textures, shaders, and directions with exact colours to check them by. A former export
    /// there is replaced.
    ///
    /// # Errors
    /// Those of [`Self::new`]; fails for a folder that is no export or cannot be written.
    pub fn export(
        field: &HeightField,
        optics: &Optics,
        footprint: f64,
        folder: impl AsRef<Path>,
        task: &Task,
    ) -> Result<()> {
        let settings = settings(optics, footprint)?;
        export::check_target(folder.as_ref())?;
        let material = ExportedMaterial::new(field, &settings, task)?;
        write(folder.as_ref(), field, &settings, &material)
    }
}

/// Writes `material` of `field` into `folder`.
fn write(
    folder: &Path,
    field: &HeightField,
    settings: &ExportSettings,
    material: &ExportedMaterial,
) -> Result<()> {
    let maker = notes::software().to_owned();
    let mut description = MaterialDescription::new(field, settings, material, maker)?;
    export::write(folder, material, &mut description)
}

impl fmt::Debug for SurfaceColours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SurfaceColours").field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}

/// Reads every file of the export in `folder`, and returns the relative L2 error of its colours against the exact ones.
///
/// # Errors
/// Fails for a folder that is no export, and for a file that is missing, truncated or damaged.
pub fn check_export(folder: impl AsRef<Path>) -> Result<f64> {
    Ok(ExportReader::open(folder.as_ref())?.check()?.errors().relative_l2)
}

/// Returns the settings of a table of `optics`, checked.
fn settings(optics: &Optics, footprint: f64) -> Result<ExportSettings> {
    Optics { method: Method::Table, ..optics.clone() }.checked()?.export_settings(footprint)
}

#[doc(hidden)]
impl Optics {
    /// Returns the settings of an export for footprints from `footprint` on, a standard deviation of (u, v).
    ///
    /// # Errors
    /// Fails if the coherence is not Gaussian.
    pub fn export_settings(&self, footprint: f64) -> Result<ExportSettings> {
        let sigma = self.coherence.sigma();
        Ok(ExportSettings {
            sigma: sigma.ok_or_else(|| {
                Error::usage("a colour table is of Gaussian coherence", Remedy::GaussianCoherence)
            })?,
            beyond: self.beyond,
            illuminant: self.illuminant.clone(),
            reflectance: self.reflectance.clone(),
            tolerance: self.tolerance,
            wavelengths: self.wavelengths,
            footprint,
            most_bytes: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front::direction;
    use crate::surface::synth::{Spec, SurfaceKind};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::{fs, thread};

    /// Asks for the colours of a coarse table; returns them, and the number of reports that making it took.
    fn colours(context: &Context, tolerance: f64) -> (Vec<[f64; 3]>, usize) {
        let field = HeightField::generate(&Spec::new(SurfaceKind::Sinusoid)).unwrap();
        let optics = Optics::new().with_coherence_length(20.0).with_tolerance(tolerance);
        let reports = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&reports);
        let task = Task::reporting(move |_| {
            counted.fetch_add(1, Ordering::Relaxed);
        });
        let colours = SurfaceColours::new(&field, &optics, 0.02, context, &task).unwrap();
        let pairs = [10.0, 20.0, 30.0].map(|angle| [direction(30.0, 0.0), direction(angle, 180.0)]);
        (colours.xyz(&pairs, 0.02), reports.load(Ordering::Relaxed))
    }

    #[test]
    fn two_contexts_with_caches_of_their_own_work_side_by_side() {
        let folder = tempfile::tempdir().unwrap();
        let context = &|name: &str| {
            Context::default().with_cache(folder.path().join(name), 1 << 30).with_threads(1).unwrap()
        };
        let [one, two] = thread::scope(|scope| {
            let started = ["one", "two"].map(|name| scope.spawn(move || colours(&context(name), 5e-2)));
            started.map(|thread| thread.join().unwrap())
        });
        assert_eq!(one.0, two.0);
        assert!(one.1 > 0 && two.1 > 0, "each has made its own");
        let files = |name: &str| fs::read_dir(folder.path().join(name)).unwrap().count();
        assert_eq!((files("one"), files("two")), (1, 1));
        let again = colours(&context("one"), 5e-2);
        assert_eq!((again.0, again.1), (one.0, 0), "from the cache, without work");
        assert!(colours(&context("one"), 1e-1).1 > 0, "another tolerance is another table");
        assert_eq!((files("one"), files("two")), (2, 1));
    }

    #[test]
    fn footprints_are_standard_deviations_and_covariances() {
        let field = HeightField::generate(&Spec::new(SurfaceKind::Sinusoid)).unwrap();
        let optics = Optics::new().with_coherence_length(20.0).with_tolerance(5e-2);
        let colours =
            SurfaceColours::new(&field, &optics, 0.02, &Context::default(), &Task::silent()).unwrap();
        // Across two orders of 550 nm.
        let pairs: Vec<_> =
            (0..60).map(|i| [direction(30.0, 0.0), direction(10.0 + 0.3 * f64::from(i), 180.0)]).collect();
        let spread = |deviation: f64| {
            let values: Vec<f64> = colours.xyz(&pairs, deviation).into_iter().map(|[_, y, _]| y).collect();
            let (low, high) = values.iter().fold((f64::INFINITY, 0.0f64), |(l, h), y| (l.min(*y), h.max(*y)));
            (high - low) * values.len() as f64 / values.iter().sum::<f64>()
        };
        assert!(spread(0.3) < 0.5 * spread(0.02), "{} {}", spread(0.3), spread(0.02));
        let asked: Vec<_> = pairs.iter().map(|pair| (*pair, [0.3 * 0.3, 0.0, 0.3 * 0.3])).collect();
        assert_eq!(colours.xyz_over(&asked), colours.xyz(&pairs, 0.3));
    }

    #[test]
    fn an_export_is_read_checked_and_has_the_colours_of_its_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("material");
        let field = HeightField::generate(&Spec::new(SurfaceKind::Sinusoid)).unwrap();
        let optics = Optics::new().with_coherence_length(20.0).with_tolerance(5e-2);
        SurfaceColours::export(&field, &optics, 0.02, &path, &Task::silent()).unwrap();
        assert!(check_export(&path).unwrap() < 5e-2);
        let [made, read] = [
            SurfaceColours::new(&field, &optics, 0.02, &Context::default(), &Task::silent()).unwrap(),
            SurfaceColours::open(&path).unwrap(),
        ];
        let pairs =
            [[direction(30.0, 0.0), direction(14.0, 180.0)], [direction(91.0, 0.0), direction(0.0, 0.0)]];
        assert_eq!(made.xyz(&pairs, 0.02), read.xyz(&pairs, 0.02));
        assert!(made.xyz(&pairs, 0.02)[0][1] > 0.0 && made.xyz(&pairs, 0.02)[1] == [0.0; 3]);
        assert!(SurfaceColours::open(folder.path()).is_err());
        let again = folder.path().join("again");
        made.save(&again, &Task::silent()).unwrap();
        assert_eq!(check_export(&again).unwrap(), check_export(&path).unwrap(), "the same files");
        assert!(read.save(folder.path().join("copy"), &Task::silent()).is_err(), "without a surface");
    }
}
