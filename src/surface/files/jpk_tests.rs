use super::super::bytes::{Number, Order};
use super::super::testing::{
    assert_close, assert_rows, assert_seed, assert_survives, downwards, encoded, upwards, whole,
};
use super::*;

/// Tag, type and bytes of an entry.
type Entry = (u16, u16, Vec<u8>);

fn text(tag: u16, text: &str) -> Entry {
    (tag, 2, format!("{text}\0").into_bytes())
}

fn short(tag: u16, number: u16) -> Entry {
    (tag, 3, number.to_be_bytes().to_vec())
}

fn double(tag: u16, number: f64) -> Entry {
    (tag, 12, number.to_be_bytes().to_vec())
}

/// Returns a big-endian TIFF of pages of 3 × 2 samples of 32 bits, each with its entries and its samples.
fn file(pages: &[(Vec<Entry>, Vec<f64>)]) -> Vec<u8> {
    let mut bytes = b"MM\0*\0\0\0\x08".to_vec();
    for (i, (extra, samples)) in pages.iter().enumerate() {
        let data = encoded(Number::I32, Order::Big, samples);
        let mut entries = vec![short(256, 3), short(257, 2), short(258, 32), short(259, 1), short(262, 1)];
        entries.extend([short(277, 1), short(278, 2), short(339, 2)]);
        entries.extend(extra.clone());
        entries.push((273, 4, Vec::new()));
        entries.push((279, 4, (data.len() as u32).to_be_bytes().to_vec()));
        entries.sort_by_key(|entry| entry.0);
        let mut place = bytes.len() + 2 + entries.len() * 12 + 4;
        let mut apart = data.clone();
        let strip = place as u32;
        place += data.len();
        bytes.extend((entries.len() as u16).to_be_bytes());
        for (tag, kind, mut value) in entries {
            if tag == 273 {
                value = strip.to_be_bytes().to_vec();
            }
            let width = match kind {
                2 => 1,
                3 => 2,
                4 => 4,
                _ => 8,
            };
            bytes.extend([tag.to_be_bytes(), kind.to_be_bytes()].concat());
            bytes.extend((value.len() as u32 / width).to_be_bytes());
            if value.len() > 4 {
                bytes.extend((place as u32).to_be_bytes());
                place += value.len();
                apart.extend(value);
            } else {
                value.resize(4, 0);
                bytes.extend(value);
            }
        }
        let is_last = i + 1 == pages.len();
        bytes.extend((if is_last { 0 } else { place as u32 }).to_be_bytes());
        bytes.extend(apart);
    }
    bytes
}

/// Returns the entries of a channel with raw numbers and a scaled slot.
fn channel(name: &str, unit: &str, scaling: &str, default: &str) -> Vec<Entry> {
    let second = FIRST_SLOT + SLOT_STEP;
    vec![
        text(NAMES[1], name),
        short(SLOTS, 2),
        text(DEFAULT_SLOT, default),
        text(FIRST_SLOT, "raw"),
        text(FIRST_SLOT + SCALING, "NullScaling"),
        text(second, "nominal"),
        text(second + UNIT, unit),
        text(second + SCALING, scaling),
        double(second + FACTOR, 2e-9),
        double(second + OFFSET, -1e-9),
    ]
}

fn grid() -> Vec<Entry> {
    vec![text(NAMES[1], "contact"), double(SIDES[0], 3e-6), double(SIDES[1], 4e-6)]
}

#[test]
fn channels_are_scaled_by_their_default_slot_and_begin_with_the_lowest_line() {
    let mut retrace = channel("Height", "m", "LinearScaling", "nominal");
    retrace.extend([short(RETRACE, 1), short(REFLECTED, 1)]);
    let stored = |rows: Vec<f64>| rows.iter().map(|h| (h + 1.0) / 2.0 * 10.0).collect::<Vec<f64>>();
    let pages = [
        (grid(), vec![0.0; 6]),
        (channel("Height", "m", "LinearScaling", "nominal"), stored(upwards())),
        (retrace, stored(downwards())),
        (channel("Deflection", "V", "LinearScaling", "raw"), upwards()),
    ];
    let bytes = file(&pages);
    let scan = super::super::recognise(&bytes, "jpk").unwrap();
    assert_eq!(scan.format, FORMAT.title);
    let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Height", "Height (retrace)", "Deflection"], "the thumbnail is no channel");
    for channel in scan.channels {
        let (spacing, quantity) = (channel.spacing.map(Option::unwrap), channel.quantity);
        assert_close(spacing, [1e-6, 2e-6]);
        let samples = channel.samples().unwrap();
        if quantity == Quantity::Height {
            let metres: Vec<f64> = samples.iter().map(|h| (h + 1e-9) / 10.0 - 1e-9).collect();
            let rounded: Vec<f64> = metres.iter().map(|h| (h * 1e9 * 2.0).round() / 2.0).collect();
            assert_rows(&rounded, 1.0);
        } else {
            assert_rows(&samples, 1.0);
        }
    }
    assert_seed(&FORMAT, "three.jpk", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
}

#[test]
fn other_scalings_and_missing_slots_are_told() {
    let said = |entries: Vec<Entry>| {
        read(&file(&[(grid(), vec![0.0; 6]), (entries, upwards())])).err().unwrap().to_string()
    };
    assert!(said(channel("Height", "m", "AcosScaling", "nominal")).contains("AcosScaling"));
    assert!(said(channel("Height", "m", "LinearScaling", "absolute")).contains("`absolute` is missing"));
    assert!(said(Vec::new()).contains("no image"));
}
