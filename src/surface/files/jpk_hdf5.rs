//! Scans of JPK's fast microscopes (.h5-jpk): HDF5 with one dataset for a channel, one image after the other in its columns.
//!
//! The encoder of a channel converts stored numbers to its default quantity. The first line is the lowest unless the grid is reflected.
//! Facts after a file of software 8.1 and AFMReader.

use super::bytes::damaged;
use super::format::Format;
use super::hdf5::{Attributes, StoredImage, explain, has, root};
use super::scan::{Channel, Scan, size, spacing};
use crate::error::Result;
use hdf5_reader::group::Group;

/// The format.
pub const FORMAT: Format = Format {
    name: "jpk_hdf5",
    title: "JPK scans in HDF5",
    extensions: &["h5-jpk"],
    signature: |b| has(b, "JPK SCAN"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "all channels of all images, by their default quantity"],
};

/// Largest number of images of a channel, a film of some minutes.
const MOST_IMAGES: u64 = 10_000;

/// Size of the images of a measurement.
struct ImageGrid {
    size: [usize; 2],
    spacing: [Option<f64>; 2],
    is_reflected: bool,
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A file without images; groups that are damaged.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let root = root(bytes)?;
    let mut found = Vec::new();
    for measurement in groups(&root, "Measurement_")? {
        let grid = ImageGrid::of(&measurement)?;
        for channel in groups(&measurement, "Channel_")? {
            channels(&channel, &grid, &mut found)?;
        }
    }
    let mut scan = Scan::of_readable(FORMAT.title, found)?;
    scan.number_equal_names();
    Ok(scan)
}

/// Returns the groups whose names begin with `prefix`, in the order of their names.
fn groups(group: &Group, prefix: &str) -> Result<Vec<Group>> {
    let mut groups = group.groups().map_err(explain)?;
    groups.retain(|group| name(group).starts_with(prefix));
    groups.sort_by(|a, b| name(a).cmp(name(b)));
    Ok(groups)
}

/// Returns the last part of the name of a group.
fn name(group: &Group) -> &str {
    group.name().rsplit('/').next().unwrap_or_default()
}

impl ImageGrid {
    fn of(measurement: &Group) -> Result<Self> {
        let attributes = Attributes::of_group(measurement)?;
        let number = |name: &str| attributes.number(&format!("position-pattern.grid.{name}"));
        let counts = ["ilength", "jlength"].map(|name| number(name).unwrap_or(0.0) as u64); // 0 is no size
        let size = size(counts[0], counts[1])?;
        let sides = ["ulength", "vlength"].map(number);
        let is_reflected =
            attributes.text("position-pattern.grid.reflect").is_some_and(|text| text == "true");
        Ok(Self { size, spacing: [0, 1].map(|i| spacing(sides[i]?, size[i])), is_reflected })
    }
}

/// Appends each image of a channel to `found`, with its name.
fn channels<'a>(
    group: &Group,
    grid: &ImageGrid,
    found: &mut Vec<(String, Result<Channel<'a>>)>,
) -> Result<()> {
    let attributes = Attributes::of_group(group)?;
    let datasets = group.datasets().map_err(explain)?;
    let dataset = datasets.iter().find(|dataset| !dataset.name().ends_with("thumbnail"));
    let dataset = dataset.ok_or_else(|| damaged(format!("the group `{}` has no dataset", name(group))))?;
    let title = attributes.text("channel.fancy-name").or_else(|| attributes.text("channel.name"));
    let title = title.unwrap_or_else(|| "unnamed".to_owned());
    let is_retrace = attributes.text("retrace").is_some_and(|text| text == "true");
    let encoder = |name: &str| attributes.number(&format!("net-encoder.scaling.{name}"));
    let images = dataset.shape().get(1).copied().unwrap_or(1);
    if images > MOST_IMAGES {
        return Err(damaged(format!("a channel has {images} images, more than {MOST_IMAGES}")));
    }
    for column in 0..images {
        let mut title = if is_retrace { format!("{title} (retrace)") } else { title.clone() };
        if column > 0 {
            title += &format!(", image {}", column + 1);
        }
        let channel = || {
            let factor = encoder("multiplier").filter(|x| x.is_finite());
            let factor = factor.ok_or_else(|| damaged(format!("the channel `{title}` has no factor")))?;
            let image = StoredImage {
                dataset: dataset.clone(),
                column: Some(column),
                scale: [factor, encoder("offset").unwrap_or(0.0)],
                unit: attributes.text("net-encoder.scaling.unit.unit").unwrap_or_default(), // raw numbers have none
                missing: None,
                is_bottom_first: !grid.is_reflected,
            };
            Ok(image.channel(title.clone(), grid.size, grid.spacing))
        };
        let channel = channel();
        found.push((title, channel));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_rows, assert_survives, whole};
    use super::*;

    const FRAMES: &[u8] = include_bytes!("../../../fuzz/seeds/jpk_hdf5/frames.h5-jpk");

    #[test]
    fn channels_have_names_scales_and_lines_from_the_top() {
        assert!((FORMAT.signature)(FRAMES));
        let scan = read(FRAMES).unwrap();
        let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(
            names,
            ["Error Signal (retrace)", "Error Signal (retrace), image 2", "Height", "Height, image 2"]
        );
        let chosen = super::super::choose::choose(&scan, None).unwrap();
        assert_eq!(chosen, 2);
        for (i, channel) in scan.channels.into_iter().enumerate().skip(2) {
            assert_eq!((channel.size, channel.spacing), ([3, 2], [Some(5e-7), Some(1e-6)]));
            let samples = channel.samples().unwrap();
            let first = if i == 2 { 0.0 } else { 7.0 };
            let stored: Vec<f64> = samples.iter().map(|h| (1e-8 - h) / 1e-9 - first).collect();
            let rounded: Vec<f64> = stored.iter().map(|x| (x * 1e9).round() / 1e9).collect();
            assert_rows(&rounded, 1.0);
        }
    }

    #[test]
    fn what_is_cut_or_damaged_is_refused_in_a_line() {
        assert_survives(FRAMES, |bytes| whole(read(bytes)));
    }
}
