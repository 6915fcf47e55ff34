//! Colour tables: the spectrum integrated once, over the directions along the surface.
//!
//! XYZ of Σ weight·q²·|P|² depends on (u, v, w) alone, for one surface, window and illuminant. It is smooth in w, so a few
//! cubics in w hold it, and it varies over (u, v) on the scale that the window sets. A table has the coefficients of these
//! cubics at each place of a square grid over −(u, v). Through repeats of the patch it is the same, with other wavelengths. It holds intensities, so its mip levels, averages of it,
//! are what a pixel sees that covers a range of (u, v).
//!
//! The shader's part is `shaders/table.glsl`; `shaders/bake.comp` makes the values.

pub mod aperture;
pub mod bake;
pub mod cache;
pub mod grid;
pub mod nodes;
pub mod pyramid;
pub mod rings;

pub use grid::Grid;

use super::shading::Shading;
use crate::cache::Store;
use crate::error::{Error, Result};
use crate::optics::orders::Colours;
use crate::precompute::{self, Layers, Settings, compute, compute_at};
use crate::surface::HeightField;
use crate::vk::device::Device;
use aperture::Aperture;
use glam::DVec2;
use rings::{Rings, Wavelengths};
use std::sync::Arc;

/// How a picture reads a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// What the pixel's centre sees, as the other methods show it.
    #[default]
    Point,
    /// What all of the pixel sees: the average over its footprint in (u, v).
    Pixel,
}

impl Filter {
    /// The word for it on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Pixel => "pixel",
        }
    }

    /// Most samples along a footprint; 0: the centre alone. `MAX_TAPS` of the shader.
    pub fn taps(self) -> i32 {
        match self {
            Self::Pixel => 4,
            Self::Point => 0,
        }
    }

    /// Samples of each layer over a footprint with the edges `dx` and `dy` in (u, v): the twin of `table_xyz` in
    /// `shaders/table.glsl`.
    pub fn taps_over(self, grid: &Grid, dx: DVec2, dy: DVec2) -> usize {
        if self == Self::Point {
            return 1;
        }
        let (xx, yy, xy) = (dx.x * dx.x + dy.x * dy.x, dx.y * dx.y + dy.y * dy.y, dx.x * dx.y + dy.x * dy.y);
        let mean = 0.5 * (xx + yy);
        let spread = (0.5 * (xx - yy)).hypot(xy);
        let (longer, shorter) = ((mean + spread).sqrt().max(1e-9), (mean - spread).max(0.0).sqrt());
        (longer / shorter.max(grid.spacing)).ceil().clamp(1.0, f64::from(self.taps())) as usize
    }
}

/// A finished table on the host, ready for upload and for the disk.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTable {
    /// Where its texels stand.
    pub grid: Grid,
    /// σ of the window \[µm\], or what stands for it through repeats.
    pub sigma: f64,
    /// What a stored 1 stands for.
    pub unit: f32,
    /// Mip levels from the finest: RGBA texels of 16-bit floats, layer by layer, row by row from the smallest v. The finest
    /// has X, Y and Z beside each other and a layer a piece, the others a layer for each.
    pub levels: Vec<Vec<u16>>,
}

/// The smallest tolerance of a table: its texels are 16-bit floats, which round by up to 4.9e-4, and a colour sums a dozen.
pub const LEAST_TOLERANCE: f64 = 2e-3;

/// Fails where 16-bit floats cannot hold `tolerance`.
///
/// # Errors
/// With the reason and what to do.
pub fn check_tolerance(tolerance: f64) -> Result<()> {
    if tolerance >= LEAST_TOLERANCE {
        return Ok(());
    }
    Err(Error::failed(
        format!(
            "--method table holds 16-bit floats, whose rounding takes a tolerance of {LEAST_TOLERANCE:.0e} or more, and \
             {tolerance:.0e} is asked for"
        ),
        "ask for a larger --tolerance, or use --method spectral",
    ))
}

/// The table of `field` under `shading`, from the cache or baked and kept there; beside it, why it could not be kept.
/// `progress(what, done, of)` is called as work goes on; an error from it ends the work.
///
/// # Errors
/// For settings that a table cannot do; where the tolerance is below [`LEAST_TOLERANCE`], where table or layers do not fit
/// into the device or into this machine, where the surface takes more pieces in w than a table has, where the device is
/// lost, and what `progress` returns.
pub fn obtain(
    device: &Arc<Device>,
    field: &HeightField,
    shading: &Shading,
    progress: &Progress<'_>,
) -> Result<(ColorTable, Option<Error>)> {
    if shading.terms.is_some() {
        return Err(Error::usage(
            "--method table sums as many terms as its tolerance asks for",
            "leave --terms away, or use --method spectral",
        ));
    }
    shading.check_wavelengths()?;
    check_tolerance(shading.tolerance)?;
    let settings = bake::layer_settings(shading, device.candidate())?;
    let room = settings.memory_limit as u64;
    let aperture = Aperture::new(field, shading.coherence);
    // What is hopeless is refused before any work: a table has at least one piece.
    let least = Grid::new(aperture.width(), shading.tolerance, 1);
    least.check(device.candidate().max_side, room, aperture.smaller())?;
    bake::check_wavelengths(&aperture, &shading.clone().for_pictures(), least.outer())?;
    let store = Store::open();
    let key = cache::key(field, &settings, shading)?;
    if let Some(table) = store.as_ref().and_then(|store| cache::load(store, &key, room)) {
        return Ok((table, None));
    }
    // The layers' file may serve another illuminant, too.
    let (layers, _) = precompute::cache::obtain(field, &settings, &|done, of| progress("spectra", done, of))?;
    let table = make(device, (field, layers, &settings), shading, progress)?;
    let kept = store.map(|store| cache::save(&store, &key, &table));
    Ok((table, kept.and_then(Result::err)))
}

/// Called with what is done, how much of it, and of how much.
pub type Progress<'a> = dyn Fn(&'static str, usize, usize) -> Result<()> + 'a;

/// Bakes the table of `field` under `shading`: `layers`, made for `settings`, are those of the window at the patch's centre;
/// the other windows' are made as they are needed.
///
/// # Errors
/// As [`obtain`].
pub fn make(
    device: &Arc<Device>,
    (field, layers, settings): (&HeightField, Layers, &Settings),
    shading: &Shading,
    progress: &Progress<'_>,
) -> Result<ColorTable> {
    check_tolerance(shading.tolerance)?;
    // A table is the same whatever asks for it.
    let shading = &shading.clone().for_pictures();
    let aperture = Aperture::new(field, shading.coherence);
    let pieces = nodes::needed(&layers, &aperture, shading)?;
    let grid = Grid::new(aperture.width(), shading.tolerance, pieces);
    grid.check(device.candidate().max_side, settings.memory_limit as u64, aperture.smaller())?;
    let rings = rings_for(&aperture, shading, [roughness(field), layers.z_max], grid.outer());
    let mut samples = bake::samples(&rings, &grid);
    let [n, m] = shading.windows;
    let steps = (n * m) as usize;
    let share = 1.0 / steps as f32;
    let patch = field.patch_size();
    let mut first = Some(layers);
    for window in 0..n * m {
        let place = [window % n, window / n];
        let shift = [0, 1].map(|i| f64::from(place[i]) / f64::from(shading.windows[i]) * patch[i]);
        let layers = match first.take() {
            Some(layers) => layers,
            None => {
                let spectra = |done, of| progress("spectra", done, of);
                match aperture {
                    Aperture::Gaussian(_) => compute_at(field, settings, shift, &spectra)?,
                    Aperture::Repeats(_) => compute(&field.begun_at(shift), settings, &spectra)?,
                }
            }
        };
        bake::bake(
            device,
            (&layers, &aperture),
            shading,
            (&rings, &grid),
            share,
            &mut samples,
            &|done, of| progress("colours", window as usize * of + done, steps * of),
        )?;
    }
    let [planes, near] = grid.squares().map(|square| rings.resampled(&square, &samples));
    drop(samples);
    let (unit, levels) = pyramid::texels(&grid, planes, near);
    Ok(ColorTable { grid, sigma: aperture.sigma(), unit, levels })
}

/// The rings of `aperture` under `shading`, out to |(u, v)| = `outer`; `turning` as [`Rings::new`] takes it.
fn rings_for(aperture: &Aperture, shading: &Shading, turning: [f64; 2], outer: f64) -> Rings {
    match aperture {
        Aperture::Gaussian(sigma) => {
            let combs = bake::true_combs(*sigma, shading);
            Rings::new(aperture, shading.tolerance, &Wavelengths::Combs(&combs), turning, outer)
        }
        Aperture::Repeats(_) => {
            let colours = Colours::new(&shading.illuminant, shading.quadrature());
            let all = Wavelengths::spectrum(&colours, aperture.band() * aperture.end() * outer);
            Rings::new(aperture, shading.tolerance, &all, turning, outer)
        }
    }
}

/// Standard deviation of the heights \[µm\].
fn roughness(field: &HeightField) -> f64 {
    let count = field.heights().len() as f64;
    let mean = field.heights().iter().sum::<f64>() / count;
    (field.heights().iter().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt()
}
