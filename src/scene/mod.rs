//! The scene: meshes with tangent frames, camera, lights, scene files.

pub mod camera;
pub mod corner;
pub mod display_settings;
pub mod environment;
mod environment_cells;
mod exr_header;
pub mod far_light;
pub mod incident;
pub mod lamp;
pub mod light;
pub mod mesh;
mod normals;
pub mod obj;
pub mod object;
mod polygon;
pub mod primitives;
mod radiance_header;
mod scene_document;
pub mod scene_file;
mod scene_options;
mod scene_writer;
pub mod snake;
mod tangents;

pub use camera::Camera;
pub use corner::Corner;
pub use display_settings::{Background, DisplaySettings};
pub use environment::Environment;
pub use far_light::FarLight;
pub use incident::Incident;
pub use lamp::{Lamp, Room};
pub use light::{Emitter, Light};
pub use mesh::{Bounds, Mesh, Vertex};
pub use object::{Grooves, Object};
pub use scene_file::Scene;
