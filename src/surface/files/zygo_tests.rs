use super::super::testing::{
    assert_close, assert_robust, assert_seed, assert_survives, downwards, encoded, heights, whole,
};
use super::*;

/// Returns a file of the `format` of the header, with two intensities and the phases `codes`.
fn file(format: u16, resolution: i16, sign: i16, codes: &[f64]) -> Vec<u8> {
    let length: usize = if format == 3 { 4096 } else { 834 };
    let mut bytes = vec![0; length];
    let mut put = |place: usize, field: &[u8]| bytes[place..place + field.len()].copy_from_slice(field);
    put(0, &[0x88, 0x1b, 0x03, 0x6e + format as u8]);
    put(4, &format.to_be_bytes());
    put(6, &(length as u32).to_be_bytes());
    put(52, &[0, 2, 0, 1, 0, 1]);
    put(60, &4_u32.to_be_bytes());
    put(68, &[0, 3, 0, 2]);
    put(72, &24_u32.to_be_bytes());
    put(164, &0.5_f32.to_be_bytes());
    put(168, &8.0_f32.to_be_bytes());
    put(176, &2.0_f32.to_be_bytes());
    put(184, &(2.0_f32).powi(-20).to_be_bytes());
    put(218, &resolution.to_be_bytes());
    put(SIGN, &sign.to_be_bytes());
    [bytes, vec![0; 4], encoded(Number::I32, Order::Big, codes)].concat()
}

#[test]
fn codes_of_every_resolution_are_parts_of_the_wavelength() {
    for (format, resolution, codes) in [(1, 0, 4096.0), (2, 1, 32_768.0), (3, 2, 131_072.0), (3, 1, 32_768.0)]
    {
        let bytes = file(format, resolution, 0, &downwards());
        let (samples, spacing) = heights(super::super::recognise(&bytes, "dat"));
        super::super::testing::assert_rows(&samples, 8.0 / codes);
        assert_close(spacing, [2.0_f64.powi(-20); 2]);
    }
    let (samples, _) = heights(read(&file(1, 0, 1, &downwards())));
    super::super::testing::assert_rows(&samples, -8.0 / 4096.0);
}

#[test]
fn invalid_codes_are_gaps_and_damaged_files_are_refused() {
    let mut codes = downwards();
    codes[1] = INVALID;
    codes[4] = INVALID + 7.0;
    let bytes = file(1, 1, 0, &codes);
    let (samples, _) = heights(read(&bytes));
    assert!(samples[1].is_nan() && samples[4].is_nan() && samples[0] == 8.0 / 32_768.0);
    assert_seed(&FORMAT, "gaps.dat", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
    assert_robust(&bytes, |b| whole(read(b)));
    assert!(read(&file(1, 3, 0, &codes)).err().unwrap().to_string().contains("resolution is 3"));
}
