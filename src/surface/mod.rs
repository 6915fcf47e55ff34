//! Height fields: the model, the files they come from, the generated ones, levelling.

pub mod files;
mod height_field;
mod level;
pub mod source;
pub mod statistics;
pub mod synth;

pub use height_field::{HeightField, MAX_SIDE};
pub use level::Level;
pub use source::Source;
pub use statistics::Statistics;
