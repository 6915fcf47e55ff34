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
use crate::render::shadow_map::side;
use crate::render::target;
use crate::scene::Vertex;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Depth, Drawing, Pipeline};
use ash::vk;
use std::cell::Cell;
use std::sync::Arc;

/// Maximum number of depth maps. Further lights share the last.
const MOST_MAPS: usize = 4;

/// Depth maps of the lights.
pub struct ShadowPass {
    maps: Vec<DepthMap>,
    /// Number of the map bound to the objects.
    read: usize,
    /// Matrix from the world to the clip space of that map, for the current position of its light.
    wanted: ClipFromWorld,
    side: u32,
    pipeline: Pipeline,
    block: Descriptors,
}

/// Columns of the matrix from the world to the clip space of a depth map.
type ClipFromWorld = [[f32; 4]; 4];

/// Depth map of the mesh from one light.
struct DepthMap {
    image: Image,
    /// Matrix from the world to the map's clip space when it was drawn; `None` before that.
    drawn: Cell<Option<ClipFromWorld>>,
}

impl DepthMap {
    fn new(device: &Arc<Device>, side: u32) -> Result<Self> {
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let (size, format) = ([side; 2], target::DEPTH);
        let description = Description { name: "shadow map", format, size, layers: 1, array: false, usage };
        Ok(Self { image: Image::new(device, &description)?, drawn: Cell::new(None) })
    }
}

impl ShadowPass {
    /// Makes a map for pictures of `objects` with `size` pixels, and binds it to the objects.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject], size: [u32; 2]) -> Result<Self> {
        let side = side(size);
        let binding = Binding {
            number: 0,
            kind: vk::DescriptorType::UNIFORM_BUFFER,
            stages: vk::ShaderStageFlags::VERTEX,
        };
        let block = Descriptors::new(device, "shadow set", &[binding])?;
        // The light is the same for all objects.
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
        let map = DepthMap::new(device, side)?;
        objects.iter().for_each(|object| object.frame.read_shadow(Some(&map.image)));
        Ok(Self { maps: vec![map], read: 0, wanted: ClipFromWorld::default(), side, pipeline, block })
    }

    /// Binds the map of light number `light`, with the matrix `clip_from_world`, to `objects`. The device must not be
    /// using the objects' sets.
    ///
    /// # Errors
    /// Fails if the device is out of memory for the light's first map.
    pub fn select(
        &mut self,
        device: &Arc<Device>,
        objects: &[DeviceObject],
        light: usize,
        clip_from_world: ClipFromWorld,
    ) -> Result<()> {
        let number = light.min(MOST_MAPS - 1);
        while self.maps.len() <= number {
            self.maps.push(DepthMap::new(device, self.side)?);
        }
        if number != self.read {
            objects.iter().for_each(|object| object.frame.read_shadow(Some(&self.maps[number].image)));
        }
        (self.read, self.wanted) = (number, clip_from_world);
        Ok(())
    }

    /// Records the drawing of `objects` into the selected map, unless the map is up to date; the map becomes readable
    /// by shaders.
    pub fn record(&self, record: &Recorder<'_>, objects: &[DeviceObject]) {
        let DepthMap { image, drawn } = &self.maps[self.read];
        if drawn.replace(Some(self.wanted)) == Some(self.wanted) {
            return;
        }
        let all = record.within([self.side; 2], 0..self.side);
        all.images(&[(image, Access::Nothing, Access::DepthAttachment)]);
        all.render(&[], Some(image), |draw| {
            draw.bind(&self.pipeline, &[&self.block]);
            objects.iter().filter(|o| o.casts_shadows).for_each(|object| object.mesh.draw(draw));
        });
        all.images(&[(image, Access::DepthAttachment, Access::ShaderRead)]);
    }
}
