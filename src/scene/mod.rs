//! What is looked at: meshes with tangent frames, camera, lights, the scene file.

pub mod camera;
pub mod light;
pub mod mesh;
pub mod obj;
pub mod primitives;
pub mod scene_file;
pub mod snake;
mod surfacing;
mod tangents;

pub use camera::Camera;
pub use light::{Light, MAX_LIGHTS};
pub use mesh::{Bounds, Corner, Mesh, Vertex};
pub use scene_file::Scene;
