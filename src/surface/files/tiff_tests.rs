use super::super::testing::{BOTTOM, TOP, assert_rows, only, whole};
use super::super::topography::Spacing;
use super::*;

/// Returns a hand-made TIFF of one strip: entries of tag, type, count and value, in either byte order, classic or big.
fn file(big_endian: bool, big: bool, entries: &[(u16, u16, u32)], data: &[u8]) -> Vec<u8> {
    let mut all = entries.to_vec();
    let width = if big { 20 } else { 12 };
    let (head, count, next) = if big { (16, 8, 8) } else { (8, 2, 4) };
    let count_of = all.len() + 2;
    let start = head + count + count_of * width + next;
    all.push((273, 4, start as u32));
    all.push((279, 4, data.len() as u32));
    all.sort_unstable();
    let mut bytes: Vec<u8> = Vec::new();
    let put = |bytes: &mut Vec<u8>, little: &[u8]| {
        let mut field = little.to_vec();
        if big_endian {
            field.reverse();
        }
        bytes.extend(field);
    };
    bytes.extend(if big_endian { b"MM" } else { b"II" });
    if big {
        put(&mut bytes, &43_u16.to_le_bytes());
        put(&mut bytes, &8_u16.to_le_bytes());
        put(&mut bytes, &0_u16.to_le_bytes());
        put(&mut bytes, &16_u64.to_le_bytes());
        put(&mut bytes, &(all.len() as u64).to_le_bytes());
    } else {
        put(&mut bytes, &42_u16.to_le_bytes());
        put(&mut bytes, &8_u32.to_le_bytes());
        put(&mut bytes, &(all.len() as u16).to_le_bytes());
    }
    for (tag, kind, value) in all {
        put(&mut bytes, &tag.to_le_bytes());
        put(&mut bytes, &kind.to_le_bytes());
        // A text fills the field of its entry.
        let count: u64 = if kind == 2 { 4 } else { 1 };
        put(&mut bytes, &count.to_le_bytes()[..if big { 8 } else { 4 }]);
        let before = bytes.len();
        match kind {
            3 => put(&mut bytes, &(value as u16).to_le_bytes()),
            _ => put(&mut bytes, &value.to_le_bytes()),
        }
        bytes.resize(before + if big { 8 } else { 4 }, 0);
    }
    bytes.resize(start, 0);
    [bytes, data.to_vec()].concat()
}

fn grey(bits: u32, format: u32, orientation: u32) -> Vec<(u16, u16, u32)> {
    let fixed = [(256, 4, 3), (257, 4, 2), (259, 3, 1), (262, 3, 1), (277, 3, 1), (278, 4, 2)];
    [&fixed[..], &[(258, 3, bits), (339, 3, format), (274, 3, orientation)]].concat()
}

fn floats(big_endian: bool) -> Vec<u8> {
    let bytes = |h: &f64| if big_endian { (*h as f32).to_be_bytes() } else { (*h as f32).to_le_bytes() };
    TOP.iter().chain(&BOTTOM).flat_map(bytes).collect()
}

#[test]
fn floats_are_metres_in_classic_and_big_files_of_both_byte_orders() {
    for (big_endian, big) in [(false, false), (true, false), (false, true), (true, true)] {
        let bytes = file(big_endian, big, &grey(32, 3, 1), &floats(big_endian));
        let (unit, quantity, size, spacing, samples) = only(read(&bytes));
        assert_eq!((unit.as_str(), quantity, size, spacing), ("m", Quantity::Height, [3, 2], [None, None]));
        assert_rows(&samples, 1.0);
        for length in 0..bytes.len() {
            assert!(whole(read(&bytes[..length])).is_err(), "{length}");
        }
    }
}

#[test]
fn integers_of_all_widths_are_shares_of_their_largest_code() {
    let signed: Vec<u8> = TOP.iter().chain(&BOTTOM).flat_map(|h| (*h as i16).to_le_bytes()).collect();
    assert_rows(&only(read(&file(false, false, &grey(16, 2, 1), &signed))).4, 1.0 / 32767.0);
    let wide: Vec<u8> = TOP.iter().chain(&BOTTOM).flat_map(|h| (*h as u32).to_le_bytes()).collect();
    assert_rows(&only(read(&file(false, false, &grey(32, 1, 1), &wide))).4, 1.0 / f64::from(u32::MAX));
    let eight = [1, 2, 3, 4, 5, 6];
    for big in [false, true] {
        let (_, quantity, .., samples) = only(read(&file(false, big, &grey(8, 1, 1), &eight)));
        assert_eq!(quantity, Quantity::Code { largest: 255.0 });
        assert_rows(&samples, 1.0 / 255.0);
    }
}

#[test]
fn every_orientation_shows_the_same_corner_in_floats_and_in_codes() {
    // Expected positions of the stored samples a b c / d e f, from the table of TIFF 6.0.
    for (orientation, size, shown) in [
        (1, [3, 2], [1, 2, 3, 4, 5, 6]),
        (2, [3, 2], [3, 2, 1, 6, 5, 4]),
        (3, [3, 2], [6, 5, 4, 3, 2, 1]),
        (4, [3, 2], [4, 5, 6, 1, 2, 3]),
        (5, [2, 3], [1, 4, 2, 5, 3, 6]),
        (6, [2, 3], [4, 1, 5, 2, 6, 3]),
        (7, [2, 3], [6, 3, 5, 2, 4, 1]),
        (8, [2, 3], [3, 6, 2, 5, 1, 4]),
    ] {
        let (_, _, found, _, samples) =
            only(read(&file(false, false, &grey(32, 3, orientation), &floats(false))));
        assert_eq!((found, samples), (size, shown.map(f64::from).to_vec()), "{orientation}");
        let codes = file(false, false, &grey(8, 1, orientation), &[1, 2, 3, 4, 5, 6]);
        let (_, _, found, _, samples) = only(read(&codes));
        let samples: Vec<f64> = samples.iter().map(|x| (x * 255.0).round()).collect();
        assert_eq!((found, samples), (size, shown.map(f64::from).to_vec()), "{orientation} in codes");
    }
}

#[test]
fn what_is_written_has_its_distances_and_the_rounding_of_single_precision() {
    let heights: Vec<f64> = TOP.iter().chain(&BOTTOM).map(|h| h / 3.0 * 1e-7).collect();
    for spacing in [[7.843137254901961e-9, 1e-8], [1e-12, 3.3e-6], [2.58e-6, 3e-3]] {
        let scan = Topography::new([3, 2], Spacing::Metres(spacing), heights.clone(), 1e6, None).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        write(&scan, &Notes::default(), &mut bytes).unwrap();
        let (_, _, size, found, samples) = only(read(bytes.get_ref()));
        assert_eq!((size, found), ([3, 2], spacing.map(Some)));
        assert!(samples.iter().zip(&heights).all(|(a, b)| *a == f64::from(*b as f32)));
    }
}

#[test]
fn fractions_of_32_bits_are_close() {
    for x in [1.0, 72.0, 1e6, 0.01 / 7.843137254901961e-9, 0.01 / 2.58e-6, std::f64::consts::PI] {
        let Rational { n, d } = rational(x);
        assert!((f64::from(n) / f64::from(d) / x - 1.0).abs() < 1e-9, "{x}: {n}/{d}");
    }
    for x in [0.0, 1e-300, 1e300, f64::INFINITY] {
        let Rational { n, d } = rational(x);
        assert!(n > 0 && d > 0, "{x}");
    }
}

#[test]
fn counting_from_white_and_sizes_that_lie_are_refused() {
    let mut white = grey(32, 3, 1);
    white.iter_mut().filter(|e| e.0 == 262).for_each(|e| e.2 = 0);
    assert!(read(&file(false, false, &white, &floats(false))).err().unwrap().to_string().contains("white"));
    let mut wide = grey(32, 3, 1);
    wide.iter_mut().filter(|e| e.0 == 256).for_each(|e| e.2 = 100_000);
    assert!(read(&file(false, false, &wide, &floats(false))).err().unwrap().to_string().contains("16384"));
    let mut long = grey(32, 3, 1);
    long.iter_mut().filter(|e| matches!(e.0, 256 | 257 | 278)).for_each(|e| e.2 = 3000);
    assert!(read(&file(false, false, &long, &floats(false))).is_err());
}

#[test]
fn codes_that_count_from_white_are_refused() {
    for bits in [8, 16] {
        let data = vec![1u8; 6 * bits as usize / 8];
        let entries =
            [(256, 4, 3), (257, 4, 2), (258, 3, bits), (259, 3, 1), (262, 3, 0), (277, 3, 1), (278, 4, 2)];
        let refused = read(&file(false, false, &entries, &data)).err().unwrap().to_string();
        assert!(refused.contains("WhiteIsZero"), "{refused}");
    }
}

#[test]
fn imagej_s_units_count_for_each_axis_and_for_values() {
    let text = "ImageJ=1.53t\nunit=\\u00B5m\nyunit=nm\nvunit=nm\n";
    assert_eq!(image_j(text, "unit").as_deref(), Some("\u{b5}m"));
    assert_eq!(image_j(text, "yunit").as_deref(), Some("nm"));
    assert_eq!(image_j(text, "vunit").as_deref(), Some("nm"));
    assert_eq!(image_j("unit=nm", "unit"), None);
}

#[test]
fn tags_say_which_code_is_the_largest_and_which_is_none() {
    let stored: Vec<u8> = [0_u16, 4095, 7, 2048, 1, 2].iter().flat_map(|n| n.to_le_bytes()).collect();
    for tag in [281, 341] {
        let entries = [&grey(16, 1, 1)[..], &[(tag, 3, 4095)]].concat();
        let bytes = file(false, false, &entries, &stored);
        let scan = read(&bytes).unwrap();
        assert!(scan.notes[0].contains("4095 by the file's tag"), "{:?}", scan.notes);
        let (_, quantity, .., samples) = only(Ok(scan));
        assert_eq!((quantity, samples[1]), (Quantity::Code { largest: 4095.0 }, 1.0));
    }
    let entries = [&grey(16, 1, 1)[..], &[(281, 3, 4000)]].concat();
    assert_eq!(only(read(&file(false, false, &entries, &stored))).1, Quantity::Code { largest: 65_535.0 });
    // The text "7" stands in the entry.
    let mut bytes =
        file(false, false, &[&grey(16, 1, 1)[..], &[(42113, 2, u32::from(b'7'))]].concat(), &stored);
    let (.., samples) = only(read(&bytes));
    assert!(samples[2].is_nan() && (samples[3] - 2048.0 / 65_535.0).abs() < 1e-15);
    bytes =
        file(false, false, &[&grey(32, 3, 1)[..], &[(42113, 2, u32::from(b'6'))]].concat(), &floats(false));
    assert!(only(read(&bytes)).4[5].is_nan());
}

#[test]
fn physical_sizes_of_ome_are_micrometres_unless_they_have_a_unit() {
    let text = "<?xml?><OME xmlns='x'><Image><Pixels Type=\"float\" PhysicalSizeX='0.25' PhysicalSizeY=\"500\" PhysicalSizeYUnit=\"nm\"/>";
    assert_eq!([ome(text, 'X'), ome(text, 'Y'), ome(text, 'Z')], [Some(2.5e-7), Some(500.0 * 1e-9), None]);
    assert_eq!(ome("<OME><Pixels PhysicalSizeX=\"-\">", 'X'), None);
}
