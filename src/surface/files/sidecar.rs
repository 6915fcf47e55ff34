//! Scales in a file beside an image: `scan.toml` or `scan.tif.toml` beside `scan.tif`.
//!
//! `pixel_size = "10nm"` and `height = "138.5nm"` have the meaning of [`ReadSettings`](super::ReadSettings).

use crate::error::{Error, Result};
use crate::{input, units};
use serde::Deserialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Scales in a sidecar.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sidecar {
    /// Distance of samples along `x` and `y` \[µm\].
    pub pixel_size: Option<[f64; 2]>,
    /// Height of the largest code \[µm\].
    pub height: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SidecarFields {
    pixel_size: Option<String>,
    height: Option<String>,
}

impl Sidecar {
    /// Reads the sidecar of `path`; returns an empty one if there is none.
    ///
    /// # Errors
    /// A file of that name with scales that cannot be meant.
    pub fn beside(path: &Path) -> Result<Self> {
        let mut longer = OsString::from(path.as_os_str());
        longer.push(".toml");
        for place in [PathBuf::from(longer), path.with_extension("toml")] {
            if place != path && place.is_file() {
                let text = input::read_text(&place, "a file of scales")?;
                if let Some(sidecar) = Self::parse(&text).map_err(|e| e.at(place.display()))? {
                    return Ok(sidecar);
                }
            }
        }
        Ok(Self::default())
    }

    /// Parses the scales in `text`; `None` if it is about something else, such as a scene.
    ///
    /// # Errors
    /// A scale that is no length, an entry beside the scales, or scales in a text that is no TOML.
    pub fn parse(text: &str) -> Result<Option<Self>> {
        const SCALES: [&str; 2] = ["pixel_size", "height"];
        let is_ours = match text.parse::<toml::Table>() {
            Ok(table) => SCALES.iter().any(|name| table.contains_key(*name)) && !table.contains_key("mesh"),
            // Damaged: ours if a line of it gives a scale; what is wrong is told below.
            Err(_) => text.lines().any(|line| SCALES.iter().any(|name| line.trim_start().starts_with(name))),
        };
        if !is_ours {
            return Ok(None);
        }
        let file: SidecarFields = toml::from_str(text).map_err(|e| {
            Error::input(e.message().to_owned(), "write pixel_size and height, as in \"10nm\"").caused_by(e)
        })?;
        Ok(Some(Self {
            pixel_size: file.pixel_size.as_deref().map(units::length_pair).transpose()?,
            height: file.height.as_deref().map(units::length).transpose()?,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_read_and_scenes_are_left_alone() {
        let sidecar = Sidecar::parse("pixel_size = \"10nmx12nm\"\nheight = \"138.5nm\"\n").unwrap().unwrap();
        assert_eq!(sidecar, Sidecar { pixel_size: Some([0.01, 0.012]), height: Some(0.1385) });
        assert_eq!(Sidecar::parse("mesh = \"plate\"\npixel_size = \"10nm\"\n").unwrap(), None);
        assert_eq!(Sidecar::parse("name = 3\n").unwrap(), None);
        assert_eq!(Sidecar::parse("no toml").unwrap(), None);
        assert!(Sidecar::parse("pixel_size = \"10\"\n").is_err());
        assert!(Sidecar::parse("pixel_size = 10nm\n").is_err());
        assert!(Sidecar::parse("pixel_size = \"10nm\"\ncolour = 1\n").is_err());
    }

    #[test]
    fn either_name_is_found_and_the_longer_one_first() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.tif");
        assert_eq!(Sidecar::beside(&path).unwrap(), Sidecar::default());
        std::fs::write(folder.path().join("scan.toml"), "height = \"1um\"\n").unwrap();
        assert_eq!(Sidecar::beside(&path).unwrap().height, Some(1.0));
        std::fs::write(folder.path().join("scan.tif.toml"), "height = \"2um\"\n").unwrap();
        assert_eq!(Sidecar::beside(&path).unwrap().height, Some(2.0));
    }
}
