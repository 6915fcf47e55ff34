//! `diffract help`, `completions` and `manual`: help texts, shell completions and manual pages from one description of the command line.

use super::Arguments;
use super::console::Console;
use super::usage::{self, Understood};
use crate::error::{Error, Result};
use crate::output;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Arguments of `help`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract help render
  diffract help surface info")]
pub struct HelpArguments {
    /// The command, as in `surface info`; without one, all of them
    #[arg(value_name = "COMMAND")]
    command: Vec<String>,
}

/// Arguments of `completions`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract completions bash > ~/.local/share/bash-completion/completions/diffract
  diffract completions zsh > ~/.zfunc/_diffract
  diffract completions fish > ~/.config/fish/completions/diffract.fish")]
pub struct CompletionArguments {
    /// Shell to complete words for
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Arguments of `manual`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract manual ~/.local/share/man/man1 && man diffract-render")]
pub struct ManualArguments {
    /// Existing folder for the pages
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

/// Prints the help of a command, like `--help` behind the command.
pub fn help(arguments: &HelpArguments, console: &Console) -> Result<()> {
    let words =
        ["diffract"].into_iter().chain(arguments.command.iter().map(String::as_str)).chain(["--help"]);
    match usage::understand(words.map(OsString::from))? {
        Understood::Help(help) => console.write_help(&help),
        Understood::Work(_) => Err(Error::bug("the help of a command is a command")),
    }
}

/// Prints the script that completes words in a shell.
pub fn completions(arguments: &CompletionArguments, console: &Console) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "diffract", &mut script);
    console.write(&String::from_utf8_lossy(&script))
}

/// Writes a page for each command.
pub fn manual(arguments: &ManualArguments) -> Result<()> {
    if !arguments.folder.is_dir() {
        let what = format!("{}: there is no such folder", arguments.folder.display());
        return Err(Error::usage(what, "make it, or name another"));
    }
    let mut all = Arguments::command();
    all.build(); // the full name of each command
    pages(&all, &arguments.folder)
}

/// Writes the page of `command` and those of the commands below it.
fn pages(command: &Command, folder: &Path) -> Result<()> {
    let page = clap_mangen::Man::new(command.clone());
    let path = folder.join(page.get_filename());
    output::write_atomically(&path, |file| page.render(file).map_err(|e| output::write_failed(&path, e)))?;
    command.get_subcommands().try_for_each(|below| pages(below, folder))
}
