//! Sums over the spectrum for squares of texels of a colour table.
//!
//! For each wavelength the coefficients in z are read for all texels of a square, along f_x and then along f_y, and multiplied by the
//! polynomials at all |w|: a matrix product in which neighbouring texels share their reads.

use super::held::HeldFactor;
use super::{LARGEST_W, TableSettings};
use crate::optics::quadrature::{WavelengthSets, Wavelengths};
use crate::optics::reflectance::{MeanReflectance, Reflectance};
use crate::optics::spectrum::MIDDLE;
use crate::optics::theory::Theory;
use crate::spectra::power::chebyshev::nodes;
use crate::spectra::power::{OrderReader, OrderSeries, ReadScratch, Square};
use glam::{DVec2, Vec4};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of |w| in a piece of its range, for the coefficients of a cubic.
pub const NODES: usize = 4;

/// Wavelengths of each direction.
pub struct DirectionWavelengths {
    sets: WavelengthSets,
    // For each set, wavelength by wavelength, the reflectance over cos θ_h by Stam's theory; empty if it does not depend on the wavelength.
    reflectances: Vec<Vec<ReflectanceRow>>,
    // The same by the small-slope approximation.
    held: Option<HeldFactor>,
    variance: f64,
}

impl DirectionWavelengths {
    /// Chooses the wavelengths for the table of `settings`.
    pub fn new(series: &OrderSeries, settings: &TableSettings) -> Self {
        let orders = series.blur.variance;
        let variance = settings.finest.powi(2);
        // The response along a ray varies as fast as that of a window of this standard deviation, because both have the same blur.
        let blur = 0.5 * (orders[0] + orders[1]) + variance / MIDDLE.powi(2);
        let sigma = 1.0 / (PI * (8.0 * blur).sqrt());
        let illuminant = &settings.illuminant;
        let sets = match settings.wavelengths {
            Some(count) => WavelengthSets::only(Wavelengths::catmull_rom(illuminant, count)),
            None => WavelengthSets::gaussian(illuminant, sigma, settings.budget.wavelengths),
        };
        let rows = |r: &Reflectance| {
            let mean = MeanReflectance::new(r);
            let row = |q: &f64| ReflectanceRow::new(r, &mean, *q);
            sets.sets.par_iter().map(|set| set.wavenumbers.iter().map(row).collect()).collect()
        };
        let stam = settings.reflectance.as_ref().filter(|r| r.theory() == Theory::Stam);
        let reflectances = stam.map_or_else(Vec::new, rows);
        let held = settings.reflectance.as_ref().and_then(HeldFactor::new);
        Self { sets, reflectances, held, variance }
    }
}

/// Ratio of R at one wavenumber to the mean R, over cos θ_h.
struct ReflectanceRow(Vec<f32>);

impl ReflectanceRow {
    /// Steps of cos θ_h, about as many as in shaders ([`crate::optics::reflectance::COLUMNS`] has the error).
    const STEPS: usize = 256;

    fn new(reflectance: &Reflectance, mean: &MeanReflectance, wavenumber: f64) -> Self {
        let at = |i: usize| {
            let cosine = i as f64 / Self::STEPS as f64;
            mean.ratio(reflectance.at(1.0 / wavenumber, cosine), cosine) as f32
        };
        Self((0..=Self::STEPS).map(at).collect())
    }

    /// Returns the ratio for |(u, v)|² = `uv2` and |w|² = `w2`.
    fn at(&self, uv2: f32, w2: f32) -> f32 {
        let place = (0.5 * (uv2 + w2).sqrt()).min(1.0) * Self::STEPS as f32;
        let left = (place as usize).min(Self::STEPS - 1);
        let share = place - left as f32;
        self.0[left] + share * (self.0[left + 1] - self.0[left])
    }
}

/// Number of |w| that the products process at once: the size of a vector register.
const LANES: usize = 8;
/// Number of places whose products share their reads of the polynomials.
const PLACES: usize = 4;

/// Sums over the spectrum at given |w|.
pub struct Sums<'a> {
    reader: &'a OrderReader<'a>,
    spectrum: &'a DirectionWavelengths,
    /// Number of |w|.
    count: usize,
    /// Number of |w|, rounded up to [`LANES`].
    padded: usize,
    /// For each set, wavelength by wavelength: `[w / LANES][term][w % LANES]`, q² z²/w² times the Chebyshev polynomials at z = 2πq|w|.
    polynomials: Vec<Vec<[f32; LANES]>>,
    /// |w|².
    w2: Vec<f32>,
    /// Factors that the sums hold by the small-slope approximation.
    held: Option<HeldRows>,
    /// Registers of this machine.
    arch: Arch,
}

/// Working arrays of a thread.
#[derive(Default)]
pub struct Scratch {
    reading: ReadScratch,
    /// `[place][term]`.
    terms: Vec<f32>,
    /// R, `[place][w]`; empty if R is a factor in front of the sums.
    reflectances: Vec<[f32; LANES]>,
    /// `[place][channel][w]`, w padded to [`LANES`].
    sums: Vec<Vec4>,
}

impl<'a> Sums<'a> {
    /// Prepares sums at the four Chebyshev nodes of each of `pieces`.
    pub fn new(reader: &'a OrderReader<'a>, spectrum: &'a DirectionWavelengths, pieces: usize) -> Self {
        Self::at(reader, spectrum, nodes_of_pieces(pieces))
    }

    /// Prepares sums at the given |w|.
    pub fn at(reader: &'a OrderReader<'a>, spectrum: &'a DirectionWavelengths, w: Vec<f64>) -> Self {
        let terms = reader.series.terms;
        let (count, padded) = (w.len(), w.len().next_multiple_of(LANES));
        let of_set = |set: &Wavelengths| {
            let mut values = vec![[0f32; LANES]; set.len() * terms * padded / LANES];
            let mut t = vec![0.0; terms];
            for (q, node) in set.wavenumbers.iter().zip(values.chunks_exact_mut(terms * padded / LANES)) {
                let factor = (2.0 * PI * q * q).powi(2);
                for (i, w) in w.iter().enumerate() {
                    reader.series.polynomials_at(2.0 * PI * q * w, &mut t);
                    for (factors, t) in node[i / LANES * terms..].iter_mut().zip(&t) {
                        factors[i % LANES] = (t * factor) as f32;
                    }
                }
            }
            values
        };
        let polynomials = spectrum.sets.sets.par_iter().map(of_set).collect();
        let w2 = (0..padded).map(|i| w.get(i).map_or(0.0, |w| (w * w) as f32)).collect();
        let held = spectrum.held.as_ref().map(|held| HeldRows::new(held, &spectrum.sets, &w, padded));
        Self { reader, spectrum, count, padded, polynomials, w2, held, arch: Arch::new() }
    }

    /// Writes XYZ at every w for every texel of `tile` into `scratch`.
    fn sum(&self, tile: &Square, scratch: &mut Scratch) {
        let number = self.spectrum.sets.number(tile.farthest());
        let set = &self.spectrum.sets.sets[number];
        let (terms, places) = (self.reader.series.terms, tile.side * tile.side);
        scratch.sums.clear();
        scratch.sums.resize(places * 3 * self.padded / 4, Vec4::ZERO);
        scratch.terms.resize(places * terms, 0.0);
        let nodes = set.wavenumbers.iter().zip(&set.weights);
        let polynomials = self.polynomials[number].chunks_exact(terms * self.padded / LANES);
        for (j, ((q, weight), polynomials)) in nodes.zip(polynomials).enumerate() {
            let widened = q * q * self.spectrum.variance;
            self.reader.read(&tile.scaled(*q), widened, &mut scratch.reading, &mut scratch.terms);
            if let Some(rows) = self.spectrum.reflectances.get(number) {
                self.reflect(tile, &rows[j], &mut scratch.reflectances);
            } else if let Some(held) = &self.held {
                scratch.reflectances.clear();
                for place in 0..places {
                    let uv = tile.place(place).length() as f32;
                    scratch.reflectances.extend(held.of_sets[number][j].at(uv));
                }
            }
            let products =
                Products { series: &scratch.terms, polynomials, terms, reflectances: &scratch.reflectances };
            let sums = bytemuck::cast_slice_mut(&mut scratch.sums);
            self.arch.dispatch(AddProducts { products, weights: weight.as_vec3().to_array(), sums });
        }
        if let Some(held) = &self.held {
            let sums: &mut [f32] = bytemuck::cast_slice_mut(&mut scratch.sums);
            for (place, sums) in sums.chunks_exact_mut(3 * self.padded).enumerate() {
                let uv = tile.place(place).length() as f32;
                for (sums, scale) in sums.chunks_exact_mut(self.padded).zip(&held.scales) {
                    let scales = scale.at(uv).flatten();
                    sums.iter_mut().zip(scales).for_each(|(sum, scale)| *sum *= scale);
                }
            }
        }
    }

    /// Writes R at a wavenumber for every place of `tile` and every w into `out`.
    fn reflect(&self, tile: &Square, row: &ReflectanceRow, out: &mut Vec<[f32; LANES]>) {
        out.clear();
        for place in 0..tile.side * tile.side {
            let uv2 = tile.place(place).length_squared() as f32;
            out.extend(self.w2.as_chunks::<LANES>().0.iter().map(|w2| w2.map(|w2| row.at(uv2, w2))));
        }
    }

    /// Returns XYZ at every w for one place.
    pub fn colours(&self, place: DVec2, scratch: &mut Scratch) -> Vec<[f32; 3]> {
        self.sum(&Square::point(place), scratch);
        let sums: &[f32] = bytemuck::cast_slice(&scratch.sums);
        (0..self.count).map(|i| std::array::from_fn(|channel| sums[channel * self.padded + i])).collect()
    }

    /// Returns XYZ at the nodes for every texel of `tile`: for each texel and channel, the nodes of all pieces and padding.
    pub fn at_nodes<'s>(&self, tile: &Square, scratch: &'s mut Scratch) -> std::slice::ChunksExact<'s, Vec4> {
        self.sum(tile, scratch);
        scratch.sums.chunks_exact(3 * self.padded / 4)
    }
}

/// Factors that sums hold by the small-slope approximation, at the |w| of the sums.
struct HeldRows {
    /// For each set, wavelength by wavelength, the mean of |B|².
    of_sets: Vec<Vec<HeldRow>>,
    /// Factors of X, Y and Z after the sums.
    scales: [HeldRow; 3],
}

impl HeldRows {
    fn new(held: &HeldFactor, sets: &WavelengthSets, w: &[f64], padded: usize) -> Self {
        let of_set = |set: &Wavelengths| {
            let row = |q: &f64| HeldRow::new(w, padded, |uv, w| held.mean(*q, uv, w));
            set.wavenumbers.iter().map(row).collect()
        };
        let scale = |channel: usize| HeldRow::new(w, padded, |uv, w| held.scales(uv, w)[channel]);
        Self { of_sets: sets.sets.par_iter().map(of_set).collect(), scales: [0, 1, 2].map(scale) }
    }
}

/// Function of |(u, v)| at each |w| of the sums.
struct HeldRow {
    /// `[step of |(u, v)|][w / LANES][w % LANES]`.
    values: Vec<[f32; LANES]>,
    lanes: usize,
}

impl HeldRow {
    /// Steps of |(u, v)| over 0 … 2.
    const STEPS: usize = 128;

    fn new(w: &[f64], padded: usize, of: impl Fn(f64, f64) -> f64) -> Self {
        let lanes = padded / LANES;
        let mut values = vec![[0f32; LANES]; (Self::STEPS + 1) * lanes];
        for (step, row) in values.chunks_exact_mut(lanes).enumerate() {
            let uv = LARGEST_W * step as f64 / Self::STEPS as f64;
            row.as_flattened_mut().iter_mut().zip(w).for_each(|(value, w)| *value = of(uv, *w) as f32);
        }
        Self { values, lanes }
    }

    /// Interpolates the function at |(u, v)| = `uv`.
    fn at(&self, uv: f32) -> impl Iterator<Item = [f32; LANES]> {
        let place = (uv / LARGEST_W as f32).clamp(0.0, 1.0) * Self::STEPS as f32;
        let left = (place as usize).min(Self::STEPS - 1);
        let share = place - left as f32;
        let rows = &self.values[left * self.lanes..][..2 * self.lanes];
        let (below, above) = rows.split_at(self.lanes);
        below.iter().zip(above).map(move |(a, b)| std::array::from_fn(|i| a[i] + share * (b[i] - a[i])))
    }
}

/// Factors of the products at one wavelength.
struct Products<'a> {
    /// `[place][term]`.
    series: &'a [f32],
    /// `[w / LANES][term][w % LANES]`.
    polynomials: &'a [[f32; LANES]],
    /// Number of terms.
    terms: usize,
    /// R, `[place][w / LANES][w % LANES]`; empty if R is a factor in front of the sums.
    reflectances: &'a [[f32; LANES]],
}

/// Adds max(0, Σ term·polynomial) · R times the XYZ `weights` of a wavelength to `sums`, for each place and |w|.
struct AddProducts<'a> {
    products: Products<'a>,
    weights: [f32; 3],
    /// `[place][channel][w]`.
    sums: &'a mut [f32],
}

impl WithSimd for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Products { series, polynomials, terms, reflectances } = self.products;
        let lanes = polynomials.len() / terms;
        // Registers of each LANES numbers.
        let each = LANES / S::F32_LANES;
        let (polynomials, _) = S::as_simd_f32s(polynomials.as_flattened());
        let (reflectances, _) = S::as_simd_f32s(reflectances.as_flattened());
        let (sums, _) = S::as_mut_simd_f32s(self.sums);
        let weights = self.weights.map(|weight| simd.splat_f32s(weight));
        let (dark, registers) = (simd.splat_f32s(0.0), lanes * each);
        for register in 0..registers {
            // Polynomials of this register, term by term.
            let first = register / each * terms * each + register % each;
            let polynomials = &polynomials[first..];
            let mut place = 0;
            for series in series.chunks(PLACES * terms) {
                let mut values = [dark; PLACES];
                let count = series.len() / terms;
                if count == PLACES {
                    let (a, rest) = series.split_at(terms);
                    let (b, rest) = rest.split_at(terms);
                    let (c, d) = rest.split_at(terms);
                    let [mut va, mut vb, mut vc, mut vd] = values;
                    for ((((factor, a), b), c), d) in
                        polynomials.iter().step_by(each).zip(a).zip(b).zip(c).zip(d)
                    {
                        va = simd.mul_add_e_f32s(*factor, simd.splat_f32s(*a), va);
                        vb = simd.mul_add_e_f32s(*factor, simd.splat_f32s(*b), vb);
                        vc = simd.mul_add_e_f32s(*factor, simd.splat_f32s(*c), vc);
                        vd = simd.mul_add_e_f32s(*factor, simd.splat_f32s(*d), vd);
                    }
                    values = [va, vb, vc, vd];
                } else {
                    for (value, series) in values.iter_mut().zip(series.chunks_exact(terms)) {
                        for (factor, term) in polynomials.iter().step_by(each).zip(series) {
                            *value = simd.mul_add_e_f32s(*factor, simd.splat_f32s(*term), *value);
                        }
                    }
                }
                for value in &values[..count] {
                    let mut value = simd.max_f32s(*value, dark);
                    if let Some(reflected) = reflectances.get(place * registers + register) {
                        value = simd.mul_f32s(value, *reflected);
                    }
                    let sums = &mut sums[3 * place * registers..][..3 * registers];
                    for (channel, weight) in weights.iter().enumerate() {
                        let sum = &mut sums[channel * registers + register];
                        *sum = simd.mul_add_e_f32s(value, *weight, *sum);
                    }
                    place += 1;
                }
            }
        }
    }
}

/// Returns the nodes of each of `pieces` of the range of |w|, one piece after the other.
pub fn nodes_of_pieces(pieces: usize) -> Vec<f64> {
    let length = LARGEST_W / pieces as f64;
    let of_piece = |piece| nodes(NODES, length).into_iter().map(move |w| piece as f64 * length + w);
    (0..pieces).flat_map(of_piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use pulp::Scalar;

    #[test]
    fn products_in_registers_are_the_plain_sums() {
        let mut random = Random::new(4);
        let mut numbers =
            |count: usize| -> Vec<f32> { (0..count).map(|_| random.share() as f32 - 0.4).collect() };
        // One place less than fills the last block.
        let (terms, places, lanes) = (12, 7, 2);
        let series = numbers(places * terms);
        let polynomials: Vec<[f32; LANES]> = numbers(lanes * terms * LANES).as_chunks().0.to_vec();
        let reflectances: Vec<[f32; LANES]> = numbers(places * lanes * LANES).as_chunks().0.to_vec();
        let weights = [0.3, 1.0, -0.2];
        for reflectances in [&[][..], &reflectances] {
            let products = || Products { series: &series, polynomials: &polynomials, terms, reflectances };
            let mut exact = vec![0f32; places * 3 * lanes * LANES];
            for (i, sum) in exact.iter_mut().enumerate() {
                let (place, channel, w) =
                    (i / (3 * lanes * LANES), i / (lanes * LANES) % 3, i % (lanes * LANES));
                let term =
                    |t: usize| series[place * terms + t] * polynomials[w / LANES * terms + t][w % LANES];
                let value = (0..terms).map(term).sum::<f32>().max(0.0);
                let r = reflectances.get(place * lanes + w / LANES).map_or(1.0, |r| r[w % LANES]);
                *sum = value * r * weights[channel];
            }
            assert!(exact.iter().any(|sum| *sum != 0.0) && exact.contains(&0.0));
            let (mut found, mut plain) = (vec![0f32; exact.len()], vec![0f32; exact.len()]);
            Arch::new().dispatch(AddProducts { products: products(), weights, sums: &mut found });
            AddProducts { products: products(), weights, sums: &mut plain }.with_simd(Scalar);
            for sums in [found, plain] {
                let apart = sums.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0f32, f32::max);
                assert!(apart < 1e-5, "{apart}");
            }
        }
    }
}
