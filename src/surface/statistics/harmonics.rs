//! Shape of a periodic profile, by the Fourier coefficients at multiples of its frequency.

use super::height_spectrum::{SurfaceSpectrum, hann};
use crate::error::Result;
use crate::surface::{HeightField, Levelling};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// Multiples of the frequency that are compared.
const MOST: usize = 5;
/// Fewer coefficients do not tell a sawtooth from other profiles.
const FEWEST: usize = 3;
/// Largest Σ |D_n|² over n ≥ 2 of a sinusoid: 0.04 where a second harmonic has a tenth of its amplitude, 0.15 of a triangle.
const SINUSOID_OVERTONES: f64 = 0.05;
/// Widest flank of a blaze over its period, and the largest RMS difference of its D_n from those of a sawtooth with
/// some flank up to this one.
const WIDEST_FLANK: f64 = 0.2;
const BLAZE_DIFFERENCE: f64 = 0.2;
/// Flanks that are tried.
const FLANKS: usize = 20;

/// Fourier coefficients of heights.
pub(super) struct Harmonics {
    /// c_n \[µm\] of the frequency times n = 1, 2 …, those below the Nyquist frequency: h = Σ c_n e^{2πi n f·r} over
    /// both signs of n.
    coefficients: Vec<Complex<f64>>,
}

impl Harmonics {
    /// Returns the coefficients of a spectrum of one period at multiples of the frequency at `place`.
    pub fn of_one_period(spectrum: &SurfaceSpectrum, place: [usize; 2]) -> Self {
        let spacing = [0, 1].map(|axis| spectrum.patch[axis] / spectrum.samples[axis] as f64);
        let count = resolved(spectrum.frequency(place[0], place[1]), spacing) as isize;
        let [i, j] = place.map(|n| n as isize);
        Self { coefficients: (1..=count).map(|n| spectrum.value(n * i, n * j)).collect() }
    }

    /// Returns the coefficients of `field` less its plane under a Hann window at multiples of `frequency` \[1/µm\].
    ///
    /// # Errors
    /// Too little memory for the levelled field.
    pub fn windowed(field: &HeightField, frequency: [f64; 2]) -> Result<Self> {
        let level = field.levelled(Levelling::Plane)?;
        let [across, down] = [level.columns(), level.rows()].map(hann);
        let spacing = level.pixel_size();
        let count = resolved(frequency, spacing);
        let turn = |cycles: f64| Complex::from_polar(1.0, -TAU * cycles);
        let columns: Vec<Complex<f64>> =
            (0..level.columns()).map(|c| turn(frequency[0] * spacing[0] * c as f64)).collect();
        let row = |r: usize| {
            let start = turn(-frequency[1] * spacing[1] * r as f64); // rows go down, y up
            let mut sums = [Complex::default(); MOST];
            for ((height, weight), column) in level.row(r).iter().zip(&across).zip(&columns) {
                let wave = start * column;
                let mut term = wave * (height * weight * down[r]);
                for sum in &mut sums[..count] {
                    *sum += term;
                    term *= wave;
                }
            }
            sums
        };
        let add = |a: [Complex<f64>; MOST], b: [Complex<f64>; MOST]| std::array::from_fn(|n| a[n] + b[n]);
        let sums = (0..level.rows()).into_par_iter().map(row).reduce(|| [Complex::default(); MOST], add);
        let weight = across.iter().sum::<f64>() * down.iter().sum::<f64>();
        Ok(Self { coefficients: sums[..count].iter().map(|sum| sum / weight).collect() })
    }

    /// Returns the mean square height of these frequencies \[µm²\].
    pub fn variance(&self) -> f64 {
        2.0 * self.coefficients.iter().map(Complex::norm_sqr).sum::<f64>()
    }

    /// Returns D_n = n c_n / |c_1| of n = 1, 2 …, the coefficients of the slope, as seen from where that of n = 1 is greatest.
    fn slopes(&self) -> Vec<Complex<f64>> {
        let of_slope =
            self.coefficients.iter().zip(1_i32..).map(|(c, n)| Complex::new(0.0, f64::from(n)) * c);
        let of_slope: Vec<Complex<f64>> = of_slope.collect();
        let Some(first) = of_slope.first().copied() else { return of_slope };
        let turned =
            |(d, n): (&Complex<f64>, i32)| d / Complex::from_polar(first.norm(), f64::from(n) * first.arg());
        of_slope.iter().zip(1..).map(turned).collect()
    }

    /// Returns true if a single frequency has nearly all of the slope.
    pub fn is_sinusoid(&self) -> bool {
        self.slopes().iter().skip(1).map(Complex::norm_sqr).sum::<f64>() <= SINUSOID_OVERTONES
    }

    /// Returns true if the slope is constant but for one narrow flank.
    pub fn is_blaze(&self) -> bool {
        let slopes = self.slopes();
        if slopes.len() < FEWEST {
            return false;
        }
        let difference = |flank: f64, sign: f64| {
            let squares = slopes
                .iter()
                .zip(1..)
                .skip(1)
                .map(|(d, n): (_, i32)| (d - sign.powi(n + 1) * pulse(flank, f64::from(n))).norm_sqr());
            (squares.sum::<f64>() / (slopes.len() - 1) as f64).sqrt()
        };
        let flanks = (0..=FLANKS).map(|step| WIDEST_FLANK * step as f64 / FLANKS as f64);
        // Flanks that rise and that fall.
        flanks
            .flat_map(|flank| [difference(flank, 1.0), difference(flank, -1.0)])
            .any(|difference| difference <= BLAZE_DIFFERENCE)
    }
}

/// Returns the number of multiples of a frequency \[1/µm\], at most [`MOST`], below the Nyquist frequencies of samples
/// this far apart \[µm\].
fn resolved(frequency: [f64; 2], spacing: [f64; 2]) -> usize {
    let cycles = [0, 1].map(|axis| (frequency[axis] * spacing[axis]).abs());
    (1..=MOST).take_while(|n| cycles.iter().all(|c| *n as f64 * c < 0.5)).count()
}

/// Returns coefficient n of a pulse that is `width` of the period wide, over coefficient 1.
fn pulse(width: f64, n: f64) -> f64 {
    if width == 0.0 { 1.0 } else { (PI * n * width).sin() / (n * (PI * width).sin()) }
}
