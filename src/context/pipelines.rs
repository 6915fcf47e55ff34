//! Compiled pipelines in the cache on disk, so that a driver need not compile them again at the next start.

use crate::cache::{EntryFormat, Kept, Key, Payload, Store};
use crate::error::Result;
use crate::vk::device::Device;
use serde::{Deserialize, Serialize};

/// Largest size of the pipelines of a device \[bytes\]: a small part of the cache's default limit.
const LARGEST: u64 = 64 << 20;
/// Least ratio of the cache's limit to the size of the pipelines, so that a small cache still has room for colour tables.
const SHARE: u64 = 8;

/// Compiled pipelines of a device and its driver.
pub struct Pipelines {
    data: Vec<u8>,
}

/// Size of the data \[bytes\].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PipelinesHeader {
    bytes: usize,
}

impl Kept for Pipelines {
    const FORMAT: EntryFormat = EntryFormat { name: "pipelines", version: 1 };
    type Header = PipelinesHeader;

    fn header(&self) -> PipelinesHeader {
        PipelinesHeader { bytes: self.data.len() }
    }

    fn payload(&self) -> Vec<&[u8]> {
        vec![&self.data]
    }

    fn build(header: PipelinesHeader, payload: &mut Payload<'_>) -> Option<Self> {
        Some(Self { data: payload.take(header.bytes)? })
    }
}

/// Returns the key of the pipelines of this version of the program on `device`.
fn key(device: &Device) -> Result<Key> {
    let candidate = device.candidate();
    Key::of_settings(
        &Pipelines::FORMAT,
        &(&candidate.name, &candidate.driver, candidate.version, env!("CARGO_PKG_VERSION")),
    )
}

/// Adds the pipelines that `store` keeps for `device` to it. Without any, the driver compiles all of them.
pub(super) fn load(device: &Device, store: &Store) {
    let Ok(key) = key(device) else { return }; // without a key, nothing is kept
    if let Some(Pipelines { data }) = store.load_kept(&key, LARGEST) {
        let _ = device.add_pipelines(&data); // refused ones are compiled again
    }
}

/// Keeps the pipelines of `device` in `store`, if there are more than it has. Where they outgrow their room, none are
/// kept, and those of the next run come in their place. Failures are ignored: the next start compiles them again.
pub(super) fn save(device: &Device, store: &Store) {
    let (Ok(key), Ok(data)) = (key(device), device.pipeline_data()) else { return };
    if data.is_empty() {
        return;
    }
    let _ = keep(store, &key, data); // the next start compiles them again
}

/// Keeps `data` as the pipelines of `key`, as [`save`] describes.
fn keep(store: &Store, key: &Key, data: Vec<u8>) -> Result<()> {
    let room = LARGEST.min(store.limit() / SHARE);
    let known = store.load_kept::<Pipelines>(key, LARGEST).map_or(0, |kept| kept.data.len());
    if data.len() as u64 > room {
        return if known > 0 { store.save_kept(key, &Pipelines { data: Vec::new() }) } else { Ok(()) };
    }
    if data.len() > known { store.save_kept(key, &Pipelines { data }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pipelines_are_kept_whole_and_those_of_another_driver_are_not_found() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 1 << 20);
        let [key, other] =
            ["driver 1", "driver 2"].map(|driver| Key::of_settings(&Pipelines::FORMAT, &driver).unwrap());
        let data: Vec<u8> = (0..1000).map(|i| (i % 251) as u8).collect();
        store.save_kept(&key, &Pipelines { data: data.clone() }).unwrap();
        assert_eq!(store.load_kept::<Pipelines>(&key, LARGEST).unwrap().data, data);
        assert!(store.load_kept::<Pipelines>(&other, LARGEST).is_none());
        assert!(store.load_kept::<Pipelines>(&key, 999).is_none(), "more than the limit");
    }

    #[test]
    fn pipelines_that_outgrow_their_room_make_place_for_those_of_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 80_000);
        let key = Key::of_settings(&Pipelines::FORMAT, &"driver").unwrap();
        let kept = || store.load_kept::<Pipelines>(&key, LARGEST).map(|kept| kept.data.len());
        for (bytes, expected) in [
            (20_000, None), // never kept
            (9_000, Some(9_000)),
            (8_000, Some(9_000)), // fewer than are kept
            (10_000, Some(10_000)),
            (10_001, Some(0)),
            (500, Some(500)),
        ] {
            keep(&store, &key, vec![1; bytes]).unwrap();
            assert_eq!(kept(), expected, "{bytes}");
        }
    }
}
