//! Lights: an emitter, which is a point or disc of the sky or a lamp, and its spectrum.

use super::far_light::FarLight;
use super::incident::Incident;
use super::lamp::{Lamp, Room};
use crate::error::{Error, Result};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use std::fmt;
use std::path::Path;

/// A light of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Emitter.
    #[doc(hidden)]
    pub emitter: Emitter,
    /// Spectrum; `None`: that of the scene's illuminant.
    #[doc(hidden)]
    pub spectrum: Option<Illuminant>,
}

/// Emitter of a light: its position and shape, without a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emitter {
    /// Light at infinity: all of the scene sees it in the same direction.
    Far(FarLight),
    /// Lamp in the scene.
    Lamp(Lamp),
}

#[doc(hidden)]
impl Light {
    /// Parses a light: an emitter, as [`Emitter::parse`] reads it, and optionally `@` and a spectrum, as [`Illuminant::from_name_or_file`]
    /// reads it.
    ///
    /// # Errors
    /// Those of both functions.
    pub fn parse(text: &str) -> Result<Self> {
        Self::parse_in(text, Path::new(""))
    }

    /// Parses a light of a scene file; the names of files are relative to `folder`.
    ///
    /// # Errors
    /// See [`Self::parse`].
    pub fn parse_in(text: &str, folder: &Path) -> Result<Self> {
        let (emitter, spectrum) = match text.split_once('@') {
            Some((emitter, name)) => (emitter, Some(illuminant(name.trim(), folder, text)?)),
            None => (text, None),
        };
        Ok(Self { emitter: Emitter::parse(emitter)?, spectrum })
    }

    /// Returns a point of the sky with the angles and the intensity of [`FarLight`].
    pub fn point(theta: f64, phi: f64, intensity: f64) -> Self {
        FarLight { theta, phi, intensity, size: 0.0 }.into()
    }

    /// Returns true if the light is a lamp in the scene.
    pub fn is_lamp(&self) -> bool {
        matches!(self.emitter, Emitter::Lamp(_))
    }

    /// Returns the light's illuminant; `None`: that of the scene.
    pub fn illuminant(&self) -> Option<&Illuminant> {
        self.spectrum.as_ref()
    }

    /// Returns the light, without its spectrum if none of `others` has the same illuminant.
    #[must_use]
    pub fn known_to(&self, others: &[Self]) -> Self {
        let is_known = |known: &&Illuminant| others.iter().any(|other| other.illuminant() == Some(*known));
        Self { emitter: self.emitter, spectrum: self.spectrum.as_ref().filter(is_known).cloned() }
    }

    /// Returns the light with its emitter replaced by the result of `change`.
    #[must_use]
    pub fn map(&self, change: impl FnOnce(Emitter) -> Emitter) -> Self {
        Self { emitter: change(self.emitter), spectrum: self.spectrum.clone() }
    }

    /// Writes the light in the form of scene files and options; `name` returns the name of a spectrum's file.
    ///
    /// # Errors
    /// Those of `name`.
    pub fn to_text(&self, name: impl FnOnce(&Path) -> Result<String>) -> Result<String> {
        let name = match &self.spectrum {
            None => return Ok(self.emitter.to_string()),
            Some(spectrum) => spectrum.file().map_or(Ok(spectrum.name().into_owned()), name)?,
        };
        Ok(format!("{}@{name}", self.emitter))
    }
}

/// Returns the illuminant of that name, or the file of that name in `folder`. The error names the `light`.
fn illuminant(name: &str, folder: &Path, light: &str) -> Result<Illuminant> {
    if name.is_empty() {
        return Err(Error::usage(
            format!("the light '{light}' names no spectrum"),
            "write the name of an illuminant or of a CSV file behind @, as in sun:30,90@a",
        ));
    }
    if let Some(built_in) = Illuminant::built_in(name) {
        return Ok(built_in);
    }
    let file = folder.join(name);
    let illuminant = Illuminant::from_name_or_file(&file)?;
    if file.to_str().is_none() {
        return Err(Error::input(format!("the name {} is not UTF-8", file.display()), "rename the file"));
    }
    Ok(illuminant)
}

impl Emitter {
    /// Parses a lamp, or `THETA,PHI[,INTENSITY]`, a point of the sky, `sun:…` or `disc:SIZE:…`.
    ///
    /// # Errors
    /// Those of [`Lamp::parse`] and [`FarLight::parse`].
    pub fn parse(text: &str) -> Result<Self> {
        if Lamp::is_named_by(text) {
            Lamp::parse(text).map(Self::Lamp)
        } else {
            FarLight::parse(text).map(Self::Far)
        }
    }

    /// Subtracts from the emitter's extent the part that `coherence` contains already.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence, room: &Room) -> Self {
        match self {
            Self::Far(light) => Self::Far(light.beyond(coherence)),
            Self::Lamp(lamp) => Self::Lamp(lamp.beyond(coherence, room)),
        }
    }

    /// Rotates the emitter by `degrees` about the vertical through the middle of `room`.
    #[must_use]
    pub fn turned(self, degrees: f64, room: &Room) -> Self {
        match self {
            Self::Far(light) => Self::Far(FarLight { phi: light.phi + degrees, ..light }),
            Self::Lamp(lamp) => Self::Lamp(lamp.turned(degrees, room)),
        }
    }

    /// Returns the light as seen from the middle of `room`: a point of the sky. A light below the horizon is moved up to it.
    pub fn from_afar(&self, room: &Room) -> FarLight {
        let lamp = match self {
            Self::Far(light) => return *light,
            Self::Lamp(lamp) => lamp,
        };
        let to_lamp = lamp.middle - room.centre;
        let theta = to_lamp.truncate().length().atan2(to_lamp.z).to_degrees().min(90.0);
        FarLight { theta, phi: to_lamp.y.atan2(to_lamp.x).to_degrees(), intensity: 1.0, size: 0.0 }
    }

    /// Returns the sample at `point` (uniform in 0 … 1) of `count` samples in `room`.
    pub fn incident(&self, point: [f64; 2], count: u32, room: &Room) -> Incident {
        match self {
            Self::Far(light) => light.incident(point, count),
            Self::Lamp(lamp) => lamp.incident(point, count, room),
        }
    }
}

impl<T: Into<Emitter>> From<T> for Light {
    fn from(emitter: T) -> Self {
        Self { emitter: emitter.into(), spectrum: None }
    }
}

impl From<FarLight> for Emitter {
    fn from(light: FarLight) -> Self {
        Self::Far(light)
    }
}

impl From<Lamp> for Emitter {
    fn from(lamp: Lamp) -> Self {
        Self::Lamp(lamp)
    }
}

impl fmt::Display for Light {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.emitter.fmt(f)?;
        self.spectrum.as_ref().map_or(Ok(()), |spectrum| write!(f, "@{}", spectrum.name()))
    }
}

impl fmt::Display for Emitter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Far(light) => light.fmt(f),
            Self::Lamp(lamp) => lamp.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_with_a_spectrum_are_read_as_they_are_written() {
        for text in ["30,90,1@a", "sun:30,90,2@led", "sphere:0.1:0.2,0,1,60W@e", "rectangle:1x2:0,-1,1@d65"] {
            let light = Light::parse(text).unwrap();
            assert_eq!(light.to_string(), text);
            assert_eq!(light.emitter, Light::parse(text.split('@').next().unwrap()).unwrap().emitter);
        }
        assert_eq!(Light::parse("30,90@A").unwrap().illuminant(), Some(&Illuminant::A));
        assert_eq!(Light::parse("30,90").unwrap().illuminant(), None);
    }

    #[test]
    fn the_spectrum_of_a_scenes_light_lies_beside_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("lamp@home.csv"), "400,1\n700,2\n").unwrap();
        let light = Light::parse_in("30,90,1@lamp@home.csv", folder.path()).unwrap();
        let spectrum = light.spectrum.as_ref().unwrap();
        assert_eq!(*spectrum, Illuminant::from_text("400,1\n700,2\n").unwrap());
        assert_eq!(spectrum.file(), Some(&*folder.path().join("lamp@home.csv")));
        assert_eq!(Light::parse(&light.to_string()).unwrap(), light);
        let named = |path: &Path| Ok(path.file_name().unwrap().to_str().unwrap().to_owned());
        assert_eq!(light.to_text(named).unwrap(), "30,90,1@lamp@home.csv");
    }

    #[test]
    fn a_spectrum_that_is_none_is_refused_with_a_remedy() {
        for (text, said) in
            [("30,90@", "names no spectrum"), ("30,90@nothing.csv", "nothing.csv"), ("@a", "not a light")]
        {
            let error = Light::parse(text).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
