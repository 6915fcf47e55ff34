//! The document of a scene file: its keys and their forms, read and written by one definition.

use super::camera::Camera;
use super::display_settings::Background;
use super::lens::Lens;
use super::object::Up;
use super::scene_options::FileOptions;
use crate::error::{Error, Result};
use crate::optics::color::Tone;
use crate::units;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Scene file, with its keys in the order in which it is written. Tables stand behind plain values, as TOML needs it, and what is `None` is left out. The keys of the main object stand at
/// the top; serde reports unknown keys of flattened structs without a line, so they are repeated here.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneDocument {
    pub scale: Option<String>,
    pub mesh: String,
    pub up: Option<Up>,
    pub part: Option<String>,
    pub surface: String,
    pub pixel_size: Option<String>,
    pub height: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prepare: Vec<String>,
    pub base_color: Option<Triple<f32>>,
    pub pigment: Option<String>,
    pub grooves: Option<String>,
    pub material: Option<String>,
    pub film: Option<String>,
    pub ground: Option<Triple<f32>>,
    #[serde(default)]
    pub exposure: SceneExposure,
    #[serde(default)]
    pub tone: ToneName,
    #[serde(default)]
    pub background: Background,
    #[serde(default = "yes")]
    pub shadows: bool,
    pub lights: Vec<String>,
    pub environment: Option<EnvironmentDocument>,
    pub camera: CameraDocument,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectDocument>,
    #[serde(default, skip_serializing_if = "FileOptions::is_empty")]
    pub options: FileOptions,
}

impl SceneDocument {
    /// Returns the document of the main object, whose keys stand at the top of the file.
    pub fn main_object(&self) -> ObjectDocument {
        ObjectDocument {
            mesh: self.mesh.clone(),
            up: self.up,
            part: self.part.clone(),
            position: Triple::default(),
            rotation: Triple::default(),
            size: 1.0,
            surface: Some(self.surface.clone()),
            pixel_size: self.pixel_size.clone(),
            height: self.height.clone(),
            prepare: self.prepare.clone(),
            grooves: self.grooves.clone(),
            material: self.material.clone(),
            film: self.film.clone(),
            base_color: self.base_color,
            pigment: self.pigment.clone(),
        }
    }
}

/// Object of a scene file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectDocument {
    pub mesh: String,
    pub up: Option<Up>,
    pub part: Option<String>,
    #[serde(default)]
    pub position: Triple<f32>,
    #[serde(default)]
    pub rotation: Triple<Angle>,
    #[serde(default = "one")]
    pub size: f32,
    pub surface: Option<String>,
    pub pixel_size: Option<String>,
    pub height: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prepare: Vec<String>,
    pub grooves: Option<String>,
    pub material: Option<String>,
    pub film: Option<String>,
    pub base_color: Option<Triple<f32>>,
    pub pigment: Option<String>,
}

/// Camera of a scene file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraDocument {
    pub eye: Triple<f32>,
    pub target: Triple<f32>,
    /// Vertical field of view of a perspective camera.
    pub field_of_view: Option<String>,
    /// Height of what an orthographic camera shows.
    pub height: Option<f32>,
    pub roll: Option<String>,
    pub shift: Option<Exactly<f32, 2>>,
}

impl CameraDocument {
    /// Returns the camera.
    ///
    /// # Errors
    /// Angles that are none, numbers out of range, and anything but one of field of view and height.
    pub fn camera(&self) -> Result<Camera> {
        let radians = |text: &String| Ok::<_, Error>(units::angle(text)?.to_radians() as f32);
        let lens = match (&self.field_of_view, self.height) {
            (Some(angle), None) => Lens::perspective(radians(angle)?),
            (None, Some(height)) => Lens::orthographic(height),
            _ => {
                return Err(Error::input(
                    "the camera has not one of field_of_view and height",
                    "give a field_of_view, as in \"35deg\", or the height of what an orthographic camera shows",
                ));
            }
        };
        let roll = self.roll.as_ref().map_or(Ok(0.0), radians)?;
        let Exactly(shift) = self.shift.unwrap_or_default(); // none is no shift
        let lens = Lens { roll, shift, ..lens };
        Camera::looking(self.eye.0.into(), self.target.0.into(), lens)
    }
}

/// Surroundings of a scene file: `sky`, `studio` or a picture, with rotation and exposure.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentDocument {
    pub name: String,
    pub rotation: Option<String>,
    #[serde(default)]
    pub exposure: f64,
}

fn yes() -> bool {
    true
}

fn one() -> f32 {
    1.0
}

/// Exactly three values.
pub(super) type Triple<T> = Exactly<T, 3>;

/// Exactly `N` values; serde's arrays would take the first `N` of more.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(try_from = "Vec<T>", into = "Vec<T>")]
#[serde(bound(serialize = "T: Copy + Serialize", deserialize = "T: Copy + Deserialize<'de>"))]
pub(super) struct Exactly<T: Copy, const N: usize>(pub [T; N]);

impl<T: Copy + Default, const N: usize> Default for Exactly<T, N> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<T: Copy, const N: usize> TryFrom<Vec<T>> for Exactly<T, N> {
    type Error = String;

    fn try_from(numbers: Vec<T>) -> Result<Self, String> {
        let count = numbers.len();
        numbers.try_into().map(Self).map_err(|_| format!("{count} numbers where {N} belong"))
    }
}

impl<T: Copy, const N: usize> From<Exactly<T, N>> for Vec<T> {
    fn from(Exactly(values): Exactly<T, N>) -> Self {
        values.to_vec()
    }
}

/// Angle with its unit \[degrees\].
#[derive(Clone, Copy, Default, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub(super) struct Angle(pub f64);

impl TryFrom<String> for Angle {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        units::angle(&text).map(Self).map_err(|e| e.to_string())
    }
}

impl From<Angle> for String {
    fn from(Angle(degrees): Angle) -> Self {
        format!("{degrees}deg")
    }
}

/// Exposure: a number of stops, or `"auto"`.
#[derive(Clone, Copy, Deserialize, Default, Serialize)]
#[serde(try_from = "toml::Value", into = "toml::Value")]
pub(super) struct SceneExposure {
    pub stops: f64,
    pub is_auto: bool,
}

impl TryFrom<toml::Value> for SceneExposure {
    type Error = &'static str;

    fn try_from(value: toml::Value) -> Result<Self, Self::Error> {
        match value {
            toml::Value::Integer(stops) => Ok(Self { stops: stops as f64, is_auto: false }),
            toml::Value::Float(stops) => Ok(Self { stops, is_auto: false }),
            toml::Value::String(word) if word == "auto" => Ok(Self { stops: 0.0, is_auto: true }),
            _ => Err("the exposure is neither a number of stops nor \"auto\""),
        }
    }
}

impl From<SceneExposure> for toml::Value {
    fn from(exposure: SceneExposure) -> Self {
        if exposure.is_auto { "auto".into() } else { exposure.stops.into() }
    }
}

/// Name of a tone.
#[derive(Clone, Copy, Deserialize, Default, Serialize)]
#[serde(try_from = "String", into = "String")]
pub(super) struct ToneName(pub Tone);

impl TryFrom<String> for ToneName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Tone::from_name(&name).map(Self).map_err(|e| e.to_string())
    }
}

impl From<ToneName> for String {
    fn from(ToneName(tone): ToneName) -> Self {
        tone.name().to_owned()
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        match toml::Value::deserialize(from)? {
            toml::Value::String(name) if name == "surroundings" => Ok(Self::Surroundings),
            toml::Value::String(name) => Err(D::Error::custom(format!(
                "the background `{name}` is neither a colour nor \"surroundings\""
            ))),
            color => {
                let color = Triple::deserialize(color).map_err(D::Error::custom)?;
                Ok(Self::Color(color.0.into()))
            }
        }
    }
}

impl Serialize for Background {
    fn serialize<S: Serializer>(&self, into: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Surroundings => into.serialize_str("surroundings"),
            Self::Color(color) => Exactly(color.to_array()).serialize(into),
        }
    }
}
