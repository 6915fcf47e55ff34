//! Rows and columns of an array exchanged.

use rayon::prelude::*;

/// Returns the transpose of `values`, row by row, with `columns` columns.
pub fn transposed<T: Copy + Default + Send + Sync>(columns: usize, values: &[T]) -> Vec<T> {
    let mut out = vec![T::default(); values.len()];
    transpose(columns, values, &mut out);
    out
}

/// Writes the transpose of `values`, row by row, with `columns` columns, into `out`, which is as long.
pub fn transpose<T: Copy + Send + Sync>(columns: usize, values: &[T], out: &mut [T]) {
    /// Rows of the result that are written together, so that more than one number is read of each cache line.
    const TOGETHER: usize = 8;
    let rows = values.len() / columns;
    out.par_chunks_mut(TOGETHER * rows).enumerate().for_each(|(block, out)| {
        for (row, source) in values.chunks_exact(columns).enumerate() {
            for (out, value) in out.chunks_exact_mut(rows).zip(&source[TOGETHER * block..]) {
                out[row] = *value;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns_whatever_the_size() {
        for (columns, rows) in [(1, 1), (1, 9), (9, 1), (8, 8), (7, 17), (17, 7), (24, 3)] {
            let values: Vec<usize> = (0..columns * rows).collect();
            let turned = transposed(columns, &values);
            let exact = (0..columns * rows).map(|i| (i % rows) * columns + i / rows);
            assert!(turned.iter().copied().eq(exact), "{columns} x {rows}");
            assert_eq!(transposed(rows, &turned), values);
        }
    }
}
