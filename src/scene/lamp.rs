//! Lamps: spheres and rectangles that stand in the scene, near enough that pixels see them in different directions and at different distances.

use super::incident::{Emits, Incident, LampPoint, concentric, share_of_sample, spread_of};
use crate::error::{Error, Result};
use crate::optics::coherence::Coherence;
use crate::units;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;
use std::fmt;

/// Lamp: a uniform, diffuse emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Shape of the emitter.
    pub shape: LampShape,
    /// Middle \[units of the scene\].
    pub middle: DVec3,
    /// Radiance or power.
    pub strength: Strength,
}

/// The shape of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampShape {
    /// A sphere.
    Sphere {
        /// \[units of the scene\]
        diameter: f64,
    },
    /// A rectangle that emits to one side; its width is horizontal.
    Rectangle {
        /// Width and height \[units of the scene\].
        size: [f64; 2],
        /// Point that the rectangle faces; the middle of the scene by default.
        faces: Option<DVec3>,
    },
}

/// Strength of a lamp, in units in which a light of intensity 1 gives an irradiance of π.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Strength {
    /// The middle of the scene gets the light of intensity 1.
    #[default]
    Suited,
    /// Radiance.
    Radiance(f64),
    /// Power \[W\]; a light of intensity 1 gives π W/m².
    Power(f64),
}

/// Position and size of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Middle of the lit scene \[units of the scene\].
    pub centre: DVec3,
    /// Length of a unit \[m\].
    pub unit: f64,
}

/// Largest coordinate and size.
const FARTHEST: f64 = 1e6;
/// Smallest size of a lamp, in units of the scene: every pixel sees it as a point. Areas and radiances of far smaller ones
/// leave the range of 64-bit floats.
const SMALLEST: f64 = 1e-9;
/// Largest radiance and power.
const STRONGEST: f64 = 1e12;
const SPHERE: &str = "write sphere:DIAMETER:X,Y,Z[,STRENGTH] in units of the scene, as in sphere:0.1:0.2,0,1 or sphere:0.1:0.2,0,1,60W";
const RECTANGLE: &str = "write rectangle:WIDTHxHEIGHT:X,Y,Z[,STRENGTH][:X,Y,Z of what it faces] in units of the scene, as in rectangle:0.4x0.2:0,-1,1";

impl Lamp {
    /// Returns true if `text` describes a lamp.
    pub fn is_named_by(text: &str) -> bool {
        let kind = text.split(':').next().map(str::trim);
        matches!(kind, Some("sphere" | "rectangle"))
    }

    /// Parses the lamp `sphere:DIAMETER:X,Y,Z[,STRENGTH]` or `rectangle:WIDTHxHEIGHT:X,Y,Z[,STRENGTH][:X,Y,Z]`. The strength is a radiance,
    /// or a power with a W behind it.
    ///
    /// # Errors
    /// Another form, or numbers out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let (shape, place, form) = match parts[..] {
            ["sphere", diameter, place] => {
                (LampShape::Sphere { diameter: size(diameter, text)? }, place, SPHERE)
            }
            ["rectangle", sides, place, ref faced @ ..] if faced.len() <= 1 => {
                let (width, height) = sides.split_once(['x', '×']).ok_or_else(|| refused(text, RECTANGLE))?;
                let faces = faced.first().map(|point| coordinates(point, text, RECTANGLE)).transpose()?;
                let size = [size(width, text)?, size(height, text)?];
                (LampShape::Rectangle { size, faces }, place, RECTANGLE)
            }
            ["rectangle", ..] => return Err(refused(text, RECTANGLE)),
            _ => return Err(refused(text, SPHERE)),
        };
        let (place, strength) = match place.match_indices(',').nth(2) {
            Some((comma, _)) => (&place[..comma], Strength::parse(&place[comma + 1..], text)?),
            None => (place, Strength::Suited),
        };
        let lamp = Self { shape, middle: coordinates(place, text, form)?, strength };
        match shape {
            LampShape::Rectangle { faces: Some(point), .. } if point == lamp.middle => Err(Error::usage(
                format!("the rectangle in the light '{text}' faces its own middle"),
                "give another point, or none for the middle of the scene",
            )),
            _ => Ok(lamp),
        }
    }

    /// Returns the radiance in `room`, in units in which a light of intensity 1 gives an irradiance of π.
    pub fn radiance(&self, room: &Room) -> f64 {
        match self.strength {
            Strength::Radiance(radiance) => radiance,
            Strength::Suited => PI * self.distance(room).powi(2) / self.outline(),
            // Lambert's emitter radiates π per unit of its radiance and of its area.
            Strength::Power(power) => power / (PI * self.surface() * room.unit.powi(2)),
        }
    }

    /// Subtracts from the lamp's extent, as seen from the middle of `room`, the part that `coherence` contains already; the irradiance
    /// stays.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence, room: &Room) -> Self {
        /// Smallest remaining share of a lamp's size, which keeps its radiance finite.
        const LEAST: f64 = 1e-3;
        let held = spread_of(coherence) * self.distance(room).powi(2);
        let left = |variances: f64| (1.0 - held / variances).max(0.0).sqrt().max(LEAST);
        let shape = match self.shape {
            LampShape::Sphere { diameter } => {
                LampShape::Sphere { diameter: diameter * left(variance_of_disc(diameter)) }
            }
            LampShape::Rectangle { size, faces } => {
                LampShape::Rectangle { size: size.map(|side| side * left(variance_of_side(side))), faces }
            }
        };
        let smaller = Self { shape, ..self };
        let radiance = self.radiance(room) * self.outline() / smaller.outline();
        Self { strength: Strength::Radiance(radiance), ..smaller }
    }

    /// Rotates the lamp by `degrees` about the vertical through the middle of `room`.
    #[must_use]
    pub fn turned(self, degrees: f64, room: &Room) -> Self {
        let turned = |point: DVec3| {
            let flat = DVec2::from_angle(degrees.to_radians()).rotate((point - room.centre).truncate());
            (room.centre.truncate() + flat).extend(point.z)
        };
        let shape = match self.shape {
            LampShape::Rectangle { size, faces } => LampShape::Rectangle { size, faces: faces.map(turned) },
            sphere @ LampShape::Sphere { .. } => sphere,
        };
        Self { middle: turned(self.middle), shape, ..self }
    }

    /// Returns the sample at `point` (uniform in 0 … 1) of `count` samples: a point that stands for a part of the lamp with the same
    /// variance along both axes. The points are drawn from a smaller lamp, as by [`super::far_light::FarLight::incident`]. For a sphere
    /// they are drawn from the disc that the middle of `room` sees.
    pub fn incident(&self, point: [f64; 2], count: u32, room: &Room) -> Incident {
        let share = share_of_sample(count);
        let normal = self.normal(room);
        let [across, up] = axes(normal);
        let (at, emits, variance) = match self.shape {
            LampShape::Sphere { diameter } => {
                let (radius, angle) = concentric(point);
                let place = DVec2::from_angle(angle) * (radius * 0.5 * diameter * (1.0 - share).sqrt());
                (place, Emits::AllAround { middle: self.middle }, share * variance_of_disc(diameter))
            }
            LampShape::Rectangle { size, .. } => {
                let variances = size.map(variance_of_side);
                let variance = share * variances[0].min(variances[1]);
                let along = |i: usize| size[i] * (1.0 - variance / variances[i]).sqrt() * (point[i] - 0.5);
                (DVec2::new(along(0), along(1)), Emits::ToOneSide { normal }, variance)
            }
        };
        let place = self.middle + across * at.x + up * at.y;
        Incident {
            direction: (place - room.centre).try_normalize().unwrap_or(-normal),
            place: Some(LampPoint { point: place, emits }),
            irradiance: Vec3::splat((self.radiance(room) * self.outline() / PI) as f32),
            variance,
            mean: 1.0,
        }
    }

    /// Returns the corners of a rectangle, or of the square around the outline of a sphere as seen from the middle of `room`, in turn.
    pub fn corners(&self, room: &Room) -> [DVec3; 4] {
        let [across, up] = axes(self.normal(room));
        let [width, height] = match self.shape {
            LampShape::Sphere { diameter } => [diameter; 2],
            LampShape::Rectangle { size, .. } => size,
        };
        let corner = |x: f64, y: f64| self.middle + across * (0.5 * x * width) + up * (0.5 * y * height);
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
    }

    /// Returns the distance from the middle of the scene; at least the radius of a disc with the area of the outline.
    fn distance(&self, room: &Room) -> f64 {
        self.middle.distance(room.centre).max(0.5 * (self.outline() / PI).sqrt())
    }

    /// Returns the unit normal of the lamp toward the scene.
    fn normal(&self, room: &Room) -> DVec3 {
        let faced = match self.shape {
            LampShape::Rectangle { faces: Some(point), .. } => point,
            _ => room.centre,
        };
        (faced - self.middle).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// Returns the area of the outline, seen along the axis \[units of the scene, squared\].
    fn outline(&self) -> f64 {
        match self.shape {
            LampShape::Sphere { diameter } => PI * diameter * diameter / 4.0,
            LampShape::Rectangle { size: [width, height], .. } => width * height,
        }
    }

    /// Returns the area of the emitting surface.
    fn surface(&self) -> f64 {
        match self.shape {
            LampShape::Sphere { .. } => 4.0 * self.outline(),
            LampShape::Rectangle { .. } => self.outline(),
        }
    }
}

/// Returns the horizontal and the other axis of a surface with this `normal`.
fn axes(normal: DVec3) -> [DVec3; 2] {
    let across = DVec3::Z.cross(normal).try_normalize().unwrap_or(DVec3::X);
    [across, normal.cross(across)]
}

/// Returns the variance of the points of a disc along an axis.
fn variance_of_disc(diameter: f64) -> f64 {
    diameter * diameter / 16.0
}

/// Returns the variance of the points of a rectangle along a side.
fn variance_of_side(side: f64) -> f64 {
    side * side / 12.0
}

impl Strength {
    fn parse(text: &str, light: &str) -> Result<Self> {
        let number = text.trim().strip_suffix('W').unwrap_or(text).trim();
        let value = units::number(number).filter(|value| *value > 0.0 && *value <= STRONGEST);
        let value = value.ok_or_else(|| {
            Error::usage(
                format!("the strength '{}' in the light '{light}'", text.trim()),
                "give a radiance above 0, at most 1e12, or a power, as in 60W",
            )
        })?;
        Ok(if text.trim().ends_with('W') { Self::Power(value) } else { Self::Radiance(value) })
    }
}

impl fmt::Display for Lamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.shape {
            LampShape::Sphere { diameter } => write!(f, "sphere:{diameter}:")?,
            LampShape::Rectangle { size: [width, height], .. } => write!(f, "rectangle:{width}x{height}:")?,
        }
        let [x, y, z] = self.middle.to_array();
        write!(f, "{x},{y},{z}")?;
        match self.strength {
            Strength::Suited => {}
            Strength::Radiance(radiance) => write!(f, ",{radiance}")?,
            Strength::Power(power) => write!(f, ",{power}W")?,
        }
        match self.shape {
            LampShape::Rectangle { faces: Some(point), .. } => {
                write!(f, ":{},{},{}", point.x, point.y, point.z)
            }
            _ => Ok(()),
        }
    }
}

fn refused(text: &str, form: &'static str) -> Error {
    Error::usage(format!("'{text}' is not a light"), form)
}

fn size(text: &str, light: &str) -> Result<f64> {
    units::number(text.trim()).filter(|size| (SMALLEST..=FARTHEST).contains(size)).ok_or_else(|| {
        Error::usage(
            format!("the size '{text}' in the light '{light}'"),
            "give a number from 1e-9 to 1000000, in units of the scene",
        )
    })
}

fn coordinates(text: &str, light: &str, form: &'static str) -> Result<DVec3> {
    let point = units::triple(text).map_err(|_| refused(light, form))?;
    if point.iter().all(|x| x.abs() <= FARTHEST) {
        return Ok(point.into());
    }
    Err(Error::usage(
        format!("the place '{text}' in the light '{light}'"),
        "give coordinates within ±1000000",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Room = Room { centre: DVec3::new(0.5, -1.0, 0.25), unit: 0.1 };

    fn mean_over(lamp: &Lamp, count: u32, of: impl Fn(Incident) -> DVec3) -> DVec3 {
        let side = 60;
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let points = (0..side * side).map(|i| [place(i % side), place(i / side)]);
        points.map(|point| of(lamp.incident(point, count, &ROOM))).sum::<DVec3>() / f64::from(side * side)
    }

    #[test]
    fn what_is_written_is_read_again_and_other_words_are_refused() {
        for text in [
            "sphere:0.1:0.2,0,1",
            "sphere:0.1:0.2,0,1,60W",
            "rectangle:0.4x0.2:0,-1,1",
            "rectangle:0.4x0.2:0,-1,1,250:0,0,-1",
        ] {
            assert_eq!(Lamp::parse(text).unwrap().to_string(), text);
        }
        for wrong in [
            "sphere",
            "sphere:0:0,0,1",
            "sphere:-1:0,0,1",
            "sphere:1e-160:0,0,1",
            "rectangle:1e-170x1:0,0,1",
            "sphere:1:0,0",
            "sphere:1:0,0,1,0",
            "sphere:1:0,0,1,2,3",
            "sphere:1:0,0,1:0,0,0",
            "sphere:1:0,0,1e7",
            "sphere:inf:0,0,1",
            "rectangle:1:0,0,1",
            "rectangle:1x2:0,0,1:0,0,1",
            "rectangle:1x2:0,0,1,4:0,0,0:1,1,1",
            "rectangle:1x2:0,0,1,W",
        ] {
            assert_eq!(Lamp::parse(wrong).unwrap_err().kind(), crate::error::ErrorKind::Usage, "{wrong}");
        }
    }

    #[test]
    fn strengths_agree_with_closed_forms() {
        let toward = DVec3::new(2.0, 1.0, 2.0) / 3.0;
        let at = |text: &str| {
            let middle = ROOM.centre + 4.0 * toward;
            let text = text.replace('@', &format!("{},{},{}", middle.x, middle.y, middle.z));
            mean_over(&Lamp::parse(&text).unwrap(), 1 << 20, |incident| {
                let falloff = incident.place.unwrap().falloff(ROOM.centre);
                incident.irradiance.as_dvec3() * falloff * incident.direction.dot(toward)
            })
            .x
        };
        // E/π of a sphere of radius r at distance D is L r²/D²; of a small rectangle L A/(π D²).
        assert!((at("sphere:0.5:@,80") / (80.0 * (0.25f64 / 4.0).powi(2)) - 1.0).abs() < 1e-6);
        assert!((at("rectangle:0.02x0.01:@,80") / (80.0 * 2e-4 / (PI * 16.0)) - 1.0).abs() < 1e-4);
        assert!((at("sphere:0.5:@") - 1.0).abs() < 1e-6);
        assert!((at("rectangle:0.02x0.01:@") - 1.0).abs() < 1e-4);
        // P/(4π d²) of a sphere; P/(π d²) straight before a diffuse emitter; d = 0.4 m.
        assert!((at("sphere:0.5:@,60W") / (60.0 / (4.0 * PI * 0.16) / PI) - 1.0).abs() < 1e-6);
        assert!((at("rectangle:0.02x0.01:@,60W") / (60.0 / (PI * 0.16) / PI) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn points_and_what_each_stands_for_make_up_the_lamp() {
        for text in ["sphere:0.5:3,1,2", "rectangle:0.6x0.2:3,1,2"] {
            let lamp = Lamp::parse(text).unwrap();
            let normal = lamp.normal(&ROOM);
            let across = DVec3::Z.cross(normal).normalize();
            let variances = match lamp.shape {
                LampShape::Sphere { diameter } => [variance_of_disc(diameter); 2],
                LampShape::Rectangle { size, .. } => size.map(variance_of_side),
            };
            for count in [1, 5, 16, 1000] {
                let spread = mean_over(&lamp, count, |incident| {
                    let from_middle = incident.place.unwrap().point - lamp.middle;
                    let variance = DVec3::splat(incident.variance);
                    let [x, y] = [across, normal.cross(across)].map(|axis| from_middle.dot(axis).powi(2));
                    variance + DVec3::new(x, y, from_middle.dot(normal).powi(2))
                });
                assert!((spread.x / variances[0] - 1.0).abs() < 2e-3, "{text}, {count}: {spread}");
                assert!((spread.y / variances[1] - 1.0).abs() < 2e-3, "{text}, {count}: {spread}");
            }
        }
    }

    #[test]
    fn coherence_holds_a_part_of_a_lamp_and_its_light_stays() {
        let lamp = Lamp::parse("sphere:0.5:3,1,2,7").unwrap();
        let smaller = lamp.beyond(&Coherence::Gaussian { length: 20.0 }, &ROOM);
        let light = |lamp: &Lamp| lamp.incident([0.5; 2], 16, &ROOM).irradiance.x;
        assert!((light(&smaller) / light(&lamp) - 1.0).abs() < 1e-5);
        let (LampShape::Sphere { diameter: left }, LampShape::Sphere { diameter: whole }) =
            (smaller.shape, lamp.shape)
        else {
            panic!("the shape changed")
        };
        let held = spread_of(&Coherence::Gaussian { length: 20.0 }) * lamp.distance(&ROOM).powi(2);
        assert!((variance_of_disc(left) + held - variance_of_disc(whole)).abs() < 1e-9);
        let same = Lamp { strength: Strength::Radiance(lamp.radiance(&ROOM)), ..lamp };
        assert_eq!(lamp.beyond(&Coherence::Repeats([3, 3]), &ROOM), same);
    }
}
