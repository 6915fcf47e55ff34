//! Cells of environment maps: parts of about the same light and nearly square, by repeated halving along the longer side (Debevec 2005, "A
//! Median Cut Algorithm for Light Probe Sampling").

use std::ops::Range;

/// Prefix sums of the light of an environment map along its rows.
#[derive(Debug, PartialEq)]
pub(super) struct LightSums {
    width: usize,
    height: usize,
    /// Light of the pixels before each pixel of a row, and of the whole row at its end; row by row.
    sums: Vec<f64>,
}

/// A part of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub rows: Range<usize>,
    pub columns: Range<usize>,
    /// Number of samples in the cell: above 1 only for a single pixel.
    pub samples: u32,
}

impl LightSums {
    /// Sums the `light` of the pixels of a picture of `width` columns, row by row.
    pub fn new(width: usize, light: &[f64]) -> Self {
        let height = light.len() / width;
        let mut sums = Vec::with_capacity((width + 1) * height);
        for row in light.chunks_exact(width) {
            let mut sum = 0.0;
            sums.push(sum);
            sums.extend(row.iter().map(|light| {
                sum += light;
                sum
            }));
        }
        Self { width, height, sums }
    }

    /// Returns cell number `index` of `count`. Among 2^k cells, those whose numbers share their leading bits lie together.
    pub fn cell(&self, index: u32, count: u32) -> Cell {
        let mut cell = Cell { rows: 0..self.height, columns: 0..self.width, samples: count.max(1) };
        let mut index = index.min(cell.samples - 1);
        while cell.samples > 1 && (cell.rows.len() > 1 || cell.columns.len() > 1) {
            let first = cell.samples / 2;
            let share = f64::from(first) / f64::from(cell.samples);
            let is_first = index < first;
            if self.is_wide(&cell) {
                let middle = self.column_at(&cell, share);
                cell.columns = if is_first { cell.columns.start..middle } else { middle..cell.columns.end };
            } else {
                let middle = self.row_at(&cell, share);
                cell.rows = if is_first { cell.rows.start..middle } else { middle..cell.rows.end };
            }
            index = if is_first { index } else { index - first };
            cell.samples = if is_first { first } else { cell.samples - first };
        }
        cell
    }

    /// Returns true if `cell` is wider than high, measured across its middle. A single row or column is not cut along itself.
    fn is_wide(&self, cell: &Cell) -> bool {
        let middle = 0.5 * (cell.rows.start + cell.rows.end) as f64 / self.height as f64;
        let sine = (std::f64::consts::PI * middle).sin();
        let wide = cell.columns.len() as f64 * sine >= cell.rows.len() as f64;
        cell.columns.len() > 1 && (wide || cell.rows.len() == 1)
    }

    /// Returns the light of `columns` of `row`.
    fn light(&self, row: usize, columns: Range<usize>) -> f64 {
        let sums = &self.sums[row * (self.width + 1)..][..=self.width];
        sums[columns.end] - sums[columns.start]
    }

    /// Returns the column at which to cut `cell` so that the columns before have `share` of its light.
    fn column_at(&self, cell: &Cell, share: f64) -> usize {
        let Range { start, end } = cell.columns;
        let before = |column: usize| cell.rows.clone().map(|row| self.light(row, start..column)).sum::<f64>();
        let wanted = share * before(end);
        let (mut low, mut high) = (start + 1, end - 1);
        while low < high {
            let middle = usize::midpoint(low, high);
            if before(middle) < wanted { low = middle + 1 } else { high = middle }
        }
        nearer(low, start + 1, wanted, before)
    }

    /// Returns the row at which to cut `cell` so that the rows above have `share` of its light.
    fn row_at(&self, cell: &Cell, share: f64) -> usize {
        let Range { start, end } = cell.rows;
        let mut above = vec![0.0];
        above.extend(cell.rows.clone().scan(0.0, |sum, row| {
            *sum += self.light(row, cell.columns.clone());
            Some(*sum)
        }));
        let wanted = share * above[end - start];
        let row = start + above.partition_point(|sum| *sum < wanted);
        nearer(row.clamp(start + 1, end - 1), start + 1, wanted, |row| above[row - start])
    }
}

/// Returns the one of the cut `at` and the cut before it whose light is nearer to `wanted`.
fn nearer(at: usize, first: usize, wanted: f64, light: impl Fn(usize) -> f64) -> usize {
    let is_before = at > first && wanted - light(at - 1) < light(at) - wanted;
    if is_before { at - 1 } else { at }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> (usize, Vec<f64>) {
        let (width, height) = (64, 32);
        let at = |i: usize| 1.0 + (((i % width) * 7 + (i / width) * 13) % 11) as f64;
        (width, (0..width * height).map(at).collect())
    }

    fn light_of(cell: &Cell, width: usize, light: &[f64]) -> f64 {
        cell.rows.clone().flat_map(|row| &light[row * width..][cell.columns.clone()]).sum()
    }

    #[test]
    fn cells_cover_every_pixel_once_and_hold_about_the_same_light() {
        let (width, light) = picture();
        let sums = LightSums::new(width, &light);
        let total: f64 = light.iter().sum();
        for count in [1, 2, 3, 16, 37, 64] {
            let mut seen = vec![0; light.len()];
            for cell in (0..count).map(|index| sums.cell(index, count)) {
                assert_eq!(cell.samples, 1);
                let share = light_of(&cell, width, &light) / total * f64::from(count);
                assert!((share - 1.0).abs() < 0.35, "{count}: {share}, {cell:?}");
                for row in cell.rows {
                    cell.columns.clone().for_each(|column| seen[row * width + column] += 1);
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{count}");
        }
    }

    #[test]
    fn numbers_that_share_their_leading_bits_lie_together() {
        let (width, light) = picture();
        let sums = LightSums::new(width, &light);
        for index in 0..64 {
            let (inner, above) = (sums.cell(index, 64), sums.cell(index / 4, 16));
            assert!(inner.rows.start >= above.rows.start && inner.rows.end <= above.rows.end);
            assert!(inner.columns.start >= above.columns.start && inner.columns.end <= above.columns.end);
        }
    }

    #[test]
    fn a_pixel_that_outshines_all_others_is_shared() {
        let (width, mut light) = picture();
        light[700] = 1e9;
        let sums = LightSums::new(width, &light);
        let cells: Vec<_> = (0..16).map(|index| sums.cell(index, 16)).collect();
        let bright: Vec<_> = cells.iter().filter(|cell| light_of(cell, width, &light) >= 1e9).collect();
        assert!(!bright.is_empty() && bright.iter().all(|cell| cell.samples as usize == bright.len()));
        // Nothing is left out, and nothing counts twice.
        let sum: f64 = cells.iter().map(|cell| light_of(cell, width, &light) / f64::from(cell.samples)).sum();
        assert!((sum / light.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // The same without any light.
        let dark = LightSums::new(4, &[0.0; 8]);
        assert_eq!((0..100).map(|index| dark.cell(index, 100).columns.start).max(), Some(3));
    }
}
