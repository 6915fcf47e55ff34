//! The command line: one file per command; raw arguments in, validated settings with units out.

mod answer;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod arena;
mod benchmark;
mod brdf;
mod cache;
mod captions;
mod closed_stdout;
mod colour;
mod console;
mod devices;
mod eval;
mod evaluation;
mod export;
mod exported;
mod finished;
#[cfg(feature = "viewer")]
mod last_view;
mod lights;
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
#[cfg(feature = "viewer")]
mod view;
#[cfg(feature = "viewer")]
mod view_command;
mod write;

use crate::context::Context;
use crate::error::{Error, ErrorKind, Result};
use clap::{Parser, Subcommand};
pub use console::Streams;
use console::{Console, Verbosity};
use std::ffi::OsString;
use std::process::ExitCode;
use usage::Understood;

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
    /// Surroundings as directional lights for other programs
    Lights(lights::Arguments),
    /// List the Vulkan devices, and the reason for the chosen one
    Devices(devices::Arguments),
    /// Show the help of a command
    Help(manual::HelpArguments),
    /// Print the script with which a shell completes commands and options
    Completions(manual::CompletionArguments),
    /// Write pages for `man`, one for each command
    Manual(manual::ManualArguments),
}

/// Runs the program on the arguments, the streams, the cache and the threads of the process.
pub fn main() -> ExitCode {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    arena::share();
    let context = Context::new().with_validation(wants_validation());
    let console = Console::new(std::env::args_os().collect(), Streams::of_process(), context);
    ExitCode::from(finish(&console, || obey(&console, threads::start)))
}

/// Runs the program on `words`, its name first, and returns its exit code: 0 for done, 2 for wrong usage, 1 for everything else.
///
/// Files are those of the process; everything else is that of `context`, unless the words name something else.
pub fn run(words: impl IntoIterator<Item = OsString>, streams: Streams, context: &Context) -> u8 {
    let console = Console::new(words.into_iter().collect(), streams, context.clone());
    finish(&console, || context.run(|| obey(&console, |_| ())))
}

/// Returns the exit code of `work`, and prints its error.
fn finish(console: &Console, work: impl FnOnce() -> Result<()> + Send) -> u8 {
    work().map_or_else(
        |error| {
            console.print(&remedies::in_options(&error));
            exit_code(&error)
        },
        |()| 0,
    )
}

/// Returns the exit code of the process after `error`: 2 for wrong usage, 1 for everything else.
fn exit_code(error: &Error) -> u8 {
    if error.kind() == ErrorKind::Usage { 2 } else { 1 }
}

/// Obeys the words of `console` on a large stack, after `prepare`; windows run on the calling thread.
fn obey(console: &Console, prepare: impl FnOnce(&Console)) -> Result<()> {
    let understood = on_large_stack(|| usage::understand(console.words().iter().cloned()))?;
    let arguments = match understood {
        Understood::Work(arguments) => arguments,
        Understood::Help(help) => return console.write_help(&help),
    };
    let console = &console.clone().saying(arguments.verbosity);
    prepare(console);
    #[cfg(feature = "viewer")]
    if let Command::View(arguments) = &arguments.command {
        return view::run(arguments, console);
    }
    on_large_stack(|| command(&arguments.command, console))
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

/// Runs a command.
fn command(command: &Command, console: &Console) -> Result<()> {
    match command {
        #[cfg(feature = "viewer")]
        Command::View(arguments) => view::run(arguments, console),
        Command::Render(arguments) => render::run(arguments, console),
        Command::Eval(arguments) => eval::run(arguments, console),
        Command::Brdf(arguments) => brdf::run(arguments, console),
        Command::Colour(arguments) => colour::run(arguments, console),
        Command::Orders(arguments) => orders::run(arguments, console),
        Command::Export(arguments) => export::run(arguments, console),
        Command::Peaks(arguments) => peaks::run(arguments, console),
        Command::Profile(arguments) => profile::run(arguments, console),
        Command::Trade(arguments) => trade::run(arguments, console),
        Command::Surface(command) => surface::run(command, console),
        Command::Cache(arguments) => cache::run(arguments, console),
        Command::Lights(arguments) => lights::run(arguments, console),
        Command::Devices(arguments) => devices::run(arguments, console),
        Command::Help(arguments) => manual::help(arguments, console),
        Command::Completions(arguments) => manual::completions(arguments, console),
        Command::Manual(arguments) => manual::manual(arguments),
    }
}

/// Returns true if the environment asks for Vulkan validation.
fn wants_validation() -> bool {
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
