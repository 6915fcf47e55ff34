//! `diffract view`: a scene in a window.

use super::console::Console;
use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, MeshOptions, OpticsOptions, SurfaceOptions, ViewOptions, real,
};
use super::{check_validation, last_view, prepare, scene_options, usage_error, view_command};
use crate::error::{Error, Result};
use crate::settings::Method;
use crate::task::Task;
use crate::units;
use crate::viewer::{self, LastView, SceneFiles, Start, ViewSettings};
use ash::vk;
use clap::{Args, CommandFactory, FromArgMatches, Parser, ValueEnum};
use std::ffi::{OsStr, OsString};
use std::sync::Arc;

/// Arguments of `view`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract view
  diffract view disc --surface blaze
  diffract view mesh.obj --surface scan.png --pixel-size 48.83nm --height 434.7nm

Left drag orbits, right drag moves the light, the wheel zooms. F1 lists all keys.
S saves the picture with the `diffract render` that draws the same.
The next window offers to continue where this one was closed.")]
pub struct Arguments {
    /// snake, plate, sphere, disc, cd, skin, a scene file (.toml) or a mesh (.obj, .gltf, .glb, .ply, .stl)
    #[arg(default_value = "snake")]
    scene: OsString,
    /// Width and height of the window in pixels, times the scale of the display
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "1280x800")]
    size: [u32; 2],
    /// Samples a pixel that are summed while nothing moves, as by render: 1 to 4096; 1 looks at pixel centres only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), allow_hyphen_values = true, default_value = "64", hide_short_help = true)]
    samples: u32,
    /// Frames a second to keep up while something moves, by leaving work out
    #[arg(long, value_name = "N", value_parser = fps, allow_hyphen_values = true, default_value = "15", hide_short_help = true)]
    fps: f64,
    /// Presentation of frames; immediate and mailbox do not wait for the display
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    present: Present,
    #[command(flatten)]
    view: ViewOptions,
    #[command(flatten)]
    mesh: MeshOptions,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

impl Arguments {
    /// Returns the scene.
    pub fn scene(&self) -> &OsStr {
        &self.scene
    }
}

/// Presentation mode of the window.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Present {
    /// One after another, at the display's pace
    #[default]
    Fifo,
    /// The newest at the display's pace
    Mailbox,
    /// At once
    Immediate,
}

/// Checks a name that the window shows and writes into commands.
fn utf8(name: &OsStr) -> Result<String> {
    name.to_str().map(str::to_owned).ok_or_else(|| {
        let what = format!("the name {name:?} is not UTF-8, and the window writes it into commands");
        Error::usage(what, "rename the file, or draw it with `diffract render`")
    })
}

fn fps(text: &str) -> Result<f64> {
    real(text, (0.1, 1000.0), "number of frames a second")
}

/// Opens the window.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    check_validation(&viewer::run(start(arguments, console)?)?)
}

/// Returns the start settings of a window from `arguments`.
///
/// # Errors
/// Settings that do not fit together, and files that cannot be read.
pub fn start(arguments: &Arguments, console: &Console) -> Result<Start> {
    let optics = arguments.optics.for_pictures(&arguments.colour, console)?;
    if optics.method == Method::Reference {
        return Err(Error::usage(
            "--method reference is too slow for a window",
            "leave it out; E in the window measures the error against the reference",
        ));
    }
    utf8(&arguments.colour.illuminant)?;
    let mut plain = prepare::scene(console, &arguments.scene, &arguments.mesh.overrides())?;
    let mut scene = plain.clone();
    let optics = arguments.optics.material_of(&scene, optics);
    arguments.view.apply(&mut scene, console)?;
    // The window has no controls for them.
    plain.environment.clone_from(&scene.environment);
    plain.shadows = scene.shadows;
    (plain.display.background, plain.display.is_opaque) = (scene.display.background, scene.display.is_opaque);
    let surface = arguments.surface.source(None, Some(&scene), "elaphe")?;
    if surface.kind().is_none() {
        surface.load(&Task::silent())?; // a file that is none is told before a window opens
    }
    let settings = ViewSettings {
        scene: utf8(&arguments.scene)?,
        surface,
        optics,
        surroundings: viewer::placement(&scene),
        exposure: scene.display.exposure,
        tone: scene.display.tone,
        base_color: scene.main_object().base_color,
        camera: scene.camera,
        lights: scene.lights,
        samples: arguments.samples,
    };
    let (of_scenes, of_last) = (console.clone(), console.clone());
    let open_scene = move |name: &str| open(name, &of_scenes);
    let open_last = move || last(&of_last);
    Ok(Start {
        measures_exposure: scene.display.auto_exposure,
        settings,
        plain,
        size: arguments.size,
        fps: arguments.fps,
        present: match arguments.present {
            Present::Fifo => vk::PresentModeKHR::FIFO,
            Present::Mailbox => vk::PresentModeKHR::MAILBOX,
            Present::Immediate => vk::PresentModeKHR::IMMEDIATE,
        },
        context: console.context().clone(),
        command_line: view_command::render,
        scenes: SceneFiles { open: Arc::new(open_scene), write: view_command::write_scene },
        last: LastView {
            is_kept: last_view::is_kept(),
            keep: last_view::keep,
            open: Arc::new(open_last),
            recent: last_view::recent,
            keep_recent: last_view::keep_recent,
        },
    })
}

/// Arguments of `view` without a program and a command.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct ViewLine {
    #[command(flatten)]
    arguments: Arguments,
}

/// Returns the start settings of a window that continues the last one.
fn last(console: &Console) -> Result<Start> {
    let words = last_view::words()?;
    let understood = understood(&words)
        .map_err(|e| last_view::damaged(&e.to_string().lines().next().unwrap_or_default()))?;
    start(&understood?, console)
}

/// Returns the start settings of a window of the scene called `name`.
fn open(name: &str, console: &Console) -> Result<Start> {
    let understood = understood(&[name.into()]).map_err(|e| usage_error::in_one_line(&e, "diffract view"))?;
    start(&understood?, console)
}

/// Parses `words` without a program and a command, with the options of their scene; the inner result has the error of those options.
fn understood(words: &[OsString]) -> std::result::Result<Result<Arguments>, clap::Error> {
    let arguments = ViewLine::try_parse_from(words)?.arguments;
    Ok(match scene_options::of(&arguments.scene, "view") {
        Ok(None) => Ok(arguments),
        Ok(Some(options)) => {
            let command = ViewLine::command().args_override_self(true);
            let matches = command.try_get_matches_from(options.iter().chain(words))?;
            Ok(ViewLine::from_arg_matches(&matches)?.arguments)
        }
        Err(e) => Err(e),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_that_the_panel_names_are_those_of_view() {
        let command = Arguments::augment_args(clap::Command::new("view"));
        let options: Vec<String> =
            command.get_arguments().filter_map(|a| a.get_long().map(|long| format!("--{long}"))).collect();
        for row in viewer::ROWS {
            let Some(option) = row.option.filter(|option| option.starts_with("--")) else { continue };
            for name in option.split([' ', ',']).filter(|word| word.starts_with("--")) {
                assert!(options.iter().any(|known| known == name), "{}: {option}", row.label);
            }
        }
    }
}
