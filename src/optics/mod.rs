//! The optics in f64: geometry of a pair of directions, Fresnel reflectance, coherence, spectrum and colour, and the
//! direct sum that judges every faster path. Lengths are micrometres, angles radians, directions unit vectors in the
//! tangent frame (x = T, y = B, z = N) that point AWAY from the surface.

pub mod brdf;
pub mod coherence;
pub mod color;
pub mod color_difference;
pub mod colour_excess;
pub mod energy;
pub mod factor;
pub mod geometry;
pub mod grating;
pub mod material;
mod material_table;
pub mod nufft;
pub mod orders;
pub mod polarisation;
pub mod quadrature;
pub mod reference;
pub mod reflectance;
pub mod sampling;
pub mod small_slope;
pub mod spectrum;
pub mod surface_report;
pub mod svd;
pub mod theory;
pub mod validity;
