//! Audit of the layers: the expansion's terms against the transform of e^{izh} itself, within the directions above the horizon.

use super::texels::Texels;
use super::transform::{PaddedAxis, TermPair, TermSpectrum, Transformer};
use crate::error::{Error, Result};
use crate::spectra::amplitude::expansion::Expansion;
use rustfft::num_complex::{Complex32, Complex64};
use std::f64::consts::PI;

/// Intensity relative to the specular peak below which errors are not judged: a 65 µm window's specular peak at normal incidence is 439
/// sr⁻¹ at 550 nm, and 4.4e-5 sr⁻¹ under a light of irradiance π is below the display's black at exposure 0.
pub const FAINT: f64 = 1e-7;

/// Returns [`FAINT`] at a part `share` of the largest k|w|: the BRDF divides by w².
fn faint(share: f64) -> f64 {
    FAINT * share * share
}

/// Number of terms for one audited plane of k|w|.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneTerms {
    /// k|w| \[rad/µm\].
    pub z: f64,
    /// Terms that keep the error on this plane.
    pub terms: usize,
}

/// Number of audited planes of k|w|.
pub const PLANES: usize = 9;

/// Audited k|w| as parts of the largest, increasing: from grazing directions, with scattered light only, to the specular direction at the
/// shortest wavelength.
const PLACES: [f64; PLANES] = [0.02, 0.08, 0.24, 0.33, 0.49, 0.66, 0.74, 0.87, 0.995];

/// Audit: a few planes of z with the transform of e^{izh} at some texels within the visible directions.
pub(super) struct Audit {
    pub planes: [Plane; PLANES],
}

pub(super) struct Plane {
    pub z: f64,
    /// Intensity below which a texel is not judged.
    faint: f64,
    /// Kept column and row of each judged texel.
    texels: Vec<[usize; 2]>,
    exact: Vec<Complex64>,
    /// `[term][texel]`, rounded as stored.
    terms: Vec<Vec<Complex32>>,
}

impl Audit {
    /// Evenly spread texels per plane: the RMS of this many exponentially distributed values is accurate to a few per cent.
    const SPREAD: usize = 2000;
    /// Brightest texels per plane, judged in addition: a grating has few orders, and they are all that is visible.
    const BRIGHTEST: usize = 500;

    pub fn new(
        transformer: &Transformer,
        heights: &[f64],
        half_range: f64,
        z_max: f64,
        progress: impl Fn(usize) -> Result<()>,
    ) -> Result<Self> {
        let mut planes = Vec::new();
        for (index, share) in PLACES.into_iter().enumerate() {
            progress(index)?;
            let z = share * z_max;
            let spectrum = transformer.spectrum(|i| Complex64::cis(z * half_range * heights[i]));
            let radius = (z_max * z_max - z * z).sqrt() / (2.0 * PI);
            let mut texels = spread(transformer, radius, Self::SPREAD);
            texels.extend(brightest(transformer, &spectrum, radius, Self::BRIGHTEST));
            let exact = texels.iter().map(|&[c, r]| spectrum.at(c, r)).collect();
            transformer.take_back([spectrum]);
            planes.push(Plane { z, faint: faint(share), texels, exact, terms: Vec::new() });
        }
        planes.try_into().map(|planes| Self { planes }).map_err(|_| Error::bug("the audit lost a plane"))
    }

    /// Adds a pair of terms, given on kept columns and rows.
    pub fn add(&mut self, pair: &TermPair) {
        for plane in &mut self.planes {
            let stored = |v: Complex64| Complex32::new(v.re as f32, v.im as f32);
            let pairs = plane.texels.iter().map(|&[c, r]| pair.at(c, r));
            let (even, odd) = pairs.map(|[a, b]| (stored(a), stored(b))).unzip();
            plane.terms.extend([even, odd]);
        }
    }

    /// Returns the worst plane's RMS relative intensity error with `terms` terms of `family`.
    pub fn error(&self, family: &dyn Expansion, terms: usize) -> f64 {
        self.planes.iter().map(|plane| plane.error(family, terms)).fold(0.0, f64::max)
    }

    /// Returns the same error with every number rounded to 16 bits.
    pub fn error_of_halves(&self, family: &dyn Expansion, terms: usize) -> f64 {
        let rounded = |v: &Complex32| Complex32::new(Texels::halved(v.re), Texels::halved(v.im));
        let error = |plane: &Plane| {
            let terms_there = plane
                .terms
                .iter()
                .map(|term| term.iter().map(rounded).collect::<Vec<_>>())
                .collect::<Vec<_>>();
            plane.error_of(&terms_there, family, terms)
        };
        self.planes.iter().map(error).fold(0.0, f64::max)
    }

    /// Returns the smallest number of terms, up to `terms`, that keeps each plane within `allowed`; never fewer than for a lower plane.
    pub fn terms_by_z(&self, family: &dyn Expansion, terms: usize, allowed: f64) -> [PlaneTerms; PLANES] {
        let mut least = 1;
        std::array::from_fn(|i| {
            let plane = &self.planes[i];
            least = (least..terms).find(|&n| plane.error(family, n) <= allowed).unwrap_or(terms);
            PlaneTerms { z: plane.z, terms: least }
        })
    }
}

impl Plane {
    /// Returns the RMS relative intensity error with the first `terms` terms, summed in f32 like in the shader.
    fn error(&self, family: &dyn Expansion, terms: usize) -> f64 {
        self.error_of(&self.terms, family, terms)
    }

    /// Returns the same error of the terms in `stored`.
    fn error_of(&self, stored: &[Vec<Complex32>], family: &dyn Expansion, terms: usize) -> f64 {
        let mut c = vec![Complex64::ZERO; terms];
        family.coefficients(self.z, &mut c);
        let c: Vec<Complex32> = c.iter().map(|c| Complex32::new(c.re as f32, c.im as f32)).collect();
        // Texels that are too dark to be seen would only dilute the mean.
        let seen = self.exact.iter().enumerate().filter(|(_, exact)| exact.norm_sqr() >= self.faint);
        let (count, squares) = seen.fold((0usize, 0.0), |(count, squares), (t, exact)| {
            let sum: Complex32 = c.iter().zip(stored).map(|(c, term)| c * term[t]).sum();
            let truth = exact.norm_sqr();
            (count + 1, squares + ((f64::from(sum.norm_sqr()) - truth) / truth).powi(2))
        });
        (squares / count.max(1) as f64).sqrt()
    }
}

/// Returns kept texels spread evenly over |f| ≤ `radius` \[µm⁻¹\], the frequencies that some direction above the horizon and some
/// wavelength reach at one z: |f|² ≤ (z_max² − z²)/(2π)², from |(u,v,w)| ≤ 2.
fn spread(transformer: &Transformer, radius: f64, most: usize) -> Vec<[usize; 2]> {
    let (x, y) = (&transformer.x, &transformer.y);
    // The additive recurrence of the plastic number (Roberts 2018) covers a square evenly for any count.
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let spot = |i: usize, power: i32| (0.5 + i as f64 * PLASTIC.powi(-power)).fract() * 2.0 - 1.0;
    (0..most)
        .filter_map(|i| {
            let (fx, fy) = (spot(i, 1) * radius, spot(i, 2) * radius);
            let column = (fx * x.length).round() as i64 + x.bins as i64;
            let row = (fy * y.length).round() as i64 + y.bins as i64;
            let inside = fx.hypot(fy) <= radius
                && (0..x.kept() as i64).contains(&column)
                && (0..y.kept() as i64).contains(&row);
            inside.then_some([column as usize, row as usize])
        })
        .collect()
}

/// Returns the `most` kept texels with |f| ≤ `radius` at which `spectrum` is largest.
fn brightest(
    transformer: &Transformer,
    spectrum: &TermSpectrum,
    radius: f64,
    most: usize,
) -> Vec<[usize; 2]> {
    let (x, y) = (&transformer.x, &transformer.y);
    let frequency = |k: usize, axis: &PaddedAxis| (k as f64 - axis.bins as f64) / axis.length;
    let mut best: Vec<(f64, [usize; 2])> = Vec::new();
    for column in 0..x.kept() {
        best.extend(
            (0..y.kept())
                .filter(|&row| frequency(column, x).hypot(frequency(row, y)) <= radius)
                .map(|row| (spectrum.at(column, row).norm_sqr(), [column, row])),
        );
        // Column by column, so that never more than one column is kept beside the best.
        if best.len() > most {
            best.select_nth_unstable_by(most, |a, b| b.0.total_cmp(&a.0));
            best.truncate(most);
        }
    }
    best.into_iter().map(|(_, texel)| texel).collect()
}
