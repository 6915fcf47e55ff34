use super::*;
use crate::error::Remedy;
use serde::Deserialize;
use std::fs::{self, File};
use std::time::{Duration, SystemTime};

const FORMAT: EntryFormat = EntryFormat { name: "numbers", version: 3 };

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    count: usize,
    scale: f64,
}

type Numbers = (Header, Vec<u16>);

fn build(header: Header, payload: &mut Payload<'_>) -> Option<Numbers> {
    let numbers = payload.take(header.count)?;
    Some((header, numbers))
}

fn field(heights: Vec<f64>, columns: usize) -> crate::surface::HeightField {
    let rows = heights.len() / columns;
    crate::surface::HeightField::new(columns, rows, [0.1, 0.2], heights).unwrap()
}

struct Folder {
    outer: tempfile::TempDir,
    store: Store,
}

impl Folder {
    fn new(limit: u64) -> Self {
        let outer = tempfile::tempdir().unwrap();
        let store = Store::at(outer.path().join("cache"), limit);
        Self { outer, store }
    }

    fn save(&self, key: &Key, count: usize) -> Result<Numbers> {
        let numbers: Vec<u16> = (0..count).map(|i| (i * 31) as u16).collect();
        let header = Header { count, scale: 0.1 + 0.2 };
        self.store.save(&FORMAT, key, &header, &[bytemuck::cast_slice(&numbers)])?;
        Ok((header, numbers))
    }

    fn load(&self, key: &Key) -> Option<Numbers> {
        self.store.load(&FORMAT, key, 1 << 20, build)
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.store.path(&FORMAT, key)
    }

    fn set_time(&self, key: &Key, time: SystemTime) {
        let times = FileTimes::new().set_accessed(time);
        File::options().write(true).open(self.path(key)).unwrap().set_times(times).unwrap();
    }

    fn names(&self) -> usize {
        fs::read_dir(self.store.folder()).unwrap().count()
    }
}

#[test]
fn what_is_saved_is_loaded_exactly_and_nothing_else_is() {
    let folder = Folder::new(1 << 20);
    let key = Key::named("a");
    assert_eq!(folder.load(&key), None);
    let saved = folder.save(&key, 100_000).unwrap();
    assert_eq!(folder.load(&key), Some(saved));
    assert_eq!(folder.names(), 1);
    assert_eq!(folder.load(&Key::named("b")), None);
    let newer = EntryFormat { version: 4, ..FORMAT };
    assert_eq!(folder.store.load(&newer, &key, 1 << 20, build), None, "another version");
    let others = EntryFormat { name: "others", ..FORMAT };
    fs::copy(folder.path(&key), folder.store.path(&others, &key)).unwrap();
    assert_eq!(folder.store.load(&others, &key, 1 << 20, build), None, "another kind");
    fs::copy(folder.path(&key), folder.path(&Key::named("b"))).unwrap();
    assert_eq!(folder.load(&Key::named("b")), None, "the file of another key");
    assert_eq!(folder.store.load(&FORMAT, &key, 199_999, build), None, "more than the memory limit");
    assert!(folder.store.load(&FORMAT, &key, 200_000, build).is_some());
}

#[test]
fn any_changed_byte_and_any_other_length_makes_a_file_absent() {
    let folder = Folder::new(1 << 20);
    let key = Key::named("a");
    folder.save(&key, 50).unwrap();
    let whole = fs::read(folder.path(&key)).unwrap();
    for place in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[place] ^= 1;
        fs::write(folder.path(&key), &damaged).unwrap();
        assert_eq!(folder.load(&key), None, "byte {place}");
        fs::write(folder.path(&key), &whole[..place]).unwrap();
        assert_eq!(folder.load(&key), None, "cut to {place}");
    }
    fs::write(folder.path(&key), [&whole[..], &[0]].concat()).unwrap();
    assert_eq!(folder.load(&key), None, "a byte more");
    folder.save(&key, 50).unwrap();
    assert!(folder.load(&key).is_some());
}

#[test]
fn lengths_that_are_forged_with_a_right_check_sum_take_no_memory_and_no_file() {
    let key = Key::named("a");
    let payload = [7u8; 64];
    let found = |header: serde_json::Value| {
        let file = seal(&FORMAT, &key, &header, &payload);
        read(&mut file.as_slice(), file.len() as u64, &FORMAT, &key, 1 << 20, build)
    };
    let header = |count: u64| serde_json::json!({ "count": count, "scale": 1.5 });
    assert!(found(header(32)).is_some());
    // More than there is, a product that overflows, less than there is.
    for count in [33, 1 << 40, 1 << 63, u64::MAX, 31, 0] {
        assert!(found(header(count)).is_none(), "{count}");
    }
    for bad in [
        serde_json::json!({ "count": 32 }),
        serde_json::json!({ "count": -1, "scale": 1.5 }),
        serde_json::json!({ "count": 1e300, "scale": 1.5 }),
        serde_json::json!({ "count": 32, "scale": null }),
        serde_json::json!({ "count": 32, "scale": 1.5, "more": 1 }),
        serde_json::json!([]),
    ] {
        assert!(found(bad.clone()).is_none(), "{bad}");
    }
    // The length of the header itself, in front of it.
    let file = seal(&FORMAT, &key, &header(32), &payload);
    let at = 16 + blake3::OUT_LEN;
    for length in [0, 1, 1 << 19, 1 << 40, u64::MAX] {
        let mut forged = file[..file.len() - blake3::OUT_LEN].to_vec();
        forged[at..at + 8].copy_from_slice(&length.to_le_bytes());
        let sum = *blake3::hash(&forged).as_bytes();
        forged.extend(sum);
        let size = forged.len() as u64;
        let found = read(&mut forged.as_slice(), size, &FORMAT, &key, 1 << 20, build);
        assert!(found.is_none(), "{length}");
    }
    // A size that the file system reports and the file does not have.
    for size in [0, 10, file.len() as u64 - 1, file.len() as u64 + 1, u64::MAX] {
        assert!(read(&mut file.as_slice(), size, &FORMAT, &key, u64::MAX, build).is_none(), "{size}");
    }
}

#[test]
fn every_setting_its_name_the_heights_and_the_format_change_the_key() {
    #[derive(Serialize)]
    struct Settings {
        a: f64,
        b: Option<usize>,
    }
    #[derive(Serialize)]
    struct Renamed {
        a: f64,
        c: Option<usize>,
    }
    let heights = vec![0.0, 1.0, 2.0, 3.0];
    let settings = Settings { a: 0.1, b: None };
    let key = |settings: &Settings, heights: &[f64]| {
        Key::new(&FORMAT, settings, &field(heights.to_vec(), 2)).unwrap()
    };
    let first = key(&settings, &heights);
    assert_eq!(key(&settings, &heights), first);
    let more = [
        key(&Settings { a: 0.1 + f64::EPSILON / 8.0, b: None }, &heights),
        key(&Settings { b: Some(0), ..settings }, &heights),
        key(&settings, &[0.0, 1.0, 2.0, 3.0 + 1e-15]),
        key(&settings, &[-0.0, 1.0, 2.0, 3.0]),
        Key::new(&FORMAT, &settings, &field(heights.clone(), 4)).unwrap(),
        Key::new(&FORMAT, &settings, &field(heights.clone(), 1)).unwrap(),
        Key::new(&FORMAT, &Renamed { a: 0.1, c: None }, &field(heights.clone(), 2)).unwrap(),
        Key::new(&EntryFormat { version: 4, ..FORMAT }, &settings, &field(heights.clone(), 2)).unwrap(),
        Key::new(&EntryFormat { name: "others", ..FORMAT }, &settings, &field(heights.clone(), 2)).unwrap(),
    ];
    let wider = crate::surface::HeightField::new(2, 2, [0.1, 0.3], heights.clone()).unwrap();
    let wide = crate::surface::HeightField::new(2, 2, [0.3, 0.2], heights.clone()).unwrap();
    let spaced = [wider, wide].map(|field| Key::new(&FORMAT, &settings, &field).unwrap());
    let all: std::collections::HashSet<Key> = more.into_iter().chain(spaced).chain([first]).collect();
    assert_eq!(all.len(), 12);
}

#[test]
fn the_least_recently_used_files_go_first_and_loading_is_use() {
    let folder = Folder::new(3 * 2400);
    let keys = ["a", "b", "c", "d"].map(Key::named);
    for (age, key) in keys[..3].iter().enumerate() {
        folder.save(key, 1000).unwrap();
        folder.set_time(key, SystemTime::now() - Duration::from_secs(1000 - age as u64));
    }
    assert_eq!(folder.store.contents().unwrap().total().files, 3);
    assert!(folder.load(&keys[0]).is_some());
    folder.save(&keys[3], 1000).unwrap();
    let there = keys.map(|key| folder.path(&key).exists());
    assert_eq!(there, [true, false, true, true], "b was used least recently");
    assert!(folder.store.contents().unwrap().total().bytes <= 3 * 2400);
}

#[test]
fn the_limit_holds_after_every_save_and_a_file_that_is_saved_again_counts_once() {
    let folder = Folder::new(10_000);
    let key = Key::named("same");
    for count in [4000, 4500, 4000] {
        folder.save(&Key::named("other"), 100).unwrap();
        folder.save(&key, count).unwrap();
        assert!(folder.store.contents().unwrap().total().bytes <= 10_000);
    }
    assert_eq!(folder.names(), 2);
    for i in 0..40 {
        folder.save(&Key::named(&i.to_string()), 100 * (i % 13)).unwrap();
        assert!(folder.store.contents().unwrap().total().bytes <= 10_000, "{i}");
    }
    let refused = folder.save(&key, 5000).unwrap_err();
    assert_eq!(refused.remedies(), [Remedy::LargerCache], "{refused}");
    assert!(folder.store.contents().unwrap().total().files > 1, "nothing goes for what does not fit");
}

#[test]
fn a_clock_that_is_set_back_to_1970_or_was_ahead_neither_empties_nor_overfills_the_folder() {
    let folder = Folder::new(3 * 2400);
    let keys = ["a", "b", "c", "d"].map(Key::named);
    for key in &keys[..3] {
        folder.save(key, 1000).unwrap();
    }
    // b was written while the clock was ahead: it would stay for ever. c was written in 1970.
    folder.set_time(&keys[1], SystemTime::now() + Duration::from_secs(1 << 31));
    folder.set_time(&keys[2], SystemTime::UNIX_EPOCH + Duration::from_secs(10));
    folder.save(&keys[3], 1000).unwrap();
    assert!(folder.path(&keys[0]).exists() && !folder.path(&keys[1]).exists());
    assert_eq!(folder.store.contents().unwrap().total().files, 3);
    for time in [SystemTime::UNIX_EPOCH, SystemTime::now() + Duration::from_secs(1 << 31)] {
        let stale = folder.store.folder().join(".diffract-stale");
        File::create(&stale).unwrap().set_modified(time).unwrap();
        folder.save(&keys[3], 1000).unwrap();
        assert!(!stale.exists(), "a stale temporary file, whatever its time");
    }
}

#[test]
fn a_temporary_file_stays_while_its_writer_lives_however_old_it_looks() {
    let folder = Folder::new(1 << 20);
    folder.save(&Key::named("a"), 10).unwrap();
    let [held, young, others] = [".diffract-held", ".diffract-young", "mine"].map(|name| {
        let path = folder.store.folder().join(name);
        (File::create(&path).unwrap(), path)
    });
    for (file, _) in [&held, &others] {
        file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
    }
    held.0.lock().unwrap();
    folder.save(&Key::named("a"), 10).unwrap();
    assert!(held.1.exists() && young.1.exists() && others.1.exists());
    held.0.unlock().unwrap();
    folder.save(&Key::named("a"), 10).unwrap();
    assert!(!held.1.exists() && young.1.exists() && others.1.exists());
}

#[test]
fn clearing_takes_the_results_of_all_versions_and_nothing_else() {
    let folder = Folder::new(1 << 20);
    assert_eq!(folder.store.clear().unwrap(), Contents::default(), "no folder yet");
    for name in ["a", "b"] {
        folder.save(&Key::named(name), 10).unwrap();
    }
    let former = folder.store.folder().join(format!("{}.layers", "0a".repeat(32)));
    fs::write(&former, [1; 5]).unwrap();
    let strange =
        ["note.txt", &format!("{}.Layers", "0a".repeat(32)), &format!("{}.layers", "0A".repeat(32))]
            .map(|name| folder.store.folder().join(name));
    strange.iter().for_each(|path| fs::write(path, "mine").unwrap());
    let contents = folder.store.contents().unwrap();
    assert_eq!(contents.kinds["layers"], Usage { files: 1, bytes: 5 });
    assert_eq!(contents.kinds["numbers"].files, 2);
    assert_eq!(folder.store.clear().unwrap(), contents);
    assert!(strange.iter().all(|path| path.exists()) && folder.names() == strange.len());
}

#[cfg(unix)]
mod links {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_link_in_the_place_of_a_file_is_neither_read_nor_written_nor_emptied() {
        let folder = Folder::new(1 << 20);
        let key = Key::named("a");
        folder.save(&key, 10).unwrap();
        let victim = folder.outer.path().join("victim");
        fs::rename(folder.path(&key), &victim).unwrap();
        let before = fs::read(&victim).unwrap();
        for target in [victim.as_path(), Path::new("/nowhere/at/all"), folder.outer.path()] {
            let _ = fs::remove_file(folder.path(&key));
            symlink(target, folder.path(&key)).unwrap();
            assert_eq!(folder.load(&key), None, "{}", target.display());
            assert_eq!(folder.store.contents().unwrap().total().files, 0);
            folder.store.clear().unwrap();
            folder.save(&key, 20).unwrap();
            assert!(fs::symlink_metadata(folder.path(&key)).unwrap().is_file());
        }
        assert_eq!(fs::read(&victim).unwrap(), before);
        // A stale temporary file that is a link goes nowhere, either.
        symlink(&victim, folder.store.folder().join(".diffract-link")).unwrap();
        folder.save(&key, 10).unwrap();
        assert_eq!(fs::read(&victim).unwrap(), before);
    }

    #[test]
    fn a_folder_that_is_a_link_or_a_file_is_not_used() {
        let folder = Folder::new(1 << 20);
        let key = Key::named("a");
        let target = folder.outer.path().join("target");
        fs::create_dir(&target).unwrap();
        symlink(&target, folder.store.folder()).unwrap();
        let refused = folder.save(&key, 10).unwrap_err().to_string();
        assert!(
            refused.contains("links are not followed") && refused.contains("XDG_CACHE_HOME"),
            "{refused}"
        );
        assert!(folder.store.clear().is_err() && folder.store.contents().is_err());
        assert_eq!(folder.load(&key), None);
        assert_eq!(fs::read_dir(&target).unwrap().count(), 0);
        fs::remove_file(folder.store.folder()).unwrap();
        fs::write(folder.store.folder(), "a file").unwrap();
        assert!(folder.save(&key, 10).is_err());
    }

    #[test]
    fn the_folder_and_its_files_are_closed_to_others_also_where_the_folder_was_open() {
        let folder = Folder::new(1 << 20);
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        folder.save(&Key::named("a"), 10).unwrap();
        assert_eq!(mode(folder.store.folder()), 0o700);
        assert_eq!(mode(&folder.path(&Key::named("a"))), 0o600);
        fs::set_permissions(folder.store.folder(), fs::Permissions::from_mode(0o777)).unwrap();
        assert!(folder.load(&Key::named("a")).is_some());
        assert_eq!(mode(folder.store.folder()), 0o700);
    }

    #[test]
    fn a_pipe_in_the_place_of_a_file_does_not_stop_the_program() {
        let folder = Folder::new(1 << 20);
        let key = Key::named("a");
        folder.save(&key, 10).unwrap();
        fs::remove_file(folder.path(&key)).unwrap();
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, folder.path(&key), rustix::fs::FileType::Fifo, mode, 0).unwrap();
        assert_eq!(folder.load(&key), None);
        folder.save(&key, 10).unwrap();
        assert!(folder.load(&key).is_some());
    }
}

#[test]
fn writers_and_readers_at_once_see_whole_files_within_the_limit() {
    let folder = Folder::new(6000);
    std::thread::scope(|scope| {
        for writer in 0..4 {
            let folder = &folder;
            scope.spawn(move || {
                for round in 0..60 {
                    let count = 200 + 100 * ((writer + round) % 5);
                    let key = Key::named(&(round % 7).to_string());
                    // Another writer may have made room at the expense of this one's folder listing, never of its file.
                    folder.save(&key, count).unwrap();
                    if let Some((header, numbers)) = folder.load(&key) {
                        assert!(
                            numbers.len() == header.count
                                && numbers.iter().enumerate().all(|(i, n)| *n == (i * 31) as u16)
                        );
                    }
                }
            });
        }
    });
    folder.save(&Key::named("last"), 100).unwrap();
    assert!(folder.store.contents().unwrap().total().bytes <= 6000);
    assert!(
        fs::read_dir(folder.store.folder())
            .unwrap()
            .all(|f| { !f.unwrap().file_name().to_string_lossy().starts_with('.') })
    );
}
