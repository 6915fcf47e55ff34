//! The command line: one file per command; raw arguments in, validated settings with units out.

mod benchmark;
mod brdf;
mod cache;
mod captions;
mod closed_stdout;
mod colour;
mod devices;
mod eval;
mod evaluation;
mod export;
mod exported;
mod finished;
#[cfg(feature = "viewer")]
mod last_view;
mod manual;
mod options;
mod orders;
mod peaks;
mod prepare;
mod profile;
mod progress;
mod range;
mod remedies;
mod render;
mod scale;
mod scene_options;
mod sequence;
mod short_help;
mod surface;
mod threads;
mod trade;
pub mod untrusted;
mod usage;
mod usage_error;
mod verbosity;
#[cfg(feature = "viewer")]
mod view;
#[cfg(feature = "viewer")]
mod view_command;
mod write;

use crate::error::{Error, ErrorKind, Result};
use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;
use verbosity::{Verbosity, say};

const VIEW_EXAMPLE: &str = if cfg!(feature = "viewer") { "\n  diffract view" } else { "" };

/// Structural colour from a measured height field.
#[derive(Parser, Debug)]
#[command(
    name = "diffract",
    version,
    about = "Structural colour from a measured height field: Stam's wave-optics BRDF, as pictures and as numbers",
    after_help = format!("Examples:{VIEW_EXAMPLE}
  diffract render -o snake.png
  diffract render sphere --surface scan.png --pixel-size 48.83nm --height 434.7nm -o scan.exr
  diffract eval blaze --queries directions.csv --method reference
  diffract brdf elaphe --light 30,0 -o hemisphere.png
  diffract surface info xenopeltis

Lengths are written with their unit: 65um, 434.7nm. `diffract COMMAND --help` says more."),
    disable_help_subcommand = true
)]
struct Arguments {
    #[command(flatten)]
    verbosity: Verbosity,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    #[cfg(feature = "viewer")]
    /// A window: orbit, drag the light, change everything live
    View(view::Arguments),
    /// Draw a scene into a PNG or EXR file
    Render(render::Arguments),
    /// BRDF numbers for given directions
    Eval(eval::Arguments),
    /// The hemisphere of one light direction, as a picture or as numbers
    Brdf(brdf::Arguments),
    /// Colours as a multi-angle spectrophotometer reads them
    Colour(colour::Arguments),
    /// Angles and efficiencies of the orders of a periodic surface
    Orders(orders::Arguments),
    /// The material for other programs: a colour table that they can read
    Export(export::Arguments),
    /// Peak angles against the grating equation
    Peaks(peaks::Arguments),
    /// Frame times, errors, and the limits of the device
    Profile(profile::Arguments),
    /// Speed against accuracy, measured: table, plot, advice
    Trade(trade::Arguments),
    /// Statistics and cost of a height field; generated height fields
    #[command(subcommand)]
    Surface(surface::Command),
    /// Show or remove cached results
    Cache(cache::Arguments),
    /// List the Vulkan devices, and the reason for the chosen one
    Devices(devices::Arguments),
    /// Show the help of a command
    Help(manual::HelpArguments),
    /// Print the script with which a shell completes commands and options
    Completions(manual::CompletionArguments),
    /// Write pages for `man`, one for each command
    Manual(manual::ManualArguments),
}

/// Runs the program on the arguments of the process.
pub fn main() -> ExitCode {
    match on_large_stack(|| usage::parse(std::env::args_os()))
        .and_then(|arguments| arguments.map_or(Ok(()), start))
    {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print(&remedies::in_options(&error));
            ExitCode::from(exit_code(&error))
        }
    }
}

/// Returns the exit code of the process after `error`: 2 for wrong usage, 1 for everything else.
fn exit_code(error: &Error) -> u8 {
    if error.kind() == ErrorKind::Usage { 2 } else { 1 }
}

/// Runs a command on a large stack; windows run on the main thread.
fn start(arguments: Arguments) -> Result<()> {
    #[cfg(feature = "viewer")]
    if matches!(arguments.command, Command::View(_)) {
        return run(arguments);
    }
    on_large_stack(|| run(arguments))
}

/// Runs `work` in a thread with the usual stack size of a process: a stack that `ulimit -s` makes small would overflow. If the system gives
/// no thread, the calling thread does the work.
fn on_large_stack<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    const BYTES: usize = 8 << 20;
    let mut work = Some(work);
    let done = std::thread::scope(|scope| {
        let work = &mut work;
        let thread = std::thread::Builder::new().name("main".to_owned()).stack_size(BYTES);
        let thread = thread.spawn_scoped(scope, move || work.take().map(|work| work())).ok()?; // no thread: see below
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    let done = done.or_else(|| work.map(|work| work()));
    done.unwrap_or_else(|| Err(Error::bug("a command did not run")))
}

fn run(arguments: Arguments) -> Result<()> {
    arguments.verbosity.apply();
    threads::start();
    match arguments.command {
        #[cfg(feature = "viewer")]
        Command::View(arguments) => view::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Eval(arguments) => eval::run(&arguments),
        Command::Brdf(arguments) => brdf::run(&arguments),
        Command::Colour(arguments) => colour::run(&arguments),
        Command::Orders(arguments) => orders::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Peaks(arguments) => peaks::run(&arguments),
        Command::Profile(arguments) => profile::run(&arguments),
        Command::Trade(arguments) => trade::run(&arguments),
        Command::Surface(command) => surface::run(&command),
        Command::Cache(arguments) => cache::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Help(arguments) => manual::help(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Manual(arguments) => manual::manual(&arguments),
    }
}

/// Writes one line to stderr; a closed stderr is no error.
fn print(line: &dyn std::fmt::Display) {
    let line = write::without_controls(&line.to_string());
    let _ = writeln!(std::io::stderr(), "diffract: {line}");
}

/// Returns true if Vulkan validation is enabled; then each of its messages is an error.
fn validation() -> bool {
    std::env::var_os("DIFFRACT_VALIDATION").is_some_and(|v| !v.is_empty() && v != "0")
}

/// Fails if there are validation messages.
fn check_validation(messages: &[String]) -> Result<()> {
    match messages {
        [] => Ok(()),
        [first, ..] => Err(Error::bug(format!(
            "Vulkan validation has {} message(s), the first: {first}",
            messages.len()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_usage_alone_ends_the_program_with_exit_code_2() {
        assert_eq!(exit_code(&Error::usage("a", "b")), 2);
        let others = [Error::input("a", "b"), Error::files("a", "b"), Error::cancelled(), Error::bug("a")];
        assert!(others.iter().all(|error| exit_code(error) == 1));
    }
}
