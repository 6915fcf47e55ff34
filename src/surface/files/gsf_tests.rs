use super::super::scan::Quantity;
use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::super::topography::Spacing;
use super::*;

/// Returns a hand-made file: `header` lines, NUL up to a multiple of four, the floats.
fn file(header: &str, rows: &[f64]) -> Vec<u8> {
    let mut bytes = [MAGIC, header.as_bytes(), b"\0"].concat();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes.extend(rows.iter().flat_map(|h| (*h as f32).to_le_bytes()));
    bytes
}

fn rows(unit: f64) -> Vec<f64> {
    TOP.iter().chain(&BOTTOM).map(|h| h * unit).collect()
}

#[test]
fn a_field_by_hand_has_its_heights_and_units_whatever_the_padding() {
    for title in ["a", "ab", "abc", "abcd"] {
        let header = format!(
            "XRes = 3\nYRes = 2\nXReal = 3e-6\nYReal = 4e-6\nXYUnits = m\nZUnits = m\nTitle = {title}\n"
        );
        let bytes = file(&header, &rows(0.5));
        let (unit, quantity, size, spacing, samples) = only(read(&bytes));
        assert_eq!((unit.as_str(), quantity, size), ("m", Quantity::Height, [3, 2]));
        assert!((spacing[0].unwrap() - 1e-6).abs() < 1e-20 && (spacing[1].unwrap() - 2e-6).abs() < 1e-20);
        assert_rows(&samples, 0.5);
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn units_with_prefixes_and_missing_ones_are_what_they_say() {
    let (_, _, _, spacing, samples) =
        only(read(&file("XRes=3\nYRes=2\nXReal=3\nYReal=2\nXYUnits=\u{b5}m\nZUnits=nm\n", &rows(1.0))));
    assert!((spacing[0].unwrap() - 1e-6).abs() < 1e-20);
    assert_rows(&samples, 1e-9);
    let (_, quantity, _, spacing, _) = only(read(&file("XRes=3\nYRes=2\n", &rows(1.0))));
    assert_eq!((quantity, spacing), (Quantity::Other, [None, None]));
    assert!(read(&file("XRes=3\n", &rows(1.0))).is_err());
    assert!(read(&file("XRes=99999\nYRes=99999\n", &rows(1.0))).is_err(), "a header that lies");
    let holes = file("XRes=3\nYRes=2\nZUnits=m\n", &[1.0, f64::NAN, f64::INFINITY, 4.0, 5.0, 6.0]);
    assert_eq!(only(read(&holes)).4.iter().filter(|h| h.is_nan()).count(), 2);
}

#[test]
fn what_is_written_is_read_back_to_the_rounding_of_single_precision() {
    let scan = Topography::new([3, 2], Spacing::Metres([7.843e-9, 1e-8]), rows(1.0 / 3.0 * 1e-7), 1e6, None)
        .unwrap();
    let mut bytes = Vec::new();
    write(&scan, &Notes::default(), &mut bytes).unwrap();
    let (_, _, _, spacing, samples) = only(read(&bytes));
    assert!(
        (spacing[0].unwrap() / 7.843e-9 - 1.0).abs() < 1e-15
            && (spacing[1].unwrap() / 1e-8 - 1.0).abs() < 1e-15
    );
    assert!(samples.iter().zip(scan.metres()).all(|(a, b)| *a == f64::from(b as f32)));
}
