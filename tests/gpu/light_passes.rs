//! Pictures under several lights, which are drawn together.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::mean::{optics, source};
use crate::measure::colours;
use diffract::internals::filter::FootprintSizes;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::scene::{Environment, Light, Scene};
use diffract::internals::settings::Method;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use glam::{DVec3, Vec3};

const SIZE: [u32; 2] = [48, 36];
const SHOWN: Shown = Shown::plain(0.0, DVec3::ZERO);

/// A picture whose colours are the sum of those of `pictures`, and whose alpha is that of the first.
fn sum(pictures: &[Vec<[f32; 4]>]) -> Vec<[f32; 4]> {
    let pixel = |i: usize| {
        let channel = |c: usize| pictures.iter().map(|picture| picture[i][c]).sum();
        [channel(0), channel(1), channel(2), pictures[0][i][3]]
    };
    (0..pictures[0].len()).map(pixel).collect()
}

/// Pictures under each light of `view` alone, and under all of them.
fn alone_and_together(view: &View, alone: Sampling, together: Sampling) -> [Vec<[f32; 4]>; 2] {
    let scene = Scene::open("sphere").unwrap();
    let (field, optics) = (patch(SurfaceKind::Bumps, 2.0), optics(8.0, 2e-2).for_pictures());
    let mut pictures = None;
    with_device(|device| {
        let sizes = FootprintSizes { shorter: 1e-2, longer: 1e-2 };
        let source = source(device, &field, &optics, Method::Table, sizes);
        let mesh = (&scene.main_object().mesh, &Pigment::white());
        let mut renderer =
            crate::renderer_with(device, &source, &optics, mesh, SIZE, crate::shadows(true)).unwrap();
        let mut paint = |view: &View, sampling: &Sampling| {
            renderer.render(view, sampling, SHOWN, &Task::silent()).unwrap().radiance
        };
        let under = |lights: &[Light], environment: &Option<Environment>| View {
            lights: lights.to_vec(),
            environment: environment.clone(),
            ..view.clone()
        };
        let lights = view.lights.chunks(1).map(|light| under(light, &None));
        let around = view.environment.is_some().then(|| under(&[], &view.environment));
        let each: Vec<_> = lights.chain(around).map(|view| paint(&view, &alone)).collect();
        pictures = Some([sum(&each), paint(view, &together)]);
    });
    pictures.unwrap()
}

fn sphere(lights: &[&str]) -> View {
    let lights = lights.iter().map(|text| Light::parse(text).unwrap()).collect();
    let mut view = View::of(&Scene::open("sphere").unwrap(), lights);
    view.base_colors = vec![Vec3::new(0.3, 0.2, 0.1)];
    view
}

#[test]
fn one_sample_under_any_number_of_lights_is_the_sum_over_each() {
    // More than a pass has, and lamps among distant lights. The only sample of a square is its middle, whatever its number.
    let lights = [
        ["40,-97,1", "20,10,0.5", "70,200,1", "sphere:0.5:2,-1,2", "35,-50,2"],
        ["80,20,0.7", "0,0,0.1", "60,120,0.3", "50,300,0.8", "rectangle:0.3x0.3:0,-3,2"],
    ]
    .concat();
    let [each, all] = alone_and_together(&sphere(&lights), Sampling::ONE, Sampling::ONE);
    let error = colours(&all, &each);
    eprintln!("one sample under {} lights: {error:.1e}", lights.len());
    // The rounding of 32-bit sums.
    assert!(error < 1e-6, "{error}");
    assert!(all.iter().zip(&each).all(|(a, b)| a[3] == b[3]), "coverage depends on the lights");
}

#[test]
fn surroundings_that_few_samples_draw_are_as_bright_as_alone() {
    let mut view = sphere(&["40,-97,1", "sphere:0.5:2,-1,2"]);
    view.environment = Some(Environment::open("sky").unwrap());
    // 16 groups of four samples, and a rest.
    let together = Sampling { count: 66, seed: 3 };
    assert!(view.schedule(&together).after(0).samples == 4, "all samples draw all lights");
    let [each, all] = alone_and_together(&view, Sampling { count: 256, seed: 4 }, together);
    let total = |picture: &[[f32; 4]]| picture.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let (error, energy) = (colours(&all, &each), total(&all) / total(&each));
    eprintln!("two lights below a sky: {error:.4}, energy {energy:.4}");
    // 1.002 and 0.056 are measured: two pictures of few samples each, with other jitter. Surroundings of a quarter of their light would be far off.
    assert!((energy - 1.0).abs() < 0.01, "{energy}");
    assert!(error < 0.1, "{error}");
    let coverage = |picture: &[[f32; 4]]| picture.iter().map(|p| f64::from(p[3])).sum::<f64>();
    assert!((coverage(&all) / coverage(&each) - 1.0).abs() < 2e-3);
    assert!(all.iter().all(|p| p[3] <= 1.0));
}
