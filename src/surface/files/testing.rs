//! Helpers of the tests of all readers.

use super::bytes::{Number, Order};
use super::format::Format;
use super::scan::{Quantity, Scan};
use crate::error::Result;
use crate::random::Random;
use std::fs;
use std::path::Path;

/// Three samples wide, two rows high, and no two alike, so that every flip and every exchange shows. Row by row from the top.
pub const TOP: [f64; 3] = [1.0, 2.0, 3.0];
/// The second row.
pub const BOTTOM: [f64; 3] = [4.0, 5.0, 6.0];

/// Returns both rows with the lower one first, as many instruments store them.
pub fn upwards() -> Vec<f64> {
    [BOTTOM, TOP].concat()
}

/// Returns both rows with the upper one first.
pub fn downwards() -> Vec<f64> {
    [TOP, BOTTOM].concat()
}

/// Returns the bytes of `values` as stored numbers.
pub fn encoded(number: Number, order: Order, values: &[f64]) -> Vec<u8> {
    let bytes = |x: &f64| {
        let mut bytes = match number {
            Number::F32 => (*x as f32).to_le_bytes().to_vec(),
            Number::F64 => x.to_le_bytes().to_vec(),
            _ => (*x as i64).to_le_bytes()[..number.bytes()].to_vec(),
        };
        if order == Order::Big {
            bytes.reverse();
        }
        bytes
    };
    values.iter().flat_map(bytes).collect()
}

/// Returns samples and distances of the single channel of `scan`, after asserting that it is a height of three by two samples.
#[track_caller]
pub fn heights(scan: Result<Scan>) -> (Vec<f64>, [f64; 2]) {
    let (_, quantity, size, spacing, samples) = only(scan);
    assert_eq!((quantity, size), (Quantity::Height, [3, 2]));
    (samples, spacing.map(Option::unwrap))
}

/// Asserts that lengths are equal to nine digits.
#[track_caller]
pub fn assert_close(found: [f64; 2], expected: [f64; 2]) {
    assert!(
        found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9),
        "{found:?} is not {expected:?}"
    );
}

/// Returns unit, quantity, size, distances and samples of the single channel of `scan`.
#[track_caller]
pub fn only(scan: Result<Scan>) -> (String, Quantity, [usize; 2], [Option<f64>; 2], Vec<f64>) {
    let mut scan = scan.unwrap();
    assert_eq!(scan.channels.len(), 1);
    let channel = scan.channels.remove(0);
    let (unit, quantity, size, spacing) =
        (channel.unit.clone(), channel.quantity, channel.size, channel.spacing);
    (unit, quantity, size, spacing, channel.samples().unwrap())
}

/// Asserts that `samples` are both rows, each times `unit`.
#[track_caller]
pub fn assert_rows(samples: &[f64], unit: f64) {
    let expected: Vec<f64> = TOP.iter().chain(&BOTTOM).map(|x| x * unit).collect();
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * b.abs();
    assert!(
        samples.len() == 6 && samples.iter().zip(&expected).all(close),
        "{samples:?} is not {expected:?}"
    );
}

/// Asserts that every shorter part of `bytes` is refused, and that no change of one byte makes `read` panic.
#[track_caller]
pub fn assert_robust(bytes: &[u8], read: impl Fn(&[u8]) -> Result<()>) {
    read(bytes).unwrap();
    for length in 0..bytes.len() {
        let e = read(&bytes[..length])
            .expect_err(&format!("{length} of {} bytes are enough", bytes.len()))
            .to_string();
        assert!(e.contains("; "), "{e}");
    }
    for i in 0..bytes.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut damaged = bytes.to_vec();
            damaged[i] ^= change;
            let _ = read(&damaged);
        }
    }
}

/// Reads all samples of all channels.
pub fn whole(scan: Result<Scan>) -> Result<()> {
    scan?.channels.into_iter().try_for_each(|channel| channel.samples().map(drop))
}

/// Asserts that `bytes` are the fuzzer's seed `file` of a format of the program, which `DIFFRACT_BLESS=1` writes.
#[track_caller]
pub fn assert_seed(format: &Format, file: &str, bytes: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(format.name);
    if std::env::var_os("DIFFRACT_BLESS").is_some() {
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(file), bytes).unwrap();
    }
    let seed = fs::read(folder.join(file)).unwrap();
    assert!(seed == bytes, "{file} is another file; DIFFRACT_BLESS=1 writes it");
}

/// Asserts that `read` reads `bytes`, and that it reads or refuses in a line what is left of them when they are cut at every hundredth
/// byte, and when up to four bytes are changed in a thousand ways.
#[track_caller]
pub fn assert_survives(bytes: &[u8], read: impl Fn(&[u8]) -> Result<()>) {
    read(bytes).unwrap();
    let check = |bytes: &[u8]| {
        if let Err(e) = read(bytes) {
            let line = e.to_string();
            assert!(line.contains("; ") && !line.contains('\n'), "{line}");
        }
    };
    (0..bytes.len()).step_by(100).for_each(|length| check(&bytes[..length]));
    let mut random = Random::new(7);
    for _ in 0..1000 {
        let mut damaged = bytes.to_vec();
        for _ in 0..1 + (4.0 * random.share()) as usize {
            let place = (random.share() * bytes.len() as f64) as usize;
            damaged[place] = (256.0 * random.share()) as u8;
        }
        check(&damaged);
    }
}
