//! Numbers and texts from bytes that may end too early.

use crate::error::{Error, Result};
use half::f16;

/// Byte order of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Least significant byte first (Intel).
    Little,
    /// Most significant byte first (Motorola).
    Big,
}

/// Type of a stored sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it: signed, unsigned, floating-point, with their bits")]
pub enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Number {
    /// Returns the size of one sample \[bytes\].
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Returns true for floating-point types.
    pub fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// Returns the largest number of an integer type; infinity for floating-point numbers.
    pub fn largest(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::I64 => i64::MAX as f64,
            Self::U64 => u64::MAX as f64,
            Self::F16 | Self::F32 | Self::F64 => f64::INFINITY,
        }
    }

    /// Decodes all numbers in `bytes`; an incomplete one at the end is ignored.
    pub fn decode(self, bytes: &[u8], order: Order) -> Vec<f64> {
        match self {
            Self::I8 => bytes.iter().map(|b| f64::from(*b as i8)).collect(),
            Self::U8 => bytes.iter().map(|b| f64::from(*b)).collect(),
            Self::I16 => each(bytes, order, |b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => each(bytes, order, |b| f64::from(u16::from_le_bytes(b))),
            Self::I32 => each(bytes, order, |b| f64::from(i32::from_le_bytes(b))),
            Self::U32 => each(bytes, order, |b| f64::from(u32::from_le_bytes(b))),
            Self::I64 => each(bytes, order, |b| i64::from_le_bytes(b) as f64),
            Self::U64 => each(bytes, order, |b| u64::from_le_bytes(b) as f64),
            Self::F16 => each(bytes, order, |b| f16::from_le_bytes(b).to_f64()),
            Self::F32 => each(bytes, order, |b| f64::from(f32::from_le_bytes(b))),
            Self::F64 => each(bytes, order, f64::from_le_bytes),
        }
    }
}

fn each<const N: usize>(bytes: &[u8], order: Order, read: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let number = |chunk: &[u8]| {
        let mut bytes = [0; N];
        bytes.copy_from_slice(chunk);
        if order == Order::Big {
            bytes.reverse();
        }
        read(bytes)
    };
    bytes.chunks_exact(N).map(number).collect()
}

/// Reader of one number or text after the other.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    place: usize,
    order: Order,
}

impl<'a> Cursor<'a> {
    /// Returns a reader that starts at the first of `bytes`.
    pub fn new(bytes: &'a [u8], order: Order) -> Self {
        Self { bytes, place: 0, order }
    }

    /// Returns a reader of the same bytes from `place` on.
    #[must_use]
    pub fn at(&self, place: usize) -> Self {
        Self { place, ..self.clone() }
    }

    /// Returns the number of bytes that were read or skipped.
    pub fn place(&self) -> usize {
        self.place
    }

    /// Returns the number of bytes that are left.
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.place)
    }

    /// Reads the next `count` bytes.
    ///
    /// # Errors
    /// Fewer are left.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let end = self.place.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.place..end)).ok_or_else(cut_short)?;
        self.place += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.order == Order::Big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// Reads a byte.
    pub fn u8(&mut self) -> Result<u8> {
        self.array().map(|[b]: [u8; 1]| b)
    }

    /// Reads two bytes, unsigned.
    pub fn u16(&mut self) -> Result<u16> {
        self.array().map(u16::from_le_bytes)
    }

    /// Reads two bytes, signed.
    pub fn i16(&mut self) -> Result<i16> {
        self.array().map(i16::from_le_bytes)
    }

    /// Reads four bytes, unsigned.
    pub fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// Reads four bytes, signed.
    pub fn i32(&mut self) -> Result<i32> {
        self.array().map(i32::from_le_bytes)
    }

    /// Reads a number of single precision.
    pub fn f32(&mut self) -> Result<f64> {
        self.array().map(f32::from_le_bytes).map(f64::from)
    }

    /// Reads a number of double precision.
    pub fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// Reads a text in a field of `width` bytes: up to the first NUL, without white space around it.
    pub fn text(&mut self, width: usize) -> Result<String> {
        Ok(text(self.take(width)?))
    }

    /// Reads a text in a field of `width` UTF-16 units, little-endian, up to the first zero.
    pub fn wide_text(&mut self, width: usize) -> Result<String> {
        let text = wide_text(self.take(width * 2)?, Order::Little);
        Ok(text.split('\0').next().unwrap_or_default().trim().to_owned())
    }
}

/// Returns the text in a field of fixed width: up to the first NUL, without white space around it; UTF-8 or Latin-1.
pub fn text(field: &[u8]) -> String {
    let end = field.iter().position(|b| *b == 0).unwrap_or(field.len());
    decode_text(&field[..end]).trim().to_owned()
}

/// Decodes bytes as UTF-8 if they are valid, otherwise as Latin-1, in which every byte is a character.
pub fn decode_text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        // No UTF-8: Latin-1.
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

/// Decodes UTF-16; an incomplete unit at the end is ignored.
pub fn wide_text(bytes: &[u8], order: Order) -> String {
    let units = Number::U16.decode(bytes, order);
    String::from_utf16_lossy(&units.into_iter().map(|unit| unit as u16).collect::<Vec<_>>())
}

/// Returns the error of a file that ends too early.
pub fn cut_short() -> Error {
    Error::input("is cut short", "save or copy the file again")
}

/// Returns the error of a file that contradicts itself or its format.
pub fn damaged(what: impl std::fmt::Display) -> Error {
    Error::input(format!("is damaged: {what}"), "save or copy the file again")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_either_byte_order_are_read() {
        assert_eq!(Number::I16.decode(&[0x01, 0x80, 0xff], Order::Little), [-32767.0]);
        assert_eq!(Number::I16.decode(&[0x80, 0x01], Order::Big), [-32767.0]);
        assert_eq!(Number::U32.decode(&[0, 0, 0, 0x80], Order::Little), [2_147_483_648.0]);
        assert_eq!(Number::F32.decode(&[0x3f, 0x80, 0, 0], Order::Big), [1.0]);
        assert_eq!(Number::F16.decode(&[0x00, 0x3c], Order::Little), [1.0]);
        assert_eq!(Number::I8.decode(&[0xff], Order::Big), [-1.0]);
    }

    #[test]
    fn a_cursor_stops_at_the_end_and_never_wraps() {
        let mut cursor = Cursor::new(&[1, 2, 3], Order::Big);
        assert_eq!(cursor.u16().unwrap(), 0x0102);
        assert!(cursor.u16().is_err() && cursor.take(usize::MAX).is_err());
        assert_eq!((cursor.u8().unwrap(), cursor.left()), (3, 0));
        assert!(cursor.at(usize::MAX).u8().is_err());
    }

    #[test]
    fn texts_end_at_nul_and_may_be_latin_1() {
        assert_eq!(text(b"  nm \0rest"), "nm");
        assert_eq!(text(b"\xb5m  "), "\u{b5}m");
        assert_eq!(text("\u{3bc}m".as_bytes()), "\u{3bc}m");
    }
}
