//! Data sources that pixels are shaded from.
//!
//! A source is one file here and one in `shaders/` (`source_NAME.glsl`). Together they define its bindings in
//! descriptor set 1, its specialisation constants, its cost and its limits. `shaders/shade.frag` and
//! `shaders/eval.comp` are compiled once for each source. To add a source, add the two files and a variant of
//! [`Source`].

mod bound;
pub mod classical_grating;
pub mod cost;
pub mod grating;
pub mod part;
pub mod spectra;
mod surface_factor;
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
use crate::brdf::energy_map::EnergyMap;
use crate::error::Result;
use crate::settings::Optics;
use crate::spectra::amplitude::Layers;
use crate::spectra::amplitude::expansion::Basis;
use crate::vk::device::Device;
use cost::Cost;
use std::sync::Arc;

/// Data that a pixel is shaded from, on the host; cheap to clone.
#[derive(Clone)]
pub enum Source {
    /// Spectra through one Gaussian window, summed over wavelengths.
    Window(Window),
    /// Spectra of one period, repeated n × m times.
    Grating(Grating),
    /// Colour table over (u, v, w).
    Table(Table),
    /// Baseline: the sum of the thesis.
    Thesis(Thesis),
    /// Baseline: the classical shader of a grating of one period.
    ClassicalGrating(ClassicalGrating),
}

/// Size of the texture with a source's data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Array layers.
    pub layers: usize,
    /// Texels along its sides.
    pub size: [usize; 2],
    /// Total bytes.
    pub bytes: u64,
}

/// Description of a source for reports.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSummary {
    /// Its value of `--method`.
    pub method: &'static str,
    /// Expansion, if there is one.
    pub basis: Option<Basis>,
    /// Terms of the expansion.
    pub terms: usize,
    /// Layers read per wavelength or direction.
    pub layers: usize,
    /// Interpolation between texels.
    pub kernel: String,
}

impl Source {
    /// Returns the source of spectra through a window.
    pub fn window(layers: impl Into<Arc<Layers>>) -> Self {
        Self::Window(Window { layers: layers.into(), energy: None })
    }

    /// Uploads the data and the tables for `optics` as set 1.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn bind(&self, device: &Arc<Device>, optics: &Optics) -> Result<BoundSource> {
        match self {
            Self::Window(source) => source.bind(device, optics),
            Self::Grating(source) => source.bind(device, optics),
            Self::Table(source) => source.bind(device, optics),
            Self::Thesis(source) => source.bind(device, optics),
            Self::ClassicalGrating(source) => source.bind(device, optics),
        }
    }

    /// Changes the shading to `optics`. `bound` holds the data of this source already, so only small tables are
    /// uploaded. The device must not be using it.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn rebind(&self, device: &Arc<Device>, bound: &mut BoundSource, optics: &Optics) -> Result<()> {
        match self {
            Self::Window(source) => source.set(device, bound, optics),
            Self::Grating(source) => source.set(device, bound, optics),
            Self::Table(source) => source.set(device, bound, optics),
            Self::Thesis(source) => source.set(device, bound, optics),
            Self::ClassicalGrating(source) => source.set(device, bound, optics),
        }
    }

    /// Returns this source within a limit of energy, which baselines do not have.
    pub fn limited(self, energy: Option<Arc<EnergyMap>>) -> Self {
        match self {
            Self::Window(source) => Self::Window(Window { energy, ..source }),
            Self::Grating(source) => Self::Grating(Grating { energy, ..source }),
            Self::Table(source) => Self::Table(Table { energy, ..source }),
            baseline => baseline,
        }
    }

    /// Returns the limit of energy, if the source has one.
    pub fn energy(&self) -> Option<&Arc<EnergyMap>> {
        match self {
            Self::Window(Window { energy, .. })
            | Self::Grating(Grating { energy, .. })
            | Self::Table(Table { energy, .. }) => energy.as_ref(),
            Self::Thesis(_) | Self::ClassicalGrating(_) => None,
        }
    }

    /// Returns true if both have the identical data, whatever the shading, so that [`Source::rebind`] can switch from
    /// one to the other.
    pub fn shares_data_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Window(a), Self::Window(b)) => Arc::ptr_eq(&a.layers, &b.layers),
            (Self::Grating(a), Self::Grating(b)) => Arc::ptr_eq(&a.layers, &b.layers),
            (Self::Table(a), Self::Table(b)) => Arc::ptr_eq(&a.table, &b.table),
            _ => false,
        }
    }

    /// Returns the size of the texture with its data; zero for a source without data.
    pub fn extent(&self) -> Extent {
        match self {
            Self::Window(Window { layers, .. })
            | Self::Grating(Grating { layers, .. })
            | Self::Thesis(Thesis { layers, .. }) => spectra::extent(layers),
            Self::Table(source) => source.extent(),
            Self::ClassicalGrating(_) => Extent::default(),
        }
    }

    /// Returns the terms of the expansion, if one is summed.
    pub fn terms(&self) -> Option<usize> {
        match self {
            Self::Window(Window { layers, .. })
            | Self::Grating(Grating { layers, .. })
            | Self::Thesis(Thesis { layers, .. }) => Some(layers.terms),
            Self::Table(_) | Self::ClassicalGrating(_) => None,
        }
    }

    /// Returns the description for reports under `optics`.
    pub fn summary(&self, optics: &Optics) -> SourceSummary {
        match self {
            Self::Window(source) => source.summary(optics),
            Self::Grating(source) => source.summary(optics),
            Self::Table(source) => source.summary(),
            Self::Thesis(source) => source.summary(),
            Self::ClassicalGrating(source) => source.summary(),
        }
    }

    /// Returns the work of a frame that shades `directions` (one entry per light) under `optics`.
    pub fn cost(&self, optics: &Optics, directions: &[Directions]) -> Cost {
        match self {
            Self::Window(source) => source.cost(optics, directions),
            Self::Grating(source) => source.cost(optics, directions),
            Self::Table(source) => source.cost(directions),
            Self::Thesis(source) => source.cost(directions),
            Self::ClassicalGrating(_) => Cost::counted(directions, |_| (0, 0)),
        }
    }

    /// Returns true if some directions exceed the limits of the source, so that a picture needs [`Source::check`].
    pub fn has_limits(&self, optics: &Optics) -> bool {
        match self {
            Self::Grating(source) => source.has_limits(optics),
            _ => false,
        }
    }

    /// Checks that a picture of `directions` (one entry per light) is within the limits of the source.
    ///
    /// # Errors
    /// Fails with the numbers and a remedy.
    pub fn check(&self, optics: &Optics, directions: &[Directions]) -> Result<()> {
        match self {
            Self::Grating(source) => source.check(optics, directions),
            _ => Ok(()),
        }
    }
}

impl From<&Source> for Source {
    fn from(source: &Source) -> Self {
        source.clone()
    }
}

/// Returns the three stages compiled for the source of this name.
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
