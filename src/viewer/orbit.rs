//! Geometry of dragging camera and lights, without a window.

use crate::scene::environment::Placement;
use crate::scene::{Camera, Emitter, FarLight, Lamp, Mesh};
use glam::{Vec2, Vec3};

/// Object of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drag {
    /// The camera around its target.
    Orbit,
    /// The camera and its target sideways.
    Pan,
    /// The first light over the hemisphere.
    Light,
    /// The surroundings about the vertical.
    Surroundings,
}

/// Rotation for a drag across the height of the picture \[rad\].
const TURN: f32 = std::f32::consts::PI;
/// Smallest angle between the eye and a pole \[rad\]: a drag across the pole would flip the picture.
const POLE: f32 = 0.01;
/// Factor on the camera's distance per step of the wheel.
const ZOOM: f32 = 0.88;

/// Returns `camera` after a drag by `pixels` (x right, y down) in a picture `height` pixels high.
pub fn dragged(camera: Camera, drag: Drag, pixels: Vec2, height: f32) -> Camera {
    let part = pixels / height.max(1.0);
    match drag {
        Drag::Orbit => Camera {
            phi: (camera.phi - part.x * TURN).rem_euclid(2.0 * std::f32::consts::PI),
            theta: (camera.theta - part.y * TURN).clamp(POLE, std::f32::consts::PI - POLE),
            ..camera
        },
        Drag::Pan => {
            // A point at the target's distance stays under the pointer.
            let across = camera.height_at(camera.distance);
            let [right, up] = camera.right_and_up();
            Camera { target: camera.target + across * (up * part.y - right * part.x), ..camera }
        }
        Drag::Light | Drag::Surroundings => camera,
    }
}

/// Returns the emitter `light` after a drag by `pixels` in a picture `height` pixels high, seen by `camera`. A drag to
/// the right moves the light to the right, a drag upward moves it away from the viewer; a lamp keeps its height.
pub fn light_dragged(light: Emitter, camera: Camera, pixels: Vec2, height: f32) -> Emitter {
    match light {
        Emitter::Far(light) => far_light_dragged(light, camera, pixels, height).into(),
        Emitter::Lamp(lamp) => lamp_dragged(lamp, camera, pixels, height).into(),
    }
}

/// Returns the `placement` of surroundings after a drag by `pixels` in a picture `height` pixels high: the background
/// moves with the pointer.
pub fn surroundings_dragged(placement: Placement, pixels: Vec2, height: f32) -> Placement {
    let turned = placement.rotation - f64::from(pixels.x / height.max(1.0) * TURN).to_degrees();
    // Rounded to a tenth of a degree, to keep command lines short.
    let rotation = (turned * 10.0).round() / 10.0;
    // In the range −180° to 180°.
    Placement { rotation: rotation - 360.0 * (rotation / 360.0).round(), ..placement }
}

fn lamp_dragged(lamp: Lamp, camera: Camera, pixels: Vec2, height: f32) -> Lamp {
    let part = pixels / height.max(1.0);
    let away = Vec2::from_angle(camera.phi + std::f32::consts::PI);
    let right = Vec2::new(away.y, -away.x);
    let across = camera.height_at(camera.distance);
    let moved = lamp.middle + ((right * part.x - away * part.y) * across).extend(0.0).as_dvec3();
    // Rounded to a thousandth of the visible width, to keep command lines short.
    let digits = 10f64.powf((1e3 / f64::from(across)).log10().ceil());
    Lamp { middle: (moved * digits).round() / digits, ..lamp }
}

fn far_light_dragged(light: FarLight, camera: Camera, pixels: Vec2, height: f32) -> FarLight {
    let part = pixels / height.max(1.0);
    let (theta, phi) = ((light.theta as f32).to_radians(), (light.phi as f32).to_radians());
    // Polar coordinates of radius θ have no singularity at the zenith.
    let place = Vec2::from_angle(phi) * theta;
    let away = Vec2::from_angle(camera.phi + std::f32::consts::PI);
    let right = Vec2::new(away.y, -away.x);
    let moved = place + (right * part.x - away * part.y) * TURN;
    let length = moved.length();
    let theta = f64::from(length.to_degrees()).clamp(0.0, 89.0);
    let phi = if length > 1e-4 { f64::from(moved.to_angle().to_degrees()) } else { light.phi };
    // Rounded to a tenth of a degree, to keep command lines short.
    let tenth = |x: f64| (x * 10.0).round() / 10.0;
    FarLight { theta: tenth(theta), phi: tenth(phi), ..light }
}

/// Returns `camera` after `steps` of the wheel, forward positive, around a scene of `radius`.
pub fn zoomed(camera: Camera, steps: f32, radius: f32) -> Camera {
    let distance = camera.distance * ZOOM.powf(steps.clamp(-20.0, 20.0));
    camera.showing(distance.clamp(radius * 0.02, radius * 50.0) / camera.distance)
}

/// Returns the pixel of a picture of `size` that shows `point`; `None` behind the eye.
pub fn pixel_of(camera: &Camera, point: Vec3, size: [u32; 2]) -> Option<Vec2> {
    let clip = camera.clip_from_world(size, camera.target, camera.distance) * point.extend(1.0);
    let place = clip.truncate().truncate() / clip.w;
    (clip.w > 0.0).then(|| (place + 1.0) / 2.0 * Vec2::new(size[0] as f32, size[1] as f32))
}

/// Returns the nearest point of `meshes` under pixel `at` of a picture of `size`; `None` if there is none.
pub fn hit(camera: &Camera, meshes: &[&Mesh], at: Vec2, size: [u32; 2]) -> Option<Vec3> {
    let sight = camera.sight(at.as_dvec2(), size);
    let (eye, ray) = (sight.origin.as_vec3(), sight.direction.as_vec3());
    let distances = meshes.iter().flat_map(|mesh| {
        let corner = |i: u32| Vec3::from(mesh.vertices()[i as usize].position);
        mesh.indices().chunks_exact(3).filter_map(move |t| {
            let [a, b, c] = [corner(t[0]), corner(t[1]), corner(t[2])];
            crossing(eye, ray, a, b - a, c - a)
        })
    });
    distances.min_by(f32::total_cmp).map(|t| eye + ray * t)
}

/// Returns the distance along `ray` from `eye` to the triangle at `a` with edges `e` and `f` (Möller and Trumbore
/// 1997).
fn crossing(eye: Vec3, ray: Vec3, a: Vec3, e: Vec3, f: Vec3) -> Option<f32> {
    let p = ray.cross(f);
    let determinant = e.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = eye - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e);
    let v = ray.dot(q) / determinant;
    let t = f.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Lens, primitives};

    fn camera() -> Camera {
        Camera::looking(Vec3::new(0.0, -3.0, 1.0), Vec3::ZERO, Lens::perspective(0.6)).unwrap()
    }

    #[test]
    fn a_drag_to_the_right_turns_what_is_seen_to_the_right() {
        let turned = dragged(camera(), Drag::Orbit, Vec2::new(100.0, 0.0), 400.0);
        // A point at the front, seen by the turned camera, has moved right.
        let clip = turned.clip_from_world([400, 400], Vec3::ZERO, 2.0);
        assert!(clip.project_point3(Vec3::new(0.0, -1.0, 0.0)).x > 0.1);
        assert_eq!(turned.distance, camera().distance);
        let above = dragged(camera(), Drag::Orbit, Vec2::new(0.0, 1e6), 400.0);
        assert!(
            above.theta > 0.0 && above.eye().z > 2.9,
            "dragging down looks from above, and stops at the pole"
        );
    }

    #[test]
    fn what_is_panned_stays_under_the_pointer() {
        let (size, start) = ([640, 480], camera());
        let before = start.clip_from_world(size, Vec3::ZERO, 2.0).project_point3(start.target);
        let panned = dragged(start, Drag::Pan, Vec2::new(64.0, -30.0), 480.0);
        let after = panned.clip_from_world(size, Vec3::ZERO, 2.0).project_point3(start.target);
        let moved = (after - before).truncate() * Vec2::new(320.0, 240.0);
        assert!((moved - Vec2::new(64.0, -30.0)).length() < 0.5, "{moved}");
    }

    #[test]
    fn the_wheel_zooms_within_limits() {
        let near = zoomed(camera(), 1.0, 1.0);
        assert!(near.distance < camera().distance);
        assert!((zoomed(near, -1.0, 1.0).distance - camera().distance).abs() < 1e-5);
        assert!((0..100).fold(camera(), |c, _| zoomed(c, 9.0, 1.0)).distance >= 0.02);
    }

    #[test]
    fn a_light_crosses_the_zenith_and_stays_above_the_horizon() {
        let light = FarLight { theta: 10.0, phi: 90.0, intensity: 2.0, size: 0.0 };
        // The camera looks toward +y, so a drag upward moves the light on the far side farther away.
        let dragged = |light: FarLight, pixels| match light_dragged(light.into(), camera(), pixels, 400.0) {
            Emitter::Far(light) => light,
            Emitter::Lamp(_) => panic!("it became a lamp"),
        };
        let away = dragged(light, Vec2::new(0.0, -40.0));
        assert!(away.theta > light.theta && (away.phi - 90.0).abs() < 0.2, "{away:?}");
        let across = dragged(light, Vec2::new(0.0, 80.0));
        assert!((across.phi + 90.0).abs() < 0.2 && across.theta > 0.0, "{across:?}");
        let right = dragged(FarLight { theta: 0.0, ..light }, Vec2::new(80.0, 0.0));
        assert!(right.direction().x > 0.3 && right.intensity == 2.0, "{right:?}");
        assert_eq!(dragged(light, Vec2::new(1e5, 0.0)).theta, 89.0);
        let lamp = Emitter::parse("sphere:0.1:0.2,0.3,1").unwrap();
        let Emitter::Lamp(moved) = light_dragged(lamp, camera(), Vec2::new(40.0, -40.0), 400.0) else {
            panic!()
        };
        assert!(moved.middle.x > 0.2 && moved.middle.y > 0.3 && moved.middle.z == 1.0, "{moved:?}");
    }

    #[test]
    fn surroundings_turn_with_the_pointer_and_keep_their_angle_short() {
        let turned = |from: f64, x: f32| {
            let placement = Placement { rotation: from, exposure: 1.5 };
            surroundings_dragged(placement, Vec2::new(x, 70.0), 400.0)
        };
        // A drag across the height turns by half a circle.
        assert_eq!(turned(0.0, -100.0), Placement { rotation: 45.0, exposure: 1.5 });
        assert!((turned(170.0, -100.0).rotation + 145.0).abs() < 1e-9);
        assert!((turned(-170.0, 100.0).rotation - 145.0).abs() < 1e-9);
    }

    #[test]
    fn a_click_finds_the_point_under_it_or_nothing() {
        let plate = primitives::plate();
        let above = Camera::looking(Vec3::new(0.0, -0.01, 4.0), Vec3::ZERO, Lens::perspective(0.6)).unwrap();
        let middle = hit(&above, &[&plate], Vec2::new(100.0, 100.0), [200, 200]).unwrap();
        assert!(middle.length() < 0.02, "{middle}");
        assert!(hit(&above, &[&plate], Vec2::new(0.0, 0.0), [2000, 20]).is_none());
    }
}
