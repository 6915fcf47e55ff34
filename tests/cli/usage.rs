//! Help, version, and wrong use.

use crate::sandbox::Sandbox;

/// Every command and what its help has to mention.
pub const COMMANDS: [(&[&str], &str); 22] = [
    (&["view"], "--fps"),
    (&["render"], "--exposure"),
    (&["eval"], "--queries"),
    (&["brdf"], "--light"),
    (&["colour"], "--aspecular"),
    (&["orders"], "--wavelength"),
    (&["export"], "--footprint"),
    (&["peaks"], "--angles"),
    (&["profile"], "--frames"),
    (&["trade"], "--quick"),
    (&["surface"], "synth"),
    (&["surface", "info"], "--level"),
    (&["surface", "compare"], "--aperture"),
    (&["surface", "convert"], "--channel"),
    (&["surface", "synth"], "--patch"),
    (&["cache"], "clear"),
    (&["cache", "clear"], "Remove"),
    (&["lights"], "--rotate-environment"),
    (&["devices"], "--device"),
    (&["help"], "COMMAND"),
    (&["completions"], "bash"),
    (&["manual"], "FOLDER"),
];

#[test]
fn help_of_every_command_goes_to_stdout_with_exit_code_0() {
    let sandbox = Sandbox::new();
    let top = sandbox.run(["--help"]).done();
    assert!(top.contains("Examples:"));
    for (command, mentioned) in COMMANDS {
        assert!(command.len() > 1 || top.contains(command[0]), "{command:?} is not in the help");
        let help = sandbox.run2(command, &["--help"]).done();
        assert!(help.contains(mentioned) && help.contains("Usage: diffract"), "{command:?}: {help}");
        assert!(
            help.contains("Example") || [&["surface"][..], &["cache", "clear"]].contains(&command),
            "{command:?} has no example"
        );
    }
}

/// Returns the options that a help lists.
fn options(help: &str) -> Vec<&str> {
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    lines.filter_map(|line| line.split([' ', ',']).find(|word| word.starts_with("--"))).collect()
}

#[test]
fn the_short_help_of_every_command_fits_a_screen_and_says_where_the_rest_is() {
    /// Lines of a usual terminal.
    const LINES: usize = 50;
    let sandbox = Sandbox::new();
    for command in COMMANDS.map(|(command, _)| command).into_iter().chain([&[][..]]) {
        let [short, long] = ["-h", "--help"].map(|flag| sandbox.run2(command, &[flag]).done());
        assert!(short.contains("Usage: diffract"), "{command:?}: {short}");
        assert!(short.lines().count() <= LINES, "{command:?} has {} lines:\n{short}", short.lines().count());
        let [usual, all] = [options(&short), options(&long)];
        assert!(usual.iter().all(|option| all.contains(option)), "{command:?}: {usual:?}");
        let tells = short.trim_end().ends_with("--help shows all of them, with examples.");
        assert_eq!(tells, usual.len() < all.len(), "{command:?}:\n{short}");
    }
    assert!(options(&sandbox.run(["render", "--help"]).done()).len() > 40, "options are found");
}

#[test]
fn help_completions_and_pages_for_man_come_from_the_program() {
    let sandbox = Sandbox::new();
    for command in [&[][..], &["render"], &["surface", "info"]] {
        assert_eq!(sandbox.run2(&["help"], command).done(), sandbox.run2(command, &["--help"]).done());
    }
    assert!(sandbox.run(["help", "rendr"]).refused(2).contains("do you mean render?"));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = sandbox.run(["completions", shell]).done();
        assert!(script.contains("render") && script.contains("tolerance"), "{shell}");
    }
    sandbox.run(["manual", "."]).done();
    // Hyphens are escaped.
    let page = |name: &str| String::from_utf8(sandbox.read(name)).unwrap().replace("\\-", "-");
    assert!(
        page("diffract.1").contains("diffract-render(1)") && page("diffract-render.1").contains("exposure")
    );
    assert!(page("diffract-surface-info.1").starts_with(".ie"), "a page for man");
    assert!(sandbox.run(["manual", "nowhere"]).refused(2).contains("no such folder"));
}

#[test]
fn help_of_pictures_says_what_is_measured_and_lists_the_tones() {
    let sandbox = Sandbox::new();
    for command in ["render", "view"] {
        let help = sandbox.run([command, "--help"]).done();
        for mentioned in ["--exposure <EV|auto>", "all of a sequence", "--tone <NAME>", "neutral"] {
            assert!(help.contains(mentioned), "{command}: `{mentioned}` is missing in: {help}");
        }
    }
}

#[test]
fn the_list_of_commands_in_these_tests_is_the_programs() {
    let sandbox = Sandbox::new();
    for parent in [&[][..], &["surface"], &["cache"]] {
        let help = sandbox.run2(parent, &["--help"]).done();
        let (_, list) = help.split_once("Commands:\n").unwrap();
        for line in list.lines().take_while(|line| !line.is_empty()) {
            let Some(name) = line.strip_prefix("  ").and_then(|l| l.split_whitespace().next()) else {
                continue;
            };
            if line.starts_with("   ") {
                continue; // a description that is wrapped
            }
            let path: Vec<&str> = parent.iter().copied().chain([name]).collect();
            assert!(COMMANDS.iter().any(|(command, _)| *command == path), "{path:?} is not tested");
        }
    }
}

#[test]
fn the_version_goes_to_stdout_with_exit_code_0() {
    for flag in ["--version", "-V"] {
        let expected = concat!("diffract ", env!("CARGO_PKG_VERSION"), "\n");
        assert_eq!(Sandbox::new().run([flag]).done(), expected);
    }
}

#[test]
fn wrong_use_is_one_line_with_exit_code_2_that_names_where_the_help_is() {
    let sandbox = Sandbox::new();
    for (arguments, parts) in [
        (&[][..], &["no command", "`diffract --help`"][..]),
        (&["surface"], &["no command", "`diffract surface --help`"]),
        (&["rendr"], &["'rendr'", "render?", "`diffract --help`"]),
        (&[""], &["''"]),
        (&["help", "now"], &["'now'", "`diffract --help`"]),
        (&["--hepl"], &["--hepl", "`diffract --help`"]),
        (&["render"], &["--output", "`diffract render --help`"]),
        (&["render", "-o"], &["--output", "`diffract render --help`"]),
        (&["render", "elaphe", "-o", "a.png"], &["is a surface and no scene", "--surface NAME"]),
        (&["render", "skin.gsf", "-o", "a.png"], &["is a surface and no scene", "--surface NAME"]),
        (&["render", "plate", "sphere", "-o", "a.png"], &["'sphere'", "`diffract render --help`"]),
        (&["render", "-o", "a.png", "--sise", "4x4"], &["--sise", "--size?"]),
        (&["render", "-o", "a.png", "--ior", "1.5", "--ior", "2"], &["--ior"]),
        (&["render", "nothing", "-o", "a.png"], &["`nothing`", "snake, plate, sphere, disc"]),
        (&["eval", "blaze"], &["--queries", "`diffract eval --help`"]),
        (&["eval", "blaze", "--surface", "flat", "--queries", "q.csv"], &["twice"]),
        (&["brdf", "blaze", "--light", "30,0"], &["--output", "`diffract brdf --help`"]),
        (&["brdf", "blaze", "-o", "a.png"], &["--light", "`diffract brdf --help`"]),
        (&["orders", "blaze", "--light", "30,0"], &["--wavelength", "`diffract orders --help`"]),
        (&["peaks", "blaze", "--theta-i", "30"], &["--angles", "`diffract peaks --help`"]),
        (&["peaks", "blaze", "--angles", "0:9:1"], &["--theta-i", "`diffract peaks --help`"]),
        (&["surface", "synth", "blaze"], &["--output", "`diffract surface synth --help`"]),
        (&["surface", "synth", "marble", "-o", "a.png"], &["`marble`", "xenopeltis"]),
        (&["devices", "now"], &["'now'", "`diffract devices --help`"]),
    ] {
        // The queries have to be there for the surface to be looked at.
        sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n0,0,0,0\n");
        let line = sandbox.run(arguments).refused(2);
        for part in parts {
            assert!(line.contains(part), "{arguments:?}: `{part}` is missing in: {line}");
        }
    }
}

#[cfg(unix)]
#[test]
fn an_argument_that_is_no_text_is_refused_in_one_line() {
    use std::os::unix::ffi::OsStrExt;
    let odd = std::ffi::OsStr::from_bytes(b"\xff\xfe.toml");
    let sandbox = Sandbox::new();
    sandbox.run([odd]).refused(2);
    // As the name of a scene it can be right, and there is no such file.
    sandbox.run(["render".as_ref(), odd, "-o".as_ref(), "a.png".as_ref()]).refused(1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error_and_a_closed_one_is_not() {
    use crate::sandbox::outcome;
    use std::process::Stdio;
    let sandbox = Sandbox::new();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = sandbox.command(["surface", "info", "flat"]);
    let full = outcome(command.stdout(full).stderr(Stdio::piped()).spawn().unwrap());
    assert!(full.refused(1).contains("stdout"));
    let mut command = sandbox.command(["surface", "info", "flat"]);
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let closed = outcome(command.stdout(writer).stderr(Stdio::piped()).spawn().unwrap());
    closed.done();
}
