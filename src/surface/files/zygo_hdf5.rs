//! Height maps of Zygo's program Mx (.datx): HDF5 with maps in `Data/Surface`, rows from the top.
//!
//! Heights have a unit of length or are fringes, of which wavelength, interferometric factor and obliquity make lengths. The converters of
//! both axes have the distance of samples. Facts after Gwyddion's description, SurfaceTopography and prysm.

use super::bytes::damaged;
use super::format::Format;
use super::hdf5::{Attributes, StoredImage, explain, has, root};
use super::scan::{Channel, Scan, size, spacing};
use crate::error::{Error, Result};
use hdf5_reader::Dataset;
use hdf5_reader::group::Group;

/// The format.
pub const FORMAT: Format = Format {
    name: "zygo_hdf5",
    title: "Zygo Mx",
    extensions: &["datx"],
    signature: |b| has(b, "Z Converter"),
    is_by_name: false,
    read,
    facts: ["yes, if the instrument was calibrated", "yes", "the reserved number", "maps of heights"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A file of intensities alone; an unknown unit; groups that are damaged.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let root = root(bytes)?;
    let surfaces = root.group("Data").and_then(|data| data.group("Surface")).map_err(|e| {
        Error::input("holds no map of heights", "choose a file with a measured surface").caused_by(e)
    })?;
    let mut datasets = surfaces.datasets().map_err(explain)?;
    datasets.sort_by(|a, b| a.name().cmp(b.name()));
    let many = datasets.len() > 1;
    let found = datasets.into_iter().enumerate().map(|(i, dataset)| {
        let name = if many { format!("Surface {}", i + 1) } else { "Surface".to_owned() };
        (name.clone(), map(&surfaces, dataset, name))
    });
    Scan::of_readable(FORMAT.title, found.collect())
}

/// Returns the map in `dataset`.
fn map<'a>(group: &Group, dataset: Dataset, name: String) -> Result<Channel<'a>> {
    let [rows, columns] = dataset.shape() else { return Err(damaged("a map has no rows and columns")) };
    let size = size(*columns, *rows)?;
    let attributes = Attributes::of_dataset(group, &dataset);
    let unit = attributes.text("Unit").ok_or_else(|| damaged("a map has no unit"))?;
    let (unit, factor) = if unit.eq_ignore_ascii_case("fringes") {
        let factors = ["Wavelength", "Interferometric Scale Factor", "Obliquity Factor"];
        let factor = factors.iter().try_fold(1.0, |product, name| Some(product * attributes.number(name)?));
        ("m".to_owned(), factor.ok_or_else(|| damaged("fringes have no wavelength or factors"))?)
    } else {
        (unit, 1.0)
    };
    // The second parameter of a converter is the metres between samples.
    let step = |axis: &str| {
        let parameters = attributes.list_in_record(&format!("{axis} Converter"), "Parameters")?;
        spacing(*parameters.get(1)?, 1)
    };
    let spacing = ["X", "Y"].map(step);
    let missing = attributes.number("No Data").map(|least| [least, f64::INFINITY]);
    let image =
        StoredImage { dataset, column: None, scale: [factor, 0.0], unit, missing, is_bottom_first: false };
    Ok(image.channel(name, size, spacing))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_close, assert_rows, assert_survives, heights, whole};
    use super::*;

    const METRES: &[u8] = include_bytes!("../../../fuzz/seeds/zygo_hdf5/metres.datx");
    const FRINGES: &[u8] = include_bytes!("../../../fuzz/seeds/zygo_hdf5/fringes.datx");

    #[test]
    fn maps_in_metres_and_in_fringes_are_heights() {
        for (bytes, unit) in [(METRES, 1e-9), (FRINGES, 6e-7 * 0.5 * 1.1)] {
            assert!((FORMAT.signature)(bytes));
            let (mut samples, distances) = heights(read(bytes));
            assert_close(distances, [5e-7, 1e-6]);
            if bytes == METRES {
                assert!(samples[5].is_nan(), "it was not measured");
                samples[5] = 6.0 * unit;
            }
            assert_rows(&samples, unit);
        }
    }

    #[test]
    fn what_is_cut_or_damaged_is_refused_in_a_line() {
        assert_survives(METRES, |bytes| whole(read(bytes)));
        assert_survives(FRINGES, |bytes| whole(read(bytes)));
    }
}
