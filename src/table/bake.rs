//! Sums the spectrum at every texel of a colour table.

use super::grid::Grid;
use super::specular::Specular;
use super::{ColorTable, Header, LARGEST_W};
use crate::error::{Error, Result};
use crate::memory;
use crate::optics::quadrature::{Comb, Ladder, Rule};
use crate::optics::spectrum::Illuminant;
use crate::spectra::power::PowerSpectra;
use crate::spectra::power::chebyshev::{nodes, polynomials};
use crate::spectra::power::read::Reader;
use crate::spectra::power::texture::PER_TEXEL;
use glam::DVec2;
use half::f16;
use rayon::prelude::*;
use std::f64::consts::PI;

/// What a table is made for.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TableSettings {
    /// The light's spectrum.
    pub illuminant: Illuminant,
    /// Number of wavelengths, where the user names it.
    pub wavelengths: Option<usize>,
    /// Relative error of the sum over wavelengths.
    pub quadrature_error: f64,
    /// Relative error of reading between texels.
    pub reading_error: f64,
    /// Relative error of the cubics in |w|.
    pub cubic_error: f64,
    /// Least standard deviation of u and of v that is averaged over.
    pub finest: f64,
    /// Most texels along a side.
    pub side_limit: usize,
    /// Most bytes of all levels. Not part of the key: it decides whether they are made.
    #[serde(skip)]
    pub memory_limit: usize,
}

/// Coefficients of a cubic.
const CUBIC: usize = 4;
/// Most pieces of the range of |w|.
pub(super) const MOST_PIECES: usize = 16;
/// A wavelength in the middle of the visible range \[µm\].
const MIDDLE: f64 = 0.55;
/// Where blue light weighs most \[µm\]: coherence blurs it least.
const BLUE: f64 = 0.45;
/// Linear interpolation of prefiltered samples a spacing Δ apart of what is blurred by a standard deviation b errs by this times (Δ/b)², relative
/// L2: 4·√(3/(64·720)) along each axis, from (2πΔf)²/√720 averaged over the blur's spectrum.
const LINEAR_ERROR: f64 = 0.0323 * std::f64::consts::SQRT_2;

/// Bakes the table of the surface that `spectra` describe.
///
/// # Errors
/// Where the limits or memory do not suffice; what `progress` returns.
pub fn bake(
    spectra: &PowerSpectra,
    settings: &TableSettings,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<ColorTable> {
    let reader = Reader::new(spectra);
    let orders = reader.header.orders_blur.variance;
    let blur = settings.finest.powi(2) + BLUE * BLUE * 0.5 * (orders[0] + orders[1]);
    let spacing = (blur * settings.reading_error / LINEAR_ERROR).sqrt();
    let grid = Grid::new(spacing, settings.finest);
    let spectrum = Spectrum::new(&reader, settings);
    let (pieces, cubic_error) = choose_pieces(&reader, &spectrum, settings)?;
    check_room(&grid, pieces, settings)?;
    let sums = Sums::new(&reader, &spectrum, pieces);
    let width = pieces * 3 * CUBIC;
    let side = grid.side;
    let mut finest = vec![0f32; side * side * width];
    // Rows between two calls of `progress`.
    const ROWS: usize = 16;
    for (block, rows) in finest.chunks_mut(ROWS * side * width).enumerate() {
        progress(block * ROWS, side)?;
        rows.par_chunks_mut(width).enumerate().for_each_init(
            || Scratch::new(&reader),
            |scratch, (i, texel)| {
                let place = DVec2::new(grid.at(0, i % side), grid.at(0, block * ROWS + i / side));
                if place.length() <= grid.extent + 2.0 * grid.spacing(0) {
                    sums.cubics(place, scratch, texel);
                }
            },
        );
    }
    let unit = unit_of(&finest);
    let mut levels = Vec::with_capacity(grid.levels);
    let mut current = finest;
    for level in 0..grid.levels {
        levels.push(texels(&current, grid.side_of(level), pieces, unit));
        if level + 1 < grid.levels {
            current = next_level(&current, grid.side_of(level), width, level, &grid);
        }
    }
    progress(side, side)?;
    let specular = Specular::new(&reader.header, &settings.illuminant);
    Ok(ColorTable { header: Header { grid, pieces, unit, specular, cubic_error }, levels })
}

fn check_room(grid: &Grid, pieces: usize, settings: &TableSettings) -> Result<()> {
    const MIB: f64 = 1024.0 * 1024.0;
    let bytes = grid.bytes(pieces);
    if grid.side > settings.side_limit || bytes > settings.memory_limit {
        return Err(Error::failed(
            format!(
                "the colour table would take {0} x {0} texels and {1:.0} MiB",
                grid.side,
                bytes as f64 / MIB
            ),
            "ask for a larger --tolerance, look from farther away, or use --method spectral",
        ));
    }
    // The finest level in 32-bit floats and the one after it stand beside all levels in 16-bit floats.
    memory::ensure_room(bytes as u64 * 7 / 2, "the colour table")
}

/// The wavelengths of each direction.
struct Spectrum {
    combs: Vec<Comb>,
    rule: Rule,
    named: bool,
    variance: f64,
}

impl Spectrum {
    fn new(reader: &Reader, settings: &TableSettings) -> Self {
        let orders = reader.header.orders_blur.variance;
        let variance = settings.finest.powi(2);
        // The response along a ray varies as its blur allows: that of a window of this standard deviation.
        let blur = 0.5 * (orders[0] + orders[1]) + variance / MIDDLE.powi(2);
        let sigma = 1.0 / (PI * (8.0 * blur).sqrt());
        let rule = Rule::gaussian(&settings.illuminant, sigma, settings.quadrature_error);
        match settings.wavelengths {
            Some(count) => {
                let nodes = crate::optics::quadrature::Nodes::catmull_rom(&settings.illuminant, count);
                Self { combs: vec![nodes.into()], rule, named: true, variance }
            }
            None => {
                Self { combs: Ladder::new(&settings.illuminant, &rule).levels, rule, named: false, variance }
            }
        }
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

/// Sums over the spectrum at given |w|.
struct Sums<'a> {
    reader: &'a Reader,
    spectrum: &'a Spectrum,
    w: Vec<f64>,
    pieces: usize,
    // For each comb, node by node: [w][term], q² z² times the Chebyshev polynomials at z = 2πq|w|.
    polynomials: Vec<Vec<[f32; PER_TEXEL]>>,
    to_cubic: [[f32; CUBIC]; CUBIC],
}

/// Working arrays of a thread.
struct Scratch {
    terms: Vec<[f32; PER_TEXEL]>,
    sums: Vec<[f32; 3]>,
}

impl Scratch {
    fn new(reader: &Reader) -> Self {
        Self { terms: vec![[0.0; PER_TEXEL]; reader.header.terms / PER_TEXEL], sums: Vec::new() }
    }
}

impl<'a> Sums<'a> {
    /// At the four Chebyshev nodes of each of `pieces`.
    fn new(reader: &'a Reader, spectrum: &'a Spectrum, pieces: usize) -> Self {
        let length = LARGEST_W / pieces as f64;
        let w =
            (0..pieces).flat_map(|p| nodes(CUBIC, length).into_iter().map(move |x| p as f64 * length + x));
        Self::at(reader, spectrum, w.collect(), pieces)
    }

    fn at(reader: &'a Reader, spectrum: &'a Spectrum, w: Vec<f64>, pieces: usize) -> Self {
        let (terms, z_max) = (reader.header.terms, reader.header.z_max);
        let of_comb = |comb: &Comb| {
            let mut values = Vec::with_capacity(comb.weights.len() * w.len() * terms / PER_TEXEL);
            let mut t = vec![0.0; terms];
            for q in &comb.wavenumbers {
                for w in &w {
                    let factor = (q * 2.0 * PI * q * w).powi(2) * reader.header.unit;
                    polynomials((4.0 * PI * q * w / z_max - 1.0).min(1.0), &mut t);
                    values
                        .extend(t.chunks(PER_TEXEL).map(|t| std::array::from_fn(|k| (t[k] * factor) as f32)));
                }
            }
            values
        };
        let polynomials = spectrum.combs.par_iter().map(of_comb).collect();
        Self { reader, spectrum, w, pieces, polynomials, to_cubic: cubic_from_nodes() }
    }

    /// XYZ at every w for the place `toward` = −(u, v), into `scratch.sums`.
    fn colours(&self, toward: DVec2, scratch: &mut Scratch) {
        scratch.sums.clear();
        scratch.sums.resize(self.w.len(), [0.0; 3]);
        let number = self.spectrum.comb(toward.length());
        let comb = &self.spectrum.combs[number];
        let terms = self.reader.header.terms / PER_TEXEL;
        let per_node = self.w.len() * terms;
        for (j, (q, weight)) in comb.wavenumbers.iter().zip(&comb.weights).enumerate() {
            let f = toward * *q;
            if !self.reader.holds(f) {
                continue;
            }
            let level = (self.reader.level(q * q * self.spectrum.variance) + dither(j)).floor();
            self.reader.read(f, level, &mut scratch.terms);
            let weight = weight.as_vec3().to_array();
            let rows = &self.polynomials[number][j * per_node..(j + 1) * per_node];
            for (sum, row) in scratch.sums.iter_mut().zip(rows.chunks_exact(terms)) {
                let value = dot(row, &scratch.terms).max(0.0);
                for (channel, weight) in sum.iter_mut().zip(weight) {
                    *channel += weight * value;
                }
            }
        }
    }

    /// The cubics at `toward`: [piece][channel][power].
    fn cubics(&self, toward: DVec2, scratch: &mut Scratch, out: &mut [f32]) {
        self.colours(toward, scratch);
        for piece in 0..self.pieces {
            let values = &scratch.sums[piece * CUBIC..(piece + 1) * CUBIC];
            for channel in 0..3 {
                for power in 0..CUBIC {
                    let sum: f32 =
                        values.iter().zip(&self.to_cubic[power]).map(|(v, m)| v[channel] * m).sum();
                    out[(piece * 3 + channel) * CUBIC + power] = sum;
                }
            }
        }
    }
}

/// Share of a level that node `j` adds before it is rounded down: neighbouring wavelengths then mix two levels as interpolation between
/// the levels would, for half the reads. Multiples of the golden ratio spread evenly however many there are.
fn dither(j: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    (0.5 + j as f64 * GOLDEN).fract()
}

/// Σ a b.
fn dot(a: &[[f32; PER_TEXEL]], b: &[[f32; PER_TEXEL]]) -> f32 {
    let mut sums = [0f32; PER_TEXEL];
    for (a, b) in a.iter().zip(b) {
        for k in 0..PER_TEXEL {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum()
}

/// Takes values at the four Chebyshev nodes of −1 … 1 to the coefficients of 1, t, t², t³.
fn cubic_from_nodes() -> [[f32; CUBIC]; CUBIC] {
    let chebyshev = crate::spectra::power::chebyshev::coefficients_from_values(CUBIC);
    // T_2 = 2t² − 1 and T_3 = 4t³ − 3t.
    let row = |f: &dyn Fn(usize) -> f64| std::array::from_fn(|j| f(j) as f32);
    [
        row(&|j| chebyshev[0][j] - chebyshev[2][j]),
        row(&|j| chebyshev[1][j] - 3.0 * chebyshev[3][j]),
        row(&|j| 2.0 * chebyshev[2][j]),
        row(&|j| 4.0 * chebyshev[3][j]),
    ]
}

/// The fewest pieces whose cubics err by no more than the settings allow, and that error: RMS over directions spread evenly and over |w|,
/// each relative to its own value, since the faint directions far from the specular one are where the colours are.
fn choose_pieces(reader: &Reader, spectrum: &Spectrum, settings: &TableSettings) -> Result<(usize, f64)> {
    /// Directions that are judged, on a spiral of equal areas.
    const JUDGED: usize = 150;
    /// Places in |w|, between nodes of any pieces.
    const BETWEEN: usize = 41;
    const GOLDEN_ANGLE: f64 = 2.399_963;
    /// What a value counts for at the least, over the largest of its direction: small |w| are small in pictures, too.
    const FAINT: f32 = 0.05;
    let fine: Vec<f64> = (0..BETWEEN).map(|i| LARGEST_W * (i as f64 + 0.37) / BETWEEN as f64).collect();
    let exact = Sums::at(reader, spectrum, fine.clone(), 1);
    let places: Vec<DVec2> = (0..JUDGED)
        .map(|i| {
            let radius = LARGEST_W * ((i as f64 + 0.5) / JUDGED as f64).sqrt();
            DVec2::from_angle(GOLDEN_ANGLE * i as f64) * radius
        })
        .collect();
    let truth: Vec<Vec<[f32; 3]>> = places
        .par_iter()
        .map_init(
            || Scratch::new(reader),
            |scratch, place| {
                exact.colours(*place, scratch);
                scratch.sums.clone()
            },
        )
        .collect();
    let error_of = |pieces: usize| {
        let sums = Sums::new(reader, spectrum, pieces);
        let parts: Vec<(f64, f64)> = places
            .par_iter()
            .zip(&truth)
            .map_init(
                || (Scratch::new(reader), vec![0f32; pieces * 3 * CUBIC]),
                |(scratch, cubics), (place, truth)| {
                    sums.cubics(*place, scratch, cubics);
                    let largest_w = (4.0 - place.length_squared()).max(0.0).sqrt();
                    let mut parts = (0.0, 0.0);
                    let largest: [f32; 3] = std::array::from_fn(|channel| {
                        truth.iter().map(|colour| colour[channel]).fold(0.0, f32::max)
                    });
                    for (w, truth) in fine.iter().zip(truth).filter(|(w, _)| **w <= largest_w) {
                        for (channel, truth) in truth.iter().enumerate() {
                            let value = evaluate(cubics, pieces, channel, *w);
                            let size = truth.hypot(FAINT * largest[channel]);
                            if size > 0.0 {
                                parts.0 += f64::from((value - truth) / size).powi(2);
                                parts.1 += 1.0;
                            }
                        }
                    }
                    parts
                },
            )
            .collect();
        let lit: Vec<f64> =
            parts.iter().filter(|p| p.1 > 0.0).map(|(error, energy)| error / energy).collect();
        (lit.iter().sum::<f64>() / lit.len().max(1) as f64).sqrt()
    };
    for pieces in 1..=MOST_PIECES {
        let error = error_of(pieces);
        if error <= settings.cubic_error {
            return Ok((pieces, error));
        }
    }
    Err(Error::failed(
        format!("{MOST_PIECES} cubics do not hold the colours of so high a surface"),
        "ask for a larger --tolerance, or use --method spectral",
    ))
}

/// A channel at |w| from [piece][channel][power].
fn evaluate(cubics: &[f32], pieces: usize, channel: usize, w: f64) -> f32 {
    let place = w / LARGEST_W * pieces as f64;
    let piece = (place as usize).min(pieces - 1);
    let t = (2.0 * (place - piece as f64) - 1.0) as f32;
    let c = &cubics[(piece * 3 + channel) * CUBIC..][..CUBIC];
    c[0] + t * (c[1] + t * (c[2] + t * c[3]))
}

/// A unit in which the largest coefficient stands near the largest 16-bit floats.
fn unit_of(values: &[f32]) -> f64 {
    const NEAR: f32 = 3e4;
    let largest = values.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    if largest > 0.0 { f64::from(largest / NEAR) } else { 1.0 }
}

/// The next level: a blur by the growth of the grid, at every second place between two texels.
fn next_level(values: &[f32], side: usize, width: usize, level: usize, grid: &Grid) -> Vec<f32> {
    let spread = 3f64.sqrt() * grid.growth * 2f64.powi(level as i32) / grid.spacing(level);
    // Weights of the texels at ±½, ±1½ …, e^(−8) at the last.
    let reach = (4.0 * spread).ceil() as i64;
    let weight = |i: i64| (-0.5 * ((i as f64 - 0.5) / spread).powi(2)).exp();
    let total: f64 = (1 - reach..=reach).map(weight).sum();
    let taps: Vec<(i64, f32)> = (1 - reach..=reach).map(|i| (i, (weight(i) / total) as f32)).collect();
    let half = side / 2;
    let clamp = |i: i64| i.clamp(0, side as i64 - 1) as usize;
    let mut along_x = vec![0f32; half * side * width];
    along_x.par_chunks_mut(half * width).zip(values.par_chunks(side * width)).for_each(|(out, row)| {
        for (i, texel) in out.chunks_mut(width).enumerate() {
            for (offset, weight) in &taps {
                let source = clamp(2 * i as i64 + offset);
                let source = &row[source * width..(source + 1) * width];
                texel.iter_mut().zip(source).for_each(|(t, s)| *t += weight * s);
            }
        }
    });
    let mut both = vec![0f32; half * half * width];
    both.par_chunks_mut(half * width).enumerate().for_each(|(j, out)| {
        for (offset, weight) in &taps {
            let row = &along_x[clamp(2 * j as i64 + offset) * half * width..][..half * width];
            out.iter_mut().zip(row).for_each(|(o, s)| *o += weight * s);
        }
    });
    both
}

/// A level as 16-bit texels, prefiltered for linear reading: (−1, 14, −1)/12 along each axis (Condat, Blu, Unser, *Beyond
/// interpolation*, 2005).
fn texels(values: &[f32], side: usize, pieces: usize, unit: f64) -> Vec<f16> {
    let width = pieces * 3 * CUBIC;
    let scale = (1.0 / unit) as f32;
    let mut out = vec![f16::ZERO; values.len()];
    out.par_chunks_mut(side * side * CUBIC).enumerate().for_each(|(layer, out)| {
        let at = |row: usize, column: usize, power: usize| {
            values[(row * side + column) * width + layer * CUBIC + power]
        };
        let ends = |i: usize| [i.saturating_sub(1), (i + 1).min(side - 1)];
        for (row, out) in out.chunks_mut(side * CUBIC).enumerate() {
            let [below, above] = ends(row);
            for (column, texel) in out.chunks_mut(CUBIC).enumerate() {
                let [left, right] = ends(column);
                for (power, slot) in texel.iter_mut().enumerate() {
                    let along = |row: usize| {
                        (14.0 * at(row, column, power) - at(row, left, power) - at(row, right, power)) / 12.0
                    };
                    let value = (14.0 * along(row) - along(below) - along(above)) / 12.0;
                    *slot = f16::from_f32((value * scale).clamp(-65000.0, 65000.0));
                }
            }
        }
    });
    out
}
