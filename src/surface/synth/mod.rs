//! Generated height fields of published dimensions. Each file says which dimensions are published and which are chosen.
//!
//! All of them are periodic over their patch, because the patch is what repeats: its left edge meets the right one, its
//! top the bottom. A patch is therefore rounded to whole periods, the spacing of the samples to whole samples a patch.

mod analytic;
mod brushed;
mod disc_tracks;
mod grid;
mod ridges;
mod tulip;
mod waves;

use super::HeightField;
use crate::error::{Error, Result};
use grid::SampleGrid;

/// Kind of a built-in surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceKind {
    /// A mirror: height 0.
    Flat,
    /// h = a sin(2πx/d), d = 2 µm, full height 2a = 0.2 µm.
    Sinusoid,
    /// A sawtooth rising along +x, period 2.5 µm, full height 246.23 nm.
    Blaze,
    /// Ridges with straight flanks, 0.2 µm high, half as wide as their period of 2 µm: a lamellar grating.
    Lamellar,
    /// Round bumps 0.15 µm high on a lattice of 0.5 µm × 1 µm.
    Bumps,
    /// Finger-like micro-ridges as on the skin of *Elaphe*: 1.14 µm across, 0.43 µm high.
    Elaphe,
    /// Long, regular micro-ridges as on the skin of *Xenopeltis unicolor*: 1.55 µm across, 0.82 µm high.
    Xenopeltis,
    /// The data of a compact disc: tracks of pits 1.6 µm apart along `x`, 0.5 µm wide, 0.83 µm to 3.05 µm long, 0.12 µm high.
    Cd,
    /// The data of a DVD: tracks of pits 0.74 µm apart along `x`, 0.32 µm wide, 0.40 µm to 1.47 µm long, 0.105 µm high.
    Dvd,
    /// Finely brushed metal: scratches nearly along `y`, 0.4 µm apart on average, up to 0.5 µm deep. They spread light along `x`.
    Brushed,
    /// The long, irregular striations on petals of the tulip 'Queen of the Night': 1.2 µm apart along `x`, 0.5 µm high.
    Tulip,
}

/// Settings of a generated surface. What is not set is the default of its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Spec {
    /// Kind of surface.
    pub kind: SurfaceKind,
    /// Seed of the random generator: the same seed gives the same surface, bit for bit, on one platform. Surfaces with a formula have one
    /// form only ([`SurfaceKind::is_random`]).
    pub seed: u64,
    /// Wished side lengths of the patch \[µm\]; the nearest whole periods are made.
    pub patch: Option<[f64; 2]>,
    /// Largest sample spacing \[µm\]; the made one is smaller by less than one sample a patch.
    pub pixel_size: Option<[f64; 2]>,
    /// Period or mean distance along `x` \[µm\]; pits, scratches and ridges scale with it, along `y`, too.
    pub period: Option<f64>,
    /// Full height \[µm\].
    pub height: Option<f64>,
    /// Width of the ridges of a lamellar grating at half of their height, over the period.
    pub duty: Option<f64>,
    /// Width of the flanks of a lamellar grating \[µm\]; 0 for upright ones.
    pub flank: Option<f64>,
}

/// Default period of a lamellar grating \[µm\].
const LAMELLAR_PERIOD: f64 = 2.0;
/// Samples of a period of a profile with edges, or a divisor of them: edges at whole hundredths of the period stand between samples.
const PROFILE_SAMPLES: f64 = 100.0;

/// The dimensions of a kind \[µm\].
struct Dimensions {
    /// Lengths along `x` and `y` of which the patch holds a whole number: periods or mean distances; 0 if any length will do.
    period: [f64; 2],
    height: f64,
    /// Side of the square patch.
    patch: f64,
    /// Largest sample spacing that shows the finest structure; infinite if the limit from the wavelength of light is enough.
    spacing: f64,
    /// Samples of each period along `x`, where edges are to stand between samples.
    of_period: Option<usize>,
}

impl SurfaceKind {
    /// Every kind, from simple to rich.
    pub const ALL: [Self; 11] = [
        Self::Flat,
        Self::Sinusoid,
        Self::Blaze,
        Self::Lamellar,
        Self::Bumps,
        Self::Elaphe,
        Self::Xenopeltis,
        Self::Cd,
        Self::Dvd,
        Self::Brushed,
        Self::Tulip,
    ];

    /// Returns the name on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Sinusoid => "sinusoid",
            Self::Blaze => "blaze",
            Self::Lamellar => "lamellar",
            Self::Bumps => "bumps",
            Self::Elaphe => "elaphe",
            Self::Xenopeltis => "xenopeltis",
            Self::Cd => "cd",
            Self::Dvd => "dvd",
            Self::Brushed => "brushed",
            Self::Tulip => "tulip",
        }
    }
}

#[doc(hidden)]
impl SurfaceKind {
    /// Returns true if the surface depends on the seed.
    pub fn is_random(self) -> bool {
        !matches!(self, Self::Flat | Self::Sinusoid | Self::Blaze | Self::Lamellar | Self::Bumps)
    }

    /// Returns the kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    fn dimensions(self) -> Dimensions {
        /// Enough periods for sharp orders, few enough samples to compute with at once.
        const FORMULA_PATCH: f64 = 20.0;
        /// The side of the scans that the skins resemble, which is also the coherence length of sunlight.
        const RANDOM_PATCH: f64 = 65.0;
        let (period, height, patch) = match self {
            Self::Flat => ([0.0, 0.0], 0.0, FORMULA_PATCH),
            Self::Sinusoid => ([2.0, 0.0], 0.2, FORMULA_PATCH),
            Self::Blaze => ([2.5, 0.0], 0.246_23, FORMULA_PATCH),
            Self::Lamellar => ([LAMELLAR_PERIOD, 0.0], 0.2, FORMULA_PATCH),
            Self::Bumps => ([0.5, 1.0], 0.15, FORMULA_PATCH),
            // The rows of the Elaphe scan repeat every 3.1 µm (its spectrum peaks at 0.32 /µm along y).
            Self::Elaphe => ([1.14, 3.1], 0.43, RANDOM_PATCH),
            // The ridges of Xenopeltis are long; that they repeat every 6.5 µm is a choice, not a measurement.
            Self::Xenopeltis => ([1.55, 6.5], 0.82, RANDOM_PATCH),
            Self::Cd => (disc_tracks::CD.period(), disc_tracks::CD.height, RANDOM_PATCH),
            Self::Dvd => (disc_tracks::DVD.period(), disc_tracks::DVD.height, RANDOM_PATCH),
            Self::Brushed => ([brushed::DISTANCE, 0.0], brushed::HEIGHT, RANDOM_PATCH),
            Self::Tulip => ([tulip::DISTANCE, 0.0], tulip::HEIGHT, RANDOM_PATCH),
        };
        let spacing = match self {
            Self::Cd | Self::Dvd => disc_tracks::SPACING,
            _ => f64::INFINITY,
        };
        Dimensions { period, height, patch, spacing, of_period: None }
    }
}

impl Dimensions {
    /// Returns the dimensions with all lengths in the plane but the patch scaled to a period of `period` along `x`.
    fn with_period(self, period: f64) -> Self {
        let scale = period / self.period[0];
        Self { period: [period, self.period[1] * scale], spacing: self.spacing * scale, ..self }
    }

    /// Returns the dimensions with enough samples of each period along `x` for a profile with edges and for structures of the width `finest`.
    fn with_edges(self, finest: f64) -> Self {
        let least = self.period[0] / finest.min(grid::FINE_ENOUGH);
        let of_period = (least / PROFILE_SAMPLES).ceil().max(1.0) * PROFILE_SAMPLES;
        Self { of_period: Some(of_period as usize), ..self } // saturates far above what a side may have
    }
}

/// Makes the surface that `spec` describes.
///
/// # Errors
/// A length that is not finite and positive, a period or height for the flat surface, a patch that holds not even half a
/// period (on a disc, no pit and land), fewer than two samples a period, more samples than [`super::MAX_SIDE`] on a side or
/// than the memory holds.
pub fn generate(spec: &Spec) -> Result<HeightField> {
    check(spec)?;
    let mut dimensions = spec.kind.dimensions();
    if let Some(period) = spec.period {
        dimensions = dimensions.with_period(period);
    }
    let height = spec.height.unwrap_or(dimensions.height);
    if spec.kind != SurfaceKind::Lamellar && (spec.duty.is_some() || spec.flank.is_some()) {
        return Err(Error::usage(
            format!("a surface of the kind {} has neither duty nor flanks", spec.kind.name()),
            "leave them out or take lamellar",
        ));
    }
    if spec.kind == SurfaceKind::Lamellar {
        /// Samples on a flank that show its slope.
        const ON_FLANK: f64 = 4.0;
        dimensions = dimensions.with_edges(match spec.flank {
            Some(flank) if flank > 0.0 => flank / ON_FLANK,
            _ => f64::INFINITY,
        });
    }
    let grid = SampleGrid::new(spec, &dimensions)?;
    match spec.kind {
        SurfaceKind::Flat => analytic::flat(&grid),
        SurfaceKind::Sinusoid => analytic::sinusoid(&grid, height),
        SurfaceKind::Blaze => analytic::blaze(&grid, height),
        SurfaceKind::Lamellar => lamellar(&grid, spec, dimensions.period[0], height),
        SurfaceKind::Bumps => analytic::bumps(&grid, height),
        SurfaceKind::Elaphe => ridges::make(&grid, height, spec.seed, &ridges::ELAPHE),
        SurfaceKind::Xenopeltis => ridges::make(&grid, height, spec.seed, &ridges::XENOPELTIS),
        SurfaceKind::Cd => disc_tracks::make(&grid, height, spec.seed, &disc_tracks::CD),
        SurfaceKind::Dvd => disc_tracks::make(&grid, height, spec.seed, &disc_tracks::DVD),
        SurfaceKind::Brushed => brushed::make(&grid, height, spec.seed),
        SurfaceKind::Tulip => tulip::make(&grid, height, spec.seed),
    }
}

fn check(spec: &Spec) -> Result<()> {
    let [patch, pixel] = [spec.patch, spec.pixel_size].map(|pair| pair.unwrap_or([1.0; 2]));
    let lengths = [
        ("patch", patch[0]),
        ("patch", patch[1]),
        ("pixel size", pixel[0]),
        ("pixel size", pixel[1]),
        ("period", spec.period.unwrap_or(1.0)),
        ("height", spec.height.unwrap_or(1.0)),
    ];
    if let Some((name, value)) = lengths.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        return Err(Error::usage(
            format!("the {name} {value} um is not positive"),
            "give a length above zero",
        ));
    }
    if spec.kind == SurfaceKind::Flat && (spec.period.is_some() || spec.height.is_some()) {
        return Err(Error::usage(
            "a flat surface has neither period nor height",
            "leave them out or take sinusoid",
        ));
    }
    Ok(())
}

/// Returns a lamellar grating with the duty and the flanks of `spec`.
fn lamellar(grid: &SampleGrid, spec: &Spec, period: f64, height: f64) -> Result<HeightField> {
    let (duty, flank) = (spec.duty.unwrap_or(0.5), spec.flank.unwrap_or(0.0));
    let flank_share = flank / period;
    if !(duty > 0.0 && duty < 1.0 && flank >= 0.0 && flank_share <= 2.0 * duty.min(1.0 - duty)) {
        return Err(Error::usage(
            format!(
                "ridges of {duty} of the period with flanks of {flank} um do not fit a period of {period} um"
            ),
            "give a duty between 0 and 1, and flanks that leave a top and a bottom",
        ));
    }
    analytic::lamellar(grid, height, duty, flank_share)
}

/// Makes the grating whose lines have the heights `profile`(x) \[µm\], x from 0 to 1 over the period along x. `spec` gives its period, patch and sample spacing; its kind is
/// of no account.
///
/// # Errors
/// Those of [`generate`]; a height that is not finite.
pub fn from_profile(spec: &Spec, profile: &(dyn Fn(f64) -> f64 + Sync)) -> Result<HeightField> {
    let spec = &Spec { kind: SurfaceKind::Lamellar, ..*spec };
    check(spec)?;
    let dimensions = spec.kind.dimensions().with_period(spec.period.unwrap_or(LAMELLAR_PERIOD));
    let grid = SampleGrid::new(spec, &dimensions.with_edges(f64::INFINITY))?;
    let periods = grid.periods[0] as f64;
    let field = grid.sample(|x, _| profile((periods * x).fract()))?;
    match spec.height {
        Some(height) => grid::to_full_height(&field, height),
        None => Ok(field),
    }
}

/// Rises smoothly from 0 at 0 to 1 at 1, level at both ends.
fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
