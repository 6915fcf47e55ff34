//! Gratings whose profile a user writes as a formula.

use crate::error::{Error, Result};
use crate::surface::HeightField;
use crate::surface::synth::{self, Spec};
use exmex::{Express, Val};

/// Variable of a profile: the place in its period, from 0 to 1.
const VARIABLE: &str = "x";
/// Longest formula that is read \[letters\].
const LONGEST: usize = 1000;
/// Remedy for text that is no formula.
const FORM: &str =
    "write heights in micrometres over x, as in '0.1*sin(6.2832*x)' or '0.15 if x < 0.5 else 0'";

/// Makes the grating of the profile `formula`, with the period, patch and sample spacing of `spec`.
///
/// # Errors
/// Fails for text that is no formula of x alone, and for heights that are not finite numbers.
pub fn grating(formula: &str, spec: &Spec) -> Result<HeightField> {
    let refused = |what: String| Error::usage(format!("the profile `{}` {what}", shortened(formula)), FORM);
    if formula.chars().count() > LONGEST {
        return Err(refused(format!("has more than {LONGEST} letters")));
    }
    let parsed = exmex::parse_val::<i32, f64>(formula)
        .map_err(|e| refused(format!("is no formula ({e})")).caused_by(e))?;
    if let Some(other) = parsed.var_names().iter().find(|name| *name != VARIABLE) {
        return Err(refused(format!("is of {other}, not of x alone")));
    }
    let is_constant = parsed.var_names().is_empty();
    let height = |x: f64| {
        let place = [Val::Float(x)];
        let value = parsed.eval(if is_constant { &[] } else { &place });
        value.ok().and_then(|value| value.to_float().ok()).unwrap_or(f64::NAN) // refused as a height
    };
    synth::from_profile(spec, &height).map_err(|e| e.at(format!("the profile `{}`", shortened(formula))))
}

/// Returns the beginning of a long `formula`.
fn shortened(formula: &str) -> String {
    const SHOWN: usize = 40;
    match formula.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}...", &formula[..end]),
        None => formula.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::synth::SurfaceKind;

    fn made(formula: &str) -> Result<HeightField> {
        grating(formula, &Spec { period: Some(1.0), patch: Some([2.0, 0.5]), ..Spec::new(SurfaceKind::Flat) })
    }

    #[test]
    fn formulas_with_comparisons_and_functions_are_profiles() {
        let steps = made("0.15 if x < 0.5 else 0").unwrap();
        let half = steps.columns() / 4;
        assert_eq!(steps.patch_size(), [2.0, 0.5]);
        assert!(steps.row(0)[..half].iter().all(|h| *h == 0.15));
        assert!(steps.row(0)[half..2 * half].iter().all(|h| *h == 0.0));
        let wave = made("0.1*sin(2*PI*x)").unwrap();
        let expected = |x: f64| 0.1 * (std::f64::consts::TAU * x).sin();
        for (column, h) in wave.row(0).iter().enumerate() {
            let place = (column as f64 + 0.5) / wave.columns() as f64 * 2.0;
            assert!((h - expected(place)).abs() < 1e-12);
        }
        assert!(made("1").unwrap().heights().iter().all(|h| *h == 1.0));
    }

    #[test]
    fn what_is_no_formula_of_x_is_refused_in_a_line() {
        for (formula, part) in [
            ("", "is no formula"),
            ("0.1*(", "is no formula"),
            ("x + y", "is of y"),
            ("1/(x-x)", "not a number"),
            ("x<0.5?0.15:0", "`x<0.5?0.15:0`"),
            ("sqrt(-1)", "not a number"),
        ] {
            let said = made(formula).unwrap_err().to_string();
            assert!(said.contains(part) && !said.contains('\n'), "{formula}: {said}");
        }
        assert!(made(&"x+".repeat(501)).unwrap_err().to_string().len() < 300);
    }
}
