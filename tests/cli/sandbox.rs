//! A folder, a cache and ways to run the program in them: inside the process of the tests, or as a process of its own.

use diffract::internals::cache::DEFAULT_LIMIT;
use diffract::internals::cli::{self, Streams};
use diffract::internals::context::Context;
use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, Read, Write};
use std::iter;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, LazyLock, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longer than any run here takes on two cores that others use, too; a run that takes longer hangs.
pub const TIMEOUT: Duration = Duration::from_secs(300);

/// A periodic surface of 24 × 24 samples, and how to read it.
pub const SMALL: [&str; 8] = [
    "--surface",
    "small.png",
    "--pixel-size",
    "83.3333333nm",
    "--height",
    "137.4nm",
    "--coherence",
    "gaussian:4um",
];

/// What a run left.
#[derive(Debug)]
pub struct Outcome {
    /// The exit code; `None` if the program was killed.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Outcome {
    /// The output of a run that has to succeed without a word on stderr.
    #[track_caller]
    pub fn done(self) -> String {
        assert_eq!((self.code, self.stderr.as_str()), (Some(0), ""), "{}", self.stdout);
        self.stdout
    }

    /// The one line of a run that has to be refused with exit code `code`.
    #[track_caller]
    pub fn refused(self, code: i32) -> String {
        let line = self.refused_somehow("");
        assert_eq!(self.code, Some(code), "{line}");
        line
    }

    /// The same without the questions about units on stderr, which stand before an error.
    pub fn without_questions(mut self) -> Self {
        let lines = self.stderr.split_inclusive('\n');
        self.stderr = lines.filter(|line| !line.trim_end().ends_with('?')).collect();
        self
    }

    /// The one line of a run that has to be refused; `what` was asked for.
    #[track_caller]
    pub fn refused_somehow(&self, what: &str) -> String {
        let line = self.stderr.strip_suffix('\n').unwrap_or_else(|| panic!("{what}: no line, {self:?}"));
        assert!(matches!(self.code, Some(1 | 2)), "{what}: {self:?}");
        assert_eq!(self.stdout, "", "{what}");
        assert!(!line.contains(['\n', '\r', '\u{1b}']), "{what}: more than a line: {line}");
        assert!(line.starts_with("diffract: ") && line.contains("; "), "{what}: {line}");
        assert!(!line.contains("panicked"), "{what}: {line}");
        line.to_owned()
    }
}

/// A folder to work in and a cache folder, gone with the value.
pub struct Sandbox {
    folder: TempDir,
    variables: Vec<(OsString, OsString)>,
}

impl Sandbox {
    pub fn new() -> Self {
        let sandbox = Self { folder: TempDir::new().unwrap(), variables: Vec::new() };
        fs::create_dir(sandbox.path("")).unwrap();
        sandbox
    }

    /// A sandbox that holds [`SMALL`]'s surface.
    pub fn with_small_surface() -> Self {
        let sandbox = Self::new();
        sandbox.run(["surface", "synth", "bumps", "--patch", "2um", "-o", "small.png"]).done();
        sandbox
    }

    /// The same with the environment variable `name`.
    pub fn with(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.variables.push((name.into(), value.as_ref().to_owned()));
        self
    }

    /// The same on a machine on which the loader finds no Vulkan driver.
    pub fn without_vulkan(self) -> Self {
        self.with("VK_DRIVER_FILES", "/nowhere/driver.json").with("VK_ICD_FILENAMES", "/nowhere/driver.json")
    }

    /// A path in the folder that the program works in.
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join("work").join(name)
    }

    /// The program's own state folder.
    pub fn state(&self) -> PathBuf {
        self.folder.path().join("state/diffract")
    }

    /// The program's own cache folder.
    pub fn cache(&self) -> PathBuf {
        self.folder.path().join("cache/diffract")
    }

    /// The bytes of a file.
    #[track_caller]
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    /// Every file, folder and other thing in the folder, with the content of files.
    pub fn content(&self) -> BTreeMap<OsString, Option<Vec<u8>>> {
        let entries = fs::read_dir(self.path("")).unwrap().map(Result::unwrap);
        entries
            .map(|e| {
                (e.file_name(), e.file_type().unwrap().is_file().then(|| fs::read(e.path()).ok()).flatten())
            })
            .collect()
    }

    /// The program, not yet running.
    pub fn command<A: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = A>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diffract"));
        command.args(arguments).current_dir(self.path(""));
        // The driver's own shader cache may serve all tests; ours may not.
        if let Some(shared) = std::env::var_os("XDG_CACHE_HOME") {
            command.env("MESA_SHADER_CACHE_DIR", shared);
        }
        // No test opens a window on the display of whoever runs it.
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.env("XDG_CACHE_HOME", self.folder.path().join("cache"));
        command.env("XDG_STATE_HOME", self.folder.path().join("state"));
        command.envs(self.variables.iter().map(|(name, value)| (name, value)));
        command
    }

    /// Runs the program to its end: in this process, unless the sandbox has environment variables of its own.
    #[track_caller]
    pub fn run<A: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = A>) -> Outcome {
        if !self.variables.is_empty() {
            return self.run_alone(arguments);
        }
        let words = iter::once(OsString::from("diffract"))
            .chain(arguments.into_iter().map(|word| word.as_ref().to_owned()))
            .collect();
        run_inside(words, self.path(""), shared_context().with_cache(self.cache(), DEFAULT_LIMIT))
    }

    /// Runs the program to its end in a process of its own, with a stdin that stays open and says nothing.
    #[track_caller]
    pub fn run_alone<A: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = A>) -> Outcome {
        let mut command = self.command(arguments);
        let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        outcome(child.unwrap())
    }

    /// Runs `start` and `end` as one command line.
    #[track_caller]
    pub fn run2(&self, start: &[&str], end: &[&str]) -> Outcome {
        self.run(start.iter().chain(end))
    }
}

/// The context of all runs inside this process, with one device. The library reads the same variable of validation as the program.
fn shared_context() -> Context {
    static SHARED: LazyLock<Context> = LazyLock::new(|| {
        Context::default().with_validation(std::env::var_os("DIFFRACT_VALIDATION").is_some())
    });
    SHARED.clone()
}

/// Text that a run writes.
#[derive(Clone, Default)]
struct Written(Arc<Mutex<Vec<u8>>>);

impl Written {
    fn text(&self) -> String {
        String::from_utf8_lossy(&self.0.lock().unwrap()).into_owned()
    }
}

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Runs the program on `words` in a thread that works in `folder`.
#[track_caller]
fn run_inside(words: Vec<OsString>, folder: PathBuf, context: Context) -> Outcome {
    let (output, errors) = (Written::default(), Written::default());
    let streams = Streams::new(io::empty(), output.clone(), errors.clone());
    let (sender, receiver) = channel();
    let thread = std::thread::spawn(move || {
        // SAFETY: the thread keeps its file descriptors in common with the others; only its working folder becomes its own.
        unsafe { rustix::thread::unshare_unsafe(rustix::thread::UnshareFlags::FS) }.unwrap();
        std::env::set_current_dir(folder).unwrap();
        let _ = sender.send(cli::run(words, streams, &context)); // the test may have given up
    });
    let code = match receiver.recv_timeout(TIMEOUT) {
        Ok(code) => code,
        Err(RecvTimeoutError::Timeout) => panic!("the program hangs"),
        Err(RecvTimeoutError::Disconnected) => std::panic::resume_unwind(thread.join().unwrap_err()),
    };
    Outcome { code: Some(code.into()), stdout: output.text(), stderr: errors.text() }
}

/// Waits for `child`, whose outputs are pipes.
#[track_caller]
pub fn outcome(mut child: Child) -> Outcome {
    let stdin = child.stdin.take(); // kept open: a program that read it would not end
    let (stdout, stderr) = (collect(child.stdout.take()), collect(child.stderr.take()));
    let deadline = Instant::now() + TIMEOUT;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > deadline {
            child.kill().unwrap();
            panic!("the program hangs");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    drop(stdin);
    Outcome { code: status.code(), stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap() }
}

fn collect(pipe: Option<impl Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            pipe.read_to_end(&mut bytes).unwrap();
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// A grey 8-bit PNG.
pub fn grey_png(columns: u32, rows: u32, code: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    encoded(image::GrayImage::from_fn(columns, rows, |x, y| image::Luma([code(x, y)])).into())
}

/// A PNG of any picture.
pub fn encoded(picture: image::DynamicImage) -> Vec<u8> {
    let mut bytes = io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.flush().unwrap();
    bytes.into_inner()
}
