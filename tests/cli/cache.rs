//! Spectra kept for next time: never wrong, never in the way.

use crate::sandbox::{Outcome, SMALL, Sandbox, outcome};
use std::fs;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Arguments of a small picture through one window, whose layers are the one file that is kept: Stam's theory has no limit of energy.
fn picture(output: &'static str) -> Vec<&'static str> {
    [
        &["render", "sphere", "--size", "24x18", "--tolerance", "1e-1", "--windows", "1x1", "-o", output][..],
        &["--theory", "stam"],
        &SMALL,
    ]
    .concat()
}

fn kept(sandbox: &Sandbox) -> Vec<PathBuf> {
    fs::read_dir(sandbox.cache()).map_or(vec![], |files| files.map(|f| f.unwrap().path()).collect())
}

/// The picture without any cache.
fn cold() -> (Sandbox, Vec<u8>) {
    let sandbox = Sandbox::with_small_surface();
    sandbox.run(picture("cold.exr")).done();
    let bytes = sandbox.read("cold.exr");
    (sandbox, bytes)
}

#[test]
fn a_damaged_file_is_rebuilt_without_a_word_and_the_picture_is_the_same() {
    let (sandbox, right) = cold();
    let [file] = &kept(&sandbox)[..] else { panic!("one file") };
    let whole = fs::read(file).unwrap();
    let flipped =
        |place: usize| whole.iter().enumerate().map(|(i, b)| if i == place { !b } else { *b }).collect();
    let foreign = {
        let other = Sandbox::with_small_surface();
        other.run2(&picture("other.exr"), &["--ior", "1.5", "--terms", "3"]).done();
        fs::read(&kept(&other)[0]).unwrap()
    };
    assert_ne!(foreign, whole);
    let bad: [Vec<u8>; 8] = [
        vec![],
        whole[..10].to_vec(),
        whole[..whole.len() / 2].to_vec(),
        whole[..whole.len() - 1].to_vec(),
        flipped(0),
        flipped(60),
        flipped(whole.len() / 2),
        foreign,
    ];
    for (index, content) in bad.iter().enumerate() {
        fs::write(file, content).unwrap();
        sandbox.run(picture("again.exr")).done();
        assert_eq!(sandbox.read("again.exr"), right, "damage {index}");
        assert_eq!(fs::read(file).unwrap(), whole, "damage {index} is repaired");
        assert_eq!(kept(&sandbox).len(), 1, "damage {index}");
    }
}

#[cfg(unix)]
#[test]
fn what_stands_in_the_place_of_a_file_does_no_harm() {
    let (sandbox, right) = cold();
    let [file] = &kept(&sandbox)[..] else { panic!("one file") };
    let warned = |outcome: Outcome, what: &str| {
        assert_eq!(outcome.code, Some(0), "{what}: {outcome:?}");
        assert!(outcome.stderr.lines().count() <= 1 && outcome.stdout.is_empty(), "{what}: {outcome:?}");
        assert_eq!(sandbox.read("again.exr"), right, "{what}");
    };
    fs::remove_file(file).unwrap();
    fs::create_dir(file).unwrap();
    warned(sandbox.run(picture("again.exr")), "a folder");
    fs::remove_dir(file).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(file).status().unwrap().success());
    warned(sandbox.run(picture("again.exr")), "a pipe");
    fs::remove_file(file).unwrap();
    std::os::unix::fs::symlink("/dev/zero", file).unwrap();
    warned(sandbox.run(picture("again.exr")), "a device");
    fs::remove_file(file).unwrap();
}

#[cfg(unix)]
#[test]
fn a_link_in_the_cache_overwrites_nothing_and_the_folder_is_closed_to_others() {
    use std::os::unix::fs::PermissionsExt;
    let (sandbox, right) = cold();
    let [file] = &kept(&sandbox)[..] else { panic!("one file") };
    sandbox.write("victim", "precious");
    fs::remove_file(file).unwrap();
    std::os::unix::fs::symlink(sandbox.path("victim"), file).unwrap();
    sandbox.run(picture("again.exr")).done();
    assert_eq!(sandbox.read("again.exr"), right);
    assert_eq!(sandbox.read("victim"), b"precious");
    assert!(fs::symlink_metadata(file).unwrap().is_file());
    assert_eq!(fs::metadata(sandbox.cache()).unwrap().permissions().mode() & 0o777, 0o700);
}

#[test]
fn the_cache_is_shown_bounded_and_cleared() {
    let (sandbox, right) = cold();
    let size = fs::metadata(&kept(&sandbox)[0]).unwrap().len();
    let shown = sandbox.run(["cache"]).done();
    assert!(shown.contains(&sandbox.cache().display().to_string()), "{shown}");
    assert!(shown.contains("layers") && shown.contains(&format!("{size} bytes")), "{shown}");
    // Room for one of two.
    let room = size * 11 / 5; // the second takes twice as much
    let bound = format!("{room}B");
    sandbox.run2(&picture("other.exr"), &["--ior", "1.6", "--terms", "3", "--cache-size", &bound]).done();
    let held: u64 = kept(&sandbox).iter().map(|file| fs::metadata(file).unwrap().len()).sum();
    assert!(kept(&sandbox).len() == 1 && held <= room, "{held}");
    let refused = sandbox.run2(&picture("again.exr"), &["--cache-size", "1kB"]);
    assert!(refused.code == Some(0) && refused.stderr.contains("--cache-size"), "{refused:?}");
    let cleared = sandbox.run(["cache", "clear"]).done();
    assert!(cleared.contains("1 file removed"), "{cleared}");
    assert!(kept(&sandbox).is_empty());
    sandbox.run2(&picture("none.exr"), &["--cache-size", "0"]).done();
    assert!(kept(&sandbox).is_empty() && sandbox.read("none.exr") == right);
    assert_eq!(sandbox.run(["cache", "--cache-size", "-1MB"]).code, Some(2));
}

#[test]
fn without_a_place_to_keep_spectra_the_work_is_done_with_one_warning() {
    let (_, right) = cold();
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("file", "in the way");
    let blocked = sandbox.path("file");
    let sandbox = sandbox.with("XDG_CACHE_HOME", blocked);
    let outcome = sandbox.run(picture("out.exr"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let lines: Vec<&str> = outcome.stderr.lines().collect();
    assert!(
        matches!(lines[..], [line] if line.starts_with("diffract: the spectra cannot be kept for next time")),
        "{outcome:?}"
    );
    assert_eq!(sandbox.read("out.exr"), right);
    assert_eq!(sandbox.read("file"), b"in the way");
}

#[test]
fn without_a_home_the_work_is_done_without_a_word() {
    let (_, right) = cold();
    let sandbox = Sandbox::with_small_surface().with("XDG_CACHE_HOME", "").with("HOME", "");
    sandbox.run(picture("out.exr")).done();
    assert_eq!(sandbox.read("out.exr"), right);
}

#[test]
fn processes_at_once_share_a_cache_and_an_output() {
    let (_, right) = cold();
    let sandbox = Sandbox::with_small_surface();
    let start = || {
        let mut command = sandbox.command(picture("out.exr"));
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let started: Vec<_> = (0..3).map(|_| start()).collect();
    for child in started {
        outcome(child).done();
    }
    assert_eq!(sandbox.read("out.exr"), right);
    assert_eq!(kept(&sandbox).len(), 1);
    assert_eq!(sandbox.content().len(), 2, "the surface and the picture");
}

#[test]
fn a_program_killed_at_any_moment_leaves_nothing_that_is_read_later() {
    let (_, right) = cold();
    let sandbox = Sandbox::with_small_surface();
    let begun = Instant::now();
    sandbox.run(picture("warm.exr")).done();
    let usual = begun.elapsed();
    for step in 0..12 {
        let _ = fs::remove_dir_all(sandbox.cache());
        let mut command = sandbox.command(picture("out.exr"));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(usual * step / 12 + Duration::from_millis(1));
        child.kill().unwrap();
        child.wait().unwrap();
        // Whole or not there, wherever the end came.
        if sandbox.path("out.exr").exists() {
            assert_eq!(sandbox.read("out.exr"), right, "killed in step {step}");
            fs::remove_file(sandbox.path("out.exr")).unwrap();
        }
        sandbox.run(picture("next.exr")).done();
        assert_eq!(sandbox.read("next.exr"), right, "after step {step}");
    }
}

#[cfg(unix)]
#[test]
fn leftovers_of_a_killed_program_are_swept_when_they_are_old() {
    let (sandbox, _) = cold();
    let [old, young, other] =
        [".diffract-old", ".diffract-young", "mine"].map(|name| sandbox.cache().join(name));
    for file in [&old, &young, &other] {
        fs::write(file, "half").unwrap();
    }
    let long_ago = std::time::SystemTime::now() - Duration::from_secs(3 * 24 * 3600);
    for file in [&old, &other] {
        fs::File::options().write(true).open(file).unwrap().set_modified(long_ago).unwrap();
    }
    sandbox.run2(&picture("again.exr"), &["--terms", "3"]).done();
    assert!(!old.exists() && young.exists() && other.exists());
}
