//! Sums the spectrum over squares of texels of a colour table.
//!
//! For each wavelength the coefficients in z are read for all texels of a square, along f_x and then along f_y, and multiplied by the
//! polynomials at all |w|: a matrix product in which neighbouring texels share what they read.

use super::{LARGEST_W, TableSettings};
use crate::optics::quadrature::{Comb, Ladder, Nodes, Rule};
use crate::optics::reflectance::{MeanReflectance, Reflectance};
use crate::optics::spectrum::MIDDLE;
use crate::spectra::power::chebyshev::{nodes, polynomials};
use crate::spectra::power::read::{ReadScratch, SpectraReader, Square};
use crate::spectra::power::texture::PER_TEXEL;
use glam::{DVec2, Vec4};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Values of |w| in a piece of its range, for the coefficients of a cubic; and values that the products take at once.
pub const NODES: usize = 4;

/// The wavelengths of each direction.
pub struct DirectionWavelengths {
    combs: Vec<Comb>,
    // For each comb, node by node, what the surface reflects over cos θ_h; nothing where that does not depend on the wavelength.
    reflectances: Vec<Vec<ReflectanceRow>>,
    rule: Rule,
    named: bool,
    variance: f64,
}

impl DirectionWavelengths {
    /// For the table of `settings`.
    pub fn new(reader: &SpectraReader, settings: &TableSettings) -> Self {
        let orders = reader.header.orders_blur.variance;
        let variance = settings.finest.powi(2);
        // The response along a ray varies as its blur allows: that of a window of this standard deviation.
        let blur = 0.5 * (orders[0] + orders[1]) + variance / MIDDLE.powi(2);
        let sigma = 1.0 / (PI * (8.0 * blur).sqrt());
        let rule = Rule::gaussian(&settings.illuminant, sigma, settings.quadrature_error);
        let combs = match settings.wavelengths {
            Some(count) => vec![Nodes::catmull_rom(&settings.illuminant, count).into()],
            None => Ladder::new(&settings.illuminant, &rule).levels,
        };
        let rows = |r: &Reflectance| {
            let mean = MeanReflectance::new(r);
            let row = |q: &f64| ReflectanceRow::new(r, &mean, *q);
            let of_comb = |comb: &Comb| comb.wavenumbers.iter().map(row).collect();
            combs.par_iter().map(of_comb).collect()
        };
        let reflectances = settings.reflectance.as_ref().map_or_else(Vec::new, rows);
        Self { combs, reflectances, rule, named: settings.wavelengths.is_some(), variance }
    }

    /// Number of the comb for |(u, v)| = `uv`.
    fn comb(&self, uv: f64) -> usize {
        if self.named {
            return 0;
        }
        let needed = self.rule.count(uv.min(2.0));
        self.combs.iter().position(|comb| comb.weights.len() >= needed).unwrap_or(self.combs.len() - 1)
    }
}

/// R at one wavenumber over the mean R, over cos θ_h.
struct ReflectanceRow(Vec<f32>);

impl ReflectanceRow {
    /// Steps of cos θ_h, about as many as shaders have ([`crate::optics::reflectance::COLUMNS`] says what that errs by).
    const STEPS: usize = 256;

    fn new(reflectance: &Reflectance, mean: &MeanReflectance, wavenumber: f64) -> Self {
        let at = |i: usize| {
            let cosine = i as f64 / Self::STEPS as f64;
            (reflectance.at(1.0 / wavenumber, cosine) / mean.at(cosine)) as f32
        };
        Self((0..=Self::STEPS).map(at).collect())
    }

    /// R where |(u, v)|² and |w|² are `uv2` and `w2`.
    fn at(&self, uv2: f32, w2: f32) -> f32 {
        let place = (0.5 * (uv2 + w2).sqrt()).min(1.0) * Self::STEPS as f32;
        let left = (place as usize).min(Self::STEPS - 1);
        let share = place - left as f32;
        self.0[left] + share * (self.0[left + 1] - self.0[left])
    }
}

/// Sums over the spectrum at given |w|.
pub struct Sums<'a> {
    reader: &'a SpectraReader,
    spectrum: &'a DirectionWavelengths,
    // Number of |w|, and the same rounded up to NODES.
    count: usize,
    padded: usize,
    // For each comb, node by node: [w / NODES][term][w % NODES], q² z²/w² times the Chebyshev polynomials at
    // z = 2πq|w|.
    polynomials: Vec<Vec<Vec4>>,
    // |w|² of each lane.
    w2: Vec<Vec4>,
}

/// Working arrays of a thread.
#[derive(Default)]
pub struct Scratch {
    reading: ReadScratch,
    terms: Vec<Vec4>,
    /// `[texel][channel][w]`, w padded to [`NODES`].
    sums: Vec<Vec4>,
}

impl<'a> Sums<'a> {
    /// At the four Chebyshev nodes of each of `pieces`.
    pub fn new(reader: &'a SpectraReader, spectrum: &'a DirectionWavelengths, pieces: usize) -> Self {
        Self::at(reader, spectrum, nodes_of_pieces(pieces))
    }

    /// At the given |w|.
    pub fn at(reader: &'a SpectraReader, spectrum: &'a DirectionWavelengths, w: Vec<f64>) -> Self {
        let (terms, z_max) = (reader.header.terms, reader.header.z_max);
        let (count, padded) = (w.len(), w.len().next_multiple_of(NODES));
        let of_comb = |comb: &Comb| {
            let mut values = vec![0f32; comb.weights.len() * terms * padded];
            let mut t = vec![0.0; terms];
            for (q, node) in comb.wavenumbers.iter().zip(values.chunks_exact_mut(terms * padded)) {
                for (i, w) in w.iter().enumerate() {
                    let factor = (2.0 * PI * q * q).powi(2) * reader.header.unit;
                    polynomials((4.0 * PI * q * w / z_max - 1.0).min(1.0), &mut t);
                    let lane = (i / NODES) * terms * NODES + i % NODES;
                    for (k, t) in t.iter().enumerate() {
                        node[lane + k * NODES] = (t * factor) as f32;
                    }
                }
            }
            values.chunks_exact(NODES).map(Vec4::from_slice).collect()
        };
        let polynomials = spectrum.combs.par_iter().map(of_comb).collect();
        let squared: Vec<f32> = (0..padded).map(|i| w.get(i).map_or(0.0, |w| (w * w) as f32)).collect();
        let w2 = squared.chunks_exact(NODES).map(Vec4::from_slice).collect();
        Self { reader, spectrum, count, padded, polynomials, w2 }
    }

    /// XYZ at every w for every texel of `tile`, into `scratch`.
    fn sum(&self, tile: &Square, scratch: &mut Scratch) {
        let number = self.spectrum.comb(tile.farthest());
        let comb = &self.spectrum.combs[number];
        let (terms, texels, lanes) = (self.reader.header.terms, tile.side * tile.side, self.padded / NODES);
        scratch.sums.clear();
        scratch.sums.resize(texels * 3 * lanes, Vec4::ZERO);
        scratch.terms.resize(texels * terms / PER_TEXEL, Vec4::ZERO);
        let per_node = terms * lanes;
        let layers = terms / PER_TEXEL;
        for (j, (q, weight)) in comb.wavenumbers.iter().zip(&comb.weights).enumerate() {
            let square = tile.scaled(*q);
            self.reader.read(
                &square,
                q * q * self.spectrum.variance,
                &mut scratch.reading,
                &mut scratch.terms,
            );
            let weight = weight.as_vec3().to_array();
            let matrix = &self.polynomials[number][j * per_node..(j + 1) * per_node];
            let reflectance = self.spectrum.reflectances.get(number).map(|rows| &rows[j]);
            let texels = scratch.terms.chunks_exact(layers).zip(scratch.sums.chunks_exact_mut(3 * lanes));
            for (texel, (series, sums)) in texels.enumerate() {
                let uv2 = tile.place(texel).length_squared() as f32;
                for (lane, factors) in matrix.chunks_exact(terms).enumerate() {
                    let mut value = product(series, factors);
                    if let Some(row) = reflectance {
                        value *= Vec4::from(self.w2[lane].to_array().map(|w2| row.at(uv2, w2)));
                    }
                    for (channel, weight) in weight.iter().enumerate() {
                        sums[channel * lanes + lane] += value * *weight;
                    }
                }
            }
        }
    }

    /// XYZ at every w for one place.
    pub fn colours(&self, place: DVec2, scratch: &mut Scratch) -> Vec<[f32; 3]> {
        self.sum(&Square::point(place), scratch);
        let sums: &[f32] = bytemuck::cast_slice(&scratch.sums);
        (0..self.count).map(|i| std::array::from_fn(|channel| sums[channel * self.padded + i])).collect()
    }

    /// XYZ at the nodes for every texel of `tile`: `[texel][channel][piece]`, for [`Sums::new`].
    pub fn at_nodes<'s>(&self, tile: &Square, scratch: &'s mut Scratch) -> &'s [Vec4] {
        self.sum(tile, scratch);
        &scratch.sums
    }
}

/// max(0, Σ term·factor), at [`NODES`] values of |w|.
fn product(series: &[Vec4], factors: &[Vec4]) -> Vec4 {
    let mut sum = Vec4::ZERO;
    for (terms, factors) in series.iter().zip(factors.chunks_exact(PER_TEXEL)) {
        sum += factors[0] * terms.x + factors[1] * terms.y + factors[2] * terms.z + factors[3] * terms.w;
    }
    sum.max(Vec4::ZERO)
}

/// The nodes of each of `pieces` of the range of |w|, one piece after the other.
pub fn nodes_of_pieces(pieces: usize) -> Vec<f64> {
    let length = LARGEST_W / pieces as f64;
    let of_piece = |piece| nodes(NODES, length).into_iter().map(move |w| piece as f64 * length + w);
    (0..pieces).flat_map(of_piece).collect()
}
