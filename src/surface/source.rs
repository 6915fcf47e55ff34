//! Where a height field comes from, as it is named on the command line, in scene files and in the viewer.

use super::files::{self, Topography, Wish};
use super::synth::{self, Kind, Spec};
use super::{HeightField, Level};
use crate::error::{Error, Result};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// A named height field and how to read it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// A built-in name or a file.
    pub name: OsString,
    /// Distance between samples \[µm\]; `None`: the file's or the built-in's own.
    pub pixel_size: Option<[f64; 2]>,
    /// Height of an image's largest code, full height of a built-in or of any other file \[µm\]; `None`: its own.
    pub height: Option<f64>,
    /// The channel of a file that has several, by name or number; `None`: the height.
    pub channel: Option<String>,
    /// What is subtracted.
    pub level: Level,
    /// Which one of the many skins of one kind.
    pub seed: u64,
}

impl Source {
    /// Reads or makes the height field.
    ///
    /// # Errors
    /// A name that is neither, a file that is no scan, a file without units.
    pub fn load(&self) -> Result<HeightField> {
        self.prepare(self.read()?.into_field()?)
    }

    /// The heights as they are in the file, or as they are made; nothing is subtracted.
    ///
    /// # Errors
    /// As [`Source::load`].
    pub fn read(&self) -> Result<Topography> {
        let (pixel_size, height) = (self.pixel_size, self.height);
        match self.kind() {
            Some(kind) => {
                let spec = Spec { seed: self.seed, pixel_size, height, ..Spec::new(kind) };
                synth::generate(&spec).map(Topography::of)
            }
            None => from_file(&self.name, &Wish { pixel_size, height, channel: self.channel.as_deref() }),
        }
    }

    /// The built-in surface that the name stands for; `None` for a file.
    pub fn kind(&self) -> Option<Kind> {
        self.name.to_str().and_then(Kind::from_name)
    }

    /// `field` less what is to be subtracted.
    ///
    /// # Errors
    /// A field from which that cannot be taken.
    pub fn prepare(&self, field: HeightField) -> Result<HeightField> {
        if self.level == Level::None { Ok(field) } else { field.levelled(self.level) }
    }
}

fn from_file(name: &OsStr, wish: &Wish) -> Result<Topography> {
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        let known = Kind::ALL.map(Kind::name).join(", ");
        return Err(Error::usage(
            format!("there is no surface `{}`", name.display()),
            format!("give {}, or one of {known}", files::KNOWN),
        ));
    }
    files::read(path, wish)
}
