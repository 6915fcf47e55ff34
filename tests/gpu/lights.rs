//! Lights with an extent, surroundings and shadows.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::mean::source;
use crate::measure::colours;
use crate::shared::{self, Pictured};
use diffract::internals::brdf::albedo::Decimation;
use diffract::internals::brdf::mean::MeanBrdf;
use diffract::internals::brdf::tabulated::{SummedOrders, TabulatedMean};
use diffract::internals::filter::{Covariance, FootprintSizes};
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::color::{Tone, xyz_to_linear_srgb};
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::optics::spectrum::{Illuminant, SHORTEST};
use diffract::internals::optics::theory::Theory;
use diffract::internals::render::directions::Directions;
use diffract::internals::render::footprints;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::reference_picture::PixelReference;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::environment::Placement;
use diffract::internals::scene::{Camera, Corner, Environment, FarLight, Lens, Light, Mesh, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::setup::pigment_alone;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

const SHOWN: Shown = Shown { exposure: 0.0, tone: Tone::None, background: DVec3::ZERO };

/// A plate without pigment, looked at from afar, so that all of it is seen from nearly one direction.
fn plate(theta: f32, lights: Vec<Light>, environment: Option<Environment>) -> (Scene, View) {
    const FAR: f32 = 60.0;
    let scene = Scene::open("plate").unwrap();
    let (sin, cos) = theta.sin_cos();
    let mut view = View::of(&scene, lights);
    view.camera =
        Camera::looking(Vec3::new(FAR * sin, 0.0, FAR * cos), Vec3::ZERO, Lens::perspective(0.02)).unwrap();
    view.base_colors = vec![Vec3::ZERO];
    view.environment = environment;
    (scene, view)
}

fn optics(length: f64, reflectance: f64) -> Optics {
    Optics {
        coherence: Coherence::Gaussian { length },
        windows: Windows::All,
        tolerance: 2e-2,
        // Perfect mirrors of steep profiles send most light along the surface by the small-slope approximation, where wide footprints average badly.
        reflectance: Reflectance::from(reflectance).by(Theory::Stam),
        ..Optics::default()
    }
    .for_pictures()
}

/// Mean radiance of the covered pixels for each of `samplings`.
fn radiance(
    device: &Arc<Device>,
    field: &HeightField,
    optics: &Optics,
    (scene, view): &(Scene, View),
    samplings: &[Sampling],
) -> Vec<DVec3> {
    const SIZE: [u32; 2] = [12, 12];
    let source = source(device, field, optics, Method::Table, FootprintSizes::default());
    let mut renderer = crate::renderer_of(device, scene, &source, optics, SIZE).unwrap();
    let mean = |sampling: &Sampling| {
        let picture = renderer.render(view, sampling, SHOWN, &Task::silent()).unwrap();
        let inside = picture.radiance.iter().filter(|p| p[3] == 1.0);
        let (sum, count) = inside.fold((DVec3::ZERO, 0.0), |(sum, count), p| {
            (sum + DVec3::new(p[0].into(), p[1].into(), p[2].into()), count + 1.0)
        });
        assert!(count >= 20.0, "only {count} pixels are covered");
        sum / count
    };
    samplings.iter().map(mean).collect()
}

/// Refractive index of a mirror that reflects everything.
const MIRROR: f64 = 1e9;

#[test]
fn under_a_white_sky_a_surface_that_absorbs_nothing_is_as_bright_as_its_closed_form() {
    let white = Environment::of(&|_| Vec3::ONE);
    let optics = optics(8.0, MIRROR);
    with_device(|device| {
        for (kind, theta) in [(SurfaceKind::Flat, 0.0f64), (SurfaceKind::Blaze, 20.0)] {
            let field = patch(kind, 10.0);
            let scene = plate(theta.to_radians() as f32, Vec::new(), Some(white.clone()));
            let found = radiance(device, &field, &optics, &scene, &[Sampling { count: 512, seed: 0 }])[0];
            let expected = albedo(&field, &optics, theta);
            let apart = (found - expected).length() / expected.length();
            eprintln!("{} at {theta}: {found:.3} for {expected:.3}: {apart:.3}", kind.name());
            if kind == SurfaceKind::Flat {
                // All of the light comes back, by the specular order alone.
                assert!((expected - DVec3::ONE).length() < 0.005 && apart < 0.005, "{found}, {expected}");
                continue;
            }
            // What a sample averages over is projected where the sample is, and not where the order is: all pictures come out lower by twice its
            // variance, 0.015. The rest is the sum of the blurs, which goes up and down from one part of the sky to the next.
            assert!(apart < 0.04, "{} at {theta}: {found} instead of {expected}", kind.name());
        }
    });
}

/// Radiance that changes slowly over directions, in another way for each colour.
fn slow(direction: DVec3) -> Vec3 {
    let d = direction.as_vec3();
    Vec3::new(1.0 + 0.5 * d.x, 1.0 + 0.5 * d.y, 1.0 + 0.3 * d.z + 0.3 * d.x * d.y)
}

#[test]
fn a_flat_mirror_shows_the_surroundings_in_the_mirrored_direction_from_one_sample() {
    let field = patch(SurfaceKind::Flat, 10.0);
    let optics = optics(16.0, MIRROR);
    let lamp = Light::point(10.0, 90.0, 1.0);
    with_device(|device| {
        for (theta, rotation, exposure, lamps) in
            [(0.0f64, 0.0f64, 0.0f64, 0), (40.0, 0.0, 0.0, 1), (60.0, 70.0, 1.0, 2), (75.0, 250.0, -2.0, 3)]
        {
            let mut around = Environment::of(&slow);
            around.placement = Placement::new(rotation, exposure).unwrap();
            let scene = plate(theta.to_radians() as f32, vec![lamp.clone(); lamps], Some(around));
            let found = radiance(device, &field, &optics, &scene, &[Sampling::ONE])[0];
            let (sin, cos) = theta.to_radians().sin_cos();
            // What stood at `direction` before the surroundings were turned.
            let mirrored = DQuat::from_rotation_z(-rotation.to_radians()) * DVec3::new(-sin, 0.0, cos);
            let expected = slow(mirrored).as_dvec3() * exposure.exp2();
            let apart = (found - expected).length() / expected.length();
            eprintln!(
                "from {theta} degrees, beside {lamps} lamps: {found:.4}, {apart:.4} from {expected:.4}"
            );
            // Half of it is the share that colours leave out of 16-bit floats and sums.
            assert!(apart < 0.005, "{found} instead of {expected}");
        }
    });
}

#[test]
fn a_sphere_in_a_studio_is_the_reference_sphere_over_the_same_directions() {
    const SIZE: [u32; 2] = [80, 60];
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let optics = optics(16.0, 1.5);
    let scene = Scene::open("sphere").unwrap();
    let lamp = Light::point(45.0, -40.0, 1.0);
    let mut in_studio = View::of(&scene, vec![lamp]);
    in_studio.environment = Some(Environment::open("studio").unwrap());
    let mut without_lamp = in_studio.clone();
    without_lamp.lights.clear();
    // The light of the window, one of the parts of the studio. Samples of its softboxes and its room err by up to 0.075 by table, each in its own way: the mean of all
    // sixteen errs by 0.016.
    let sampling = Sampling { count: 16, seed: 3 };
    let sample = sampling.sample(1);
    // What is measured, and a fifth or more on top.
    let cases = [(&in_studio, 0.02, 0.08), (&without_lamp, 0.028, 0.4)];
    with_device(|device| {
        let (mesh, white) = (&scene.main_object().mesh, Pigment::white());
        for (view, allowed, least_unmirrored) in cases {
            let (views, lights) = (std::slice::from_ref(view), view.light_count());
            let sizes = footprints::sizes(device, mesh, views, SIZE, &sampling).unwrap();
            let pictured = Pictured { field: &field, optics: &optics, view, size: SIZE };
            let source = source(device, &field, &optics, Method::Table, sizes);
            let mut renderer = crate::renderer(device, &source, &optics, mesh, &white, SIZE).unwrap();
            renderer.draw_sample(view, &sample, SHOWN).unwrap();
            let found = renderer.read_back().unwrap().radiance;
            let seen: Vec<Directions> =
                (0..lights).map(|light| renderer.directions_of(view, light, &sample).unwrap()).collect();
            let mirrored = seen.iter().filter(|s| s.mirrored.len() == s.view.len()).count();
            assert_eq!(mirrored, 1, "the surroundings alone are mirrored");
            let exact = pictured.kept_by(device, &format!("sphere-in-studio-{lights}"), &seen);
            let error = colours(&found, &exact);
            eprintln!("a sphere under {lights} lights: {error:.4}");
            assert!(error < allowed, "{lights} lights: {error}");
            let dark: Vec<Directions> =
                seen.into_iter().map(|s| Directions { mirrored: Vec::new(), ..s }).collect();
            let other = colours(
                &pictured.kept_by(device, &format!("sphere-in-studio-{lights}-unmirrored"), &dark),
                &exact,
            );
            eprintln!("{lights} lights unmirrored: {other:.4}");
            assert!(other > least_unmirrored, "{lights} lights: {other}");
        }
    });
}

#[test]
fn a_pigment_under_wide_lights_is_that_of_the_reference() {
    const SIZE: [u32; 2] = [96, 72];
    let scene = Scene::open("sphere").unwrap();
    let mut view = View::of(&scene, Vec::new());
    view.environment = Some(Environment::open("sky").unwrap());
    view.base_colors = vec![Vec3::new(0.9, 0.5, 0.2)];
    let (optics, sample) = (optics(16.0, 1.5), Sampling { count: 16, seed: 3 }.sample(1));
    with_device(|device| {
        let mut renderer = crate::renderer_of(device, &scene, &pigment_alone(), &optics, SIZE).unwrap();
        renderer.draw_sample(&view, &sample, SHOWN).unwrap();
        let found = renderer.read_back().unwrap().radiance;
        let seen: Vec<Directions> = (0..view.light_count())
            .map(|light| renderer.directions_of(&view, light, &sample).unwrap())
            .collect();
        let exact = shared::shaded(&PixelReference::of_pigment(&optics), &view, &seen, &|_| true);
        let error = colours(&found, &exact);
        eprintln!("a pigment under the sky: {error:.1e}");
        // The rounding of 32-bit floats makes 1.2e-7.
        assert!(error < 1e-5, "{error:e}");
    });
}

/// Linear sRGB of what comes back to `theta` \[degrees\] of light from everywhere, in f64: the sum over a fine lattice of (u, v), where
/// cos θ_i dω_i = du dv, of f itself.
fn albedo(field: &HeightField, optics: &Optics, theta: f64) -> DVec3 {
    let sigma = optics.coherence.sigma().unwrap();
    let reflectance = optics.reflectance.clone();
    let mean = MeanBrdf { field: field.clone(), sigma, beyond: optics.beyond, reflectance };
    let table = TabulatedMean::new(mean, SHORTEST, &Task::silent()).unwrap().limited(Decimation::Coarse);
    let view = direction(theta, 0.0);
    // Fine against the blur of the orders by coherence, λ/(√8 π σ) ≥ 0.02; the lattice adds its own.
    const SIDE: i32 = 160;
    let step = 2.0 / f64::from(SIDE);
    let own = Covariance { uu: step * step, uv: 0.0, vv: step * step };
    let place = |i: i32| (f64::from(i) + 0.5) * step - 1.0;
    let pairs: Vec<(Pair, Covariance)> = (0..SIDE * SIDE)
        .map(|i| (place(i % SIDE), place(i / SIDE)))
        .filter(|(x, y)| x * x + y * y < 1.0)
        .map(|(x, y)| (Pair::new(DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()), view), own))
        .collect();
    let weighted = table.xyz(&Illuminant::D65, &pairs, SummedOrders::All, &Task::silent()).unwrap();
    let sum: DVec3 =
        pairs.iter().zip(weighted).map(|((pair, _), xyz)| xyz / pair.light.z * (step * step)).sum();
    xyz_to_linear_srgb(sum)
}

#[test]
fn a_disc_of_light_is_the_mean_over_its_points() {
    let field = patch(SurfaceKind::Blaze, 10.0);
    let optics = optics(16.0, MIRROR);
    let disc = FarLight::parse("disc:12deg:35,180").unwrap();
    with_device(|device| {
        let scene = plate(0.3, vec![disc.into()], None);
        let samplings = [64, 1024].map(|count| Sampling { count, seed: 5 });
        let found = radiance(device, &field, &optics, &scene, &samplings);
        // In f64, over directions spread evenly within the disc.
        let sigma = optics.coherence.sigma().unwrap();
        let reflectance = optics.reflectance.clone();
        let mean = MeanBrdf { field: field.clone(), sigma, beyond: optics.beyond, reflectance };
        let table = TabulatedMean::new(mean, SHORTEST, &Task::silent()).unwrap().limited(Decimation::Coarse);
        let view = DVec3::new(0.3f64.sin(), 0.0, 0.3f64.cos());
        let centre = direction(disc.theta, disc.phi);
        let edge = (0.5 * disc.size).to_radians().cos();
        let (x, y) = centre.any_orthonormal_pair();
        const POINTS: usize = 4000;
        let pairs: Vec<(Pair, Covariance)> = (0..POINTS)
            .map(|i| {
                // A spiral of equal solid angles.
                const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
                let cosine = 1.0 - (i as f64 + 0.5) / POINTS as f64 * (1.0 - edge);
                let (sin, cos) = (GOLDEN_ANGLE * i as f64).sin_cos();
                let light = centre * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).sqrt();
                (Pair::new(light, view), Covariance::default())
            })
            .collect();
        let sum: DVec3 = table
            .xyz(&Illuminant::D65, &pairs, SummedOrders::All, &Task::silent())
            .unwrap()
            .into_iter()
            .sum();
        let exact = xyz_to_linear_srgb(sum / POINTS as f64) * PI;
        let relative = |f: DVec3| (f - exact).length() / exact.length();
        let errors: Vec<f64> = found.iter().map(|f| relative(*f)).collect();
        eprintln!("a disc: {found:.4?} for {exact:.4}, {errors:.3?}");
        // 64 samples soften the edge of the disc by a quarter of its spread.
        assert!(errors[0] < 0.12 && errors[1] < 0.04, "{found:?} instead of {exact}");
        let point = plate(0.3, vec![FarLight { size: 0.0, ..disc }.into()], None);
        let wrong = radiance(device, &field, &optics, &point, &samplings[..1])[0];
        assert!((wrong - exact).length() > 0.2 * exact.length(), "a point is as good: {wrong}");
    });
}

/// A floor of side 4 around the origin, and a roof of side 2 at `height` over its half x < 0.
pub fn floor_below_a_roof(height: f32) -> Mesh {
    let square = |x: [f32; 2], y: [f32; 2], z: f32| {
        let corner = |i: usize, j: usize| Corner {
            position: [x[i], y[j], z],
            normal: Some([0.0, 0.0, 1.0]),
            uv: Some([x[i], y[j]]),
        };
        [[corner(0, 0), corner(1, 0), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(0, 1)]]
    };
    let floor = square([-2.0, 2.0], [-2.0, 2.0], 0.0);
    let roof = square([-1.0, 0.0], [-1.0, 1.0], height);
    Mesh::from_triangles([floor, roof].concat()).unwrap()
}

/// Brightness of the floor along the line y = 0 below the roof's edge at x = 0, over that without shadows, and the x of each pixel.
pub fn across_the_edge(device: &Arc<Device>, light: Light, height: f32, samples: u32) -> Vec<[f64; 2]> {
    const SIZE: [u32; 2] = [3, 513];
    /// Of the camera, which looks below the roof at 45 degrees.
    const AWAY: f32 = 4.0;
    const FIELD_OF_VIEW: f32 = 0.025;
    let mesh = floor_below_a_roof(height);
    let source = Source::ClassicalGrating(ClassicalGrating::default());
    let mut view = View::of(&Scene::open("plate").unwrap(), vec![light]);
    view.camera =
        Camera::looking(Vec3::new(AWAY, 0.0, AWAY), Vec3::ZERO, Lens::perspective(FIELD_OF_VIEW)).unwrap();
    (view.centre, view.radius) = (mesh.bounds().centre, mesh.bounds().radius);
    view.base_colors = vec![Vec3::ONE];
    let column = |shadows: bool| -> Vec<f64> {
        let optics = Optics { reflectance: 1.0.into(), ..Optics::default() };
        let (object, settings) = ((&mesh, &Pigment::white()), crate::shadows(shadows));
        let mut renderer = crate::renderer_with(device, &source, &optics, object, SIZE, settings).unwrap();
        let sampling = Sampling { count: samples, seed: 2 };
        let picture = renderer.render(&view, &sampling, SHOWN, &Task::silent()).unwrap();
        picture.radiance.iter().skip(1).step_by(3).map(|p| f64::from(p[1])).collect()
    };
    // The picture's top is the far end, x < 0. The floor is seen at 45 degrees.
    let step = f64::from(2.0 * (FIELD_OF_VIEW / 2.0).tan() * AWAY * 2.0) / f64::from(SIZE[1]);
    let x = (0..SIZE[1]).map(|row| (f64::from(row) - 256.0) * step);
    x.zip(column(true).iter().zip(column(false))).map(|(x, (a, b))| [x, a / b.max(1e-9)]).collect()
}

#[test]
fn a_shadow_s_edge_is_as_soft_as_the_light_and_the_height_make_it() {
    with_device(|device| {
        for (size, height) in [(8.0, 0.2f32), (16.0, 0.2), (16.0, 0.1)] {
            let light = FarLight { theta: 0.0, phi: 0.0, intensity: 1.0, size }.into();
            let column = across_the_edge(device, light, height, 256);
            // The part of a disc that an edge leaves free.
            let reach = f64::from(height) * (0.5 * size).to_radians().tan();
            let free = |x: f64| {
                let t = (x / reach).clamp(-1.0, 1.0);
                0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / PI
            };
            let square = column.iter().map(|[x, lit]| (lit - free(*x)).powi(2)).sum::<f64>();
            let rms = (square / column.len() as f64).sqrt();
            eprintln!("{size} degrees, {height} high: {rms:.3}");
            assert!(rms < 0.03, "{size} degrees, {height} high: {rms}: {column:.2?}");
            let (first, last) = (column[0][1], column[column.len() - 1][1]);
            assert!(first < 0.01 && last > 0.99, "{first} to {last}");
        }
    });
}

#[test]
fn convex_meshes_cast_no_shadow_on_themselves() {
    with_device(|device| {
        for name in ["sphere", "plate", "disc"] {
            let scene = Scene::open(name).unwrap();
            let source = Source::ClassicalGrating(ClassicalGrating::default());
            // From afar, and from lamps that do not stand over the middle.
            for light in [
                "0,20",
                "45,20",
                "80,20",
                "89,20",
                "sphere:0.4:0.9,0.3,1.1,30",
                "rectangle:0.3x0.2:-0.9,0.5,0.7,30:0.4,0.1,-1",
                "sphere:0.1:0.2,-1.4,0.6,30",
            ] {
                let mut view = View::of(&scene, vec![Light::parse(light).unwrap()]);
                view.base_colors = vec![Vec3::ONE];
                let paint = |shadows: bool| {
                    let object = (&scene.main_object().mesh, &Pigment::white());
                    let (optics, settings) = (Optics::default(), crate::shadows(shadows));
                    let mut renderer =
                        crate::renderer_with(device, &source, &optics, object, [160, 120], settings).unwrap();
                    renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap().radiance
                };
                let (with, without) = (paint(true), paint(false));
                let largest = without.iter().fold(0.0f32, |m, p| m.max(p[1]));
                assert!(largest > 1e-3, "{name} under {light} is black");
                let apart = with.iter().zip(&without).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
                // Next to the terminator a triangle may be turned away where its interpolated normal is not.
                assert!(apart <= 0.04 * largest, "{name} under {light}: {apart} of {largest}");
            }
        }
    });
}

#[test]
fn a_mesh_that_is_wound_inward_is_as_bright_as_one_that_is_not() {
    with_device(|device| {
        let source = Source::ClassicalGrating(ClassicalGrating::default());
        let corner = |position: [f32; 3]| Corner { position, normal: None, uv: None };
        let [a, b, c] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.5, 0.0]].map(corner);
        let paint = |triangle: [Corner; 3]| {
            let mesh = Mesh::from_triangles(vec![triangle]).unwrap();
            let light = Light::point(40.0, 20.0, 1.0);
            let mut view = View::of(&Scene::open("plate").unwrap(), vec![light]);
            view.camera =
                Camera::looking(Vec3::new(1.0, -1.0, 3.0), Vec3::ZERO, Lens::perspective(0.9)).unwrap();
            (view.centre, view.radius) = (mesh.bounds().centre, mesh.bounds().radius);
            view.base_colors = vec![Vec3::ONE];
            let optics = Optics::default();
            let (object, settings) = ((&mesh, &Pigment::white()), crate::shadows(true));
            let mut renderer =
                crate::renderer_with(device, &source, &optics, object, [40, 30], settings).unwrap();
            renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap().radiance
        };
        let (outward, inward) = (paint([a, b, c]), paint([a, c, b]));
        let lit = outward.iter().filter(|p| p[1] > 0.1).count();
        assert!(lit > 100, "only {lit} pixels are lit");
        let apart = outward.iter().zip(&inward).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-5, "{apart}");
    });
}

#[test]
fn no_single_sample_at_a_silhouette_outshines_all_others() {
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, scene.lights.clone());
    let optics = optics(65.0, 1.5);
    with_device(|device| {
        const SIZE: [u32; 2] = [160, 90];
        let sizes = FootprintSizes { shorter: 0.01, longer: 0.03 };
        let source = source(device, &field, &optics, Method::Table, sizes);
        let mut renderer = crate::renderer_of(device, &scene, &source, &optics, SIZE).unwrap();
        let [few, more, most] = [16, 64, 256].map(|count| {
            let sampling = Sampling { count, seed: 1 };
            renderer.render(&view, &sampling, SHOWN, &Task::silent()).unwrap().radiance
        });
        let (few, more) = (colours(&few, &most), colours(&more, &most));
        eprintln!("the snake from 16 samples differs from 256 by {few:.3}, from 64 by {more:.3}");
        // What edges and highlights leave, and two fifths on top. Without a bound on 1/cos of the viewer it is 0.71 and 0.29.
        assert!(few < 0.4 && more < 0.2, "{few}, {more}");
    });
}
