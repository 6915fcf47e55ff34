//! Options that name a height field and its preparation.

use super::preparation::PreparationOptions;
use super::seed;
use crate::cli::console::Console;
use crate::cli::progress::surface_task;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::surface::files::Topography;
use crate::surface::files::plausible::HeightSource;
use crate::surface::synth::SurfaceKind;
use crate::surface::{HeightField, SurfaceSource, files};
use crate::units;
use clap::Args;
use std::borrow::Cow;
use std::ffi::{OsStr, OsString};

/// Surface of commands whose user names none.
const DEFAULT_SURFACE: &str = "elaphe";

/// The height field.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceOptions {
    /// Height field: a file or the name of a built-in surface
    #[arg(long, value_name = "FILE|BUILTIN", help = surface_help())]
    pub surface: Option<OsString>,
    /// Distance between samples, as in 48.83nm or 80nmx90nm, instead of the file's
    #[arg(long, value_name = "LENGTH", value_parser = units::length_pair, allow_hyphen_values = true)]
    pub pixel_size: Option<[f64; 2]>,
    /// Height of an image's largest code, as in 434.7nm; full height of a built-in surface, or of a file instead of the file's
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true)]
    pub height: Option<f64>,
    /// Channel of a file that has several, by name or number [default: the first height]
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub channel: Option<String>,
    /// Seed of a random built-in surface, and of the positions in a pixel of `--samples`
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true, default_value = "1", hide_short_help = true)]
    pub seed: u64,
    #[command(flatten)]
    preparation: PreparationOptions,
}

/// Returns the help of the surface: extensions of files, and names of built-in surfaces.
fn surface_help() -> String {
    let names = SurfaceKind::ALL.map(SurfaceKind::name).join(", ");
    format!("Height field: a file ({}), or {names}", files::dotted_extensions())
}

impl SurfaceOptions {
    /// Returns the file of the surface; `None` for a built-in one.
    pub fn files<'a>(&'a self, positional: Option<&'a OsStr>) -> Option<&'a OsStr> {
        let built_in = |name: &OsStr| name.to_str().and_then(SurfaceKind::from_name).is_some();
        positional.or(self.surface.as_deref()).filter(|name| !built_in(name))
    }

    /// Returns the name of the surface, which is the default one unless there is another.
    pub fn name<'a>(&'a self, positional: Option<&'a OsStr>) -> Cow<'a, str> {
        let named = positional.or(self.surface.as_deref());
        named.map_or(DEFAULT_SURFACE.into(), OsStr::to_string_lossy)
    }

    /// Loads and prepares the height field that the options name, or that of `scene`, or `fallback`.
    pub fn load(
        &self,
        positional: Option<&OsStr>,
        scene: Option<&Scene>,
        fallback: &str,
        console: &Console,
    ) -> Result<HeightField> {
        let source = self.source(positional, scene, fallback)?;
        source.prepare(self.read(&source, console)?.into_field()?, &surface_task(console))
    }

    /// Reads the heights of `source` without preparation; prints the warnings about them.
    pub fn read(&self, source: &SurfaceSource, console: &Console) -> Result<Topography> {
        let scan = source.read(&surface_task(console))?;
        let warnings = match scan.origin() {
            Some(origin) => origin.warnings.clone(),
            // A generated surface is as high and as wide as asked.
            None => scan.questions(HeightSource::Given),
        };
        for warning in warnings {
            console.say(&format_args!("{}: {warning}", source.name.display()));
        }
        Ok(scan)
    }

    /// Returns the source that [`SurfaceOptions::load`] loads.
    pub fn source(
        &self,
        positional: Option<&OsStr>,
        scene: Option<&Scene>,
        fallback: &str,
    ) -> Result<SurfaceSource> {
        if positional.is_some() && self.surface.is_some() {
            return Err(Error::usage(
                "the surface is given twice",
                "give it as an argument or by --surface, not both",
            ));
        }
        // A scene's units and steps belong to the scene's surface.
        let named = positional.or(self.surface.as_deref()).map(SurfaceSource::named);
        let base = named.or_else(|| scene.map(Scene::main_surface));
        let base = base.unwrap_or_else(|| SurfaceSource::named(OsStr::new(fallback)));
        Ok(SurfaceSource {
            name: base.name,
            pixel_size: self.pixel_size.or(base.pixel_size),
            height: self.height.or(base.height),
            channel: self.channel.clone(),
            prepare: self.preparation.steps().unwrap_or(base.prepare),
            seed: self.seed,
        })
    }
}
