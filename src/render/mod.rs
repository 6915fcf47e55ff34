//! Rendering: joins optics and Vulkan. Contains the layers as textures, the tables of the shaders, passes, frames and
//! targets. No other module uses both sides.

pub mod device_brdf;
pub mod device_mesh;
pub mod directions;
pub mod evaluator;
pub mod exposure;
pub mod footprints;
pub mod frame;
pub mod frame_set;
pub mod gbuffer;
pub mod grooves;
pub mod light_passes;
pub mod object;
pub mod passes;
pub mod pigment;
pub mod rays;
pub mod reference_picture;
pub mod renderer;
pub mod sampling;
pub mod sequence;
pub mod shadow_map;
pub mod source;
mod surroundings;
pub mod tables;
pub mod target;
pub mod upload;
pub mod window_pass;

/// SPIR-V of a shader, by the name of its file.
macro_rules! shader {
    ($($part:literal),+) => {
        $crate::vk::pipeline::Code {
            name: concat!($($part),+),
            spirv: include_bytes!(concat!(env!("OUT_DIR"), "/", $($part,)+ ".spv")),
            constants: &[],
        }
    };
}
pub(crate) use shader;
