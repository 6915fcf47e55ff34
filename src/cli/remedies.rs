//! Remedies of errors, in options of the command line.

use crate::error::{Error, Remedy};
use std::borrow::Cow;

/// Returns the error in one line that names options.
pub fn in_options(error: &Error) -> String {
    error.in_words(option)
}

/// Returns the words to type for `remedy`.
fn option(remedy: &Remedy) -> Cow<'_, str> {
    Cow::Borrowed(match remedy {
        Remedy::Words(words) => words,
        Remedy::LargerTolerance => "ask for a larger --tolerance",
        Remedy::SmallerPicture => "ask for a smaller --size",
        Remedy::AllWindows => "use --windows all",
        Remedy::OneWindow => "use --windows 1x1 --method spectral",
        Remedy::SpectralMethod => "use --method spectral",
        Remedy::TableMethod => "use --method table",
        Remedy::UnlimitedTheory => "use --theory stam, which has no limit of energy",
        Remedy::ReferenceMethod => "use --method reference",
        Remedy::OptimalBasis => "use --basis optimal",
        Remedy::FewerTerms => "ask for fewer --terms",
        Remedy::AutomaticTerms => "leave --terms away",
        Remedy::AutomaticWavelengths => "leave --wavelengths away",
        Remedy::ShorterCoherence => "ask for a shorter --coherence",
        Remedy::GaussianCoherence => "use --coherence gaussian:LENGTH",
        Remedy::FewerRepeats => "ask for fewer --coherence repeats",
        Remedy::LargerPatch => "take a larger --crop",
        Remedy::CopiesBeyond => "use --beyond copies",
        Remedy::PixelSize => "give the distance between samples, as in --pixel-size 48.83nm",
        Remedy::SurfaceOnScene => "name a scene, and this surface by --surface, as in sphere --surface NAME",
        Remedy::FullHeight => "give what the largest grey code means, as in --height 434.7nm",
        Remedy::Channel => "name one with --channel",
        Remedy::LevelPlane => "use --level plane, which helps tilted scans",
        Remedy::BlendTile => "use --tile blend",
        Remedy::LargerCache => "give a larger --cache-size",
        Remedy::OtherDevice => "name a --device that `diffract devices` lists",
        Remedy::SoftwareDevice => "use --device cpu",
        Remedy::PictureFile => "draw into a file with `diffract render -o picture.png`",
        Remedy::TimesTolerance(growth) => {
            return format!("ask for a --tolerance {growth:.1} times as large").into();
        }
        Remedy::Tolerance(tolerance) => return format!("use --tolerance {tolerance:e}").into(),
        other => return Cow::Owned(other.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remedy_names_its_option() {
        let error = Error::limit("too large", [Remedy::LargerTolerance, Remedy::ReferenceMethod]);
        let line = "too large; ask for a larger --tolerance, or use --method reference";
        assert_eq!(in_options(&error), line);
        assert_eq!(
            in_options(&Error::usage("a", "b").or(Remedy::FartherCamera)),
            "a; b, or look from farther away"
        );
    }
}
