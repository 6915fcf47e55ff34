//! Where a height field comes from, as it is named on the command line, in scene files and in the viewer.

use super::prepare::{self, Level, Step};
use super::synth::{self, Kind, Spec};
use super::{HeightField, image_file};
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
    /// What is done to the heights before use, in this order.
    pub prepare: Vec<Step>,
    /// Which one of the many skins of one kind.
    pub seed: u64,
}

impl Source {
    /// The built-in surface of `kind`, as it is by default.
    pub fn built_in(kind: Kind) -> Self {
        Self { name: kind.name().to_owned(), pixel_size: None, height: None, prepare: Vec::new(), seed: 1 }
    }

    /// The first levelling among the steps.
    pub fn level(&self) -> Level {
        let level = |step: &Step| if let Step::Level(level) = step { Some(*level) } else { None };
        self.prepare.iter().find_map(level).unwrap_or_default()
    }

    /// Makes `level` the first levelling among the steps, in the place of the one that is there or before all others.
    pub fn set_level(&mut self, level: Level) {
        let there = self.prepare.iter().position(|step| matches!(step, Step::Level(_)));
        match (there, level) {
            (Some(place), Level::None) => drop(self.prepare.remove(place)),
            (Some(place), level) => self.prepare[place] = Step::Level(level),
            (None, Level::None) => {}
            (None, level) => self.prepare.insert(0, Step::Level(level)),
        }
    }

    /// Reads or makes the height field, and prepares it.
    ///
    /// # Errors
    /// A name that is neither, a file that is no height image, a file without units, a step that cannot be done.
    pub fn load(&self) -> Result<HeightField> {
        let (pixel_size, height) = (self.pixel_size, self.height);
        let field = match Kind::from_name(&self.name) {
            Some(kind) => synth::generate(&Spec { seed: self.seed, pixel_size, height, ..Spec::new(kind) })?,
            None => from_file(&self.name, pixel_size, height)?,
        };
        prepare::apply_all(field, &self.prepare)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_takes_the_place_of_the_first_one_and_other_steps_stay() {
        let mut source = Source::built_in(Kind::Blaze);
        source.set_level(Level::Mean);
        source.prepare.push(Step::Invert);
        source.prepare.push(Step::Level(Level::Rows));
        source.set_level(Level::Plane);
        assert_eq!(prepare::describe(&source.prepare), "level plane, invert, level rows");
        assert_eq!(source.level(), Level::Plane);
        source.set_level(Level::None);
        source.set_level(Level::None);
        assert_eq!((source.level(), source.prepare.len()), (Level::None, 1));
    }

    #[test]
    fn a_source_prepares_what_it_loads() {
        let plain = Source::built_in(Kind::Blaze);
        let moulded = Source { prepare: vec![Step::Level(Level::Mean), Step::Invert], ..plain.clone() };
        let [plain, moulded] = [plain, moulded].map(|source| source.load().unwrap());
        let expected = plain.levelled(Level::Mean).unwrap();
        assert!(expected.heights().iter().zip(moulded.heights()).all(|(a, b)| *a == -*b));
    }
}
