//! Shadows by depth maps from each light. A map is drawn when its light has moved, not when the camera has. Samples
//! move a light within its extent, so that their mean shows soft shadows. The geometry pass compares with the map; the
//! shaders are `shaders/shadow.vert` and `in_shadow` of `shaders/geometry.frag`.
//!
//! Shadows that a height field casts on itself are not modelled: the Kirchhoff approximation, on which the BRDF is
//! based, neglects them.

use super::device_mesh::attributes;
use super::object::DeviceObject;
use super::shader;
use super::target;
use crate::error::Result;
use crate::scene::Vertex;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Depth, Drawing, Pipeline};
use ash::vk;
use glam::{DVec3, Mat4, Vec3, Vec4};
use std::cell::Cell;
use std::sync::Arc;

/// Returns the side of the depth maps for a picture of `size` pixels \[texels\]: about four texels per pixel if the
/// mesh fills the picture. With half the side, twice as many pixels at a shadow's edge are on the wrong side of it.
fn side(size: [u32; 2]) -> u32 {
    (4 * size[0].max(size[1])).clamp(256, 2048)
}

/// Maximum number of depth maps. Further lights share the last.
const MOST_MAPS: usize = 4;

/// Depth maps of the lights.
pub struct Shadows {
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

impl Shadows {
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

/// Returns the matrix from the world to the clip space of the depth map of a light in this `direction`, for a picture
/// of `size` pixels. The map covers a sphere of `radius` around `centre`. `jitter` \[texels\] shifts the map against
/// the mesh, so that its texels blur over many samples.
pub fn clip_from_world(
    direction: DVec3,
    centre: Vec3,
    radius: f32,
    size: [u32; 2],
    jitter: [f64; 2],
) -> Mat4 {
    /// Margin around the sphere, so that nothing is cut off at the edge of the map.
    const ROOM: f32 = 1.02;
    let toward = direction.as_vec3();
    let (x, y) = toward.any_orthonormal_pair();
    let scale = 1.0 / (ROOM * radius.max(f32::MIN_POSITIVE));
    let moved = |axis: usize| (2.0 * jitter[axis] / f64::from(side(size))) as f32;
    // Depth grows from 0, nearest to the light, to 1.
    let rows = [
        (x * scale).extend(moved(0) - scale * x.dot(centre)),
        (y * scale).extend(moved(1) - scale * y.dot(centre)),
        (toward * (-0.5 * scale)).extend(0.5 + 0.5 * scale * toward.dot(centre)),
        Vec4::W,
    ];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// Returns the matrix from the world to the clip space of the depth map of a lamp at `place`, aimed at the centre of a
/// sphere of `radius` around `centre`. The map covers the sphere; if the lamp is inside or close to it, the map covers
/// the directions within 75° of the centre. `size` and `jitter` are as for [`clip_from_world`].
pub fn clip_from_lamp(place: Vec3, centre: Vec3, radius: f32, size: [u32; 2], jitter: [f64; 2]) -> Mat4 {
    /// Margin around the sphere, so that nothing is cut off at the edge of the map.
    const ROOM: f32 = 1.02;
    /// Near plane of a lamp inside the sphere, as a fraction of the radius; nearer surfaces cast no shadow.
    const NEAREST: f32 = 0.01;
    let radius = ROOM * radius.max(f32::MIN_POSITIVE);
    let distance = place.distance(centre);
    let forward = (centre - place).try_normalize().unwrap_or(Vec3::NEG_Z);
    let (x, y) = forward.any_orthonormal_pair();
    let half = if distance > radius { (radius / distance).asin().min(WIDEST) } else { WIDEST };
    let focal = 1.0 / half.tan();
    let [near, far] = [(distance - radius).max(NEAREST * radius), distance + radius];
    let depth = far / (far - near);
    let row = |axis: Vec3, scale: f32, offset: f32| {
        (axis * scale + forward * offset).extend(-(axis * scale + forward * offset).dot(place))
    };
    let moved = |axis: usize| (2.0 * jitter[axis] / f64::from(side(size))) as f32;
    let mut third = row(forward, depth, 0.0);
    third.w -= near * depth;
    let rows = [row(x, focal, moved(0)), row(y, focal, moved(1)), third, row(forward, 1.0, 0.0)];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// Largest half-angle of the depth map of a lamp \[radians\].
const WIDEST: f32 = 75.0 * std::f32::consts::PI / 180.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_holds_the_sphere_and_what_is_nearer_to_the_light_has_less_depth() {
        let (direction, centre, radius) = (DVec3::new(0.6, 0.0, 0.8), Vec3::new(3.0, -2.0, 1.0), 2.5);
        let size = [640, 480];
        let toward = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::new(-0.6, 0.0, -0.8)];
        let depth = |clip: Mat4, p: Vec3| clip.project_point3(p).z;
        let far = clip_from_world(direction, centre, radius, size, [0.0; 2]);
        let lamp = centre + direction.as_vec3() * 6.0;
        let near = clip_from_lamp(lamp, centre, radius, size, [0.0; 2]);
        for clip in [far, near] {
            for toward in toward {
                let place = clip.project_point3(centre + toward * radius);
                let held = place.x.abs() <= 1.0 && place.y.abs() <= 1.0 && (0.0..=1.0).contains(&place.z);
                assert!(held, "{place}");
            }
            assert!(depth(clip, centre + direction.as_vec3()) < depth(clip, centre));
        }
        assert!((depth(far, centre) - 0.5).abs() < 1e-6);
        // B of the depth A + B/distance, as the shader computes it.
        let reach = (near * lamp.extend(1.0)).z;
        let at = |distance: f32| depth(near, lamp - direction.as_vec3() * distance);
        assert!((at(4.0) - at(8.0) - reach * (1.0 / 4.0 - 1.0 / 8.0)).abs() < 1e-5);
        let moved = clip_from_lamp(lamp, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
        let moved = clip_from_world(direction, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
    }
}
