use super::*;
use crate::error::Remedy;
use std::fs;

const PIXEL: Option<[f64; 2]> = Some([0.01, 0.01]);

fn settings(pixel_size: Option<[f64; 2]>, height: Option<f64>) -> ReadSettings<'static> {
    ReadSettings { pixel_size, height, channel: None }
}

#[test]
fn content_decides_and_a_wrong_extension_does_no_harm() {
    let sdf = b"aISO-1.0\nNumPoints = 2\nNumProfiles = 1\nXscale = 1e-8\nYscale = 1e-8\nZscale = 1\n*\n1e-9 2e-9\n*";
    for extension in ["sdf", "png", "tif", "", "xyz"] {
        let scan = from_bytes(sdf, extension, &ReadSettings::default()).unwrap();
        assert_eq!((scan.size(), scan.summary().range), ([2, 1], [1e-9, 2e-9]));
    }
    let points = b"0 0 1e-9\n1e-8 0 2e-9\n2e-8 0 3e-9\n";
    assert_eq!(from_bytes(points, "xyz", &ReadSettings::default()).unwrap().size(), [3, 1]);
    assert_eq!(from_bytes(points, "txt", &settings(PIXEL, None)).unwrap().size(), [3, 3]);
    assert!(
        from_bytes(b"\0\0\0\0", "", &settings(PIXEL, None))
            .unwrap_err()
            .to_string()
            .contains("no known format")
    );
}

#[test]
fn every_format_stands_in_the_table_of_the_book() {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/SCANS.md");
    let page = fs::read_to_string(&place).unwrap();
    let is_row = |line: &&str| line.starts_with("| `.");
    let (rows, written): (Vec<&str>, Vec<String>) =
        (page.lines().filter(is_row).collect(), FORMATS.iter().map(Format::row).collect());
    if std::env::var_os("DIFFRACT_BLESS").is_some() {
        fs::write(&place, page.replace(&rows.join("\n"), &written.join("\n"))).unwrap();
    } else {
        assert_eq!(rows, written, "the table of docs/SCANS.md; DIFFRACT_BLESS=1 writes it");
    }
}

#[test]
fn extensions_are_lower_case_and_each_stands_once() {
    let all = extensions();
    assert!(all.iter().all(|e| *e == e.to_lowercase() && !e.contains('.')), "{all:?}");
    assert!(is_extension("TIF") && is_extension("gsf") && !is_extension("obj"));
    assert_eq!(all.iter().filter(|e| **e == "tiff").count(), 1);
    assert!(known().contains(".gsf .gwy"));
}

#[test]
fn a_scale_that_is_missing_is_asked_for() {
    let matrix = b"1e-9 2e-9\n3e-9 4e-9\n";
    let said = |e: Result<Topography>| {
        let e = e.unwrap_err();
        assert_eq!(e.kind(), error::ErrorKind::Usage);
        e.remedies().to_vec()
    };
    assert_eq!(said(from_bytes(matrix, "txt", &ReadSettings::default())), [Remedy::PixelSize]);
    assert!(from_bytes(matrix, "txt", &settings(PIXEL, None)).is_ok());
    let codes = [
        &b"\x93NUMPY\x01\x00\x42\x00{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2), }     \n"[..],
        &[0, 255],
    ]
    .concat();
    let length = codes.len() - 10 - 2;
    let mut codes = codes;
    codes[8] = length as u8;
    assert_eq!(said(from_bytes(&codes, "npy", &settings(PIXEL, None))), [Remedy::FullHeight]);
    let read = from_bytes(&codes, "npy", &settings(PIXEL, Some(0.51))).unwrap();
    assert!((read.summary().range[1] - 0.51e-6).abs() < 1e-18);
    assert!((read.origin().unwrap().quantisation.unwrap() - 2e-9).abs() < 1e-20, "a step of 8 bits");
}

#[test]
fn options_override_what_a_file_says() {
    let text = "# A: B\n# W: 2 \u{b5}m\n# H: 2 \u{b5}m\n# U: nm\n10 20\n30 50\n";
    let plain = from_bytes(text.as_bytes(), "txt", &ReadSettings::default()).unwrap();
    assert!((plain.spacing()[0] - 1e-6).abs() < 1e-18 && (plain.summary().range[1] - 50e-9).abs() < 1e-20);
    let other = from_bytes(text.as_bytes(), "txt", &settings(Some([0.5, 0.25]), Some(0.08))).unwrap();
    assert_eq!(other.spacing(), [5e-7, 2.5e-7]);
    let [low, high] = other.summary().range;
    assert!((high - low - 80e-9).abs() < 1e-20 && (low - 20e-9).abs() < 1e-20);
    let field = other.into_field().unwrap();
    assert_eq!(field.pixel_size(), [0.5, 0.25]);
}

#[test]
fn a_channel_without_a_unit_needs_a_height_an_angle_is_refused_and_gaps_are_told() {
    let text = "# A: Phase\n# W: 2 \u{b5}m\n# H: 2 \u{b5}m\n# U: deg\n10 20\n30 nan\n";
    for height in [None, Some(0.2)] {
        let e = from_bytes(text.as_bytes(), "txt", &settings(None, height)).unwrap_err();
        assert!(e.to_string().contains("Phase") && e.to_string().contains("deg"), "{e}");
        assert_eq!(e.remedies(), [Remedy::Channel]);
    }
    let text = text.replace("deg", "a.u.");
    let e = from_bytes(text.as_bytes(), "txt", &ReadSettings::default()).unwrap_err();
    assert_eq!(e.remedies(), [Remedy::Channel, Remedy::FullHeight]);
    let scan = from_bytes(text.as_bytes(), "txt", &settings(None, Some(0.2))).unwrap();
    let origin = scan.origin().unwrap();
    assert!(origin.warnings.iter().any(|line| line.contains("1 of 4 samples")), "{:?}", origin.warnings);
    assert_eq!(scan.missing(), 1);
    let field = scan.into_field().unwrap();
    assert!(
        (field.heights()[3] - 0.2).abs() < 1e-12,
        "the mean of its neighbours, not zero: {:?}",
        field.heights()
    );
}

#[test]
fn a_sidecar_gives_what_the_file_does_not_and_options_win() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.txt");
    fs::write(&path, "1e-9 2e-9\n3e-9 4e-9\n").unwrap();
    assert!(read(&path, &ReadSettings::default(), &Task::silent()).is_err());
    fs::write(folder.path().join("scan.toml"), "pixel_size = \"20nm\"\n").unwrap();
    assert!(
        (read(&path, &ReadSettings::default(), &Task::silent()).unwrap().spacing()[0] - 20e-9).abs() < 1e-22
    );
    assert!(
        (read(&path, &settings(PIXEL, None), &Task::silent()).unwrap().spacing()[0] - 10e-9).abs() < 1e-22
    );
    fs::write(folder.path().join("scan.toml"), "pixel_size = \"20\"\n").unwrap();
    assert!(
        read(&path, &ReadSettings::default(), &Task::silent()).unwrap_err().to_string().contains("scan.toml")
    );
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf_8_are_read() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(std::ffi::OsStr::from_bytes(b"sc\xffan.txt"));
    fs::write(&path, "1e-9 2e-9\n").unwrap();
    assert_eq!(read(&path, &settings(PIXEL, None), &Task::silent()).unwrap().size(), [2, 1]);
}

/// Reads or refuses every file of the folder `DIFFRACT_SCANS`, if it is set.
#[test]
fn scans_of_a_folder_are_read_where_one_is_named() {
    let Some(folder) = std::env::var_os("DIFFRACT_SCANS") else { return };
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match read(&path, &settings(PIXEL, Some(0.1)), &Task::silent()) {
            Ok(scan) => assert!(scan.summary().rms.is_finite(), "{}", path.display()),
            Err(e) => assert!(e.to_string().contains("; "), "{}: {e}", path.display()),
        }
    }
}

#[test]
fn reading_is_told_part_by_part_and_ends_where_it_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("field.npy");
    // 36 MB: three parts, and the end.
    let field = HeightField::from_fn(3000, 1500, [0.1; 2], |x, y| x.sin() * y.cos()).unwrap();
    field.save(&path).unwrap();
    let settings = ReadSettings { pixel_size: Some([0.1; 2]), ..ReadSettings::default() };
    let (all, reports) = Task::cancelled_at(usize::MAX);
    assert_eq!(read(&path, &settings, &all).unwrap().size(), [3000, 1500]);
    let parts = reports.load(std::sync::atomic::Ordering::Relaxed);
    assert_eq!(parts, 4);
    for last in 1..=parts {
        let (task, reports) = Task::cancelled_at(last);
        assert!(read(&path, &settings, &task).is_err_and(|e| e.is_cancelled()), "{last}");
        assert_eq!(reports.load(std::sync::atomic::Ordering::Relaxed), last);
    }
}
