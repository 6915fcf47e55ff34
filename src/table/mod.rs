//! Colour tables: the mean response summed over the spectrum of one light, so that a picture reads one colour instead of tens of
//! wavelengths.
//!
//! With R the reflectance and G the geometric factor, f cos θ_i = R G cos θ_i (X(u, v, |w|) + X₀/w²). X is the sum over wavelengths
//! of q² ⟨|P|²⟩/(A w²) without the specular order, a smooth function of |w| that the table holds by a few numbers ([`ColorBasis`]). X₀ is q² ⟨|P|²⟩/A of
//! the specular order, a Gaussian in (u, v) for each band of wavelengths, which needs no table over (u, v).
//!
//! If R depends on the wavelength, the sums contain it and the factor in front is 1: the half vector's angle follows from (u, v, w) alone, as
//! cos θ_h = |(u, v, w)|/2, so that a table has room for it.
//!
//! Level l of a table is the average over a Gaussian of (u, v) of standard deviation s_l; see [`TableGrid`].

mod bake;
mod basis;
mod cache;
mod energy;
mod grid;
mod held;
mod projection;
mod read;
mod specular;
mod sums;

pub use bake::{PlannedTable, bake, check};
pub use basis::{ColorBasis, Cubics};
pub use grid::{LEVELS_OF_MIP, TableGrid};
pub use read::TableReader;
pub use specular::{BANDS, SPECULAR_SAMPLES, Specular};

use crate::budget::{ErrorBudget, MeanBudget};
use crate::optics::factor::IndexTriple;
use crate::optics::reflectance::{MeanReflectance, Reflectance};
use crate::optics::spectrum::Illuminant;
use crate::spectra::power::EVEN;
use crate::surface::MAX_SIDE;
use half::f16;
use serde::{Deserialize, Serialize};

/// Smallest tolerance that a table keeps where the refractive index is one number. Colours of a blaze in 200 random directions err by 0.0018,
/// 0.0010 and 0.0004 (relative L2, by `eval --method reference`, a coherence length of 8 µm) at tolerances of 2e-3, 1e-3 and 5e-4; 16-bit floats
/// round by as much as the last. Colours of metals in random directions err by up to 0.011 at any tolerance.
pub const LEAST_TOLERANCE: f64 = 1e-3;

/// Settings of a table.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TableSettings {
    /// Spectrum of the light.
    pub illuminant: Illuminant,
    /// Reflectance of the surface, if it depends on the wavelength: then the sums contain it.
    pub reflectance: Option<Reflectance>,
    /// Number of wavelengths, if the user names it.
    pub wavelengths: Option<usize>,
    /// Relative errors allowed to the parts.
    pub budget: MeanBudget,
    /// Smallest standard deviation of u and of v to average over.
    pub finest: f64,
    /// Largest number of texels along a side.
    pub side_limit: usize,
    /// Largest size of all levels \[bytes\]. Not part of the key: the limit does not change the table.
    #[serde(skip)]
    pub memory_limit: usize,
}

impl TableSettings {
    /// Default limit of the size of a table \[bytes\].
    const USUAL_MEMORY: usize = 1 << 31;

    /// Returns the settings of a table of single directions under `illuminant` with a relative error of `tolerance` over directions.
    pub fn new(illuminant: Illuminant, tolerance: f64) -> Self {
        Self {
            illuminant,
            reflectance: None,
            wavelengths: None,
            budget: ErrorBudget::of_directions(tolerance).mean,
            finest: 0.0,
            side_limit: MAX_SIDE,
            memory_limit: Self::USUAL_MEMORY,
        }
    }
}

/// Colour table.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTable {
    /// Header: everything but the numbers of the texels.
    pub header: TableHeader,
    /// Mip levels, for each `[level of the two][piece][four components][row][column][component of the four]`, rows in growing v: coordinates in
    /// the header's basis. Places are those of ω_i + ω_r = −(u, v).
    pub mips: Vec<Vec<f16>>,
}

/// Header of a [`ColorTable`], which gives its numbers their meaning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableHeader {
    /// Grid of the texels.
    pub grid: TableGrid,
    /// Basis of the coordinates in a texel.
    pub basis: ColorBasis,
    /// Value of a stored 1 \[sr⁻¹\].
    pub unit: f64,
    /// Specular order.
    pub specular: Specular,
    /// Variance of u and of v by the coherence of blue light, the least over all wavelengths.
    pub coherence_blur: f64,
    /// Relative errors allowed to the parts.
    pub budget: MeanBudget,
    /// Relative error of the series of the orders, measured.
    pub series_error: f64,
    /// Relative error of the basis, measured.
    pub basis_error: f64,
    /// Number of orders that share the light: [`crate::spectra::power::OrderSeries::effective_orders`].
    pub effective_orders: f64,
    /// Mean reflectance by which the colours are divided if R depends on the wavelength; it has the larger part of the dependence on the
    /// angle. The factor belongs to the direction of the pixel, not to the directions in its footprint.
    pub mean_reflectance: Option<MeanReflectance>,
    /// Refractive indices of the factor in front by the small-slope approximation, if the table is of one material.
    #[serde(default)]
    pub indices: Option<IndexTriple>,
    /// Limit of energy of an exported material, at the points of a [`DirectionGrid`](crate::optics::energy::DirectionGrid): [`EnergyMap::points`](crate::brdf::energy_map::EnergyMap::points).
    #[serde(default)]
    pub energy: Option<Vec<[f32; 2]>>,
}

impl TableHeader {
    /// Returns the number of layers of a mip level, of four numbers each: those of its two levels, one after the other.
    pub fn layers(&self) -> usize {
        LEVELS_OF_MIP * self.basis.layers()
    }

    /// Returns the number of numbers of a mip level.
    pub fn numbers_of_mip(&self, mip: usize) -> usize {
        (self.grid.side >> mip).pow(2) * self.layers() * basis::PER_TEXEL
    }

    /// Returns rows of [`SPECULAR_SAMPLES`] texels: XYZ of each band of the specular order over |w| and the band's variance; those of the sums of 4, 16 … and at last of all bands; and the mean R
    /// of a material over the cosine of the half angle, or 1.
    pub fn specular_rows(&self) -> Vec<[f32; 4]> {
        let specular = &self.specular;
        let mean = (0..SPECULAR_SAMPLES).map(|sample| {
            let cosine = sample as f64 / (SPECULAR_SAMPLES - 1) as f64;
            let mean = self.mean_reflectance.as_ref().map_or(1.0, |mean| mean.at(cosine) as f32);
            [mean; 3]
        });
        let mut rows = Vec::new();
        let mut together = 1;
        while together <= specular.weights.len() {
            rows.extend(specular.groups(together).flat_map(|(variance, weights)| {
                weights.into_iter().map(move |[x, y, z]| [x, y, z, variance as f32])
            }));
            together *= 4;
        }
        rows.extend(mean.map(|[x, y, z]| [x, y, z, 0.0]));
        rows
    }
}

impl ColorTable {
    /// Returns the table of a surface that diffracts nothing.
    pub fn dark() -> Self {
        let grid = TableGrid::new(0.25, 0.0, 0.0);
        let basis = ColorBasis::dark();
        let specular =
            Specular { variances: vec![1.0; BANDS], weights: vec![vec![[0.0; 3]; SPECULAR_SAMPLES]; BANDS] };
        let header = TableHeader {
            grid,
            basis,
            unit: 1.0,
            specular,
            coherence_blur: 1.0,
            budget: ErrorBudget::of_directions(1.0).mean,
            series_error: 0.0,
            basis_error: 0.0,
            effective_orders: EVEN,
            mean_reflectance: None,
            indices: None,
            energy: None,
        };
        let mips = (0..header.grid.mips()).map(|mip| vec![f16::ZERO; header.numbers_of_mip(mip)]).collect();
        Self { header, mips }
    }

    /// Returns the table of `header` and `mips` from an untrusted source; `None` if they are not valid, or if a number is not finite.
    pub fn from_parts(header: TableHeader, mips: Vec<Vec<f16>>) -> Option<Self> {
        let is_whole = cache::is_sound(&header)
            && mips.len() == header.grid.mips()
            && mips.iter().enumerate().all(|(mip, held)| held.len() == header.numbers_of_mip(mip))
            && mips.iter().flatten().all(|number| number.is_finite());
        is_whole.then_some(Self { header, mips })
    }

    /// Returns the numbers of a level, for each `[piece][four components][row][column][component of the four]`.
    pub fn level(&self, level: usize) -> &[f16] {
        let mip = &self.mips[level / LEVELS_OF_MIP];
        let numbers = mip.len() / LEVELS_OF_MIP;
        &mip[level % LEVELS_OF_MIP * numbers..][..numbers]
    }

    /// Returns the size of all levels \[bytes\].
    pub fn bytes(&self) -> usize {
        self.mips.iter().map(|mip| mip.len() * size_of::<f16>()).sum()
    }
}

/// Largest |w|.
pub const LARGEST_W: f64 = 2.0;

#[cfg(test)]
mod tests;
