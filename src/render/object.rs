//! Object of a scene: its data sources, and on the device its mesh and its frame set.

use super::device_mesh::DeviceMesh;
use super::frame_set::{FrameBlock, FrameSet};
use super::gbuffer::GBuffer;
use super::grooves::{GrooveDirections, Layout};
use super::pigment::Pigment;
use super::source::Source;
use crate::error::Result;
use crate::scene::{Mesh, Object, Scene};
use crate::settings::Optics;
use crate::vk::device::Device;
use glam::Vec3;
use std::sync::Arc;

/// Data that an object is drawn from.
#[derive(Clone, Copy)]
pub struct ObjectData<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Its pigment texture.
    pub pigment: &'a Pigment,
    /// Orientation of the patch on the mesh.
    pub grooves: &'a GrooveDirections,
    /// True if it casts shadows from lights that do.
    pub casts_shadows: bool,
    /// Sources that it is shaded from.
    pub sources: &'a ObjectSources,
}

impl<'a> ObjectData<'a> {
    /// Returns the data of an object whose patch lies along the mesh.
    pub fn new(mesh: &'a Mesh, pigment: &'a Pigment, sources: &'a ObjectSources) -> Self {
        let grooves = GrooveDirections::along();
        Self { mesh, pigment, grooves, casts_shadows: true, sources }
    }
}

/// Source of an object under one illuminant, that of `optics`.
#[derive(Clone)]
pub struct ObjectSource {
    /// BRDF data.
    pub source: Source,
    /// Settings of the optics.
    pub optics: Optics,
}

/// Sources of an object under all lights.
#[derive(Clone)]
pub struct ObjectSources {
    /// Source under the surroundings and the lights without a separate illuminant.
    pub first: ObjectSource,
    /// Sources under the lights with a separate illuminant, one for each. A light whose illuminant is missing here
    /// uses `first`.
    pub under: Vec<ObjectSource>,
}

impl ObjectSources {
    /// Returns `source`, shaded by `optics` under all lights.
    pub fn new(source: Source, optics: Optics) -> Self {
        Self { first: ObjectSource { source, optics }, under: Vec::new() }
    }

    /// Iterates over all sources, the default one first.
    pub fn all(&self) -> impl Iterator<Item = &ObjectSource> {
        std::iter::once(&self.first).chain(&self.under)
    }

    /// Returns true if the data and pipelines on the device for `other` can be reused: everything that is slow to
    /// upload or compile is the same.
    pub fn shares_data_with(&self, other: &Self) -> bool {
        let same = |(this, other): (&ObjectSource, &ObjectSource)| {
            this.source.shares_data_with(&other.source)
                && this.optics.reflectance.shares_stages_with(&other.optics.reflectance)
        };
        self.under.len() == other.under.len() && self.all().zip(other.all()).all(same)
    }
}

/// Files that are read for an object in addition to its mesh and its surface.
pub struct ObjectTextures {
    /// Pigment texture, white if there is none.
    pub pigment: Pigment,
    /// Orientation of the patch on the mesh.
    pub grooves: GrooveDirections,
}

impl ObjectTextures {
    /// Reads the textures of all objects of `scene`, in their order.
    ///
    /// # Errors
    /// Fails if a picture cannot be read.
    pub fn of(scene: &Scene) -> Result<Vec<Self>> {
        let read = |object: &Object| {
            let pigment = object.pigment.as_deref().map(Pigment::read).transpose()?;
            let grooves = GrooveDirections::of(&object.grooves)?;
            Ok(Self { pigment: pigment.unwrap_or_else(Pigment::white), grooves })
        };
        scene.objects.iter().map(read).collect()
    }
}

/// Returns the draw data of the objects of `scene`, with their `textures` and `sources`, in their order.
pub fn objects<'a>(
    scene: &'a Scene,
    textures: &'a [ObjectTextures],
    sources: impl IntoIterator<Item = &'a ObjectSources>,
) -> Vec<ObjectData<'a>> {
    let objects = scene.objects.iter().zip(textures).zip(sources);
    let data = |((object, textures), sources): ((&'a Object, &'a ObjectTextures), _)| ObjectData {
        mesh: &object.mesh,
        pigment: &textures.pigment,
        grooves: &textures.grooves,
        casts_shadows: !object.is_ground,
        sources,
    };
    objects.map(data).collect()
}

/// Object on the device.
pub struct DeviceObject {
    /// Its mesh.
    pub mesh: DeviceMesh,
    /// Frame set, with the pigment of the object.
    pub frame: FrameSet,
    /// Orientation of the patch on the mesh.
    pub layout: Layout,
    /// True if it casts shadows from lights that do.
    pub casts_shadows: bool,
    turn: [f32; 2],
    textured: bool,
}

impl DeviceObject {
    /// Uploads `data`, for frames with the images of `gbuffer`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, data: &ObjectData<'_>, gbuffer: &GBuffer) -> Result<Self> {
        Ok(Self {
            mesh: DeviceMesh::new(device, data.mesh)?,
            frame: FrameSet::new(device, data.pigment, data.grooves, gbuffer)?,
            layout: data.grooves.layout,
            casts_shadows: data.casts_shadows,
            turn: data.grooves.turn,
            textured: data.pigment.is_textured(),
        })
    }

    /// Adapts `block`, the block of the view, to this object, whose pigment has the albedo `base_color`, and whose
    /// specular order the variance `specular_spread` of (u, v).
    pub fn block(&self, mut block: FrameBlock, base_color: Vec3, specular_spread: f32) -> FrameBlock {
        block.surroundings[3] = specular_spread;
        block.grooves[..2].copy_from_slice(&self.turn);
        // Without a texture, no albedo image is read.
        block.base_color = base_color.extend(if self.textured { 1.0 } else { 0.0 }).to_array();
        block
    }
}
