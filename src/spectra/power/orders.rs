//! The powers |c_m(z)|² of a patch's orders at one z, by an f64 Fourier transform.

use super::Beyond;
use crate::error::Result;
use crate::memory;
use crate::surface::HeightField;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// Block of kept orders m around 0 along each axis. Order m = (i − origin) stands at column or row i, with f_y growing with the row.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct OrderGrid {
    /// Orders along m_x and m_y.
    pub size: [usize; 2],
    /// Column and row of order 0.
    pub origin: [usize; 2],
    /// Side lengths T_x, T_y of the patch \[µm\]: orders are 1/T apart.
    pub patch: [f64; 2],
    /// True if all orders of the samples are kept, so that the grid repeats beyond its ends.
    pub periodic: [bool; 2],
}

impl OrderGrid {
    /// Returns the orders of `field` up to the frequency `band` \[µm⁻¹\] and `guard` \[µm⁻¹\] beyond, or all orders of its samples.
    pub fn new(field: &HeightField, band: f64, guard: f64) -> Self {
        let samples = [field.columns(), field.rows()];
        let patch = field.patch_size();
        let kept = [0, 1].map(|i| (2 * ((band + guard) * patch[i]).ceil() as usize + 1).min(samples[i]));
        Self {
            size: kept,
            origin: kept.map(|n| n / 2),
            patch,
            periodic: [0, 1].map(|i| kept[i] == samples[i]),
        }
    }

    /// Returns the number of orders.
    pub fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }
}

/// Powers of the orders at one z.
#[derive(Clone, Debug)]
pub struct OrderPowers {
    /// Power of the specular order, |⟨e^{izh}⟩|².
    pub specular: f64,
    /// |c_m|² of the others, row by row in growing m_y; with [`Beyond::Copies`] order 0 is 0 here.
    pub powers: Vec<f64>,
}

/// Transforms of one field at many z.
pub struct Transform<'a> {
    field: &'a HeightField,
    grid: OrderGrid,
    beyond: Beyond,
    // Square root of the taper's share of each column and row; their squares have a mean of 1.
    taper: [Vec<f64>; 2],
    // Transform of the taper along x, at the kept columns.
    taper_spectrum: Vec<Complex64>,
    middle: f64,
    along_x: Arc<dyn Fft<f64>>,
    along_y: Arc<dyn Fft<f64>>,
}

impl<'a> Transform<'a> {
    /// Plans the transforms for the orders `grid` of `field`.
    pub fn new(field: &'a HeightField, grid: OrderGrid, beyond: Beyond) -> Self {
        let mut planner = FftPlanner::new();
        let (low, high) = field.range();
        let taper = [field.columns(), field.rows()].map(|n| match beyond {
            Beyond::Copies => vec![1.0; n],
            Beyond::Alike => hann(n),
        });
        // Frequencies are those of ω_i + ω_r and z is positive, so that the sum is over e^{izh} e^{2πi f·x}. Along y rows run downward,
        // so that the sign turns.
        let (along_x, along_y) =
            (planner.plan_fft_inverse(field.columns()), planner.plan_fft_forward(field.rows()));
        let mut spectrum: Vec<_> = taper[0].iter().copied().map(Complex64::from).collect();
        along_x.process(&mut spectrum);
        let at = |i: usize| spectrum[wrapped(i, grid.origin[0], field.columns())];
        let taper_spectrum = (0..grid.size[0]).map(at).collect();
        Self { field, grid, beyond, taper, taper_spectrum, middle: 0.5 * (low + high), along_x, along_y }
    }

    /// Returns the height field.
    pub fn field(&self) -> &HeightField {
        self.field
    }

    /// Returns the kept orders.
    pub fn grid(&self) -> &OrderGrid {
        &self.grid
    }

    /// Checks that there is memory for [`Transform::at`].
    ///
    /// # Errors
    /// Too little memory.
    pub fn ensure_room(&self) -> Result<()> {
        let bytes = (self.field.rows() * self.grid.size[0] + self.grid.count()) * size_of::<Complex64>();
        memory::ensure_room(bytes as u64, "the transforms of the heights")
    }

    /// Returns the powers at z \[rad/µm\].
    pub fn at(&self, z: f64) -> OrderPowers {
        let (columns, rows) = (self.field.columns(), self.field.rows());
        let [kept_x, kept_y] = self.grid.size;
        // Row transforms, the kept columns alone, and the sums of e^{iz(h − middle)} over the taper's power in each row.
        let mut half: Vec<Complex64> = vec![Complex64::ZERO; rows * kept_x];
        let row_sums: Vec<Complex64> = half
            .par_chunks_mut(kept_x)
            .enumerate()
            .map_init(
                || vec![Complex64::ZERO; columns],
                |buffer, (row, kept)| {
                    let (weigh, mut sum) = (self.taper[1][row], Complex64::ZERO);
                    let source = self.field.row(row).iter().zip(&self.taper[0]);
                    for (slot, (h, t)) in buffer.iter_mut().zip(source) {
                        let wave = Complex64::cis(z * (h - self.middle));
                        sum += wave * (t * t);
                        *slot = wave * (t * weigh);
                    }
                    self.along_x.process(buffer);
                    for (i, slot) in kept.iter_mut().enumerate() {
                        *slot = buffer[wrapped(i, self.grid.origin[0], columns)];
                    }
                    sum * (weigh * weigh)
                },
            )
            .collect();
        let norm = 1.0 / (columns * rows) as f64;
        // The specular amplitude, which is left out of a surface that goes on alike.
        let mean = row_sums.iter().sum::<Complex64>() * norm;
        let offset = if self.beyond == Beyond::Alike { mean } else { Complex64::ZERO };
        let columns_done: Vec<Vec<f64>> = (0..kept_x)
            .into_par_iter()
            .map(|column| {
                let specular = offset * self.taper_spectrum[column];
                let row = |(row, weigh): (usize, &f64)| half[row * kept_x + column] - specular * weigh;
                let mut buffer: Vec<Complex64> = self.taper[1].iter().enumerate().map(row).collect();
                self.along_y.process(&mut buffer);
                (0..kept_y)
                    .map(|j| (buffer[wrapped(j, self.grid.origin[1], rows)] * norm).norm_sqr())
                    .map(|power| if power < ROUNDING { 0.0 } else { power })
                    .collect()
            })
            .collect();
        let mut powers = vec![0.0; kept_x * kept_y];
        powers.par_chunks_mut(kept_x).enumerate().for_each(|(j, row)| {
            row.iter_mut().zip(&columns_done).for_each(|(slot, column)| *slot = column[j]);
        });
        if self.beyond == Beyond::Copies {
            powers[self.grid.origin[1] * kept_x + self.grid.origin[0]] = 0.0;
        }
        OrderPowers { specular: mean.norm_sqr(), powers }
    }
}

/// Power of an order, relative to the sum of all, below which it is the rounding of a transform. Without this limit a flat surface has the
/// colours of rounding, and takes as many cubics to hold them as the highest one.
const ROUNDING: f64 = 1e-24;

/// Returns the bin of a transform of `samples` that holds order `place − origin`.
fn wrapped(place: usize, origin: usize, samples: usize) -> usize {
    (place + samples - origin) % samples
}

/// Returns Hann's window over `count` samples, scaled so that the mean of its square is 1; a single sample has no taper.
pub(super) fn hann(count: usize) -> Vec<f64> {
    let window = |i: usize| (PI * (i as f64 + 0.5) / count as f64).sin().powi(2);
    let power: f64 = (0..count).map(|i| window(i).powi(2)).sum::<f64>() / count as f64;
    (0..count).map(|i| window(i) / power.sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rough(columns: usize, rows: usize) -> HeightField {
        let heights = (0..columns * rows).map(|i| 0.2 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
        HeightField::new(columns, rows, [0.1, 0.12], heights).unwrap()
    }

    #[test]
    fn each_order_is_the_plain_sum_over_the_patch() {
        for (columns, rows) in [(8, 6), (7, 9)] {
            let field = rough(columns, rows);
            let grid = OrderGrid::new(&field, 100.0, 0.0);
            let powers = Transform::new(&field, grid, Beyond::Copies).at(9.0);
            for (mx, my) in [(1i64, 0i64), (0, 1), (2, -1), (-3, 2)] {
                let mut sum = Complex64::ZERO;
                for row in 0..rows {
                    for column in 0..columns {
                        let turns = mx as f64 * field.x(column) / grid.patch[0]
                            + my as f64 * field.y(row) / grid.patch[1];
                        sum += Complex64::cis(9.0 * field.row(row)[column] + 2.0 * PI * turns);
                    }
                }
                let plain = (sum / (columns * rows) as f64).norm_sqr();
                let place = |m: i64, axis: usize| (m + grid.origin[axis] as i64) as usize;
                let got = powers.powers[place(my, 1) * grid.size[0] + place(mx, 0)];
                assert!((got - plain).abs() < 1e-14, "{columns}x{rows} order {mx},{my}: {got} {plain}");
                assert!(plain > 1e-6);
            }
        }
    }

    #[test]
    fn all_orders_together_hold_the_power_of_a_mirror() {
        let field = rough(12, 10);
        for beyond in [Beyond::Copies, Beyond::Alike] {
            let grid = OrderGrid::new(&field, 100.0, 0.0);
            let powers = Transform::new(&field, grid, beyond).at(11.0);
            let sum = powers.specular + powers.powers.iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-12, "{beyond:?}: {sum}");
        }
    }

    /// Returns J_m(x) = (1/π) ∫ cos(mτ − x sin τ) dτ over 0 … π.
    fn bessel(m: i64, x: f64) -> f64 {
        const STEPS: usize = 4000;
        let at = |i: usize| {
            let t = PI * (i as f64 + 0.5) / STEPS as f64;
            (m as f64 * t - x * t.sin()).cos()
        };
        (0..STEPS).map(at).sum::<f64>() / STEPS as f64
    }

    #[test]
    fn a_sinusoid_sends_squared_bessel_functions_into_its_orders_and_a_mirror_everything_into_one() {
        const PERIODS: usize = 3;
        let (columns, amplitude, z) = (96, 0.1, 17.0);
        let height = |i: usize| amplitude * (2.0 * PI * PERIODS as f64 * i as f64 / columns as f64).sin();
        let heights = (0..columns * 4).map(|i| height(i % columns)).collect();
        let field = HeightField::new(columns, 4, [0.1; 2], heights).unwrap();
        let grid = OrderGrid::new(&field, 100.0, 0.0);
        let powers = Transform::new(&field, grid, Beyond::Copies).at(z);
        assert!((powers.specular - bessel(0, z * amplitude).powi(2)).abs() < 1e-9);
        for order in 1..5i64 {
            let column = (order * PERIODS as i64 + grid.origin[0] as i64) as usize;
            let got = powers.powers[grid.origin[1] * grid.size[0] + column];
            assert!((got - bessel(order, z * amplitude).powi(2)).abs() < 1e-9, "order {order}: {got}");
        }
        let flat = HeightField::new(8, 8, [0.1; 2], vec![0.3; 64]).unwrap();
        let powers = Transform::new(&flat, OrderGrid::new(&flat, 100.0, 0.0), Beyond::Copies).at(z);
        assert!((powers.specular - 1.0).abs() < 1e-12 && powers.powers.iter().all(|p| *p < 1e-24));
    }

    #[test]
    fn a_scan_whose_edges_do_not_meet_shows_no_cross_when_the_surface_goes_on_alike() {
        // A tilt of one height range over the patch, and waves of whole periods: the seam alone sends light along the axes.
        let n = 64;
        let height = |x: f64, y: f64| 0.15 * x + 0.02 * (2.0 * PI * (5.0 * x + 4.0 * y)).sin();
        let heights =
            (0..n * n).map(|i| height((i % n) as f64 / n as f64, (i / n) as f64 / n as f64)).collect();
        let field = HeightField::new(n, n, [0.1; 2], heights).unwrap();
        let grid = OrderGrid::new(&field, 100.0, 0.0);
        let cross = |beyond| {
            let powers = Transform::new(&field, grid, beyond).at(12.0).powers;
            // Orders on the axis, far from the specular direction and from the waves.
            (20..28).map(|m| powers[grid.origin[1] * grid.size[0] + grid.origin[0] + m]).sum::<f64>()
        };
        let (copies, alike) = (cross(Beyond::Copies), cross(Beyond::Alike));
        assert!(alike < 1e-3 * copies, "{alike:e} of {copies:e}");
    }
}
