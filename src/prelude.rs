//! The items that most programs need from this library: `use diffract::prelude::*;`. Lengths are micrometres, angles degrees.
//!
//! | for | take |
//! | --- | --- |
//! | a surface | [`HeightField`] from a function or a file (with [`ReadSettings`] for what the file does not say), or [`synth::generate`] |
//! | the light | [`Coherence`], [`Illuminant`], and [`Pair`]s of [`direction`]s |
//! | the BRDF of a pixel | [`MeanReference`] of a [`MeanBrdf`], asked through [`Brdf`] |
//! | the BRDF of one coherence window | [`DirectSum`] of a [`Reference`], asked through [`Brdf`] |
//! | many colours fast | [`OrderSeries`], then [`bake`] a [`ColorTable`], then a [`TableReader`] |
#![cfg_attr(
    feature = "vulkan",
    doc = "| a picture | a [`Context`], a [`Scene`], [`setup::picture`], [`picture_file::save`] |"
)]

pub use crate::brdf::mean::MeanBrdf;
pub use crate::brdf::{Brdf, DirectSum, MeanReference};
pub use crate::context::Context;
pub use crate::error::{Error, Result};
pub use crate::filter::Covariance;
pub use crate::optics::coherence::{Beyond, Coherence, Windows};
pub use crate::optics::color::{display, xyz_to_linear_srgb};
pub use crate::optics::geometry::{Pair, direction};
pub use crate::optics::reference::Reference;
pub use crate::optics::spectrum::Illuminant;
pub use crate::scene::Scene;
pub use crate::spectra::power::{OrderSeries, PowerSettings};
pub use crate::surface::HeightField;
pub use crate::surface::files::ReadSettings;
pub use crate::surface::synth::{self, Spec, SurfaceKind};
pub use crate::table::{ColorTable, TableReader, TableSettings, bake};
pub use crate::task::Task;

#[cfg(feature = "vulkan")]
pub use crate::{
    picture_file,
    setup::{self, PictureSettings},
    vk::{device::Device, instance::Instance, selection::DeviceChoice},
};
