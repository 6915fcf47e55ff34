use super::super::testing::{
    assert_close, assert_rows, assert_seed, assert_survives, downwards, encoded, heights, whole,
};
use super::*;
use std::io::Write;

/// Returns a plain file of one or two images of heights.
fn file(magic: &[u8; 4], number: Number, images: usize) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    bytes.resize(12 + 18 * 4, 0);
    let put = |bytes: &mut Vec<u8>, place: usize, n: usize| {
        bytes[place..place + 4].copy_from_slice(&(n as u32).to_le_bytes());
    };
    let conditions = bytes.len();
    put(&mut bytes, CONDITIONS, conditions);
    bytes.resize(conditions + 312, 0);
    put(&mut bytes, conditions, 312);
    // Title and name of the lens, both without letters.
    let texts = bytes.len();
    put(&mut bytes, 76, texts);
    bytes.resize(texts + 8, 0);
    for (i, n) in [1_000_000, 2_000_000, 100].into_iter().enumerate() {
        put(&mut bytes, conditions + SCALES + 4 * i, n);
    }
    for offset in &HEIGHTS[..images] {
        let place = bytes.len();
        put(&mut bytes, *offset, place);
        let data = encoded(number, Order::Little, &downwards());
        for n in [3, 2, number.bytes() * 8, 0, data.len(), 0, 255] {
            bytes.extend((n as u32).to_le_bytes());
        }
        bytes.extend([0; PALETTE]);
        bytes.extend(data);
    }
    bytes
}

/// Returns the file as instruments of later series keep it: in a zip behind a picture.
fn packed(plain: &[u8]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file(MEMBER, zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(plain).unwrap();
    [b"VK6\x06\0\0\0BM-bmp", &zip.finish().unwrap().into_inner()[..]].concat()
}

#[test]
fn heights_of_all_widths_have_their_picometres() {
    for (magic, number) in [(b"VK3_", Number::U8), (b"VK4_", Number::U16), (b"VK4_", Number::U32)] {
        let plain = file(magic, number, 1);
        for bytes in [plain.clone(), packed(&plain)] {
            let (samples, spacing) = heights(super::super::recognise(&bytes, "vk4"));
            assert_rows(&samples, 1e-10);
            assert_close(spacing, [1e-6, 2e-6]);
        }
    }
    let two = file(b"VK4_", Number::U16, 2);
    let names: Vec<String> = read(&two).unwrap().channels.into_iter().map(|c| c.name).collect();
    assert_eq!(names, ["Height 0", "Height 1"]);
}

#[test]
fn damaged_files_are_read_or_refused() {
    let plain = file(b"VK4_", Number::U32, 1);
    let bytes = packed(&plain);
    assert_seed(&FORMAT, "plain.vk4", &plain);
    assert_seed(&FORMAT, "packed.vk6", &bytes);
    for bytes in [&plain, &bytes] {
        assert_survives(bytes, |b| whole(read(b)));
    }
    assert!(read(&plain[..plain.len() - 1]).is_err());
    assert!(read(&file(b"VK4_", Number::U8, 0)).err().unwrap().to_string().contains("no image"));
}
