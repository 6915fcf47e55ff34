//! Height fields: the model, the files they come from, the generated ones, levelling.

mod height_field;

pub use height_field::{HeightField, MAX_SIDE};
