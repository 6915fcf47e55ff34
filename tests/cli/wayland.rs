//! A Wayland compositor of its own without a screen (sway), and keys for it (wtype).

use crate::display::wait_for;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// A compositor that goes with its value.
pub struct Wayland {
    server: Child,
    folder: TempDir,
}

/// The command for `program`, as nobody where root runs the tests: sway refuses root.
fn unprivileged(program: &str, folder: &Path) -> Command {
    const NOBODY: &str = "65534";
    if std::fs::metadata(folder).unwrap().uid() != 0 {
        return Command::new(program);
    }
    let mut command = Command::new("setpriv");
    command.args(["--reuid", NOBODY, "--regid", NOBODY, "--clear-groups", program]);
    command
}

impl Wayland {
    /// With an output of this scale.
    pub fn new(scale: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o777)).unwrap();
        let settings = folder.path().join("config");
        let output = format!("xwayland disable\noutput * resolution 1200x900 scale {scale}\n");
        std::fs::write(&settings, output).unwrap();
        let mut command = unprivileged("sway", folder.path());
        command.arg("-c").arg(&settings);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env("HOME", folder.path());
        command.envs([("WLR_BACKENDS", "headless"), ("WLR_RENDERER", "pixman")]);
        command.env("WLR_LIBINPUT_NO_DEVICES", "1").env("XDG_RUNTIME_DIR", folder.path());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let server = command
            .spawn()
            .unwrap_or_else(|e| panic!("sway does not start ({e}): tools/setup.sh test installs it"));
        let own = Self { server, folder };
        wait_for("a compositor", || own.socket("sway-ipc").and_then(|_| own.socket("wayland-")));
        own
    }

    /// The socket whose name begins with `start`.
    fn socket(&self, start: &str) -> Option<PathBuf> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let is = |path: &PathBuf| {
            let name = path.file_name().unwrap().to_string_lossy();
            name.starts_with(start) && !name.ends_with(".lock")
        };
        entries.into_iter().find(is)
    }

    /// Environment variables of programs that show windows on it, and none on an X display.
    pub fn variables(&self) -> [(String, String); 3] {
        let text = |path: PathBuf| path.to_str().unwrap().to_owned();
        [
            ("WAYLAND_DISPLAY".to_owned(), text(self.socket("wayland-").unwrap())),
            ("XDG_RUNTIME_DIR".to_owned(), text(self.folder.path().to_owned())),
            ("DISPLAY".to_owned(), String::new()),
        ]
    }

    /// Presses the key of this name.
    pub fn key(&self, name: &str) {
        // A keyboard that comes and goes at once is not seen by windows.
        let status = Command::new("wtype")
            .args(["-s", "800", "-k", name, "-s", "800"])
            .envs(self.variables())
            .status()
            .unwrap_or_else(|e| panic!("wtype does not start ({e}): tools/setup.sh test installs it"));
        assert!(status.success(), "wtype -k {name}: {status}");
    }

    /// Asks the window to close, as its frame's button does.
    pub fn close(&self) {
        let socket = self.socket("sway-ipc").unwrap();
        let asked = Command::new("swaymsg").arg("kill").env("SWAYSOCK", socket).output().unwrap();
        assert!(asked.status.success(), "{asked:?}");
    }
}

impl Drop for Wayland {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
