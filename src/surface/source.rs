//! Where a height field comes from, as it is named on the command line, in scene files and in the viewer.

use super::synth::{self, Kind, Spec};
use super::{HeightField, Level, image_file};
use crate::error::{Error, Result};
use std::path::Path;

/// A named height field and how to read it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// A built-in name or a file.
    pub name: String,
    /// Distance between samples \[µm\]; `None`: the built-in's own.
    pub pixel_size: Option<[f64; 2]>,
    /// Height of a file's largest code, full height of a built-in \[µm\]; `None`: the built-in's own.
    pub height: Option<f64>,
    /// What is subtracted.
    pub level: Level,
    /// Which one of the many skins of one kind.
    pub seed: u64,
}

impl Source {
    /// Reads or makes the height field.
    ///
    /// # Errors
    /// A name that is neither, a file that is no height image, a file without units.
    pub fn load(&self) -> Result<HeightField> {
        let (pixel_size, height) = (self.pixel_size, self.height);
        let field = match Kind::from_name(&self.name) {
            Some(kind) => synth::generate(&Spec { seed: self.seed, pixel_size, height, ..Spec::new(kind) })?,
            None => from_file(&self.name, pixel_size, height)?,
        };
        if self.level == Level::None { Ok(field) } else { field.levelled(self.level) }
    }
}

fn from_file(name: &str, pixel_size: Option<[f64; 2]>, height: Option<f64>) -> Result<HeightField> {
    let path = Path::new(name);
    let known = Kind::ALL.map(Kind::name).join(", ");
    if path.extension().is_none() && !path.exists() {
        return Err(Error::usage(
            format!("there is no surface `{name}`"),
            format!("give a PNG or TIFF file, or one of {known}"),
        ));
    }
    // What is not there needs no units.
    if let Err(e) = path.metadata() {
        return Err(Error::failed(format!("cannot open: {e}"), "check the path").at(name));
    }
    let missing = |option: &str, example: &str| {
        Error::usage(
            format!("the height image {name} carries no units"),
            format!("add {option}, as in {option} {example}"),
        )
    };
    let pixel_size = pixel_size.ok_or_else(|| missing("--pixel-size", "97.66nm"))?;
    let height = height.ok_or_else(|| missing("--height", "434.7nm"))?;
    image_file::read(path, pixel_size, height)
}
