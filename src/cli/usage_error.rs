//! Conversion of clap's errors into one-line errors of the program.

use crate::error::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error as _;

/// Returns the one-line error for wrong words of `command`.
pub fn in_one_line(e: &clap::Error, command: &str) -> Error {
    let see = format!("see `{command} --help`");
    let text = |kind| match e.get(kind) {
        Some(ContextValue::String(s)) => Some(s.clone()),
        // The most similar one comes last.
        Some(ContextValue::Strings(list)) => list.last().cloned(),
        _ => None,
    };
    let argument = text(ContextKind::InvalidArg).unwrap_or_default();
    // Errors of our value parsers are ready; only the option's name is missing.
    if let Some(cause) = e.source().and_then(|source| source.downcast_ref::<Error>()) {
        return cause.clone().at(argument).or(see);
    }
    let what = match e.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            return Error::usage("no command is given", see);
        }
        ErrorKind::InvalidUtf8 => "an argument is not UTF-8".to_owned(),
        // The first paragraph is the error, tips and usage follow.
        _ => {
            let text = e.to_string();
            let first = text.split("\n\n").next().unwrap_or_default();
            first.strip_prefix("error: ").unwrap_or(first).to_owned()
        }
    };
    let suggested = text(ContextKind::SuggestedArg).or_else(|| text(ContextKind::SuggestedSubcommand));
    match suggested {
        Some(word) => Error::usage(what, format!("do you mean {word}? {see}")),
        None => Error::usage(what, see),
    }
}
