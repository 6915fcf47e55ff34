//! Whole pictures against the f64 reference picture, per channel in linear light.

use crate::device::with_device;
use crate::evaluation::{layers, limited, optics, patch, window};
use crate::measure::channel;
use crate::shared::Pictured;
use diffract::internals::render::directions::Directions;
use diffract::internals::render::frame::View;
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::Picture;
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::vk::device::Device;
use glam::{DVec3, Vec3};
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 72];

/// A picture with the directions that it shaded.
fn paint(
    device: &Arc<Device>,
    field: &HeightField,
    optics: &Optics,
    scene: &Scene,
    view: &View,
) -> (Picture, Vec<Directions>) {
    let layers = layers(field, optics);
    let source = limited(window(&layers), field, optics);
    let mut renderer = crate::renderer_of(device, scene, &source, optics, SIZE).unwrap();
    let picture = renderer.render_plain(view, 0.0, DVec3::ZERO).unwrap();
    let directions = (0..view.lights.len()).map(|light| renderer.directions(view, light).unwrap()).collect();
    (picture, directions)
}

#[test]
fn a_picture_is_the_reference_picture_within_its_tolerance() {
    let field = patch(SurfaceKind::Elaphe, 6.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![Light::point(45.0, -40.0, 2.0), Light::point(70.0, 60.0, 0.7)];
    let view = View::of(&scene, lights);
    with_device(|device| {
        let mut exact: Option<Vec<[f32; 4]>> = None;
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let optics = optics(8.0, tolerance);
            let (picture, directions) = paint(device, &field, &optics, &scene, &view);
            let exact = exact.get_or_insert_with(|| {
                let pictured = Pictured { field: &field, optics: &optics, view: &view, size: SIZE };
                pictured.kept_by(device, "sphere-elaphe-one-window", &directions)
            });
            let covered = exact.iter().filter(|p| p[3] == 1.0).count();
            assert!(covered > 1000, "only {covered} pixels are covered");
            let errors = [0, 1, 2].map(|c| channel(&picture.radiance, exact, c));
            eprintln!("picture at {tolerance:e}: {errors:.2?}");
            assert!(errors.iter().all(|&e| e <= tolerance), "{tolerance}: {errors:?}");
            if tolerance < 1e-2 {
                // What must not pass: the light moved by half a degree, and red and blue exchanged.
                let mut moved = view.clone();
                moved.lights[0] = Light::point(45.5, -40.0, 2.0);
                let (wrong, _) = paint(device, &field, &optics, &scene, &moved);
                assert!(channel(&wrong.radiance, exact, 1) > tolerance);
                let swapped: Vec<_> = picture.radiance.iter().map(|p| [p[2], p[1], p[0], p[3]]).collect();
                assert!(channel(&swapped, exact, 0) > tolerance);
            }
        }
    });
}

#[test]
fn a_pigment_texture_of_one_colour_is_that_base_colour_under_one_light_and_under_four() {
    let field = patch(SurfaceKind::Flat, 2.0);
    let scene = Scene::open("sphere").unwrap();
    let optics = optics(4.0, 1e-1);
    let light = |phi: f64| Light::point(40.0, phi, 1.0);
    // sRGB codes 255 and 0 are exactly 1 and 0.
    let green = Pigment { size: [2, 2], texels: [0, 255, 0, 255].repeat(4) };
    let base = |color: Vec3, view: &View| View { base_colors: vec![color], ..view.clone() };
    with_device(|device| {
        let layers = layers(&field, &optics);
        for lights in [vec![light(10.0)], [10.0, 80.0, 200.0, -60.0].map(light).to_vec()] {
            let plain = View::of(&scene, lights);
            let paint = |pigment: &Pigment, view: &View| {
                let mut renderer = crate::renderer(
                    device,
                    &window(&layers),
                    &optics,
                    &scene.main_object().mesh,
                    pigment,
                    SIZE,
                )
                .unwrap();
                renderer.render_plain(view, 0.0, DVec3::ZERO).unwrap().radiance
            };
            let textured = base(Vec3::ONE, &plain);
            let found = paint(&green, &textured);
            assert_eq!(found, paint(&Pigment::white(), &base(Vec3::Y, &plain)));
            assert_ne!(found, paint(&Pigment::white(), &base(Vec3::X, &plain)));
            // White is what a view with a texture falls back to where there is none.
            let white = paint(&Pigment::white(), &base(Vec3::ONE, &plain));
            assert_eq!(white, paint(&Pigment::white(), &textured));
            assert_ne!(white, found);
        }
    });
}

#[test]
fn an_upright_sphere_is_lit_from_where_the_light_is() {
    let field = patch(SurfaceKind::Flat, 4.0);
    let scene = Scene::open("sphere").unwrap();
    let optics = optics(4.0, 1e-1);
    let half = |light: Light| {
        let mut sides = [[0.0f64; 2]; 2];
        with_device(|device| {
            let mut view = View::of(&scene, vec![light]);
            view.base_colors = vec![Vec3::ONE];
            let (picture, _) = paint(device, &field, &optics, &scene, &view);
            for (i, p) in picture.radiance.iter().enumerate() {
                let (x, y) = (i % SIZE[0] as usize, i / SIZE[0] as usize);
                sides[0][usize::from(x >= SIZE[0] as usize / 2)] += f64::from(p[1]);
                sides[1][usize::from(y >= SIZE[1] as usize / 2)] += f64::from(p[1]);
            }
        });
        sides
    };
    // The camera looks along +y: +x is to the right, +z is up (row 0 is the top).
    let right = half(Light::point(80.0, 0.0, 1.0));
    assert!(right[0][1] > 1.5 * right[0][0], "{right:?}");
    let top = half(Light::point(0.0, 0.0, 1.0));
    assert!(top[1][0] > 1.5 * top[1][1], "{top:?}");
}

#[test]
fn directions_are_unit_vectors_where_the_mesh_covers_and_nothing_elsewhere() {
    let field = patch(SurfaceKind::Flat, 4.0);
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, scene.lights.clone());
    with_device(|device| {
        let (picture, directions) = paint(device, &field, &optics(4.0, 1e-1), &scene, &view);
        for (pixel, (light, seen)) in
            picture.radiance.iter().zip(directions[0].light.iter().zip(&directions[0].view))
        {
            assert_eq!(pixel[3], light[3]);
            for v in [light, seen] {
                let length = v[..3].iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!(if pixel[3] == 1.0 { (length - 1.0).abs() < 1e-5 } else { length == 0.0 });
            }
        }
    });
}

#[test]
fn the_same_view_gives_the_same_bits_and_every_pixel_is_finite() {
    let field = patch(SurfaceKind::Elaphe, 6.0);
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, scene.lights.clone());
    let optics = optics(16.0, 1e-1);
    with_device(|device| {
        let (first, _) = paint(device, &field, &optics, &scene, &view);
        let (second, _) = paint(device, &field, &optics, &scene, &view);
        assert!(first == second);
        assert!(first.radiance.iter().flatten().all(|x| x.is_finite()));
    });
}

/// The point of a unit sphere at the origin that a pixel's ray meets first.
fn on_sphere(view: &View, pixel: usize) -> Option<DVec3> {
    let clip = view.clip_from_world(SIZE).as_dmat4().inverse();
    let (x, y) = ((pixel % SIZE[0] as usize) as f64 + 0.5, (pixel / SIZE[0] as usize) as f64 + 0.5);
    let ndc = |z: f64| clip.project_point3(DVec3::new(2.0 * x / 96.0 - 1.0, 2.0 * y / 72.0 - 1.0, z));
    let eye = view.camera.eye().as_dvec3();
    let ray = (ndc(0.9) - eye).normalize();
    let along = -eye.dot(ray);
    let inside = 1.0 - (eye + ray * along).length_squared();
    (inside >= 0.0).then(|| eye + ray * (along - inside.sqrt()))
}

#[test]
fn interpolated_tangent_space_directions_are_close_to_those_of_exact_frames() {
    let scene = Scene::open("sphere").unwrap();
    let light = Light::point(45.0, -40.0, 1.0);
    let view = View::of(&scene, vec![light.clone()]);
    with_device(|device| {
        let (_, directions) =
            paint(device, &patch(SurfaceKind::Flat, 4.0), &optics(4.0, 1e-1), &scene, &view);
        let mut angles: Vec<f64> = Vec::new();
        for (pixel, (seen_light, seen_view)) in
            directions[0].light.iter().zip(&directions[0].view).enumerate()
        {
            let Some(normal) = on_sphere(&view, pixel).filter(|_| seen_light[3] == 1.0) else { continue };
            let to_view = (view.camera.eye().as_dvec3() - normal).normalize();
            let to_light = light.emitter.from_afar(&view.room()).direction().as_dvec3();
            // T points east, along growing longitude; B = N x T north.
            let east = DVec3::new(-normal.y, normal.x, 0.0).normalize();
            for (exact, seen) in [(to_light, seen_light), (to_view, seen_view)] {
                let exact = DVec3::new(exact.dot(east), exact.dot(normal.cross(east)), exact.dot(normal));
                let seen = DVec3::new(seen[0].into(), seen[1].into(), seen[2].into());
                angles.push(exact.angle_between(seen).to_degrees());
            }
        }
        angles.sort_by(f64::total_cmp);
        let at = |share: f64| angles[((angles.len() - 1) as f64 * share) as usize];
        eprintln!(
            "interpolation of directions: median {:.1e}, p95 {:.1e}, max {:.1e} degrees",
            at(0.5),
            at(0.95),
            at(1.0)
        );
        // The sphere's facets are a few degrees wide: linear interpolation over an arc of ε radians errs by about ε²/8.
        assert!(angles.len() > 2000 && at(0.95) < 0.2, "{:?}", (angles.len(), at(0.5), at(0.95), at(1.0)));
    });
}
