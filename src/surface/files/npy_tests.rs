use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::super::topography::Spacing;
use super::*;

fn file(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

fn rows() -> impl Iterator<Item = f64> {
    TOP.into_iter().chain(BOTTOM)
}

#[test]
fn arrays_of_every_type_and_order_are_rows_from_the_top() {
    let columns = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0_f64];
    for (bytes, unit) in [
        (file("<f8", "False", "(2, 3)", &rows().flat_map(f64::to_le_bytes).collect::<Vec<u8>>()), 1.0),
        (file(">f8", "False", "(2, 3)", &rows().flat_map(f64::to_be_bytes).collect::<Vec<u8>>()), 1.0),
        (
            file(
                "<f4",
                "False",
                "(2, 3)",
                &rows().flat_map(|h| (h as f32).to_le_bytes()).collect::<Vec<u8>>(),
            ),
            1.0,
        ),
        (
            file("<f8", "True", "(2, 3)", &columns.iter().flat_map(|h| h.to_le_bytes()).collect::<Vec<u8>>()),
            1.0,
        ),
        (file("|u1", "False", "(2, 3)", &rows().map(|h| h as u8).collect::<Vec<u8>>()), 1.0 / 255.0),
        (
            file(
                ">i2",
                "False",
                "(2, 3)",
                &rows().flat_map(|h| (h as i16).to_be_bytes()).collect::<Vec<u8>>(),
            ),
            1.0 / 32767.0,
        ),
    ] {
        let (_, quantity, size, spacing, samples) = only(read(&bytes));
        assert_eq!((size, spacing), ([3, 2], [None, None]));
        assert_eq!(quantity == Quantity::Height, unit == 1.0);
        assert_rows(&samples, unit);
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn arrays_of_other_shapes_and_kinds_are_refused_in_words() {
    let said = |descr, shape| read(&file(descr, "False", shape, &[0; 64])).err().unwrap().to_string();
    assert!(said("<f8", "(2,)").contains("(2,)"));
    assert!(said("<f8", "(1, 2, 3)").contains("no image"));
    assert!(said("<c16", "(2, 2)").contains("c16"));
    assert!(said("|O", "(2, 2)").contains("plain numbers"));
    assert!(said("<f8", "(16000, 16000)").contains("cut short"));
    assert!(said("<f8", "(99999999999999999999, 1)").contains("damaged"));
    assert!(said("<f8", "(0, 4)").contains("empty"));
}

#[test]
fn what_is_written_is_read_back_to_the_last_bit() {
    let heights: Vec<f64> = rows().map(|h| h / 3.0 * 1e-7).collect();
    let scan = Topography::new([3, 2], Spacing::Metres([1e-8; 2]), heights.clone(), 1e6, None).unwrap();
    let mut bytes = Vec::new();
    write(&scan, &mut bytes).unwrap();
    assert_eq!(bytes.len(), 128 + 6 * 8, "data start at a multiple of 64");
    assert_eq!(only(read(&bytes)).4, heights);
}
