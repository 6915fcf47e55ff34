//! Contents of a microscope file, before a channel is chosen or scaled.

use super::super::MAX_SIDE;
use super::bytes::{Number, Order, cut_short, damaged};
use super::units;
use crate::error::{Error, Result};
use crate::memory;
use crate::notes::PreparationRecord;
use std::borrow::Cow;

/// Quantity of a channel's samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Heights \[m\].
    Height,
    /// Shares of the largest code of an integer without a scale, 0 … 1 (−1 … 1 for signed codes).
    Code {
        /// The largest code.
        largest: f64,
    },
    /// Another quantity, in the unit of the channel.
    Other,
}

/// Function that returns the samples row by row from the top; samples that are not finite were not measured.
pub type Decode<'a> = Box<dyn FnOnce() -> Result<Vec<f64>> + 'a>;

/// One image of a file. Samples are decoded on demand.
pub struct Channel<'a> {
    /// Name as in the file.
    pub name: String,
    /// Unit of the samples as in the file; empty for none.
    pub unit: String,
    /// Samples along `x` and `y`.
    pub size: [usize; 2],
    /// Distance of neighbouring samples along `x` and `y` \[m\]; `None` if the file does not say.
    pub spacing: [Option<f64>; 2],
    /// Quantity of the samples.
    pub quantity: Quantity,
    /// Steps that made these samples of the measured ones, as the file notes them.
    pub prepared: PreparationRecord,
    /// The samples.
    pub decode: Decode<'a>,
}

impl<'a> Channel<'a> {
    /// Returns an image of `size` whose samples are those of `block` in `unit`: heights if that is a length.
    ///
    /// # Errors
    /// Fewer bytes than `size` needs; a scale that is no number.
    pub fn stored(
        name: impl Into<String>,
        unit: &str,
        size: [usize; 2],
        spacing: [Option<f64>; 2],
        mut block: Block<'a>,
    ) -> Result<Self> {
        if block.scale.iter().any(|x| !x.is_finite()) {
            return Err(damaged("its scale of heights is no number"));
        }
        let metres = units::length(unit);
        block.scale = block.scale.map(|x| x * metres.unwrap_or(1.0));
        Ok(Self {
            name: name.into(),
            unit: unit.to_owned(),
            size,
            spacing,
            quantity: if metres.is_some() { Quantity::Height } else { Quantity::Other },
            prepared: PreparationRecord::default(),
            decode: block.decode(size)?,
        })
    }

    /// Returns the same image with samples that `change` makes of the stored ones.
    #[must_use]
    pub fn changed(self, change: impl FnOnce(Vec<f64>) -> Vec<f64> + 'a) -> Self {
        let decode = self.decode;
        Self { decode: Box::new(move || Ok(change(decode()?))), ..self }
    }

    /// Decodes the samples: `size[0]` × `size[1]` of them, row by row from the top; NaN for those that were not measured.
    ///
    /// # Errors
    /// No room for them; damage that shows only now.
    pub fn samples(self) -> Result<Vec<f64>> {
        let [columns, rows] = self.size;
        let count = columns * rows; // sides are at most MAX_SIDE
        memory::ensure_room(count as u64 * 8, &format!("a scan of {columns} x {rows} samples"))?;
        let mut samples = (self.decode)()?;
        if samples.len() != count {
            return Err(cut_short());
        }
        samples.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = f64::NAN);
        Ok(samples)
    }
}

/// All channels of a file.
pub struct Scan<'a> {
    /// The format, for people.
    pub format: &'static str,
    /// At least one.
    pub channels: Vec<Channel<'a>>,
    /// Facts that a user should know about the file, one line each.
    pub notes: Vec<String>,
    /// True if a user has to choose the channel.
    pub asks: bool,
}

impl<'a> Scan<'a> {
    /// Returns a file that holds a single image.
    pub fn single(format: &'static str, channel: Channel<'a>) -> Self {
        Self::new(format, vec![channel])
    }

    /// Returns a file that holds `channels`.
    pub fn new(format: &'static str, channels: Vec<Channel<'a>>) -> Self {
        Self { format, channels, notes: Vec::new(), asks: false }
    }

    /// Numbers channels that have the name of an earlier one, as in `Height (2)`, so that each can be chosen by its name.
    pub fn number_equal_names(&mut self) {
        let mut met = std::collections::HashMap::new();
        for channel in &mut self.channels {
            let count: &mut usize = met.entry(channel.name.clone()).or_default();
            *count += 1;
            if *count > 1 {
                channel.name = format!("{} ({count})", channel.name);
            }
        }
    }

    /// Returns a file of the channels that can be read, each with its name. Errors of the others become notes.
    ///
    /// # Errors
    /// The first channel's error if none can be read; no channel at all.
    pub fn of_readable(format: &'static str, found: Vec<(String, Result<Channel<'a>>)>) -> Result<Self> {
        let mut scan = Self::new(format, Vec::new());
        let mut first = None;
        for (name, channel) in found {
            match channel {
                Ok(channel) => scan.channels.push(channel),
                Err(error) => {
                    scan.notes.push(format!("the channel `{name}` cannot be read and is left out: {error}"));
                    first.get_or_insert(error);
                }
            }
        }
        match first {
            Some(error) if scan.channels.is_empty() => Err(error),
            None if scan.channels.is_empty() => {
                Err(Error::input("holds no image", "choose a file with an image in it"))
            }
            _ => Ok(scan),
        }
    }
}

/// Checks that a height field can have the size.
///
/// # Errors
/// An empty or oversized grid.
pub fn size(columns: u64, rows: u64) -> Result<[usize; 2]> {
    if columns == 0 || rows == 0 {
        return Err(Error::input(
            format!("the scan is empty ({columns} x {rows})"),
            "choose a file with at least one sample",
        ));
    }
    match (usize::try_from(columns), usize::try_from(rows)) {
        (Ok(columns), Ok(rows)) if columns <= MAX_SIDE && rows <= MAX_SIDE => Ok([columns, rows]),
        _ => Err(Error::input(
            format!("{columns} x {rows} samples are more than {MAX_SIDE} on a side"),
            "crop it or average it down",
        )),
    }
}

/// Returns the distance between samples \[m\] of `length` over `count` samples; `None` if that is no distance. Its sign does not matter.
pub fn spacing(length: f64, count: usize) -> Option<f64> {
    Some((length / count as f64).abs()).filter(|d| d.is_finite() && *d > 0.0)
}

/// Row of a block that is the top of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// The first.
    TopFirst,
    /// The last.
    BottomFirst,
}

/// Samples as stored in a file.
#[derive(Clone, Debug)]
pub struct Block<'a> {
    /// The samples' bytes, x fastest.
    pub bytes: Cow<'a, [u8]>,
    /// Type of a stored sample.
    pub number: Number,
    /// Byte order of the samples.
    pub order: Order,
    /// Size of one unit of the stored number, and value of a stored 0.
    pub scale: [f64; 2],
    /// Stored number of a sample that was not measured.
    pub missing: Option<f64>,
    /// Least stored number of samples that were not measured.
    pub missing_from: Option<f64>,
    /// Row that is the top.
    pub rows: Rows,
    /// True if the first sample of a row is its right end.
    pub mirrored: bool,
}

impl<'a> Block<'a> {
    /// Returns a block whose numbers are the samples themselves.
    pub fn plain(bytes: &'a [u8], number: Number, order: Order) -> Self {
        Self {
            bytes: bytes.into(),
            number,
            order,
            scale: [1.0, 0.0],
            missing: None,
            missing_from: None,
            rows: Rows::TopFirst,
            mirrored: false,
        }
    }

    /// Returns the function that decodes the samples of an image of `size`.
    ///
    /// # Errors
    /// Fewer bytes than `size` needs.
    pub fn decode(self, size: [usize; 2]) -> Result<Decode<'a>> {
        let needed = size[0] * size[1] * self.number.bytes();
        if self.bytes.len() < needed {
            return Err(cut_short());
        }
        Ok(Box::new(move || {
            let mut samples = self.number.decode(&self.bytes[..needed], self.order);
            let [factor, zero] = self.scale;
            for sample in &mut samples {
                let missing =
                    self.missing == Some(*sample) || self.missing_from.is_some_and(|least| *sample >= least);
                *sample = if missing { f64::NAN } else { *sample * factor + zero };
            }
            if self.rows == Rows::BottomFirst {
                flip(&mut samples, size[0]);
            }
            if self.mirrored {
                samples.chunks_exact_mut(size[0]).for_each(<[f64]>::reverse);
            }
            Ok(samples)
        }))
    }
}

/// Turns rows of `columns` samples upside down.
pub fn flip(samples: &mut [f64], columns: usize) {
    let rows = samples.len() / columns;
    for row in 0..rows / 2 {
        let (upper, lower) = samples.split_at_mut((rows - 1 - row) * columns);
        upper[row * columns..(row + 1) * columns].swap_with_slice(&mut lower[..columns]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flipping_turns_rows_and_not_columns() {
        let mut samples = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        flip(&mut samples, 2);
        assert_eq!(samples, [5.0, 6.0, 3.0, 4.0, 1.0, 2.0]);
    }

    #[test]
    fn a_block_is_scaled_and_what_was_not_measured_is_nan() {
        let block = Block {
            scale: [0.5, 1.0],
            missing: Some(-1.0),
            rows: Rows::BottomFirst,
            ..Block::plain(&[2, 0xff, 4, 6], Number::I8, Order::Little)
        };
        let samples = block.clone().decode([2, 2]).unwrap()().unwrap();
        assert_eq!(samples[..3], [3.0, 4.0, 2.0]);
        assert!(samples[3].is_nan());
        assert!(block.decode([2, 3]).is_err(), "there are only four bytes");
    }

    #[test]
    fn sizes_that_no_height_field_has_are_refused() {
        assert_eq!(size(3, 2).unwrap(), [3, 2]);
        assert!(size(0, 2).is_err() && size(2, 16_385).is_err() && size(u64::MAX, 1).is_err());
        assert_eq!(spacing(-6.0, 3), Some(2.0));
        assert_eq!((spacing(0.0, 3), spacing(f64::NAN, 3), spacing(f64::INFINITY, 1)), (None, None, None));
    }
}
