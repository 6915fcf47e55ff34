use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, upwards, whole,
};
use super::*;

/// Returns a file of a height and a deflection.
fn file(kind: &str, number: Number) -> Vec<u8> {
    let text = format!(
        "fileType      Image\nversion       PicoView 0x10c04\nxPixels       3\nyPixels       2\nxLength       3.0e-006\nyLength       4.0e-006\n\
         scanUp        FALSE\nbufferLabel   Topography\nfilter        3rd_order\nbufferRange   {range}\nbufferUnit    nm\nbufferLabel   Deflection\n\
         bufferRange   1.0000000000000000e+001\nbufferUnit    V\ndata          {kind}\n",
        range = number.largest() + 1.0
    );
    let data = encoded(number, Order::Little, &upwards());
    [text.as_bytes(), &data, &data].concat()
}

#[test]
fn channels_have_their_ranges_and_begin_with_the_lowest_line() {
    for (kind, number) in [("BINARY", Number::I16), ("BINARY_32", Number::I32)] {
        let bytes = file(kind, number);
        let scan = super::super::recognise(&bytes, "mi").unwrap();
        let units: Vec<&str> = scan.channels.iter().map(|c| c.unit.as_str()).collect();
        assert_eq!(units, ["nm", "V"]);
        for (channel, unit) in scan.channels.into_iter().zip([1e-9, 10.0 / (number.largest() + 1.0)]) {
            assert_eq!(channel.size, [3, 2]);
            assert_close(channel.spacing.map(Option::unwrap), [1e-6, 2e-6]);
            assert_rows(&channel.samples().unwrap(), unit);
        }
        assert_survives(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn spectra_text_and_damaged_files_are_refused() {
    let bytes = file("BINARY", Number::I16);
    assert_seed(&FORMAT, "two.mi", &bytes);
    assert_robust(&bytes[..bytes.len() - 12], |b| whole(read(b)));
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let said = |from: &str, to: &str| read(text.replace(from, to).as_bytes()).err().unwrap().to_string();
    assert!(said("Image", "Spectroscopy").contains("spectra"));
    assert!(said("BINARY", "ASCII").contains("ASCII"));
    assert!(said("xPixels", "xPixel_").contains("xPixels"));
}
