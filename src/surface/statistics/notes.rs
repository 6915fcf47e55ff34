//! Warnings about the data, in sentences.

use super::Statistics;
use super::height_spectrum::analysed_part;
use super::heights::{CORE, core_range};
use crate::error::Result;
use crate::surface::{HeightField, Levelling};

/// Height range relative to the range of all but the outermost samples, from which dust is reported.
const DUSTY: f64 = 1.25;
/// Height range after levelling by a plane, relative to the range before, from which dust is reported.
const RAISED: f64 = 1.02;
/// Number of levels in the height range below which coarse quantisation is reported.
const COARSE_LEVELS: usize = 1024;
/// Share of the variance at undersampled frequencies from which it is reported.
const UNDERSAMPLED: f64 = 0.02;

/// Returns warnings about `field`, one sentence each. `statistics` are those of `field`.
///
/// # Errors
/// Heights so large that their sums are not finite numbers.
pub fn notes(field: &HeightField, statistics: &Statistics) -> Result<Vec<String>> {
    let notes = [
        dust(statistics),
        levelling(field)?,
        quantisation(statistics),
        sampling(statistics),
        seams(statistics),
    ];
    Ok(notes.into_iter().flatten().collect())
}

fn nm(um: f64) -> String {
    format!("{:.1} nm", um * 1e3)
}

fn dust(statistics: &Statistics) -> Option<String> {
    let heights = &statistics.heights;
    let range = heights.range[1] - heights.range[0];
    (heights.core_range > 0.0 && range > DUSTY * heights.core_range).then(|| {
        format!(
            "dust: all but {:.1} % of the samples lie within {}, the others widen the range to {}",
            200.0 * CORE,
            nm(heights.core_range),
            nm(range)
        )
    })
}

/// Warns if levelling by a plane widens the height range: it narrows that of a tilted scan, unless a few samples that stand out elsewhere
/// set the range.
fn levelling(field: &HeightField) -> Result<Option<String>> {
    let part = analysed_part(field);
    let (low, high) = part.range();
    let levelled = part.levelled(Levelling::Plane)?;
    let (lowest, highest) = levelled.range();
    let dusty = highest - lowest > DUSTY * core_range(levelled.heights());
    Ok((dusty && highest - lowest > RAISED * (high - low)).then(|| {
        format!(
            "dust: `level plane` raises the height range from {} to {}; a few samples set it, not the tilt",
            nm(high - low),
            nm(highest - lowest)
        )
    }))
}

fn quantisation(statistics: &Statistics) -> Option<String> {
    let heights = &statistics.heights;
    let step = heights.quantisation.filter(|_| heights.levels < COARSE_LEVELS && heights.levels > 2)?;
    Some(format!(
        "quantisation: heights are multiples of {:.3} nm ({} levels), an error of {:.3} nm RMS",
        step * 1e3,
        heights.levels,
        step * 1e3 / 12f64.sqrt()
    ))
}

fn sampling(statistics: &Statistics) -> Option<String> {
    let share = statistics.undersampled_share;
    (share > UNDERSAMPLED).then(|| {
        format!(
            "sampling: {:.0} % of the height variance is in structure finer than four samples; scan with a smaller distance between samples",
            100.0 * share
        )
    })
}

fn seams(statistics: &Statistics) -> Option<String> {
    use crate::surface::tiling::Verdict;
    let tiling = &statistics.tiling;
    if tiling.verdict == Verdict::Tiles {
        return None;
    }
    let broken = tiling.broken_in_words();
    if !broken.is_empty() {
        return Some(format!(
            "seams: copies do not join, because the patch holds {}; `crop` it to whole periods, or `tile` or `taper` it",
            broken.join(" and ")
        ));
    }
    Some(format!(
        "seams: copies do not join (steps across them {:.1} and {:.1} times the nearest inside); `tile` or `taper` makes them",
        tiling.ratio[0], tiling.ratio[1]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::tests::field;
    use crate::task::Task;
    use std::f64::consts::TAU;

    fn notes_of(field: &HeightField) -> String {
        notes(field, &Statistics::of(field, &Task::silent()).unwrap()).unwrap().join("\n")
    }

    #[test]
    fn a_clean_field_that_tiles_has_no_notes() {
        assert_eq!(notes_of(&field(120, 120, |x, y| (TAU * x / 1.2).sin() + (TAU * y / 3.0).cos())), "");
    }

    #[test]
    fn dust_and_seams_and_coarse_codes_are_told() {
        // A tilt of 0.5 over the field, a particle at its lower end and a pit at its upper end: both within the tilted range.
        let dusty = notes_of(&field(100, 100, |x, y| {
            let in_row = y > 2.0 && y < 2.07;
            let particle = if in_row && x < 0.15 { 0.45 } else { 0.0 };
            let pit = if in_row && x > 9.75 { 0.45 } else { 0.0 };
            0.05 * x + 0.001 * (7.0 * x + 5.0 * y).sin() + particle - pit
        }));
        assert!(dusty.contains("`level plane` raises the height range from 49"), "{dusty}");
        assert!(dusty.contains("seams: ") && !dusty.contains("quantisation"), "{dusty}");
        let codes = notes_of(&field(90, 90, |x, y| 0.002 * (40.0 * (x * y).sin()).round()));
        assert!(codes.contains("multiples of 2.000 nm (81 levels), an error of 0.577 nm RMS"), "{codes}");
        let particle = notes_of(&field(90, 90, |x, y| {
            0.1 * (TAU * x / 1.5).sin() + if x < 0.15 && y < 0.07 { 1.0 } else { 0.0 }
        }));
        assert!(particle.contains("dust: all but 0.1 % of the samples lie within"), "{particle}");
    }

    #[test]
    fn structure_of_three_samples_is_told() {
        assert!(notes_of(&field(90, 90, |x, _| (TAU * x / 0.3).sin())).contains("sampling: 100 %"));
    }
}
