//! Metres of Python and micrometres of the library.

use pyo3::prelude::*;

/// Micrometres of a metre.
const UM: f64 = 1e6;
/// Digits of a decimal number that a float always holds.
const DIGITS: usize = 15;

/// Returns a length in metres in micrometres: the product with 10⁶, or the decimal number of fifteen digits beside it.
///
/// The command line reads `550nm` as the float that is nearest to 0.55 µm, and the product of 550e-9 and 10⁶ may be its neighbour. Whoever means a decimal number gets that number. A
/// length moves by two units in the last place at most, which is less than what sums of floats before it err by.
pub fn micrometres(metres: f64) -> f64 {
    decimal(metres * UM)
}

/// Returns a length in micrometres in metres, as [`micrometres`] in the other direction.
pub fn metres(micrometres: f64) -> f64 {
    decimal(micrometres / UM)
}

/// Returns the decimal number of fifteen digits beside `value` if it is at most two units in the last place away, else `value`.
fn decimal(value: f64) -> f64 {
    const UNITS: u64 = 2;
    let rounded: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    let is_beside = value.is_finite() && rounded.to_bits().abs_diff(value.to_bits()) <= UNITS;
    if is_beside { rounded } else { value }
}

/// Returns a length in metres in micrometres.
#[pyfunction]
pub fn micrometres_of(metres: f64) -> f64 {
    micrometres(metres)
}

/// Returns a length in micrometres in metres.
#[pyfunction]
pub fn metres_of(micrometres: f64) -> f64 {
    metres(micrometres)
}
