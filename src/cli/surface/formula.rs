//! Gratings whose profile a user writes as a formula.

use crate::error::{Error, Result};
use crate::surface::HeightField;
use crate::surface::synth::{self, Spec};
use exmex::{BinOp, Express, FlatEx, FloatOpsFactory, MakeOperators, MatchLiteral, Operator};

/// Variable of a profile: the place in its period, from 0 to 1.
const VARIABLE: &str = "x";
/// Longest formula that is read \[letters\].
const LONGEST: usize = 1000;
/// Remedy for text that is no formula.
const FORM: &str =
    "write heights in micrometres over x, as in '0.1*sin(6.2832*x)' or '0.15 if x < 0.5 else 0'";

/// Formula of 64-bit floats.
type Formula = FlatEx<f64, ProfileOperators, DecimalNumber>;

/// Operators of a profile: those of floats, and below them comparisons, which are 1 or 0, `&&`, `||`, and `value if condition else other`.
#[derive(Clone, Debug)]
struct ProfileOperators;

/// Number with digits before or behind a point, and an exponent, as in `2.5e-2`.
#[derive(Clone, Debug)]
struct DecimalNumber;

impl MatchLiteral for DecimalNumber {
    fn is_literal(text: &str) -> Option<&str> {
        let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
        let whole = digits(0);
        let mut end = whole;
        if text[end..].starts_with('.') {
            end += 1 + digits(end + 1);
        }
        if end < whole + 2 && whole == 0 {
            return None; // no digit
        }
        if text[end..].starts_with(['e', 'E']) {
            let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
            let exponent = digits(end + 1 + sign);
            end += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        Some(&text[..end])
    }
}

/// Value of `value if condition` where the condition does not hold: a NaN by whose bits `else` knows it.
const NO_VALUE: u64 = 0x7ff8_0000_0000_0e15;

impl MakeOperators<f64> for ProfileOperators {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let binary = |name, prio, apply: fn(f64, f64) -> f64| {
            Operator::make_bin(name, BinOp { apply, prio, is_commutative: false })
        };
        let mut operators = FloatOpsFactory::<f64>::make(); // of priority 0 and more
        operators.extend([
            binary("<", -1, |a, b| truth_of(a < b)),
            binary(">", -1, |a, b| truth_of(a > b)),
            binary("<=", -1, |a, b| truth_of(a <= b)),
            binary(">=", -1, |a, b| truth_of(a >= b)),
            binary("&&", -2, |a, b| truth_of(a != 0.0 && b != 0.0)),
            binary("||", -3, |a, b| truth_of(a != 0.0 || b != 0.0)),
            binary("if", -4, |value, holds| if holds == 0.0 { f64::from_bits(NO_VALUE) } else { value }),
            binary("else", -5, |value, other| if value.to_bits() == NO_VALUE { other } else { value }),
        ]);
        operators
    }
}

/// Returns 1 for what holds, and else 0.
fn truth_of(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// Makes the grating of the profile `formula`, with the period, patch and sample spacing of `spec`.
///
/// # Errors
/// Fails for text that is no formula of x alone, and for heights that are not finite numbers.
pub fn grating(formula: &str, spec: &Spec) -> Result<HeightField> {
    let refused = |what: String| Error::usage(format!("the profile `{}` {what}", shortened(formula)), FORM);
    if formula.chars().count() > LONGEST {
        return Err(refused(format!("has more than {LONGEST} letters")));
    }
    let parsed = Formula::parse(formula).map_err(|e| refused(format!("is no formula ({e})")).caused_by(e))?;
    if let Some(other) = parsed.var_names().iter().find(|name| *name != VARIABLE) {
        return Err(refused(format!("is of {other}, not of x alone")));
    }
    let is_constant = parsed.var_names().is_empty();
    let height = |x: f64| {
        let place = [x];
        let value = parsed.eval(if is_constant { &[] } else { &place });
        value.unwrap_or(f64::NAN) // refused as a height
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
        let of_three = made("0.1 if x < 0.25 else 0.2 if x < 0.5 && x > 0 else 1/4").unwrap();
        let quarter = of_three.columns() / 8;
        let heights: Vec<f64> = of_three.row(0).iter().copied().step_by(quarter).take(4).collect();
        assert_eq!(heights, [0.1, 0.2, 0.25, 0.25], "and a quotient of whole numbers is no whole number");
        assert!(made("1").unwrap().heights().iter().all(|h| *h == 1.0));
    }

    #[test]
    fn numbers_may_have_exponents() {
        for (text, number) in [
            ("2e-2*x", "2e-2"),
            ("1.5E+3", "1.5E+3"),
            (".5e1", ".5e1"),
            ("3.", "3."),
            ("1else", "1"),
            ("2e", "2"),
            ("7)", "7"),
        ] {
            assert_eq!(DecimalNumber::is_literal(text), Some(number), "{text}");
        }
        assert!([".", "x", "-1", "e5", ""].iter().all(|text| DecimalNumber::is_literal(text).is_none()));
        assert_eq!(made("2e-2*x").unwrap().heights(), made("0.02*x").unwrap().heights());
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
            ("0.1 if x < 0.5", "not a number"),
            ("(-2147483647-1)%(-1)", "is no formula"),
        ] {
            let said = made(formula).unwrap_err().to_string();
            assert!(said.contains(part) && !said.contains('\n'), "{formula}: {said}");
        }
        assert!(made(&"x+".repeat(501)).unwrap_err().to_string().len() < 300);
    }
}
