//! Heights and spectra reduced to the resolution of a picture, and their distribution.

use super::height_spectrum::SurfaceSpectrum;
use crate::surface::HeightField;

/// Values on a grid, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotGrid {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The values.
    pub values: Vec<f64>,
}

impl PlotGrid {
    /// Returns the heights of `field` \[nm\], averaged down until no side is longer than `most`.
    pub fn of_heights(field: &HeightField, most: usize) -> Self {
        reduced([field.columns(), field.rows()], most, |column, row| field.row(row)[column] * 1e3)
    }

    /// Returns the power density of `spectrum` \[nm² µm²\] over both halves, f from −`side` to `side` \[1/µm\] along both axes, averaged
    /// down until no side is longer than `most`.
    pub fn of_power(spectrum: &SurfaceSpectrum, side: f64, most: usize) -> Self {
        let [columns, rows] = spectrum.samples;
        let cells = [0, 1].map(|axis| (2.0 * side * spectrum.patch[axis]).round().max(1.0) as usize);
        reduced(cells, most, |c, r| {
            let place = |n: usize, cells: usize| n as isize - (cells / 2) as isize;
            let (i, j) = (place(c, cells[0]), place(r, cells[1])); // rows grow down as the transform's places do
            let inside = 2 * i.unsigned_abs() <= columns && 2 * j.unsigned_abs() <= rows;
            let power = if inside { spectrum.value(i, j).norm_sqr() } else { 0.0 };
            power * spectrum.patch[0] * spectrum.patch[1] * 1e6
        })
    }

    /// Returns the range of all values but the half percent at each end, so that dust does not take the colours.
    pub fn core(&self) -> [f64; 2] {
        let mut sorted = self.values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let cut = sorted.len() / 200;
        [sorted[cut], sorted[sorted.len() - 1 - cut]]
    }
}

/// Returns the largest frequency in a picture of a power spectrum along each axis \[1/µm\]: the Nyquist frequency or, if smaller, the
/// largest frequency that light of the wavelength `shortest` \[µm\] sees, |f| ≤ 2/λ, plus a margin of 10 %.
pub fn side_of_power(spectrum: &SurfaceSpectrum, shortest: f64) -> f64 {
    let largest = [0, 1].map(|axis| spectrum.samples[axis] as f64 / 2.0 / spectrum.patch[axis]);
    largest[0].min(largest[1]).min(2.2 / shortest)
}

fn reduced(size: [usize; 2], most: usize, value: impl Fn(usize, usize) -> f64) -> PlotGrid {
    let factor = size[0].max(size[1]).div_ceil(most);
    let [columns, rows] = size.map(|n| (n / factor).max(1));
    let mean = |i: usize| {
        let (c0, r0) = (i % columns * factor, i / columns * factor);
        let cells = (r0..(r0 + factor).min(size[1]))
            .flat_map(|r| (c0..(c0 + factor).min(size[0])).map(move |c| (c, r)));
        let (sum, count) = cells.fold((0.0, 0.0), |(sum, count), (c, r)| (sum + value(c, r), count + 1.0));
        sum / count
    };
    PlotGrid { size: [columns, rows], values: (0..columns * rows).map(mean).collect() }
}

/// Returns the density of `values` in bins of `width` from `low` to `high`, at most four times `bins`, as the outline of a band: x, 0,
/// density.
pub fn histogram(
    values: impl Iterator<Item = f64>,
    [low, high]: [f64; 2],
    width: f64,
    bins: usize,
) -> Vec<[f64; 3]> {
    let width = if width > 0.0 { width } else { 1.0 };
    let bins = (((high - low) / width).ceil() as usize).clamp(1, 4 * bins);
    let mut counts = vec![0.0; bins];
    let mut all = 0.0;
    for value in values {
        all += 1.0;
        if let Some(count) = counts.get_mut(((value - low) / width) as usize) {
            *count += 1.0;
        }
    }
    let density = |count: &f64| count / (f64::max(all, 1.0) * width);
    let steps = counts
        .iter()
        .enumerate()
        .flat_map(|(i, count)| [i, i + 1].map(|edge| [low + edge as f64 * width, 0.0, density(count)]));
    steps.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_integrates_to_one_and_grids_keep_their_mean() {
        let bars = histogram([0.1, 0.2, 0.6, 0.9].into_iter(), [0.0, 1.0], 0.25, 120);
        let area: f64 = bars.chunks(2).map(|b| (b[1][0] - b[0][0]) * b[0][2]).sum();
        assert!((area - 1.0).abs() < 1e-12, "{bars:?}");
        assert_eq!(bars[0], [0.0, 0.0, 2.0]);
        let field = HeightField::from_fn(64, 32, [0.1; 2], |x, y| 0.3 * x - 0.2 * y).unwrap();
        let grid = PlotGrid::of_heights(&field, 16);
        assert_eq!(grid.size, [16, 8]);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean(&grid.values) - 1e3 * mean(field.heights())).abs() < 1e-9);
        // Row 0 is at the top, where y is largest and the height lowest.
        assert!(grid.values[0] < grid.values[16 * 7]);
    }
}
