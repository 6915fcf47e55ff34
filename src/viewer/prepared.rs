//! Surfaces and settings that are ready to be drawn.

use crate::render::shading::Shading;
use crate::render::source::Source;
use crate::surface::HeightField;
use std::sync::Arc;

/// What a setting is prepared for, the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The user's own picture.
    Own,
    /// The picture that it is compared with.
    Other,
    /// Moving pictures, with fewer wavelengths and terms.
    Coarse,
    /// Moving pictures, with fewer wavelengths.
    FewerWavelengths,
}

/// Number of roles.
pub const ROLES: usize = 4;

/// A surface and settings that are ready to be drawn.
pub struct Prepared {
    /// Number of the request; unique and increasing.
    pub number: u64,
    /// The height field.
    pub field: Arc<HeightField>,
    /// What it is shaded from.
    pub shaded_from: Source,
    /// The settings.
    pub shading: Shading,
}
