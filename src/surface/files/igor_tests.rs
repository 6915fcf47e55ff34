use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::*;

/// Numbers in the byte order of a file.
struct Writer(Order, Vec<u8>);

impl Writer {
    fn put<const N: usize>(&mut self, mut little: [u8; N]) {
        if self.0 == Order::Big {
            little.reverse();
        }
        self.1.extend(little);
    }

    fn field(&mut self, text: &str, width: usize) {
        let mut field = text.as_bytes().to_vec();
        field.resize(width, 0);
        self.1.extend(field);
    }
}

/// Returns a hand-made wave of 3 × 2 samples, bottom row first; `labels` name its channels.
fn file(order: Order, kind: u16, unit: &str, labels: &[&str], note: &str) -> Vec<u8> {
    let mut w = Writer(order, Vec::new());
    w.put(5_u16.to_le_bytes());
    w.put([0; 2]); // the check sum, later
    w.put([0; 4]);
    for length in
        [0, note.len(), 0, 0, 0, 0, 0, 0, 0, if labels.is_empty() { 0 } else { 32 * (labels.len() + 1) }, 0]
    {
        w.put((length as u32).to_le_bytes());
    }
    w.1.resize(64 + 16, 0);
    w.put(kind.to_le_bytes());
    w.1.resize(64 + 68, 0);
    for count in [3_u32, 2, labels.len() as u32, 0] {
        w.put(count.to_le_bytes());
    }
    for step in [1e-8_f64, 2e-8, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0] {
        w.put(step.to_le_bytes());
    }
    w.field(unit, 4);
    w.field("m", 4);
    w.field("m", 4);
    w.1.resize(384, 0);
    for channel in 0..labels.len().max(1) {
        for h in BOTTOM.iter().chain(&TOP).map(|h| h * (channel + 1) as f64) {
            match kind {
                2 => w.put((h as f32).to_le_bytes()),
                4 => w.put(h.to_le_bytes()),
                _ => w.put((h as i16).to_le_bytes()),
            }
        }
    }
    w.1.extend(note.as_bytes());
    if !labels.is_empty() {
        w.field("", 32);
        labels.iter().for_each(|label| w.field(label, 32));
    }
    let sum = Number::I16.decode(&w.1[..384], order).iter().fold(0_i16, |sum, x| sum.wrapping_add(*x as i16));
    let sum = match order {
        Order::Little => sum.wrapping_neg().to_le_bytes(),
        Order::Big => sum.wrapping_neg().to_be_bytes(),
    };
    w.1[2..4].copy_from_slice(&sum);
    w.1
}

#[test]
fn waves_of_every_number_and_byte_order_have_their_bottom_row_first() {
    for (order, kind) in
        [(Order::Little, 2), (Order::Big, 2), (Order::Little, 4), (Order::Big, 4), (Order::Big, 0x10)]
    {
        let bytes = file(order, kind, "m", &[], "");
        let (unit, quantity, size, spacing, samples) = only(read(&bytes));
        assert_eq!((unit.as_str(), quantity, size), ("m", Quantity::Height, [3, 2]));
        assert_eq!(spacing, [Some(1e-8), Some(2e-8)]);
        assert_rows(&samples, 1.0);
        assert_robust(&bytes, |b| whole(read(b)));
    }
}

#[test]
fn labels_decide_what_channels_of_asylum_are() {
    let labels = ["HeightRetrace", "PhaseRetrace", "AmplitudeTrace", "MineRetrace"];
    let bytes = file(Order::Little, 2, "m", &labels, "ScanSize: 1e-6\rMineUnit: V\r");
    let scan = read(&bytes).unwrap();
    let found: Vec<(&str, &str)> = scan.channels.iter().map(|c| (c.name.as_str(), c.unit.as_str())).collect();
    assert_eq!(
        found,
        [("HeightRetrace", "m"), ("PhaseRetrace", "deg"), ("AmplitudeTrace", "m"), ("MineRetrace", "V")]
    );
    assert_eq!(super::super::choose::choose(&scan, None).unwrap(), 0);
    assert_rows(&scan.channels.into_iter().nth(1).unwrap().samples().unwrap(), 2.0);
    let bytes = file(Order::Little, 2, "nm", &["PhaseRetrace"], "");
    assert_eq!(read(&bytes).unwrap().channels[0].unit, "nm", "without a note the wave is not Asylum's");
}

#[test]
fn waves_that_are_no_images_are_refused_in_words() {
    let said = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
    let mut line = vec![0; 200];
    line[0] = 2;
    line[14..16].copy_from_slice(&(-2_i16).to_le_bytes());
    assert!(said(&line).contains("single line"));
    assert!(said(&file(Order::Little, 3, "m", &[], "")).contains("complex"));
    let mut changed = file(Order::Little, 2, "m", &[], "");
    changed[100] ^= 1;
    assert!(said(&changed).contains("check sum"));
}
