//! Samples that were not measured.

use crate::error::{Error, Result};

/// Largest share of missing samples: beyond it most heights would be invented.
const MOST: f64 = 0.5;

/// Description of [`fill`], for messages.
pub const METHOD: &str =
    "each is filled with the mean of its measured neighbours, from the rim of a gap inwards";

/// Fills the `missing` NaN of `samples`, rows of `columns`. Every NaN with known neighbours among the eight around it becomes their mean.
/// Filled samples count as known in the next round, until all are filled. They stay within the range of the measured ones.
///
/// # Errors
/// More than half of the samples are missing.
pub fn fill(samples: &mut [f64], columns: usize, missing: usize) -> Result<()> {
    let count = samples.len();
    if missing as f64 > MOST * count as f64 {
        return Err(Error::input(
            format!("{missing} of {count} samples were not measured, more than half"),
            "cut out the measured part with the instrument's software",
        ));
    }
    let mut open = missing;
    // Missing samples beside measured ones, then beside those that were just filled: each sample is visited a few times.
    let mut rim: Vec<usize> = (0..count).filter(|&i| samples[i].is_nan()).collect();
    while open > 0 {
        let mean = |i: &usize| Some((*i, mean_around(samples, columns, *i)?));
        let known: Vec<(usize, f64)> = rim.iter().filter_map(mean).collect();
        if known.is_empty() {
            return Err(Error::input("no sample of it was measured", "choose another channel or file"));
        }
        for (i, mean) in &known {
            samples[*i] = *mean;
        }
        open -= known.len();
        rim = known
            .iter()
            .flat_map(|(i, _)| neighbours(count, columns, *i))
            .filter(|&i| samples[i].is_nan())
            .collect();
        rim.sort_unstable();
        rim.dedup();
    }
    Ok(())
}

/// Returns the indices of sample `i` and of its up to eight neighbours.
fn neighbours(count: usize, columns: usize, i: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (i / columns, i % columns);
    let last = count / columns - 1;
    let across = column.saturating_sub(1)..=(column + 1).min(columns - 1);
    (row.saturating_sub(1)..=(row + 1).min(last))
        .flat_map(move |r| across.clone().map(move |c| r * columns + c))
}

/// Returns the mean of the known samples among the eight neighbours.
fn mean_around(samples: &[f64], columns: usize, i: usize) -> Option<f64> {
    let known = neighbours(samples.len(), columns, i).map(|i| samples[i]).filter(|x| !x.is_nan());
    let (sum, count) = known.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: f64 = f64::NAN;

    #[test]
    fn gaps_are_filled_from_their_rims_and_never_with_zero() {
        let mut one = [1.0, 2.0, 3.0, 4.0, N, 6.0, 7.0, 8.0, 9.0];
        fill(&mut one, 3, 1).unwrap();
        assert_eq!(one[4], 5.0, "the mean of the eight around it");
        let mut line = [5.0, N, N, 5.5, 6.0, 6.5, 7.0];
        fill(&mut line, 7, 2).unwrap();
        assert_eq!(line[1..3], [5.0, 5.5], "a row of its own is one line of neighbours");
        let mut corner = [N, N, 4.0, N, N, 4.0, 4.0, 4.0, 4.0];
        fill(&mut corner, 3, 4).unwrap();
        assert_eq!(corner, [4.0; 9]);
    }

    #[test]
    fn filled_samples_stay_within_the_measured_range() {
        let mut samples: Vec<f64> = (0..400).map(|i| f64::from(i * 37 % 101) - 50.0).collect();
        let gaps: Vec<usize> = (0..400).filter(|i| i % 20 > 5 && i % 20 < 14).collect();
        gaps.iter().for_each(|&i| samples[i] = N);
        fill(&mut samples, 20, gaps.len()).unwrap();
        assert!(samples.iter().all(|h| (-50.0..=50.0).contains(h)));
    }

    #[test]
    fn more_than_half_is_refused() {
        assert!(fill(&mut [N, N, 1.0], 3, 2).unwrap_err().to_string().contains("2 of 3"));
        assert!(fill(&mut [N, 1.0], 2, 1).is_ok());
    }
}
