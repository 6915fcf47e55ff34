use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::*;

const SENSITIVITY: &str =
    "\\*Scanner list\r\n\\@Sens. Zsens: V 20.00000 nm/V\r\n\\@Sens. Defl: V 50.0 mV/V\r\n";

/// Returns a hand-made file: its header ends at byte 1024, then the bottom row and the top row.
fn file(version: &str, scanner: &str, image: &str, number: Number) -> Vec<u8> {
    let samples = BOTTOM.iter().chain(&TOP);
    let data: Vec<u8> = match number {
        Number::I16 => samples.flat_map(|x| (*x as i16 * 100).to_le_bytes()).collect(),
        _ => samples.flat_map(|x| (*x as i32 * 100_000).to_le_bytes()).collect(),
    };
    let version = if version.is_empty() { String::new() } else { format!("\\Version: {version}\r\n") };
    let header = format!(
        "\\*File list\r\n{version}{scanner}\\*Ciao image list\r\n\\Data offset: 1024\r\n\\Data length: {}\r\n\
         \\Samps/line: 3\r\n\\Number of lines: 2\r\n{image}\\*File list end\r\n",
        data.len()
    );
    let mut bytes = header.into_bytes();
    bytes.push(0x1a);
    bytes.resize(1024, 0);
    [bytes, data].concat()
}

const SIZE: &str = "\\Scan Size: 3000 2000 nm\r\n";

fn z(scale: &str) -> String {
    format!("{SIZE}\\Bytes/pixel: 2\r\n\\@2:Image Data: S [Height] \"Height\"\r\n\\@2:Z scale: {scale}\r\n")
}

#[test]
fn the_hard_value_times_the_sensitivity_is_the_height_and_the_first_row_is_the_bottom() {
    let image = z("V [Sens. Zsens] (0.006713867 V/LSB) 440.0000 V");
    let bytes = file("0x05120000", SENSITIVITY, &image, Number::I16);
    let (unit, quantity, size, spacing, samples) = only(read(&bytes));
    assert_eq!((unit.as_str(), quantity, size), ("nm", Quantity::Height, [3, 2]));
    assert!((spacing[0].unwrap() - 1e-6).abs() < 1e-18 && (spacing[1].unwrap() - 1e-6).abs() < 1e-18);
    assert_rows(&samples, 100.0 * 440.0 * 20e-9 / 65536.0);
    assert_eq!(read(&bytes).unwrap().channels[0].name, "Height");
    assert_robust(&bytes[..], |b| whole(read(b)));
}

#[test]
fn newer_files_have_wide_samples_whatever_the_divisor() {
    let image = z("V [Sens. Zsens] (0.0067 V/LSB) 440.0 V");
    let narrow = file("0x09300201", SENSITIVITY, &image, Number::I32);
    assert_rows(&only(read(&narrow)).4, 1e5 * 440.0 * 20e-9 / 65536.0);
    let wide = file("0x0A000000", SENSITIVITY, &image.replace("pixel: 2", "pixel: 4"), Number::I32);
    assert_rows(&only(read(&wide)).4, 1e5 * 440.0 * 20e-9 / 4_294_967_296.0);
}

#[test]
fn every_scale_chain_gives_metres_or_another_unit() {
    let read_as = |version: &str, image: &str| {
        let bytes = file(version, SENSITIVITY, image, Number::I16);
        let (unit, quantity, _, _, samples) = only(read(&bytes));
        (unit, quantity == Quantity::Height, samples[0] * 65536.0 / 100.0)
    };
    for (scale, unit, is_height, full) in [
        ("V [Sens. Zsens] (0.0067 V/LSB) 440.0 V", "nm", true, 8.8e-6),
        ("V [sens. zsens] (0.0067 mV/LSB) 2000 mV", "nm", true, 40e-9),
        ("C [Sens. Zsens] 2 V", "nm", true, 40e-9),
        ("V [Sens. Defl] (0.0003 V/LSB) 20.0 V", "mV", false, 1000.0),
        ("V [Sens. Nowhere] (0.0003 V/LSB) 20.0 V", "V", false, 20.0),
        ("V (0.0003 V/LSB) 20.0 V", "V", false, 20.0),
        ("V [] (0.0003 nm/LSB) 500.0 nm", "nm", true, 5e-7),
        ("V [Sens. Zsens] (0.0003 (V)/LSB) 1.0 Arb", "nm/V Arb", false, 20.0),
    ] {
        let (found, height, value) = read_as("0x05120000", &z(scale));
        assert_eq!((found.as_str(), height), (unit, is_height), "{scale}");
        assert!((value / full - 1.0).abs() < 1e-12, "{scale}: {value}");
    }
    // Before version 4, and before versions.
    let (_, height, value) = read_as("0x03000000", &format!("{SIZE}\\Z scale: 150.0 nm (65536)\r\n"));
    assert!(height && (value / 150e-9 - 1.0).abs() < 1e-12, "{value}");
    let (_, height, value) = read_as("", &format!("{SIZE}\\Z magnify image: 3.0\r\n"));
    assert!(height && (value / 3e-7 - 1.0).abs() < 1e-12, "{value}");
}

#[test]
fn scan_sizes_of_one_or_two_lengths_give_the_distances() {
    let spacing = |size: &str| {
        let image = z("V (0 V/LSB) 1 nm").replace(SIZE, size);
        only(read(&file("0x05120000", SENSITIVITY, &image, Number::I16)))
            .3
            .map(|d| d.map(|d| (d * 1e12).round()))
    };
    let um = |x: f64, y: f64| [Some(x * 1e6), Some(y * 1e6)];
    assert_eq!(spacing("\\Scan Size: 3 2 ~m\r\n"), um(1.0, 1.0));
    assert_eq!(spacing("\\Scan size: 3 \u{b5}m\r\n"), um(1.0, 1.5));
    assert_eq!(spacing("\\Scan Size: 3 3 ~m\r\n\\Aspect Ratio: 1:1\r\n"), um(1.0, 1.5));
    assert_eq!(spacing("\\Scan Size: 3 3 ~m\r\n\\Aspect Ratio: 3:2\r\n"), um(1.0, 1.0));
    assert_eq!(spacing("\\Scan Size: 0 0 ~m\r\n"), [None, None]);
    assert_eq!(spacing(""), [None, None]);
}

#[test]
fn what_holds_no_image_and_sizes_that_lie_are_refused() {
    let said = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
    assert!(said(b"\\*Force file list\r\n").contains("force curves"));
    assert!(said(b"\\*File list\r\n\\*File list end\r\n").contains("no image"));
    let image = z("V (0 V/LSB) 1 nm");
    let lies = |from: &str, to: &str| {
        let bytes = file("0x05120000", SENSITIVITY, &image, Number::I16);
        let text: String = bytes.iter().map(|b| char::from(*b)).collect();
        said(&text.replace(from, to).chars().map(|c| c as u8).collect::<Vec<u8>>())
    };
    assert!(lies("line: 3", "line: 9").contains("cut short"));
    assert!(lies("line: 3", "line: 99999999").contains("16384"));
    assert!(lies("offset: 1024", "offset: 18446744073709551615").contains("cut short"));
    assert!(lies("pixel: 2", "pixel: 3").contains("3 bytes"));
}

#[test]
fn an_aspect_ratio_that_is_one_number_means_square_pixels_unless_it_is_one() {
    let of = |ratio: &str| {
        let size = format!("\\Scan Size: 3000 3000 nm\r\n\\Aspect Ratio: {ratio}\r\n");
        let image = z("V [Sens. Zsens] (0.0067 V/LSB) 440.0 V").replace(SIZE, &size);
        only(read(&file("0x09700105", SENSITIVITY, &image, Number::I16))).3.map(Option::unwrap)
    };
    for (ratio, y) in [("0.516184", 1.0), ("1", 1.5), ("1:1", 1.5), ("2:1", 1.0)] {
        let [dx, dy] = of(ratio);
        assert!((dx - 1e-6).abs() < 1e-18 && (dy - y * 1e-6).abs() < 1e-18, "{ratio}: {dx} {dy}");
    }
}

#[test]
fn a_scan_that_was_stopped_has_the_lines_that_were_measured() {
    let image = z("V [Sens. Zsens] (0.0067 V/LSB) 440.0 V");
    let stopped = format!("{image}\\Valid data start Y: 1\r\n\\Valid data len Y: 1\r\n");
    let bytes = file("0x05120000", SENSITIVITY, &stopped, Number::I16);
    let (_, _, size, spacing, samples) = only(read(&bytes));
    // The second stored line is the top one; lines are as far apart as those of the whole scan.
    assert_eq!(size, [3, 1]);
    assert!((spacing[1].unwrap() - 1e-6).abs() < 1e-18);
    let step = 100.0 * 440.0 * 20e-9 / 65536.0;
    assert!(samples.iter().zip(TOP).all(|(found, x)| (found - x * step).abs() < 1e-18));
    // Many files have only the lines that were measured.
    let text = String::from_utf8_lossy(&bytes[..1024]).replace("Data length: 12", "Data length: 06");
    let short = [text.as_bytes(), &bytes[1024 + 6..]].concat();
    let (_, _, size, _, again) = only(read(&short));
    assert_eq!((size, again), ([3, 1], samples));
    assert_robust(&bytes[..], |b| whole(read(b)));
}

#[test]
fn an_empty_image_is_told_and_the_others_are_read() {
    let image = z("V [Sens. Zsens] (0.0067 V/LSB) 440.0 V");
    let empty = "\\*Ciao image list\r\n\\Data offset: 1024\r\n\\Samps/line: 0 0\r\n\\Number of lines: 0\r\n\
                 \\@2:Image Data: S [Other] \"Other\"\r\n";
    let bytes = file("0x05120000", SENSITIVITY, &format!("{image}{empty}"), Number::I16);
    let scan = read(&bytes).unwrap();
    assert_eq!(scan.channels.len(), 1);
    assert!(scan.notes[0].contains("Other") && scan.notes[0].contains("0 x 0"), "{:?}", scan.notes);
    let of_cell = [b"\\*EC File list".as_slice(), &bytes[b"\\*File list".len()..]].concat();
    assert!(MAGICS.iter().any(|magic| of_cell.starts_with(magic)));
    assert_eq!(read(&of_cell).unwrap().channels.len(), 1);
}
