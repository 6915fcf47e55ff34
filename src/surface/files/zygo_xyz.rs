//! Height maps of Zygo's programs as text (.xyz): a head of 13 lines, then a line for each pixel between two lines of `#`.
//!
//! A line has the column, the row from the top, and the height in micrometres or `No Data`. The fourth line has the origin and the size of the
//! map, the eighth the distance of samples in metres. Source: Zygo, *MetroPro Reference Guide*, OMP-0347.

use super::bytes::{cut_short, damaged};
use super::format::Format;
use super::scan::{Channel, Quantity, Scan, size, spacing};
use super::table;
use crate::error::{Error, Result};
use crate::memory;
use crate::notes::PreparationRecord;

/// The format.
pub const FORMAT: Format = Format {
    name: "zygo_xyz",
    title: "Zygo text",
    extensions: &["xyz"],
    signature: |b| b.starts_with(b"Zygo XYZ Data File"),
    is_by_name: false,
    read,
    facts: ["yes, if the instrument was calibrated", "micrometres", "`No Data`", "format 1"],
};

/// Metres of a micrometre.
const MICROMETRE: f64 = 1e-6;

/// Reads the file in `bytes`.
///
/// # Errors
/// Another format than 1; a head without sizes; pixels outside of the map, or too few of them.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let text = table::decoded(bytes);
    let mut lines = text.lines();
    let head: Vec<&str> = lines.by_ref().take_while(|line| line.trim() != "#").collect();
    if !head.first().is_some_and(|line| line.trim_end().ends_with("Format 1")) {
        return Err(Error::input(
            "is of another format than 1",
            "export it from Zygo's program as XYZ, format 1",
        ));
    }
    let words = |line: usize| head.get(line).copied().unwrap_or_default().split_whitespace(); // no words: an error below
    let map: Vec<u64> = words(3).map_while(|word| word.parse().ok()).collect();
    let [left, top, columns, rows] = map[..] else {
        return Err(damaged("its fourth line has no size of the map"));
    };
    let size = size(columns, rows)?;
    let pixel = words(7).nth(6).and_then(|word| spacing(word.parse().ok()?, 1));
    let count = size[0] * size[1];
    // A pixel takes six characters at least, so that short texts promise no large arrays.
    if text.len() < 6 * count {
        return Err(cut_short());
    }
    memory::ensure_room(count as u64 * 8, &format!("a scan of {columns} x {rows} samples"))?;
    let mut samples = vec![f64::NAN; count];
    let mut has_end = false;
    for line in lines {
        if line.trim() == "#" {
            has_end = true;
            break;
        }
        let mut words = line.split_whitespace();
        let mut place = |first: u64, n: usize| {
            let place = words.next()?.parse::<u64>().ok()?.checked_sub(first)?;
            usize::try_from(place).ok().filter(|place| *place < n)
        };
        let (column, row) = (place(left, size[0]), place(top, size[1]));
        let (Some(column), Some(row)) = (column, row) else {
            return Err(damaged(format!(
                "`{}` is no pixel of the map",
                line.chars().take(40).collect::<String>()
            )));
        };
        // `No Data` is no number.
        samples[row * size[0] + column] =
            words.next().and_then(|word| word.parse().ok()).unwrap_or(f64::NAN) * MICROMETRE;
    }
    if !has_end {
        return Err(cut_short());
    }
    Ok(Scan::single(
        FORMAT.title,
        Channel {
            name: "Phase".to_owned(),
            unit: "um".to_owned(),
            size,
            spacing: [pixel; 2],
            quantity: Quantity::Height,
            prepared: PreparationRecord::default(),
            decode: Box::new(move || Ok(samples)),
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        assert_close, assert_robust, assert_rows, assert_seed, assert_survives, heights, whole,
    };
    use super::*;

    #[test]
    fn pixels_are_micrometres_and_no_data_is_a_gap() {
        let text = "Zygo XYZ Data File - Format 1\n1 8 1 0 \"Mon\"\n0 0 0 0 0 0\n10 20 3 2\n\n\n\n0 0.5 6.328e-07 0 1 1 1e-06 0\n3 2 0 0 0 0 0 \"\"\n\
                    0\n0\n0 \"\"\n1 0\n#\n10 20 1\n11 20 2\n12 20 3\n10 21 4\n11 21 5\n12 21 6\n#";
        let (samples, spacing) = heights(super::super::recognise(text.as_bytes(), "xyz"));
        assert_rows(&samples, 1e-6);
        assert_close(spacing, [1e-6; 2]);
        assert_robust(text.as_bytes(), |b| whole(read(b)));
        assert_survives(text.as_bytes(), |b| whole(read(b)));
        let gap = text.replace("11 20 2", "11 20 No Data");
        assert_seed(&FORMAT, "gap.xyz", gap.as_bytes());
        assert!(heights(read(gap.as_bytes())).0[1].is_nan());
        let said = |from: &str, to: &str| read(text.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(
            said("12 21", "13 21").contains("`13 21 6`") && said("Format 1", "Format 2").contains("format")
        );
    }
}
