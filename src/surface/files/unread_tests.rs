use super::super::{ReadSettings, from_bytes};
use super::*;
use std::io::Write;

/// Returns a zip of empty files.
fn zip(names: &[&str]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for name in names {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(b"x").unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn files_that_are_not_read_are_named_with_a_way_out() {
    let wide: Vec<u8> = "..STiMage 005".encode_utf16().flat_map(u16::to_le_bytes).skip(2).collect();
    let binary = [&[0; 80][..], &1_u32.to_le_bytes(), &[0; 50]].concat();
    for (bytes, extension, what, remedy) in [
        (b"\x01\xb0\x93\xff\0\0".to_vec(), "mdt", "NT-MDT", "Gwyddion"),
        (zip(&["header.properties", "segments/0/x"]), "jpk-force", "force curves", "image"),
        (zip(&["height.npy", "mask.npy"]), "npz", "NumPy", ".npy"),
        (zip(&["index.xml", "LAYER_0.raw"]), "plux", "Sensofar", ".sur"),
        (b"\x89HDF\r\n\x1a\n\0".to_vec(), "dat", "an HDF5 file", "Gwyddion"),
        (b"MATLAB 5.0 MAT-file\0".to_vec(), "mat", "MATLAB", "writematrix"),
        (wide, "sm4", "RHK", "Gwyddion"),
        (b"\0\0\0\0ARDF".to_vec(), "ardf", "ARDF", "Gwyddion"),
        (OLE.to_vec(), "mnt", "MountainsMap", ".sur"),
        (b"\0\x01\0\x02".to_vec(), "nms", "NanoFocus", ".x3p"),
        (b"\x01\0\0\0".to_vec(), "asd", "high-speed", "Gwyddion"),
        (binary, "stl", "STL", ".npy"),
        (b"solid a\nfacet normal 0 0 1\n".to_vec(), "txt", "STL", ".npy"),
        (b"v 0 0 1\nf 1 1 1\n".to_vec(), "obj", "OBJ", ".npy"),
    ] {
        let e = from_bytes(&bytes, extension, &ReadSettings::default()).unwrap_err().to_string();
        assert!(
            e.contains(what) && e.contains(remedy) && e.contains("which is not read; "),
            "{extension}: {e}"
        );
    }
}

#[test]
fn descriptions_of_x3p_keep_their_reader_and_damaged_zips_its_errors() {
    assert!(by_content(&zip(&["main.xml", "index.xml"])).is_none());
    assert!(by_content(b"PK\x03\x04").is_none());
    assert!(by_content(b"").is_none() && by_name("gsf").is_none() && by_name("tmd").is_some());
}

#[test]
fn no_format_is_both_read_and_unread() {
    for extension in super::super::extensions() {
        assert!(by_name(extension).is_none(), "{extension}");
    }
}
