//! Tolerances that users can type, and the least of them with which a request succeeds.

use crate::error::{Error, Remedy, Result};

/// Range of tolerances: below the first, rounding of 32-bit floats dominates everywhere.
pub const TOLERANCES: (f64, f64) = (1e-6, 1.0);

/// Factor by which the next tolerance is larger at least: far above [`ROUNDING`], so that it is another number of one digit.
const STEP: f64 = 1.0 + 1e-6;
/// Factor within which numbers count as equal, above the rounding of f64.
const ROUNDING: f64 = 1.0 + 1e-9;

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
            Ok(()) => return Some(least_below(next, tolerance, attempt)),
            Err(refusal) => (tolerance, growth) = (next, self::growth(&refusal)?),
        }
    }
}

/// Returns the least tolerance of one digit that `attempt` accepts, from the `accepted` one down to the `refused` one: a growth is an estimate, because what is
/// made for a larger tolerance errs by a little more or less.
fn least_below(mut accepted: f64, refused: f64, mut attempt: impl FnMut(f64) -> Result<()>) -> f64 {
    loop {
        let next = next_below(accepted);
        if next <= refused || attempt(next).is_err() {
            return accepted;
        }
        accepted = next;
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
    of_digit((tolerance * 10f64.powi(-decade) / ROUNDING).ceil(), decade)
}

/// Returns the number of one digit below the `tolerance` of one digit.
fn next_below(tolerance: f64) -> f64 {
    let decade = (tolerance * ROUNDING).log10().floor() as i32;
    let digit = (tolerance * 10f64.powi(-decade)).round();
    if digit > 1.0 { of_digit(digit - 1.0, decade) } else { of_digit(9.0, decade - 1) }
}

/// Returns digit · 10^decade. Powers of 10 are exact, their inverses are not.
fn of_digit(digit: f64, decade: i32) -> f64 {
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
            if tolerance >= least { Ok(()) } else { Err(Error::limit("too small", remedy)) }
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
    fn a_growth_that_is_too_large_does_not_hide_a_smaller_tolerance() {
        let refusal = Error::limit("too small", Remedy::TimesTolerance(9.5));
        let error = with_least(refusal, 1e-2, request(0.031, true));
        assert_eq!(error.remedies(), [Remedy::Tolerance(4e-2)]);
    }

    #[test]
    fn tolerances_of_one_digit_follow_each_other() {
        for (tolerance, below) in [(5e-2, 4e-2), (2e-1, 1e-1), (1e-2, 9e-3), (1.0, 0.9), (1e-3, 9e-4)] {
            assert_eq!(next_below(tolerance), below);
            assert_eq!((rounded_up(tolerance), rounded_up(0.999 * tolerance)), (tolerance, tolerance));
        }
    }

    #[test]
    fn a_tolerance_that_does_not_help_is_no_remedy() {
        for remedy in [Remedy::LargerTolerance, Remedy::TimesTolerance(f64::INFINITY)] {
            let error = Error::limit("too small", remedy).or("look elsewhere");
            let named = with_least(error, 1e-2, request(2.0, false));
            assert_eq!(named.to_string(), "too small; look elsewhere");
        }
        let other = Error::input("no", "stop");
        assert_eq!(with_least(other.clone(), 1e-2, |_| panic!("tried")), other);
    }
}
