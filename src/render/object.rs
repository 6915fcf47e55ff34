//! An object of a scene: what it is shaded from, and on the device its mesh and what the frame is for it.

use super::device_mesh::DeviceMesh;
use super::frame_set::{FrameBlock, FrameSet};
use super::grooves::{GrooveDirections, Layout};
use super::pigment::Pigment;
use super::shading::Shading;
use super::source::Source;
use super::target::Geometry;
use crate::error::Result;
use crate::scene::{Grooves, Mesh, Scene};
use crate::vk::device::Device;
use glam::Vec3;
use std::path::PathBuf;
use std::sync::Arc;

/// What an object is drawn from.
#[derive(Clone, Copy)]
pub struct ObjectData<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Its pigment texture.
    pub pigment: &'a Pigment,
    /// How the patch lies on the mesh.
    pub grooves: &'a GrooveDirections,
    /// Albedo of its pigment; `None`: that of the view.
    pub base_color: Option<Vec3>,
    /// Whether it casts shadows, where lights do.
    pub casts_shadows: bool,
    /// What it is shaded from.
    pub sources: &'a ObjectSources,
}

/// What an object is shaded from under one illuminant, that of `shading`.
#[derive(Clone)]
pub struct ObjectSource {
    /// What it is shaded from.
    pub source: Source,
    /// How it is shaded.
    pub shading: Shading,
}

/// What an object is shaded from under all lights.
#[derive(Clone)]
pub struct ObjectSources {
    /// Under the lights without a spectrum of their own and the surroundings.
    pub own: ObjectSource,
    /// Under the lights with a spectrum of their own, one for each other illuminant. Lights whose illuminant is not there count as without.
    pub under: Vec<ObjectSource>,
}

impl ObjectSources {
    /// `source` shaded by `shading`, under all lights.
    pub fn new(source: Source, shading: Shading) -> Self {
        Self { own: ObjectSource { source, shading }, under: Vec::new() }
    }

    /// All of them, the own first.
    pub fn all(&self) -> impl Iterator<Item = &ObjectSource> {
        std::iter::once(&self.own).chain(&self.under)
    }

    /// Whether this could take over what a device holds for `other`: everything that takes long to upload or compile is the same.
    pub fn shares_data_with(&self, other: &Self) -> bool {
        let same = |(own, other): (&ObjectSource, &ObjectSource)| {
            own.source.shares_data_with(&other.source)
                && own.shading.reflectance.shares_stages_with(&other.shading.reflectance)
        };
        self.under.len() == other.under.len() && self.all().zip(other.all()).all(same)
    }
}

/// What is read for an object beside its mesh and its surface.
pub struct ObjectTextures {
    /// Its pigment texture, white where it has none.
    pub pigment: Pigment,
    /// How the patch lies on the mesh.
    pub grooves: GrooveDirections,
}

impl ObjectTextures {
    /// Those of all objects of `scene`, the first object first.
    ///
    /// # Errors
    /// A picture that cannot be read.
    pub fn of(scene: &Scene) -> Result<Vec<Self>> {
        let first = (&scene.pigment, &scene.grooves);
        let others = scene.objects.iter().map(|object| (&object.pigment, &object.grooves));
        let read = |(pigment, grooves): (&Option<PathBuf>, &Grooves)| {
            let pigment = pigment.as_deref().map(Pigment::read).transpose()?;
            let grooves = GrooveDirections::of(grooves)?;
            Ok(Self { pigment: pigment.unwrap_or_else(Pigment::white), grooves })
        };
        std::iter::once(first).chain(others).map(read).collect()
    }
}

/// What the objects of `scene` are drawn from, with what was read for them and what each is shaded from, the first object first.
pub fn objects<'a>(
    scene: &'a Scene,
    textures: &'a [ObjectTextures],
    sources: impl IntoIterator<Item = &'a ObjectSources>,
) -> Vec<ObjectData<'a>> {
    let others = scene.objects.iter().map(|o| (&o.mesh, Some(o.base_color), !o.is_ground));
    let meshes = std::iter::once((&scene.mesh, None, true)).chain(others);
    let object = |(((mesh, base_color, casts_shadows), own), sources): ((_, &'a ObjectTextures), _)| {
        let ObjectTextures { pigment, grooves } = own;
        ObjectData { mesh, pigment, grooves, base_color, casts_shadows, sources }
    };
    meshes.zip(textures).zip(sources).map(object).collect()
}

/// An object on the device.
pub struct DeviceObject {
    /// Its mesh.
    pub mesh: DeviceMesh,
    /// The frame, with its own pigment.
    pub frame: FrameSet,
    /// How the patch lies on the mesh.
    pub layout: Layout,
    /// Whether it casts shadows, where lights do.
    pub casts_shadows: bool,
    turn: [f32; 2],
    base_color: Option<Vec3>,
    textured: bool,
}

impl DeviceObject {
    /// Uploads `data`, for frames with what `geometry` holds.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, data: &ObjectData<'_>, geometry: &Geometry) -> Result<Self> {
        Ok(Self {
            mesh: DeviceMesh::new(device, data.mesh)?,
            frame: FrameSet::new(device, data.pigment, data.grooves, geometry)?,
            layout: data.grooves.layout,
            casts_shadows: data.casts_shadows,
            turn: data.grooves.turn,
            base_color: data.base_color,
            textured: data.pigment.is_textured(),
        })
    }

    /// `block`, which is that of the view, for this object, whose specular order spreads over this variance of (u, v).
    pub fn block(&self, mut block: FrameBlock, specular_spread: f32) -> FrameBlock {
        block.surroundings[3] = specular_spread;
        block.grooves = [self.turn[0], self.turn[1], 0.0, 0.0];
        if let Some(color) = self.base_color {
            block.base_color = color.extend(1.0).to_array();
        }
        if !self.textured {
            // There are no albedos to read.
            block.base_color[3] = 0.0;
        }
        block
    }
}
