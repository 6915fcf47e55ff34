//! What clap has to say of wrong words, as the program's own one-line error.

use crate::error::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error as _;

/// What clap has to say of wrong words for `command`, in the program's own words.
pub fn in_one_line(e: &clap::Error, command: &str) -> Error {
    let see = format!("see `{command} --help`");
    let text = |kind| match e.get(kind) {
        Some(ContextValue::String(s)) => Some(s.clone()),
        Some(ContextValue::Strings(list)) => list.first().cloned(),
        _ => None,
    };
    let argument = text(ContextKind::InvalidArg).unwrap_or_default();
    // The value parsers are ours, and so are their errors; only the option's name is missing.
    if let Some(own) = e.source().and_then(|source| source.downcast_ref::<Error>()) {
        return own.clone().at(argument).or(see);
    }
    let what = match e.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            return Error::usage("no command is given", see);
        }
        ErrorKind::InvalidUtf8 => "an argument is not UTF-8".to_owned(),
        // The first paragraph is the error, what follows are tips and usage.
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
