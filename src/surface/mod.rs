//! Height fields: the model, the files they come from, the generated ones, levelling.

mod height_field;
pub mod image_file;
mod level;
pub mod source;
pub mod statistics;
pub mod synth;
pub mod tiling;

pub use height_field::{HeightField, MAX_SIDE};
pub use level::Level;
pub use source::Source;
pub use statistics::Statistics;
