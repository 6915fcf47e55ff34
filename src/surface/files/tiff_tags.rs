//! Directories of a TIFF with private tags, which decoders of pictures leave alone.

use super::bytes::{Cursor, Order, cut_short, text};
use crate::error::Result;

/// Largest number of directories that are read; scans have a few dozen channels.
const MOST_DIRECTORIES: usize = 200;

/// Largest number of entries of a directory that are read; those of scans have up to two hundred.
const MOST_ENTRIES: usize = 1000;

/// Bytes of a value that stands in its entry.
const INLINE: usize = 4;

/// Bytes of an entry.
const ENTRY: usize = 12;

/// Directory of a classic TIFF: the tags of one image.
#[derive(Clone, Debug)]
pub struct TiffDirectory<'a> {
    bytes: &'a [u8],
    order: Order,
    /// Places of the entries in the file.
    entries: std::ops::Range<usize>,
}

impl<'a> TiffDirectory<'a> {
    /// Returns the directories of the file in `bytes`; none if it is no classic TIFF.
    pub fn all(bytes: &'a [u8]) -> Vec<Self> {
        let order = match bytes.get(..4) {
            Some(b"II*\0") => Order::Little,
            Some(b"MM\0*") => Order::Big,
            _ => return Vec::new(),
        };
        let mut found: Vec<Self> = Vec::new();
        let mut next = Cursor::new(bytes, order).at(4).u32().ok();
        while let Some(place) = next.map(|place| place as usize).filter(|place| *place > 0) {
            let Ok(count) = Cursor::new(bytes, order).at(place).u16() else { break }; // beyond the end
            let (first, count) = (place + 2, usize::from(count));
            let entries = first..first + count.min(MOST_ENTRIES) * ENTRY;
            // A directory that names an earlier one would go on for ever.
            if found.len() == MOST_DIRECTORIES || found.iter().any(|other| other.entries == entries) {
                break;
            }
            next = Cursor::new(bytes, order).at(first + count * ENTRY).u32().ok();
            found.push(Self { bytes, order, entries });
        }
        found
    }

    /// Returns type, count and place of the value of `tag`.
    fn entry(&self, tag: u16) -> Option<(u16, usize, usize)> {
        self.entries.clone().step_by(ENTRY).find_map(|place| {
            let mut cursor = Cursor::new(self.bytes, self.order).at(place);
            (cursor.u16().ok()? == tag).then_some(())?;
            Some((cursor.u16().ok()?, cursor.u32().ok()? as usize, place + ENTRY - INLINE))
        })
    }

    /// Returns the type of `tag` and the bytes of its value; `None` if there is no such tag.
    fn typed(&self, tag: u16) -> Option<(u16, Result<&'a [u8]>)> {
        let (kind, count, place) = self.entry(tag)?;
        let width = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 => 4,
            _ => 8,
        };
        let length = count.saturating_mul(width);
        let mut cursor = Cursor::new(self.bytes, self.order).at(place);
        let place = if length > INLINE { cursor.u32().ok()? as usize } else { place };
        Some((kind, cursor.at(place).take(length).map_err(|_| cut_short())))
    }

    /// Returns the bytes of `tag`; `None` if there is no such tag.
    ///
    /// # Errors
    /// The value lies beyond the end of the file.
    pub fn value(&self, tag: u16) -> Option<Result<&'a [u8]>> {
        self.typed(tag).map(|(_, value)| value)
    }

    /// Returns the number of `tag`, of any type; `None` if there is none.
    pub fn number(&self, tag: u16) -> Option<f64> {
        let (kind, value) = self.typed(tag)?;
        let mut cursor = Cursor::new(value.ok()?, self.order);
        let number = match kind {
            1 | 7 => cursor.u8().map(f64::from),
            3 => cursor.u16().map(f64::from),
            4 => cursor.u32().map(f64::from),
            8 => cursor.i16().map(f64::from),
            9 => cursor.i32().map(f64::from),
            11 => cursor.f32(),
            12 => cursor.f64(),
            _ => return None,
        };
        number.ok()
    }

    /// Returns the text of `tag`; `None` if there is none.
    pub fn text(&self, tag: u16) -> Option<String> {
        self.value(tag)?.ok().map(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_in_their_entries_or_apart_and_rings_of_directories_end() {
        let mut bytes = b"MM\0*\0\0\0\x08\0\x03".to_vec();
        bytes.extend([0x80, 1, 0, 8, 0, 0, 0, 1, 0xff, 0xfe, 0, 0]);
        bytes.extend([0x80, 2, 0, 2, 0, 0, 0, 6, 0, 0, 0, 50]);
        bytes.extend([0x80, 3, 0, 12, 0, 0, 0, 1, 0, 0, 1, 0]);
        bytes.extend([0, 0, 0, 8]);
        bytes.extend(b"metre\0");
        let all = TiffDirectory::all(&bytes);
        assert_eq!(all.len(), 1, "the next directory is the first again");
        assert_eq!((all[0].number(0x8001), all[0].text(0x8002).as_deref()), (Some(-2.0), Some("metre")));
        assert!(all[0].value(0x8003).unwrap().is_err() && all[0].value(0x8004).is_none());
        assert!(
            TiffDirectory::all(b"MM\0*").is_empty()
                && TiffDirectory::all(b"MM\0*\xff\xff\xff\xff").is_empty()
        );
    }
}
