//! What fuzzing once found, and what it started from, read again: success or an error, and never a panic.

use diffract::cli::untrusted::READERS;
use std::fs;
use std::path::Path;

#[test]
fn every_seed_and_every_former_finding_is_read_or_refused_in_a_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut read = 0;
    for reader in READERS {
        for folder in ["fuzz/seeds", "tests/regressions"] {
            let folder = root.join(folder).join(reader.name);
            let files = fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path());
            for file in files {
                let bytes = fs::read(&file).unwrap();
                if let Err(error) = (reader.read)(&bytes) {
                    let line = error.to_string();
                    assert!(
                        line.contains("; ") && !line.contains(['\n', '\u{1b}']),
                        "{}: {line}",
                        file.display()
                    );
                }
                read += 1;
            }
        }
        assert!(
            root.join("fuzz/fuzz_targets").join(reader.name).with_extension("rs").is_file(),
            "{}",
            reader.name
        );
    }
    assert!(read >= 2 * READERS.len(), "only {read} files were read");
}

#[test]
fn every_folder_of_findings_belongs_to_a_reader_and_every_reader_has_seeds_that_it_takes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["fuzz/seeds", "tests/regressions"] {
        // Nothing was ever found where there is no folder of findings.
        for entry in fs::read_dir(root.join(folder)).into_iter().flatten() {
            let name = entry.unwrap().file_name();
            assert!(
                READERS.iter().any(|reader| reader.name == name),
                "{folder}/{} is nobody's",
                name.display()
            );
        }
    }
    for reader in READERS {
        let seeds = fs::read_dir(root.join("fuzz/seeds").join(reader.name)).unwrap();
        let taken =
            seeds.filter(|seed| (reader.read)(&fs::read(seed.as_ref().unwrap().path()).unwrap()).is_ok());
        assert!(taken.count() > 0, "{} takes none of its seeds", reader.name);
    }
}
