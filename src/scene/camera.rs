//! An orbit camera.

use super::lens::{Lens, LensProjection};
use crate::error::{Error, Result};
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, Vec3};

/// Camera that orbits a target. The world's up is +z.
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
    /// LensProjection, roll and shift.
    pub lens: Lens,
}

/// Unit vectors of a camera in the world.
#[derive(Clone, Copy)]
struct CameraAxes {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

/// Line of sight.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Point on the line, at the eye or in its plane.
    pub origin: DVec3,
    /// Direction away from the viewer; not normalised. Its component along the camera's axis is 1.
    pub direction: DVec3,
}

impl Camera {
    /// Returns the camera at `eye` that looks at `target` through `lens`.
    ///
    /// # Errors
    /// Numbers that are not finite, an eye at the target, a lens out of range.
    pub fn looking(eye: Vec3, target: Vec3, lens: Lens) -> Result<Self> {
        let offset = eye - target;
        let distance = offset.length();
        if !(eye.is_finite() && target.is_finite() && distance.is_finite() && distance > 0.0) {
            return Err(Error::usage(
                "the camera's eye and target are not two points",
                "give two different points",
            ));
        }
        lens.check()?;
        // Near the poles the arc cosine of a rounded quotient is wrong in the fourth digit.
        let theta = offset.truncate().length().atan2(offset.z);
        Ok(Self { target, distance, theta, phi: offset.y.atan2(offset.x), lens })
    }

    /// Returns the position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.exact_eye().as_vec3()
    }

    fn exact_eye(&self) -> DVec3 {
        self.target.as_dvec3() - f64::from(self.distance) * self.axes().forward
    }

    /// Returns the axes. Without roll, `right` is horizontal.
    fn axes(&self) -> CameraAxes {
        let (sin, cos) = f64::from(self.theta).sin_cos();
        let (sin_phi, cos_phi) = f64::from(self.phi).sin_cos();
        let forward = -DVec3::new(sin * cos_phi, sin * sin_phi, cos);
        let level = DVec3::new(-sin_phi, cos_phi, 0.0);
        let upright = level.cross(forward);
        let (sin, cos) = f64::from(self.lens.roll).sin_cos();
        CameraAxes { right: cos * level - sin * upright, up: cos * upright + sin * level, forward }
    }

    /// Returns the direction of the camera's axis, away from the viewer.
    pub fn forward(&self) -> DVec3 {
        self.axes().forward
    }

    /// Returns the directions to the right and up in the picture.
    pub fn right_and_up(&self) -> [Vec3; 2] {
        let axes = self.axes();
        [axes.right, axes.up].map(|axis| axis.as_vec3())
    }

    /// Returns the camera after its picture shows `factor` times as much: moved, and an orthographic one with another height.
    #[must_use]
    pub fn showing(&self, factor: f32) -> Self {
        let mut lens = self.lens;
        if let LensProjection::Orthographic { height } = &mut lens.projection {
            *height *= factor;
        }
        Self { distance: self.distance * factor, lens, ..*self }
    }

    /// Returns the viewer in homogeneous coordinates: the eye and 1, or for an orthographic camera the direction toward the viewer and 0.
    pub fn viewer(&self) -> DVec4 {
        match self.lens.projection {
            LensProjection::Perspective { .. } => self.exact_eye().extend(1.0),
            LensProjection::Orthographic { .. } => (-self.axes().forward).extend(0.0),
        }
    }

    /// Returns the vector from `point` to the viewer; of length 1 for an orthographic camera.
    pub fn toward_viewer(&self, point: DVec3) -> DVec3 {
        let viewer = self.viewer();
        viewer.truncate() - viewer.w * point
    }

    /// Returns the height of what the picture shows at `distance` from the eye.
    pub fn height_at(&self, distance: f32) -> f32 {
        self.lens.projection.height_at(distance)
    }

    /// Returns the matrix from the world to Vulkan clip space (y down, depth 0 … 1) for a picture of `size` pixels that shows a scene of
    /// `radius` around `centre`.
    pub fn clip_from_world(&self, size: [u32; 2], centre: Vec3, radius: f32) -> Mat4 {
        let axes = self.axes();
        let eye = self.exact_eye();
        let away = -axes.forward;
        let view = DMat4::from_cols(
            DVec3::new(axes.right.x, axes.up.x, away.x).extend(0.0),
            DVec3::new(axes.right.y, axes.up.y, away.y).extend(0.0),
            DVec3::new(axes.right.z, axes.up.z, away.z).extend(0.0),
            -DVec3::new(axes.right.dot(eye), axes.up.dot(eye), away.dot(eye)).extend(-1.0),
        );
        (self.clip_from_view(size, centre, radius) * view).as_mat4()
    }

    fn clip_from_view(&self, size: [u32; 2], centre: Vec3, radius: f32) -> DMat4 {
        let [near, far] = self.depths(centre, radius);
        self.lens.clip_from_view(size, near, far)
    }

    /// Returns the distances from the eye, along the axis, of the planes of depth 0 and 1 that enclose a scene of `radius` around `centre`.
    fn depths(&self, centre: Vec3, radius: f32) -> [f64; 2] {
        /// Smallest near over far distance: depth precision falls with far/near.
        const NEAREST: f64 = 1e-3;
        /// Room beside the scene.
        const MARGIN: f64 = 0.01;
        let from_eye = centre.as_dvec3() - self.exact_eye();
        let radius = f64::from(radius.max(1e-6));
        match self.lens.projection {
            LensProjection::Perspective { .. } => {
                let far = from_eye.length() + radius;
                let near = (from_eye.length() - radius).max(far * NEAREST);
                [near * (1.0 - MARGIN), far * (1.0 + MARGIN)]
            }
            // It sees what lies behind its eye, too.
            LensProjection::Orthographic { .. } => {
                let along = from_eye.dot(self.forward());
                [along - radius * (1.0 + MARGIN), along + radius * (1.0 + MARGIN)]
            }
        }
    }

    /// Returns the distance from the eye along the camera's axis, for the `depth` of [`Self::clip_from_world`] with the same `centre` and
    /// `radius`.
    pub fn distance_along_axis(&self, depth: f32, centre: Vec3, radius: f32) -> f64 {
        let [near, far] = self.depths(centre, radius);
        let depth = f64::from(depth);
        match self.lens.projection {
            LensProjection::Perspective { .. } => near * far / (far - depth * (far - near)),
            LensProjection::Orthographic { .. } => near + depth * (far - near),
        }
    }

    /// Returns the line of sight through the point `place` of a picture of `size` pixels \[pixels from its upper left corner\]: the f64
    /// twin of [`Self::clip_from_world`].
    pub fn sight(&self, place: DVec2, size: [u32; 2]) -> Sight {
        let CameraAxes { right, up, forward } = self.axes();
        let size = DVec2::new(size[0].into(), size[1].into());
        let shift = DVec2::new(self.lens.shift[0].into(), self.lens.shift[1].into());
        // Offset from the axis, right and up, in heights of the picture.
        let offset = (place - size / 2.0) * DVec2::new(1.0, -1.0) / size.y + shift;
        let eye = self.exact_eye();
        let across = |height: f64| (right * offset.x + up * offset.y) * height;
        match self.lens.projection {
            LensProjection::Perspective { field_of_view } => {
                let height = 2.0 * (f64::from(field_of_view) / 2.0).tan();
                Sight { origin: eye, direction: forward + across(height) }
            }
            LensProjection::Orthographic { height } => {
                Sight { origin: eye + across(height.into()), direction: forward }
            }
        }
    }
}

/// Returns the centre of pixel number `pixel`, row by row from the top, in a picture of `size` pixels \[pixels from its upper left corner\].
pub fn pixel_centre(pixel: usize, size: [u32; 2]) -> DVec2 {
    DVec2::new((pixel % size[0] as usize) as f64, (pixel / size[0] as usize) as f64) + 0.5
}

/// Returns the centre of pixel number `pixel` in clip space, for a picture of `size` pixels, row by row from the top.
pub fn pixel_in_clip(pixel: usize, size: [u32; 2]) -> DVec2 {
    pixel_centre(pixel, size) / DVec2::new(size[0].into(), size[1].into()) * 2.0 - 1.0
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
        let camera =
            Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 0.1), Lens::perspective(0.6))
                .unwrap();
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

    /// Returns cameras of every projection, with and without roll and shift.
    fn cameras() -> Vec<Camera> {
        let lenses = [Lens::perspective(0.6), Lens::orthographic(1.7)].into_iter().flat_map(|lens| {
            let plain = [lens, Lens { roll: -0.7, ..lens }, Lens { shift: [0.2, -0.4], ..lens }];
            plain.into_iter().chain([Lens { roll: 2.0, shift: [-1.1, 0.3], ..lens }])
        });
        let eyes = [Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 4.0), Vec3::new(0.5, 0.0, -3.0)];
        let looking = |lens| eyes.map(|eye| Camera::looking(eye, Vec3::new(0.5, 0.0, 0.1), lens).unwrap());
        lenses.flat_map(looking).collect()
    }

    #[test]
    fn a_sight_leads_to_what_is_seen_at_its_place_at_the_distance_of_its_depth() {
        let size = [200, 100];
        for camera in cameras() {
            let clip = camera.clip_from_world(size, Vec3::ZERO, 1.0);
            for place in [DVec2::new(100.0, 50.0), DVec2::new(0.5, 0.5), DVec2::new(150.0, 80.0)] {
                let sight = camera.sight(place, size);
                for along in [2.5, 4.0] {
                    let point = sight.origin + sight.direction * along;
                    let seen = clip.project_point3(point.as_vec3());
                    let expected = place / DVec2::new(200.0, 100.0) * 2.0 - 1.0;
                    let off = (seen.truncate().as_dvec2() - expected).length();
                    assert!(off < 2e-5, "{camera:?}, {place}: {seen}, {expected}");
                    let distance = camera.distance_along_axis(seen.z, Vec3::ZERO, 1.0);
                    assert!((distance - along).abs() < 1e-4, "{camera:?}: {distance}, {along}");
                    let to_viewer = camera.toward_viewer(point);
                    assert!(to_viewer.normalize().dot(sight.direction.normalize()) < -1.0 + 1e-12);
                }
            }
        }
    }

    #[test]
    fn roll_turns_the_picture_and_shift_moves_it() {
        let seen = |lens, point: Vec3| {
            let camera = Camera::looking(Vec3::new(0.0, -4.0, 0.0), Vec3::ZERO, lens).unwrap();
            let clip = camera.clip_from_world([100, 100], Vec3::ZERO, 1.0).project_point3(point);
            // To the right and up.
            [clip.x, -clip.y].map(|x| (x * 1e4).round() / 1e4)
        };
        for lens in [Lens::orthographic(2.0), Lens::perspective(2.0 * 0.25f32.atan())] {
            assert_eq!(seen(lens, Vec3::ZERO), [0.0, 0.0]);
            assert_eq!(seen(lens, Vec3::X * 0.5), [0.5, 0.0]);
            assert_eq!(seen(lens, Vec3::Z * 0.5), [0.0, 0.5]);
            // A camera that is turned clockwise sees up on its left.
            let rolled = Lens { roll: std::f32::consts::FRAC_PI_2, ..lens };
            assert_eq!(seen(rolled, Vec3::Z * 0.5), [-0.5, 0.0]);
            // The middle of a picture that is shifted to the right by a quarter of its height is what was half way to its rim.
            assert_eq!(seen(Lens { shift: [0.25, 0.0], ..lens }, Vec3::X * 0.5), [0.0, 0.0]);
            assert_eq!(seen(Lens { shift: [0.0, 0.25], ..lens }, Vec3::Z * 0.5), [0.0, 0.0]);
        }
    }

    #[test]
    fn a_camera_that_looks_straight_down_has_its_right_across_its_azimuth() {
        let camera = Camera::looking(Vec3::Z * 3.0, Vec3::ZERO, Lens::orthographic(2.0)).unwrap();
        assert_eq!(camera.forward(), DVec3::NEG_Z);
        let clip = camera.clip_from_world([100, 100], Vec3::ZERO, 1.0).project_point3(Vec3::Y * 0.5);
        assert!((clip.x - 0.5).abs() < 1e-6 && clip.y.abs() < 1e-6, "{clip}");
    }

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        let camera =
            Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 0.1), Lens::perspective(0.6))
                .unwrap();
        assert!((camera.eye() - Vec3::new(3.0, 1.0, 2.0)).length() < 1e-5);
        let clip = camera.clip_from_world([200, 100], Vec3::ZERO, 1.0);
        let middle = clip.project_point3(Vec3::new(0.5, 0.0, 0.1));
        assert!(middle.x.abs() < 1e-5 && middle.y.abs() < 1e-5 && (0.0..1.0).contains(&middle.z));
        // Vulkan's y grows downward.
        assert!(clip.project_point3(Vec3::new(0.5, 0.0, 0.3)).y < middle.y);
    }

    #[test]
    fn impossible_cameras_are_refused_and_the_pole_is_no_special_place() {
        assert!(Camera::looking(Vec3::ONE, Vec3::ONE, Lens::perspective(0.6)).is_err());
        assert!(Camera::looking(Vec3::ONE, Vec3::ZERO, Lens::perspective(0.0)).is_err());
        assert!(Camera::looking(Vec3::NAN, Vec3::ZERO, Lens::perspective(0.6)).is_err());
        let above = Camera::looking(Vec3::Z * 2.0, Vec3::ZERO, Lens::perspective(0.6)).unwrap();
        assert!(above.clip_from_world([10, 10], Vec3::ZERO, 1.0).is_finite());
    }
}
