use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, encoded, heights, upwards, whole,
};
use super::*;

/// Returns a file of the blocks, with lengths of 32 bits in version 1.00 and of 64 bits in 1.01.
fn file(version: &str, blocks: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = [MAGIC, version.as_bytes(), &(blocks.len() as u16).to_le_bytes()].concat();
    for (tag, data) in blocks {
        bytes.extend(tag.to_le_bytes());
        bytes.extend((data.len() as u32).to_le_bytes());
        if version == "1.01" {
            bytes.extend([0; 4]);
        }
        bytes.extend(data);
    }
    bytes
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// Returns the blocks of a file of stored numbers, twice the heights in picometres.
fn blocks(number: Number, bits: u32) -> Vec<(u16, Vec<u8>)> {
    let stored: Vec<f64> = upwards().iter().map(|h| h * 2.0).collect();
    vec![
        (0x65, vec![0]),
        (COUNTS, words(&[3, 2, bits])),
        (SIDES, [3e-6_f64, 4e-6, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).chain([0; 4]).collect()),
        (FACTOR, [&[0; 4][..], &5e-13_f64.to_le_bytes()].concat()),
        (HEIGHTS, encoded(number, Order::Little, &stored)),
    ]
}

#[test]
fn both_versions_and_widths_are_read() {
    for (version, number, bits) in [("1.00", Number::U16, 16), ("1.01", Number::I32, 32)] {
        let bytes = file(version, &blocks(number, bits));
        let (samples, spacing) = heights(super::super::recognise(&bytes, "frt"));
        assert_rows(&samples, 1e-12);
        assert_close(spacing, [1e-6, 2e-6]);
        assert_survives(&bytes, |b| whole(read(b)));
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn sensors_have_their_names_and_intensities_are_left_out() {
    let mut all = blocks(Number::U16, 16);
    let (_, data) = all.pop().unwrap();
    let image = |kind: u32, data: &[u8]| [&words(&[kind, 3, 2, 16])[..], data].concat();
    let mut gap = data.clone();
    gap[..2].copy_from_slice(&[1, 0]);
    let sensors =
        [&[0; 8][..], &image(0x4, &data), &image(0x1, &data), &image(BOTTOM | 0x0100_0004, &gap)].concat();
    all.push((SENSORS, sensors));
    let bytes = file("1.00", &all);
    let mut scan = read(&bytes).unwrap();
    let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Topography (top sensor) 1", "Topography (bottom sensor) 2"]);
    let samples = scan.channels.pop().unwrap().samples().unwrap();
    assert!(samples[3].is_nan() && (samples[0] - 1e-12).abs() < 1e-24);
    assert_seed(&FORMAT, "sensors.frt", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
    assert!(read(&file("2.00", &all)).err().unwrap().to_string().contains("version 2.00"));
}
