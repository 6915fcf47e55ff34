//! The small tables that the shaders read beside the layers, computed in f64.

use super::shading::Shading;
use crate::optics::orders::Colours;
use crate::optics::quadrature::{Comb, Ladder, Nodes, Rule};
use crate::optics::spectrum::Illuminant;
use crate::precompute::Layers;

/// Bins of |(u, v)| over 0 … 2 for which a wavelength comb is chosen; `UV_BINS` of `shaders/source_window.glsl`.
pub const UV_BINS: usize = 256;

/// A table of four floats an entry, row by row: a texture.
#[derive(Clone, Debug)]
pub struct TableTexture {
    /// Entries along a row, and rows.
    pub size: [usize; 2],
    /// All entries.
    pub values: Vec<[f32; 4]>,
}

/// Wavelength combs as the shaders read them.
#[derive(Clone, Debug)]
pub struct Combs {
    /// Row of `nodes` and number of nodes for each bin of |(u, v)|.
    pub bins: Vec<[i32; 2]>,
    /// A comb a row: XYZ weight and wavenumber of every node.
    pub nodes: TableTexture,
}

impl Combs {
    /// The wavelengths of colours from `layers` under `shading`.
    pub fn of(layers: &Layers, shading: &Shading) -> Self {
        Self::new(&shading.illuminant, layers.sigma, shading.quadrature(), shading.wavelengths)
    }

    /// Combs by [`Rule`] for a relative error of the colour of `tolerance`, or one of `wavelengths` nodes for every direction.
    pub fn new(illuminant: &Illuminant, sigma: f64, tolerance: f64, wavelengths: Option<usize>) -> Self {
        if let Some(count) = wavelengths {
            let only = [Nodes::catmull_rom(illuminant, count).into()];
            return Self { bins: vec![[0, count as i32]; UV_BINS], nodes: table(&only) };
        }
        let rule = Rule::gaussian(illuminant, sigma, tolerance);
        let levels = Ladder::new(illuminant, &rule).levels;
        let bins = (0..UV_BINS)
            .map(|bin| {
                // The bin's far end decides.
                let needed = rule.count(2.0 * (bin + 1) as f64 / UV_BINS as f64);
                let row = levels.iter().position(|l| l.weights.len() >= needed).unwrap_or(levels.len() - 1);
                [row as i32, levels[row].weights.len() as i32]
            })
            .collect();
        Self { bins, nodes: table(&levels) }
    }

    /// One comb of `count` nodes at equal steps of the wavelength, for every direction.
    pub fn even_wavelengths(illuminant: &Illuminant, count: usize) -> Self {
        let only = [Comb::even_wavelengths(illuminant, count)];
        Self { bins: vec![[0, count as i32]; UV_BINS], nodes: table(&only) }
    }

    /// The colour functions as a density over wavenumbers, in place of combs: wavelengths stand where the orders do.
    pub fn densities(colours: &Colours) -> Self {
        let values: Vec<[f32; 4]> =
            colours.densities.iter().map(|d| d.as_vec3().extend(0.0).to_array()).collect();
        Self { nodes: TableTexture { size: [values.len(), 1], values }, ..Self::none() }
    }

    /// No wavelengths: their sum is made already.
    pub fn none() -> Self {
        // Devices bind no empty textures.
        let nodes = TableTexture { size: [1, 1], values: vec![[0.0; 4]] };
        Self { bins: vec![[0, 0]; UV_BINS], nodes }
    }

    /// Row of `nodes` and number of nodes for a direction at |(u, v)| = `uv`.
    pub fn at(&self, uv: f64) -> [i32; 2] {
        self.bins[((uv * 0.5 * UV_BINS as f64) as usize).min(UV_BINS - 1)]
    }

    /// Nodes of the longest comb.
    pub fn most(&self) -> usize {
        self.bins.iter().map(|&[_, count]| count as usize).max().unwrap_or(0)
    }

    /// Nodes that a direction at |(u, v)| = `uv` sums over.
    pub fn nodes_at(&self, uv: f64) -> &[[f32; 4]] {
        let [row, count] = self.at(uv).map(|n| n as usize);
        &self.nodes.values[row * self.nodes.size[0]..][..count]
    }
}

fn table(combs: &[Comb]) -> TableTexture {
    let columns = combs.iter().map(|c| c.weights.len()).max().unwrap_or(1);
    let mut values = vec![[0.0; 4]; columns * combs.len()];
    for (row, comb) in values.chunks_mut(columns).zip(combs) {
        row.iter_mut().zip(rows(comb)).for_each(|(slot, node)| *slot = node);
    }
    TableTexture { size: [columns, combs.len()], values }
}

fn rows(comb: &Comb) -> impl Iterator<Item = [f32; 4]> {
    comb.weights.iter().zip(&comb.wavenumbers).map(|(w, &q)| [w.x as f32, w.y as f32, w.z as f32, q as f32])
}
