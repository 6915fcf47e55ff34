//! Options of the mesh and of the surface's place on it, with the words of scene files.

use crate::error::{Error, Result};
use crate::scene::object::Up;
use crate::scene::{Grooves, SceneOverrides};
use crate::units;
use clap::Args;
use std::path::{Path, PathBuf};

/// Unit, axis and grooves of the mesh, each instead of the scene's.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Mesh")]
pub struct MeshOptions {
    /// Direction of the surface's x on the first mesh, from that of growing u, instead of the scene's: an angle as in 90deg, radial (away from the
    /// middle of the texture), or a picture over (u, v) whose grey is the angle, from black for 0 to white for 360 degrees
    #[arg(long, value_name = "ANGLE|radial|FILE", value_parser = grooves, allow_hyphen_values = true, hide_short_help = true)]
    grooves: Option<Grooves>,
    /// Length of one unit of the scene, as in 120mm, instead of the scene's
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true, hide_short_help = true)]
    scale: Option<f64>,
    /// Axis of the mesh file that points up, instead of the scene's [default: z in .ply and .stl, y in others]
    #[arg(long, value_name = "y|z", value_parser = up, hide_short_help = true)]
    up: Option<Up>,
}

impl MeshOptions {
    /// Returns the settings that the options give instead of the scene's.
    pub fn overrides(&self) -> SceneOverrides {
        SceneOverrides { scale: self.scale, up: self.up, grooves: self.grooves.clone() }
    }

    /// Returns the picture of the grooves, if there is one.
    pub fn files(&self) -> Option<&PathBuf> {
        self.grooves.as_ref().and_then(Grooves::file)
    }
}

fn grooves(text: &str) -> Result<Grooves> {
    if text.trim().is_empty() {
        return Err(Error::usage(
            "grooves have no direction",
            "give an angle as in 90deg, radial, or a picture",
        ));
    }
    Grooves::parse(text, Path::new(""))
}

fn up(text: &str) -> Result<Up> {
    match text {
        "y" => Ok(Up::Y),
        "z" => Ok(Up::Z),
        _ => Err(Error::usage(format!("`{text}` is no axis that points up"), "give y or z")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_scene_files() {
        assert_eq!(grooves("90deg").unwrap(), Grooves::Turned(90.0));
        assert_eq!(grooves("radial").unwrap(), Grooves::Radial);
        assert_eq!(grooves("a.png").unwrap(), Grooves::Map("a.png".into()));
        assert_eq!((up("y").unwrap(), up("z").unwrap()), (Up::Y, Up::Z));
        assert!(up("x").is_err() && grooves("xdeg").is_err() && grooves(" ").is_err());
    }
}
