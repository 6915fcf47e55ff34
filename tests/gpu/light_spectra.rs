//! Lights with spectra of their own.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::mean::source;
use crate::shared::Pictured;
use diffract::internals::filter::FootprintSizes;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::color::xyz_to_linear_srgb;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::object::{ObjectSource, ObjectSources, ObjectTextures, objects};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::{Renderer, RendererSettings};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::setup::pigment_alone;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::vk::device::Device;
use glam::{DVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [72, 54];

/// A sphere and a plate under daylight, a tungsten lamp and an LED, each from another side.
const SCENE: &str = r#"
mesh = "sphere"
surface = "elaphe"
base_color = [0.1, 0.1, 0.3]
lights = ["50,-60,2", "30,-100,1@a", "sphere:0.4:2,-2,2@led"]

[[objects]]
mesh = "plate"
up = "z"
position = [0.9, 1.4, 0.2]
rotation = ["80deg", "0deg", "20deg"]
size = 2.0
base_color = [0.3, 0.2, 0.1]

[camera]
eye = [0.8, -7.0, 2.2]
target = [0.2, 0.0, 0.0]
field_of_view = "30deg"
"#;

fn optics(illuminant: Illuminant) -> Optics {
    Optics {
        coherence: Coherence::Gaussian { length: 16.0 },
        windows: Windows::All,
        tolerance: 2e-2,
        illuminant,
        ..Optics::default()
    }
    .for_pictures()
}

/// `field` by `method` under the first of `illuminants`, and under the others where lights have them.
fn sources(
    device: &Arc<Device>,
    field: &HeightField,
    method: Method,
    illuminants: &[Illuminant],
) -> ObjectSources {
    let mut all = illuminants.iter().map(|illuminant| {
        let optics = optics(illuminant.clone());
        let source = source(device, field, &optics, method, FootprintSizes::default());
        ObjectSource { source, optics }
    });
    ObjectSources { first: all.next().unwrap(), under: all.collect() }
}

fn dark(illuminants: &[Illuminant]) -> ObjectSources {
    let mut all = illuminants
        .iter()
        .map(|illuminant| ObjectSource { source: pigment_alone(), optics: optics(illuminant.clone()) });
    ObjectSources { first: all.next().unwrap(), under: all.collect() }
}

#[test]
fn lights_of_several_spectra_add_up_to_pictures_under_each_alone() {
    let scene = Scene::parse(SCENE, Path::new("")).unwrap();
    let textures = ObjectTextures::of(&scene).unwrap();
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let every = [Illuminant::D65, Illuminant::A, Illuminant::Led];
    let sample = Sampling { count: 4, seed: 3 }.sample(1);
    let shown = Shown::plain(0.0, DVec3::ZERO);
    with_device(|device| {
        for method in [Method::Table] {
            // Pictures of `lights`, where the objects are shaded from `sources`.
            let picture = |lights: Vec<Light>, sources: [ObjectSources; 2]| {
                let view = View::of(&scene, lights);
                let all = objects(&scene, &textures, &sources);
                let mut renderer = Renderer::new(device, &all, SIZE, RendererSettings::default()).unwrap();
                renderer.draw_sample(&view, &sample, shown).unwrap();
                renderer.read_back().unwrap().radiance
            };
            let of = |illuminants: &[Illuminant]| {
                [sources(device, &field, method, illuminants), dark(illuminants)]
            };
            let together = picture(scene.lights.clone(), of(&every));
            // A light that is dark keeps the places of the others in the sequence of samples.
            let alone = |number: usize| {
                let mut lights = scene.lights.clone();
                for (other, light) in lights.iter_mut().enumerate() {
                    light.spectrum = None;
                    if other != number {
                        let text = if light.is_lamp() { "sphere:0.4:2,-2,2,1e-9" } else { "89.9,0,1e-9" };
                        *light = Light::parse(text).unwrap();
                    }
                }
                picture(lights, of(&every[number..=number]))
            };
            let alone = [0, 1, 2].map(alone);
            let brightest = together.iter().map(|p| p[1]).fold(0f32, f32::max);
            let mut covered = 0;
            for (pixel, found) in together.iter().enumerate() {
                assert_eq!(found[3], alone[0][pixel][3]);
                covered += usize::from(found[3] > 0.0);
                for c in 0..3 {
                    let sum: f32 = alone.iter().map(|picture| picture[pixel][c]).sum();
                    assert!(
                        (found[c] - sum).abs() < 1e-5 * brightest,
                        "{method:?}, pixel {pixel}: {found:?}, {:?}",
                        alone.each_ref().map(|picture| picture[pixel])
                    );
                }
            }
            let red = |picture: &[[f32; 4]]| {
                let sum = |c: usize| picture.iter().map(|p| p[c]).sum::<f32>();
                sum(0) / sum(2)
            };
            let [daylight, tungsten, led] = alone.each_ref().map(|picture| red(picture));
            eprintln!("{method:?}: {covered} pixels; red over blue {daylight}, {tungsten}, {led}");
            assert!(covered > 800 && tungsten > 3.0 * daylight && led > 1.2 * daylight);
        }
    });
}

#[test]
fn a_light_with_the_spectrum_of_the_scene_is_a_light_without_one() {
    let scene = Scene::parse(SCENE, Path::new("")).unwrap();
    let textures = ObjectTextures::of(&scene).unwrap();
    with_device(|device| {
        let sources = [dark(&[Illuminant::D65]), dark(&[Illuminant::D65])];
        let all = objects(&scene, &textures, &sources);
        let mut renderer = Renderer::new(device, &all, SIZE, RendererSettings::default()).unwrap();
        let mut picture = |spectra: [&str; 3]| {
            let texts = ["50,-60,2", "30,-100,1", "sphere:0.4:2,-2,2"];
            let light = |(text, spectrum)| Light::parse(&format!("{text}{spectrum}")).unwrap();
            let view = View::of(&scene, texts.into_iter().zip(spectra).map(light).collect());
            renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap()
        };
        let without = picture([""; 3]);
        assert_eq!(picture(["@d65"; 3]), without);
        // Those that nothing is prepared for, too.
        assert_eq!(picture(["@a", "@led", ""]), without);
    });
}

#[test]
fn a_white_surface_has_the_white_of_the_light() {
    let scene = Scene::open("plate").unwrap();
    with_device(|device| {
        for illuminant in [Illuminant::D65, Illuminant::A, Illuminant::E, Illuminant::Led] {
            let optics = Optics { reflectance: 1.0.into(), ..optics(illuminant.clone()) };
            let pigment = Pigment::white();
            let mut renderer =
                crate::renderer(device, &pigment_alone(), &optics, &scene.main_object().mesh, &pigment, SIZE)
                    .unwrap();
            let lights = vec![Light::point(0.0, 0.0, 2.0)];
            let view = View { base_colors: vec![Vec3::ONE], ..View::of(&scene, lights) };
            let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            let white = xyz_to_linear_srgb(illuminant.white()) * 2.0;
            let mut covered = 0;
            for pixel in picture.radiance.iter().filter(|pixel| pixel[3] > 0.0) {
                covered += 1;
                let found = DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
                assert!(
                    (found - white).abs().max_element() < 1e-5 * white.max_element(),
                    "{illuminant:?}: {found}, {white}"
                );
            }
            assert!(covered > 500);
        }
    });
}

#[test]
fn pictures_under_several_spectra_are_those_of_the_reference() {
    let field = patch(SurfaceKind::Elaphe, 10.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = ["45,-40,2@a", "60,60,1", "30,170,1@led"].map(|text| Light::parse(text).unwrap());
    let view = View::of(&scene, lights.to_vec());
    let every = [Illuminant::D65, Illuminant::A, Illuminant::Led];
    let optics = optics(Illuminant::D65);
    let textures = ObjectTextures::of(&scene).unwrap();
    with_device(|device| {
        for (method, most) in [(Method::Table, 2e-2)] {
            let sources = [sources(device, &field, method, &every)];
            let all = objects(&scene, &textures, &sources);
            let mut renderer = Renderer::new(device, &all, SIZE, RendererSettings::default()).unwrap();
            let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            let seen: Vec<_> = (0..3).map(|light| renderer.directions(&view, light).unwrap()).collect();
            let pictured = Pictured { field: &field, optics: &optics, view: &view, size: SIZE };
            let exact = pictured.kept_by(device, "sphere-under-three-spectra", &seen);
            let (mut difference, mut whole) = (0.0, 0.0);
            for (found, exact) in picture.radiance.iter().zip(&exact) {
                for c in 0..3 {
                    difference += f64::from(found[c] - exact[c]).powi(2);
                    whole += f64::from(exact[c]).powi(2);
                }
            }
            let error = (difference / whole).sqrt();
            eprintln!("{method:?}: {error:.4}");
            assert!(error < most, "{method:?}: {error}");
        }
    });
}
