//! The user's settings, and what a change of them requires.

use crate::budget::Purpose;
use crate::error::Result;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::color::Tone;
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::Illuminant;
use crate::render::sampling::Sampling;
use crate::render::shading::Shading;
use crate::scene::environment::Placement;
use crate::scene::{Camera, Light, Scene};
use crate::setup::Method;
use crate::spectra::amplitude::expansion::Basis;
use crate::surface::SurfaceSource;
use glam::Vec3;

/// How the diffraction is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct OpticsSettings {
    /// Positions of the coherence window.
    pub windows: Windows,
    /// The expansion.
    pub basis: Basis,
    /// Accepted relative error.
    pub tolerance: f64,
    /// Number of terms; `None` follows from the tolerance.
    pub terms: Option<usize>,
    /// Number of wavelengths; `None` follows from the tolerance.
    pub wavelengths: Option<usize>,
}

/// Everything that determines the picture except its size.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSettings {
    /// Name of the scene.
    pub scene: String,
    /// The height field.
    pub surface: SurfaceSource,
    /// The optics.
    pub optics: OpticsSettings,
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// How the surface goes on beyond the patch.
    pub beyond: Beyond,
    /// What the surface reflects.
    pub reflectance: Reflectance,
    /// Spectrum of the light: a name or a file.
    pub illuminant: String,
    /// The lights.
    pub lights: Vec<Light>,
    /// How the surroundings stand, where the scene has any.
    pub surroundings: Placement,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// What the display makes of highlights.
    pub tone: Tone,
    /// Albedo of the pigment, linear sRGB.
    pub base_color: Vec3,
    /// The camera.
    pub camera: Camera,
    /// Samples that each pixel of a still picture is the mean of.
    pub samples: u32,
}

/// What a scene brings beside mesh and camera.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSettings {
    /// The height field.
    pub surface: SurfaceSource,
    /// What the surface reflects.
    pub reflectance: Reflectance,
    /// The lights.
    pub lights: Vec<Light>,
    /// How its surroundings stand, where it has any.
    pub surroundings: Placement,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// What the display makes of highlights.
    pub tone: Tone,
    /// Albedo of the pigment, linear sRGB.
    pub base_color: Vec3,
}

impl SceneSettings {
    /// What `scene` brings.
    pub fn of(scene: &Scene) -> Self {
        Self {
            surface: SurfaceSource {
                name: scene.surface.clone(),
                pixel_size: scene.pixel_size,
                height: scene.full_height,
                channel: None,
                prepare: scene.prepare.clone(),
                seed: 1,
            },
            reflectance: scene.reflectance.clone().unwrap_or_default(),
            lights: scene.lights.clone(),
            surroundings: placement(scene),
            exposure: scene.exposure,
            tone: scene.tone,
            base_color: scene.base_color,
        }
    }

    /// Puts all of it into `settings`.
    pub fn put_into(&self, settings: &mut ViewSettings) {
        let Self { surface, reflectance, lights, surroundings, exposure, tone, base_color } = self.clone();
        (settings.surface, settings.reflectance, settings.lights) = (surface, reflectance, lights);
        (settings.surroundings, settings.exposure) = (surroundings, exposure);
        (settings.tone, settings.base_color) = (tone, base_color);
    }
}

/// How the surroundings of `scene` stand.
pub fn placement(scene: &Scene) -> Placement {
    scene.environment.as_ref().map(|environment| environment.placement).unwrap_or_default()
}

/// What a change requires; each includes those before it.
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
    /// What has to be renewed to go from `shown` to `self`.
    pub fn needs(&self, shown: &Self) -> Needs {
        let optics = |s: &Self| {
            let of_lights: Vec<_> = s.lights.iter().map(|light| light.illuminant().cloned()).collect();
            let light = (s.coherence, s.illuminant.clone(), of_lights);
            // What shading averages over.
            let footprint = s.sampling().footprint();
            (s.surface.clone(), s.optics.clone(), s.beyond, s.reflectance.clone(), light, footprint)
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

    /// The settings for `render`, with `optics` in place of [`Self::optics`].
    ///
    /// # Errors
    /// Fails if the file of the illuminant cannot be read.
    pub fn shading(&self, optics: &OpticsSettings) -> Result<Shading> {
        Ok(Shading {
            coherence: self.coherence,
            reflectance: self.reflectance.clone(),
            illuminant: Illuminant::from_name_or_file(&self.illuminant)?,
            tolerance: optics.tolerance,
            windows: self.windows(optics),
            beyond: self.beyond,
            basis: optics.basis,
            terms: optics.terms.filter(|_| self.windows(optics) != Windows::All),
            wavelengths: self.wavelengths(optics),
            purpose: Purpose::Picture,
            looser_colours: 1.0,
        })
    }

    /// The samples of a still picture. A seed that chooses the surface chooses them, too.
    pub fn sampling(&self) -> Sampling {
        Sampling { count: self.samples.max(1), seed: self.surface.seed }
    }

    /// Replaces what `old` has brought by what `new` brings, and keeps what the user has set since.
    pub fn change_scene(&mut self, old: &SceneSettings, new: &SceneSettings) {
        fn replace<T: Clone + PartialEq>(now: &mut T, old: &T, new: &T) {
            if now == old {
                now.clone_from(new);
            }
        }
        replace(&mut self.surface, &old.surface, &new.surface);
        replace(&mut self.reflectance, &old.reflectance, &new.reflectance);
        replace(&mut self.lights, &old.lights, &new.lights);
        replace(&mut self.surroundings, &old.surroundings, &new.surroundings);
        replace(&mut self.exposure, &old.exposure, &new.exposure);
        replace(&mut self.tone, &old.tone, &new.tone);
        replace(&mut self.base_color, &old.base_color, &new.base_color);
    }

    /// Positions of the window: a finite grating stands at one place.
    pub fn windows(&self, optics: &OpticsSettings) -> Windows {
        if self.repeats() { Windows::ONE } else { optics.windows }
    }

    /// Returns the method of `optics`: the mean is drawn from a table, one window as a sum over wavelengths.
    pub fn method(&self, optics: &OpticsSettings) -> Method {
        if self.windows(optics) == Windows::All { Method::Table } else { Method::Spectral }
    }

    /// The number of wavelengths that `optics` sets. Through repeats it has no effect: the wavelengths are those of the orders.
    pub fn wavelengths(&self, optics: &OpticsSettings) -> Option<usize> {
        optics.wavelengths.filter(|_| !self.repeats())
    }

    /// A vector as an option takes it, so that the same numbers are read again.
    pub fn triple(v: Vec3) -> String {
        format!("{},{},{}", v.x, v.y, v.z)
    }

    /// Whether the coherence is a finite number of copies of the patch.
    pub fn repeats(&self) -> bool {
        matches!(self.coherence, Coherence::Repeats(_))
    }

    /// The camera as the options of a command line give it. They name the eye, so its angles differ in the last bits.
    pub fn shown_camera(&self, scene: &Scene) -> Camera {
        if self.camera == scene.camera {
            return self.camera;
        }
        let c = &self.camera;
        Camera::looking(c.eye(), c.target, c.field_of_view).unwrap_or(*c)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::scene::light::LightSpectrum;

    /// One window of the plate's own surface, and its scene.
    pub(crate) fn settings() -> (ViewSettings, Scene) {
        let scene = Scene::open("plate").unwrap();
        let surface = SurfaceSource {
            name: scene.surface.clone(),
            pixel_size: None,
            height: None,
            channel: None,
            prepare: Vec::new(),
            seed: 1,
        };
        let optics = OpticsSettings {
            windows: Windows::ONE,
            basis: Basis::Taylor,
            tolerance: 1e-2,
            terms: None,
            wavelengths: None,
        };
        let settings = ViewSettings {
            scene: "plate".to_owned(),
            surface,
            optics,
            coherence: Coherence::SUNLIGHT,
            beyond: Beyond::Copies,
            reflectance: Reflectance::default(),
            illuminant: "d65".to_owned(),
            lights: scene.lights.clone(),
            surroundings: placement(&scene),
            exposure: scene.exposure,
            tone: scene.tone,
            base_color: scene.base_color,
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
        assert_eq!(needs(&|s| s.tone = Tone::Neutral), Needs::Display);
        assert_eq!(needs(&|s| s.lights[0] = Light::point(1.0, 2.0, 3.0)), Needs::Frame);
        assert_eq!(needs(&|s| s.lights[0].spectrum = LightSpectrum::built_in("led")), Needs::Layers);
        assert_eq!(needs(&|s| s.camera.phi += 0.1), Needs::Frame);
        assert_eq!(needs(&|s| s.surroundings.rotation += 5.0), Needs::Frame);
        assert_eq!(needs(&|s| s.base_color.x = 0.1), Needs::Frame);
        let of_samples = |samples| ViewSettings { samples, ..shown.clone() };
        // A single sample averages over the whole pixel filter, one of several over its part.
        for other in [1, 9, 64] {
            assert_eq!(of_samples(16).needs(&of_samples(other)), Needs::Layers, "{other}");
        }
        assert_eq!(needs(&|s| s.optics.terms = Some(5)), Needs::Layers);
        assert_eq!(needs(&|s| s.surface.seed = 2), Needs::Layers);
        assert_eq!(needs(&|s| s.illuminant = "a".to_owned()), Needs::Layers);
        assert_eq!(needs(&|s| s.scene = "disc".to_owned()), Needs::Mesh);
    }

    #[test]
    fn another_scene_brings_what_the_user_has_not_set() {
        let (mut s, scene) = settings();
        let [old, new] = [&scene, &Scene::open("cd").unwrap()].map(SceneSettings::of);
        s.change_scene(&old, &new);
        let brought = [s.surface == new.surface, s.reflectance == new.reflectance, s.lights == new.lights];
        assert_eq!(brought, [true; 3]);
        assert_eq!((s.exposure, s.tone, s.base_color), (new.exposure, new.tone, new.base_color));
        s.exposure += 1.0;
        s.surface = SurfaceSource {
            height: Some(0.3),
            ..SurfaceSource::built_in(crate::surface::synth::SurfaceKind::Elaphe)
        };
        s.base_color = Vec3::splat(0.25);
        let set = s.clone();
        s.change_scene(&new, &old);
        assert_eq!((s.exposure, &s.surface, s.base_color), (set.exposure, &set.surface, set.base_color));
        assert_eq!((&s.lights, s.tone), (&old.lights, old.tone));
    }

    #[test]
    fn a_finite_grating_has_no_mean_and_the_wavelengths_of_its_orders() {
        let (s, _) = settings();
        let optics = OpticsSettings { windows: Windows::All, wavelengths: Some(9), ..s.optics.clone() };
        let repeats = ViewSettings { coherence: Coherence::Repeats([3, 7]), optics, ..s };
        assert_eq!(repeats.shading(&repeats.optics).unwrap().wavelengths, None);
        assert_eq!(repeats.windows(&repeats.optics), Windows::ONE);
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
            let named = Camera::looking(parsed.into(), s.camera.target, s.camera.field_of_view).unwrap();
            assert_eq!(named, s.shown_camera(&scene), "{eye}");
        }
    }
}
