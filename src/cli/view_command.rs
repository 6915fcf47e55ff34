//! Command line that draws the picture in the window.

use super::options::as_options;
use super::scene_options;
use crate::error::Result;
use crate::optics::coherence::{Coherence, Windows};
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::{DielectricLaw, Reflectance};
use crate::optics::theory::Theory;
use crate::output;
use crate::picture_file::quoted;
use crate::scene::{DisplaySettings, Grooves, Lens, LensProjection, Scene, SceneOverrides};
use crate::surface::SurfaceSource;
use crate::surface::prepare::{Levelling, PreparationStep};
use crate::viewer::{Output, ViewSettings};
use std::io::Write;
use std::path::Path;

/// Returns the `diffract render` that draws the picture of `settings` into `output`, without options that have their default or the value
/// of `scene`.
pub fn render(settings: &ViewSettings, scene: &Scene, output: &Output<'_>) -> String {
    let mut words = Words(vec![settings.scene.clone()]);
    words.settings(settings, scene);
    let Output { size: [width, height], file, turntable } = *output;
    words.option("size", format!("{width}x{height}"));
    if let Some(count) = turntable {
        words.option("turntable", count.to_string());
    }
    let words: Vec<String> = words.0.iter().map(|word| quoted(word)).collect();
    format!("diffract render {} -o {}", words.join(" "), quoted(file))
}

/// Returns the arguments of the `diffract view` that begins with `settings`, independent of the current folder.
pub fn view(settings: &ViewSettings, scene: &Scene) -> Vec<String> {
    let mut words = Words(vec![settings.scene.clone()]);
    words.settings(settings, scene);
    words.0.into_iter().map(absolute).collect()
}

/// Writes `settings` of `scene` as a scene file: all settings of the picture except its size.
///
/// # Errors
/// A file that cannot be written; names of files that are not UTF-8.
pub fn write_scene(settings: &ViewSettings, scene: &Scene, path: &Path) -> Result<()> {
    let mut words = Words(Vec::new());
    words.optics(settings);
    words.option("seed", settings.surface.seed.to_string());
    if let Some(channel) = &settings.surface.channel {
        words.option("channel", channel);
    }
    let pairs =
        words.0.chunks_exact(2).map(|pair| [pair[0].trim_start_matches('-').to_owned(), pair[1].clone()]);
    // A material with a spectrum has separate keys in the file.
    let has_spectrum = matches!(&settings.optics.reflectance, Reflectance::Fresnel { material, .. } if material.constant_index().is_none());
    let is_option = |[name, _]: &[String; 2]| {
        scene_options::OF_SCENES.contains(&name.as_str()) && !(has_spectrum && name == "film")
    };
    let mut written = Scene {
        camera: settings.shown_camera(scene),
        lights: settings.lights.clone(),
        environment: scene.environment.as_ref().map(|environment| environment.placed(settings.surroundings)),
        display: DisplaySettings {
            exposure: settings.exposure,
            auto_exposure: false,
            tone: settings.tone,
            ..scene.display
        },
        options: pairs.filter(is_option).collect(),
        ..scene.clone()
    };
    let object = written.main_object_mut();
    object.surface = Some(settings.surface.clone());
    object.base_color = settings.base_color;
    object.reflectance = has_spectrum.then(|| settings.optics.reflectance.clone());
    let text = written.to_toml(path.parent().unwrap_or(Path::new("")))?;
    output::write_atomically(path, |file| {
        file.write_all(text.as_bytes()).map_err(|e| output::write_failed(path, e))
    })
}

/// Returns the absolute name of a file, and any other word unchanged.
fn absolute(word: String) -> String {
    let path = Path::new(&word);
    let from_root = path.is_file().then(|| std::path::absolute(path).ok()).flatten();
    from_root.and_then(|path| path.to_str().map(str::to_owned)).unwrap_or(word)
}

/// Command line under construction.
struct Words(Vec<String>);

impl Words {
    fn option(&mut self, name: &str, value: impl Into<String>) {
        self.0.extend([format!("--{name}"), value.into()]);
    }

    /// Adds the options for `settings` that differ from `scene` and from the defaults.
    fn settings(&mut self, settings: &ViewSettings, scene: &Scene) {
        let words = self;
        words.surface(&settings.surface, scene);
        words.optics(settings);
        for light in &settings.lights {
            words.option("light", light.to_string());
        }
        if let Some(environment) = &scene.environment {
            let placement = settings.surroundings;
            words.option("environment", environment.name.to_string());
            words.option("rotate-environment", format!("{}deg", placement.rotation));
            words.option("environment-exposure", placement.exposure.to_string());
        }
        words.overrides(&scene.overrides);
        if !scene.shadows {
            words.option("shadows", "off");
        }
        words.option("exposure", settings.exposure.to_string());
        if settings.tone != scene.display.tone {
            words.option("tone", settings.tone.name());
        }
        if scene.display.is_opaque {
            words.option("background", scene.display.background.to_string());
        }
        if settings.base_color != scene.main_object().base_color {
            words.option("base-color", ViewSettings::triple(settings.base_color));
        }
        let camera = &settings.camera;
        if *camera != scene.camera {
            words.option("eye", ViewSettings::triple(camera.eye()));
            words.option("target", ViewSettings::triple(camera.target));
            words.lens(&camera.lens, &scene.camera.lens);
        }
    }

    /// Adds the options of `lens` that differ from `old`.
    fn lens(&mut self, lens: &Lens, old: &Lens) {
        let degrees = |radians: f32| format!("{}deg", f64::from(radians).to_degrees());
        match lens.projection {
            projection if projection == old.projection => {}
            LensProjection::Perspective { field_of_view } => {
                self.option("field-of-view", degrees(field_of_view))
            }
            LensProjection::Orthographic { height } => self.option("orthographic", height.to_string()),
        }
        if lens.roll != old.roll {
            self.option("roll", degrees(lens.roll));
        }
        if lens.shift != old.shift {
            self.option("lens-shift", format!("{},{}", lens.shift[0], lens.shift[1]));
        }
    }

    /// Adds the options that the scene was opened with.
    fn overrides(&mut self, overrides: &SceneOverrides) {
        if let Some(micrometres) = overrides.scale {
            self.option("scale", format!("{micrometres}um"));
        }
        if let Some(up) = overrides.up {
            self.option("up", up.name());
        }
        match &overrides.grooves {
            None => {}
            Some(Grooves::Along) => self.option("grooves", "0deg"),
            Some(Grooves::Turned(angle)) => self.option("grooves", format!("{angle}deg")),
            Some(Grooves::Radial) => self.option("grooves", "radial"),
            Some(Grooves::Map(file)) => self.option("grooves", file.to_string_lossy()),
        }
    }

    fn surface(&mut self, surface: &SurfaceSource, scene: &Scene) {
        let of_scene = scene.main_surface();
        let is_same = surface.name == of_scene.name;
        if !is_same {
            self.option("surface", surface.name.to_string_lossy());
        }
        if let Some([x, y]) = surface.pixel_size.filter(|p| !is_same || Some(*p) != of_scene.pixel_size) {
            self.option("pixel-size", format!("{x}umx{y}um"));
        }
        if let Some(height) = surface.height.filter(|h| !is_same || Some(*h) != of_scene.height) {
            self.option("height", format!("{height}um"));
        }
        if let Some(channel) = &surface.channel {
            self.option("channel", channel);
        }
        let own_steps: &[PreparationStep] = if is_same { &of_scene.prepare } else { &[] };
        if surface.prepare != own_steps {
            // Without a step the scene's steps would stay.
            let none = [PreparationStep::Level(Levelling::None)];
            let steps = if surface.prepare.is_empty() { &none[..] } else { &surface.prepare };
            self.0.extend(as_options(steps).split(' ').map(str::to_owned));
        }
        if surface.seed != 1 {
            self.option("seed", surface.seed.to_string());
        }
    }

    fn optics(&mut self, settings: &ViewSettings) {
        let optics = settings.optics.settled();
        self.option("method", optics.method.name());
        self.option("windows", optics.windows.to_string());
        if optics.windows == Windows::All {
            self.option("beyond", optics.beyond.name());
        } else {
            self.option("basis", optics.basis.name());
        }
        self.option("samples", settings.samples.to_string());
        self.option("tolerance", format!("{:e}", optics.tolerance));
        if let Some(terms) = optics.terms {
            self.option("terms", terms.to_string());
        }
        if let Some(wavelengths) = optics.wavelengths {
            self.option("wavelengths", wavelengths.to_string());
        }
        let coherence = match optics.coherence {
            Coherence::Gaussian { length } => format!("gaussian:{length}um"),
            Coherence::Repeats([n, m]) => format!("grating:{n}x{m}"),
        };
        self.option("coherence", coherence);
        match &optics.reflectance {
            Reflectance::Schlick(ior) => {
                self.option("ior", ior.to_string());
                self.option("reflectance", DielectricLaw::Schlick.name());
            }
            Reflectance::Fresnel { material, film, polarisation, theory } => {
                match material.constant_index() {
                    Some(index) => self.option("ior", index.to_string()),
                    None => self.option("material", &material.name),
                }
                if let Some(film) = film {
                    self.option("film", film.to_string());
                }
                if *polarisation != Polarisation::None {
                    self.option("polarisation", polarisation.name());
                }
                if *theory != Theory::default() {
                    self.option("theory", theory.name());
                }
            }
        }
        self.option("illuminant", optics.illuminant.name());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::color::Tone;
    use crate::scene::object::Up;
    use crate::settings::Optics;
    use crate::viewer::settings_of_a_plate as settings;

    const OUTPUT: Output<'_> = Output { size: [64, 48], file: "a.png", turntable: None };

    #[test]
    fn the_command_line_names_what_differs_and_quotes_it() {
        let (mut s, scene) = settings();
        let plain = render(&s, &scene, &OUTPUT);
        let expected = "diffract render plate --method spectral --windows 1x1 --basis taylor --samples 1 --tolerance 1e-2 ";
        assert!(plain.starts_with(expected), "{plain}");
        assert!(plain.ends_with("--size 64x48 -o a.png"), "{plain}");
        let turn = render(&s, &scene, &Output { turntable: Some(24), ..OUTPUT });
        assert!(turn.ends_with("--size 64x48 --turntable 24 -o a.png"), "{turn}");
        assert!(!plain.contains("--eye") && !plain.contains("--surface") && !plain.contains("--seed"));
        let by_table = Optics { terms: Some(9), windows: Windows::All, ..s.optics.clone() };
        let table = render(&ViewSettings { optics: by_table, ..s.clone() }, &scene, &OUTPUT);
        let expected = "--method table --windows all --beyond copies --samples 1 --tolerance 1e-2";
        assert!(table.contains(expected), "{table}");
        assert!(!table.contains("--terms") && !table.contains("--basis"), "{table}");
        let through = Coherence::Repeats([3, 7]);
        // A finite grating stands at one place, so that there is no mean and no table of it.
        let named =
            Optics { coherence: through, windows: Windows::All, wavelengths: Some(9), ..s.optics.clone() };
        let repeats = ViewSettings { optics: named, ..s.clone() };
        let told = render(&repeats, &scene, &OUTPUT);
        assert!(told.contains("--coherence grating:3x7") && !told.contains("--wavelengths"), "{told}");
        assert!(told.contains("--method spectral --windows 1x1"), "{told}");
        assert!(!told.contains("--tone"), "{told}");
        s.tone = Tone::None;
        let told = render(&s, &scene, &OUTPUT);
        assert!(told.contains("--tone none"), "{told}");
        let display = DisplaySettings { tone: Tone::None, ..scene.display };
        let hard = Scene { display, ..scene.clone() };
        assert!(!render(&s, &hard, &OUTPUT).contains("--tone"));
        let overrides = SceneOverrides { scale: Some(5e4), up: Some(Up::Z), grooves: Some(Grooves::Radial) };
        let given = render(&s, &Scene { overrides, ..scene.clone() }, &OUTPUT);
        assert!(given.contains("--scale 50000um --up z --grooves radial"), "{given}");
        s.tone = Tone::Neutral;
        assert!(render(&s, &hard, &OUTPUT).contains("--tone neutral"));
        s.surface.name = "my scan's.png".into();
        s.surface.pixel_size = Some([0.09, 0.1]);
        s.camera.phi += 0.25;
        let told = render(&s, &scene, &OUTPUT);
        assert!(told.contains("--surface 'my scan'\\''s.png' --pixel-size 0.09umx0.1um"), "{told}");
        assert!(told.contains("--eye ") && told.contains("--target "), "{told}");
    }
}
