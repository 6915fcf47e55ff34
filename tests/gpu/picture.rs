//! Whole pictures against the f64 reference picture, per channel in linear light.

use crate::device::with_device;
use crate::evaluation::{layers, patch, shading};
use crate::measure::channel;
use diffract::render::frame::View;
use diffract::render::picture::{Directions, Painter, Picture};
use diffract::render::reference_picture::reference_picture;
use diffract::render::resources::Pigment;
use diffract::render::shading::Shading;
use diffract::scene::{Light, Scene};
use diffract::surface::HeightField;
use diffract::surface::synth::Kind;
use diffract::vk::device::Device;
use glam::{DVec3, Vec3};
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 72];

fn view_of(scene: &Scene, lights: Vec<Light>) -> View {
    let bounds = scene.mesh.bounds();
    View {
        camera: scene.camera,
        centre: bounds.centre,
        radius: bounds.radius,
        lights,
        base_color: scene.base_color,
        pigment: false,
    }
}

/// A picture with the directions that it shaded.
fn paint(
    device: &Arc<Device>,
    field: &HeightField,
    shading: &Shading,
    scene: &Scene,
    view: &View,
) -> (Picture, Vec<Directions>) {
    let layers = layers(field, shading);
    let mut painter = Painter::new(device, &layers, shading, &scene.mesh, &Pigment::white(), SIZE).unwrap();
    let picture = painter.paint(view, 0.0, DVec3::ZERO).unwrap();
    let directions = (0..view.lights.len()).map(|light| painter.directions(view, light).unwrap()).collect();
    (picture, directions)
}

#[test]
fn a_picture_is_the_reference_picture_within_its_tolerance() {
    let field = patch(Kind::Elaphe, 6.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![
        Light { theta: 45.0, phi: -40.0, intensity: 2.0 },
        Light { theta: 70.0, phi: 60.0, intensity: 0.7 },
    ];
    let view = view_of(&scene, lights);
    with_device(|device| {
        let mut exact: Option<Vec<[f32; 4]>> = None;
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let shading = shading(8.0, tolerance);
            let (picture, directions) = paint(device, &field, &shading, &scene, &view);
            let exact = exact.get_or_insert_with(|| {
                reference_picture(&field, &shading, &view, &directions, &|_, _| Ok(())).unwrap()
            });
            let covered = exact.iter().filter(|p| p[3] == 1.0).count();
            assert!(covered > 1000, "only {covered} pixels are covered");
            let errors = [0, 1, 2].map(|c| channel(&picture.radiance, exact, c));
            eprintln!("picture at {tolerance:e}: {errors:.2?}");
            assert!(errors.iter().all(|&e| e <= tolerance), "{tolerance}: {errors:?}");
            if tolerance < 1e-2 {
                // What must not pass: the light moved by half a degree, and red and blue exchanged.
                let mut moved = view.clone();
                moved.lights[0].theta += 0.5;
                let (wrong, _) = paint(device, &field, &shading, &scene, &moved);
                assert!(channel(&wrong.radiance, exact, 1) > tolerance);
                let swapped: Vec<_> = picture.radiance.iter().map(|p| [p[2], p[1], p[0], p[3]]).collect();
                assert!(channel(&swapped, exact, 0) > tolerance);
            }
        }
    });
}

#[test]
fn an_upright_sphere_is_lit_from_where_the_light_is() {
    let field = patch(Kind::Flat, 4.0);
    let scene = Scene::open("sphere").unwrap();
    let shading = shading(4.0, 1e-1);
    let half = |light: Light| {
        let mut sides = [[0.0f64; 2]; 2];
        with_device(|device| {
            let mut view = view_of(&scene, vec![light]);
            view.base_color = Vec3::ONE;
            let (picture, _) = paint(device, &field, &shading, &scene, &view);
            for (i, p) in picture.radiance.iter().enumerate() {
                let (x, y) = (i % SIZE[0] as usize, i / SIZE[0] as usize);
                sides[0][usize::from(x >= SIZE[0] as usize / 2)] += f64::from(p[1]);
                sides[1][usize::from(y >= SIZE[1] as usize / 2)] += f64::from(p[1]);
            }
        });
        sides
    };
    // The camera looks along +y: +x is to the right, +z is up (row 0 is the top).
    let right = half(Light { theta: 80.0, phi: 0.0, intensity: 1.0 });
    assert!(right[0][1] > 1.5 * right[0][0], "{right:?}");
    let top = half(Light { theta: 0.0, phi: 0.0, intensity: 1.0 });
    assert!(top[1][0] > 1.5 * top[1][1], "{top:?}");
}

#[test]
fn directions_are_unit_vectors_where_the_mesh_covers_and_nothing_elsewhere() {
    let field = patch(Kind::Flat, 4.0);
    let scene = Scene::open("snake").unwrap();
    let view = view_of(&scene, scene.lights.clone());
    with_device(|device| {
        let (picture, directions) = paint(device, &field, &shading(4.0, 1e-1), &scene, &view);
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
    let field = patch(Kind::Elaphe, 6.0);
    let scene = Scene::open("snake").unwrap();
    let view = view_of(&scene, scene.lights.clone());
    let shading = shading(16.0, 1e-1);
    with_device(|device| {
        let (first, _) = paint(device, &field, &shading, &scene, &view);
        let (second, _) = paint(device, &field, &shading, &scene, &view);
        assert!(first == second);
        assert!(first.radiance.iter().flatten().all(|x| x.is_finite()));
    });
}
