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

/// Returns `argument` with the first sentence of its help in the short one.
fn summarised(argument: Arg) -> Arg {
    let Some(whole) = argument.get_help().cloned() else { return argument };
    match whole.to_string().split_once(". ") {
        Some((first, _)) if argument.get_long_help().is_none() => {
            argument.help(first.to_owned()).long_help(whole)
        }
        _ => argument,
    }
}
