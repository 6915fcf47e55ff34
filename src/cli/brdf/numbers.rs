//! Maps as numbers: CSV and NumPy arrays.

use crate::brdf::hemisphere::{HemisphereMap, views};
use crate::cli::write::Csv;
use crate::error::{Error, Result};
use crate::memory;
use crate::optics::geometry::angles;
use crate::output;
use crate::picture_file::PictureFormat;
use crate::surface::files::npy;
use std::io::{self, Write};
use std::path::Path;

/// Format of a map, by the name of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// Picture.
    Picture(PictureFormat),
    /// Row for each direction.
    Csv,
    /// Array of 32-bit floats.
    Npy,
}

impl MapFormat {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// Another extension than .png, .exr, .csv and .npy.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("npy") => Ok(Self::Npy),
            // That error names fewer formats.
            _ => PictureFormat::of(path).map(Self::Picture).map_err(|_| {
                Error::usage(
                    format!("{}: the format of the map is not clear", path.display()),
                    "name it .png, .exr, .csv or .npy",
                )
            }),
        }
    }
}

/// Returns the names of the columns of a map: at a single wavelength `is_spectral` is true and one number says the BRDF \[sr⁻¹\], else linear sRGB.
fn columns(is_spectral: bool) -> impl Iterator<Item = &'static str> {
    let values: &[&str] = if is_spectral { &["brdf"] } else { &["r", "g", "b"] };
    ["x", "y", "theta_r", "phi_r"].into_iter().chain(values.iter().copied())
}

/// Returns a row for each direction of `map`: direction cosines and angles of the viewer, and the BRDF.
fn rows(map: &HemisphereMap, is_spectral: bool) -> impl Iterator<Item = impl Iterator<Item = String>> {
    let values = if is_spectral { 1 } else { 3 };
    views(map.side, 0..map.side).map(move |(place, view)| {
        let (theta, phi) = angles(view);
        let direction = [view.x, view.y, theta, phi].map(|x| x.to_string());
        direction.into_iter().chain(map.pixels[place][..values].iter().map(|x| format!("{x:e}")))
    })
}

/// Returns the table of `map`.
///
/// # Errors
/// Fails if there is too little memory for its text.
pub fn table(map: &HemisphereMap, is_spectral: bool) -> Result<Csv> {
    /// Memory of a row as text and as an object of JSON, an upper bound \[bytes\]: seven cells of each.
    const ROW: u64 = 2048;
    memory::ensure_room(u64::from(map.side).pow(2) * ROW, "the map as JSON")?;
    let mut table = Csv::new();
    table.row(columns(is_spectral));
    rows(map, is_spectral).for_each(|row| table.row(row));
    Ok(table)
}

/// Writes `map` to the CSV file `path`, whole or not at all, row by row.
///
/// # Errors
/// A file that cannot be written.
pub fn write_csv(path: &Path, map: &HemisphereMap, is_spectral: bool) -> Result<()> {
    output::write_atomically(path, |file| {
        csv(file, map, is_spectral).map_err(|e| output::write_failed(path, e))
    })
}

fn csv(file: &mut impl Write, map: &HemisphereMap, is_spectral: bool) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(file);
    table.write_record(columns(is_spectral))?;
    for row in rows(map, is_spectral) {
        table.write_record(row.collect::<Vec<_>>())?;
    }
    table.flush()
}

/// Writes `map` to the file `path`, whole or not at all, as an array of N × N numbers at a single wavelength (`is_spectral`), else of
/// N × N × 3 of linear sRGB; NaN outside the hemisphere.
///
/// # Errors
/// A file that cannot be written.
pub fn write_npy(path: &Path, map: &HemisphereMap, is_spectral: bool) -> Result<()> {
    output::write_atomically(path, |file| {
        npy(file, map, is_spectral).map_err(|e| output::write_failed(path, e))
    })
}

fn npy(file: &mut impl Write, map: &HemisphereMap, is_spectral: bool) -> io::Result<()> {
    let side = map.side as usize;
    let shape: &[usize] = if is_spectral { &[side, side] } else { &[side, side, 3] };
    npy::write_header("<f4", shape, file)?;
    let channels = if is_spectral { 1 } else { 3 };
    for pixel in &map.pixels {
        for value in &pixel[..channels] {
            let value = if pixel[3] > 0.0 { *value } else { f32::NAN };
            file.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(())
}
