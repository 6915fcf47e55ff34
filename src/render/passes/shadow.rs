//! Shadows by depth maps from each light. A map is drawn when its light has moved, not when the camera has. Samples
//! move a light within its extent, so that their mean shows soft shadows. Shading compares with the map; the shaders are
//! `shaders/shadow.vert` and `in_shadow` of `shaders/light.glsl`.
//!
//! Shadows that a height field casts on itself are not modelled: the Kirchhoff approximation, on which the BRDF is
//! based, neglects them.

use crate::error::Result;
use crate::render::device_mesh::attributes;
use crate::render::object::DeviceObject;
use crate::render::shader;
use crate::render::target;
use crate::scene::Vertex;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Depth, Drawing, Pipeline};
use ash::vk;
use std::cell::RefCell;
use std::sync::Arc;

/// Columns of the matrix from the world to the clip space of a depth map.
type ClipFromWorld = [[f32; 4]; 4];

/// Depth maps of the lights of a pass.
pub struct ShadowPass {
    /// One layer for each place of a light.
    maps: Image,
    /// Matrix of each layer when it was drawn; `None` before that.
    drawn: RefCell<Vec<Option<ClipFromWorld>>>,
    /// Layer of each light of the current pass, and its matrix.
    wanted: Vec<(usize, ClipFromWorld)>,
    pipeline: Pipeline,
    block: Descriptors,
}

/// Makes an array of `layers` depth maps of this `side`.
fn maps(device: &Arc<Device>, side: u32, layers: u32) -> Result<Image> {
    let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
    let (size, format) = ([side; 2], target::DEPTH);
    Image::new(device, &Description { name: "shadow maps", format, size, layers, array: true, usage })
}

impl ShadowPass {
    /// Makes a pass without maps.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject]) -> Result<Self> {
        let binding = Binding {
            number: 0,
            kind: vk::DescriptorType::UNIFORM_BUFFER,
            stages: vk::ShaderStageFlags::VERTEX,
        };
        let block = Descriptors::new(device, "shadow set", &[binding])?;
        // The lights are the same for all objects.
        if let Some(first) = objects.first() {
            first.frame.share_block(&block, 0);
        }
        let drawing = Drawing {
            vertex_stride: size_of::<Vertex>() as u32,
            attributes: &attributes()[..1],
            colors: &[],
            depth: Some(Depth {
                format: target::DEPTH,
                compare: vk::CompareOp::LESS,
                write: true,
                stencil: None,
            }),
        };
        let pipeline = Pipeline::graphics(device, shader!("shadow.vert"), None, &drawing, &[&block], 0)?;
        Ok(Self { maps: maps(device, 1, 1)?, drawn: RefCell::default(), wanted: Vec::new(), pipeline, block })
    }

    /// Sets the lights of the pass, each with its layer and its matrix, and binds the maps, of this `side`, to `objects`. The
    /// device must not be using the objects' sets.
    ///
    /// # Errors
    /// Fails if the device is out of memory for larger or further maps.
    pub fn select(
        &mut self,
        device: &Arc<Device>,
        objects: &[DeviceObject],
        side: u32,
        wanted: Vec<(usize, ClipFromWorld)>,
    ) -> Result<()> {
        let drawn = self.drawn.get_mut();
        let layers = wanted.iter().map(|(layer, _)| layer + 1).fold(drawn.len(), usize::max);
        if layers > drawn.len() || self.maps.size() != [side; 2] {
            self.maps = maps(device, side, layers as u32)?;
            *drawn = vec![None; layers];
            objects.iter().for_each(|object| object.frame.read_shadow(Some(&self.maps)));
        }
        self.wanted = wanted;
        Ok(())
    }

    /// Records the drawing of `objects` into the maps of the pass that are not up to date; all maps become readable by
    /// shaders.
    pub fn record(&self, record: &Recorder<'_>, objects: &[DeviceObject]) {
        let mut drawn = self.drawn.borrow_mut();
        let stale: Vec<_> =
            self.wanted.iter().filter(|(layer, matrix)| drawn[*layer] != Some(*matrix)).collect();
        if stale.is_empty() {
            return;
        }
        let side = self.maps.size();
        let all = record.within(side, 0..side[1]);
        // Maps that stay keep their contents.
        let is_new = drawn.iter().all(Option::is_none);
        let before = if is_new { Access::Nothing } else { Access::ShaderRead };
        all.images(&[(&self.maps, before, Access::DepthAttachment)]);
        for &&(layer, matrix) in &stale {
            drawn[layer] = Some(matrix);
            let number = layer as u32;
            all.render_layer(&self.maps, number, |draw| {
                draw.bind(&self.pipeline, &[&self.block]);
                objects.iter().filter(|o| o.casts_shadows).for_each(|object| object.mesh.draw(draw, number));
            });
        }
        all.images(&[(&self.maps, Access::DepthAttachment, Access::ShaderRead)]);
    }
}
