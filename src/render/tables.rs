//! The small tables that the shaders read beside the layers, computed in f64.

use super::interface::UV_BINS;
use crate::expansion::Expansion;
use crate::optics::quadrature::{Ladder, Nodes, Rule};
use crate::optics::spectrum::Illuminant;
use crate::precompute::Layers;
use rustfft::num_complex::Complex64;

/// c_n(z) over a uniform grid of z, two terms to a row of four floats.
#[derive(Clone, Debug)]
pub struct Coefficients {
    /// `[entry][pair]` → Re, Im, Re, Im.
    pub values: Vec<[f32; 4]>,
    /// Pairs that any z from an entry to the next needs.
    pub pairs_needed: Vec<i32>,
    /// Entries per unit of z.
    pub entries_per_z: f64,
}

impl Coefficients {
    /// The table for `layers`, fine enough that interpolating in it is a thousandth of `tolerance`.
    pub fn new(layers: &Layers, tolerance: f64) -> Self {
        /// Share of the tolerance that the interpolation of e^{izh} may take: (Δz·a)²/8.
        const SHARE: f64 = 1e-3;
        /// Bounds on the number of entries: the larger fills half a megabyte per eight pairs.
        const ENTRIES: (f64, f64) = (64.0, 8192.0);
        let expansion = layers.expansion();
        let x_max = layers.z_max * layers.half_range;
        let intervals = (x_max / (8.0 * SHARE * tolerance).sqrt()).ceil().clamp(ENTRIES.0, ENTRIES.1);
        let step = layers.z_max / intervals;
        let entries = intervals as usize + 2;
        let pairs = layers.pairs();
        let mut values = Vec::with_capacity(entries * pairs);
        let mut row = vec![Complex64::ZERO; 2 * pairs];
        for entry in 0..entries {
            expansion.coefficients(entry as f64 * step, &mut row);
            row[layers.terms..].fill(Complex64::ZERO); // an odd count leaves half a pair
            values.extend(row.chunks(2).map(|c| [c[0].re, c[0].im, c[1].re, c[1].im].map(|x| x as f32)));
        }
        let pairs_needed =
            (0..entries).map(|entry| layers.terms_at((entry + 1) as f64 * step).div_ceil(2) as i32).collect();
        Self { values, pairs_needed, entries_per_z: 1.0 / step }
    }

    /// Entries.
    pub fn entries(&self) -> usize {
        self.pairs_needed.len()
    }
}

/// Wavelength combs as the shaders read them.
#[derive(Clone, Debug)]
pub struct Combs {
    /// First node and number of nodes for each bin of |(u, v)|.
    pub bins: Vec<[i32; 2]>,
    /// XYZ weight and wavenumber of every node.
    pub nodes: Vec<[f32; 4]>,
}

impl Combs {
    /// Combs by [`Rule`] for `tolerance`, or one of `wavelengths` nodes for every direction.
    pub fn new(illuminant: &Illuminant, sigma: f64, tolerance: f64, wavelengths: Option<usize>) -> Self {
        if let Some(count) = wavelengths {
            let only = Nodes::catmull_rom(illuminant, count);
            return Self { bins: vec![[0, count as i32]; UV_BINS], nodes: rows(&only) };
        }
        let rule = Rule::gaussian(sigma, tolerance);
        let ladder = Ladder::new(illuminant, &rule);
        let mut firsts = Vec::new();
        let mut nodes = Vec::new();
        for level in &ladder.levels {
            firsts.push([nodes.len() as i32, level.weights.len() as i32]);
            nodes.extend(rows(level));
        }
        let bins = (0..UV_BINS)
            .map(|bin| {
                // The bin's far end decides.
                let needed = rule.count(2.0 * (bin + 1) as f64 / UV_BINS as f64);
                let level = ladder.levels.iter().position(|l| l.weights.len() >= needed);
                firsts[level.unwrap_or(firsts.len() - 1)]
            })
            .collect();
        Self { bins, nodes }
    }

    /// Nodes that a direction at |(u, v)| = `uv` sums over.
    pub fn nodes_at(&self, uv: f64) -> &[[f32; 4]] {
        let bin = ((uv * 0.5 * UV_BINS as f64) as usize).min(UV_BINS - 1);
        let [first, count] = self.bins[bin].map(|n| n as usize);
        &self.nodes[first..first + count]
    }
}

fn rows(nodes: &Nodes) -> Vec<[f32; 4]> {
    let row = |(j, w): (usize, &glam::DVec3)| {
        [w.x as f32, w.y as f32, w.z as f32, (nodes.first + j as f64 * nodes.step) as f32]
    };
    nodes.weights.iter().enumerate().map(row).collect()
}
