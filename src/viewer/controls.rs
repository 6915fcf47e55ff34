//! Remedies of errors in terms of the panel's controls.

use crate::error::{Error, Remedy};
use std::borrow::Cow;

/// Returns the error in one line that names controls.
pub fn in_controls(error: &Error) -> String {
    error.in_words(control)
}

/// Returns the change in the window for `remedy`.
fn control(remedy: &Remedy) -> Cow<'_, str> {
    Cow::Borrowed(match remedy {
        Remedy::Words(words) => words,
        Remedy::LargerTolerance => "choose a larger `tolerance`",
        Remedy::TimesTolerance(growth) => {
            return format!("choose a `tolerance` {growth:.1} times as large").into();
        }
        Remedy::Tolerance(tolerance) => return format!("set `tolerance` to {tolerance:e}").into(),
        Remedy::SmallerPicture => "make the window smaller",
        Remedy::AllWindows => "set `windows` to `mean`",
        Remedy::OneWindow => "set `windows` to `one`",
        Remedy::SpectralMethod => "set `windows` to `one`",
        Remedy::TableMethod => "set `windows` to `mean`",
        Remedy::OptimalBasis => "set `basis` to `optimal`",
        Remedy::FewerTerms => "set fewer `terms`",
        Remedy::AutomaticTerms => "set `terms` to `automatic`",
        Remedy::AutomaticWavelengths => "set `wavelengths` to `automatic`",
        Remedy::ShorterCoherence => "set a smaller `length` of the coherence",
        Remedy::GaussianCoherence => "set `coherence` to `gaussian`",
        Remedy::FewerRepeats => "set fewer `copies`",
        Remedy::PixelSize => "set `sample spacing`",
        Remedy::FullHeight => "set `full height`",
        Remedy::LevelPlane => "set `level` to `plane`",
        other => return Cow::Owned(other.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remedy_names_its_control() {
        let error = Error::limit("too large", [Remedy::LargerTolerance, Remedy::ReferenceMethod]);
        assert_eq!(in_controls(&error), "too large; choose a larger `tolerance`, or take the f64 reference");
    }
}
