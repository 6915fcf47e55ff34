//! `diffract cache`: shows and clears the cache.

use super::console::Console;
use crate::cache::{Contents, DEFAULT_LIMIT, Usage};
use crate::error::{Error, Result};
use crate::memory::in_words;
use clap::{Args, Subcommand};

/// Arguments of `cache`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract cache           the folder, and number and bytes of each kind of result
  diffract cache clear     removes all of them; whatever is needed is computed again

Before a result is kept, those used least recently are removed until all fit into `--cache-size`.")]
pub struct Arguments {
    #[command(subcommand)]
    action: Option<Action>,
}

#[derive(Subcommand, Debug)]
enum Action {
    /// Remove all cached results
    Clear,
}

/// Shows or clears the cache.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let store = console.context().store().ok_or_else(|| {
        Error::files("there is no folder for a cache", "set XDG_CACHE_HOME or HOME to an absolute path")
    })?;
    let folder = store.folder().display();
    let text = match arguments.action {
        None => {
            let contents = store.contents()?;
            let limit = in_words(DEFAULT_LIMIT);
            format!("{folder}\n{}limit: {limit} unless --cache-size says otherwise\n", table(&contents))
        }
        Some(Action::Clear) => {
            let Usage { files, bytes } = store.clear()?.total();
            format!("{folder}: {} removed, {}\n", counted(files), in_words(bytes))
        }
    };
    console.write(&text)
}

/// Returns a line for each kind of result, and one for all.
fn table(contents: &Contents) -> String {
    let line = |kind: &str, usage: Usage| {
        format!("{kind:<10} {:>6} {:>12} bytes ({})\n", usage.files, usage.bytes, in_words(usage.bytes))
    };
    let kinds = contents.kinds.iter().map(|(kind, usage)| line(kind, *usage));
    kinds.chain([line("total", contents.total())]).collect()
}

fn counted(files: u64) -> String {
    if files == 1 { "1 file".to_owned() } else { format!("{files} files") }
}
