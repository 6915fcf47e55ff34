//! Preparing a height field: levelling, cleaning, cutting, and making its edges meet.
//!
//! A [`PreparationStep`] is one operation with its settings. Steps are applied in the order in which the user names them, each to the result of the
//! one before. A step has the same words on the command line, in scene files (`"level plane"`) and in the record of what
//! was done, and [`PreparationStep::parse`] reads what [`PreparationStep`]'s `Display` writes: the record repeats the preparation.

mod crop;
mod despike;
mod destripe;
mod facet;
mod interpolate;
mod invert;
mod level;
mod polynomial;
mod resample;
mod rotate;
mod rows;
mod taper;
mod tile;
mod tip;
mod words;

pub use crop::Crop;
pub use level::Levelling;
pub use rotate::Rotation;
pub use tile::Tile;
pub use words::WORDS;

use super::HeightField;
use crate::error::Result;
use crate::memory;
use crate::task::{PREPARATION, Task};

/// One operation on a height field. Lengths are micrometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PreparationStep {
    /// Subtracts an offset, a tilt, a bow, or the offsets of the scan lines.
    Level(Levelling),
    /// Replaces single samples that stand far out of their neighbours.
    Despike,
    /// Replaces streaks along rows: runs of samples that differ from the rows above and below.
    Destripe,
    /// Removes the shape of a tip with this radius of curvature.
    DeconvolveTip(f64),
    /// Keeps a rectangle.
    Crop(Crop),
    /// Changes the distance between samples along `x` and `y`.
    Resample([f64; 2]),
    /// Turns the surface about its normal.
    Rotate(Rotation),
    /// Fades the heights to their mean over this length at each edge.
    Taper(f64),
    /// Makes the edges meet.
    Tile(Tile),
    /// Inverts heights: the mould of the surface.
    Invert,
}

impl PreparationStep {
    /// Returns the field after this step, which its record names.
    ///
    /// # Errors
    /// A rectangle that is not inside the field, a length that the field is too small for, grooves that cannot be found, a result that is
    /// too large, heights whose sums are not finite numbers.
    pub fn apply(&self, field: &HeightField) -> Result<HeightField> {
        /// Fields in memory during a step: the result and working copies.
        const COPIES: u64 = 3;
        let bytes = COPIES * size_of_val(field.heights()) as u64;
        memory::ensure_room(bytes, &format!("the step `{self}`"))?;
        let apply = || match self {
            Self::Level(level) => field.levelled(*level),
            Self::Despike => despike::apply(field),
            Self::Destripe => destripe::apply(field),
            Self::DeconvolveTip(radius) => tip::apply(field, *radius),
            Self::Crop(crop) => crop.apply(field),
            Self::Resample(spacing) => resample::apply(field, *spacing),
            Self::Rotate(rotation) => rotation.apply(field),
            Self::Taper(length) => taper::apply(field, *length),
            Self::Tile(tile) => tile.apply(field),
            Self::Invert => invert::apply(field),
        };
        let mut prepared = field.prepared().clone();
        if !self.is_nothing() {
            prepared.push(self);
        }
        Ok(apply().map_err(|e| e.at(self))?.with_record(prepared))
    }

    /// Returns true if the step leaves every field unchanged.
    pub fn is_nothing(&self) -> bool {
        *self == Self::Level(Levelling::None)
    }
}

/// Applies all `steps` to `field` in their order.
///
/// # Errors
/// See [`PreparationStep::apply`]; the message names the step. Also fails if the task is cancelled.
pub fn apply_all(field: HeightField, steps: &[PreparationStep], task: &Task) -> Result<HeightField> {
    steps.iter().enumerate().try_fold(field, |field, (done, step)| {
        task.report(PREPARATION, done, steps.len())?;
        step.apply(&field)
    })
}

/// Returns the steps in words, in the form of scene files: `level plane, crop 40um`; `none` for no step.
pub fn describe(steps: &[PreparationStep]) -> String {
    if steps.is_empty() {
        return "none".to_owned();
    }
    steps.iter().map(PreparationStep::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let pixel = [0.1, 0.07];
        let empty = HeightField::new(columns, rows, pixel, vec![0.0; columns * rows]).unwrap();
        let at = |i: usize| h(empty.x(i % columns), empty.y(i / columns));
        HeightField::new(columns, rows, pixel, (0..columns * rows).map(at).collect()).unwrap()
    }

    /// Returns the largest absolute difference of two fields of one grid \[µm\].
    pub(super) fn difference(a: &HeightField, b: &HeightField) -> f64 {
        assert_eq!((a.columns(), a.rows()), (b.columns(), b.rows()));
        a.heights().iter().zip(b.heights()).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    }

    #[test]
    fn steps_act_in_their_order() {
        let slope = field(40, 40, |x, _| x * x);
        let parse =
            |all: &[&str]| all.iter().map(|text| PreparationStep::parse(text).unwrap()).collect::<Vec<_>>();
        let [first, second] = [["level mean", "crop 1um"], ["crop 1um", "level mean"]]
            .map(|steps| apply_all(slope.clone(), &parse(&steps), &Task::silent()).unwrap());
        let mean = |f: &HeightField| f.heights().iter().sum::<f64>() / f.heights().len() as f64;
        assert!(
            mean(&second).abs() < 1e-12 && mean(&first) < -0.5,
            "levelled before, the part has an offset"
        );
        assert_eq!(describe(&parse(&["level mean", "crop 1um"])), "level mean, crop 1um");
        assert_eq!(describe(&[]), "none");
    }

    #[test]
    fn every_step_takes_the_smallest_fields_or_says_why_not() {
        for (columns, rows) in [(1, 1), (1, 7), (7, 1), (2, 2), (3, 3)] {
            let small = field(columns, rows, |x, y| x + y);
            for text in words::EXAMPLES {
                match PreparationStep::parse(text).unwrap().apply(&small) {
                    Ok(field) => assert!(field.heights().iter().all(|h| h.is_finite()), "{text}"),
                    Err(e) => assert!(e.to_string().contains("; "), "{text}: {e}"),
                }
            }
        }
    }

    #[test]
    fn an_error_names_its_step() {
        let e = PreparationStep::parse("crop 40um")
            .unwrap()
            .apply(&field(4, 4, |x, _| x))
            .unwrap_err()
            .to_string();
        assert!(e.starts_with("crop 40um: "), "{e}");
    }
}
