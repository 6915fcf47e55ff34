//! The error budget of a setting: where its error comes from.

use crate::precompute::Layers;
use crate::render::shading::Shading;
use crate::render::source::{Grating, Source, Table, Window};
use crate::setup::READING_SHARE;
use serde::Serialize;

/// One contribution to the error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BudgetPart {
    /// Its source.
    pub what: &'static str,
    /// Its size, relative to what the tolerance is defined for: single directions, or the colours of a picture. NaN if unknown.
    pub error: f64,
    /// How the size is known.
    pub known: String,
}

/// All contributions; their squares add up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// The contributions.
    pub parts: Vec<BudgetPart>,
    /// The tolerance for their sum.
    pub tolerance: f64,
}

impl ErrorBudget {
    /// The budget of what is shaded from `source` with `shading`; empty for a baseline.
    pub fn of(source: &Source, shading: &Shading) -> Self {
        match source {
            Source::Window(Window { layers }) | Source::Grating(Grating { layers, .. }) => {
                Self::of_layers(layers, shading)
            }
            Source::Table(Table { table }) => Self::of_table(table.header.basis_error, shading),
            Source::Thesis(_) | Source::ClassicalGrating(_) => Self::default(),
        }
    }

    /// The budget of `layers` for `shading`.
    pub fn of_layers(layers: &Layers, shading: &Shading) -> Self {
        let known_by_rule = "from the quadrature rule";
        let (quadrature, known) = match shading.wavelengths {
            None => (shading.quadrature(), known_by_rule),
            Some(_) => (
                f64::NAN,
                "unknown: the number of wavelengths is given; a comparison with the reference measures the total",
            ),
        };
        let part = |what, error, known: &str| BudgetPart { what, error, known: known.to_owned() };
        let bounds = format!(
            "measured against the transform of the exact phase; bounds of the amplitude, relative to the specular peak: truncation \
             {:.0e}, rounding of 32-bit floats {:.0e}",
            layers.errors.truncation_bound, layers.errors.rounding_bound
        );
        Self {
            parts: vec![
                part("truncation and rounding", layers.errors.expansion / shading.gain(), &bounds),
                part(
                    "reading between texels",
                    layers.errors.interpolation / shading.gain(),
                    "from the transform of the kernel",
                ),
                part("wavelengths of a colour", quadrature, known),
            ],
            tolerance: shading.tolerance,
        }
    }

    /// The parts of a colour table under `shading` whose basis errs by `basis`.
    fn of_table(basis: f64, shading: &Shading) -> Self {
        let part = |what, error, known: &str| BudgetPart { what, error, known: known.to_owned() };
        Self {
            parts: vec![
                part(
                    "reading between texels",
                    READING_SHARE * shading.tolerance,
                    "by the blur of the finest level",
                ),
                part("colours over w", basis, "measured at places that the basis was not made for"),
                part("wavelengths of a colour", shading.quadrature(), "by the rule for the nodes"),
            ],
            tolerance: shading.tolerance,
        }
    }

    /// The root of the sum of squares of all known contributions.
    pub fn total(&self) -> f64 {
        self.known().map(|part| part.error * part.error).sum::<f64>().sqrt()
    }

    fn known(&self) -> impl Iterator<Item = &BudgetPart> {
        self.parts.iter().filter(|part| part.error.is_finite())
    }

    /// One line per contribution, with its share of the sum of squares.
    pub fn to_text(&self) -> String {
        let squares = self.total().powi(2).max(f64::MIN_POSITIVE);
        let mut text = String::new();
        for part in &self.parts {
            let numbers = if part.error.is_finite() {
                format!("{:.1e}, {:.0} %, ", part.error, 100.0 * part.error * part.error / squares)
            } else {
                String::new()
            };
            text += &format!("{:<26}{numbers}{}\n", part.what, part.known);
        }
        text + &format!("{:<26}{:.1e} of a tolerance of {:.0e}\n", "together", self.total(), self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_as_squares_and_what_is_not_known_is_said() {
        let part = |what, error| BudgetPart { what, error, known: "so".to_owned() };
        let mut budget = ErrorBudget { parts: vec![part("a", 3e-3), part("b", 4e-3)], tolerance: 1e-2 };
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
