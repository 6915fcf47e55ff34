//! Surfaces and settings that are ready to be drawn.

use crate::error::Result;
use crate::optics::validity::ScalarTheory;
use crate::render::object::ObjectSources;
use crate::render::source::Source;
use crate::settings::Optics;
use crate::setup;
use crate::surface::HeightField;
use std::sync::{Arc, LazyLock};

/// Purpose of a prepared setting, most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// First colours of the main picture, until those of the requested settings are ready.
    Preview,
    /// Main picture, with the settings of the user.
    Own,
    /// Picture it is compared with.
    Other,
    /// Main picture, with the resolution of (u, v) that the present view needs.
    AsSeen,
}

/// Number of roles.
pub const ROLES: usize = 4;

impl Prepared {
    /// Returns a surface that does not diffract, for use before any other is ready.
    ///
    /// # Errors
    /// Fails only if there is a bug in this function.
    pub fn pigment_alone() -> Result<Self> {
        Ok(Self {
            number: 0,
            field: Arc::new(HeightField::new(1, 1, [1.0; 2], vec![0.0])?),
            objects: vec![ObjectSources::new(setup::pigment_alone(), Optics::default())],
            scalar_theory: None,
        })
    }
}

/// Surface and settings that are ready to be drawn.
pub struct Prepared {
    /// Number of the request; unique and increasing.
    pub number: u64,
    /// Height field.
    pub field: Arc<HeightField>,
    /// Sources of the objects as far as they are known, of the first one in any case.
    pub objects: Vec<ObjectSources>,
    /// Errors of scalar theory; `None` if the height field has not been measured.
    pub scalar_theory: Option<ScalarTheory>,
}

impl Prepared {
    /// Returns the source of the first object under the illuminant of the settings.
    pub fn source(&self) -> &Source {
        &self.objects[0].first.source
    }

    /// Returns the settings of the optics of the first object.
    pub fn optics(&self) -> &Optics {
        &self.objects[0].first.optics
    }

    /// Returns true if the first object's data on the device for `other` can be reused.
    pub fn shares_data_with(&self, other: &Self) -> bool {
        self.objects[0].shares_data_with(&other.objects[0])
    }

    /// Iterates over the sources of `count` objects; an object whose source is unknown shows its pigment alone.
    pub fn of_objects(&self, count: usize) -> impl Iterator<Item = &ObjectSources> {
        static UNKNOWN: LazyLock<ObjectSources> =
            LazyLock::new(|| ObjectSources::new(setup::pigment_alone(), Optics::default()));
        self.objects.iter().chain(std::iter::repeat(&*UNKNOWN)).take(count)
    }
}
