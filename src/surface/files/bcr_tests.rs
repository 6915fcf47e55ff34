use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, downwards, encoded, heights,
    whole,
};
use super::*;

/// Returns a file whose header has `length` characters, of `width` bytes each.
fn file(lines: &str, length: usize, width: usize, data: &[u8]) -> Vec<u8> {
    let mut text =
        format!("{lines}xpixels = 3\nypixels = 2\nxlength = 3000\nylength = 4\nyunit = um\n%comment = 1\n");
    text.extend(std::iter::repeat_n(' ', length - text.chars().count()));
    let text: Vec<u8> = text.encode_utf16().flat_map(|unit| unit.to_le_bytes()[..width].to_vec()).collect();
    [&text[..], data].concat()
}

#[test]
fn integers_and_floats_of_both_orders_are_read() {
    let rows = downwards();
    let shorts = |order| encoded(Number::I16, order, &rows);
    let floats = encoded(Number::F32, Order::Big, &rows);
    for bytes in [
        file("fileformat = bcrstm\nbit2nm = 2\n", 2048, 1, &shorts(Order::Little)),
        file(
            "fileformat = bcrstm\nbit2nm = 2\nintelmode = 0\nheadersize = 300\n",
            300,
            1,
            &shorts(Order::Big),
        ),
        file("fileformat = bcrstm_unicode\nbit2nm = 2\n", 2048, 2, &shorts(Order::Little)),
        file("fileformat = bcrf\nintelmode = 0\nzmin = 2\nbit2nm = 9\n", 2048, 1, &floats),
        file("\u{feff}fileformat = bcrstm_unicode\nbit2nm = 2\n", 2048, 2, &shorts(Order::Little)),
    ] {
        let (samples, spacing) = heights(super::super::recognise(&bytes, "bcr"));
        let is_float = bytes.starts_with(b"fileformat = bcrf\n");
        let samples: Vec<f64> = samples.iter().map(|h| if is_float { h - 1e-9 } else { h / 2.0 }).collect();
        let rounded: Vec<f64> = samples.iter().map(|h| (h * 1e12).round()).collect();
        assert_rows(&rounded, 1e3);
        assert_close(spacing, [1e-6, 2e-6]);
        assert_survives(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn gaps_are_known_where_the_header_counts_them() {
    let mut rows = downwards();
    rows[2] = INVALID;
    let data = encoded(Number::I16, Order::Little, &rows);
    let bytes = file("fileformat = bcrstm\nvoidpixels = 1\n", 2048, 1, &data);
    let (samples, _) = heights(read(&bytes));
    assert!(samples[2].is_nan() && samples[0] == 1e-9);
    assert_seed(&FORMAT, "gaps.bcr", &bytes);
    assert_robust(&bytes, |b| whole(read(b)));
    let (samples, _) = heights(read(&file("fileformat = bcrstm\n", 2048, 1, &data)));
    assert_eq!(samples[2], INVALID * 1e-9);
}
