//! Ranges of numbers: `LO:HI:STEP`, as in `380:780:1`.

use crate::error::{Error, Result};

/// Largest number of values in a range.
const MAX_VALUES: f64 = 1e6;
/// Smallest step. Values are rounded to a thousandth of it.
const SMALLEST_STEP: f64 = 1e-6;
/// Fraction of a step by which the last value may exceed the end: (780 − 380)/0.1 is not an integer in binary floating point.
const SLACK: f64 = 1e-6;

/// Values from `low` in equal steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    low: f64,
    step: f64,
    count: usize,
}

impl Range {
    /// Parses `LO:HI:STEP` with both ends within `limits`. HI is included if a step falls on it. `what` names the values in errors.
    ///
    /// # Errors
    /// Not three finite numbers, LO above HI, a step below 1e-6, more than a million values.
    pub fn parse(text: &str, limits: (f64, f64), what: &str) -> Result<Self> {
        let refuse = |why: &str, remedy: &str| {
            Err(Error::usage(format!("`{text}` is not a range of {what}: {why}"), remedy.to_owned()))
        };
        let fields: Option<Vec<f64>> = text.split(':').map(number).collect();
        let Some([low, high, step]) = fields.as_deref() else {
            return refuse("it is not three numbers", "give LO:HI:STEP, as in 380:780:1");
        };
        if !(limits.0..=limits.1).contains(low) || !(limits.0..=limits.1).contains(high) {
            return refuse("an end is out of bounds", &format!("stay within {} to {}", limits.0, limits.1));
        }
        if low > high {
            return refuse("it is reversed", "give the lower end first");
        }
        if *step < SMALLEST_STEP {
            return refuse("the step is too small", &format!("give a step of at least {SMALLEST_STEP}"));
        }
        let steps = (high - low) / step;
        if steps >= MAX_VALUES {
            return refuse(
                "it has too many values",
                &format!("give a larger step, for at most {MAX_VALUES}"),
            );
        }
        Ok(Self { low: *low, step: *step, count: (steps + SLACK).floor() as usize + 1 })
    }

    /// Returns the values in increasing order.
    pub fn values(&self) -> Vec<f64> {
        // Rounding makes steps of 0.01 print as such.
        let scale = 1e3 / SMALLEST_STEP;
        (0..self.count).map(|i| ((self.low + i as f64 * self.step) * scale).round() / scale).collect()
    }

    /// Returns the distance between neighbouring values.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Returns the number of values, at least 1.
    pub fn count(&self) -> usize {
        self.count
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(text: &str) -> Result<Range> {
        Range::parse(text, (-90.0, 1000.0), "numbers")
    }

    #[test]
    fn both_ends_are_included_and_values_are_as_written() {
        let values = range("380:780:1").unwrap().values();
        assert_eq!((values.len(), values[0], values[400]), (401, 380.0, 780.0));
        let fine = range("-57.5:-38:0.01").unwrap().values();
        assert_eq!((fine.len(), fine[1], fine[1950]), (1951, -57.49, -38.0));
        assert_eq!(range("1:2:0.7").unwrap().values(), [1.0, 1.7]);
        assert_eq!(range("550:550:5").unwrap().count(), 1);
    }

    #[test]
    fn what_is_no_range_is_refused_with_its_reason() {
        for (text, reason) in [
            ("", "three numbers"),
            ("5", "three numbers"),
            ("1:2", "three numbers"),
            ("1:2:3:4", "three numbers"),
            ("1:x:1", "three numbers"),
            ("nan:2:1", "three numbers"),
            ("1:inf:1", "three numbers"),
            ("1:2:nan", "three numbers"),
            ("2:1:1", "reversed"),
            ("2:1:-1", "reversed"),
            ("1:2:0", "step"),
            ("1:2:-1", "step"),
            ("1:2:1e-9", "step"),
            ("-91:2:1", "out of bounds"),
            ("1:1001:1", "out of bounds"),
            ("0:1000:1e-6", "too many"),
        ] {
            let error = range(text).unwrap_err();
            assert!(
                error.to_string().contains(reason) && error.kind() == crate::error::ErrorKind::Usage,
                "{text}: {error}"
            );
        }
    }
}
