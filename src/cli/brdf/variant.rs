//! The two variants of `--compare`.

use crate::cli::options::{self, OpticsOptions};
use crate::error::{Error, Result};
use crate::settings::Method;
use crate::spectra::amplitude::expansion::Basis;
use clap::ValueEnum;

/// Optics options of a variant that differ from the other options.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Name, as given by the user.
    pub name: String,
    words: Vec<String>,
}

impl Variant {
    /// Parses two variants `A,B`.
    pub fn pair(text: &str) -> Result<[Self; 2]> {
        match text.split(',').collect::<Vec<_>>()[..] {
            [a, b] => Ok([Self::parse(a)?, Self::parse(b)?]),
            _ => Err(Error::usage(
                format!("`{text}` are not two things to compare"),
                "give A,B, as in spectral,reference",
            )),
        }
    }

    /// Parses words joined by `+`: methods, bases, coherences.
    fn parse(text: &str) -> Result<Self> {
        let words: Vec<String> = text.split('+').map(|word| word.trim().to_owned()).collect();
        let known = |word: &String| method(word).is_some() || basis(word).is_some() || word.contains(':');
        if let Some(word) = words.iter().find(|word| !known(word)) {
            return Err(Error::usage(
                format!("`{word}` is nothing to compare"),
                "give methods, bases or coherences, joined by + where both are meant, as in spectral+repeats:26x1",
            ));
        }
        for word in words.iter().filter(|word| word.contains(':')) {
            options::coherence(word)?;
        }
        Ok(Self { name: text.trim().to_owned(), words })
    }

    /// Returns `options` changed by this variant.
    pub fn of(&self, options: &OpticsOptions) -> Result<OpticsOptions> {
        let mut varied = options.clone();
        for word in &self.words {
            match (method(word), basis(word)) {
                (Some(method), _) => varied.method = Some(method),
                (_, Some(basis)) => varied.basis = Some(basis),
                _ => varied.coherence = options::coherence(word)?,
            }
        }
        Ok(varied)
    }
}

fn method(word: &str) -> Option<Method> {
    Method::from_str(word, false).ok()
}

fn basis(word: &str) -> Option<Basis> {
    Basis::ALL.into_iter().find(|basis| basis.name() == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_variants_are_words_of_the_optics() {
        let [a, b] = Variant::pair("spectral+repeats:3x2, reference").unwrap();
        assert_eq!((a.name.as_str(), b.name.as_str()), ("spectral+repeats:3x2", "reference"));
        for bad in [
            "",
            "spectral",
            "a,b",
            "spectral,",
            "taylor,laser:3um",
            "taylor,reference,optimal",
            "spectral,repeats:0x1",
        ] {
            assert!(Variant::pair(bad).is_err(), "{bad}");
        }
    }
}
