//! Scans of Nanosurf Studio (.nhf): HDF5 with measurements, their segments (forward, backward), and in these one dataset a channel.
//!
//! The whole range of a stored integer stands for the range of its signal. The first line is the lowest. Facts after Nanosurf's own readers
//! of versions 1 and 2 (NSFopen, nanosurf).

use super::format::Format;
use super::hdf5::{Attributes, StoredImage, explain, fill_value, has, range_of_integers, root};
use super::scan::{Channel, Scan, size, spacing};
use crate::error::Result;
use hdf5_reader::Dataset;
use hdf5_reader::group::Group;

/// The format.
pub const FORMAT: Format = Format {
    name: "nanosurf_hdf5",
    title: "Nanosurf Studio",
    extensions: &["nhf"],
    signature: |b| has(b, "nsf_file_version_major"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "the fill value", "all channels of all segments of images, versions 1 and 2"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A file without images; groups that are damaged.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let root = root(bytes)?;
    let mut found = Vec::new();
    for measurement in root.groups().map_err(explain)? {
        let whole = Attributes::of_group(&measurement)?;
        for segment in measurement.groups().map_err(explain)? {
            let own = Attributes::of_group(&segment)?;
            let Some(grid) = SegmentGrid::of(&own).or_else(|| SegmentGrid::of(&whole)) else { continue };
            let direction = own.text("segment_name").or_else(|| own.text("name")).unwrap_or_default();
            for dataset in segment.datasets().map_err(explain)? {
                found.extend(channel(&segment, dataset, &direction, &grid));
            }
        }
    }
    let mut scan = Scan::of_readable(FORMAT.title, found)?;
    scan.number_equal_names();
    Ok(scan)
}

/// Points and lines of an image, and its sides \[m\].
struct SegmentGrid {
    counts: [f64; 2],
    sides: [Option<f64>; 2],
}

impl SegmentGrid {
    /// Returns the grid that `attributes` describe, as either version does.
    fn of(attributes: &Attributes) -> Option<Self> {
        let pair = |x: &str, y: &str| [attributes.number(x), attributes.number(y)];
        if let [Some(columns), Some(rows)] = pair("image_points_per_line", "image_number_of_lines") {
            return Some(Self { counts: [columns, rows], sides: pair("image_size_x", "image_size_y") });
        }
        // Lines come first.
        let [rows, columns] = attributes.numbers("rect_axis_size")[..] else { return None };
        let sides = attributes.numbers("rect_axis_range");
        Some(Self { counts: [columns, rows], sides: [sides.get(1).copied(), sides.first().copied()] })
    }
}

/// Returns the channel in `dataset`; `None` if it is that of no signal.
fn channel<'a>(
    segment: &Group,
    dataset: Dataset,
    direction: &str,
    grid: &SegmentGrid,
) -> Option<(String, Result<Channel<'a>>)> {
    let attributes = Attributes::of_dataset(segment, &dataset);
    let signal = attributes.text("signal_name");
    let calibration = if signal.is_some() { "signal_calibration" } else { "base_calibration" };
    let end = |name: &str| attributes.number(&format!("{calibration}_{name}"));
    let ends = [end("min")?, end("max")?];
    let name = signal.or_else(|| attributes.text("name"))?;
    let name = if direction.is_empty() { name } else { format!("{name} ({direction})") };
    let unit = attributes.text(&format!("{calibration}_unit")).unwrap_or_default(); // shares have none
    let made = || {
        let size = size(grid.counts[0] as u64, grid.counts[1] as u64)?;
        let spacing = [0, 1].map(|i| spacing(grid.sides[i]?, size[i]));
        let scale = range_of_integers(&dataset).map_or([1.0, 0.0], |[least, most]| {
            let factor = (ends[1] - ends[0]) / (most - least);
            [factor, ends[0] - least * factor]
        });
        // Version 1 writes every sample.
        let missing = fill_value(&dataset).filter(|_| calibration == "signal_calibration");
        let missing = missing.map(|x| [x, x]);
        let image = StoredImage { dataset, column: None, scale, unit, missing, is_bottom_first: true };
        Ok(image.channel(name.clone(), size, spacing))
    };
    let made = made();
    Some((name, made))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_close, assert_rows, assert_survives, heights, whole};
    use super::*;

    const VERSION_1: &[u8] = include_bytes!("../../../fuzz/seeds/nanosurf_hdf5/version_1.nhf");
    const VERSION_2: &[u8] = include_bytes!("../../../fuzz/seeds/nanosurf_hdf5/version_2.nhf");

    /// Asserts that `samples` are the rows of the tests, within the rounding of the scale.
    fn assert_rounded(samples: &[f64], unit: f64) {
        let rounded: Vec<f64> = samples.iter().map(|x| (x / unit * 1e6).round() / 1e6).collect();
        assert_rows(&rounded, 1.0);
    }

    #[test]
    fn both_versions_have_scales_and_lines_from_the_top() {
        assert!((FORMAT.signature)(VERSION_1) && (FORMAT.signature)(VERSION_2));
        let (samples, distances) = heights(read(VERSION_1));
        assert_close(distances, [5e-7, 1e-6]);
        assert_rounded(&samples, 1e-9);
        let mut scan = read(VERSION_2).unwrap();
        let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["Position Z (Forward)", "Position Z (Backward)"]);
        let backward = scan.channels.pop().unwrap().samples().unwrap();
        assert!(backward[3].is_nan(), "the first sample of the lowest line was not measured");
        let forward = scan.channels.pop().unwrap();
        assert_eq!((forward.size, forward.spacing), ([3, 2], [Some(5e-7), Some(1e-6)]));
        assert_rounded(&forward.samples().unwrap(), 1e-9);
    }

    #[test]
    fn what_is_cut_or_damaged_is_refused_in_a_line() {
        assert_survives(VERSION_1, |bytes| whole(read(bytes)));
        assert_survives(VERSION_2, |bytes| whole(read(bytes)));
    }
}
