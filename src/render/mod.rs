//! Joins optics and Vulkan: the layers as a texture, the tables that the shaders read, passes, frames, targets. Only this
//! floor knows both sides.

pub mod accumulate;
pub mod color_table;
pub mod difference;
pub mod evaluator;
pub mod footprints;
pub mod frame;
pub mod interface;
pub mod picture;
pub mod pigment;
pub mod reference_picture;
pub mod repeating;
pub mod resources;
pub mod sampling;
pub mod shading;
pub mod tables;
pub mod target;
mod upload;
pub mod window;

/// SPIR-V of a shader, by the name of its file.
macro_rules! shader {
    ($name:literal) => {
        $crate::vk::pipeline::Code {
            name: $name,
            spirv: include_bytes!(concat!(env!("OUT_DIR"), "/", $name, ".spv")),
            constants: &[],
        }
    };
}
pub(crate) use shader;
