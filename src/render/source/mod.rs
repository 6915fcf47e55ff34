//! What a pixel is shaded from.
//!
//! A source is one file here and one in `shaders/` (`source_NAME.glsl`): between them they have its bindings in descriptor set 1, its
//! specialisation constants, its cost and what it refuses. `shaders/shade.frag` and `shaders/eval.comp` are compiled once for each.
//! To add a source, add the two files and a row of [`Source`].

mod bound;
pub mod classical_grating;
pub mod cost;
pub mod grating;
pub mod part;
mod reflectance;
pub mod spectra;
pub mod table;
pub mod thesis;
pub mod window;

pub use bound::BoundSource;
pub use classical_grating::ClassicalGrating;
pub use grating::Grating;
pub use table::Table;
pub use thesis::Thesis;
pub use window::Window;

use super::directions::Directions;
use super::shading::Shading;
use crate::error::Result;
use crate::spectra::amplitude::Layers;
use crate::spectra::amplitude::expansion::Basis;
use crate::vk::device::Device;
use cost::Cost;
use std::sync::Arc;

/// What a pixel is shaded from: data on the host, cheap to clone.
#[derive(Clone)]
pub enum Source {
    /// Spectra through one Gaussian window, summed over wavelengths.
    Window(Window),
    /// Spectra of one period, repeated n × m times.
    Grating(Grating),
    /// Colours over (u, v, w), read.
    Table(Table),
    /// Baseline: the thesis' own sum.
    Thesis(Thesis),
    /// Baseline: the classical shader of a grating of one period.
    ClassicalGrating(ClassicalGrating),
}

/// The texture that holds a source's data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Array layers.
    pub layers: usize,
    /// Texels along its sides.
    pub size: [usize; 2],
    /// Bytes in all.
    pub bytes: u64,
}

/// A source in the words of reports.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSummary {
    /// `--method` of it.
    pub method: &'static str,
    /// The expansion, where there is one.
    pub basis: Option<Basis>,
    /// Terms of the expansion.
    pub terms: usize,
    /// Layers that one wavelength or one direction reads.
    pub layers: usize,
    /// How it is read between texels.
    pub kernel: String,
}

impl Source {
    /// Spectra through a window.
    pub fn window(layers: impl Into<Arc<Layers>>) -> Self {
        Self::Window(Window { layers: layers.into() })
    }

    /// Uploads the data and the tables that `shading` asks for, as set 1.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn bind(&self, device: &Arc<Device>, shading: &Shading) -> Result<BoundSource> {
        match self {
            Self::Window(source) => source.bind(device, shading),
            Self::Grating(source) => source.bind(device, shading),
            Self::Table(source) => source.bind(device, shading),
            Self::Thesis(source) => source.bind(device, shading),
            Self::ClassicalGrating(source) => source.bind(device, shading),
        }
    }

    /// Shades by `shading` from now on: `bound` holds the data of this source already, and only what is small is uploaded. The device must
    /// not be using it.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn rebind(&self, device: &Arc<Device>, bound: &mut BoundSource, shading: &Shading) -> Result<()> {
        match self {
            Self::Window(source) => source.set(device, bound, shading),
            Self::Grating(source) => source.set(device, bound, shading),
            Self::Table(source) => source.set(device, bound, shading),
            Self::Thesis(source) => source.set(device, bound, shading),
            Self::ClassicalGrating(source) => source.set(device, bound, shading),
        }
    }

    /// Whether both have the very same data, however they are shaded, so that [`Source::rebind`] goes from one to the other.
    pub fn shares_data_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Window(a), Self::Window(b)) => Arc::ptr_eq(&a.layers, &b.layers),
            (Self::Grating(a), Self::Grating(b)) => Arc::ptr_eq(&a.layers, &b.layers),
            (Self::Table(a), Self::Table(b)) => Arc::ptr_eq(&a.table, &b.table),
            _ => false,
        }
    }

    /// The texture that holds its data; nothing for a source without any.
    pub fn extent(&self) -> Extent {
        match self {
            Self::Window(Window { layers })
            | Self::Grating(Grating { layers, .. })
            | Self::Thesis(Thesis { layers, .. }) => spectra::extent(layers),
            Self::Table(source) => source.extent(),
            Self::ClassicalGrating(_) => Extent::default(),
        }
    }

    /// Terms of the expansion, where one is summed.
    pub fn terms(&self) -> Option<usize> {
        match self {
            Self::Window(Window { layers })
            | Self::Grating(Grating { layers, .. })
            | Self::Thesis(Thesis { layers, .. }) => Some(layers.terms),
            Self::Table(_) | Self::ClassicalGrating(_) => None,
        }
    }

    /// What reports say of it, drawn under `shading`.
    pub fn summary(&self, shading: &Shading) -> SourceSummary {
        match self {
            Self::Window(source) => source.summary(shading),
            Self::Grating(source) => source.summary(shading),
            Self::Table(source) => source.summary(),
            Self::Thesis(source) => source.summary(),
            Self::ClassicalGrating(source) => source.summary(),
        }
    }

    /// What a frame does that shades `directions` (one entry per light) under `shading`.
    pub fn cost(&self, shading: &Shading, directions: &[Directions]) -> Cost {
        match self {
            Self::Window(source) => source.cost(shading, directions),
            Self::Grating(source) => source.cost(shading, directions),
            Self::Table(source) => source.cost(directions),
            Self::Thesis(source) => source.cost(directions),
            Self::ClassicalGrating(_) => Cost::counted(directions, |_| (0, 0)),
        }
    }

    /// Whether some directions can be refused, so that [`Source::check`] needs those of a picture.
    pub fn has_limits(&self, shading: &Shading) -> bool {
        match self {
            Self::Grating(source) => source.has_limits(shading),
            _ => false,
        }
    }

    /// Fails where a picture of `directions` (one entry per light) takes more than the source can do.
    ///
    /// # Errors
    /// With the numbers and what to do.
    pub fn check(&self, shading: &Shading, directions: &[Directions]) -> Result<()> {
        match self {
            Self::Grating(source) => source.check(shading, directions),
            _ => Ok(()),
        }
    }
}

impl From<&Source> for Source {
    fn from(source: &Source) -> Self {
        source.clone()
    }
}

/// The three stages that are compiled for the source of this name.
macro_rules! stages {
    ($name:literal) => {
        $crate::render::source::bound::Stages {
            shade: $crate::render::shader!("shade.", $name, ".frag"),
            eval: $crate::render::shader!("eval.", $name, ".comp"),
            probe: $crate::render::shader!("probe.", $name, ".frag"),
        }
    };
}
use stages;
