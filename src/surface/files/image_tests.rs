use super::super::{ReadSettings, read as read_file};
use super::*;
use crate::error::Remedy;
use crate::task::Task;
use ::image::{self, GrayImage, ImageBuffer, Luma, RgbImage, Rgba};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const PIXEL: [f64; 2] = [0.1, 0.1];

/// Reads the image at `path` as a height field.
fn read(path: &Path, pixel_size: [f64; 2], full_height: f64) -> Result<HeightField> {
    read_file(
        path,
        &ReadSettings { pixel_size: Some(pixel_size), height: Some(full_height), channel: None },
        &Task::silent(),
    )?
    .into_field()
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn refusal(path: &Path) -> String {
    let e = read(path, PIXEL, 1.0).unwrap_err();
    let text = e.to_string();
    assert!(!text.contains('\n') && text.contains("; "), "{text}");
    assert!(text.starts_with(&path.display().to_string()), "{text}");
    text
}

/// Returns a slope to the right with one high sample in the top left corner, so that every flip shows.
fn lopsided() -> HeightField {
    let mut heights: Vec<f64> = (0..12 * 7).map(|i| -0.3 + 0.01 * (i % 12) as f64).collect();
    heights[0] = 0.2;
    HeightField::new(12, 7, PIXEL, heights).unwrap()
}

/// Returns a PNG chunk with its check sum.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&kind[..], data].concat();
    let mut crc = !0_u32;
    for byte in &body {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
        }
    }
    [&(data.len() as u32).to_be_bytes()[..], &body, &(!crc).to_be_bytes()].concat()
}

fn png_header(columns: u32, rows: u32, bits: u8, colour: u8) -> Vec<u8> {
    let size = [columns.to_be_bytes(), rows.to_be_bytes()].concat();
    let ihdr = chunk(b"IHDR", &[&size[..], &[bits, colour, 0, 0, 0]].concat());
    [&b"\x89PNG\r\n\x1a\n"[..], &ihdr].concat()
}

/// Returns a zlib stream of one stored block.
fn stored(data: &[u8]) -> Vec<u8> {
    let (mut a, mut b) = (1_u32, 0_u32);
    for byte in data {
        a = (a + u32::from(*byte)) % 65521;
        b = (b + a) % 65521;
    }
    let length = data.len() as u16;
    let head = [&[0x78, 0x01, 1][..], &length.to_le_bytes(), &(!length).to_le_bytes()].concat();
    [&head[..], data, &(b << 16 | a).to_be_bytes()].concat()
}

/// Returns an uncompressed little-endian TIFF of one strip: entries of tag, type, count and value.
fn tiff(columns: u32, rows: u32, bits: u32, format: u32, data: &[u8]) -> Vec<u8> {
    let entries: [(u16, u32); 10] = [
        (256, columns),
        (257, rows),
        (258, bits),
        (259, 1),
        (262, 1),
        (273, 8 + 2 + 10 * 12 + 4),
        (277, 1),
        (278, rows),
        (279, data.len() as u32),
        (339, format),
    ];
    let mut bytes = b"II*\0\x08\0\0\0\x0a\0".to_vec();
    for (tag, value) in entries {
        let long = [tag.to_le_bytes(), 4_u16.to_le_bytes()].concat();
        bytes.extend([&long[..], &1_u32.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    [&bytes[..], &[0; 4], data].concat()
}

#[test]
fn what_is_written_is_read_back_to_half_a_code_and_not_flipped() {
    let folder = folder();
    let field = lopsided();
    for name in ["a.png", "a.tif", "A.TIFF"] {
        let path = folder.path().join(name);
        let full_height = write(&path, &field).unwrap();
        assert!((full_height - 0.5).abs() < 1e-15);
        let back = read(&path, PIXEL, full_height).unwrap();
        assert_eq!((back.columns(), back.rows()), (12, 7));
        for (a, b) in field.heights().iter().zip(back.heights()) {
            assert!((a + 0.3 - b).abs() <= 0.5 / 65535.0 * full_height * 1.000_001, "{a} {b}");
        }
        let worst = |other: &HeightField| {
            let pairs = field.heights().iter().zip(other.heights());
            pairs.fold(0.0_f64, |m, (a, b)| m.max((a + 0.3 - b).abs()))
        };
        let upside_down: Vec<f64> = (0..7).rev().flat_map(|r| back.row(r).to_vec()).collect();
        assert!(worst(&HeightField::new(12, 7, PIXEL, upside_down).unwrap()) > 0.1);
    }
}

#[test]
fn a_flat_field_is_code_zero_of_full_height_zero() {
    let folder = folder();
    let path = folder.path().join("flat.png");
    let field = HeightField::new(3, 2, PIXEL, vec![7.5; 6]).unwrap();
    assert_eq!(write(&path, &field).unwrap(), 0.0);
    assert_eq!(read(&path, PIXEL, 0.0).unwrap().heights(), [0.0; 6]);
    assert_eq!(read(&path, PIXEL, 1.0).unwrap().heights(), [0.0; 6]);
}

#[test]
fn black_is_zero_and_the_largest_code_of_each_depth_is_the_full_height() {
    let folder = folder();
    let path = folder.path().join("image.dat"); // the content tells the format
    let eight = GrayImage::from_raw(3, 1, vec![0, 51, 255]).unwrap();
    let sixteen: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_raw(3, 1, vec![0_u16, 13107, 65535]).unwrap();
    for picture in [DynamicImage::from(eight), DynamicImage::from(sixteen)] {
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            picture.save_with_format(&path, format).unwrap();
            let field = read(&path, PIXEL, 0.5).unwrap();
            for (h, expected) in field.heights().iter().zip([0.0, 0.1, 0.5]) {
                assert!((h - expected).abs() < 1e-15, "{h}");
            }
        }
    }
}

#[test]
fn equal_channels_are_grey_whatever_the_alpha_and_unequal_ones_are_named() {
    let folder = folder();
    let path = folder.path().join("colour.png");
    let mut picture: ImageBuffer<Rgba<u16>, _> = ImageBuffer::from_pixel(4, 3, Rgba([9, 9, 9, 3]));
    picture.save(&path).unwrap();
    assert!((read(&path, PIXEL, 65535.0).unwrap().heights()[5] - 9.0).abs() < 1e-12);
    picture.put_pixel(2, 1, Rgba([9, 10, 9, 3]));
    picture.save(&path).unwrap();
    let e = refusal(&path);
    assert!(e.contains("column 2, row 1") && e.contains("9, 10, 9"), "{e}");
    RgbImage::from_pixel(2, 2, image::Rgb([1, 2, 3])).save(folder.path().join("c.tif")).unwrap();
    assert!(refusal(&folder.path().join("c.tif")).contains("column 0, row 0"));
}

#[test]
fn low_bit_depths_and_palettes_of_greys_are_grey() {
    let folder = folder();
    let finish = |head: Vec<u8>, rest: &[&[u8]]| [&head[..], &rest.concat(), &chunk(b"IEND", &[])].concat();
    // Two bits: codes 0, 1, 2, 3 of 3; the palette: black, a grey of 51, white.
    let two = finish(png_header(4, 1, 2, 0), &[&chunk(b"IDAT", &stored(&[0, 0b0001_1011]))]);
    let field = read(&file(&folder, "two.png", &two), PIXEL, 3.0).unwrap();
    assert!(field.heights().iter().zip(0..).all(|(h, i)| (h - f64::from(i)).abs() < 1e-12));
    let colours = chunk(b"PLTE", &[0, 0, 0, 51, 51, 51, 255, 255, 255]);
    let palette = finish(png_header(3, 1, 8, 3), &[&colours, &chunk(b"IDAT", &stored(&[0, 2, 1, 0]))]);
    let field = read(&file(&folder, "palette.png", &palette), PIXEL, 5.0).unwrap();
    assert!(field.heights().iter().zip([5.0, 1.0, 0.0]).all(|(h, e)| (h - e).abs() < 1e-12));
}

#[test]
fn what_is_no_image_file_is_refused_before_it_is_read() {
    let folder = folder();
    assert!(refusal(&folder.path().join("none.png")).contains("no such file"));
    assert!(refusal(folder.path()).contains("folder"));
    assert!(refusal(&file(&folder, "empty.png", b"")).contains("empty"));
    assert!(refusal(&file(&folder, "text.png", b"not an image")).contains("neither"));
    assert!(refusal(&file(&folder, "one.png", b"\x89")).contains("neither"));
    #[cfg(unix)]
    assert!(refusal(Path::new("/dev/zero")).contains("not a regular file"));
}

#[test]
fn every_truncation_is_an_error() {
    let folder = folder();
    for name in ["whole.png", "whole.tif"] {
        let path = folder.path().join(name);
        write(&path, &lopsided()).unwrap();
        let bytes = fs::read(&path).unwrap();
        for length in 1..bytes.len() - 12 {
            // The last 12 bytes of a PNG are its end mark, without heights.
            let cut = file(&folder, "cut", &bytes[..length]);
            if name == "whole.png" {
                refusal(&cut);
            } else {
                let _ = read(&cut, PIXEL, 1.0); // TIFF readers may find all they need; they must not panic
            }
        }
    }
}

#[test]
fn every_damaged_byte_is_an_error_or_heights_but_never_a_panic() {
    let folder = folder();
    for name in ["whole.png", "whole.tif"] {
        let path = folder.path().join(name);
        write(&path, &lopsided()).unwrap();
        let bytes = fs::read(&path).unwrap();
        for i in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[i] ^= flip;
                if let Ok(field) = read(&file(&folder, "damaged", &damaged), PIXEL, 1.0) {
                    assert!(field.heights().iter().all(|h| (0.0..=1.0).contains(h)));
                }
            }
        }
    }
}

#[test]
fn a_bomb_is_refused_by_its_header() {
    let folder = folder();
    let e = refusal(&file(&folder, "wide.png", &png_header(100_000, 1, 8, 0)));
    assert!(e.contains("16384"), "{e}");
    refusal(&file(&folder, "huge.png", &png_header(u32::MAX, u32::MAX, 16, 6)));
    refusal(&file(&folder, "zero.png", &png_header(0, 4, 8, 0)));
    let e = refusal(&file(&folder, "wide.tif", &tiff(100_000, 1, 8, 1, &[0; 8])));
    assert!(e.contains("16384"), "{e}");
    refusal(&file(&folder, "zero.tif", &tiff(0, 1, 8, 1, &[])));
    refusal(&file(&folder, "short.tif", &tiff(16_000, 16_000, 16, 1, &[0; 8])));
}

#[test]
fn an_orientation_that_a_png_asks_for_is_applied() {
    let folder = folder();
    // Exif with one entry: orientation 6, the stored picture is to be turned clockwise.
    let exif = [&b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01"[..], &[0, 6, 0, 0, 0, 0, 0, 0]].concat();
    let data = chunk(b"IDAT", &stored(&[0, 1, 2, 3, 0, 4, 5, 6]));
    let bytes =
        |rest: &[Vec<u8>]| [&png_header(3, 2, 8, 0)[..], &rest.concat(), &chunk(b"IEND", &[])].concat();
    let plain = read(&file(&folder, "plain.png", &bytes(std::slice::from_ref(&data))), PIXEL, 255.0).unwrap();
    assert_eq!((plain.columns(), plain.rows(), plain.heights()[0].round()), (3, 2, 1.0));
    let turned =
        read(&file(&folder, "turned.png", &bytes(&[chunk(b"eXIf", &exif), data])), PIXEL, 255.0).unwrap();
    let codes: Vec<f64> = turned.heights().iter().map(|h| h.round()).collect();
    assert_eq!((turned.columns(), turned.rows(), codes), (2, 3, vec![4.0, 1.0, 5.0, 2.0, 6.0, 3.0]));
}

#[test]
fn float_samples_are_heights_and_wide_integers_are_codes() {
    let folder = folder();
    let data = [0.5e-6_f32.to_le_bytes(), 1.0e-6_f32.to_le_bytes()].concat();
    let settings = ReadSettings { pixel_size: Some(PIXEL), height: None, channel: None };
    let float = file(&folder, "float.tif", &tiff(2, 1, 32, 3, &data));
    let heights = read_file(&float, &settings, &Task::silent()).unwrap().into_field().unwrap();
    assert!((heights.heights()[0] - 0.5).abs() < 1e-7 && (heights.heights()[1] - 1.0).abs() < 1e-7);
    let codes = [0_u32.to_le_bytes(), u32::MAX.to_le_bytes()].concat();
    let long = file(&folder, "long.tif", &tiff(2, 1, 32, 1, &codes));
    assert_eq!(read(&long, PIXEL, 0.5).unwrap().heights(), [0.0, 0.5]);
    assert_eq!(read_file(&long, &settings, &Task::silent()).unwrap_err().remedies(), [Remedy::FullHeight]);
}

#[test]
fn wrong_names_lengths_and_places_leave_nothing_behind() {
    let folder = folder();
    let field = lopsided();
    for name in ["a.jpg", "a", "png"] {
        assert_eq!(write(&folder.path().join(name), &field).unwrap_err().kind(), error::ErrorKind::Usage);
    }
    assert!(write(&folder.path().join("no/a.png"), &field).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let path = folder.path().join("a.png");
    write(&path, &field).unwrap();
    for full_height in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(read(&path, PIXEL, full_height).unwrap_err().kind(), error::ErrorKind::Usage);
    }
    assert!(read(&path, [0.0, 1.0], 1.0).is_err());
}
