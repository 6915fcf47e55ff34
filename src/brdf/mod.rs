//! The BRDF of a height field in f64: the references that judge every faster path.

pub mod mean;
