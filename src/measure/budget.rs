//! Error budget of a setting, with the errors measured on the surface.

use crate::budget::{ErrorBudget, Share};
use crate::render::source::{Grating, Source, Table, Window};
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;
use crate::table::TableHeader;
use serde::Serialize;

/// Contribution to the error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BudgetPart {
    /// Name of the contribution.
    pub what: &'static str,
    /// Share of the tolerance.
    pub allowed: f64,
    /// Error of the data made for this share, relative to the quantity of the tolerance. NaN if unknown.
    pub error: f64,
    /// Origin of the error's value.
    pub known: String,
}

/// All contributions; their squares add up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeasuredBudget {
    /// Contributions.
    pub parts: Vec<BudgetPart>,
    /// Tolerance of the total.
    pub tolerance: f64,
}

impl MeasuredBudget {
    /// Returns the budget of shading from `source` with `optics`; empty for a baseline.
    pub fn of(source: &Source, optics: &Optics) -> Self {
        let parts = match source {
            Source::Window(Window { layers, .. }) | Source::Grating(Grating { layers, .. }) => {
                of_layers(layers, &optics.budget())
            }
            Source::Table(Table { table, .. }) => of_table(&table.header),
            Source::Thesis(_) | Source::ClassicalGrating(_) => return Self::default(),
        };
        let mut budget = Self { parts, tolerance: optics.tolerance };
        if optics.wavelengths.is_some() {
            budget.forget_wavelengths();
        }
        budget
    }

    /// Marks the error of the sum over wavelengths as unknown.
    fn forget_wavelengths(&mut self) {
        if let Some(part) = self.parts.last_mut() {
            part.error = f64::NAN;
            part.known = "unknown: the number of wavelengths is given; a comparison with the reference measures the total".into();
        }
    }

    /// Returns the root of the sum of squares of all known contributions.
    pub fn total(&self) -> f64 {
        self.known().map(|part| part.error * part.error).sum::<f64>().sqrt()
    }

    fn known(&self) -> impl Iterator<Item = &BudgetPart> {
        self.parts.iter().filter(|part| part.error.is_finite())
    }

    /// Formats one line per contribution, with its share of the sum of squares.
    pub fn to_text(&self) -> String {
        let squares = self.total().powi(2).max(f64::MIN_POSITIVE);
        let mut text = String::new();
        for part in &self.parts {
            let numbers = if part.error.is_finite() {
                format!(
                    "{:.1e} of {:.1e}, {:.0} %, ",
                    part.error,
                    part.allowed,
                    100.0 * part.error * part.error / squares
                )
            } else {
                String::new()
            };
            text += &format!("{:<26}{numbers}{}\n", part.what, part.known);
        }
        text + &format!("{:<26}{:.1e} of a tolerance of {:.0e}\n", "together", self.total(), self.tolerance)
    }
}

/// Returns the parts of a sum over the spectra in `layers`.
fn of_layers(layers: &Layers, budget: &ErrorBudget) -> Vec<BudgetPart> {
    let errors = &layers.errors;
    let bounds = format!(
        "bounds of the amplitude, relative to the specular peak: truncation {:.0e}, rounding of 32-bit floats {:.0e}",
        errors.truncation_bound, errors.rounding_bound
    );
    let window = &budget.window;
    let [expansion, interpolation, wavelengths] = window.shares();
    vec![
        part(expansion, errors.expansion / window.gain, &bounds),
        part(interpolation, errors.interpolation / window.gain, ""),
        part(wavelengths, wavelengths.allowed, ""),
    ]
}

/// Returns the parts of a colour table.
fn of_table(header: &TableHeader) -> Vec<BudgetPart> {
    let [series, reading, basis, wavelengths] = header.budget.shares();
    vec![
        part(series, header.series_error, ""),
        part(reading, reading.allowed, ""),
        part(basis, header.basis_error, ""),
        part(wavelengths, wavelengths.allowed, ""),
    ]
}

/// Returns a contribution with this `error`; `more` is appended to the reason for its share.
fn part(share: Share, error: f64, more: &str) -> BudgetPart {
    let Share { part, allowed, reason } = share;
    let known = if more.is_empty() { reason.to_owned() } else { format!("{reason}; {more}") };
    BudgetPart { what: part, allowed, error, known }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_as_squares_and_what_is_not_known_is_said() {
        let part = |what, error| BudgetPart { what, allowed: 1e-2, error, known: "so".to_owned() };
        let mut budget = MeasuredBudget { parts: vec![part("a", 3e-3), part("b", 4e-3)], tolerance: 1e-2 };
        assert!((budget.total() - 5e-3).abs() < 1e-12);
        let text = budget.to_text();
        assert!(
            text.contains("36 %") && text.contains("64 %") && text.contains("5.0e-3 of a tolerance"),
            "{text}"
        );
        budget.parts.push(part("c", f64::NAN));
        assert!((budget.total() - 5e-3).abs() < 1e-12 && !budget.to_text().contains("NaN"));
    }
}
