//! Passes of a frame, in the order in which they are drawn: depth from the light, G-buffer, shading, sum of samples,
//! display, and the background. Each is a struct that owns its pipelines and records its commands.

pub mod accumulate;
pub mod background;
pub mod display;
pub mod geometry;
pub mod light_directions;
pub mod light_run;
pub mod probe;
pub mod shade;
pub mod shadow;

use super::gbuffer::GBufferSettings;
use crate::vk::pipeline::{Depth, Drawing, Stencil};
use ash::vk;

/// Returns the depth test of passes over the pixels that the G-buffer covers, in a depth of this `format`. Their
/// one triangle lies at the clear depth, so that devices discard uncovered pixels before the fragment shader runs.
/// Software devices do not skip these with a branch in the shader.
pub(in crate::internals::render) fn covered(format: vk::Format) -> Depth {
    Depth { format, compare: vk::CompareOp::GREATER, write: false, stencil: None }
}

/// Returns the state of a triangle that is drawn into images of these formats, over the pixels of an object in a G-buffer
/// with these `settings`.
fn over_objects(colors: &[vk::Format], settings: GBufferSettings) -> Drawing<'_> {
    let stencil = settings.several.then_some(Stencil::Match);
    let depth = Some(Depth { stencil, ..covered(settings.depth_format()) });
    Drawing { vertex_stride: 0, attributes: &[], colors, depth }
}

/// Returns the stencil value of object `number`, from 0; stencil 0 marks uncovered pixels.
fn stencil_of(number: usize) -> u8 {
    (number + 1).min(u8::MAX.into()) as u8
}
