//! Results never destroy what they are made from, and nothing else is left beside them.

use crate::sandbox::{Outcome, SMALL, Sandbox};
use std::fs;

/// Settings under which every command is quick.
const QUICK: [&str; 4] = ["--tolerance", "1e-1", "--coherence", "gaussian:4um"];

fn with_inputs() -> Sandbox {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n0,0,0,0\n");
    sandbox.write("light.csv", "380,1\n780,1\n");
    sandbox.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    sandbox.write("pigment.png", sandbox.read("small.png"));
    sandbox.write(
        "scene.toml",
        "mesh = \"mesh.obj\"\nsurface = \"small.png\"\npixel_size = \"83nm\"\nheight = \"137nm\"\npigment = \"pigment.png\"\n\
         lights = [\"30,0\"]\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\nfield_of_view = \"35deg\"\n",
    );
    sandbox
}

#[test]
fn an_output_over_an_input_is_refused_by_every_command_and_the_input_stays() {
    let sandbox = with_inputs();
    let before = sandbox.content();
    let units = ["--pixel-size", "83nm", "--height", "137nm"];
    for (words, output) in [
        (&["render", "sphere", "--surface", "small.png"][..], "small.png"),
        (&["render", "sphere", "--surface", "./small.png"], "small.png"),
        (&["render", "scene.toml"], "small.png"),
        (&["render", "scene.toml"], "pigment.png"),
        (&["brdf", "small.png", "--light", "30,0"], "small.png"),
    ] {
        let mut words = words.to_vec();
        words.extend(units);
        words.extend(["-o", output]);
        let line = sandbox.run(&words).refused(2);
        assert!(line.contains("is the input"), "{words:?}: {line}");
    }
    for words in [
        &["eval", "flat", "--queries", "q.csv", "-o", "q.csv"][..],
        &["eval", "flat", "--queries", "q.csv", "--illuminant", "light.csv", "-o", "light.csv"],
        &["profile", "scene.toml", "--json", "scene.toml"],
        &["profile", "mesh.obj", "--json", "mesh.obj"],
        &["orders", "small.png", "--light", "30,0", "--wavelength", "550nm", "-o", "small.png"],
        &["peaks", "small.png", "--theta-i", "30", "--angles", "0:9:1", "-o", "small.png"],
        &["peaks", "small.png", "--theta-i", "30", "--angles", "0:9:1", "--json", "small.png"],
    ] {
        let line = sandbox.run(words).refused(2);
        assert!(line.contains("is the input"), "{words:?}: {line}");
    }
    assert_eq!(sandbox.content(), before);
}

#[test]
fn two_outputs_of_one_name_are_refused() {
    let sandbox = Sandbox::new();
    for words in [
        &["peaks", "blaze", "--theta-i", "30", "--angles", "0:9:1", "-o", "a", "--json", "a"][..],
        &["peaks", "blaze", "--theta-i", "30", "--angles", "0:9:1", "-o", "a.svg", "--plot", "./a.svg"],
        &["brdf", "blaze", "--light", "30,0", "-o", "b.png", "--plot", "b.png"],
    ] {
        let line = sandbox.run(words).refused(2);
        assert!(line.contains("is the same file"), "{words:?}: {line}");
    }
    assert!(sandbox.content().is_empty());
}

#[test]
fn a_surface_that_is_not_there_is_told_before_its_units() {
    let sandbox = Sandbox::new();
    for name in ["nofile.png", "nofile.xyz"] {
        let line = sandbox.run(["surface", "info", name]).refused_somehow(name);
        assert!(line.contains("no such file") && !line.contains("--pixel-size"), "{line}");
    }
}

#[test]
fn a_spectrum_that_leaves_out_visible_light_is_told_and_one_without_names_is_read_whole() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n0,0,0,0\n");
    let answer = |name: &str, text: &str| {
        sandbox.write(name, text);
        let words = ["eval", "flat", "--method", "reference", "--queries", "q.csv", "--illuminant", name];
        sandbox.run(words.iter().chain(&["--coherence", "gaussian:5um"]))
    };
    let named = answer("named.csv", "nm,power\n380,1\n600,1\n780,1\n").done();
    assert_eq!(answer("bare.csv", "380,1\n600,1\n780,1\n").done(), named);
    let Outcome { code, stderr, .. } = answer("short.csv", "400,1\n700,1\n");
    assert!(code == Some(0) && stderr.contains("400 to 700 nm") && stderr.lines().count() == 1, "{stderr}");
}

#[cfg(target_os = "linux")]
mod linux {
    use super::*;
    use crate::sandbox::outcome;
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::os::unix::process::CommandExt;
    use std::path::PathBuf;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    #[test]
    fn a_program_that_is_ended_by_a_signal_leaves_nothing_beside_its_output() {
        let sandbox = with_inputs();
        let words: Vec<&str> = ["render", "sphere", "--size", "64x48", "-o", "out.exr"]
            .into_iter()
            .chain(SMALL)
            .chain(QUICK[..2].iter().copied())
            .collect();
        let begun = Instant::now();
        sandbox.run(&words).done();
        let usual = begun.elapsed();
        let whole = sandbox.read("out.exr");
        let names = sandbox.content().len();
        for (step, signal) in ["INT", "TERM", "HUP", "KILL"].iter().cycle().take(12).enumerate() {
            if step % 2 == 0 {
                let _ = fs::remove_dir_all(sandbox.cache());
            }
            let mut child =
                sandbox.command(&words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(usual * step as u32 / 10 + Duration::from_millis(1));
            // The program may be done by now.
            let _ = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
            child.wait().unwrap();
            assert_eq!(sandbox.content().len(), names, "step {step}, {signal}");
            assert!(sandbox.read("out.exr") == whole, "step {step}, {signal}");
            let kept = fs::read_dir(sandbox.cache()).into_iter().flatten();
            let left = kept.filter(|f| f.as_ref().unwrap().file_name().to_string_lossy().starts_with('.'));
            assert_eq!(left.count(), 0, "step {step}, {signal}: in the cache");
        }
    }

    #[test]
    fn where_the_system_gives_no_threads_the_calling_thread_does_the_work() {
        let sandbox = with_inputs();
        let words = ["eval", "small.png", "--method", "reference", "--queries", "q.csv"];
        let words: Vec<&str> = words.into_iter().chain(SMALL[2..].iter().copied()).collect();
        let expected = sandbox.run(&words).done();
        // Root has as many threads as it likes; nobody has not, and must be able to reach program and files.
        let mut program = PathBuf::from(env!("CARGO_BIN_EXE_diffract"));
        let mut command = Command::new("sh");
        if fs::metadata("/proc/self").unwrap().uid() == 0 {
            let copy = sandbox.path("program");
            fs::copy(&program, &copy).unwrap();
            for path in [sandbox.path(""), sandbox.path("..")] {
                fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
            }
            program = copy;
            command.uid(65_534);
        }
        // The limit's letter differs from shell to shell.
        let script = "ulimit -u 1 2>/dev/null || ulimit -p 1 || exit 99; exec \"$0\" \"$@\"";
        command.args(["-c", script]).arg(program);
        command.args(&words).current_dir(sandbox.path("")).env("HOME", "").env("XDG_CACHE_HOME", "");
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let alone = outcome(child.unwrap());
        assert_eq!((alone.code, alone.stdout.as_str()), (Some(0), expected.as_str()), "{}", alone.stderr);
        assert!(alone.stderr.contains("the system gives 0 of"), "{}", alone.stderr);
        assert_eq!(alone.stderr.lines().count(), 1, "{}", alone.stderr);
    }

    #[test]
    fn a_result_for_a_stdout_that_is_closed_is_an_error() {
        let sandbox = with_inputs();
        sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n30,0,20,180\n");
        for words in [
            "--help",
            "--version",
            "surface info flat",
            "eval flat --queries q.csv --method reference --coherence gaussian:5um",
        ] {
            let script = format!("exec \"$0\" {words} >&-");
            let mut command = Command::new("sh");
            command.args(["-c", &script]).arg(env!("CARGO_BIN_EXE_diffract")).current_dir(sandbox.path(""));
            let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
            let line = outcome(child.unwrap()).refused(1);
            assert!(line.contains("stdout is closed"), "{words}: {line}");
        }
        // Whoever throws results away means it, and a file needs no stdout.
        for script in [
            "exec \"$0\" --version >/dev/null",
            "exec \"$0\" surface synth flat --patch 2um -o flat.png <&- 2>&1",
        ] {
            let mut command = Command::new("sh");
            command.args(["-c", script]).arg(env!("CARGO_BIN_EXE_diffract")).current_dir(sandbox.path(""));
            let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
            assert_eq!(outcome(child.unwrap()).code, Some(0), "{script}");
        }
    }

    #[test]
    fn help_and_version_to_a_full_device_are_an_error() {
        let sandbox = Sandbox::new();
        for words in [&["--help"][..], &["--version"], &["render", "--help"]] {
            let full = fs::File::options().write(true).open("/dev/full").unwrap();
            let mut command = sandbox.command(words);
            let full = outcome(command.stdout(full).stderr(Stdio::piped()).spawn().unwrap());
            assert!(full.refused(1).contains("stdout"), "{words:?}");
        }
    }

    #[test]
    fn a_display_that_is_dead_is_told_without_anybodys_sources() {
        let sandbox = Sandbox::new().with("DISPLAY", ":987");
        let line = sandbox.run(["view"]).refused(1);
        assert!(line.contains("display") && !line.contains(".rs"), "{line}");
    }
}
