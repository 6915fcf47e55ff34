//! The options that name a height field and say what is done to it before use.

use super::preparation::PreparationOptions;
use super::seed;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::surface::synth::Kind;
use crate::surface::{HeightField, Source};
use crate::units;
use clap::Args;

/// The height field.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceOptions {
    /// Height field: a PNG or TIFF file, or flat, sinusoid, blaze, bumps, elaphe, xenopeltis
    #[arg(long, value_name = "FILE|BUILTIN")]
    pub surface: Option<String>,
    /// Distance between samples, as in 97.66nm or 80nmx90nm
    #[arg(long, value_name = "LENGTH", value_parser = units::length_pair, allow_hyphen_values = true)]
    pub pixel_size: Option<[f64; 2]>,
    /// Height that the file's largest code stands for, as in 434.7nm; full height of a built-in
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true)]
    pub height: Option<f64>,
    /// Which one of the many skins of one kind, and where in a pixel `--samples` look
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true, default_value = "1")]
    pub seed: u64,
    #[command(flatten)]
    preparation: PreparationOptions,
}

impl SurfaceOptions {
    /// The file that the options name, if it is one and not a built-in.
    pub fn files<'a>(&'a self, positional: Option<&'a str>) -> Option<&'a str> {
        positional.or(self.surface.as_deref()).filter(|name| Kind::from_name(name).is_none())
    }

    /// The height field that the options name, or `scene`'s, or `fallback`, prepared.
    pub fn load(
        &self,
        positional: Option<&str>,
        scene: Option<&Scene>,
        fallback: &str,
    ) -> Result<HeightField> {
        self.source(positional, scene, fallback)?.load()
    }

    /// What [`SurfaceOptions::load`] loads.
    pub fn source(&self, positional: Option<&str>, scene: Option<&Scene>, fallback: &str) -> Result<Source> {
        if positional.is_some() && self.surface.is_some() {
            return Err(Error::usage(
                "the surface is given twice",
                "give it as an argument or by --surface, not both",
            ));
        }
        let own = positional.or(self.surface.as_deref());
        let name = own.or(scene.map(|s| s.surface.as_str())).unwrap_or(fallback);
        // A scene's units and steps belong to the scene's surface.
        let of_scene = scene.filter(|_| own.is_none());
        let pixel_size = self.pixel_size.or(of_scene.and_then(|s| s.pixel_size));
        let height = self.height.or(of_scene.and_then(|s| s.full_height));
        let steps_of_scene = || of_scene.map(|s| s.prepare.clone()).unwrap_or_default();
        let prepare = self.preparation.steps().unwrap_or_else(steps_of_scene);
        Ok(Source { name: name.to_owned(), pixel_size, height, prepare, seed: self.seed })
    }
}
