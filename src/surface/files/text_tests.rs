use super::super::testing::{BOTTOM, TOP, assert_rows, only};
use super::super::topography::Spacing;
use super::*;

const ROWS: &str = "1 2 3\n4 5 6\n";

#[test]
fn gwyddions_header_is_understood_in_any_language() {
    for head in [
        "# Channel: Topo\n# Width: 3 \u{b5}m\n# Height: 4000 nm\n# Value units: nm\n",
        "# Kanal: Topo\n# Breite: 3,0 \u{b5}m\n# H\u{f6}he: 4000 nm\n# Einheiten: nm\n",
    ] {
        let text = format!("{head}{ROWS}");
        let (unit, quantity, size, spacing, samples) = only(read(text.as_bytes()));
        assert_eq!((unit.as_str(), quantity, size), ("nm", Quantity::Height, [3, 2]));
        let [x, y] = spacing.map(Option::unwrap);
        assert!((x - 1e-6).abs() < 1e-18 && (y - 2e-6).abs() < 1e-18);
        assert_rows(&samples, 1e-9);
        // The same in Latin-1.
        let latin: Vec<u8> = text.chars().map(|c| c as u32 as u8).collect();
        assert_rows(&only(read(&latin)).4, 1e-9);
    }
    let volts = only(read(format!("# A: B\n# C: 1 m\n# D: 1 m\n# E: V\n{ROWS}").as_bytes()));
    assert_eq!(volts.1, Quantity::Other);
}

#[test]
fn a_bare_matrix_is_in_metres_and_has_no_distances() {
    let (_, quantity, _, spacing, samples) = only(read(ROWS.as_bytes()));
    assert_eq!((quantity, spacing), (Quantity::Height, [None, None]));
    assert_rows(&samples, 1.0);
}

#[test]
fn a_table_with_named_columns_is_no_matrix() {
    assert!(read(b"theta,phi,power\n1,2,3\n").err().unwrap().to_string().contains("named columns"));
    assert!(read(b"heights of a scan\n1,2,3\n").is_ok(), "a title of the whole");
}

#[test]
fn what_is_written_is_read_back_to_the_last_bit_with_its_gaps() {
    let mut heights: Vec<f64> = TOP.iter().chain(&BOTTOM).map(|h| h / 3.0 * 1e-7).collect();
    heights[4] = f64::NAN;
    let scan =
        Topography::new([3, 2], Spacing::Metres([7.843e-9, 1e-8]), heights.clone(), 1e6, None).unwrap();
    let mut bytes = Vec::new();
    write(&scan, &Notes::default(), &mut bytes).unwrap();
    let (_, _, size, spacing, samples) = only(read(&bytes));
    assert_eq!(size, [3, 2]);
    assert!((spacing[0].unwrap() / 7.843e-9 - 1.0).abs() < 1e-15);
    assert!(samples.iter().zip(&heights).all(|(a, b)| a == b || a.is_nan() && b.is_nan()));
}

#[test]
fn three_columns_that_are_a_grid_of_points_are_no_matrix() {
    let point = |i: usize| format!("{}e-7 {}e-7 {}e-9\n", i / 4, i % 4, i);
    let text: String = (0..12).map(point).collect();
    let scan = read(text.as_bytes()).unwrap();
    assert!(scan.notes[0].contains("points"), "{:?}", scan.notes);
    let (_, quantity, size, spacing, _) = only(Ok(scan));
    assert_eq!((quantity, size), (Quantity::Height, [3, 4]));
    assert!((spacing[0].unwrap() - 1e-7).abs() < 1e-20);
    // Rows of three heights are a matrix.
    assert_eq!(only(read(b"1 2 3\n4 5 6\n7 8 9\n1 2 4\n")).2, [3, 4]);
}

#[test]
fn files_of_wyko_are_refused_whatever_their_blocks_hold() {
    let refused = read(b"Wyko ASCII Data File Format\t0\t1\t1\nX Size\t2\n1\t2\n3\t4\n").err().unwrap();
    assert!(refused.to_string().contains("Wyko"), "{refused}");
}
