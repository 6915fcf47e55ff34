//! What fuzzing once found, and what it started from, read again: success or an error, and never a panic.

use diffract::internals::cli::untrusted::readers;
use diffract::internals::random::Random;
use std::fs;
use std::path::Path;

#[test]
fn every_seed_and_every_former_finding_is_read_or_refused_in_a_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut read = 0;
    for reader in readers() {
        for folder in ["fuzz/seeds", "tests/regressions"] {
            let folder = root.join(folder).join(reader.name);
            let files = fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path());
            for file in files {
                let bytes = fs::read(&file).unwrap();
                if let Err(error) = reader.read(&bytes) {
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
    }
    assert!(read >= 2 * readers().len(), "only {read} files were read");
}

#[test]
fn every_folder_of_findings_belongs_to_a_reader_and_every_reader_has_seeds_that_it_takes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["fuzz/seeds", "tests/regressions"] {
        // Nothing was ever found where there is no folder of findings.
        for entry in fs::read_dir(root.join(folder)).into_iter().flatten() {
            let name = entry.unwrap().file_name();
            assert!(
                readers().iter().any(|reader| reader.name == name),
                "{folder}/{} is nobody's",
                name.display()
            );
        }
    }
    for reader in readers() {
        let seeds = fs::read_dir(root.join("fuzz/seeds").join(reader.name)).unwrap();
        let taken =
            seeds.filter(|seed| reader.read(&fs::read(seed.as_ref().unwrap().path()).unwrap()).is_ok());
        assert!(taken.count() > 0, "{} takes none of its seeds", reader.name);
    }
}

/// `bytes` with a few things done to them that a disk, a transfer or a stranger does.
fn damaged(bytes: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + (3.0 * random.share()) as usize {
        let place = (random.share() * bytes.len() as f64) as usize;
        let end = bytes.len().min(place + 1 + (8.0 * random.share()) as usize);
        match (6.0 * random.share()) as usize {
            0 if !bytes.is_empty() => bytes[place] ^= 1 << (8.0 * random.share()) as u32,
            1 if !bytes.is_empty() => {
                bytes[place] = [0, 1, 0x7f, 0x80, 0xff, b'-', b'9'][(7.0 * random.share()) as usize]
            }
            2 => bytes.truncate(place),
            3 => drop(bytes.drain(place..end)),
            4 => {
                let twice = bytes[place..end].to_vec();
                bytes.splice(place..place, twice);
            }
            _ => {
                let from = (random.share() * other.len() as f64) as usize;
                bytes.truncate(place);
                bytes.extend(&other[from..]);
            }
        }
    }
    bytes
}

#[test]
fn seeds_that_are_cut_at_every_hundredth_of_their_length_are_read_or_refused_in_a_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    for reader in readers() {
        for file in fs::read_dir(root.join(reader.name)).unwrap().map(|entry| entry.unwrap().path()) {
            let bytes = fs::read(&file).unwrap();
            for length in (0..bytes.len()).step_by((bytes.len() / 100).max(1)) {
                if let Err(error) = reader.read(&bytes[..length]) {
                    let line = error.to_string();
                    assert!(
                        line.contains("; ") && !line.contains(['\n', '\r', '\u{1b}']),
                        "{} cut at {length}: {line}",
                        file.display()
                    );
                }
            }
        }
    }
}

#[test]
fn seeds_that_are_damaged_at_random_are_read_or_refused_in_a_line() {
    const TRIES: usize = 400;
    // More of them by hand, as in DIFFRACT_TRIES=100000.
    let tries = std::env::var("DIFFRACT_TRIES").ok().and_then(|n| n.parse().ok()).unwrap_or(TRIES);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    let mut random = Random::new(0xda_3a6e);
    for reader in readers() {
        let files = fs::read_dir(root.join(reader.name)).unwrap().map(|entry| entry.unwrap().path());
        let mut seeds: Vec<_> = files.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
        seeds.sort();
        let mut refused = 0;
        for i in 0..tries {
            let (_, seed) = &seeds[i % seeds.len()];
            let (_, other) = &seeds[(random.share() * seeds.len() as f64) as usize];
            let bytes = damaged(seed, other, &mut random);
            if let Err(error) = reader.read(&bytes) {
                let line = error.to_string();
                assert!(
                    line.contains("; ") && !line.contains(['\n', '\r', '\u{1b}']),
                    "{}: {bytes:?}: {line}",
                    reader.name
                );
                refused += 1;
            }
        }
        assert!(refused > 0, "{} refuses nothing", reader.name);
    }
}
