//! Small tables that the shaders read in addition to the layers, computed in f64.

use crate::optics::orders::ColourFunctions;
use crate::optics::quadrature::{WavelengthSets, Wavelengths};
use crate::optics::spectrum::Illuminant;
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;

/// Bins of |(u, v)| over 0 … 2 for the choice of wavelengths; `UV_BINS` of `shaders/source_window.glsl`.
pub const UV_BINS: usize = 256;

/// Table of four floats per entry, row by row, stored as a texture.
#[derive(Clone, Debug)]
pub struct TableTexture {
    /// Number of entries per row, and number of rows.
    pub size: [usize; 2],
    /// All entries.
    pub values: Vec<[f32; 4]>,
}

/// Wavelengths as the shaders read them.
#[derive(Clone, Debug)]
pub struct WavelengthTexture {
    /// Row of `nodes` and number of wavelengths for each bin of |(u, v)|.
    pub bins: Vec<[i32; 2]>,
    /// One set of wavelengths per row: XYZ weight and wavenumber of each.
    pub nodes: TableTexture,
}

impl WavelengthTexture {
    /// Returns the wavelengths for colours from `layers` under `optics`.
    pub fn of(layers: &Layers, optics: &Optics) -> Self {
        let illuminant = &optics.illuminant;
        let sets = match optics.wavelengths {
            Some(count) => WavelengthSets::only(Wavelengths::catmull_rom(illuminant, count)),
            None => WavelengthSets::gaussian(illuminant, layers.sigma, optics.budget().window.wavelengths),
        };
        Self::new(&sets)
    }

    /// Returns the texture of `sets`.
    pub fn new(sets: &WavelengthSets) -> Self {
        let bins = (0..UV_BINS)
            .map(|bin| {
                // The upper end of the bin decides.
                let row = sets.number(2.0 * (bin + 1) as f64 / UV_BINS as f64);
                [row as i32, sets.sets[row].len() as i32]
            })
            .collect();
        Self { bins, nodes: table(&sets.sets) }
    }

    /// Returns `count` equal steps of the wavelength, for every direction.
    pub fn even(illuminant: &Illuminant, count: usize) -> Self {
        Self::new(&WavelengthSets::only(Wavelengths::even(illuminant, count)))
    }

    /// Returns the colour functions as densities over wavenumber. They replace wavelengths where those follow from the
    /// orders of a grating.
    pub fn densities(colours: &ColourFunctions) -> TableTexture {
        let values: Vec<[f32; 4]> =
            colours.densities.iter().map(|d| d.as_vec3().extend(0.0).to_array()).collect();
        TableTexture { size: [values.len(), 1], values }
    }

    /// Returns the row of `nodes` and the number of wavelengths for a direction at |(u, v)| = `uv`.
    pub fn at(&self, uv: f64) -> [i32; 2] {
        self.bins[((uv * 0.5 * UV_BINS as f64) as usize).min(UV_BINS - 1)]
    }

    /// Returns the largest number of wavelengths.
    pub fn most(&self) -> usize {
        self.bins.iter().map(|&[_, count]| count as usize).max().unwrap_or(0)
    }

    /// Returns the wavelengths that a direction at |(u, v)| = `uv` sums over.
    pub fn nodes_at(&self, uv: f64) -> &[[f32; 4]] {
        let [row, count] = self.at(uv).map(|n| n as usize);
        &self.nodes.values[row * self.nodes.size[0]..][..count]
    }
}

fn table(sets: &[Wavelengths]) -> TableTexture {
    let columns = sets.iter().map(Wavelengths::len).max().unwrap_or(1);
    let mut values = vec![[0.0; 4]; columns * sets.len()];
    for (row, set) in values.chunks_mut(columns).zip(sets) {
        for (slot, (weight, q)) in row.iter_mut().zip(set.weights.iter().zip(&set.wavenumbers)) {
            *slot = weight.as_vec3().extend(*q as f32).to_array();
        }
    }
    TableTexture { size: [columns, sets.len()], values }
}
