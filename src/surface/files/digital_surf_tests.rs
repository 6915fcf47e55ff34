use super::super::scan::Quantity;
use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::*;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Returns a hand-made header, numbers in `order`.
fn header(magic: &[u8], order: Order, bits: u16, zone: u16) -> Vec<u8> {
    let mut bytes = vec![b' '; HEADER];
    bytes[12..130].fill(0);
    bytes[276..HEADER].fill(0);
    bytes[..12].copy_from_slice(magic);
    let mut put = |place: usize, little: &[u8]| {
        let field = &mut bytes[place..place + little.len()];
        field.copy_from_slice(little);
        if order == Order::Big {
            field.reverse();
        }
    };
    put(12, &(if order == Order::Big { MACINTOSH } else { 0 }).to_le_bytes());
    put(14, &1_u16.to_le_bytes());
    put(18, &2_u16.to_le_bytes());
    put(86, &1_u16.to_le_bytes());
    put(98, &bits.to_le_bytes());
    put(100, &100_i32.to_le_bytes());
    put(104, &600_i32.to_le_bytes());
    put(108, &3_i32.to_le_bytes());
    put(112, &2_i32.to_le_bytes());
    put(116, &6_u32.to_le_bytes());
    put(120, &0.5_f32.to_le_bytes());
    put(124, &2.0_f32.to_le_bytes());
    put(128, &0.25_f32.to_le_bytes());
    put(334, &zone.to_le_bytes());
    bytes[180..182].copy_from_slice(b"\xb5m");
    bytes[196..198].copy_from_slice(b"um");
    bytes[212..214].copy_from_slice(b"nm");
    bytes[228..230].copy_from_slice(b"mm"); // the unit of an axis is another one
    bytes
}

fn samples(order: Order, bits: u16) -> Vec<u8> {
    let codes = TOP.iter().chain(&BOTTOM).map(|h| *h as i32 * 100);
    let bytes = codes.flat_map(|code| {
        let mut bytes = code.to_le_bytes()[..usize::from(bits / 8)].to_vec();
        if order == Order::Big {
            bytes.reverse();
        }
        bytes
    });
    bytes.collect()
}

#[test]
fn samples_of_both_widths_and_byte_orders_have_the_unit_of_their_step() {
    for (order, bits) in [(Order::Little, 16), (Order::Little, 32), (Order::Big, 16), (Order::Big, 32)] {
        let bytes = [header(MAGIC, order, bits, 5), b"hello".to_vec(), samples(order, bits)].concat();
        let (unit, quantity, size, spacing, heights) = only(read(&bytes));
        assert_eq!((unit.as_str(), quantity, size), ("nm", Quantity::Height, [3, 2]));
        assert_eq!(spacing, [Some(0.5e-6), Some(2e-6)]);
        assert_rows(&heights, 100.0 * 0.25 * 1e-9);
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn two_below_the_lowest_code_was_not_measured_if_the_flag_says_so() {
    let mut bytes = [header(MAGIC, Order::Little, 16, 0), samples(Order::Little, 16)].concat();
    bytes[HEADER..HEADER + 2].copy_from_slice(&98_i16.to_le_bytes());
    assert!(only(read(&bytes)).4[0].is_nan());
    bytes[86] = 0;
    assert_eq!(only(read(&bytes)).4[0], 98.0 * 0.25 * 1e-9);
}

fn packed(data: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

/// Returns a compressed file whose samples are in two streams; the first claims to hold `claimed` bytes.
fn compressed(claimed: usize) -> Vec<u8> {
    let data = samples(Order::Little, 32);
    let streams = [packed(&data[..10]), packed(&data[10..])];
    let lengths = [claimed, streams[0].len(), data.len() - 10, streams[1].len()];
    let directory: Vec<u8> = lengths.iter().flat_map(|n| (*n as u32).to_le_bytes()).collect();
    let head = header(COMPRESSED_MAGIC, Order::Little, 32, 0);
    [head, 2_u32.to_le_bytes().to_vec(), directory, streams.concat()].concat()
}

#[test]
fn compressed_samples_are_those_of_their_streams() {
    assert_rows(&only(read(&compressed(10))).4, 100.0 * 0.25 * 1e-9);
    assert_robust(&compressed(10), |b| whole(read(b)));
}

#[test]
fn streams_that_lie_and_bombs_are_refused() {
    let said = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
    assert!(said(&compressed(11)).contains("less than it promises"));
    let mut huge = compressed(0x7fff_ffff);
    huge[108..112].copy_from_slice(&16_000_i32.to_le_bytes());
    huge[112..116].copy_from_slice(&16_000_i32.to_le_bytes());
    assert!(said(&huge).contains("fewer samples"));
    let mut kind = compressed(10);
    kind[18] = 12;
    assert!(said(&kind).contains("picture"));
}
