//! A program that is killed, a disk that is full, a device that is poor: no half result is left or read, and the next run
//! is as good as the first.

use crate::sandbox::{Outcome, SMALL, Sandbox, outcome};
use diffract::internals::random::Random;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Moments at which each of the [`works`] is killed: a picture with its precompute, answers, a surface, a bake.
const KILLS_EACH: [usize; 4] = [35, 20, 10, 25];
/// The same of a sweep.
const KILLS_OF_TRADE: usize = 10;

/// Small work of each kind, and the file that it leaves.
fn works() -> [(Vec<&'static str>, &'static str); 4] {
    let optics = ["--tolerance", "1e-1"];
    let picture =
        ["render", "sphere", "--size", "24x18", "--windows", "1x1", "--samples", "1", "-o", "out.exr"];
    let answers = ["eval", "--queries", "q.csv", "--windows", "1x1", "-o", "out.csv"];
    let surface = ["surface", "synth", "bumps", "--patch", "3um", "-o", "out.tif"];
    let table = ["render", "sphere", "--size", "24x18", "--method", "table", "-o", "baked.exr"];
    [
        ([&picture[..], &SMALL, &optics].concat(), "out.exr"),
        ([&answers[..], &SMALL, &optics].concat(), "out.csv"),
        (surface.to_vec(), "out.tif"),
        ([&table[..], &SMALL, &optics].concat(), "baked.exr"),
    ]
}

/// A small sweep; it keeps each row as soon as it is measured, and goes on there.
const TRADE: [&str; 7] = ["trade", "plate", "--quick", "--size", "4x4", "--folder", "trade"];

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n70,0,10,30,400\n");
    sandbox
}

/// Every file below `folder` by its path, without those that are still being written.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let temporary = entry.file_name().to_string_lossy().starts_with(".diffract-");
        match entry.path() {
            path if path.is_dir() => found.extend(files(&path)),
            path if !temporary => drop(found.insert(path.clone(), fs::read(path).unwrap())),
            _ => {}
        }
    }
    found
}

/// Whether a file of a trade is whole: times differ from run to run, so its bytes do.
fn is_whole(path: &Path, content: &[u8]) -> bool {
    let text = || std::str::from_utf8(content).unwrap_or_default();
    match path.extension().and_then(|e| e.to_str()) {
        Some("png") => image::load_from_memory(content).is_ok(),
        Some("json") => serde_json::from_slice::<serde_json::Value>(content).is_ok(),
        Some("svg") => text().trim_end().ends_with("</svg>"),
        Some("exr") => image::load_from_memory(content).is_ok(),
        _ => !content.is_empty() && text().ends_with('\n'),
    }
}

fn remove(path: &Path) {
    let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
}

/// Starts `arguments` and kills the program after `delay`; whether it was still at work.
fn killed(sandbox: &Sandbox, arguments: &[&str], delay: Duration) -> bool {
    let mut command = sandbox.command(arguments);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(delay);
    let at_work = child.try_wait().unwrap().is_none();
    child.kill().unwrap();
    child.wait().unwrap();
    at_work
}

#[test]
fn killed_at_ninety_random_moments_a_program_leaves_nothing_half() {
    let sandbox = sandbox();
    let mut random = Random::new(0x5eed);
    let (mut at_work, mut complete, mut kept_files) = (0, 0, 0);
    for ((arguments, output), kills) in works().into_iter().zip(KILLS_EACH) {
        remove(&sandbox.cache());
        let begun = Instant::now();
        sandbox.run(&arguments).done();
        let usual = begun.elapsed();
        let (right, kept) = (sandbox.read(output), files(&sandbox.cache()));
        for kill in 0..kills {
            if kill % 3 == 0 {
                remove(&sandbox.cache());
            }
            remove(&sandbox.path(output));
            at_work += usize::from(killed(&sandbox, &arguments, usual.mul_f64(random.share())));
            // Whole or not there: the result, and what the cache holds.
            if sandbox.path(output).exists() {
                assert!(
                    sandbox.read(output) == right,
                    "{arguments:?}: the result of kill {kill} is not whole"
                );
                complete += 1;
            }
            for (path, content) in files(&sandbox.cache()) {
                assert!(kept.get(&path) == Some(&content), "{arguments:?}: kill {kill} left {path:?}");
                kept_files += 1;
            }
        }
        // On top of all that was left behind, the work is done as if nothing had been.
        sandbox.run(&arguments).done();
        assert!(sandbox.read(output) == right && files(&sandbox.cache()) == kept, "{arguments:?}");
    }
    eprintln!(
        "{at_work} programs were killed at work, {complete} results and {kept_files} kept files were whole"
    );
    assert!(at_work > 45, "only {at_work} programs were killed at work");
}

#[test]
fn a_sweep_killed_at_ten_random_moments_keeps_its_rows_and_goes_on() {
    let sandbox = sandbox();
    let arguments = [&TRADE[..], &SMALL].concat();
    let mut random = Random::new(0x7ade);
    let mut rows = String::new();
    let mut longest = Duration::from_secs(3);
    for kill in 0..KILLS_OF_TRADE {
        killed(&sandbox, &arguments, longest.mul_f64(random.share()));
        for (path, content) in files(&sandbox.path("trade")) {
            assert!(is_whole(&path, &content), "kill {kill}: {} is not whole", path.display());
        }
        let now = fs::read_to_string(sandbox.path("trade/trade.csv")).unwrap_or_default();
        assert!(now.starts_with(&rows), "kill {kill} lost rows:\n{rows}\n{now}");
        rows = now;
        // A busy machine takes longer to the first row.
        if rows.lines().count() < 2 {
            longest *= 2;
        }
    }
    assert!(rows.lines().count() > 1, "no row was measured between all the kills");
    // A sweep takes its time on a busy machine, longer than a sandbox waits for anything.
    let mut last = sandbox.command(&arguments);
    assert!(
        last.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status().unwrap().success()
    );
    let done = fs::read_to_string(sandbox.path("trade/trade.csv")).unwrap();
    assert!(done.starts_with(&rows) && files(&sandbox.path("trade")).len() == 4, "{done}");
}

#[test]
fn two_programs_fill_one_cache_at_once_again_and_again() {
    let sandbox = sandbox();
    let [(arguments, output), ..] = works();
    sandbox.run(&arguments).done();
    let (right, kept) = (sandbox.read(output), files(&sandbox.cache()));
    for round in 0..4 {
        remove(&sandbox.cache());
        let start = |output: &str| {
            let mut own = arguments.clone();
            *own.iter_mut().find(|a| **a == "out.exr").unwrap() = output;
            let mut command = sandbox.command(own);
            command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let first = start("a.exr");
        std::thread::sleep(Duration::from_millis(15 * round));
        let second = start("b.exr");
        outcome(first).done();
        outcome(second).done();
        assert!(sandbox.read("a.exr") == right && sandbox.read("b.exr") == right, "round {round}");
        assert_eq!(files(&sandbox.cache()), kept, "round {round}");
    }
}

/// Runs the program where no file may grow beyond `blocks` of 1024 bytes, with the signal for that ignored, so that a
/// write fails as it does on a full disk.
#[cfg(unix)]
fn with_files_of_at_most(sandbox: &Sandbox, blocks: u32, arguments: &[&str]) -> Outcome {
    limited(sandbox, &format!("trap '' XFSZ; ulimit -f {blocks}"), arguments)
}

/// Runs the program after the shell did `limit`.
#[cfg(unix)]
fn limited(sandbox: &Sandbox, limit: &str, arguments: &[&str]) -> Outcome {
    let program = env!("CARGO_BIN_EXE_diffract");
    let script = format!("{limit} || exit 99; exec \"$0\" \"$@\"");
    let command = sandbox.command(arguments);
    let mut shell = std::process::Command::new("bash");
    shell.arg("-c").arg(script).arg(program).args(arguments).current_dir(sandbox.path(""));
    shell.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    for (name, _) in command.get_envs().filter(|(_, value)| value.is_none()) {
        shell.env_remove(name);
    }
    // Its own shader cache would be cut, too.
    shell.env("MESA_SHADER_CACHE_DISABLE", "true").env("MESA_GLSL_CACHE_DISABLE", "true");
    outcome(shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_face_of_millions_of_corners_is_refused_with_little_more_memory_than_its_file() {
    let sandbox = Sandbox::new();
    let corners = 16_000_000;
    sandbox.write(
        "face.obj",
        format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf{}\n", " 1 2 3 4".repeat(corners / 4)),
    );
    let render = ["render", "face.obj", "--size", "8x6", "-o", "o.png"];
    let line = limited(&sandbox, "ulimit -v 400000", &render).refused(1);
    assert!(line.contains(&format!("line 5: a face has {corners} corners")), "{line}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_stack_that_the_system_makes_small_is_large_enough() {
    let sandbox = Sandbox::new();
    for arguments in [&["--version"][..], &["--help"], &["surface", "info", "flat"]] {
        let outcome = limited(&sandbox, "ulimit -s 64", arguments);
        assert!(outcome.code == Some(0) && !outcome.stdout.is_empty(), "{arguments:?}: {outcome:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_driver_that_gets_no_memory_is_not_taken_for_one_that_is_not_installed() {
    let sandbox = Sandbox::new();
    let render = ["render", "plate", "--surface", "flat", "--size", "8x6", "-o", "o.png"];
    let line = limited(&sandbox, "ulimit -v 100000", &render).refused(1);
    assert!(line.contains("ulimit -v") && !line.contains("install"), "{line}");
}

#[cfg(unix)]
#[test]
fn where_the_disk_is_full_results_fail_whole_and_spectra_are_only_not_kept() {
    let sandbox = sandbox();
    let [(picture, output), _, (surface, tiff), _] = works();
    sandbox.run(&picture).done();
    let right = sandbox.read(output);
    let spectra: usize = files(&sandbox.cache()).values().map(Vec::len).sum();
    assert!(
        spectra > 8 * 1024 && right.len() < 7 * 1024,
        "{spectra} bytes of spectra, {} of picture",
        right.len()
    );
    remove(&sandbox.cache());
    remove(&sandbox.path(output));
    // Room for the picture and not for the spectra.
    let done = with_files_of_at_most(&sandbox, 7, &picture);
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(
        done.stderr.starts_with("diffract: the spectra cannot be kept for next time")
            && done.stderr.lines().count() == 1
    );
    assert_eq!(sandbox.read(output), right);
    assert_eq!(fs::read_dir(sandbox.cache()).unwrap().count(), 0, "nothing half in the cache");
    // Room for neither.
    remove(&sandbox.path(output));
    for arguments in [&picture, &surface] {
        let before = sandbox.content();
        let failed = with_files_of_at_most(&sandbox, 1, arguments);
        assert_eq!(failed.code, Some(1), "{failed:?}");
        let line = failed.stderr.lines().last().unwrap();
        assert!(
            line.contains("cannot write: the file would be larger than the system allows")
                && line.contains("free space"),
            "{line}"
        );
        assert_eq!(sandbox.content(), before, "{arguments:?}");
    }
    sandbox.run(&surface).done();
    assert!(!sandbox.read(tiff).is_empty());
}

/// Runs the program with a file system of `bytes` of its own mounted at `folder`, in namespaces of its own, so that this takes
/// no rights; what is left there is told on stdout. `None` where the machine gives no such namespaces.
#[cfg(target_os = "linux")]
fn on_a_small_disk(sandbox: &Sandbox, folder: &Path, bytes: u32, arguments: &[&str]) -> Option<Outcome> {
    const NO_MOUNT: i32 = 99;
    fs::create_dir_all(folder).unwrap();
    let script = format!(
        "cp -r \"$0\" \"$0.before\" && mount -t tmpfs -o size={bytes} none \"$0\" || exit {NO_MOUNT}
         cp -r \"$0.before\"/. \"$0\" || exit 98
         \"$@\"; code=$?; (cd \"$0\" && find . -type f -printf '%P %s\\n'); exit $code"
    );
    let command = sandbox.command(arguments);
    let mut shell = std::process::Command::new("unshare");
    shell.args(["-rm", "bash", "-c", &script]).arg(folder).arg(env!("CARGO_BIN_EXE_diffract"));
    shell.args(arguments).current_dir(sandbox.path(""));
    shell.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    for (name, _) in command.get_envs().filter(|(_, value)| value.is_none()) {
        shell.env_remove(name);
    }
    let child = shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().ok()?;
    let done = outcome(child);
    remove(&folder.with_extension("before"));
    let mounted = done.code != Some(NO_MOUNT) && !done.stderr.starts_with("unshare:");
    if !mounted {
        eprintln!("not tried: this machine lets no user mount a disk of his own ({})", done.stderr.trim());
    }
    mounted.then_some(done)
}

#[cfg(target_os = "linux")]
#[test]
fn on_a_small_disk_that_runs_full_the_former_file_stays_and_nothing_else() {
    let sandbox = sandbox();
    let [(picture, output), _, (surface, _), (table, _)] = works();
    sandbox.run(&picture).done();
    let right = sandbox.read(output);
    // A disk of one page for the results: a former result fits, a new one does not.
    let disk = sandbox.path("disk");
    for (arguments, name) in
        [(&picture, "disk/out.exr"), (&surface, "disk/out.tif"), (&table, "disk/baked.exr")]
    {
        remove(&disk);
        fs::create_dir(&disk).unwrap();
        sandbox.write(name, "former");
        let mut arguments = arguments.clone();
        let last = arguments.iter().position(|word| *word == "-o").unwrap() + 1;
        arguments[last] = name;
        let Some(failed) = on_a_small_disk(&sandbox, &disk, 4096, &arguments) else { return };
        assert_eq!(failed.code, Some(1), "{failed:?}");
        let line = failed.stderr.lines().last().unwrap();
        assert!(line.contains("the disk is full") && line.contains("free space"), "{line}");
        let file = name.trim_start_matches("disk/");
        assert_eq!(failed.stdout, format!("{file} 6\n"), "{arguments:?}");
    }
    remove(&disk);
    // And one for the cache: the picture is there, the spectra cannot be kept for next time.
    remove(&sandbox.cache());
    remove(&sandbox.path(output));
    let Some(done) = on_a_small_disk(&sandbox, &sandbox.cache(), 8192, &picture) else { return };
    assert_eq!((done.code, done.stdout.as_str()), (Some(0), ""), "{done:?}");
    assert!(done.stderr.starts_with("diffract: the spectra cannot be kept for next time"), "{done:?}");
    assert!(done.stderr.contains("the disk is full") && done.stderr.lines().count() == 1, "{done:?}");
    assert_eq!(sandbox.read(output), right);
}

#[cfg(target_os = "linux")]
#[test]
fn answers_that_stdout_cannot_take_are_a_failure() {
    let sandbox = sandbox();
    let mut arguments = works()[1].0.clone();
    arguments.truncate(arguments.len() - 2);
    let arguments: Vec<&str> = arguments.into_iter().filter(|a| !["-o", "out.csv"].contains(a)).collect();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = sandbox.command(arguments);
    let child = command.stdin(Stdio::piped()).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
    let line = outcome(child).refused(1);
    assert!(line.contains("stdout cannot be written") && line.contains("the disk is full"), "{line}");
}

/// Asserts that the picture fails under `mask` in a line with every one of `parts`, and leaves nothing.
#[track_caller]
fn fails_under(mask: &str, code: i32, parts: &[&str]) {
    let sandbox = sandbox().with("DIFFRACT_DEVICE_MASK", mask);
    let before = sandbox.content();
    for (arguments, _) in &works()[..2] {
        let line = sandbox.run(arguments).refused(code);
        for part in parts {
            assert!(line.contains(part), "{mask}: `{part}` is missing in: {line}");
        }
        assert_eq!(sandbox.content(), before, "{mask}: {arguments:?}");
    }
}

#[test]
fn a_device_without_what_is_needed_is_refused_with_its_reason_and_a_way_out() {
    for lacking in
        ["Vulkan 1.3", "dynamic rendering", "synchronization2", "maintenance4", "32-bit float", "timestamps"]
    {
        fails_under(
            &format!("without={lacking}"),
            1,
            &["no Vulkan device here can be used", lacking, "install"],
        );
    }
    let sandbox = Sandbox::new().with("DIFFRACT_DEVICE_MASK", "without=maintenance4");
    let listed = sandbox.run(["devices"]);
    assert!(listed.stdout.contains("cannot be used: it lacks maintenance4"), "{listed:?}");
    assert_eq!((listed.code, listed.stderr.lines().count()), (Some(1), 1), "{listed:?}");
}

#[test]
fn a_device_that_is_too_small_is_told_with_what_to_ask_for_instead() {
    fails_under("memory=1MiB", 1, &["--"]);
    fails_under("side=8", 1, &["8", "--"]);
    fails_under("layers=1", 1, &["layers", "--tolerance"]);
    fails_under("allocation=1", 1, &["no memory for the", "--size"]);
    fails_under("nonsense", 2, &["DIFFRACT_DEVICE_MASK", "nonsense"]);
}

#[test]
fn a_device_with_little_memory_does_small_work() {
    let poor = sandbox().with("DIFFRACT_DEVICE_MASK", "memory=64MiB");
    let rich = sandbox();
    let [picture, answers, _, table] = works();
    for (arguments, output) in [&picture, &answers, &table] {
        poor.run(arguments).done();
        rich.run(arguments).done();
        assert_eq!(poor.read(output), rich.read(output));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn with_little_memory_the_work_is_done_or_refused_and_never_hangs_or_aborts() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n30,0,20,180\n");
    let words =
        ["eval", "blaze", "--queries", "q.csv", "--method", "reference", "--coherence", "gaussian:5um"];
    let mut done = 0;
    // From what the program itself takes to what it takes with threads [KiB].
    for limit in (100_000..300_000).step_by(10_000) {
        let outcome = limited(&sandbox, &format!("ulimit -v {limit}"), &words);
        match outcome.code {
            Some(0) => done += 1,
            // The loader has no room for the program.
            Some(127) => {}
            _ => drop(outcome.refused_somehow(&limit.to_string())),
        }
    }
    assert!(done > 2, "{done} runs are done");
}
