//! Height fields: the type, files, generated surfaces, preparation and statistics.

pub mod files;
mod height_field;
pub mod prepare;
mod si;
pub mod source;
pub mod statistics;
pub mod synth;
pub mod tiling;
pub(crate) mod transpose;
mod unit_cell;

pub use height_field::{HeightField, MAX_SIDE};
pub use prepare::Levelling;
pub use source::SurfaceSource;
pub use statistics::Statistics;
