//! What is looked at: meshes with tangent frames, camera, lights, the scene file.

pub mod mesh;
pub mod obj;
pub mod primitives;
pub mod snake;
mod surfacing;
mod tangents;

pub use mesh::{Bounds, Corner, Mesh, Vertex};
