//! One run of the program: its words, its streams, how much it says, and the context of its work.

use super::closed_stdout;
use super::remedies::in_options;
use crate::context::Context;
use crate::error::{self, Error, Result};
use crate::input;
use clap::Args;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal, Read, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Streams for the results of a run and for what it says.
pub struct Streams {
    /// Data that a command is told to read from `-`.
    input: Box<dyn Read + Send>,
    /// Results.
    output: Box<dyn Write + Send>,
    /// Errors and notes.
    errors: Box<dyn Write + Send>,
    /// True if bars of progress are drawn on the terminal of the process, and results are lost where it has no stdout.
    is_process: bool,
}

impl Streams {
    /// Returns streams from `input`, to `output` for results, and to `errors` for errors and notes. No bars are drawn.
    pub fn new(
        input: impl Read + Send + 'static,
        output: impl Write + Send + 'static,
        errors: impl Write + Send + 'static,
    ) -> Self {
        Self { input: Box::new(input), output: Box::new(output), errors: Box::new(errors), is_process: false }
    }

    /// Returns the streams of the process, with bars of progress if stderr is a terminal.
    pub fn of_process() -> Self {
        Self { is_process: true, ..Self::new(io::stdin(), io::stdout(), io::stderr()) }
    }

    /// Writes `text` as a result. Fails if the process has no stdout: nobody reads it.
    fn write(&mut self, text: &str) -> Result<()> {
        if self.is_process && closed_stdout::is_closed() {
            return Err(Error::files(
                "stdout is closed, so that the result is lost",
                "send it to a file or a program",
            ));
        }
        match self.output.write_all(text.as_bytes()).and_then(|()| self.output.flush()) {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::files(
                format!("stdout cannot be written: {}", error::cause(&e)),
                "check where it goes",
            )
            .caused_by(e)),
            _ => Ok(()),
        }
    }
}

/// Options for the amount of text beside results and errors.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Program")]
pub struct Verbosity {
    /// Print more on stderr
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Print nothing on stderr but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

/// One run of the program. Clones are the same run.
#[derive(Clone)]
pub struct Console {
    shared: Arc<RunState>,
    verbosity: Verbosity,
    context: Context,
}

/// Parts of a run that never change, and its streams.
struct RunState {
    words: Vec<OsString>,
    streams: Mutex<Streams>,
    /// Notes that are told once.
    told: Mutex<BTreeSet<&'static str>>,
}

impl Console {
    /// Returns a run of the program on `words`, its name first.
    pub fn new(words: Vec<OsString>, streams: Streams, context: Context) -> Self {
        let shared = RunState { words, streams: Mutex::new(streams), told: Mutex::default() };
        Self { shared: Arc::new(shared), verbosity: Verbosity::default(), context }
    }

    /// Returns a run whose words nobody reads, without a cache.
    #[cfg(test)]
    pub fn silent() -> Self {
        Self::new(Vec::new(), Streams::new(io::empty(), io::sink(), io::sink()), Context::default())
    }

    /// Returns the run that says as much as `verbosity` asks for, notes of its context included.
    pub fn saying(mut self, verbosity: Verbosity) -> Self {
        self.verbosity = verbosity;
        let shared = Self { context: Context::default(), ..self.clone() };
        self.in_context(move |context| context.with_notes(move |note| shared.say(&in_options(note))))
    }

    /// Returns the run with the context that `change` returns.
    pub fn in_context(self, change: impl FnOnce(Context) -> Context) -> Self {
        Self { context: change(self.context), ..self }
    }

    /// Returns the words of the command line, the program's name first.
    pub fn words(&self) -> &[OsString] {
        &self.shared.words
    }

    /// Returns the context of the work.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Returns true if only errors are wanted.
    pub fn is_quiet(&self) -> bool {
        self.verbosity.quiet
    }

    /// Returns true if bars of progress are wanted, which are drawn where the process has a terminal.
    pub fn has_bars(&self) -> bool {
        !self.is_quiet() && self.streams().is_process
    }

    /// Prints one line that a user should know.
    pub fn say(&self, line: &dyn Display) {
        if !self.is_quiet() {
            self.print(line);
        }
    }

    /// Prints one line that a user should know, unless a line has been printed under this `name`.
    pub fn say_once(&self, name: &'static str, line: &dyn Display) {
        if self.shared.told.lock().unwrap_or_else(PoisonError::into_inner).insert(name) {
            self.say(line);
        }
    }

    /// Prints one line if the user asked for more.
    pub fn detail(&self, line: &dyn Display) {
        if self.verbosity.verbose {
            self.print(line);
        }
    }

    /// Prints one line even if only errors are wanted; closed streams are no error.
    pub fn print(&self, line: &dyn Display) {
        let line = without_controls(&line.to_string());
        let _ = writeln!(self.streams().errors, "diffract: {line}"); // nobody listens
    }

    /// Reads the whole text of the file `path`; `-` and `/dev/stdin` are the input of the run.
    ///
    /// # Errors
    /// Those of [`input::read_text`].
    pub fn read_text(&self, path: &Path, expected: &str) -> Result<String> {
        if !is_input(path) {
            return input::read_text(path, expected);
        }
        input::text_of(&mut self.streams().input, expected).map_err(|e| e.at(INPUT))
    }

    /// Writes a result, without control characters that a terminal would obey.
    ///
    /// # Errors
    /// Fails if there is no such stream, or if it cannot be written. A closed pipe is no error: the reader has read all that it wanted.
    pub fn write(&self, text: &str) -> Result<()> {
        self.streams().write(&without_controls(text))
    }

    /// Writes the help or the version that the parser has made, in colours if the process has a terminal.
    ///
    /// # Errors
    /// Those of [`Self::write`].
    pub fn write_help(&self, help: &clap::Error) -> Result<()> {
        let (text, mut streams) = (help.render(), self.streams());
        let in_colours = streams.is_process && io::stdout().is_terminal();
        streams.write(&if in_colours { text.ansi().to_string() } else { text.to_string() })
    }

    fn streams(&self) -> MutexGuard<'_, Streams> {
        self.shared.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Name of the input of a run in messages.
const INPUT: &str = "stdin";

/// Returns true if `path` stands for the input of the run.
fn is_input(path: &Path) -> bool {
    path == Path::new("-") || path == Path::new("/dev/stdin")
}

/// Returns the name in messages of what [`Console::read_text`] reads from `path`.
pub fn source_name(path: &Path) -> Cow<'_, str> {
    if is_input(path) { INPUT.into() } else { path.to_string_lossy() }
}

/// Returns `text` with U+FFFD in place of control characters but line breaks and tabs: names of channels and files may hold any.
fn without_controls(text: &str) -> String {
    text.replace(|c: char| c.is_control() && !matches!(c, '\n' | '\r' | '\t'), "\u{fffd}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text that a run writes.
    #[derive(Clone, Default)]
    struct Recorded(Arc<Mutex<Vec<u8>>>);

    impl Write for Recorded {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_run_says_as_much_as_it_is_asked_for_and_some_things_once() {
        let said = |quiet, verbose| {
            let errors = Recorded::default();
            let streams = Streams::new(io::empty(), io::sink(), errors.clone());
            let console = Console::new(Vec::new(), streams, Context::default());
            let console = console.saying(Verbosity { quiet, verbose });
            console.say_once("note", &"once");
            console.clone().say_once("note", &"once");
            console.say_once("other", &"another");
            console.detail(&"more");
            console.context().tell(&Error::files("a note", "no matter"));
            console.print(&"an error");
            let bytes = errors.0.lock().unwrap().clone();
            String::from_utf8(bytes).unwrap().replace("diffract: ", "")
        };
        assert_eq!(said(true, false), "an error\n");
        assert_eq!(said(false, false), "once\nanother\na note; no matter\nan error\n");
        assert_eq!(said(false, true), "once\nanother\nmore\na note; no matter\nan error\n");
    }

    #[test]
    fn input_is_read_from_the_stream_of_the_run() {
        let streams = Streams::new(&b"a,b\n"[..], io::sink(), io::sink());
        let console = Console::new(Vec::new(), streams, Context::default());
        assert_eq!(console.read_text(Path::new("-"), "a table").unwrap(), "a,b\n");
        let bad = Streams::new(&[0xff_u8, 0xfe][..], io::sink(), io::sink());
        let console = Console::new(Vec::new(), bad, Context::default());
        let said = console.read_text(Path::new("/dev/stdin"), "a table").unwrap_err().to_string();
        assert!(said.starts_with("stdin: it is not text"), "{said}");
    }

    #[test]
    fn a_terminal_obeys_no_result() {
        assert_eq!(without_controls("a\t\u{1b}[31mé\u{9b}K\n"), "a\t\u{fffd}[31mé\u{fffd}K\n");
    }
}
