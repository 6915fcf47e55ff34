//! An orbit camera.

use crate::error::{Error, Result};
use glam::camera::rh::{proj::vulkan, view::look_at_mat4};
use glam::{DVec2, DVec3, Mat4, Vec3};

/// Perspective camera that orbits a target. The world's up is +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Point looked at.
    pub target: Vec3,
    /// Distance of the eye from the target.
    pub distance: f32,
    /// Polar angle of the eye from +z, seen from the target \[rad\].
    pub theta: f32,
    /// Azimuth of the eye from +x toward +y \[rad\].
    pub phi: f32,
    /// Vertical field of view \[rad\].
    pub field_of_view: f32,
}

/// Smallest angle of the eye from the poles, at which up and view direction coincide \[rad\].
const POLE_MARGIN: f32 = 1e-3;

impl Camera {
    /// Returns the camera at `eye` that looks at `target` under `field_of_view` \[rad\].
    ///
    /// # Errors
    /// Numbers that are not finite, an eye at the target, a field of view not within 1° … 170°.
    pub fn looking(eye: Vec3, target: Vec3, field_of_view: f32) -> Result<Self> {
        let offset = eye - target;
        let distance = offset.length();
        if !(eye.is_finite() && target.is_finite() && distance.is_finite() && distance > 0.0) {
            return Err(Error::usage(
                "the camera's eye and target are not two points",
                "give two different points",
            ));
        }
        if !(1f32.to_radians()..=170f32.to_radians()).contains(&field_of_view) {
            return Err(Error::usage(
                "the field of view is not within 1deg to 170deg",
                "35deg is a good start",
            ));
        }
        let theta = (offset.z / distance).clamp(-1.0, 1.0).acos();
        Ok(Self { target, distance, theta, phi: offset.y.atan2(offset.x), field_of_view })
    }

    /// Returns the position of the eye.
    pub fn eye(&self) -> Vec3 {
        let theta = self.theta.clamp(POLE_MARGIN, std::f32::consts::PI - POLE_MARGIN);
        let (sin, cos) = theta.sin_cos();
        self.target + self.distance * Vec3::new(sin * self.phi.cos(), sin * self.phi.sin(), cos)
    }

    /// Returns the matrix from the world to Vulkan clip space (y down, depth 0 … 1) for a picture of `size` pixels that shows a scene of
    /// `radius` around `centre`.
    pub fn clip_from_world(&self, size: [u32; 2], centre: Vec3, radius: f32) -> Mat4 {
        /// Smallest near over far distance: depth precision falls with far/near.
        const NEAREST: f32 = 1e-3;
        let eye = self.eye();
        let far = (centre - eye).length() + radius.max(1e-6);
        let near = ((centre - eye).length() - radius).max(far * NEAREST) * 0.99;
        let aspect = size[0] as f32 / size[1] as f32;
        let projection = vulkan::perspective(self.field_of_view, aspect, near, far * 1.01);
        projection * look_at_mat4(eye, self.target, Vec3::Z)
    }

    /// Returns a vector from the eye through the point `place` of a picture of `size` pixels \[pixels from its upper left corner\]: the f64
    /// twin of [`Self::clip_from_world`].
    pub fn ray(&self, place: DVec2, size: [u32; 2]) -> DVec3 {
        let forward = (self.target.as_dvec3() - self.eye().as_dvec3()).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let up = right.cross(forward);
        let size = DVec2::new(size[0].into(), size[1].into());
        // Half the picture's height at distance 1 before the eye.
        let half = (f64::from(self.field_of_view) / 2.0).tan();
        let from_middle = (place * 2.0 - size) * (half / size.y);
        forward + right * from_middle.x - up * from_middle.y
    }
}

/// Returns the centre of pixel number `pixel` in clip space, for a picture of `size` pixels, row by row from the top.
pub fn pixel_in_clip(pixel: usize, size: [u32; 2]) -> DVec2 {
    let place = DVec2::new((pixel % size[0] as usize) as f64, (pixel / size[0] as usize) as f64);
    (place + 0.5) / DVec2::new(size[0].into(), size[1].into()) * 2.0 - 1.0
}

/// Shifts `clip_from_world` of a picture of `size` pixels so that the centre of each pixel shows the point `jitter` pixels from it: x to
/// the right, y downward.
pub fn jittered(clip_from_world: Mat4, size: [u32; 2], jitter: [f64; 2]) -> Mat4 {
    // Clip space is two units wide. The picture moves against the jitter.
    let step = |axis: usize| (-2.0 * jitter[axis] / f64::from(size[axis])) as f32;
    Mat4::from_translation(Vec3::new(step(0), step(1), 0.0)) * clip_from_world
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jittered_camera_shows_at_a_pixel_s_centre_what_lies_beside_it() {
        let camera = Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 0.1), 0.6).unwrap();
        let size = [200, 100];
        let clip = camera.clip_from_world(size, Vec3::ZERO, 1.0);
        let moved = jittered(clip, size, [0.3, -1.25]);
        for point in [Vec3::ZERO, Vec3::new(0.4, -0.3, 0.2)] {
            let pixel = |clip: Mat4| {
                let place = clip.project_point3(point);
                [(place.x + 1.0) / 2.0 * 200.0, (place.y + 1.0) / 2.0 * 100.0]
            };
            let (still, seen) = (pixel(clip), pixel(moved));
            // A point 0.3 pixels to the right of the centre moves by 0.3 pixels to the left.
            assert!((still[0] - seen[0] - 0.3).abs() < 1e-4 && (still[1] - seen[1] + 1.25).abs() < 1e-4);
            assert_eq!(clip.project_point3(point).z, moved.project_point3(point).z);
        }
        assert_eq!(jittered(clip, size, [0.0; 2]), clip);
    }

    #[test]
    fn a_ray_leads_to_what_is_seen_at_its_place() {
        let camera = Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 0.1), 0.6).unwrap();
        let size = [200, 100];
        let clip = camera.clip_from_world(size, Vec3::ZERO, 1.0);
        for place in [DVec2::new(100.0, 50.0), DVec2::new(0.5, 0.5), DVec2::new(150.0, 80.0)] {
            let ray = camera.ray(place, size).as_vec3();
            for along in [2.5, 4.0] {
                let seen = clip.project_point3(camera.eye() + ray * along).truncate().as_dvec2();
                let expected = place / DVec2::new(200.0, 100.0) * 2.0 - 1.0;
                assert!((seen - expected).length() < 1e-5, "{place}: {seen}, {expected}");
            }
        }
    }

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        let camera = Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 0.1), 0.6).unwrap();
        assert!((camera.eye() - Vec3::new(3.0, 1.0, 2.0)).length() < 1e-5);
        let clip = camera.clip_from_world([200, 100], Vec3::ZERO, 1.0);
        let middle = clip.project_point3(Vec3::new(0.5, 0.0, 0.1));
        assert!(middle.x.abs() < 1e-5 && middle.y.abs() < 1e-5 && (0.0..1.0).contains(&middle.z));
        // Vulkan's y grows downward.
        assert!(clip.project_point3(Vec3::new(0.5, 0.0, 0.3)).y < middle.y);
    }

    #[test]
    fn impossible_cameras_are_refused_and_the_pole_is_survived() {
        assert!(Camera::looking(Vec3::ONE, Vec3::ONE, 0.6).is_err());
        assert!(Camera::looking(Vec3::ONE, Vec3::ZERO, 0.0).is_err());
        assert!(Camera::looking(Vec3::NAN, Vec3::ZERO, 0.6).is_err());
        let above = Camera::looking(Vec3::Z * 2.0, Vec3::ZERO, 0.6).unwrap();
        assert!(above.clip_from_world([10, 10], Vec3::ZERO, 1.0).is_finite());
    }
}
