//! Generated height fields of published dimensions.
//!
//! All of them are periodic over their patch, because the patch is what repeats: its left edge meets the right one, its
//! top the bottom. A patch is therefore rounded to whole periods, the spacing of the samples to whole samples a patch.

mod analytic;
mod grid;
mod ridges;
mod waves;

use super::HeightField;
use crate::error::{Error, Result};
use grid::Grid;

/// Which surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A mirror: height 0.
    Flat,
    /// h = a sin(2πx/d), d = 2 µm, full height 2a = 0.2 µm.
    Sinusoid,
    /// A sawtooth rising along +x, period 2.5 µm, full height 246.23 nm.
    Blaze,
    /// Round bumps 0.15 µm high on a lattice of 0.5 µm × 1 µm.
    Bumps,
    /// Finger-like micro-ridges as on the skin of *Elaphe*: 1.14 µm across, 0.43 µm high.
    Elaphe,
    /// Long, regular micro-ridges as on the skin of *Xenopeltis unicolor*: 1.55 µm across, 0.82 µm high.
    Xenopeltis,
}

/// What to generate. `None` is the kind's own default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// Which surface.
    pub kind: Kind,
    /// Chooses among the many skins of one kind; the same seed is the same surface, bit for bit, on one platform. The
    /// surfaces with a formula have one form only.
    pub seed: u64,
    /// Wished side lengths of the patch \[µm\]; the nearest whole periods are made.
    pub patch: Option<[f64; 2]>,
    /// Largest sample spacing \[µm\]; the made one is smaller by less than one sample a patch.
    pub pixel_size: Option<[f64; 2]>,
    /// Period along `x` \[µm\]; what a surface has along `y` scales with it.
    pub period: Option<f64>,
    /// Full height \[µm\].
    pub height: Option<f64>,
}

/// The dimensions of a kind \[µm\].
struct Dimensions {
    /// Repeat along `x` and `y`; 0 where the surface is constant along that axis.
    period: [f64; 2],
    height: f64,
    /// Side of the square patch.
    patch: f64,
}

impl Kind {
    /// Every kind, from simple to rich.
    pub const ALL: [Self; 6] =
        [Self::Flat, Self::Sinusoid, Self::Blaze, Self::Bumps, Self::Elaphe, Self::Xenopeltis];

    /// The word for it on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Sinusoid => "sinusoid",
            Self::Blaze => "blaze",
            Self::Bumps => "bumps",
            Self::Elaphe => "elaphe",
            Self::Xenopeltis => "xenopeltis",
        }
    }

    /// The kind that `name` means.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    fn dimensions(self) -> Dimensions {
        /// Enough periods for sharp orders, few enough samples to compute with at once.
        const FORMULA_PATCH: f64 = 20.0;
        /// The side of the scans that the skins resemble, which is also the coherence length of sunlight.
        const SKIN_PATCH: f64 = 65.0;
        let (period, height, patch) = match self {
            Self::Flat => ([0.0, 0.0], 0.0, FORMULA_PATCH),
            Self::Sinusoid => ([2.0, 0.0], 0.2, FORMULA_PATCH),
            Self::Blaze => ([2.5, 0.0], 0.246_23, FORMULA_PATCH),
            Self::Bumps => ([0.5, 1.0], 0.15, FORMULA_PATCH),
            // The rows of the Elaphe scan repeat every 3.1 µm (its spectrum peaks at 0.32 /µm along y).
            Self::Elaphe => ([1.14, 3.1], 0.43, SKIN_PATCH),
            // The ridges of Xenopeltis are long; that they repeat every 6.5 µm is a choice, not a measurement.
            Self::Xenopeltis => ([1.55, 6.5], 0.82, SKIN_PATCH),
        };
        Dimensions { period, height, patch }
    }
}

impl Spec {
    /// The default surface of `kind`.
    pub fn new(kind: Kind) -> Self {
        Self { kind, seed: 0, patch: None, pixel_size: None, period: None, height: None }
    }
}

/// Makes the surface that `spec` describes.
///
/// # Errors
/// A length that is not finite and positive, a period or height for the flat surface, a patch that holds not even half a
/// period, fewer than two samples a period, more samples than [`super::MAX_SIDE`] on a side or than the memory holds.
pub fn generate(spec: &Spec) -> Result<HeightField> {
    check(spec)?;
    let mut dimensions = spec.kind.dimensions();
    if let Some(period) = spec.period {
        let scale = period / dimensions.period[0];
        dimensions.period = [period, dimensions.period[1] * scale];
    }
    let height = spec.height.unwrap_or(dimensions.height);
    let grid = Grid::new(spec, &dimensions)?;
    match spec.kind {
        Kind::Flat => analytic::flat(&grid),
        Kind::Sinusoid => analytic::sinusoid(&grid, height),
        Kind::Blaze => analytic::blaze(&grid, height),
        Kind::Bumps => analytic::bumps(&grid, height),
        Kind::Elaphe => ridges::make(&grid, height, spec.seed, &ridges::ELAPHE),
        Kind::Xenopeltis => ridges::make(&grid, height, spec.seed, &ridges::XENOPELTIS),
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
    if spec.kind == Kind::Flat && (spec.period.is_some() || spec.height.is_some()) {
        return Err(Error::usage(
            "a flat surface has neither period nor height",
            "leave them out or take sinusoid",
        ));
    }
    Ok(())
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
