//! The one error type: the failure, its place and its remedy, in a line.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::sync::Arc;

/// Kind of an error: who or what has to change before the request succeeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The request cannot be meant: a wrong option, a wrong value or a combination of them.
    Usage,
    /// The content of a file or other data cannot be used: damaged, of another format, outside of what is allowed.
    Input,
    /// The request is sound and beyond a limit of the method: of its tolerance, its terms, its wavelengths, or the size of its result.
    Limit,
    /// Whoever waited for the work cancelled it.
    Cancelled,
    /// The system refuses access to a file, a folder or an output stream.
    Files,
    /// The machine or its Vulkan device has too little memory, or no thread left.
    Memory,
    /// The Vulkan device or the display is missing, unfit or lost.
    Device,
    /// The program contradicts itself.
    Bug,
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

/// Error of another library or of the system.
type Source = Arc<dyn std::error::Error + Send + Sync>;

/// Error with a remedy. Displays as one line: `what; remedy`, which tells the text of the source as well.
#[derive(Clone, Debug)]
pub struct Error {
    kind: ErrorKind,
    what: String,
    remedies: Vec<Remedy>,
    source: Option<Source>,
}

impl PartialEq for Error {
    /// Compares everything but the sources, which have no equality.
    fn eq(&self, other: &Self) -> bool {
        (self.kind, &self.what, &self.remedies) == (other.kind, &other.what, &other.remedies)
    }
}

/// Result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

#[doc(hidden)]
impl Error {
    fn new(kind: ErrorKind, what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self { kind, what: what.into(), remedies: remedies.into().0, source: None }
    }

    /// Returns an error of wrong use: an option, a value or a combination that cannot be meant.
    pub fn usage(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Usage, what, remedies)
    }

    /// Returns an error of a file or other data whose content cannot be used.
    pub fn input(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Input, what, remedies)
    }

    /// Returns an error of a sound request that is beyond a limit of the method.
    pub fn limit(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Limit, what, remedies)
    }

    /// Returns the error of work that was cancelled. It has no remedy.
    pub fn cancelled() -> Self {
        Self { kind: ErrorKind::Cancelled, what: "cancelled".to_owned(), remedies: Vec::new(), source: None }
    }

    /// Returns an error of a file, a folder or an output stream to which the system refuses access.
    pub fn files(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Files, what, remedies)
    }

    /// Returns an error of too little memory on the machine or its Vulkan device, or of a thread that the system refuses.
    pub fn memory(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Memory, what, remedies)
    }

    /// Returns an error of a Vulkan device or a display that is missing, unfit or lost.
    pub fn device(what: impl Into<String>, remedies: impl Into<Remedies>) -> Self {
        Self::new(ErrorKind::Device, what, remedies)
    }

    /// Returns an error of a program that contradicts itself.
    pub fn bug(what: impl Into<String>) -> Self {
        Self::new(ErrorKind::Bug, what, "report this as a bug of diffract")
    }

    /// Returns the same error with `source` as the error of another library or of the system that caused it.
    #[must_use]
    pub fn caused_by(mut self, source: impl std::error::Error + Send + Sync + 'static) -> Self {
        self.source = Some(Arc::new(source));
        self
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
}

impl Error {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }
}

#[doc(hidden)]
impl Error {
    /// Returns the remedies; any of them helps.
    pub fn remedies(&self) -> &[Remedy] {
        &self.remedies
    }
}

impl Error {
    /// Returns true if the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.kind == ErrorKind::Cancelled
    }
}

#[doc(hidden)]
impl Error {
    /// Returns true if the work takes more memory than there is, or is beyond a limit of its method: another method, or a smaller request, may succeed.
    pub fn is_too_large(&self) -> bool {
        matches!(self.kind, ErrorKind::Memory | ErrorKind::Limit)
    }

    /// Returns the error in one line, with its remedies in `words`.
    pub fn in_words<'a>(&'a self, words: impl Fn(&'a Remedy) -> Cow<'a, str>) -> String {
        let mut remedies: Vec<Cow<'a, str>> = self.remedies.iter().map(words).collect();
        let Some(last) = remedies.pop() else { return line(&self.what) };
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

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_deref().map(|source| source as _)
    }
}

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
        let e = Error::files("cannot read\nit", "check the path").at("a\nb.png");
        assert_eq!(e.to_string(), "a b.png: cannot read it; check the path");
        assert_eq!(Error::usage("red\u{1b}[31m", "b").to_string(), "red [31m; b");
        assert!(Error::usage("9".repeat(1 << 20), "b").to_string().len() < 500);
        assert_eq!(Error::cancelled().to_string(), "cancelled");
    }

    /// Returns the source of `error` as a `T`.
    fn source<T: std::error::Error + 'static>(error: &Error) -> Option<&T> {
        std::error::Error::source(error)?.downcast_ref()
    }

    #[test]
    fn each_kind_of_error_is_told_with_its_source() {
        let wrong = crate::units::length("10").unwrap_err();
        assert_eq!(wrong.kind(), ErrorKind::Usage, "{wrong}");
        let missing = crate::input::read_text(std::path::Path::new("no/such"), "a text").unwrap_err();
        assert_eq!(missing.kind(), ErrorKind::Files, "{missing}");
        assert_eq!(missing.to_string(), "no/such: there is no such file; give a text");
        assert_eq!(source::<io::Error>(&missing).unwrap().kind(), io::ErrorKind::NotFound);
        let damaged = crate::export::MaterialDescription::parse("{").unwrap_err();
        assert_eq!(damaged.kind(), ErrorKind::Input, "{damaged}");
        assert!(source::<serde_json::Error>(&damaged).unwrap().is_eof());
        #[cfg(target_os = "linux")] // others do not tell their memory
        {
            let large = crate::memory::ensure_room(u64::MAX, "the field").unwrap_err();
            assert!(large.kind() == ErrorKind::Memory && large.is_too_large(), "{large}");
        }
        let high = crate::spectra::amplitude::expansion::taylor::terms_for(100.0, 1e-6, 1e-7).unwrap_err();
        assert!(high.kind() == ErrorKind::Limit && high.is_too_large(), "{high}");
        let task = crate::task::Task::silent();
        task.cancel();
        let cancelled = task.check().unwrap_err();
        assert!(cancelled.kind() == ErrorKind::Cancelled && cancelled.is_cancelled(), "{cancelled}");
        assert!(cancelled.remedies().is_empty() && !cancelled.is_too_large());
        let bug = Error::bug("nothing is left").caused_by(fmt::Error);
        assert_eq!(bug.kind(), ErrorKind::Bug);
        assert_eq!(bug.to_string(), "nothing is left; report this as a bug of diffract");
        assert!(source::<fmt::Error>(&bug.at("here")).is_some());
        assert!(std::error::Error::source(&wrong).is_none());
    }

    #[test]
    fn remedies_are_alternatives_in_the_words_of_who_shows_them() {
        let e = Error::limit("too large", [Remedy::SmallerPicture, Remedy::LargerTolerance]).or("wait");
        assert_eq!(
            e.to_string(),
            "too large; ask for a smaller picture, ask for a larger tolerance, or wait"
        );
        let shout = |remedy: &Remedy| remedy.to_string().to_uppercase().into();
        assert_eq!(Error::usage("a", Remedy::Channel).or("b").in_words(shout), "a; NAME A CHANNEL, or B");
        assert!(e.remedies().contains(&Remedy::SmallerPicture) && !e.remedies().contains(&Remedy::OneWindow));
    }
}
