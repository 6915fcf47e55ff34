//! The short help, `-h`: the usual options in a sentence each. `--help` has all options, whole texts and examples.

use clap::{Arg, Command};

/// Last line of a short help.
const CLOSING: &str = "These are the usual options. --help shows all of them, with examples.";

/// Returns `command` and the commands below it with a short help where some of their options are not usual ([`Arg::hide_short_help`]).
pub fn add(command: Command) -> Command {
    let command = command.mut_subcommands(add);
    if !command.get_arguments().any(Arg::is_hide_short_help_set) {
        return command;
    }
    let whole = command.get_after_help().cloned().unwrap_or_default();
    command.mut_args(summarised).after_help(CLOSING).after_long_help(whole)
}

/// Returns `argument` with the beginning of its help in the short one.
fn summarised(argument: Arg) -> Arg {
    let Some(whole) = argument.get_help().cloned() else { return argument };
    let text = whole.to_string();
    let first = beginning(&text);
    if first.len() == text.len() || argument.get_long_help().is_some() {
        return argument;
    }
    argument.help(first.to_owned()).long_help(whole)
}

/// Returns `text` up to the first full stop, colon or semicolon outside of brackets.
fn beginning(text: &str) -> &str {
    let mut depth = 0;
    for (place, character) in text.char_indices() {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            '.' | ':' | ';' if depth == 0 && text[place + 1..].starts_with(' ') => return &text[..place],
            _ => {}
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_begins_up_to_the_first_stop_outside_of_brackets() {
        for (text, first) in [
            ("Samples a pixel: 1 to 4096; 1 looks at centres", "Samples a pixel"),
            ("Exposure in stops. auto measures it", "Exposure in stops"),
            (
                "Method of the optics [default: table for pictures]",
                "Method of the optics [default: table for pictures]",
            ),
            (
                "Terms (--windows 1x1; else none), as in 2.5; more",
                "Terms (--windows 1x1; else none), as in 2.5",
            ),
        ] {
            assert_eq!(beginning(text), first);
        }
    }
}
