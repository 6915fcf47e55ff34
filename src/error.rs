//! The one error type: the failure, its place and its remedy, in a line.

use std::borrow::Cow;
use std::fmt;
use std::io;

/// Cause of an error, the user or the program; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The request itself cannot be meant (exit code 2).
    Usage,
    /// The request was sound, the work failed (exit code 1).
    Failed,
    /// Whoever waited for the work cancelled it (exit code 1).
    Cancelled,
}

/// Remedy: a change with which the request succeeds. Each setting has a variant, because every program has different names for it, its
/// options or controls: see [`Error::in_words`]. `Display` names settings without any.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Anything but a setting: a whole phrase, as in `check the path`.
    Words(Cow<'static, str>),
    /// A larger accepted error.
    LargerTolerance,
    /// An accepted error that is larger by at least this factor.
    TimesTolerance(f64),
    /// The least accepted error with which the request succeeds.
    Tolerance(f64),
    /// A picture of fewer pixels.
    SmallerPicture,
    /// The mean over all coherence windows.
    AllWindows,
    /// One coherence window.
    OneWindow,
    /// Spectra of the wavelengths.
    SpectralMethod,
    /// A colour table.
    TableMethod,
    /// The f64 reference.
    ReferenceMethod,
    /// The theory of the thesis, which has no limit of energy.
    UnlimitedTheory,
    /// The optimal basis.
    OptimalBasis,
    /// Fewer terms of the expansion.
    FewerTerms,
    /// The number of terms that follows from the tolerance.
    AutomaticTerms,
    /// The wavelengths that follow from the tolerance.
    AutomaticWavelengths,
    /// A shorter coherence length.
    ShorterCoherence,
    /// A Gaussian coherence window.
    GaussianCoherence,
    /// A finite grating of fewer copies.
    FewerRepeats,
    /// A larger part of the surface.
    LargerPatch,
    /// A surface that goes on as copies of the patch.
    CopiesBeyond,
    /// A camera farther from the surface.
    FartherCamera,
    /// The distance between samples of the height field.
    PixelSize,
    /// A scene, with the named surface on it.
    SurfaceOnScene,
    /// The height of the largest grey code of the height field.
    FullHeight,
    /// Another channel of the scan.
    Channel,
    /// Subtracting a plane from the heights.
    LevelPlane,
    /// Edges that are blended into each other.
    BlendTile,
    /// More room for the cache.
    LargerCache,
    /// Another of the machine's Vulkan devices.
    OtherDevice,
    /// A Vulkan device in software.
    SoftwareDevice,
    /// A picture file instead of a window.
    PictureFile,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TimesTolerance(growth) => {
                return write!(f, "ask for a tolerance {growth:.1} times as large");
            }
            Self::Tolerance(tolerance) => return write!(f, "ask for a tolerance of {tolerance:e}"),
            Self::Words(words) => words,
            Self::LargerTolerance => "ask for a larger tolerance",
            Self::SmallerPicture => "ask for a smaller picture",
            Self::AllWindows => "take the mean over all windows",
            Self::OneWindow => "take one window",
            Self::UnlimitedTheory => "take Stam's theory, which has no limit of energy",
            Self::SpectralMethod => "take the spectral method",
            Self::TableMethod => "take a colour table",
            Self::ReferenceMethod => "take the f64 reference",
            Self::OptimalBasis => "take the optimal basis",
            Self::FewerTerms => "ask for fewer terms",
            Self::AutomaticTerms => "leave the number of terms to the tolerance",
            Self::AutomaticWavelengths => "leave the wavelengths to the tolerance",
            Self::ShorterCoherence => "ask for a shorter coherence length",
            Self::GaussianCoherence => "take a Gaussian coherence window",
            Self::FewerRepeats => "ask for fewer repeats of the patch",
            Self::LargerPatch => "take a larger part of the surface",
            Self::CopiesBeyond => "let it go on as copies of the patch",
            Self::FartherCamera => "look from farther away",
            Self::PixelSize => "give the distance between samples",
            Self::SurfaceOnScene => "name a scene, and this surface for it",
            Self::FullHeight => "give what the largest grey code means",
            Self::Channel => "name a channel",
            Self::LevelPlane => "level the surface by a plane",
            Self::BlendTile => "tile by blending",
            Self::LargerCache => "give the cache more room",
            Self::OtherDevice => "take another device",
            Self::SoftwareDevice => "take a software device",
            Self::PictureFile => "draw into a file",
        })
    }
}

/// Alternative remedies. Made from words, from one [`Remedy`] or from several.
#[derive(Clone, Debug, PartialEq)]
pub struct Remedies(Vec<Remedy>);

impl From<&'static str> for Remedies {
    fn from(words: &'static str) -> Self {
        Remedy::Words(words.into()).into()
    }
}

impl From<String> for Remedies {
    fn from(words: String) -> Self {
        Remedy::Words(words.into()).into()
    }
}

impl From<Remedy> for Remedies {
    fn from(remedy: Remedy) -> Self {
        Self(vec![remedy])
    }
}

impl<const N: usize> From<[Remedy; N]> for Remedies {
    fn from(remedies: [Remedy; N]) -> Self {
        Self(remedies.into())
    }
}

/// Error with a remedy. Displays as one line: `what; remedy`.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    kind: ErrorKind,
    what: String,
    remedies: Vec<Remedy>,
}

/// Result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Returns an error of wrong use: an option, a value or a combination that cannot be meant.
    pub fn usage(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self { kind: ErrorKind::Usage, what: what.into(), remedies: remedies.into().0 }
    }

    /// Returns an error of failed work: a file, a device or a computation that did not succeed.
    pub fn failed(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self { kind: ErrorKind::Failed, what: what.into(), remedies: remedies.into().0 }
    }

    /// Returns the error of work that was cancelled.
    pub fn cancelled() -> Self {
        Self {
            kind: ErrorKind::Cancelled,
            what: "cancelled".to_owned(),
            remedies: vec![Remedy::Words("start it again".into())],
        }
    }

    /// Returns true if the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.kind == ErrorKind::Cancelled
    }

    /// Returns the same error with `place` (a file, a line, an option) named in front.
    #[must_use]
    pub fn at(mut self, place: impl fmt::Display) -> Self {
        self.what = format!("{place}: {}", self.what);
        self
    }

    /// Returns the same error with a further remedy behind the others.
    #[must_use]
    pub fn or(mut self, remedy: impl Into<Remedies>) -> Self {
        self.remedies.append(&mut remedy.into().0);
        self
    }

    /// Returns the same error with the tolerance `least` in place of a larger one; without it if there is none.
    #[must_use]
    pub fn with_tolerance(mut self, least: Option<f64>) -> Self {
        let is_larger =
            |remedy: &Remedy| matches!(remedy, Remedy::LargerTolerance | Remedy::TimesTolerance(_));
        if let Some(least) = least {
            let replaced = |remedy| if is_larger(&remedy) { Remedy::Tolerance(least) } else { remedy };
            self.remedies = self.remedies.into_iter().map(replaced).collect();
        }
        self.remedies.retain(|remedy| !is_larger(remedy));
        self
    }

    /// Returns the cause of the error.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// Returns the remedies; any of them helps.
    pub fn remedies(&self) -> &[Remedy] {
        &self.remedies
    }

    /// Returns the exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            ErrorKind::Failed | ErrorKind::Cancelled => 1,
            ErrorKind::Usage => 2,
        }
    }

    /// Returns the error in one line, with its remedies in `words`.
    pub fn in_words<'a>(&'a self, words: impl Fn(&'a Remedy) -> Cow<'a, str>) -> String {
        let mut remedies: Vec<Cow<'a, str>> = self.remedies.iter().map(words).collect();
        let last = remedies.pop().unwrap_or_default();
        let remedy = match remedies.as_slice() {
            [] => last.into_owned(),
            others => format!("{}, or {last}", others.join(", ")),
        };
        format!("{}; {}", line(&self.what), line(&remedy))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(|remedy| remedy.to_string().into()))
    }
}

/// Returns the cause of a failed access to a file or another thing of the system, in words: people know no numbers of errors.
pub fn cause(error: &io::Error) -> String {
    let words = match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder",
        io::ErrorKind::PermissionDenied => "the system denies access",
        io::ErrorKind::IsADirectory => "it is a folder",
        io::ErrorKind::NotADirectory => "a part of the path is no folder",
        io::ErrorKind::StorageFull => "the disk is full",
        io::ErrorKind::QuotaExceeded => "the quota of the disk is used up",
        io::ErrorKind::ReadOnlyFilesystem => "the disk may only be read",
        io::ErrorKind::FileTooLarge => "the file would be larger than the system allows",
        io::ErrorKind::UnexpectedEof => "it ends too early",
        io::ErrorKind::InvalidData => "its content is damaged",
        io::ErrorKind::OutOfMemory => "there is too little memory",
        // The text of the system, without its number.
        _ => return error.to_string().split(" (os error").next().unwrap_or_default().to_lowercase(),
    };
    // An error without a number is not the system's and has a text that is more precise.
    if error.raw_os_error().is_some() || error.get_ref().is_none() {
        words.to_owned()
    } else {
        error.to_string()
    }
}

/// Returns `text` as one plain line of readable length: file names and library messages may hold line breaks, control characters, or a
/// megabyte of nines.
fn line(text: &str) -> String {
    /// Largest length \[characters\], above the words of any language and almost all paths.
    const LONGEST: usize = 400;
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty());
    let shown = words.map(|word| match word.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    });
    shown.collect::<Vec<_>>().join(" ")
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_words_without_numbers() {
        /// Numbers of ENOENT, EACCES, ENOSPC, EIO and EMFILE.
        const NUMBERS: [i32; 5] = [2, 13, 28, 5, 24];
        for number in NUMBERS {
            let words = cause(&io::Error::from_raw_os_error(number));
            assert!(!words.is_empty() && !words.contains("os error"), "{number}: {words}");
        }
        assert_eq!(cause(&io::Error::from_raw_os_error(2)), "there is no such file or folder");
        let precise = io::Error::new(io::ErrorKind::InvalidData, "the block 7 is damaged");
        assert_eq!(cause(&precise), "the block 7 is damaged");
    }

    #[test]
    fn an_error_is_one_line_that_names_place_and_remedy() {
        let e = Error::failed("cannot read\nit", "check the path").at("a\nb.png");
        assert_eq!(e.to_string(), "a b.png: cannot read it; check the path");
        assert_eq!(Error::usage("red\u{1b}[31m", "b").to_string(), "red [31m; b");
        assert!(Error::usage("9".repeat(1 << 20), "b").to_string().len() < 500);
        assert_eq!(e.exit_code(), 1);
        assert_eq!(Error::usage("a", "b").exit_code(), 2);
    }

    #[test]
    fn remedies_are_alternatives_in_the_words_of_who_shows_them() {
        let e = Error::failed("too large", [Remedy::SmallerPicture, Remedy::LargerTolerance]).or("wait");
        assert_eq!(
            e.to_string(),
            "too large; ask for a smaller picture, ask for a larger tolerance, or wait"
        );
        let shout = |remedy: &Remedy| remedy.to_string().to_uppercase().into();
        assert_eq!(Error::usage("a", Remedy::Channel).or("b").in_words(shout), "a; NAME A CHANNEL, or B");
        assert!(e.remedies().contains(&Remedy::SmallerPicture) && !e.remedies().contains(&Remedy::OneWindow));
    }
}
