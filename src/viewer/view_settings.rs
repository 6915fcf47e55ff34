//! Settings of the user, and the work that a change of them requires.

use crate::optics::color::Tone;
use crate::render::sampling::Sampling;
use crate::scene::environment::Placement;
use crate::scene::{Camera, Light, Scene};
use crate::settings::Optics;
use crate::surface::SurfaceSource;
use glam::Vec3;

/// All settings that determine the picture, except its size.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSettings {
    /// Name of the scene.
    pub scene: String,
    /// The height field.
    pub surface: SurfaceSource,
    /// The optics as the user sets them. Pictures are drawn with [`Optics::settled`].
    pub optics: Optics,
    /// The lights.
    pub lights: Vec<Light>,
    /// Orientation and exposure of the surroundings, if the scene has any.
    pub surroundings: Placement,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// Tone mapping of highlights.
    pub tone: Tone,
    /// Albedo of the pigment, linear sRGB.
    pub base_color: Vec3,
    /// The camera.
    pub camera: Camera,
    /// Samples per pixel of a still picture.
    pub samples: u32,
}

/// Returns orientation and exposure of the surroundings of `scene`.
pub fn placement(scene: &Scene) -> Placement {
    scene.environment.as_ref().map(|environment| environment.placement).unwrap_or_default()
}

/// Work required by a change; each variant includes the earlier ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// Displaying the same radiance again.
    Display,
    /// A new frame.
    Frame,
    /// New layers or a new colour table.
    Layers,
    /// A new mesh.
    Mesh,
}

impl ViewSettings {
    /// Returns the work required to go from `shown` to `self`.
    pub fn needs(&self, shown: &Self) -> Needs {
        let optics = |s: &Self| {
            let of_lights: Vec<_> = s.lights.iter().map(|light| light.illuminant().cloned()).collect();
            // Part of the filter that shading averages over.
            let footprint = s.sampling().footprint();
            (s.surface.clone(), s.optics.clone(), of_lights, footprint)
        };
        if self.scene != shown.scene {
            Needs::Mesh
        } else if optics(self) != optics(shown) {
            Needs::Layers
        } else if (self.camera, self.base_color) != (shown.camera, shown.base_color)
            || (&self.lights, self.samples) != (&shown.lights, shown.samples)
            || self.surroundings != shown.surroundings
        {
            Needs::Frame
        } else if (self.exposure, self.tone) != (shown.exposure, shown.tone) {
            Needs::Display
        } else {
            Needs::Nothing
        }
    }

    /// Returns the samples of a still picture. The seed of the surface is also the seed of the samples.
    pub fn sampling(&self) -> Sampling {
        Sampling { count: self.samples.max(1), seed: self.surface.seed }
    }

    /// Takes over the settings that come with `scene`, but for its mesh and its camera.
    pub fn bring(&mut self, scene: &Scene) {
        let object = scene.main_object();
        self.surface = scene.main_surface();
        let theory = self.optics.reflectance.stated_theory();
        self.optics.reflectance = object.reflectance.clone().unwrap_or_default().by(theory);
        self.base_color = object.base_color;
        self.lights.clone_from(&scene.lights);
        self.surroundings = placement(scene);
        (self.exposure, self.tone) = (scene.display.exposure, scene.display.tone);
    }

    /// Replaces the settings that came with `old` by those of `new`, and keeps those that the user has changed.
    pub fn change_scene(&mut self, old: &Scene, new: &Scene) {
        fn replace<T: PartialEq>(now: &mut T, old: &T, new: T) {
            if now == old {
                *now = new;
            }
        }
        let [old, new] = [old, new].map(|scene| {
            let mut settings = self.clone();
            settings.bring(scene);
            settings
        });
        replace(&mut self.surface, &old.surface, new.surface);
        replace(&mut self.optics.reflectance, &old.optics.reflectance, new.optics.reflectance);
        replace(&mut self.lights, &old.lights, new.lights);
        replace(&mut self.surroundings, &old.surroundings, new.surroundings);
        replace(&mut self.exposure, &old.exposure, new.exposure);
        replace(&mut self.tone, &old.tone, new.tone);
        replace(&mut self.base_color, &old.base_color, new.base_color);
    }

    /// Formats a vector as an option value that reads back as the same numbers.
    pub fn triple(v: Vec3) -> String {
        format!("{},{},{}", v.x, v.y, v.z)
    }

    /// Returns the camera as the options of a command line describe it. They name the eye, so that its angles differ in
    /// the last bits.
    pub fn shown_camera(&self, scene: &Scene) -> Camera {
        if self.camera == scene.camera {
            return self.camera;
        }
        let c = &self.camera;
        Camera::looking(c.eye(), c.target, c.lens).unwrap_or(*c)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::optics::coherence::Windows;
    use crate::optics::spectrum::Illuminant;
    use crate::spectra::amplitude::expansion::Basis;
    use crate::surface::synth::SurfaceKind;

    /// Returns settings for one window of the plate's surface, and its scene.
    pub(crate) fn settings() -> (ViewSettings, Scene) {
        let scene = Scene::open("plate").unwrap();
        let name = scene.main_surface().name;
        let surface = SurfaceSource { name, ..SurfaceSource::built_in(SurfaceKind::Flat) };
        let optics =
            Optics { windows: Windows::ONE, basis: Basis::Taylor, ..Optics::default() }.for_pictures();
        let settings = ViewSettings {
            scene: "plate".to_owned(),
            surface,
            optics,
            lights: scene.lights.clone(),
            surroundings: placement(&scene),
            exposure: scene.display.exposure,
            tone: scene.display.tone,
            base_color: scene.main_object().base_color,
            camera: scene.camera,
            samples: 1,
        };
        (settings, scene)
    }

    #[test]
    fn each_change_asks_for_no_more_than_it_needs() {
        let (shown, _) = settings();
        let needs = |change: &dyn Fn(&mut ViewSettings)| {
            let mut wanted = shown.clone();
            change(&mut wanted);
            wanted.needs(&shown)
        };
        assert_eq!(needs(&|_| ()), Needs::Nothing);
        assert_eq!(needs(&|s| s.exposure += 1.0), Needs::Display);
        assert_eq!(needs(&|s| s.tone = Tone::None), Needs::Display);
        assert_eq!(needs(&|s| s.lights[0] = Light::point(1.0, 2.0, 3.0)), Needs::Frame);
        assert_eq!(needs(&|s| s.lights[0].spectrum = Some(Illuminant::Led)), Needs::Layers);
        assert_eq!(needs(&|s| s.camera.phi += 0.1), Needs::Frame);
        assert_eq!(needs(&|s| s.surroundings.rotation += 5.0), Needs::Frame);
        assert_eq!(needs(&|s| s.base_color.x = 0.1), Needs::Frame);
        let of_samples = |samples| ViewSettings { samples, ..shown.clone() };
        // A single sample averages over the whole pixel filter, one of several over a part of it.
        for other in [1, 9, 64] {
            assert_eq!(of_samples(16).needs(&of_samples(other)), Needs::Layers, "{other}");
        }
        assert_eq!(needs(&|s| s.optics.terms = Some(5)), Needs::Layers);
        assert_eq!(needs(&|s| s.surface.seed = 2), Needs::Layers);
        assert_eq!(needs(&|s| s.optics.illuminant = Illuminant::A), Needs::Layers);
        assert_eq!(needs(&|s| s.scene = "disc".to_owned()), Needs::Mesh);
    }

    #[test]
    fn another_scene_brings_what_the_user_has_not_set() {
        let (mut s, old_scene) = settings();
        let new_scene = Scene::open("cd").unwrap();
        let [old, new] = [&old_scene, &new_scene].map(|scene| {
            let mut settings = settings().0;
            settings.bring(scene);
            settings
        });
        s.change_scene(&old_scene, &new_scene);
        let brought = [
            s.surface == new.surface,
            s.optics.reflectance == new.optics.reflectance,
            s.lights == new.lights,
        ];
        assert_eq!(brought, [true; 3]);
        assert_eq!((s.exposure, s.tone, s.base_color), (new.exposure, new.tone, new.base_color));
        s.exposure += 1.0;
        s.surface = SurfaceSource { height: Some(0.3), ..SurfaceSource::built_in(SurfaceKind::Elaphe) };
        s.base_color = Vec3::splat(0.25);
        let set = s.clone();
        s.change_scene(&new_scene, &old_scene);
        assert_eq!((s.exposure, &s.surface, s.base_color), (set.exposure, &set.surface, set.base_color));
        assert_eq!((&s.lights, s.tone), (&old.lights, old.tone));
    }

    #[test]
    fn the_camera_that_is_named_is_the_camera_that_is_shown() {
        let (mut s, scene) = settings();
        assert_eq!(s.shown_camera(&scene), scene.camera);
        for step in 0..500u16 {
            let x = f32::from(step);
            s.camera.phi = 0.013 * x;
            s.camera.theta = 0.006 * x + 0.01;
            s.camera.distance = 1.0 + 0.037 * x;
            let eye = ViewSettings::triple(s.camera.eye());
            let parsed = crate::units::triple(&eye).unwrap().map(|x| x as f32);
            let named = Camera::looking(parsed.into(), s.camera.target, s.camera.lens).unwrap();
            assert_eq!(named, s.shown_camera(&scene), "{eye}");
        }
    }
}
