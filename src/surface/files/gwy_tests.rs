use super::super::scan::Quantity;
use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::*;

fn whole_object(name: &str, body: &[u8]) -> Vec<u8> {
    object_of(name, body.len() as u32, body)
}

fn unit(text: &str) -> Vec<u8> {
    whole_object("GwySIUnit", &component("unitstr", b's', &[text.as_bytes(), &[0]].concat()))
}

fn data_field(lateral: &str, height: &str) -> Vec<u8> {
    let rows: Vec<u8> = TOP.iter().chain(&BOTTOM).flat_map(|h| h.to_le_bytes()).collect();
    let body = [
        component("xres", b'i', &3_i32.to_le_bytes()),
        component("yres", b'i', &2_i32.to_le_bytes()),
        component("xreal", b'd', &3e-6_f64.to_le_bytes()),
        component("yreal", b'd', &4e-6_f64.to_le_bytes()),
        component("si_unit_xy", b'o', &unit(lateral)),
        component("si_unit_z", b'o', &unit(height)),
        component("data", b'D', &[&6_u32.to_le_bytes()[..], &rows].concat()),
    ]
    .concat();
    whole_object("GwyDataField", &body)
}

fn file(components: &[Vec<u8>]) -> Vec<u8> {
    [MAGIC, &whole_object("GwyContainer", &components.concat())].concat()
}

#[test]
fn a_field_is_found_by_its_key_beside_components_of_every_type() {
    let strings = [&2_u32.to_le_bytes()[..], b"one\0two\0"].concat();
    let bytes = file(&[
        component("/filename", b's', b"somewhere\0"),
        component("/0/base/range-type", b'i', &[0; 4]),
        component("/0/visible", b'b', &[1]),
        component("/big", b'q', &[0; 8]),
        component("/names", b'S', &strings),
        component("/bytes", b'C', &[1, 0, 0, 0, 7]),
        component("/7/data", b'o', &data_field("m", "m")),
        component("/7/mask", b'o', &data_field("m", "")),
        component("/7/data/title", b's', b"Topo\0"),
    ]);
    let scan = read(&bytes).unwrap();
    assert_eq!(scan.channels[0].name, "Topo");
    let (unit, quantity, size, spacing, samples) = only(read(&bytes));
    assert_eq!((unit.as_str(), quantity, size), ("m", Quantity::Height, [3, 2]));
    assert!((spacing[0].unwrap() - 1e-6).abs() < 1e-20 && (spacing[1].unwrap() - 2e-6).abs() < 1e-20);
    assert_rows(&samples, 1.0);
    assert_robust(&bytes, |b| whole(read(b)));
}

#[test]
fn channels_are_in_the_order_of_their_numbers_and_may_be_volts() {
    let bytes = file(&[
        component("/10/data", b'o', &data_field("m", "V")),
        component("/2/data", b'o', &data_field("\u{b5}m", "nm")),
    ]);
    let scan = read(&bytes).unwrap();
    let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["/2/data", "/10/data"]);
    assert_eq!(scan.channels[1].quantity, Quantity::Other);
    assert_rows(&scan.channels.into_iter().next().unwrap().samples().unwrap(), 1e-9);
}

#[test]
fn files_of_gwyddion_1_and_files_without_fields_are_refused_in_words() {
    let said = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
    assert!(said(b"GWYOGwyContainer\0....").contains("Gwyddion 1"));
    assert!(said(&file(&[component("/a", b'b', &[1])])).contains("no data field"));
    assert!(said(&file(&[component("/a", b'?', &[1])])).contains("unknown type"));
    let lies = [&u32::MAX.to_le_bytes()[..], &[0; 8]].concat();
    assert!(said(&file(&[component("/a", b'D', &lies)])).contains("cut short"));
}

#[test]
fn a_damaged_field_is_told_and_the_others_are_read() {
    let bytes = file(&[
        component("/0/data", b'o', &data_field("m", "m")),
        component("/0/data/title", b's', b"Height\0"),
        component(
            "/1/data",
            b'o',
            &whole_object("GwyDataField", &component("xres", b'i', &3_i32.to_le_bytes())),
        ),
        component("/1/data/title", b's', b"Phase\0"),
    ]);
    let scan = read(&bytes).unwrap();
    assert_eq!(scan.channels.len(), 1);
    assert!(scan.notes[0].contains("Phase"), "{:?}", scan.notes);
    assert_rows(&only(Ok(scan)).4, 1.0);
}
