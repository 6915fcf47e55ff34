//! The surface pane: the height field that diffracts as a picture and as a relief, a profile, the distribution of heights, and the power
//! spectrum with what light of a wavelength can see of it. What is pointed at in one is marked in the others.

pub mod analysis;
pub mod directions;
pub mod plot;

use crate::surface::HeightField;
use analysis::Analysis;
use egui::TextureHandle;
use std::sync::Arc;

/// How heights are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShownPane {
    /// In false colour.
    #[default]
    Heights,
    /// As if lit from the upper left.
    Relief,
}

/// What the pointer is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pointed {
    /// A spatial frequency \[1/µm\].
    Frequency([f64; 2]),
    /// A place on the surface \[µm, from the middle, y up\].
    Place([f64; 2]),
}

/// The state of the pane.
#[derive(Default)]
pub struct SurfacePane {
    /// Whether it is shown.
    pub open: bool,
    /// The height field that was read last.
    pub field: Option<Arc<HeightField>>,
    /// What is shown of it, once it is computed.
    pub analysis: Option<Arc<Analysis>>,
    /// How heights are shown.
    pub shown: ShownPane,
    /// Ends of the line of the profile \[µm\]; across the middle unless one is drawn.
    pub line: Option<[[f64; 2]; 2]>,
    /// Wavelength of the light whose orders are shown \[µm\].
    pub wavelength: Option<f64>,
    /// What the pointer was on at the last pass.
    pub pointed: Option<Pointed>,
    /// Of the heights as they are shown, and of the power spectrum.
    pub pictures: Option<SurfacePictures>,
}

/// Textures, and what they show.
pub struct SurfacePictures {
    /// Of what.
    pub analysis: Arc<Analysis>,
    /// How heights are shown.
    pub shown: ShownPane,
    /// The heights.
    pub heights: TextureHandle,
    /// The power spectrum.
    pub power: TextureHandle,
}

impl SurfacePane {
    /// Middle of the visible spectrum, unless another wavelength is chosen \[µm\].
    const GREEN: f64 = 0.55;

    /// The height field that an analysis is missing of, while the pane is open.
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

    /// Takes what was computed of a height field, unless another one has come since.
    pub fn take(&mut self, analysis: Arc<Analysis>) {
        if self.field.as_ref().is_some_and(|field| Arc::ptr_eq(field, &analysis.field)) {
            self.analysis = Some(analysis);
        }
    }

    /// Wavelength of the light whose orders are shown \[µm\].
    pub fn wavelength(&self) -> f64 {
        self.wavelength.unwrap_or(Self::GREEN)
    }

    /// The frequency that the pointer is on \[1/µm\].
    pub fn pointed_frequency(&self) -> Option<[f64; 2]> {
        match self.pointed {
            Some(Pointed::Frequency(frequency)) if self.open => Some(frequency),
            _ => None,
        }
    }
}
