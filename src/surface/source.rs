//! Source of a height field, as named on the command line, in scene files and in the viewer.

use super::HeightField;
use super::files::{self, ReadSettings, Topography};
use super::prepare::{self, Levelling, PreparationStep};
use super::synth::{self, Spec, SurfaceKind};
use crate::error::{Error, Result};
use crate::task::Task;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// A named height field and how to read it.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSource {
    /// A built-in name or a file.
    pub name: OsString,
    /// Distance between samples \[µm\]; `None`: that of the file or of the built-in surface.
    pub pixel_size: Option<[f64; 2]>,
    /// Height of an image's largest code, full height of a built-in surface or of any other file \[µm\]; `None`: no change.
    pub height: Option<f64>,
    /// Channel of a file that has several, by name or number; `None`: the height.
    pub channel: Option<String>,
    /// Preparation steps, in the order in which they are applied.
    pub prepare: Vec<PreparationStep>,
    /// Seed of a random built-in surface.
    pub seed: u64,
}

impl SurfaceSource {
    /// Returns the surface called `name`, a built-in one or a file, with default settings.
    pub fn named(name: &OsStr) -> Self {
        Self {
            name: name.to_owned(),
            pixel_size: None,
            height: None,
            channel: None,
            prepare: Vec::new(),
            seed: 1,
        }
    }

    /// Returns the built-in surface of `kind` with its default settings.
    pub fn built_in(kind: SurfaceKind) -> Self {
        Self::named(OsStr::new(kind.name()))
    }

    /// Returns the first levelling among the steps.
    pub fn level(&self) -> Levelling {
        let level = |step: &PreparationStep| {
            if let PreparationStep::Level(level) = step { Some(*level) } else { None }
        };
        self.prepare.iter().find_map(level).unwrap_or_default()
    }

    /// Replaces the first levelling among the steps by `level`, or inserts `level` before all steps.
    pub fn set_level(&mut self, level: Levelling) {
        let there = self.prepare.iter().position(|step| matches!(step, PreparationStep::Level(_)));
        match (there, level) {
            (Some(place), Levelling::None) => drop(self.prepare.remove(place)),
            (Some(place), level) => self.prepare[place] = PreparationStep::Level(level),
            (None, Levelling::None) => {}
            (None, level) => self.prepare.insert(0, PreparationStep::Level(level)),
        }
    }

    /// Reads or makes the height field, and prepares it.
    ///
    /// # Errors
    /// A name that is neither, a file that is no scan, a file without units, a step that cannot be done, a task that is cancelled.
    pub fn load(&self, task: &Task) -> Result<HeightField> {
        self.prepare(self.read(task)?.into_field()?, task)
    }

    /// Reads the file or makes the built-in surface; applies no step.
    ///
    /// # Errors
    /// See [`SurfaceSource::load`].
    pub fn read(&self, task: &Task) -> Result<Topography> {
        let (pixel_size, height) = (self.pixel_size, self.height);
        match self.kind() {
            Some(kind) => {
                let spec = Spec { seed: self.seed, pixel_size, height, ..Spec::new(kind) };
                synth::generate(&spec).map(Topography::of)
            }
            None => {
                let settings = ReadSettings { pixel_size, height, channel: self.channel.as_deref() };
                from_file(&self.name, &settings, task)
            }
        }
    }

    /// Returns the built-in surface that the name stands for; `None` for a file.
    pub fn kind(&self) -> Option<SurfaceKind> {
        self.name.to_str().and_then(SurfaceKind::from_name)
    }

    /// Returns `field` after the steps of [`SurfaceSource::prepare`].
    ///
    /// # Errors
    /// A step that cannot be done, a task that is cancelled.
    pub fn prepare(&self, field: HeightField, task: &Task) -> Result<HeightField> {
        prepare::apply_all(field, &self.prepare, task)
    }
}

fn from_file(name: &OsStr, settings: &ReadSettings, task: &Task) -> Result<Topography> {
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        let known = SurfaceKind::ALL.map(SurfaceKind::name).join(", ");
        return Err(Error::usage(
            format!("there is no surface `{}`", name.display()),
            format!("give {}, or one of {known}", files::known()),
        ));
    }
    files::read(path, settings, task)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_takes_the_place_of_the_first_one_and_other_steps_stay() {
        let mut source = SurfaceSource::built_in(SurfaceKind::Blaze);
        source.set_level(Levelling::Mean);
        source.prepare.push(PreparationStep::Invert);
        source.prepare.push(PreparationStep::Level(Levelling::Rows));
        source.set_level(Levelling::Plane);
        assert_eq!(prepare::describe(&source.prepare), "level plane, invert, level rows");
        assert_eq!(source.level(), Levelling::Plane);
        source.set_level(Levelling::None);
        source.set_level(Levelling::None);
        assert_eq!((source.level(), source.prepare.len()), (Levelling::None, 1));
    }

    #[test]
    fn a_source_prepares_what_it_loads() {
        let plain = SurfaceSource::built_in(SurfaceKind::Blaze);
        let moulded = SurfaceSource {
            prepare: vec![PreparationStep::Level(Levelling::Mean), PreparationStep::Invert],
            ..plain.clone()
        };
        let [plain, moulded] = [plain, moulded].map(|source| source.load(&Task::silent()).unwrap());
        let expected = plain.levelled(Levelling::Mean).unwrap();
        assert!(expected.heights().iter().zip(moulded.heights()).all(|(a, b)| *a == -*b));
    }
}
