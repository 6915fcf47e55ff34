use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, whole};
use super::*;

fn wide(text: &str, width: usize) -> Vec<u8> {
    let mut units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    units.resize(width * 2, 0);
    units
}

/// Returns the vendor's header, hand-made: 3 × 2 samples over 3 × 4 µm.
fn header(gain: f64, scale: f64, offset: f64, unit: &str, kind: Option<u32>) -> Vec<u8> {
    let mut h = vec![0; 4];
    h.extend(wide("Z Height", 32));
    h.extend(wide("C-AFM", 8));
    h.extend([0; 16]);
    h.extend(3_u32.to_le_bytes());
    h.extend(2_u32.to_le_bytes());
    h.extend([0; 32]);
    h.extend(3.0_f64.to_le_bytes());
    h.extend(4.0_f64.to_le_bytes());
    h.extend([0; 32]);
    h.extend(wide("V", 8));
    h.extend([0; 16]);
    for number in [gain, scale, offset] {
        h.extend(number.to_le_bytes());
    }
    h.extend(wide(unit, 8));
    h.extend([0; 24]);
    if let Some(kind) = kind {
        h.extend([0; 64]);
        assert_eq!(h.len(), TYPE_PLACE);
        h.extend(kind.to_le_bytes());
    }
    h
}

/// Returns a TIFF of a directory with Park's tags alone.
fn file(version: u32, header: &[u8], data: &[u8]) -> Vec<u8> {
    let start = 8 + 2 + 3 * 12 + 4;
    let mut bytes = b"II*\0\x08\0\0\0\x03\0".to_vec();
    let entries = [
        (VERSION_TAG, 4_u16, 1, version),
        (DATA_TAG, 1, data.len() as u32, (start + header.len()) as u32),
        (HEADER_TAG, 7, header.len() as u32, start as u32),
    ];
    for (tag, kind, count, value) in entries {
        bytes.extend(
            [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()]
                .concat(),
        );
    }
    [&bytes[..], &[0; 4], header, data].concat()
}

fn rows() -> impl Iterator<Item = f64> {
    BOTTOM.into_iter().chain(TOP)
}

#[test]
fn integers_and_floats_are_scaled_with_any_sign_of_the_gain() {
    let shorts: Vec<u8> = rows().flat_map(|h| (h as i16).to_le_bytes()).collect();
    let longs: Vec<u8> = rows().flat_map(|h| (h as i32).to_le_bytes()).collect();
    let floats: Vec<u8> = rows().flat_map(|h| (h as f32).to_le_bytes()).collect();
    for (bytes, unit) in [
        (file(0x0100_0001, &header(-2.0, 0.5, 0.0, "um", None), &shorts), -1e-6),
        (file(0x0100_0001, &header(1e-3, 0.0, 0.0, "", None), &shorts), 1e-9),
        (file(0x0100_0002, &header(1.0, 1.0, 0.0, "nm", Some(0)), &shorts), 1e-9),
        (file(0x0100_0002, &header(1.0, 1.0, 0.0, "nm", Some(1)), &longs), 1e-9),
        (file(0x0100_0002, &header(-1.0, 1.0, 0.0, "um", Some(2)), &floats), -1e-6),
    ] {
        let mut scan = super::super::recognise(&bytes, "tiff").unwrap();
        let channel = scan.channels.remove(0);
        assert_eq!((channel.name.as_str(), channel.size, scan.format), ("Z Height", [3, 2], "Park TIFF"));
        let [x, y] = channel.spacing.map(Option::unwrap);
        assert!((x - 1e-6).abs() < 1e-18 && (y - 2e-6).abs() < 1e-18);
        assert_rows(&channel.samples().unwrap(), unit);
        assert_robust(&bytes, |b| whole(super::super::recognise(b, "tiff")));
    }
}

#[test]
fn the_offset_is_added_before_the_gain() {
    let shorts: Vec<u8> = rows().flat_map(|h| (h as i16).to_le_bytes()).collect();
    let bytes = file(0x0100_0001, &header(-2.0, 0.5, 3.0, "nm", None), &shorts);
    let samples = read(&bytes).unwrap().channels.remove(0).samples().unwrap();
    assert!((samples[0] - (0.5 + 3.0) * -2.0 * 1e-9).abs() < 1e-24);
}

#[test]
fn line_profiles_and_unknown_types_are_refused() {
    let mut profile = header(1.0, 1.0, 0.0, "um", None);
    profile[0] = 1;
    assert!(read(&file(0x0100_0001, &profile, &[0; 12])).err().unwrap().to_string().contains("line profile"));
    assert!(read(&file(0x0100_0002, &header(1.0, 1.0, 0.0, "um", Some(7)), &[0; 12])).is_err());
    assert!(read(&file(0x0100_0001, &header(f64::NAN, 1.0, 0.0, "um", None), &[0; 12])).is_err());
    assert!(!recognise(b"II*\0\x08\0\0\0\0\0\0\0\0\0"), "a TIFF of somebody else");
}
