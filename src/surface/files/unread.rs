//! Formats that are recognised and not read: their names, and what to do with such a file.

use super::bytes::{Order, wide_text};
use super::format::no_signature;
use super::tiff_tags::TiffDirectory;
use super::{hdf5, jpk_hdf5, nanosurf_hdf5, zygo_hdf5};
use crate::error::Error;
use std::io::Cursor;
use zip::ZipArchive;

/// Format that is not read.
struct UnreadFormat {
    /// Description for people, behind "is".
    what: &'static str,
    /// Extensions of the names of files, for content without a signature.
    extensions: &'static [&'static str],
    /// Function that returns true for the content of such a file.
    signature: fn(&[u8]) -> bool,
    remedy: &'static str,
}

/// Remedy for what Gwyddion reads.
const GWYDDION: &str = "Gwyddion reads it: save it there as .gwy";
/// Remedy for HDF5, of which Gwyddion reads some kinds.
const HDF5: &str = "try Gwyddion, which reads many of them, and save it there as .gwy; or export it as text";
/// Remedy for the files of instruments that Gwyddion does not read.
const EXPORT: &str = "export the heights with the instrument's program as .sur, .x3p, .sdf or text";
/// Remedy for meshes.
const MESH: &str = "write the heights of a grid as .npy, .gsf or text";
/// Remedy for force curves.
const CURVES: &str = "choose the file of the image beside it, which has the heights";

/// First bytes of an OLE compound document.
const OLE: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";

/// All formats that are recognised and not read. A file that is a zip or a TIFF is told by what is in it.
const UNREAD: &[UnreadFormat] = &[
    row(
        "a file of JPK's force curves",
        &["jpk-force", "jpk-force-map", "jpk-qi-data"],
        |b| zip_holds(b, "header.properties"),
        CURVES,
    ),
    row(
        "an archive of NumPy arrays",
        &["npz"],
        |b| zip_holds(b, "npy"),
        "save one array as .npy, with numpy.save",
    ),
    row("a Sensofar scan (.plux)", &["plux"], |b| zip_holds(b, "index.xml"), EXPORT),
    row(
        "a spreadsheet",
        &["xlsx", "ods"],
        |b| zip_holds(b, "workbook.xml") || zip_holds(b, "content.xml"),
        "save the sheet as .csv",
    ),
    row("an Olympus LEXT scan", &["lext"], is_lext, GWYDDION),
    row("an NT-MDT scan", &["mdt"], |b| b.starts_with(b"\x01\xb0\x93\xff"), GWYDDION),
    row(
        "an RHK scan",
        &["sm2", "sm3", "sm4"],
        |b| b.starts_with(b"STiMage ") || wide_at(b, 2, "STiMage "),
        GWYDDION,
    ),
    row("an Omicron MATRIX scan", &["mtrx"], |b| b.starts_with(b"ONTMATRX"), GWYDDION),
    row(
        "a netCDF file, of GXSM perhaps",
        &["nc"],
        |b| b.starts_with(b"CDF\x01") || b.starts_with(b"CDF\x02"),
        GWYDDION,
    ),
    row("a TrueMap scan", &["tmd"], |b| b.starts_with(b"Binary TrueMap Data File"), GWYDDION),
    row("a scan of Bruker's Vision64 or Dektak (.opdx)", &["opdx"], |b| b.starts_with(b"VCA DATA"), GWYDDION),
    row("an Olympus scan (.oir)", &["oir"], |b| b.starts_with(b"OLYMPUSRAWFORMAT"), GWYDDION),
    row("an Asylum Research ARDF file", &["ardf"], |b| b.get(8..12) == Some(b"ARDF"), GWYDDION),
    row("a Zeta scan", &["zmg"], |b| b.starts_with(b"Zeta-Instruments"), GWYDDION),
    row("a WITec file", &["wip", "wit"], |b| b.starts_with(b"WIT_PR"), GWYDDION),
    row("a Renishaw file", &["wdf"], |b| b.starts_with(b"WDF1"), GWYDDION),
    row("an NRRD file", &["nrrd"], |b| b.starts_with(b"NRRD000"), GWYDDION),
    row("an ISO 28600 scan", &[], |b| b.starts_with(b"ISO/TC 201 SPM data transfer format"), GWYDDION),
    row("a Keyence scan (.zon)", &["zon"], |b| b.starts_with(b"KPK0") || b.starts_with(b"KPK1"), EXPORT),
    row("an OmniSurf3D scan", &["os3d"], |b| b.starts_with(b"OmniSurf3D"), EXPORT),
    row("a FITS image", &["fits", "fit"], |b| b.starts_with(b"SIMPLE  ="), "save its array as .npy"),
    row(
        "a MATLAB file",
        &["mat"],
        |b| b.starts_with(b"MATLAB "),
        "save the matrix as text, with writematrix",
    ),
    row(
        "a document of MountainsMap or one of its kin",
        &["mnt", "lms"],
        |b| b.starts_with(OLE),
        "open it there, and save the surface as .sur",
    ),
    row("an HDF5 file of no known program", &["h5", "hdf5"], is_other_hdf5, HDF5),
    row("a grid of Nanonis's spectra", &["3ds"], |b| b.starts_with(b"Grid dim="), CURVES),
    row("a NanoFocus scan", &["nms"], no_signature, EXPORT),
    row("a high-speed AFM film", &["asd"], no_signature, GWYDDION),
    row("an Olympus LEXT scan (OLS3000)", &["ols"], no_signature, GWYDDION),
    row("an STL mesh, not a field of heights", &["stl"], is_stl, MESH),
    row(
        "a PLY mesh, not a field of heights",
        &["ply"],
        |b| b.starts_with(b"ply\n") || b.starts_with(b"ply\r\n"),
        MESH,
    ),
    row("a glTF mesh, not a field of heights", &["glb", "gltf"], |b| b.starts_with(b"glTF"), MESH),
    row("an OBJ mesh, not a field of heights", &["obj"], no_signature, MESH),
];

const fn row(
    what: &'static str,
    extensions: &'static [&'static str],
    signature: fn(&[u8]) -> bool,
    remedy: &'static str,
) -> UnreadFormat {
    UnreadFormat { what, extensions, signature, remedy }
}

/// Returns the error for a file of a format that is recognised by its content and not read; `None` for others.
pub fn by_content(bytes: &[u8]) -> Option<Error> {
    UNREAD.iter().find(|format| (format.signature)(bytes)).map(refusal)
}

/// Returns the error for a file with an `extension` of a format that is not read; `None` for others.
pub fn by_name(extension: &str) -> Option<Error> {
    UNREAD.iter().find(|format| format.extensions.contains(&extension)).map(refusal)
}

fn refusal(format: &UnreadFormat) -> Error {
    Error::input(format!("is {}, which is not read", format.what), format.remedy)
}

/// Returns true if `bytes` are a zip with a file whose name ends with `name`, and without a description of X3P.
fn zip_holds(bytes: &[u8], name: &str) -> bool {
    if !bytes.starts_with(b"PK\x03\x04") {
        return false;
    }
    let Ok(archive) = ZipArchive::new(Cursor::new(bytes)) else { return false }; // the reader of X3P tells the damage
    let names: Vec<_> = archive.file_names().filter_map(|name| name.ok()).collect();
    names.iter().any(|other| other.ends_with(name)) && !names.iter().any(|other| other.ends_with("main.xml"))
}

/// Returns true if `text` stands at `place` in UTF-16.
fn wide_at(bytes: &[u8], place: usize, text: &str) -> bool {
    bytes.get(place..place + 2 * text.len()).is_some_and(|b| wide_text(b, Order::Little) == text)
}

/// Returns true for a TIFF with the description that Olympus's programs write.
fn is_lext(bytes: &[u8]) -> bool {
    /// Tag of the description of an image.
    const DESCRIPTION: u16 = 270;
    let pages = TiffDirectory::all(bytes);
    pages
        .first()
        .and_then(|page| page.text(DESCRIPTION))
        .is_some_and(|text| text.contains("<TiffTagDescData"))
}

/// Returns true for HDF5 of none of the programs whose files are read.
fn is_other_hdf5(bytes: &[u8]) -> bool {
    let mut read = [jpk_hdf5::FORMAT, nanosurf_hdf5::FORMAT, zygo_hdf5::FORMAT].into_iter();
    bytes.starts_with(hdf5::SIGNATURE) && !read.any(|format| (format.signature)(bytes))
}

/// Returns true for an STL, as text or with a count of triangles that fits the length of the file.
fn is_stl(bytes: &[u8]) -> bool {
    /// Bytes before the count of triangles.
    const HEAD: usize = 80;
    /// Bytes of a triangle.
    const TRIANGLE: usize = 50;
    let count = bytes.get(HEAD..HEAD + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let is_binary =
        count.is_some_and(|n| n > 0 && n.saturating_mul(TRIANGLE).saturating_add(HEAD + 4) == bytes.len());
    is_binary || bytes.starts_with(b"solid ") && bytes.windows(6).take(1000).any(|w| w == b"facet ")
}

#[cfg(test)]
#[path = "unread_tests.rs"]
mod tests;
