//! Parsing of the process's words into arguments; wrong use becomes a one-line error of the program.

use super::usage_error::in_one_line;
use super::{Arguments, scene_options, short_help};
use crate::error::Result;
use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Result of parsing a command line.
pub enum Understood {
    /// Command to run.
    Work(Box<Arguments>),
    /// Help or version, to be written.
    Help(clap::Error),
}

/// Parses `words`, the program's name first.
///
/// # Errors
/// Words that cannot be meant: names the option, the value and the command for help.
pub fn understand(words: impl IntoIterator<Item = OsString>) -> Result<Understood> {
    let words: Vec<OsString> = words.into_iter().collect();
    let matches = short_help::add(Arguments::command()).try_get_matches_from(&words);
    match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => {
            let expanded = scene_options::with_those_of_the_scene(&words, &arguments)?;
            Ok(Understood::Work(Box::new(expanded.unwrap_or(arguments))))
        }
        Err(e) if matches!(e.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            Ok(Understood::Help(e))
        }
        Err(e) => Err(in_one_line(&e, &command(&words))),
    }
}

/// Returns the command that the first words name, as in `diffract surface synth`.
fn command(words: &[OsString]) -> String {
    let mut command = Arguments::command();
    let mut named = command.get_name().to_owned();
    for word in words.iter().skip(1) {
        let Some(next) = word.to_str().and_then(|word| command.find_subcommand(word)).cloned() else { break };
        named = format!("{named} {}", next.get_name());
        command = next;
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(line: &str) -> String {
        let e = understand(line.split(' ').map(OsString::from)).err().unwrap();
        assert_eq!(e.kind(), crate::error::ErrorKind::Usage, "{line}");
        e.to_string()
    }

    #[test]
    fn wrong_use_names_option_value_and_help() {
        for (line, parts) in [
            ("diffract", &["no command", "`diffract --help`"][..]),
            ("diffract surface", &["no command", "`diffract surface --help`"]),
            ("diffract rendr", &["rendr", "do you mean render?", "`diffract --help`"]),
            ("diffract render", &["--output", "`diffract render --help`"]),
            ("diffract render -o a.png --sise 3x3", &["--sise", "do you mean --size?"]),
            ("diffract render -o a.png --size 3", &["--size", "'3'", "1280x720", "`diffract render --help`"]),
            ("diffract render -o a.png --size", &["--size", "value"]),
            ("diffract render -o a.png --ior 1 --ior 2", &["--ior", "multiple times"]),
            ("diffract eval --queries q --ior -1", &["--ior", "`-1`", "from 1 to 10"]),
            ("diffract eval --queries q --method x", &["--method", "'x'", "spectral, table, reference"]),
            ("diffract surface synth blaze -o a.png --seed -1", &["--seed", "`-1`", "whole number"]),
        ] {
            let said = wrong(line);
            for part in parts {
                assert!(said.contains(part), "{line}: {part} is missing in: {said}");
            }
        }
    }
}
