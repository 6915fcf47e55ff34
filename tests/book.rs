//! The book in `docs/`: its links, its pages, its pictures, and the commands that take little time.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};

/// Returns the pages whose links are checked.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "assets/README.md"]
            .map(|name| root.join(name))
            .to_vec();
    for folder in ["docs", "docs/decisions"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            found.extend(
                Some(entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "md")),
            );
        }
    }
    found
}

/// Returns `text` without its blocks of code.
fn prose(text: &str) -> String {
    let mut inside = false;
    let is_prose = |line: &&str| {
        let is_fence = line.trim_start().starts_with("```");
        inside ^= is_fence;
        !inside && !is_fence
    };
    text.lines().filter(is_prose).flat_map(|line| [line, "\n"]).collect()
}

/// Returns the targets of the links and pictures of a page.
fn targets(text: &str) -> Vec<String> {
    let prose = prose(text);
    prose
        .match_indices("](")
        .filter_map(|(at, _)| Some(prose[at + 2..].split_once(')')?.0.to_owned()))
        .collect()
}

/// Returns the anchors of a page: its headings in lower case, with hyphens for spaces and without other signs.
fn anchors(text: &str) -> Vec<String> {
    let anchor = |heading: &str| {
        let kept = |c: char| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        };
        heading.trim().to_lowercase().chars().filter_map(kept).collect()
    };
    prose(text)
        .lines()
        .filter(|line| line.starts_with('#'))
        .map(|line| anchor(line.trim_start_matches('#')))
        .collect()
}

/// Says why `target`, a link of the page at `page`, leads nowhere; none if it leads somewhere.
fn broken(page: &Path, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = target.split_once('#').map_or((target, None), |(file, anchor)| (file, Some(anchor)));
    let path = if file.is_empty() { page.to_owned() } else { page.parent().unwrap().join(file) };
    let Ok(exists) = path.canonicalize() else { return Some(format!("{target}: no such file")) };
    let text =
        if exists.is_file() { std::fs::read_to_string(exists).unwrap_or_default() } else { String::new() };
    let anchor = anchor.filter(|anchor| !anchors(&text).iter().any(|known| known == anchor))?;
    Some(format!("{target}: no heading {anchor}"))
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut wrong = Vec::new();
    for page in pages() {
        for target in targets(&std::fs::read_to_string(&page).unwrap()) {
            wrong.extend(broken(&page, &target).map(|reason| format!("{}: {reason}", page.display())));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn broken_links_are_found() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/START.md");
    let text = "[a](b.md) ![c](d.png)\n```\n[e](f)\n```\n# One `two`, three\n";
    assert_eq!(targets(text), ["b.md", "d.png"]);
    assert_eq!(anchors(text), ["one-two-three"]);
    for sound in ["SCAN.md", "#start", "../README.md#citing", "https://example.org/x", "images/"] {
        assert_eq!(broken(&page, sound), None);
    }
    for wrong in ["NONE.md", "#none", "SCAN.md#none", "images/none.png"] {
        assert!(broken(&page, wrong).is_some(), "{wrong}");
    }
}

#[test]
fn the_summary_lists_every_page_once() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut listed = targets(&std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap());
    listed.sort();
    let mut there: Vec<String> = pages()
        .iter()
        .filter_map(|page| Some(page.strip_prefix(&docs).ok()?.to_str()?.to_owned()))
        .filter(|name| name != "SUMMARY.md")
        .collect();
    there.sort();
    assert_eq!(listed, there);
}

#[test]
fn pictures_of_the_book_are_small_and_each_is_shown() {
    const MOST_BYTES: u64 = 6_500_000;
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let shown: Vec<String> =
        pages().iter().flat_map(|page| targets(&std::fs::read_to_string(page).unwrap())).collect();
    let mut sum = 0;
    for entry in std::fs::read_dir(docs.join("images")).unwrap() {
        let entry = entry.unwrap();
        let name = format!("images/{}", entry.file_name().to_str().unwrap());
        assert!(shown.iter().any(|target| target.ends_with(&name)), "no page shows docs/{name}");
        sum += entry.metadata().unwrap().len();
    }
    assert!(sum <= MOST_BYTES, "the pictures take {sum} bytes");
}

// The reference of commands is that of a program with a window.
#[cfg(feature = "viewer")]
mod commands {
    use std::path::{Path, PathBuf};
    use std::process::{Command, Output};
    use std::sync::Mutex;
    use std::thread;

    /// Runs the quick commands of all pages, or of those that are named.
    fn book(pages: &[&Path]) -> Output {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/book.sh");
        let program = env!("CARGO_BIN_EXE_diffract");
        Command::new("sh").arg(script).arg("--quick").args(pages).env("DIFFRACT", program).output().unwrap()
    }

    /// Returns the pages of the book that have quick commands.
    fn pages_with_commands() -> Vec<PathBuf> {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
        let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
        let mut pages = vec![docs.join("../README.md")];
        pages.extend(super::targets(&summary).iter().map(|target| docs.join(target)));
        pages.retain(|page| std::fs::read_to_string(page).unwrap().contains("\n```sh\n"));
        pages
    }

    #[test]
    fn quick_commands_of_the_book_run_and_print_what_it_says() {
        let pages = pages_with_commands();
        assert!(pages.len() > 7, "{pages:?}");
        // Two pages at a time: most of their commands use one core.
        let left = Mutex::new(pages.iter());
        let run = || {
            loop {
                let Some(page) = left.lock().unwrap().next() else { return };
                let output = book(&[page]);
                assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            }
        };
        thread::scope(|scope| [scope.spawn(run), scope.spawn(run)].map(|thread| thread.join().unwrap()));
    }

    #[test]
    fn a_command_that_fails_and_an_output_that_differs_are_found() {
        let page = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page.md");
        for (text, told) in [
            ("```sh\necho a\n```\n\n```text\na\n```\n", None),
            ("```sh\necho a; echo b; echo c\n```\n\n```text\na\n…\nc\n```\n", None),
            ("```sh,slow\nfalse\n```\n\n```text\na\n```\n\n```console\nfalse\n```\n", None),
            ("```sh,fetch\nfalse\n```\n", None),
            ("\n```sh\ndiffract no-such-command\n```\n", Some("line 2: a command of this block fails")),
            (
                "```sh\necho a; echo b\n```\n\n```text\na\n```\n",
                Some("line 5: the commands before print something else"),
            ),
            (
                "```sh\necho a; echo b\n```\n\n```text\n…\nc\n```\n",
                Some("line 5: the commands before print something else"),
            ),
        ] {
            std::fs::write(&page, text).unwrap();
            let output = book(&[&page]);
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.success(), told.is_none(), "{text}{stderr}");
            assert!(stderr.contains(told.unwrap_or_default()), "{text}{stderr}");
        }
    }
}
