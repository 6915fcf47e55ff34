//! Shadows by depth maps from each light. A map is drawn when its light has moved, not when the camera has. Samples
//! move a light within its extent, so that their mean shows soft shadows. Shading compares with the map; the shaders are
//! `shaders/shadow.vert` and `in_shadow` of `shaders/light.glsl`.
//!
//! Shadows that a height field casts on itself are not modelled: the Kirchhoff approximation, on which the BRDF is
//! based, neglects them.

use crate::error::Result;
use crate::render::device_mesh::attributes;
use crate::render::frame_set::binding;
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

/// Depth maps of one size, and what they show.
struct DepthMaps {
    /// Binding of the maps.
    number: u32,
    /// One layer for each place of a light.
    image: Image,
    /// Matrix of each layer when it was drawn; `None` before that.
    drawn: RefCell<Vec<Option<ClipFromWorld>>>,
    /// Layer of each light of the current pass, and its matrix.
    wanted: Vec<(usize, ClipFromWorld)>,
}

/// Depth maps of the lights of a pass.
pub struct ShadowPass {
    of_lights: DepthMaps,
    /// Maps of the directions of surroundings among which pixels choose.
    of_surroundings: DepthMaps,
    pipeline: Pipeline,
    block: Descriptors,
}

/// Depth maps that a pass reads.
pub struct WantedMaps {
    /// True for directions of surroundings among which pixels choose.
    pub chosen: bool,
    /// Side of the maps.
    pub side: u32,
    /// Layer of each light, and its matrix.
    pub maps: Vec<(usize, [[f32; 4]; 4])>,
}

impl DepthMaps {
    fn new(device: &Arc<Device>, number: u32) -> Result<Self> {
        let image = Self::image(device, 1, 1)?;
        Ok(Self { number, image, drawn: RefCell::default(), wanted: Vec::new() })
    }

    /// Makes an array of `layers` depth maps of this `side`.
    fn image(device: &Arc<Device>, side: u32, layers: u32) -> Result<Image> {
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let (size, format) = ([side; 2], target::DEPTH);
        Image::new(device, &Description { name: "shadow maps", format, size, layers, array: true, usage })
    }

    /// Makes room for the `wanted` maps.
    fn select(&mut self, device: &Arc<Device>, objects: &[DeviceObject], wanted: WantedMaps) -> Result<()> {
        let WantedMaps { side, maps, .. } = wanted;
        let drawn = self.drawn.get_mut();
        let layers = maps.iter().map(|(layer, _)| layer + 1).fold(drawn.len(), usize::max);
        if layers > drawn.len() || self.image.size() != [side; 2] {
            self.image = Self::image(device, side, layers as u32)?;
            *drawn = vec![None; layers];
            objects.iter().for_each(|object| object.frame.read_shadow(self.number, &self.image));
        }
        self.wanted = maps;
        Ok(())
    }
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
        let of_lights = DepthMaps::new(device, binding::SHADOW)?;
        let of_surroundings = DepthMaps::new(device, binding::SKY_SHADOW)?;
        Ok(Self { of_lights, of_surroundings, pipeline, block })
    }

    /// Sets the maps of the pass and binds them to `objects`. The device must not be using the objects' sets.
    ///
    /// # Errors
    /// Fails if the device is out of memory for larger or further maps.
    pub fn select(
        &mut self,
        device: &Arc<Device>,
        objects: &[DeviceObject],
        wanted: WantedMaps,
    ) -> Result<()> {
        let (used, other) = if wanted.chosen {
            (&mut self.of_surroundings, &mut self.of_lights)
        } else {
            (&mut self.of_lights, &mut self.of_surroundings)
        };
        other.wanted.clear();
        used.select(device, objects, wanted)
    }

    /// Records the drawing of `objects` into the maps of the pass that are not up to date; all maps become readable by
    /// shaders.
    pub fn record(&self, record: &Recorder<'_>, objects: &[DeviceObject]) {
        self.record_maps(&self.of_lights, record, objects);
        self.record_maps(&self.of_surroundings, record, objects);
    }

    fn record_maps(&self, maps: &DepthMaps, record: &Recorder<'_>, objects: &[DeviceObject]) {
        let mut drawn = maps.drawn.borrow_mut();
        let stale: Vec<_> =
            maps.wanted.iter().filter(|(layer, matrix)| drawn[*layer] != Some(*matrix)).collect();
        if stale.is_empty() {
            return;
        }
        let side = maps.image.size();
        let all = record.within(side, 0..side[1]);
        // Maps that stay keep their contents.
        let is_new = drawn.iter().all(Option::is_none);
        let before = if is_new { Access::Nothing } else { Access::ShaderRead };
        all.images(&[(&maps.image, before, Access::DepthAttachment)]);
        for &&(layer, matrix) in &stale {
            drawn[layer] = Some(matrix);
            let number = layer as u32;
            all.render_layer(&maps.image, number, |draw| {
                draw.bind(&self.pipeline, &[&self.block]);
                objects.iter().filter(|o| o.casts_shadows).for_each(|object| object.mesh.draw(draw, number));
            });
        }
        all.images(&[(&maps.image, Access::DepthAttachment, Access::ShaderRead)]);
    }
}
