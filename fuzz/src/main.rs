//! Fuzzes one of the program's readers: `READER=mesh cargo +nightly fuzz run read`.
#![no_main]

use diffract::internals::cli::untrusted::{UntrustedReader, readers};
use diffract::internals::error::ErrorKind;
use std::sync::LazyLock;

/// The reader that the environment variable `READER` names.
static READER: LazyLock<UntrustedReader> = LazyLock::new(|| {
    let name = std::env::var("READER").unwrap_or_default();
    let readers = readers();
    let names: Vec<_> = readers.iter().map(|reader| reader.name).collect();
    *readers
        .iter()
        .find(|reader| reader.name == name)
        .unwrap_or_else(|| panic!("READER is {name:?}; set it to one of {}", names.join(", ")))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = READER.read(bytes) {
        let line = error.to_string();
        assert!(!line.contains(['\n', '\r', '\u{1b}']) && line.contains("; "), "no line with a remedy: {line:?}");
        assert!(error.kind() != ErrorKind::Bug, "{line}");
    }
});
