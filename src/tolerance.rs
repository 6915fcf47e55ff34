//! Tolerances that users can type, and the least of them with which a request succeeds.

use crate::error::{Error, Remedy, Result};

/// Range of tolerances: below the first, rounding of 32-bit floats dominates everywhere.
pub const TOLERANCES: (f64, f64) = (1e-6, 1.0);

/// Factor by which the next tolerance is larger at least, above the rounding of f64.
const STEP: f64 = 1.0 + 1e-9;

/// Returns `error` with the least tolerance that `attempt` accepts in place of a larger one. Without such a tolerance, the remedy is left out. Errors with other
/// remedies are returned as they are.
pub fn with_least(error: Error, tolerance: f64, attempt: impl FnMut(f64) -> Result<()>) -> Error {
    match growth(&error) {
        Some(growth) => error.with_tolerance(least(tolerance, growth, attempt)),
        None => error,
    }
}

/// Returns the least tolerance of one digit, at least `growth` times `tolerance`, that `attempt` accepts; `None` if there is none. A refusal says how much
/// larger the next one has to be.
fn least(mut tolerance: f64, mut growth: f64, mut attempt: impl FnMut(f64) -> Result<()>) -> Option<f64> {
    loop {
        let next = rounded_up(tolerance * growth.max(STEP));
        if next.is_nan() || next > TOLERANCES.1 {
            return None;
        }
        match attempt(next) {
            Ok(()) => return Some(next),
            Err(refusal) => (tolerance, growth) = (next, self::growth(&refusal)?),
        }
    }
}

/// Returns the factor by which a tolerance has to grow at least for `error` to go; `None` if it is no remedy.
fn growth(error: &Error) -> Option<f64> {
    error.remedies().iter().find_map(|remedy| match remedy {
        Remedy::LargerTolerance => Some(1.0),
        Remedy::TimesTolerance(growth) => Some(*growth),
        _ => None,
    })
}

/// Returns the least number of one significant digit that is at least `tolerance`, exactly as a parser reads it.
fn rounded_up(tolerance: f64) -> f64 {
    let decade = tolerance.log10().floor() as i32;
    let digit = (tolerance * 10f64.powi(-decade) / STEP).ceil();
    // Powers of 10 are exact, their inverses are not.
    if decade < 0 { digit / 10f64.powi(-decade) } else { digit * 10f64.powi(decade) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a request that succeeds from `least` on, and tells by how much its tolerance is too small if `tells`.
    fn request(least: f64, tells: bool) -> impl FnMut(f64) -> Result<()> {
        move |tolerance| {
            let remedy =
                if tells { Remedy::TimesTolerance(least / tolerance) } else { Remedy::LargerTolerance };
            if tolerance >= least { Ok(()) } else { Err(Error::failed("too small", remedy)) }
        }
    }

    #[test]
    fn the_least_tolerance_of_one_digit_is_found_with_and_without_a_hint() {
        for (least, named) in [(0.0412, "5e-2"), (0.05, "5e-2"), (0.31, "4e-1"), (0.95, "1e0")] {
            for tells in [true, false] {
                let refusal = request(least, tells)(1e-2).unwrap_err();
                let error = with_least(refusal, 1e-2, request(least, tells));
                assert_eq!(error.to_string(), format!("too small; ask for a tolerance of {named}"));
                let Remedy::Tolerance(tolerance) = error.remedies()[0] else { panic!("{error}") };
                assert_eq!(named.parse(), Ok(tolerance), "as typed");
            }
        }
    }

    #[test]
    fn a_tolerance_that_does_not_help_is_no_remedy() {
        for remedy in [Remedy::LargerTolerance, Remedy::TimesTolerance(f64::INFINITY)] {
            let error = Error::failed("too small", remedy).or("look elsewhere");
            let named = with_least(error, 1e-2, request(2.0, false));
            assert_eq!(named.to_string(), "too small; look elsewhere");
        }
        let other = Error::failed("no", "stop");
        assert_eq!(with_least(other.clone(), 1e-2, |_| panic!("tried")), other);
    }
}
