//! `diffract`: light diffracted by a height field, as numbers and as pictures.
//!
//! Lengths are micrometres, angles degrees, directions unit vectors away from the surface in its tangent frame: x along the rows of the height field, y up in its
//! picture, z out of the surface. The programs in `examples/` use nothing but what is here.
//!
//! | for | take |
//! | --- | --- |
//! | a surface | [`HeightField`]: from numbers, a function or a file (with [`ReadSettings`] for what it does not say), or generated from a [`Spec`] |
//! | light and material | [`Optics`] |
//! | the BRDF | [`SurfaceBrdf`], asked for pairs of [`direction`]s; [`GratingOrder`]s of a grating |
//! | many colours fast | [`SurfaceColours`], which other programs read, too |
//! | work that takes long | a [`Task`], which reports and is cancelled; a [`Context`] with cache, threads and device |
#![cfg_attr(
    feature = "vulkan",
    doc = "| a picture | a [`Scene`] and [`PictureSettings`], given to [`draw`] |"
)]
//!
//! The feature `vulkan` (on by default) has the renderer, `viewer` (on by default) the window; without them the library has everything but pictures and the
//! program.
//!
//! Inside, data flows one way: `surface` → `spectra` → `table` → `render` (with `scene` and `vk`) → picture, and `optics::reference` checks the
//! result. `docs/ARCHITECTURE.md` lists the imports allowed to each module.

#![deny(unsafe_code)]

/// Everything that the front is made of, for the tests and the tools of this project. It may change in any version.
#[doc(hidden)]
#[path = ""]
pub mod internals {
    pub mod brdf;
    pub mod budget;
    pub mod cache;
    #[cfg(feature = "vulkan")]
    pub mod cli;
    pub mod context;
    pub mod error;
    pub mod export;
    pub mod fft_size;
    pub mod figure;
    pub mod files;
    pub mod filter;
    pub mod front;
    pub mod input;
    pub mod measure;
    pub mod memory;
    pub mod notes;
    pub mod optics;
    pub mod output;
    #[cfg(feature = "vulkan")]
    pub mod picture_file;
    pub mod random;
    #[cfg(feature = "vulkan")]
    pub mod render;
    pub mod scene;
    pub mod settings;
    #[cfg(feature = "vulkan")]
    pub mod setup;
    pub mod spectra;
    pub mod sums;
    pub mod surface;
    pub mod table;
    pub mod task;
    pub mod tolerance;
    pub mod units;
    #[cfg(feature = "viewer")]
    pub mod viewer;
    #[allow(unsafe_code, reason = "calls Vulkan; every block says why it is sound")]
    #[cfg(feature = "vulkan")]
    pub mod vk;
}

pub(crate) use internals::*;

#[doc(inline)]
pub use internals::context::Context;
#[doc(inline)]
pub use internals::error::{Error, ErrorKind, Result};
#[doc(inline)]
pub use internals::front::{
    AngularPeak, GratingOrder, MeasuredPeriod, PeakSettings, SurfaceBrdf, SurfaceColours, SurfaceMeasures,
    SurfacePeaks, check_export, direction, display_srgb, linear_srgb,
};
#[doc(inline)]
pub use internals::optics::coherence::Beyond;
#[doc(inline)]
pub use internals::optics::polarisation::Polarisation;
#[doc(inline)]
pub use internals::optics::theory::Theory;
#[doc(inline)]
pub use internals::scene::{Light, Mesh, Object, Scene};
#[doc(inline)]
pub use internals::settings::Optics;
#[doc(inline)]
pub use internals::surface::HeightField;
#[doc(inline)]
pub use internals::surface::files::ReadSettings;
#[doc(inline)]
pub use internals::surface::synth::{Spec, SurfaceKind};
#[doc(inline)]
pub use internals::task::{Progress, Task};

#[cfg(feature = "vulkan")]
#[doc(inline)]
pub use internals::{
    front::{PictureDifference, draw},
    render::renderer::Picture,
    setup::PictureSettings,
};

/// The command line, as a function: what the program `diffract` does.
#[cfg(feature = "vulkan")]
pub mod program {
    #[doc(inline)]
    pub use crate::internals::cli::{Streams, main, run};
}
