//! Options in a scene file. They stand before those of the user, which replace them.

use super::usage_error::in_one_line;
use super::{Arguments, Command};
use crate::error::{Error, Result};
use crate::scene::scene_file;
use clap::{CommandFactory, FromArgMatches};
use std::ffi::{OsStr, OsString};

/// Returns the arguments of `words` (the program's name first) with the options of the scene file that they name; `None` if the file has
/// none. `arguments` are those of `words` alone.
///
/// # Errors
/// A scene file that cannot be read, and options that no picture has.
pub fn with_those_of_the_scene(words: &[OsString], arguments: &Arguments) -> Result<Option<Arguments>> {
    let (command, scene) = match &arguments.command {
        #[cfg(feature = "viewer")]
        Command::View(arguments) => ("view", arguments.scene()),
        Command::Render(arguments) => ("render", arguments.scene()),
        Command::Profile(arguments) => ("profile", arguments.benchmark.scene.as_os_str()),
        _ => return Ok(None),
    };
    let Some(options) = of(scene, command)? else { return Ok(None) };
    let program = Arguments::command().mut_subcommand(command, |c| c.args_override_self(true));
    // Global options may stand before the command.
    let place = words.iter().position(|word| word == command).map_or(words.len(), |place| place + 1);
    let all = [&words[..place], &options, &words[place..]].concat();
    let matches = program.try_get_matches_from(all);
    let expanded = matches.and_then(|matches| Arguments::from_arg_matches(&matches));
    expanded.map(Some).map_err(|e| in_one_line(&e, command).at(scene.display()))
}

/// Returns the options of the scene called `scene`, as `command` takes them; `None` if it has none.
///
/// # Errors
/// See [`with_those_of_the_scene`].
pub fn of(scene: &OsStr, command: &str) -> Result<Option<Vec<OsString>>> {
    let options = scene_file::options_of(scene)?;
    let program = Arguments::command();
    let knows = |command: &str, option: &str| {
        let found = program.find_subcommand(command);
        found.is_some_and(|c| c.get_arguments().any(|argument| argument.get_long() == Some(option)))
    };
    let mut words = Vec::new();
    for [name, value] in &options {
        if !OF_SCENES.contains(&name.as_str()) {
            let what = format!("options: `{name}` is no option of a scene");
            return Err(
                Error::input(what, format!("give some of {}", OF_SCENES.join(", "))).at(scene.display())
            );
        }
        // Other commands compute less: options that they lack do not concern them.
        if knows(command, name) {
            words.push(OsString::from(format!("--{name}={value}")));
        }
    }
    Ok((!words.is_empty()).then_some(words))
}

/// Options that a scene file may hold: the surface and its optics.
pub const OF_SCENES: [&str; 16] = [
    "method",
    "windows",
    "beyond",
    "basis",
    "tolerance",
    "terms",
    "wavelengths",
    "coherence",
    "ior",
    "reflectance",
    "film",
    "polarisation",
    "illuminant",
    "samples",
    "seed",
    "channel",
];

#[cfg(test)]
mod tests {
    use super::super::usage::{Understood, understand};
    use super::*;

    #[test]
    fn options_of_a_scene_stand_until_the_user_gives_another() {
        let folder = tempfile::tempdir().unwrap();
        let scene = |options: &str| {
            let plate = scene_file::BUILT_IN[1].1;
            let path = folder.path().join("a scene.toml");
            std::fs::write(&path, format!("{plate}\n[options]\n{options}")).unwrap();
            path
        };
        let render = |scene: &std::path::Path, more: &[&str]| {
            let words = ["diffract", "-q", "render", "-o", "a.png"].map(OsString::from);
            let more = more.iter().map(OsString::from);
            understand(words.into_iter().chain(more).chain([scene.into()])).map(|wanted| match wanted {
                Understood::Work(arguments) => format!("{arguments:?}"),
                Understood::Help(_) => panic!("help"),
            })
        };
        let saved = scene("tolerance = 0.05\nsamples = \"4\"\ncoherence = \"gaussian:40um\"\n");
        let plain = render(&saved, &[]).unwrap();
        for part in ["tolerance: Some(0.05)", "samples: 4", "length: 40.0"] {
            assert!(plain.contains(part), "{part}: {plain}");
        }
        let other = render(&saved, &["--tolerance", "1e-1"]).unwrap();
        assert!(other.contains("tolerance: Some(0.1)") && other.contains("samples: 4"), "{other}");
        for (wrong, said) in [
            ("output = \"b.png\"", "`output` is no option of a scene"),
            ("tolerance = true", "give a text or a number"),
            ("tolerance = 7", "`7` is no tolerance"),
        ] {
            let e = render(&scene(wrong), &[]).unwrap_err().to_string();
            assert!(e.contains(said) && e.contains("a scene.toml"), "{wrong}: {e}");
        }
    }
}
