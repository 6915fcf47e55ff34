//! Surface pane: the height field as a picture and as a relief, a profile, the distribution of heights, and the power
//! spectrum with the frequencies visible at a wavelength. The point under the pointer in one plot is marked in the
//! others.

pub mod analysis;
pub mod directions;
pub mod plot;

use crate::surface::HeightField;
use analysis::Analysis;
use egui::TextureHandle;
use std::sync::Arc;

/// Rendering of heights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShownPane {
    /// False colours.
    #[default]
    Heights,
    /// Relief lit from the upper left.
    Relief,
}

/// Point under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pointed {
    /// Spatial frequency \[1/µm\].
    Frequency([f64; 2]),
    /// Position on the surface \[µm, from the centre, y up\].
    Place([f64; 2]),
}

/// State of the pane.
#[derive(Default)]
pub struct SurfacePane {
    /// True while it is shown.
    pub open: bool,
    /// Height field that was read last.
    pub field: Option<Arc<HeightField>>,
    /// Analysis of the height field, once it is computed.
    pub analysis: Option<Arc<Analysis>>,
    /// Rendering of heights.
    pub shown: ShownPane,
    /// Ends of the profile line \[µm\]; by default it crosses the centre.
    pub line: Option<[[f64; 2]; 2]>,
    /// Wavelength of the light whose orders are shown \[µm\].
    pub wavelength: Option<f64>,
    /// Point under the pointer at the last pass.
    pub pointed: Option<Pointed>,
    /// Textures of the heights and of the power spectrum.
    pub pictures: Option<SurfacePictures>,
}

/// Textures, and the data they show.
pub struct SurfacePictures {
    /// Analysis.
    pub analysis: Arc<Analysis>,
    /// Rendering of heights.
    pub shown: ShownPane,
    /// Heights.
    pub heights: TextureHandle,
    /// Power spectrum.
    pub power: TextureHandle,
}

impl SurfacePane {
    /// Default wavelength, the middle of the visible spectrum \[µm\].
    const GREEN: f64 = 0.55;

    /// Returns the height field whose analysis is missing, while the pane is open.
    pub fn missing(&self) -> Option<&Arc<HeightField>> {
        let field = self.field.as_ref().filter(|_| self.open)?;
        let is_there = self.analysis.as_ref().is_some_and(|analysis| Arc::ptr_eq(&analysis.field, field));
        (!is_there).then_some(field)
    }

    /// Takes another height field.
    pub fn take_field(&mut self, field: Arc<HeightField>) {
        if !self.field.as_ref().is_some_and(|known| Arc::ptr_eq(known, &field)) {
            (self.field, self.line, self.pointed) = (Some(field), None, None);
        }
    }

    /// Takes the analysis of a height field, unless another one was read since.
    pub fn take(&mut self, analysis: Arc<Analysis>) {
        if self.field.as_ref().is_some_and(|field| Arc::ptr_eq(field, &analysis.field)) {
            self.analysis = Some(analysis);
        }
    }

    /// Returns the wavelength of the light whose orders are shown \[µm\].
    pub fn wavelength(&self) -> f64 {
        self.wavelength.unwrap_or(Self::GREEN)
    }

    /// Returns the frequency under the pointer \[1/µm\].
    pub fn pointed_frequency(&self) -> Option<[f64; 2]> {
        match self.pointed {
            Some(Pointed::Frequency(frequency)) if self.open => Some(frequency),
            _ => None,
        }
    }
}
