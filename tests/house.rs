//! The structure of `src/`: imports follow the floors of `docs/ARCHITECTURE.md`, and files of one folder form no ring.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on has failed")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What each module at the top of `src/` may import: the table of floors in `docs/ARCHITECTURE.md`.
const FLOORS: [(&str, &[&str]); 33] = [
    ("error", &[]),
    ("filter", &[]),
    ("units", &["error"]),
    ("input", &["error"]),
    ("notes", &[]),
    ("output", &["error"]),
    ("memory", &["error"]),
    ("random", &["error"]),
    ("fft_size", &["error"]),
    ("sums", &[]),
    ("files", &["error", "output"]),
    ("figure", &["error", "notes", "output"]),
    ("vk", &["error", "memory"]),
    ("surface", SMALL),
    ("cache", &["surface", "error", "memory", "output"]),
    ("optics", &["surface", "error", "task", "fft_size", "input", "memory", "output", "random", "units"]),
    ("scene", &["optics", "surface", "error", "task", "input", "memory", "output", "random", "units"]),
    ("budget", &["filter"]),
    ("tolerance", &["error"]),
    ("task", &["error"]),
    (
        "spectra",
        &[
            "budget", "optics", "cache", "surface", "error", "task", "fft_size", "input", "memory", "output",
            "random", "sums", "units",
        ],
    ),
    ("brdf", &["spectra", "budget", "filter", "optics", "surface", "error", "task", "memory"]),
    (
        "table",
        &["spectra", "budget", "brdf", "filter", "cache", "optics", "surface", "error", "task", "memory"],
    ),
    ("settings", &["budget", "table", "spectra", "optics", "surface", "error"]),
    (
        "export",
        &[
            "budget",
            "table",
            "brdf",
            "spectra",
            "scene",
            "filter",
            "cache",
            "optics",
            "surface",
            "error",
            "task",
            "input",
            "memory",
            "notes",
            "output",
            "random",
            "tolerance",
        ],
    ),
    (
        "render",
        &[
            "settings", "budget", "vk", "table", "brdf", "spectra", "scene", "filter", "optics", "surface",
            "error", "task", "input", "memory", "output", "random",
        ],
    ),
    ("picture_file", &["render", "error", "notes", "output"]),
    ("context", &["cache", "vk", "error", "memory"]),
    (
        "setup",
        &[
            "context",
            "settings",
            "budget",
            "render",
            "vk",
            "table",
            "spectra",
            "brdf",
            "scene",
            "cache",
            "filter",
            "optics",
            "surface",
            "error",
            "task",
            "tolerance",
        ],
    ),
    (
        "measure",
        &[
            "settings", "budget", "setup", "render", "table", "spectra", "optics", "surface", "error",
            "task", "input", "memory", "output", "random", "units",
        ],
    ),
    (
        "viewer",
        &[
            "context",
            "settings",
            "budget",
            "spectra",
            "measure",
            "setup",
            "picture_file",
            "figure",
            "render",
            "vk",
            "scene",
            "filter",
            "optics",
            "surface",
            "error",
            "task",
            "input",
            "memory",
            "notes",
            "output",
            "random",
            "units",
        ],
    ),
    (
        "front",
        &[
            "context",
            "settings",
            "setup",
            "measure",
            "picture_file",
            "render",
            "export",
            "figure",
            "table",
            "brdf",
            "scene",
            "cache",
            "filter",
            "optics",
            "surface",
            "error",
            "task",
            "notes",
            "units",
        ],
    ),
    (
        "cli",
        &[
            "context",
            "settings",
            "budget",
            "export",
            "viewer",
            "measure",
            "setup",
            "picture_file",
            "figure",
            "render",
            "vk",
            "table",
            "spectra",
            "brdf",
            "scene",
            "cache",
            "filter",
            "optics",
            "surface",
            "files",
            "error",
            "task",
            "input",
            "memory",
            "notes",
            "output",
            "random",
            "tolerance",
            "units",
        ],
    ),
];

/// The small modules, which import nothing but the error.
const SMALL: &[&str] =
    &["error", "fft_size", "input", "memory", "notes", "output", "random", "sums", "task", "units"];

/// Files of `src/`, relative to it.
fn sources() -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    walk(&root, &mut found);
    found.iter().map(|path| path.strip_prefix(&root).unwrap().to_owned()).collect()
}

/// The module path of a file: `render/frame.rs` and `render/frame/mod.rs` are both `render::frame`.
fn module_of(file: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        file.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    parts.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    parts
}

/// Module paths that `text`, the source of `module`, names after `crate::` and `super::`, tests left out. Braces are expanded
/// one level deep, which is as deep as rustfmt's imports of this crate go.
fn imports(module: &[String], text: &str) -> BTreeSet<Vec<String>> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code: String =
        code.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + " ").collect();
    let mut found = BTreeSet::new();
    for root in ["crate::", "super::"] {
        for (at, _) in code.match_indices(root) {
            if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':')
                || code[..at].ends_with("pub(in ")
            {
                continue;
            }
            let mut rest = &code[at..];
            let mut path = module.to_vec();
            if rest.starts_with("crate::") {
                (path, rest) = (Vec::new(), &rest["crate::".len()..]);
            }
            while let Some(next) = rest.strip_prefix("super::") {
                path.pop();
                rest = next;
            }
            let name = |text: &str| {
                text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
            };
            loop {
                let part = name(rest);
                if part.is_empty() {
                    break;
                }
                rest = &rest[part.len()..];
                path.push(part);
                match rest.strip_prefix("::") {
                    Some(next) => rest = next,
                    None => break,
                }
            }
            match rest.strip_prefix('{') {
                Some(list) => {
                    let list = list.split_inclusive(['}', ';']).next().unwrap_or_default();
                    found.extend(list.split(',').map(|item| {
                        let item = item.trim().trim_start_matches('{');
                        let parts = item.split("::").map(name).take_while(|part| !part.is_empty());
                        path.iter().cloned().chain(parts).collect::<Vec<_>>()
                    }));
                }
                None => {
                    found.insert(path);
                }
            }
        }
    }
    found
}

/// For each file's module the modules of other files that it imports.
fn graph() -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = sources();
    let modules: BTreeSet<Vec<String>> = files.iter().map(|file| module_of(file)).collect();
    let is_test = |file: &Path| file.to_string_lossy().ends_with("tests.rs");
    files
        .iter()
        .filter(|file| !is_test(file))
        .map(|file| {
            let module = module_of(file);
            let text = std::fs::read_to_string(root.join(file)).unwrap();
            // The longest prefix that is a file's module; what is left names an item.
            let owner = |path: &Vec<String>| {
                (1..=path.len()).rev().map(|n| path[..n].to_vec()).find(|prefix| modules.contains(prefix))
            };
            let imported =
                imports(&module, &text).iter().filter_map(owner).filter(|m| *m != module).collect();
            (module, imported)
        })
        .collect()
}

/// The files of `src/` and of the folders with shaders, each with its text.
fn texts() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let in_folder =
        |name: &str| std::fs::read_dir(root.join(name)).unwrap().map(|entry| entry.unwrap().path());
    let shaders = ["shaders", "shaders/export", "assets/export"].into_iter().flat_map(in_folder);
    let files =
        sources().into_iter().map(|file| root.join("src").join(file)).chain(shaders.filter(|p| p.is_file()));
    files.map(|file| (file.clone(), std::fs::read_to_string(&file).unwrap())).collect()
}

/// The lines of `text` with a comment that begins with a question word, and their numbers.
fn questions(text: &str) -> Vec<(usize, &str)> {
    const AVOIDED: [&str; 7] = ["What", "Where", "Whether", "How", "Which", "Of", "As"];
    let begins = |line: &str| {
        let comment = line.trim_start().strip_prefix("//")?;
        let first = comment.trim_start_matches(['/', '!']).split_whitespace().next()?;
        AVOIDED.contains(&first).then_some(())
    };
    (1..).zip(text.lines()).filter(|(_, line)| begins(line).is_some()).collect()
}

/// Counts `word` in `text`, as a word of letters alone.
fn occurrences(text: &str, word: &str) -> usize {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|found| *found == word).count()
}

/// Comments begin with a verb or a noun: a question word in front is a sentence that says what a name says already.
#[test]
fn comments_begin_with_a_verb_or_a_noun() {
    let mut wrong = Vec::new();
    for (file, text) in texts() {
        let found = questions(&text);
        wrong.extend(found.iter().map(|(line, comment)| format!("{}:{line}: {comment}", file.display())));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The name `own` says neither whose a thing is nor what it is.
#[test]
fn things_have_names_of_what_they_are() {
    const MOST_OWN: usize = 100;
    let count: usize = texts().iter().map(|(_, text)| occurrences(text, "own")).sum();
    assert!(count <= MOST_OWN, "`own` stands {count} times in src and shaders: say whose, or name the thing");
}

#[test]
fn question_words_and_occurrences_are_found() {
    let text = "/// Returns a.\n    // Where b is.\nlet what = 1; // What\n//! As c\n// own";
    let lines: Vec<usize> = questions(text).iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [2, 4]);
    assert_eq!(occurrences("own, its own; own_rms known\n`own`", "own"), 3);
}

#[test]
fn a_module_imports_from_floors_below_its_own_alone() {
    let allowed: BTreeMap<&str, &[&str]> = FLOORS.into_iter().collect();
    for (module, imported) in graph() {
        let Some(floor) = module.first().and_then(|top| allowed.get(top.as_str())) else { continue };
        for other in imported.iter().filter(|other| other[0] != module[0]) {
            assert!(
                floor.contains(&other[0].as_str()),
                "{} imports {}, which is not on a floor below {}",
                module.join("::"),
                other.join("::"),
                module[0]
            );
        }
    }
}

/// A ring among the files of a folder, if there is one. A sub-folder counts as one file; the folder's own `mod.rs` counts as
/// none, because it may hold what its files share.
fn ring(edges: &BTreeMap<String, BTreeSet<String>>) -> Option<String> {
    let mut left = edges.clone();
    // Files without imports among those that are left cannot be part of a ring.
    while let Some(free) =
        left.iter().find(|(_, to)| !to.iter().any(|t| left.contains_key(t))).map(|(f, _)| f.clone())
    {
        left.remove(&free);
    }
    (!left.is_empty()).then(|| left.keys().cloned().collect::<Vec<_>>().join(", "))
}

#[test]
fn files_of_one_folder_form_no_ring() {
    let graph = graph();
    let mut folders: BTreeMap<Vec<String>, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (module, imported) in &graph {
        for depth in 0..module.len() {
            let (folder, file) = (&module[..depth], &module[depth]);
            let edges = folders.entry(folder.to_vec()).or_default().entry(file.clone()).or_default();
            let beside =
                imported.iter().filter(|to| to.len() > depth && to[..depth] == *folder && to[depth] != *file);
            edges.extend(beside.map(|to| to[depth].clone()));
        }
    }
    let rings: BTreeMap<String, String> =
        folders.iter().filter_map(|(folder, edges)| Some((folder.join("/"), ring(edges)?))).collect();
    assert!(rings.is_empty(), "files of these folders import each other in a ring: {rings:?}");
}

#[test]
fn imports_and_rings_are_found() {
    let module = ["a".to_owned(), "b".to_owned()];
    let text = "use super::c::{D, E};\nuse crate::{f, g::h};\nlet x = crate::i::j(); // crate::k\n#[cfg(test)]\nuse crate::l;";
    let found: Vec<String> = imports(&module, text).iter().map(|path| path.join("::")).collect();
    assert_eq!(found, ["a::c::D", "a::c::E", "f", "g::h", "i::j"]);
    let edges = |list: &[(&str, &str)]| {
        let mut map: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in list {
            map.entry((*from).to_owned()).or_default().insert((*to).to_owned());
            map.entry((*to).to_owned()).or_default();
        }
        map
    };
    assert_eq!(ring(&edges(&[("a", "b"), ("b", "c"), ("a", "c")])), None);
    assert!(ring(&edges(&[("a", "b"), ("b", "c"), ("c", "b")])).is_some());
}

/// The string literals of `code` outside of comments and test modules, each with its line.
fn literals(code: &str) -> Vec<(usize, String)> {
    let code = code.split("#[cfg(test)]").next().unwrap_or_default();
    let mut found = Vec::new();
    let mut line = 1;
    let mut rest = code.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\n' => line += 1,
            // The newline that ends a comment is counted above.
            '/' if rest.peek() == Some(&'/') => while rest.next_if(|&c| c != '\n').is_some() {},
            // A quotation mark as a character is no literal's begin.
            '\'' if rest.peek() == Some(&'"') => _ = rest.next(),
            '"' => {
                let (begin, mut text) = (line, String::new());
                while let Some(c) = rest.next().filter(|&c| c != '"') {
                    let escaped = if c == '\\' { rest.next() } else { None };
                    line += usize::from(c == '\n') + usize::from(escaped == Some('\n'));
                    text.extend(std::iter::once(c).chain(escaped));
                }
                found.push((begin, text));
            }
            _ => {}
        }
    }
    found
}

/// Whether `text` names an option or a command of the program.
fn names_the_command_line(text: &str) -> bool {
    let option =
        |(at, _): (usize, &str)| text[at + 2..].starts_with(|c: char| c.is_ascii_lowercase() || c == '{');
    text.match_indices("--").any(option) || text.contains("`diffract ")
}

#[test]
fn words_of_the_command_line_stand_in_cli_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let is_test = |file: &Path| file.to_string_lossy().ends_with("tests.rs");
    // The window says beside each control which option sets the same; all of these words stand in one file.
    let names_options = |file: &Path| file.starts_with("cli") || file == Path::new("viewer/panel/rows.rs");
    for file in sources().into_iter().filter(|file| !names_options(file) && !is_test(file)) {
        for (line, text) in literals(&std::fs::read_to_string(root.join(&file)).unwrap()) {
            assert!(
                !names_the_command_line(&text),
                "src/{}:{line} has words of the command line: {text}",
                file.display()
            );
        }
    }
}

#[test]
fn literals_and_words_of_the_command_line_are_found() {
    let code = "a(\"x\", '\"'); // \"no\"\nb(\"y \\\" z\");\n#[cfg(test)]\nc(\"no\");";
    assert_eq!(literals(code), [(1, "x".to_owned()), (2, "y \\\" z".to_owned())]);
    for text in ["use --method table", "--{name}", "see `diffract devices`"] {
        assert!(names_the_command_line(text), "{text}");
    }
    for text in ["a -- b", "---", "a bug of diffract"] {
        assert!(!names_the_command_line(text), "{text}");
    }
}

/// The names of the types that `code` declares outside of comments and test modules.
fn types(code: &str) -> Vec<String> {
    // A test module that is a file of its own may be named in the middle.
    let has_body = |line: &str| line.contains("mod ") && line.ends_with('{');
    let is_inside = |(at, _): &(usize, &str)| code[*at..].lines().nth(1).is_some_and(has_body);
    let end = code.match_indices("#[cfg(test)]").find(is_inside).map_or(code.len(), |(at, _)| at);
    let declared = |line: &str| {
        let is_visibility = |word: &&str| word.starts_with("pub") || word.ends_with(')');
        let mut words = line.split_whitespace().skip_while(is_visibility);
        let kind = words.next()?;
        let name = words.next().filter(|_| ["struct", "enum", "trait"].contains(&kind))?;
        Some(name.chars().take_while(|c| c.is_alphanumeric()).collect())
    };
    code[..end].lines().filter_map(declared).filter(|name: &String| !name.is_empty()).collect()
}

#[test]
fn a_type_name_stands_for_one_type() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let is_test = |file: &Path| file.to_string_lossy().ends_with("tests.rs");
    // What clap reads a command into, always used with the module of the command: `brdf::Arguments`.
    let is_of_command =
        |file: &Path, name: &str| file.starts_with("cli") && ["Arguments", "Command"].contains(&name);
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    for file in sources().into_iter().filter(|file| !is_test(file)) {
        for name in types(&std::fs::read_to_string(root.join(&file)).unwrap()) {
            if is_of_command(&file, &name) {
                continue;
            }
            if let Some(other) = known.insert(name.clone(), file.clone()) {
                panic!(
                    "`{name}` is a type of src/{} and another one of src/{}: name each by what it alone is",
                    other.display(),
                    file.display()
                );
            }
        }
    }
}

#[test]
fn types_are_found() {
    let code = "pub struct A<'a> {\nstruct B(u8);\n    pub(super) enum C {\npub(in crate::render) trait D: E {\n// struct F\n/// enum G\nstruct $name;\nconst H: I = J;\n#[cfg(test)]\nmod k;\nstruct L;\n#[cfg(test)]\nmod tests {\nstruct M;";
    assert_eq!(types(code), ["A", "B", "C", "D", "L"]);
}

/// Numbers of the lines of `code`, outside of test modules, that drop an error without a reason: a comment in the line or in the one before.
fn dropped_errors(code: &str) -> Vec<usize> {
    /// Calls that fail for reasons of their own.
    const FALLIBLE: [&str; 6] = ["lock()", "serde_json::", "toml::", "fs::", "read_text(", ".parse"];
    let drops = |line: &str| {
        let ignored = line.trim_start().strip_prefix("let _ = ");
        line.contains("Err(_)")
            // Writing to a String cannot fail.
            || ignored.is_some_and(|what| what.contains('(') && !what.starts_with('(') && !what.starts_with("write"))
            || line.contains("unwrap_or_default()") && FALLIBLE.iter().any(|call| line.contains(call))
    };
    let lines: Vec<&str> = code.split("#[cfg(test)]\nmod tests").next().unwrap_or(code).lines().collect();
    let has_reason = |i: usize| lines[i].contains("// ") || i > 0 && lines[i - 1].contains("// ");
    (0..lines.len()).filter(|&i| drops(lines[i]) && !has_reason(i)).map(|i| i + 1).collect()
}

#[test]
fn an_error_is_dropped_for_a_reason_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let is_test =
        |file: &Path| ["tests.rs", "testing.rs"].iter().any(|end| file.to_string_lossy().ends_with(end));
    for file in sources().into_iter().filter(|file| !is_test(file)) {
        let dropped = dropped_errors(&std::fs::read_to_string(root.join(&file)).unwrap());
        assert!(
            dropped.is_empty(),
            "src/{}: the lines {dropped:?} drop an error: pass it on, or say in a comment why not",
            file.display()
        );
    }
}

#[test]
fn dropped_errors_are_found() {
    let code = "Err(_) => 0,\nErr(_) => 0, // none\n// none\nlet _ = a();\nlet _ = a();\nlet _ = write!(s, \"\");\nlet _ = (a, b);\nfs::read(a).unwrap_or_default()\na.unwrap_or_default()\n#[cfg(test)]\nmod tests {\nlet _ = a();\n";
    assert_eq!(dropped_errors(code), [1, 5, 8]);
}

#[test]
fn the_python_module_and_the_citation_have_the_program_s_version() {
    let read =
        |name: &str| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let version = format!("version = \"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(read("python/Cargo.toml").lines().any(|line| line == version), "python/Cargo.toml: {version}");
    let cited = format!("version: {}", env!("CARGO_PKG_VERSION"));
    assert!(read("CITATION.cff").lines().any(|line| line == cited), "CITATION.cff: {cited}");
}

/// Returns the packages that cargo compiles for `selection`, each with every set of features it is compiled with.
fn compiled(selection: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let tree = std::process::Command::new(cargo)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["tree", "--locked", "--quiet", "--prefix", "none", "--no-dedupe", "--format", "{p}|{f}"])
        .args(selection)
        .output()
        .unwrap();
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in String::from_utf8(tree.stdout).unwrap().lines() {
        if let Some((package, features)) = line.split_once('|') {
            found.entry(package.to_owned()).or_default().insert(features.to_owned());
        }
    }
    found
}

#[test]
fn the_program_its_tests_and_the_python_module_share_what_is_built() {
    let tests = compiled(&["--edges", "normal,build,dev"]);
    let program = compiled(&["--edges", "normal,build"]);
    let module = compiled(&["--edges", "normal,build", "--package", "diffract-python"]);
    assert!(program.len() > 200 && module.len() > 200);
    for (package, features) in program.iter().chain(&module) {
        if let Some(of_tests) = tests.get(package) {
            assert!(
                features.is_subset(of_tests),
                "{package} has the features {features:?}, and {of_tests:?} in the tests: it and what stands on it are built twice"
            );
        }
    }
}
