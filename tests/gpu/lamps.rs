//! Lamps: lights that stand in the scene.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::lights::{across_the_edge, floor_below_a_roof};
use crate::mean::{optics, source};
use crate::measure::colours;
use crate::shared::Pictured;
use diffract::internals::optics::color::Tone;
use diffract::internals::render::footprints::sizes_of;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::light_passes::LightPass;
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::reference_picture::displayed_of;
use diffract::internals::render::renderer::{PictureRequest, RendererSettings};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::environment::Placement;
use diffract::internals::scene::{Camera, Emitter, Environment, Lamp, Lens, Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [40, 30];
const SHOWN: Shown = Shown { exposure: 0.0, tone: Tone::None, background: DVec3::ZERO };

/// A white floor at z = 0 without a roof above what is seen, under `lights`.
fn floor(lights: Vec<Light>) -> (diffract::internals::scene::Mesh, View) {
    let mesh = floor_below_a_roof(0.5);
    let mut view = View::of(&Scene::open("plate").unwrap(), lights);
    view.camera =
        Camera::looking(Vec3::new(1.9, 0.4, 2.0), Vec3::new(1.0, 0.2, 0.0), Lens::perspective(0.4)).unwrap();
    (view.centre, view.radius) = (mesh.bounds().centre, mesh.bounds().radius);
    view.base_colors = vec![Vec3::ONE];
    (mesh, view)
}

/// The point of the floor that pixel number `i` sees.
fn point(view: &View, i: usize) -> DVec3 {
    let world = view.clip_from_world(SIZE).as_dmat4().inverse();
    let place = [i % SIZE[0] as usize, i / SIZE[0] as usize];
    let [x, y] = [0, 1].map(|axis| (place[axis] as f64 + 0.5) / f64::from(SIZE[axis]) * 2.0 - 1.0);
    let eye = view.camera.eye().as_dvec3();
    let toward = world.project_point3(DVec3::new(x, y, 0.5)) - eye;
    eye - toward * (eye.z / toward.z)
}

#[test]
fn pixels_see_a_lamp_where_it_stands_and_as_bright_as_its_distance_makes_it() {
    let texts = ["sphere:0.4:0.5,-0.3,1.2,30", "30,60", "rectangle:0.6x0.2:1.5,1,0.8,20:1,0,0"];
    with_device(|device| {
        for (count, around) in [(1, false), (2, false), (3, false), (2, true)] {
            let lights = texts[..count].iter().map(|text| Light::parse(text).unwrap()).collect();
            let (mesh, mut view) = floor(lights);
            view.environment = around.then(|| Environment::open("studio").unwrap());
            let source = Source::ClassicalGrating(ClassicalGrating::default());
            let optics = Optics::default();
            let lights = view.light_count();
            assert_eq!(lights, count + usize::from(around));
            let settings = RendererSettings { specular_spread: Some(1e-4), ..RendererSettings::default() };
            let object = (&mesh, &Pigment::white());
            let mut renderer =
                crate::renderer_with(device, &source, &optics, object, SIZE, settings).unwrap();
            let sample = Sampling { count: 16, seed: 3 }.sample(5);
            let still = diffract::internals::render::sampling::Sample { jitter: [0.0; 2], ..sample };
            for number in 0..lights {
                let incident = view.incidents(&LightPass::of_all(number, still))[0];
                let seen = renderer.directions_of(&view, number, &still).unwrap();
                for (i, found) in seen.light.iter().enumerate().filter(|(_, found)| found[3] == 1.0) {
                    let at = point(&view, i);
                    let (toward, falloff) = match incident.place {
                        Some(place) => ((place.point - at).normalize(), place.falloff(at)),
                        None => (incident.direction, 1.0),
                    };
                    let direction = Vec3::new(found[0], found[1], found[2]).as_dvec3();
                    assert!((direction - toward).length() < 2e-4, "{number} at {at}: {direction}, {toward}");
                    let found = seen.irradiance(i) / incident.irradiance.as_dvec3();
                    assert!((found - falloff).abs().max_element() < 2e-3 * falloff, "{number} at {at}");
                }
            }
        }
    });
}

#[test]
fn a_white_floor_is_as_bright_as_closed_forms_say() {
    with_device(|device| {
        for text in ["sphere:0.6:0.9,0.3,1.1,30", "rectangle:0.8x0.4:0.6,0.2,0.9,20:1,0.1,0"] {
            let light = Light::parse(text).unwrap();
            let Emitter::Lamp(lamp) = light.emitter else { panic!() };
            let (mesh, view) = floor(vec![light]);
            let optics = Optics { reflectance: 1.0.into(), ..Optics::default() };
            let source = Source::ClassicalGrating(ClassicalGrating::default());
            let mut renderer =
                crate::renderer(device, &source, &optics, &mesh, &Pigment::white(), SIZE).unwrap();
            let sampling = Sampling { count: 256, seed: 4 };
            let picture = renderer.render(&view, &sampling, SHOWN, &Task::silent()).unwrap();
            for i in [0, 20, 15 * 40 + 20, 29 * 40 + 39] {
                let (found, exact) = (f64::from(picture.radiance[i][1]), brightness(&lamp, point(&view, i)));
                eprintln!("{text}: {found:.4}, {exact:.4}");
                assert!((found / exact - 1.0).abs() < 0.015, "{text} at pixel {i}: {found}, {exact}");
            }
        }
    });
}

#[test]
fn a_white_floor_is_white_under_discs_and_under_any_number_of_samples_of_white_surroundings() {
    let white = |text: &str| {
        let (mesh, mut view) =
            floor(text.split_whitespace().map(|light| Light::parse(light).unwrap()).collect());
        view.environment = text.is_empty().then(|| Environment::of(&|_| Vec3::ONE));
        (mesh, view)
    };
    with_device(|device| {
        let optics = Optics { reflectance: 1.0.into(), ..Optics::default() };
        let source = Source::ClassicalGrating(ClassicalGrating::default());
        // Deviations are small: parts of the surroundings at one height light a floor that faces up equally.
        for (text, count, spread) in [
            ("disc:60deg:0,0,1", 1, 1e-6),
            ("disc:60deg:0,0,1", 16, 1e-6),
            ("disc:120deg:0,0,1", 64, 1e-6),
            ("", 1, 1e-6),
            ("", 2, 0.01),
            ("", 4, 0.01),
            ("", 16, 0.01),
            ("", 64, 0.01),
        ] {
            let (mesh, view) = white(text);
            let mut renderer =
                crate::renderer(device, &source, &optics, &mesh, &Pigment::white(), SIZE).unwrap();
            let picture =
                renderer.render(&view, &Sampling { count, seed: 4 }, SHOWN, &Task::silent()).unwrap();
            let pixels = picture.radiance.iter().map(|pixel| f64::from(pixel[1]));
            let number = picture.radiance.len() as f64;
            let mean = pixels.clone().sum::<f64>() / number;
            let deviation = (pixels.map(|pixel| (pixel - mean).powi(2)).sum::<f64>() / number).sqrt();
            eprintln!("'{text}', {count} samples: {mean:.4} ± {deviation:.4}");
            assert!((mean - 1.0).abs() < 0.01 && deviation < spread, "'{text}', {count} samples");
        }
    });
}

/// Irradiance over π at `at` of a floor that faces up: of a sphere L r² cos θ/D², of a rectangle as a sum over its area.
fn brightness(lamp: &Lamp, at: DVec3) -> f64 {
    use diffract::internals::scene::lamp::{LampShape, Strength};
    let Strength::Radiance(radiance) = lamp.strength else { panic!() };
    match lamp.shape {
        LampShape::Sphere { diameter } => {
            let to = lamp.middle - at;
            radiance * (0.5 * diameter).powi(2) * to.z / to.length().powi(3)
        }
        LampShape::Rectangle { size, faces } => {
            let normal = (faces.unwrap() - lamp.middle).normalize();
            let across = DVec3::Z.cross(normal).normalize();
            let up = normal.cross(across);
            const SIDE: usize = 200;
            let place = |i: usize, side: f64| ((i as f64 + 0.5) / SIDE as f64 - 0.5) * side;
            let points = (0..SIDE * SIDE).map(|i| {
                let to = lamp.middle + across * place(i % SIDE, size[0]) + up * place(i / SIDE, size[1]) - at;
                to.z * -to.dot(normal) / to.length().powi(4)
            });
            radiance * size[0] * size[1] / (SIDE * SIDE) as f64 * points.sum::<f64>() / PI
        }
    }
}

#[test]
fn the_edge_of_a_lamp_s_shadow_is_as_soft_as_the_lamp_is_wide() {
    with_device(|device| {
        for (diameter, above, height) in [(0.4, 2.0, 0.2f32), (0.6, 1.0, 0.1), (0.3, 6.0, 0.4)] {
            let light = Light::parse(&format!("sphere:{diameter}:0,0,{above}")).unwrap();
            let column = across_the_edge(device, light, height, 256);
            let height = f64::from(height);
            // The part of the disc that the edge of the roof leaves free.
            let reach = 0.5 * diameter * height / (above - height);
            let free = |x: f64| {
                let t = (x / reach).clamp(-1.0, 1.0);
                0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / PI
            };
            let square = column.iter().map(|[x, lit]| (lit - free(*x)).powi(2)).sum::<f64>();
            let rms = (square / column.len() as f64).sqrt();
            eprintln!("{diameter} wide, {above} above, roof at {height}: {rms:.3}");
            assert!(rms < 0.03, "{diameter} wide, {above} above: {rms}: {column:.2?}");
        }
    });
}

#[test]
fn pictures_under_a_lamp_are_those_of_the_reference() {
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = ["sphere:0.4:0.5,-2,2", "rectangle:1x0.3:-2,0,1.5"].map(|text| Light::parse(text).unwrap());
    let view = View::of(&scene, lights.to_vec());
    let optics = optics(16.0, 2e-2).for_pictures();
    with_device(|device| {
        let probe = Source::ClassicalGrating(ClassicalGrating::default());
        let size = [160, 120];
        let new = |source: &Source| crate::renderer_of(device, &scene, source, &optics, size).unwrap();
        let mut found = new(&probe);
        let sample = Sampling { count: 16, seed: 3 }.sample(6);
        let seen = [0, 1].map(|light| found.directions_of(&view, light, &sample).unwrap());
        let pictured = Pictured { field: &field, optics: &optics, view: &view, size };
        let exact = pictured.kept_by(device, "sphere-below-lamps", &seen);
        let source = source(device, &field, &optics, Method::Table, sizes_of(&seen));
        let mut renderer = new(&source);
        renderer.draw_sample(&view, &sample, SHOWN).unwrap();
        let error = colours(&renderer.read_back().unwrap().radiance, &exact);
        eprintln!("a sphere below two lamps: {error:.4}");
        assert!(error < 0.02, "{error}");
    });
}

#[test]
fn surroundings_are_displayed_where_the_mesh_does_not_cover_them() {
    use diffract::internals::optics::color::display_over;
    let scene = Scene::open("sphere").unwrap();
    let mut view = View::of(&scene, scene.lights[..1].to_vec());
    // Waves in all directions: a background that is moved by half a pixel is another.
    let mut waves = Environment::of(&|d| (30.0 * d).map(f64::sin).as_vec3() * 0.4 + 0.5);
    waves.placement = Placement::new(70.0, 0.5).unwrap();
    view.environment = Some(waves);
    view.shows_surroundings = true;
    // Bright, so that what stands before the surroundings counts.
    view.base_colors = vec![Vec3::ONE];
    let optics = Optics::default();
    let source = Source::ClassicalGrating(ClassicalGrating::default());
    let size = [160, 120];
    let shown = Shown { exposure: -1.0, tone: Tone::Neutral, background: DVec3::ZERO };
    with_device(|device| {
        let mut renderer = crate::renderer_of(device, &scene, &source, &optics, size).unwrap();
        let mut one_sample = None;
        for count in [1, 2, 8] {
            let sampling = Sampling { count, seed: 1 };
            let picture = renderer.render(&view, &sampling, shown, &Task::silent()).unwrap();
            let expected = displayed_of(&view, size, &picture.radiance, shown);
            // However many samples the foreground has, the background is seen at the pixel centres.
            let first = one_sample.get_or_insert_with(|| picture.clone());
            let pixels =
                picture.radiance.iter().zip(&picture.display).zip(first.radiance.iter().zip(&first.display));
            let uncovered = pixels.filter(|((one, _), (other, _))| one[3] == 0.0 && other[3] == 0.0);
            let differences = uncovered.flat_map(|((_, one), (_, other))| {
                one.iter().zip(other).map(|(one, other)| one.abs_diff(*other))
            });
            let moved = differences.max().unwrap();
            // Directions differ in their last bits, and codes are rounded.
            assert!(moved <= 1, "{count} samples: the background differs by {moved} codes");
            let (mut apart, mut behind) = (0, 0);
            // Covered by less than a whole sample, and of those the ones that are apart.
            let mut thin = [0, 0];
            for ((radiance, found), expected) in picture.radiance.iter().zip(&picture.display).zip(&expected)
            {
                behind += usize::from(radiance[3] == 0.0 && found[..3] != [0, 0, 0]);
                // The device has 32-bit floats, and codes are rounded.
                let is_apart = found.iter().zip(expected).any(|(a, b)| a.abs_diff(*b) > 1);
                apart += usize::from(is_apart);
                if radiance[3] > 0.0 && radiance[3] * (count as f32) < 1.0 {
                    thin = [thin[0] + 1, thin[1] + usize::from(is_apart)];
                }
            }
            eprintln!("{count} samples: {apart} apart, {thin:?} covered by less than one");
            // Two samples lie close to the middle of the pixel and have weight for it alone.
            assert!(count <= 2 || thin[0] > 100, "{count} samples: {} pixels of less than one", thin[0]);
            assert!(50 * thin[1] <= thin[0], "{count} samples: {thin:?} pixels of less than one are others");
            assert!(behind > 4000, "{count} samples: {behind} pixels of the surroundings");
            assert!(apart < expected.len() / 500, "{count} samples: {apart} pixels are others");
            // A picture of another view that is given up changes nothing of what is shown.
            let elsewhere = Camera { phi: view.camera.phi + 1.0, ..view.camera };
            let other = View { camera: elsewhere, ..view.clone() };
            let never = Task::while_true(|_| false);
            let given_up = renderer.draw(&PictureRequest::one_sample(&other, size, shown), &never);
            assert!(given_up.is_err_and(|e| e.is_cancelled()));
            assert!(renderer.display(size, shown).unwrap());
            let again = renderer.read_back().unwrap();
            let codes = again.display.iter().flatten().zip(picture.display.iter().flatten());
            let moved = codes.map(|(one, other)| one.abs_diff(*other)).max().unwrap();
            assert!(
                again.radiance == picture.radiance && moved <= 1,
                "another view is behind {count} samples"
            );
            // Before a colour again.
            let plain = View { shows_surroundings: false, ..view.clone() };
            let picture = renderer.render(&plain, &sampling, shown, &Task::silent()).unwrap();
            let black = display_over(DVec3::ZERO, 0.0, Tone::None, 0.0, DVec3::ZERO);
            let uncovered = picture.radiance.iter().zip(&picture.display).filter(|(r, _)| r[3] == 0.0);
            assert!(uncovered.map(|(_, code)| [code[0], code[1], code[2]]).all(|code| code == black));
        }
    });
}
