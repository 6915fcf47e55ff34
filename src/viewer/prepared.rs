//! Surfaces and settings that are ready to be drawn.

use crate::error::Result;
use crate::optics::validity::ScalarTheory;
use crate::render::object::ObjectSources;
use crate::render::shading::Shading;
use crate::render::source::Source;
use crate::setup;
use crate::surface::HeightField;
use std::sync::{Arc, LazyLock};

/// What a setting is prepared for, the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The first colours of the user's own picture, until those are there that the settings ask for.
    Preview,
    /// The user's own picture.
    Own,
    /// The picture that it is compared with.
    Other,
    /// The user's own picture, as fine as camera and lights ask for now.
    AsSeen,
    /// Moving pictures, with fewer wavelengths and terms.
    Coarse,
    /// Moving pictures, with fewer wavelengths.
    FewerWavelengths,
}

/// Number of roles.
pub const ROLES: usize = 6;

impl Prepared {
    /// A surface that diffracts nothing, before there is any other.
    ///
    /// # Errors
    /// None that is known of.
    pub fn pigment_alone() -> Result<Self> {
        Ok(Self {
            number: 0,
            field: Arc::new(HeightField::new(1, 1, [1.0; 2], vec![0.0])?),
            sources: ObjectSources::new(setup::pigment_alone(), Shading::default()),
            others: Vec::new(),
            scalar_theory: None,
        })
    }
}

/// A surface and settings that are ready to be drawn.
pub struct Prepared {
    /// Number of the request; unique and increasing.
    pub number: u64,
    /// The height field.
    pub field: Arc<HeightField>,
    /// What it is shaded from.
    pub sources: ObjectSources,
    /// What the objects beside the first are shaded from, as far as it is known.
    pub others: Vec<ObjectSources>,
    /// Errors of scalar theory; `None` if the height field has not been measured.
    pub scalar_theory: Option<ScalarTheory>,
}

impl Prepared {
    /// What the first object is shaded from under the illuminant of the settings.
    pub fn source(&self) -> &Source {
        &self.sources.own.source
    }

    /// The settings.
    pub fn shading(&self) -> &Shading {
        &self.sources.own.shading
    }

    /// What the objects of a scene of so many are shaded from. Where it is not known yet, the pigment is seen.
    pub fn of_objects(&self, objects: usize) -> impl Iterator<Item = &ObjectSources> {
        static UNKNOWN: LazyLock<ObjectSources> =
            LazyLock::new(|| ObjectSources::new(setup::pigment_alone(), Shading::default()));
        let others = self.others.iter().chain(std::iter::repeat(&*UNKNOWN));
        std::iter::once(&self.sources).chain(others).take(objects)
    }
}
