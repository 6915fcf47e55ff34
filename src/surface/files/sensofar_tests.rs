use super::super::testing::{
    BOTTOM, TOP, assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, heights,
    whole,
};
use super::*;

/// Returns a file of `layers`, each with one picture behind it.
fn file(kind: u32, layers: &[&[f64]]) -> Vec<u8> {
    let mut bytes = vec![0; DATA];
    let mut put = |place: usize, field: &[u8]| bytes[place..place + field.len()].copy_from_slice(field);
    put(0, b"Mon Apr 19 11:40:13 2021");
    put(COUNTS, &[2, 0, 0, 0, 3]);
    put(SPACINGS, &0.5_f32.to_le_bytes());
    put(SPACINGS + 4, &0.25_f32.to_le_bytes());
    put(KIND, &kind.to_le_bytes());
    put(LAYERS, &[layers.len() as u8, 0, 0, 1]);
    for layer in layers {
        bytes.extend([2, 0, 0, 0, 3, 0, 0, 0]);
        bytes.extend(encoded(Number::F32, Order::Little, layer));
        bytes.extend([0; RANGE + 3 * 6]);
    }
    bytes
}

#[test]
fn layers_are_micrometres_and_are_known_without_magic_bytes() {
    let rows = [TOP, BOTTOM].concat();
    let bytes = file(TOPOGRAPHY, &[&rows]);
    let (samples, spacing) = heights(super::super::recognise(&bytes, "unknown"));
    assert_rows(&samples, 1e-6);
    assert_close(spacing, [5e-7, 2.5e-7]);
    let mut other = rows.clone();
    other[2] = INVALID;
    let bytes = file(TOPOGRAPHY, &[&rows, &other]);
    let mut scan = super::super::recognise(&bytes, "plu").unwrap();
    let second = scan.channels.pop().unwrap();
    assert_eq!((scan.channels.len(), second.name.as_str()), (1, "Topography (2)"));
    let samples = second.samples().unwrap();
    assert!(samples[2].is_nan() && (samples[5] - 6e-6).abs() < 1e-18);
    assert_seed(&FORMAT, "two.plu", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
}

#[test]
fn damaged_files_and_profiles_are_refused() {
    let rows = [TOP, BOTTOM].concat();
    let bytes = file(TOPOGRAPHY, &[&rows]);
    assert_robust(&bytes[..bytes.len() - RANGE - 18], |b| whole(read(b)));
    assert!(read(&file(1, &[&rows])).err().unwrap().to_string().contains("no topography"));
    assert!(!signature(b"Mon Apr 19") && !signature(&[0; 600]));
}
