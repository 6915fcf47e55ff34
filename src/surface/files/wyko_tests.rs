use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, heights, whole,
};
use super::*;

/// Returns a file of the blocks, each of a name, a type and its bytes.
fn file(blocks: &[(&str, u16, Vec<u8>)]) -> Vec<u8> {
    let entry = |name: &str, kind: u16, length: usize| {
        let mut entry = name.as_bytes().to_vec();
        entry.resize(NAME, 0);
        [&entry[..], &kind.to_le_bytes(), &(length as u32).to_le_bytes(), &[0xff, 0xff]].concat()
    };
    let mut bytes = vec![1, 0];
    bytes.extend(entry("Directory", 1, (blocks.len() + 1) * ENTRY));
    for (name, kind, data) in blocks {
        bytes.extend(entry(name, *kind, data.len()));
    }
    blocks.iter().for_each(|(_, _, data)| bytes.extend(data));
    bytes
}

/// Returns the blocks of a file of heights, stored column by column, each from the bottom.
fn blocks(number: Number, values: &[f64]) -> Vec<(&'static str, u16, Vec<u8>)> {
    let float = |x: f32| x.to_le_bytes().to_vec();
    let array =
        [&[3, 0, 2, 0, number.bytes() as u8, 0][..], &encoded(number, Order::Little, values)].concat();
    vec![
        ("Mult", 6, vec![4, 0]),
        ("RAW_DATA", ARRAY, array),
        ("Image", ARRAY, vec![3, 0, 2, 0, 1, 0, 9, 9, 9, 9, 9, 9]),
        ("Title", 5, b"A sample\0\0".to_vec()),
        ("Aspect", 7, float(2.0)),
        ("Pixel_size", 7, float(2.0_f32.powi(-10))),
        ("Wavelength", 7, float(8.0)),
        ("", 0, Vec::new()),
    ]
}

const COLUMNS: [f64; 6] = [4.0, 1.0, 5.0, 2.0, 6.0, 3.0];

#[test]
fn columns_from_the_bottom_become_rows_from_the_top() {
    for number in [Number::U8, Number::I16, Number::F32] {
        let bytes = file(&blocks(number, &COLUMNS));
        let (samples, spacing) = heights(super::super::recognise(&bytes, "opd"));
        assert_rows(&samples, 2e-9);
        assert_close(spacing, [1e-3 / 1024.0, 2e-3 / 1024.0]);
        assert_survives(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn invalid_samples_are_gaps_and_a_missing_scale_is_told() {
    for (number, invalid) in [(Number::I16, 32_767.0), (Number::F32, 1e38)] {
        let mut values = COLUMNS;
        values[0] = invalid;
        let (samples, _) = heights(read(&file(&blocks(number, &values))));
        assert!(samples[3].is_nan() && samples[0] == 2e-9);
    }
    let mut bare = blocks(Number::I16, &COLUMNS);
    assert_eq!(read(&file(&bare)).unwrap().channels[0].name, "A sample");
    let bytes = file(&bare);
    assert_seed(&FORMAT, "short.opd", &bytes);
    assert_robust(&bytes, |b| whole(read(b)));
    bare.remove(6);
    assert!(read(&file(&bare)).err().unwrap().to_string().contains("wavelength"));
}
