//! Surfaces and settings that are ready to be drawn.

use crate::precompute::Layers;
use crate::render::color_table::{ColorTable, Filter};
use crate::render::repeating::Repeating;
use crate::render::resources::Optics;
use crate::render::shading::Shading;
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
    pub made: Made,
    /// The settings.
    pub shading: Shading,
}

/// Size of a texture array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureSize {
    /// Array layers.
    pub layers: usize,
    /// Texels along x and y.
    pub size: [usize; 2],
    /// Bytes on the device.
    pub bytes: u64,
}

/// What a surface is shaded from.
#[derive(Clone)]
pub enum Made {
    /// Layers.
    Layers(Arc<Layers>),
    /// Layers of one period, and how it repeats.
    Repeats(Arc<Layers>, Arc<Repeating>),
    /// A colour table, and how it is read.
    Table(Arc<ColorTable>, Filter),
}

impl Made {
    /// The size of the texture.
    pub fn texture(&self) -> TextureSize {
        match self {
            Self::Layers(layers) | Self::Repeats(layers, _) => {
                // Where there are lines, they hold nearly all of it.
                let size = layers.lines.as_ref().map_or(layers.size, |lines| lines.size);
                TextureSize { layers: layers.count(), size, bytes: layers.bytes() as u64 }
            }
            Self::Table(table, _) => TextureSize {
                layers: table.grid.layers(),
                size: [table.grid.side; 2],
                bytes: table.grid.bytes(),
            },
        }
    }

    /// Whether both read the same texture in the same way.
    pub fn shares_all_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Layers(a), Self::Layers(b)) | (Self::Repeats(a, _), Self::Repeats(b, _)) => {
                Arc::ptr_eq(a, b)
            }
            (Self::Table(a, filter), Self::Table(b, other)) => Arc::ptr_eq(a, b) && filter == other,
            _ => false,
        }
    }

    /// Terms of the expansion; `None` for a colour table.
    pub fn terms(&self) -> Option<usize> {
        match self {
            Self::Layers(layers) | Self::Repeats(layers, _) => Some(layers.terms),
            Self::Table(..) => None,
        }
    }
}

impl<'a> From<&'a Made> for Optics<'a> {
    fn from(made: &'a Made) -> Self {
        match made {
            Made::Layers(layers) => Self::Layers(layers),
            Made::Repeats(layers, repeating) => Self::Repeats(layers, repeating.repeats),
            Made::Table(table, filter) => Self::Table(table, *filter),
        }
    }
}
