//! Scenes of several objects, and the directions of their grooves.

use crate::device::with_device;
use crate::evaluation::{layers, patch, window};
use crate::mean::source;
use diffract::internals::filter::FootprintSizes;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::render::directions::Directions;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::grooves::GrooveDirections;
use diffract::internals::render::object::{ObjectData, ObjectSources, ObjectTextures, objects};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::{Renderer, RendererSettings};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::{Grooves, Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::setup::pigment_alone;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 72];

/// A sphere before a plate that stands behind it, and the ground.
const SCENE: &str = r#"
mesh = "sphere"
surface = "elaphe"
base_color = [0.1, 0.1, 0.3]
ground = [0.5, 0.4, 0.3]
lights = ["50,-60,2", "disc:4deg:30,-100,1"]

[[objects]]
mesh = "plate"
up = "z"
position = [0.9, 1.4, 0.2]
rotation = ["80deg", "0deg", "20deg"]
size = 2.0
surface = "blaze"
grooves = "20deg"
base_color = [0.3, 0.02, 0.02]

[camera]
eye = [0.8, -7.0, 2.2]
target = [0.2, 0.0, 0.0]
field_of_view = "30deg"
"#;

fn optics(reflectance: f64) -> Optics {
    Optics {
        coherence: Coherence::Gaussian { length: 16.0 },
        windows: Windows::All,
        tolerance: 2e-2,
        reflectance: reflectance.into(),
        ..Optics::default()
    }
    .for_pictures()
}

fn scene() -> Scene {
    Scene::parse(SCENE, Path::new("")).unwrap()
}

#[test]
fn each_object_of_a_scene_is_drawn_as_it_would_be_alone_where_nothing_stands_before_it() {
    let scene = scene();
    let view = View::of(&scene, scene.lights.clone());
    let textures = ObjectTextures::of(&scene).unwrap();
    let sample = Sampling { count: 4, seed: 3 }.sample(1);
    let shown = Shown::plain(0.0, DVec3::ZERO);
    with_device(|device| {
        let footprints = FootprintSizes::default();
        // Sources of three kinds: a table, a sum over wavelengths, and none.
        let of_window = Optics { windows: Windows::ONE, tolerance: 1e-1, ..optics(2.0) };
        let shadings = [optics(1.5), of_window, Optics::default()];
        let first =
            source(device, &patch(SurfaceKind::Elaphe, 12.0), &shadings[0], Method::Table, footprints);
        let second = window(&layers(&patch(SurfaceKind::Blaze, 12.0), &shadings[1]));
        let sources = [first, second, pigment_alone()].into_iter().zip(shadings);
        let sources: Vec<_> = sources.map(|(source, optics)| ObjectSources::new(source, optics)).collect();
        let all = objects(&scene, &textures, &sources);
        let mut renderer = Renderer::new(device, &all, SIZE, RendererSettings::default()).unwrap();
        renderer.draw_sample(&view, &sample, shown).unwrap();
        let together = renderer.read_back().unwrap();
        let seen = renderer.directions_of(&view, 0, &sample).unwrap();
        let without = objects(&scene, &textures, std::iter::repeat_n(&sources[2], 3));
        let mut pigments = Renderer::new(device, &without, SIZE, RendererSettings::default()).unwrap();
        pigments.draw_sample(&view, &sample, shown).unwrap();
        let pigments = pigments.read_back().unwrap();
        let (mut counts, mut greens) = ([0; 3], [[0.0; 2]; 3]);
        for (number, object) in all.iter().enumerate() {
            let mut alone = Renderer::new(device, &[*object], SIZE, RendererSettings::default()).unwrap();
            let its_view = View { base_colors: vec![view.base_color(number)], ..view.clone() };
            alone.draw_sample(&its_view, &sample, shown).unwrap();
            let alone = alone.read_back().unwrap();
            for pixel in 0..together.radiance.len() {
                if seen.view[pixel][3] != 0.0 && seen.object(pixel) == number {
                    counts[number] += 1;
                    greens[number][0] += together.radiance[pixel][1];
                    greens[number][1] += pigments.radiance[pixel][1];
                    assert_eq!(together.radiance[pixel], alone.radiance[pixel], "pixel {pixel} of {number}");
                    assert_eq!(together.display[pixel], alone.display[pixel], "pixel {pixel} of {number}");
                }
            }
        }
        eprintln!("pixels of sphere, plate and ground: {counts:?}");
        assert!(counts.iter().all(|&count| count > 300), "{counts:?}");
        // Two of them diffract light on top of what is left to their pigments, at most 1 − ((n − 1)/(n + 1))²; the ground has its pigment alone.
        eprintln!("green, and that of the pigments: {greens:?}");
        let [sphere, plate, ground] = greens.map(|[all, pigment]| all / pigment);
        assert!(
            sphere > 1.01 * 0.96 && plate > 1.01 * 8.0 / 9.0 && ground == 1.0,
            "{sphere}, {plate}, {ground}"
        );
        // Sums of samples and tiles take the same way.
        let sampling = Sampling { count: 3, seed: 3 };
        let whole = renderer.render(&view, &sampling, shown, &Task::silent()).unwrap();
        let again = renderer.render(&view, &sampling, shown, &Task::silent()).unwrap();
        assert!(whole == again && whole.radiance != together.radiance);
    });
}

#[test]
fn objects_cast_shadows_on_each_other_and_on_the_ground_which_casts_none() {
    let mut scene = scene();
    // From before the sphere, and from below the ground.
    scene.lights = vec![Light::point(60.0, -110.0, 2.0), Light::point(150.0, -80.0, 2.0)];
    let view = View::of(&scene, scene.lights.clone());
    let textures = ObjectTextures::of(&scene).unwrap();
    let sources = [(); 3].map(|()| ObjectSources::new(pigment_alone(), Optics::default()));
    with_device(|device| {
        let all = objects(&scene, &textures, &sources);
        let lit = |objects: &[ObjectData<'_>], light: usize| {
            let mut renderer = Renderer::new(device, objects, SIZE, crate::shadows(true)).unwrap();
            renderer.directions(&view, light).unwrap()
        };
        let bright = |seen: &Directions, pixel: usize| seen.light[pixel][2] > 0.0;
        let pixels = |seen: &Directions, number: usize| -> Vec<usize> {
            (0..seen.view.len()).filter(|&i| seen.view[i][3] != 0.0 && seen.object(i) == number).collect()
        };
        let [above, below] = [0, 1].map(|light| lit(&all, light));
        for (number, receiver) in [(1, "plate"), (2, "ground")] {
            let alone = lit(&[all[number]], 0);
            let shadowed = pixels(&above, number).into_iter();
            let shadowed = shadowed.filter(|&i| bright(&alone, i) && !bright(&above, i)).count();
            eprintln!("{shadowed} pixels of the {receiver} are in shadow");
            assert!(shadowed > 50, "{receiver}");
        }
        // Far from what stands on it the ground is lit, also behind the end of the depth map.
        let ground = pixels(&above, 2);
        let share = ground.iter().filter(|&&i| bright(&above, i)).count() as f64 / ground.len() as f64;
        assert!(share > 0.5 && share < 1.0, "{share} of the ground is lit");
        assert!(pixels(&below, 0).iter().any(|&i| bright(&below, i)), "the sphere is lit from below");
    });
}

/// ω_i and ω_r of the pixels of a plate whose patch lies by `grooves`.
fn directions(device: &Arc<Device>, view: &View, grooves: &GrooveDirections) -> Directions {
    let scene = Scene::open("plate").unwrap();
    let source = Source::ClassicalGrating(ClassicalGrating::default());
    let (sources, pigment) = (ObjectSources::new(source, Optics::default()), Pigment::white());
    let object = ObjectData {
        mesh: &scene.main_object().mesh,
        pigment: &pigment,
        grooves,
        casts_shadows: true,
        sources: &sources,
    };
    let mut renderer = Renderer::new(device, &[object], SIZE, RendererSettings::default()).unwrap();
    renderer.directions(view, 0).unwrap()
}

/// `v` in a frame whose x is turned by `angle` \[rad\].
fn turned([x, y, z, _]: [f32; 4], angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    let [x, y, z] = [x, y, z].map(f64::from);
    DVec3::new(cos * x + sin * y, cos * y - sin * x, z)
}

/// The angle of the grooves at a place (u, v), where it is certain \[rad\].
type AngleAt = dyn Fn([f64; 2]) -> Option<f64>;

#[test]
fn grooves_turn_the_directions_about_the_normal_by_an_angle_by_a_map_or_around_the_middle() {
    let scene = Scene::open("plate").unwrap();
    let view = View::of(&scene, vec![Light::point(40.0, 25.0, 1.0)]);
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.png");
    // A quarter of white is a quarter of a turn; the right half stands at 30 degrees.
    let grey = |x: u32, _| image::Luma([if x < 32 { 65535 / 4 } else { 65535 / 12 }]);
    image::ImageBuffer::<_, Vec<u16>>::from_fn(64, 64, grey).save(&map).unwrap();
    let world = view.clip_from_world(SIZE).as_dmat4().inverse();
    let eye = view.camera.eye().as_dvec3();
    let place = |pixel: usize| {
        let clip = diffract::internals::scene::camera::pixel_in_clip(pixel, SIZE);
        let toward = world.project_point3(clip.extend(0.5)) - eye;
        let at = eye - toward * (eye.z / toward.z);
        [at.x + 0.5, at.y + 0.5]
    };
    with_device(|device| {
        let plain = directions(device, &view, GrooveDirections::along());
        let angle_of: [(Grooves, &AngleAt); 3] = [
            (Grooves::Turned(35.0), &|_| Some(35f64.to_radians())),
            (Grooves::Radial, &|[u, v]| {
                let away = (u - 0.5).hypot(v - 0.5);
                (away > 0.02).then(|| (v - 0.5).atan2(u - 0.5))
            }),
            // Beside the edges of the map its neighbours count, too.
            (Grooves::Map(map.clone()), &|[u, _]| {
                let inside = |from: f64, to: f64| u > from + 0.02 && u < to - 0.02;
                let left = inside(0.0, 0.5).then(|| 90f64.to_radians());
                left.or(inside(0.5, 1.0).then(|| 30f64.to_radians()))
            }),
        ];
        for (grooves, angle) in angle_of {
            let found = directions(device, &view, &GrooveDirections::of(&grooves).unwrap());
            let (mut checked, mut worst) = (0, 0f64);
            for pixel in (0..plain.view.len()).filter(|&i| plain.view[i][3] != 0.0) {
                let Some(angle) = angle(place(pixel)) else { continue };
                for (before, after) in
                    [(plain.view[pixel], found.view[pixel]), (plain.light[pixel], found.light[pixel])]
                {
                    worst = worst.max((turned(before, angle) - turned(after, 0.0)).length());
                }
                checked += 1;
            }
            eprintln!("{grooves:?}: {worst:.1e} over {checked} pixels");
            // A map holds 16-bit floats.
            assert!(checked > 1500 && worst < 1e-3, "{grooves:?}: {worst:.1e} over {checked} pixels");
        }
        // Around the middle the directions change faster from pixel to pixel, and footprints know it.
        let radial = directions(device, &view, &GrooveDirections::of(&Grooves::Radial).unwrap());
        let largest =
            |seen: &Directions| seen.footprints.iter().flatten().fold(0f32, |most, d| most.max(d.abs()));
        assert!(largest(&radial) > 3.0 * largest(&plain));
    });
}
