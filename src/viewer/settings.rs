//! What the user has set, what a change of it asks for, and the command line that says the same.

use crate::error::Result;
use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::render::color_table::Filter;
use crate::render::resources::Reads;
use crate::render::shading::{Purpose, Shading};
use crate::scene::{Camera, Light, Scene};
use crate::surface::{Level, Source};
use glam::Vec3;

/// How the optics is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// By which method.
    pub method: Reads,
    /// What a pixel of a colour table shows.
    pub filter: Filter,
    /// Window centres that a colour table averages over.
    pub windows: [u32; 2],
    /// Which expansion.
    pub basis: Basis,
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// Terms, where the user names them.
    pub terms: Option<usize>,
    /// Wavelengths, where the user names them.
    pub wavelengths: Option<usize>,
}

/// Everything that decides the picture but its size.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Name of the scene.
    pub scene: String,
    /// The height field.
    pub surface: Source,
    /// The optics.
    pub optics: Optics,
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// Refractive index.
    pub ior: f64,
    /// The light's spectrum: a name or a file.
    pub illuminant: String,
    /// The lights.
    pub lights: Vec<Light>,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// Albedo of the pigment, linear sRGB.
    pub base_color: Vec3,
    /// The camera.
    pub camera: Camera,
}

/// What a change makes necessary; each includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// The display of the radiance that is there.
    Display,
    /// A frame.
    Frame,
    /// Layers, or tables beside them.
    Layers,
    /// Another mesh.
    Mesh,
}

impl Settings {
    /// What has to be done to show `self` where `shown` is shown.
    pub fn needs(&self, shown: &Self) -> Needs {
        let optics =
            |s: &Self| (s.surface.clone(), s.optics.clone(), s.coherence, s.ior, s.illuminant.clone());
        if self.scene != shown.scene {
            Needs::Mesh
        } else if optics(self) != optics(shown) {
            Needs::Layers
        } else if (self.camera, self.base_color) != (shown.camera, shown.base_color)
            || self.lights != shown.lights
        {
            Needs::Frame
        } else if self.exposure != shown.exposure {
            Needs::Display
        } else {
            Needs::Nothing
        }
    }

    /// The settings of the optics, with `optics` for the user's own.
    ///
    /// # Errors
    /// Where the illuminant's file cannot be read.
    pub fn shading(&self, optics: &Optics) -> Result<Shading> {
        Ok(Shading {
            coherence: self.coherence,
            ior: self.ior,
            illuminant: Illuminant::from_name_or_file(&self.illuminant)?,
            tolerance: optics.tolerance,
            windows: if optics.method == Reads::Table { optics.windows } else { [1, 1] },
            basis: optics.basis,
            terms: optics.terms.filter(|_| optics.method == Reads::Layers),
            wavelengths: self.wavelengths(optics),
            purpose: Purpose::Picture,
            looser_colours: 1.0,
        })
    }

    /// The wavelengths that are named in `optics`: through repeats they stand where the orders do.
    fn wavelengths(&self, optics: &Optics) -> Option<usize> {
        optics.wavelengths.filter(|_| !self.repeats())
    }

    /// Whether the patch repeats so many times and no more.
    pub fn repeats(&self) -> bool {
        matches!(self.coherence, Coherence::Repeats(_))
    }

    /// The camera as a command line can name it: standing where its eye is, not where its angles put it to the last bit.
    pub fn shown_camera(&self, scene: &Scene) -> Camera {
        if self.camera == scene.camera {
            return self.camera;
        }
        let c = &self.camera;
        Camera::looking(c.eye(), c.target, c.field_of_view).unwrap_or(*c)
    }

    /// The `diffract render` that draws the picture of these settings at `size` into `output`. What is the default, or
    /// `scene`'s own, is left out.
    pub fn command(&self, scene: &Scene, size: [u32; 2], output: &str) -> String {
        let mut words = vec!["diffract render".to_owned(), quoted(&self.scene)];
        let mut option = |name: &str, value: String| words.push(format!("--{name} {}", quoted(&value)));
        let s = &self.surface;
        let own = s.name == scene.surface;
        if !own {
            option("surface", s.name.to_string_lossy().into_owned());
        }
        if let Some([x, y]) = s.pixel_size.filter(|p| !own || Some(*p) != scene.pixel_size) {
            option("pixel-size", format!("{x}umx{y}um"));
        }
        if let Some(height) = s.height.filter(|h| !own || Some(*h) != scene.full_height) {
            option("height", format!("{height}um"));
        }
        if let Some(channel) = &s.channel {
            option("channel", channel.clone());
        }
        if s.level != Level::None {
            option("level", s.level.name().to_owned());
        }
        if s.seed != 1 {
            option("seed", s.seed.to_string());
        }
        match self.optics.method {
            Reads::Layers => option("basis", self.optics.basis.name().to_owned()),
            Reads::Table => {
                option("method", Reads::Table.method().to_owned());
                option("filter", self.optics.filter.name().to_owned());
                let [n, m] = self.optics.windows;
                option("windows", format!("{n}x{m}"));
            }
        }
        option("tolerance", format!("{:e}", self.optics.tolerance));
        if let Some(terms) = self.optics.terms.filter(|_| self.optics.method == Reads::Layers) {
            option("terms", terms.to_string());
        }
        if let Some(wavelengths) = self.wavelengths(&self.optics) {
            option("wavelengths", wavelengths.to_string());
        }
        let coherence = match self.coherence {
            Coherence::Gaussian { length } => format!("gaussian:{length}um"),
            Coherence::Repeats([n, m]) => format!("repeats:{n}x{m}"),
        };
        option("coherence", coherence);
        option("ior", self.ior.to_string());
        option("illuminant", self.illuminant.clone());
        for light in &self.lights {
            option("light", format!("{},{},{}", light.theta, light.phi, light.intensity));
        }
        option("exposure", self.exposure.to_string());
        if self.base_color != scene.base_color {
            option("base-color", triple(self.base_color));
        }
        if self.camera != scene.camera {
            option("eye", triple(self.camera.eye()));
            option("target", triple(self.camera.target));
            if self.camera.field_of_view != scene.camera.field_of_view {
                option("field-of-view", format!("{}deg", f64::from(self.camera.field_of_view).to_degrees()));
            }
        }
        option("size", format!("{}x{}", size[0], size[1]));
        words.push(format!("-o {}", quoted(output)));
        words.join(" ")
    }
}

fn triple(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

/// `word` as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:+=@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> (Settings, Scene) {
        let scene = Scene::open("plate").unwrap();
        let surface = Source {
            name: scene.surface.clone(),
            pixel_size: None,
            height: None,
            channel: None,
            level: Level::None,
            seed: 1,
        };
        let optics = Optics {
            method: Reads::Layers,
            filter: Filter::Point,
            windows: [1, 1],
            basis: Basis::Taylor,
            tolerance: 1e-2,
            terms: None,
            wavelengths: None,
        };
        let settings = Settings {
            scene: "plate".to_owned(),
            surface,
            optics,
            coherence: Coherence::SUNLIGHT,
            ior: 1.5,
            illuminant: "d65".to_owned(),
            lights: scene.lights.clone(),
            exposure: scene.exposure,
            base_color: scene.base_color,
            camera: scene.camera,
        };
        (settings, scene)
    }

    #[test]
    fn each_change_asks_for_no_more_than_it_needs() {
        let (shown, _) = settings();
        let needs = |change: &dyn Fn(&mut Settings)| {
            let mut wanted = shown.clone();
            change(&mut wanted);
            wanted.needs(&shown)
        };
        assert_eq!(needs(&|_| ()), Needs::Nothing);
        assert_eq!(needs(&|s| s.exposure += 1.0), Needs::Display);
        assert_eq!(needs(&|s| s.lights[0].theta += 1.0), Needs::Frame);
        assert_eq!(needs(&|s| s.camera.phi += 0.1), Needs::Frame);
        assert_eq!(needs(&|s| s.base_color.x = 0.1), Needs::Frame);
        assert_eq!(needs(&|s| s.optics.terms = Some(5)), Needs::Layers);
        assert_eq!(needs(&|s| s.surface.seed = 2), Needs::Layers);
        assert_eq!(needs(&|s| s.illuminant = "a".to_owned()), Needs::Layers);
        assert_eq!(needs(&|s| s.scene = "disc".to_owned()), Needs::Mesh);
    }

    #[test]
    fn the_command_line_names_what_differs_and_quotes_it() {
        let (mut s, scene) = settings();
        let plain = s.command(&scene, [64, 48], "a.png");
        assert!(plain.starts_with("diffract render plate --basis taylor --tolerance 1e-2 "), "{plain}");
        assert!(plain.ends_with("--size 64x48 -o a.png"), "{plain}");
        assert!(!plain.contains("--eye") && !plain.contains("--surface") && !plain.contains("--seed"));
        let by_table = Optics { method: Reads::Table, terms: Some(9), windows: [2, 3], ..s.optics.clone() };
        let table = Settings { optics: by_table, ..s.clone() }.command(&scene, [64, 48], "a.png");
        let expected = "--method table --filter point --windows 2x3 --tolerance 1e-2";
        assert!(table.contains(expected) && !table.contains("--terms"), "{table}");
        let through = Coherence::Repeats([3, 7]);
        let named = Optics { wavelengths: Some(9), ..s.optics.clone() };
        let repeats = Settings { coherence: through, optics: named, ..s.clone() };
        let told = repeats.command(&scene, [64, 48], "a.png");
        assert!(told.contains("--coherence repeats:3x7") && !told.contains("--wavelengths"), "{told}");
        assert_eq!(repeats.shading(&repeats.optics).unwrap().wavelengths, None);
        s.surface.name = "my scan's.png".into();
        s.surface.pixel_size = Some([0.09, 0.1]);
        s.camera.phi += 0.25;
        let told = s.command(&scene, [64, 48], "a.png");
        assert!(told.contains("--surface 'my scan'\\''s.png' --pixel-size 0.09umx0.1um"), "{told}");
        assert!(told.contains("--eye ") && told.contains("--target "), "{told}");
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
            let eye = triple(s.camera.eye());
            let parsed = crate::units::triple(&eye).unwrap().map(|x| x as f32);
            let named = Camera::looking(parsed.into(), s.camera.target, s.camera.field_of_view).unwrap();
            assert_eq!(named, s.shown_camera(&scene), "{eye}");
        }
    }
}
