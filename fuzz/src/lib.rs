//! What the targets share.

use diffract::cli::untrusted::READERS;

/// Gives `bytes` to the reader called `name`.
pub fn read(name: &str, bytes: &[u8]) {
    let reader = READERS.iter().find(|reader| reader.name == name).expect("a reader of that name");
    if let Err(error) = (reader.read)(bytes) {
        let line = error.to_string();
        assert!(!line.contains(['\n', '\r', '\u{1b}']) && line.contains("; "), "no line with a remedy: {line:?}");
        assert!(matches!(error.exit_code(), 1 | 2));
    }
}
