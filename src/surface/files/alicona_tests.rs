use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, heights, whole,
};
use super::*;

/// Returns a file of rows of three samples, padded to four.
fn file(tags: &[(&str, &str)], rows: &[[f64; 4]; 2]) -> Vec<u8> {
    let tag = |name: &str, value: &str| {
        let (mut name, mut value) = (name.as_bytes().to_vec(), value.as_bytes().to_vec());
        name.resize(NAME, 0);
        value.resize(VALUE, 0);
        [&name[..], &value, b"\r\n"].concat()
    };
    let count = tags.len().to_string();
    let all = [("Version", "1"), ("TagCount", &count)].into_iter().chain(tags.iter().copied());
    let mut bytes = MAGIC.to_vec();
    all.for_each(|(name, value)| bytes.extend(tag(name, value)));
    // A comment ends the header.
    bytes.resize(bytes.len() + 254, 0);
    bytes.extend(b"\r\n");
    bytes.resize(DATA, 0);
    bytes.extend(encoded(Number::F32, Order::Little, rows.as_flattened()));
    bytes.truncate(bytes.len() - 4);
    bytes
}

/// Offset of the depth image.
const DATA: usize = 900;

const TAGS: [(&str, &str); 6] = [
    ("Cols", "3"),
    ("Rows", "2"),
    ("PixelSizeXMeter", "1e-6"),
    ("PixelSizeYMeter", "2e-6"),
    ("InvalidPixelValue", "3.000000028082e+15"),
    ("DepthImageOffset", "900"),
];

#[test]
fn rows_are_padded_and_invalid_samples_are_gaps() {
    let bytes = file(&TAGS, &[[1.0, 2.0, 3.0, 9.0], [4.0, 5.0, 6.0, 9.0]]);
    let (samples, spacing) = heights(super::super::recognise(&bytes, "al3d"));
    assert_rows(&samples, 1.0);
    assert_close(spacing, [1e-6, 2e-6]);
    let bytes = file(&TAGS, &[[1.0, 3e15, 3.0, 9.0], [f64::NAN, 5.0, 6.0, 9.0]]);
    let (samples, _) = heights(read(&bytes));
    assert!(samples[1].is_nan() && samples[3].is_nan() && samples[5] == 6.0);
    assert_seed(&FORMAT, "gaps.al3d", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
    assert_robust(&bytes, |b| whole(read(b)));
}

#[test]
fn pictures_without_depth_and_broken_tags_are_refused() {
    let rows = [[1.0, 2.0, 3.0, 9.0]; 2];
    let mut tags = TAGS;
    tags[5].1 = "0";
    assert!(read(&file(&tags, &rows)).err().unwrap().to_string().contains("picture"));
    tags[5].1 = "18446744073709551615";
    assert!(read(&file(&tags, &rows)).is_err());
    let mut bytes = file(&TAGS, &rows);
    bytes[MAGIC.len() + NAME + VALUE] = b'x';
    assert!(read(&bytes).err().unwrap().to_string().contains("`Version`"));
}
