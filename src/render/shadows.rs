//! Shadows: the depth of the mesh from each light. A map is drawn when its light has moved, not when the camera has. Samples move a light within its
//! extent, so that they add up to soft shadows. The geometry pass compares with the map; the shaders are `shaders/shadow.vert` and `in_shadow` of
//! `shaders/geometry.frag`.
//!
//! Shadows that a height field casts on itself are not modelled: Kirchhoff's approximation, on which the BRDF rests, leaves them out.

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

/// Returns the side of the depth maps for a picture of `size` pixels \[texels\]: four texels a pixel where the mesh fills the picture. Half as many put
/// twice as many pixels beside a shadow's edge on the wrong side of it.
fn side(size: [u32; 2]) -> u32 {
    (4 * size[0].max(size[1])).clamp(256, 2048)
}

/// Most depth maps that are kept. Further lights share the last.
const MOST_MAPS: usize = 4;

/// Depth maps of the lights.
pub struct Shadows {
    maps: Vec<DepthMap>,
    /// Number of the map that objects read.
    read: usize,
    /// World to the clip space of that map, as its light stands now.
    wanted: ClipFromWorld,
    side: u32,
    pipeline: Pipeline,
    block: Descriptors,
}

/// Columns of the matrix from the world to the clip space of a depth map.
type ClipFromWorld = [[f32; 4]; 4];

/// Depth of the mesh from one light.
struct DepthMap {
    image: Image,
    /// World to its clip space when it was drawn; `None` before that.
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
    /// Makes a map for pictures of `objects` with `size` pixels, which read it from now on.
    ///
    /// # Errors
    /// Where the device has no room.
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

    /// Lets `objects` read the map of light number `light`, which stands as `clip_from_world` says. The device must not be using the objects' sets.
    ///
    /// # Errors
    /// When the device has no room for the light's first map.
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

    /// Records the drawing of `objects` into the selected map, which it leaves readable by shaders, unless the map holds them already.
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

/// World to the clip space of the depth map of a light in this `direction`, for a picture of `size` pixels; the map holds a sphere of
/// `radius` around `centre`. `jitter` \[texels\] moves the map against the mesh, so that the texels of many samples blur into each other.
pub fn clip_from_world(
    direction: DVec3,
    centre: Vec3,
    radius: f32,
    size: [u32; 2],
    jitter: [f64; 2],
) -> Mat4 {
    /// A little more than the sphere, so that nothing ends at the edge of the map.
    const ROOM: f32 = 1.02;
    let toward = direction.as_vec3();
    let (x, y) = toward.any_orthonormal_pair();
    let scale = 1.0 / (ROOM * radius.max(f32::MIN_POSITIVE));
    let moved = |axis: usize| (2.0 * jitter[axis] / f64::from(side(size))) as f32;
    // Depth grows from 0, next to the light, to 1.
    let rows = [
        (x * scale).extend(moved(0) - scale * x.dot(centre)),
        (y * scale).extend(moved(1) - scale * y.dot(centre)),
        (toward * (-0.5 * scale)).extend(0.5 + 0.5 * scale * toward.dot(centre)),
        Vec4::W,
    ];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// World to the clip space of the depth map of a lamp at `place`, which looks at the middle of a sphere of `radius` around `centre`. The map
/// holds the sphere, unless the lamp is in or next to it: then what is within 75° of the direction to the middle. `size` and `jitter` as
/// of [`clip_from_world`].
pub fn clip_from_lamp(place: Vec3, centre: Vec3, radius: f32, size: [u32; 2], jitter: [f64; 2]) -> Mat4 {
    /// A little more than the sphere, so that nothing ends at the edge of the map.
    const ROOM: f32 = 1.02;
    /// The part of the radius that is next to a lamp and casts no shadow, where the lamp is in the sphere.
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

/// Largest angle that the depth map of a lamp holds on either side of its middle \[radians\].
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
        // What the shader takes for B of the depth A + B/distance.
        let reach = (near * lamp.extend(1.0)).z;
        let at = |distance: f32| depth(near, lamp - direction.as_vec3() * distance);
        assert!((at(4.0) - at(8.0) - reach * (1.0 / 4.0 - 1.0 / 8.0)).abs() < 1e-5);
        let moved = clip_from_lamp(lamp, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
        let moved = clip_from_world(direction, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
    }
}
