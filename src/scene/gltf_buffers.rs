//! Data of glTF files: buffers within the file or beside it, and the numbers that accessors read from them. Every place is checked: the description may lie.

use super::loaded_mesh::{self, MAX_BYTES};
use crate::error::{Error, Result};
use crate::memory;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::DataType;
use gltf::buffer::Source;
use gltf::{Accessor, Document};
use std::path::{Component, Path};

/// Largest number of buffers; files have one, or a few.
const MAX_BUFFERS: usize = 1 << 10;
/// Largest name of a file in an error \[characters\].
const SHOWN: usize = 60;

/// Contents of all buffers of a file.
#[derive(Debug)]
pub(super) struct GltfBuffers {
    buffers: Vec<Vec<u8>>,
}

impl GltfBuffers {
    /// Reads the buffers of `document`, of which `blob` is the one in a binary file, and others are files in `folder` or below it.
    ///
    /// # Errors
    /// Fails for a buffer that is missing, short, in another folder, or of a scheme that is not read, and for more than [`MAX_BYTES`] in all.
    pub fn read(document: &Document, mut blob: Option<Vec<u8>>, folder: &Path) -> Result<Self> {
        let mut buffers = Vec::new();
        let mut total = 0u64;
        for buffer in document.buffers() {
            let at = |e: Error| e.at(format!("buffer {}", buffer.index()));
            total = total.saturating_add(buffer.length() as u64);
            if total > MAX_BYTES || buffers.len() == MAX_BUFFERS {
                let what =
                    format!("the buffers have more than {MAX_BYTES} bytes, or are more than {MAX_BUFFERS}");
                return Err(at(Error::input(what, "simplify the mesh first")));
            }
            let bytes = match buffer.source() {
                Source::Bin => blob.take().unwrap_or_default(), // its length is checked below
                Source::Uri(uri) => from_uri(uri, folder).map_err(at)?,
            };
            if bytes.len() < buffer.length() {
                let what = format!("it has {} bytes where {} belong", bytes.len(), buffer.length());
                return Err(at(Error::input(what, "the file may be cut short; export it again")));
            }
            buffers.push(bytes);
        }
        Ok(Self { buffers })
    }

    /// Reads vectors of `N` numbers: floats, or bytes and words as numbers from 0 to 1.
    pub fn floats<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>> {
        if accessor.dimensions().multiplicity() != N {
            return Err(unread(accessor, &format!("has not {N} numbers a vertex")));
        }
        let number: fn(&[u8]) -> f32 = match (accessor.data_type(), accessor.normalized()) {
            (DataType::F32, _) => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            (DataType::U8, true) => |b| f32::from(b[0]) / f32::from(u8::MAX),
            (DataType::U16, true) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / f32::from(u16::MAX),
            _ => return Err(unread(accessor, "has numbers of another kind than floats")),
        };
        let size = accessor.size() / N;
        let vector = |item: &[u8]| std::array::from_fn(|i| number(&item[i * size..]));
        self.items(accessor, vector)
    }

    /// Reads the numbers of vertices.
    pub fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>> {
        let number: fn(&[u8]) -> u32 = match (accessor.data_type(), accessor.dimensions().multiplicity()) {
            (DataType::U8, 1) => |b| u32::from(b[0]),
            (DataType::U16, 1) => |b| u32::from(u16::from_le_bytes([b[0], b[1]])),
            (DataType::U32, 1) => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => return Err(unread(accessor, "has no indices")),
        };
        self.items(accessor, number)
    }

    /// Reads all items of `accessor`, each of them from its bytes.
    fn items<T>(&self, accessor: &Accessor<'_>, read: impl Fn(&[u8]) -> T) -> Result<Vec<T>> {
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(unread(accessor, "is sparse, or without data"));
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size).max(size);
        let buffer = self.buffers.get(view.buffer().index()).map_or(&[][..], Vec::as_slice);
        let end = view.offset().checked_add(view.length());
        let bytes =
            end.and_then(|end| buffer.get(view.offset()..end)).and_then(|b| b.get(accessor.offset()..));
        // The last item need not be followed by the rest of its stride.
        let needed = accessor.count().checked_sub(1).and_then(|n| n.checked_mul(stride)?.checked_add(size));
        let bytes = bytes.zip(needed).and_then(|(bytes, needed)| bytes.get(..needed));
        let Some(bytes) = bytes else {
            return Err(unread(accessor, "reaches beyond its buffer"));
        };
        memory::ensure_room(
            (accessor.count() as u64).saturating_mul(size_of::<T>() as u64),
            "the vertices of the mesh",
        )?;
        Ok(bytes.chunks(stride).map(|item| read(&item[..size])).collect())
    }
}

fn unread(accessor: &Accessor<'_>, what: &str) -> Error {
    Error::input(
        format!("accessor {} {what}", accessor.index()),
        "export the mesh again, as plain floats without compression",
    )
}

/// Returns the bytes of a `uri`: data in it, or a file in `folder` or below it.
fn from_uri(uri: &str, folder: &Path) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let decoded = encoded.and_then(|encoded| STANDARD.decode(encoded).ok()); // told as damaged below
        return decoded.ok_or_else(|| {
            Error::input("its data are no base64", "the file may be cut short; export it again")
        });
    }
    let name = percent_decoded(uri);
    let shown: String = name.chars().take(SHOWN).collect();
    let path = Path::new(&name);
    // Nobody has named the file but the mesh.
    let is_below = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !is_below || uri.contains("://") {
        return Err(Error::input(
            format!("it is `{shown}`, which does not lie beside the file"),
            "export the mesh as .glb, which holds all data",
        ));
    }
    loaded_mesh::read(&folder.join(path))
}

/// Replaces `%20` and the like by the bytes that they stand for.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        let code = tail.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        let code = code.and_then(|hex| u8::from_str_radix(hex, 16).ok()); // a lone % stands for itself
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_buffers_are_decoded_and_stay_in_the_folder() {
        assert_eq!(percent_decoded("a%20b%C3%A4.bin%"), "a bä.bin%");
        assert_eq!(from_uri("data:application/octet-stream;base64,AAEC", Path::new("")).unwrap(), [0, 1, 2]);
        for wrong in [
            "data:;base64,!",
            "data:AAEC",
            "/etc/passwd",
            "../a.bin",
            "%2e%2e/a.bin",
            "http://a/b.bin",
            "no.bin",
        ] {
            let e = from_uri(wrong, Path::new("")).unwrap_err().to_string();
            assert!(e.contains("; "), "{wrong}: {e}");
        }
    }
}
