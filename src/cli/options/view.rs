//! Options of camera, lights and display.

use super::{Exposure, exposure};
use crate::cli::console::Console;
use crate::error::{Error, Result};
use crate::optics::color::Tone;
use crate::scene::environment::{self, Placement};
use crate::scene::{Background, Camera, Environment, Lens, LensProjection, Light, Scene};
use crate::units;
use clap::Args;
use glam::Vec3;
use std::ffi::OsString;
use std::path::PathBuf;

/// Camera, lights and display, each instead of the scene's.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "View")]
pub struct ViewOptions {
    /// Exposure in stops, instead of the scene's. auto displays the log-average luminance of the lit pixels as middle grey, to a tenth of a
    /// stop; it is measured in one sample a pixel of the first picture and holds for all of a sequence, whichever part of it is drawn
    #[arg(long, value_name = "EV|auto", value_parser = Exposure::parse, allow_hyphen_values = true)]
    pub exposure: Option<Exposure>,
    /// Tone curve for highlights, instead of the scene's: none (moved to the edge of the gamut) or neutral (softly to white, with their
    /// hue: the Khronos PBR Neutral Tone Mapper) [default: none]
    #[arg(long, value_name = "NAME", value_parser = Tone::from_name, hide_short_help = true)]
    pub tone: Option<Tone>,
    /// A light instead of the scene's lights and surroundings, in degrees from up and around it; give it again for more lights. A point, or
    /// sun:THETA,PHI (0.533 degrees across), or disc:SIZE:THETA,PHI as in disc:5deg:40,90. Or a lamp in the scene, in the scene's units:
    /// sphere:DIAMETER:X,Y,Z[,STRENGTH] or rectangle:WIDTHxHEIGHT:X,Y,Z[,STRENGTH][:X,Y,Z that it faces], as in rectangle:0.4x0.2:0,-1,1.
    /// STRENGTH is a radiance, or a power as in 60W; without it the middle of the scene gets the light of intensity 1. A spectrum for this
    /// light alone follows @, a name or file as for --illuminant, as in sun:40,90@a
    #[arg(long, value_name = "[KIND:]THETA,PHI[,INTENSITY][@SPECTRUM]", value_parser = Light::parse, allow_hyphen_values = true)]
    pub light: Vec<Light>,
    /// Surroundings that light the scene beside its lights, instead of the scene's: sky (overcast), studio, an equirectangular .exr or .hdr
    /// picture, or none
    #[arg(long, value_name = "NAME|FILE")]
    pub environment: Option<OsString>,
    /// Rotation of the surroundings about the world's up, as in 90deg
    #[arg(long, value_name = "ANGLE", value_parser = units::angle, allow_hyphen_values = true, hide_short_help = true)]
    pub rotate_environment: Option<f64>,
    /// Brightness of the surroundings in stops
    #[arg(long, value_name = "EV", value_parser = exposure, allow_hyphen_values = true, hide_short_help = true)]
    pub environment_exposure: Option<f64>,
    /// Shadows of the mesh on itself, instead of the scene's setting
    #[arg(long, value_name = "on|off", value_parser = switch, hide_short_help = true)]
    pub shadows: Option<bool>,
    /// Position of the camera, instead of the scene's
    #[arg(long, value_name = "X,Y,Z", value_parser = units::triple, allow_hyphen_values = true, hide_short_help = true)]
    pub eye: Option<[f64; 3]>,
    /// Point that the camera looks at, instead of the scene's
    #[arg(long, value_name = "X,Y,Z", value_parser = units::triple, allow_hyphen_values = true, hide_short_help = true)]
    pub target: Option<[f64; 3]>,
    /// Vertical field of view, as in 35deg, instead of the scene's
    #[arg(long, value_name = "ANGLE", value_parser = units::angle, allow_hyphen_values = true, hide_short_help = true)]
    pub field_of_view: Option<f64>,
    /// Orthographic camera that shows this height, in the scene's units, instead of the scene's lens
    #[arg(long, value_name = "HEIGHT", value_parser = units::positive, allow_hyphen_values = true, conflicts_with = "field_of_view", hide_short_help = true)]
    pub orthographic: Option<f64>,
    /// Rotation of the camera about its axis, clockwise as its user sees it, as in 10deg, instead of the scene's
    #[arg(long, value_name = "ANGLE", value_parser = units::angle, allow_hyphen_values = true, hide_short_help = true)]
    pub roll: Option<f64>,
    /// Shift of the picture's middle from the camera's axis, to the right and up, in heights of the picture, instead of the scene's
    #[arg(long, value_name = "X,Y", value_parser = units::pair, allow_hyphen_values = true, hide_short_help = true)]
    pub lens_shift: Option<[f64; 2]>,
    /// Background behind the mesh, instead of the scene's: a colour, linear sRGB from 0 to 1, or the surroundings. It makes a PNG opaque; an EXR has none
    #[arg(long, value_name = "R,G,B|surroundings", value_parser = Background::parse, allow_hyphen_values = true, hide_short_help = true)]
    pub background: Option<Background>,
    /// Albedo of the pigment, linear sRGB from 0 to 1, instead of the scene's
    #[arg(long, value_name = "R,G,B", value_parser = units::color, allow_hyphen_values = true, hide_short_help = true)]
    pub base_color: Option<[f64; 3]>,
}

impl ViewOptions {
    /// Applies the options to `scene`.
    ///
    /// # Errors
    /// An impossible camera; surroundings that cannot be read.
    pub fn apply(&self, scene: &mut Scene, console: &Console) -> Result<()> {
        light_by(&self.light, scene);
        self.apply_environment(scene, console)?;
        if let Some(exposure) = self.exposure {
            scene.display.auto_exposure = exposure == Exposure::Auto;
            if let Exposure::Stops(stops) = exposure {
                scene.display.exposure = stops;
            }
        }
        if let Some(tone) = self.tone {
            scene.display.tone = tone;
        }
        if let Some(color) = self.base_color {
            scene.main_object_mut().base_color = color.map(|c| c as f32).into();
        }
        if let Some(background) = self.background {
            if background == Background::Surroundings && scene.environment.is_none() {
                return Err(Error::usage(
                    "there are no surroundings to be the background",
                    "add --environment sky, or give --background a colour",
                ));
            }
            (scene.display.background, scene.display.is_opaque) = (background, true);
        }
        self.apply_camera(scene)
    }

    /// Applies the options of the camera to `scene`.
    fn apply_camera(&self, scene: &mut Scene) -> Result<()> {
        let old = scene.camera;
        let radians = |degrees: f64| degrees.to_radians() as f32;
        let height = self.orthographic.map(|height| LensProjection::Orthographic { height: height as f32 });
        let angle =
            self.field_of_view.map(|angle| LensProjection::Perspective { field_of_view: radians(angle) });
        let lens = Lens {
            projection: height.or(angle).unwrap_or(old.lens.projection),
            roll: self.roll.map_or(old.lens.roll, radians),
            shift: self.lens_shift.map_or(old.lens.shift, |shift| shift.map(|x| x as f32)),
        };
        if self.eye.is_some() || self.target.is_some() {
            let vector = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
            let eye = self.eye.map_or(old.eye(), vector);
            scene.camera = Camera::looking(eye, self.target.map_or(old.target, vector), lens)?;
        } else {
            // Angles that are kept are not computed again from an eye.
            lens.check()?;
            scene.camera.lens = lens;
        }
        Ok(())
    }
}

impl ViewOptions {
    /// Returns the files that the options name, without built-in names.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let environment = self.environment.as_deref();
        let environment = environment.filter(|name| *name != "none" && !environment::is_built_in(name));
        let spectra =
            self.light.iter().filter_map(|light| light.spectrum.as_ref()?.file().map(PathBuf::from));
        environment.map(PathBuf::from).into_iter().chain(spectra)
    }

    /// Applies the options of surroundings and shadows to `scene`.
    fn apply_environment(&self, scene: &mut Scene, console: &Console) -> Result<()> {
        scene.shadows = self.shadows.unwrap_or(scene.shadows);
        match self.environment.as_deref() {
            None => {}
            Some(name) if name == "none" => scene.environment = None,
            Some(name) => scene.environment = Some(Environment::open(name)?),
        }
        let placed = self.rotate_environment.is_some() || self.environment_exposure.is_some();
        match &mut scene.environment {
            None if placed => {
                return Err(Error::usage(
                    "--rotate-environment and --environment-exposure are about surroundings, and the scene has none",
                    "add --environment sky, or leave them away",
                ));
            }
            None => {}
            Some(environment) => {
                if let Some(note) = environment.note() {
                    console.say(&note);
                }
                let old = environment.placement;
                environment.placement = Placement::new(
                    self.rotate_environment.unwrap_or(old.rotation),
                    self.environment_exposure.unwrap_or(old.exposure),
                )?;
            }
        }
        Ok(())
    }
}

/// Lights `scene` by `named` alone, without surroundings, if the user names any.
pub fn light_by(named: &[Light], scene: &mut Scene) {
    if !named.is_empty() {
        scene.lights = named.to_vec();
        scene.environment = None;
    }
}

fn switch(text: &str) -> Result<bool> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(Error::usage(format!("`{text}` is neither on nor off"), "give on or off")),
    }
}
