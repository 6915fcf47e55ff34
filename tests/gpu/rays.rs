//! The geometry pass against rays cast in f64: directions, coverage, footprints, shadows, and whole pictures.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::mean::source;
use crate::measure::colours;
use diffract::optics::coherence::{Coherence, Windows};
use diffract::render::directions::Directions;
use diffract::render::footprints::sizes_of;
use diffract::render::frame::{Shown, View};
use diffract::render::grooves::GrooveDirections;
use diffract::render::light_passes::LightPass;
use diffract::render::object::{ObjectData, ObjectSources};
use diffract::render::picture::Painter;
use diffract::render::pigment::Pigment;
use diffract::render::rays::{RayObject, RayScene, RaySettings};
use diffract::render::reference_picture::{ReferenceObject, ReferenceSamples, reference_mean};
use diffract::render::sampling::Sampling;
use diffract::render::shading::Shading;
use diffract::render::source::{ClassicalGrating, Source};
use diffract::scene::{Camera, Environment, Grooves, Light, Mesh, Scene};
use diffract::setup::Method;
use diffract::surface::synth::SurfaceKind;
use diffract::vk::device::Device;
use glam::{DVec2, DVec3, Vec3};
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 72];
const SHOWN: Shown = Shown::plain(0.0, DVec3::ZERO);

/// Mesh with grooves in a view.
struct Case {
    name: &'static str,
    mesh: Mesh,
    grooves: GrooveDirections,
    view: View,
    shadows: bool,
}

impl Case {
    /// The built-in scene `name` under `lights`.
    fn new(name: &'static str, lights: &[&str]) -> Self {
        let scene = Scene::open(name).unwrap();
        let lights = lights.iter().map(|text| Light::parse(text).unwrap()).collect();
        let view = View::of(&scene, lights);
        let grooves = GrooveDirections::of(&scene.grooves).unwrap();
        Self { name, mesh: scene.mesh, grooves, view, shadows: false }
    }

    fn object(&self) -> RayObject<'_> {
        RayObject { mesh: &self.mesh, grooves: &self.grooves, casts_shadows: true }
    }

    /// Painter of the directions, with all data beside them.
    fn painter(&self, device: &Arc<Device>) -> Painter {
        let source = Source::ClassicalGrating(ClassicalGrating::default());
        let (sources, pigment) = (ObjectSources::new(source, Shading::default()), Pigment::white());
        let object = ObjectData {
            mesh: &self.mesh,
            pigment: &pigment,
            grooves: &self.grooves,
            base_color: None,
            casts_shadows: true,
            sources: &sources,
        };
        let mut painter = Painter::of_objects(device, &[object], SIZE).unwrap();
        painter.ask_for_footprints().unwrap();
        if self.shadows {
            painter.cast_shadows().unwrap();
        }
        painter
    }

    fn settings(&self) -> RaySettings {
        RaySettings { size: SIZE, footprints: true, shadows: self.shadows, specular_spread: None }
    }
}

/// Differences between two sets of directions, each sorted. Directions in radians.
#[derive(Debug, Default)]
struct Differences {
    /// Pixels that one covers and the other does not.
    coverage: usize,
    /// Pixels whose light reaches one and not the other.
    shadow: usize,
    view: Vec<f64>,
    light: Vec<f64>,
    /// ‖J − J'‖/‖J'‖ of ∂(u, v)/∂(pixel).
    footprint: Vec<f64>,
    /// Relative.
    falloff: Vec<f64>,
}

fn direction([x, y, z, _]: [f32; 4]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

fn differences(found: &Directions, exact: &Directions) -> Differences {
    let mut all = Differences::default();
    for i in 0..exact.view.len() {
        if found.view[i][3] != exact.view[i][3] {
            all.coverage += 1;
            continue;
        }
        if exact.view[i][3] == 0.0 {
            continue;
        }
        all.view.push((direction(found.view[i]) - direction(exact.view[i])).length());
        let lights = [found, exact].map(|seen| direction(seen.light[i]));
        match lights.map(|light| light.z > 0.0) {
            [true, true] => all.light.push((lights[0] - lights[1]).length()),
            [false, false] => {}
            _ => all.shadow += 1,
        }
        let (square, mut of_exact) = (|x: f64| x * x, 0.0);
        let mut apart = 0.0;
        for (a, b) in found.footprints[i].iter().zip(exact.footprints[i]) {
            apart += square(f64::from(*a) - f64::from(b));
            of_exact += square(f64::from(b));
        }
        all.footprint.push((apart / of_exact).sqrt());
        if let (Some(a), Some(b)) = (found.falloffs.get(i), exact.falloffs.get(i)) {
            all.falloff.push(f64::from((a - b).abs() / b));
        }
    }
    for list in [&mut all.view, &mut all.light, &mut all.footprint, &mut all.falloff] {
        list.sort_by(f64::total_cmp);
    }
    all
}

/// The value that the part `share` of the sorted `values` does not exceed; 0 where there are none.
fn quantile(values: &[f64], share: f64) -> f64 {
    values.get(((values.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0)
}

#[test]
fn probe() {
    with_device(|device| {
        for name in ["plate", "sphere", "disc", "snake", "cd", "skin"] {
            let case = Case::new(name, &["40,-30,1", "sphere:0.3:0.5,-0.8,2,30"]);
            let rays = RayScene::new(vec![case.object()]);
            let mut painter = case.painter(device);
            for light in [0, 1] {
                let pass = LightPass::of_all(light, Sampling { count: 16, seed: 3 }.sample(5));
                let found = painter.directions_in(&case.view, &pass).unwrap();
                let exact = rays.directions(&case.view, &pass, &case.settings());
                let d = differences(&found, &exact);
                let q = |v: &[f64]| [0.5, 0.9, 0.99, 1.0].map(|s| format!("{:.1e}", quantile(v, s)));
                eprintln!("{} {light}: cov {} shadow {} of {}\n view {:?}\n light {:?}\n foot {:?}\n fall {:?}", case.name, d.coverage, d.shadow, d.view.len(), q(&d.view), q(&d.light), q(&d.footprint), q(&d.falloff));
            }
        }
    });
}
