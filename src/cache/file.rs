//! File of a cached result: magic, key, length of the header \[bytes, u64, little endian\], header (JSON), payload (raw numbers in this
//! machine's byte order), BLAKE3 of everything before it.

use super::key::{EntryFormat, Key};
use crate::error::{Error, Result};
use bytemuck::Pod;
use half::f16;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::io::{self, Read, Write};

/// First bytes of every file; the number changes with the layout of files.
const MAGIC: &[u8; 16] = b"diffract cache 1";
/// Size of a key and of a check sum \[bytes\].
const HASH: usize = blake3::OUT_LEN;
/// Size of the part in front of the header \[bytes\].
const PREAMBLE: usize = MAGIC.len() + HASH + size_of::<u64>();
/// Largest size of a header \[bytes\].
const LARGEST_HEADER: u64 = 1 << 20;
/// Largest size of a file without its payload \[bytes\].
pub(super) const LARGEST_OVERHEAD: u64 = PREAMBLE as u64 + LARGEST_HEADER + HASH as u64;
/// Size from which hashing by several threads pays off \[bytes\], by the documentation of `blake3`.
const MANY_BYTES: usize = 128 << 10;

/// Header of a file in front of the payload, after the key.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Envelope<H> {
    format: String,
    version: u32,
    /// Mark of the payload's byte order: a 1 in the byte order of the machine that wrote it.
    order: [u8; 2],
    payload_bytes: u64,
    header: H,
}

/// 1 as a 16-bit number in this machine's byte order.
const ORDER: [u8; 2] = 1u16.to_ne_bytes();

/// All bytes in front of the payload, and the size of the payload.
pub(super) struct Head {
    bytes: Vec<u8>,
    payload: u64,
}

impl Head {
    /// Returns the head of a file of `key` with `header` and `payload`.
    pub(super) fn new(
        format: &EntryFormat,
        key: &Key,
        header: &impl Serialize,
        payload: &[&[u8]],
    ) -> Result<Self> {
        let payload = payload.iter().map(|part| part.len() as u64).sum();
        let envelope = Envelope {
            format: format.name.to_owned(),
            version: format.version,
            order: ORDER,
            payload_bytes: payload,
            header,
        };
        let cannot = |what: String| Error::bug(what);
        let header = serde_json::to_vec(&envelope)
            .map_err(|e| cannot(format!("the header is no JSON ({e})")).caused_by(e))?;
        if header.len() as u64 > LARGEST_HEADER {
            return Err(cannot(format!("the header of {} is too long", format.name)));
        }
        let bytes = [MAGIC, key.as_bytes().as_slice(), &(header.len() as u64).to_le_bytes(), &header];
        Ok(Self { bytes: bytes.concat(), payload })
    }

    /// Returns the size of the whole file \[bytes\].
    pub(super) fn file_bytes(&self) -> u64 {
        self.bytes.len() as u64 + self.payload + HASH as u64
    }
}

/// Writes a whole file.
pub(super) fn write(file: &mut impl Write, head: &Head, payload: &[&[u8]]) -> io::Result<()> {
    let mut hasher = blake3::Hasher::new();
    for part in [head.bytes.as_slice()].iter().chain(payload) {
        update(&mut hasher, part);
        file.write_all(part)?;
    }
    file.write_all(hasher.finalize().as_bytes())?;
    file.flush()
}

/// Returns a file of `key` with any `header` and `payload`, and their correct check sum: a forged file by an attacker who knows the format.
pub fn seal(format: &EntryFormat, key: &Key, header: &serde_json::Value, payload: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    if let Ok(head) = Head::new(format, key, header, &[payload]) {
        let _ = write(&mut file, &head, &[payload]); // writing to memory does not fail
    }
    file
}

/// Reads the result in the next `size` bytes of `file`, made by `build`; see [`super::Store::load`].
pub fn read<H: DeserializeOwned, T>(
    file: &mut impl Read,
    size: u64,
    format: &EntryFormat,
    key: &Key,
    memory_limit: u64,
    build: impl FnOnce(H, &mut Payload<'_>) -> Option<T>,
) -> Option<T> {
    let mut preamble = [0u8; PREAMBLE];
    file.read_exact(&mut preamble).ok()?;
    let (magic, rest) = preamble.split_at(MAGIC.len());
    let (stored_key, length) = rest.split_at(HASH);
    if magic != MAGIC || stored_key != key.as_bytes() {
        return None;
    }
    let length = u64::from_le_bytes(length.try_into().ok()?);
    if length > LARGEST_HEADER {
        return None;
    }
    let payload_bytes = size.checked_sub(PREAMBLE as u64 + length + HASH as u64)?;
    if payload_bytes > memory_limit {
        return None;
    }
    let mut header = vec![0u8; usize::try_from(length).ok()?];
    file.read_exact(&mut header).ok()?;
    let envelope: Envelope<H> = serde_json::from_slice(&header).ok()?;
    let expected = (format.name, format.version, ORDER, payload_bytes);
    if (envelope.format.as_str(), envelope.version, envelope.order, envelope.payload_bytes) != expected {
        return None;
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update(&preamble);
    hasher.update(&header);
    let mut payload = Payload { file, left: payload_bytes, hasher };
    let built = build(envelope.header, &mut payload)?;
    let Payload { left, hasher, .. } = payload;
    let mut sum = [0u8; HASH];
    file.read_exact(&mut sum).ok()?;
    (left == 0 && hasher.finalize() == sum).then_some(built)
}

/// Payload of a file, read part by part in order.
pub struct Payload<'a> {
    file: &'a mut dyn Read,
    left: u64,
    hasher: blake3::Hasher,
}

impl Payload<'_> {
    /// Returns the number of bytes that are not read yet.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Reads the next `count` numbers; `None` if fewer are left or memory for them cannot be had. Takes no more memory than the file is
    /// long.
    pub fn take<T: Pod>(&mut self, count: usize) -> Option<Vec<T>> {
        let bytes = count.checked_mul(size_of::<T>()).and_then(|n| u64::try_from(n).ok())?;
        if bytes > self.left {
            return None;
        }
        let mut numbers = Vec::new();
        numbers.try_reserve_exact(count).ok()?;
        numbers.resize(count, T::zeroed());
        self.fill(&mut numbers)?;
        Some(numbers)
    }

    /// Reads the next `count` numbers of 16 bits; `None` in the cases of [`Payload::take`], and if one of the numbers is not finite.
    pub fn take_halves(&mut self, count: usize) -> Option<Vec<f16>> {
        self.take::<f16>(count).filter(|numbers| numbers.iter().all(|x| x.is_finite()))
    }

    /// Reads `numbers` from the next bytes; `None` if fewer are left.
    pub fn fill<T: Pod>(&mut self, numbers: &mut [T]) -> Option<()> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(numbers);
        self.left = self.left.checked_sub(bytes.len() as u64)?;
        self.file.read_exact(bytes).ok()?;
        update(&mut self.hasher, bytes);
        Some(())
    }
}

fn update(hasher: &mut blake3::Hasher, bytes: &[u8]) {
    if bytes.len() < MANY_BYTES {
        hasher.update(bytes);
    } else {
        hasher.update_rayon(bytes);
    }
}
