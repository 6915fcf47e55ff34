use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, heights, only, upwards,
    whole,
};
use super::*;

/// Returns a file of 3 × 2 samples over 3 × 4 µm, from the lower right corner on.
fn file(kind: &str, number: Number) -> Vec<u8> {
    let rest = format!(
        "\r\n[Control]\r\n\r\n    X Amplitude: 3 \u{b5}m\r\n    Y Amplitude: 40000 \u{c5}\r\n\r\n[General Info]\r\n\r\n    Acquisition channel: \
         Topography\r\n    Image Data Type: {kind}\r\n    Number of columns: 3\r\n    Number of rows: 2\r\n    Z Amplitude: 10 nm\r\n\r\n\
         [Miscellaneous]\r\n\r\n    Maximum: 6\r\n    Minimum: 1\r\n\r\n[Header end]\r\n"
    );
    let rest: Vec<u8> = rest.chars().map(|c| c as u8).collect();
    let first = "WSxM file copyright Nanotec Electronica\r\nSxM Image file\r\nImage header size: ";
    let length = first.len() + "1234\r\n".len() + rest.len();
    let mut rows = upwards();
    rows.chunks_mut(3).for_each(<[f64]>::reverse);
    [format!("{first}{length:4}\r\n").as_bytes(), &rest, &encoded(number, Order::Little, &rows)].concat()
}

#[test]
fn integers_span_the_amplitude_and_floats_have_its_unit() {
    for (kind, number, unit) in [
        ("short", Number::I16, 2e-9),
        ("integer", Number::I16, 2e-9),
        ("float", Number::F32, 1e-9),
        ("double", Number::F64, 1e-9),
    ] {
        let bytes = file(kind, number);
        let (samples, spacing) = heights(super::super::recognise(&bytes, "stp"));
        assert_rows(&samples, unit);
        assert_close(spacing, [1e-6, 2e-6]);
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn other_channels_and_curves_are_told_and_damaged_files_survive() {
    let bytes = file("short", Number::I16);
    assert_seed(&FORMAT, "short.top", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
    let text: String = bytes.iter().map(|b| char::from(*b)).collect();
    let changed = |from: &str, to: &str| text.replace(from, to).chars().map(|c| c as u8).collect::<Vec<u8>>();
    let volts = changed("10 nm", "10 V ");
    assert_eq!(only(read(&volts)).0, "V");
    let curve = changed("SxM Image file", "SxM Cur_e file");
    assert!(read(&curve).err().unwrap().to_string().contains("curves"));
}
