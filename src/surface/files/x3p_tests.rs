use super::super::testing::{BOTTOM, TOP, assert_robust, assert_rows, only, whole};
use super::super::topography::Spacing;
use super::*;

/// Returns a zip of `members` by the zip crate.
fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in members {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn xml(kind: &str, z: &str, link: &str, size: [u32; 2]) -> String {
    let lateral = |name: &str, step: &str| {
        format!(
            "<{name}><AxisType>I</AxisType><DataType>D</DataType><Increment>{step}</Increment><Offset>0</Offset></{name}>"
        )
    };
    format!(
        "<?xml version=\"1.0\"?><p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1><Axes>{}{}\
         <CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{z}</CZ></Axes></Record1><Record3><MatrixDimension>\
         <SizeX>{}</SizeX><SizeY>{}</SizeY><SizeZ>1</SizeZ></MatrixDimension>{link}</Record3></p:ISO5436_2>",
        lateral("CX", "1e-6"),
        lateral("CY", "2e-6"),
        size[0],
        size[1]
    )
}

const LINK: &str = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>";
const STEP: &str = "<Increment>1e-9</Increment><Offset>0</Offset>";

fn rows() -> impl Iterator<Item = f64> {
    TOP.into_iter().chain(BOTTOM)
}

#[test]
fn data_of_every_type_have_their_increment() {
    let shorts: Vec<u8> = rows().flat_map(|h| (h as i16).to_le_bytes()).collect();
    let longs: Vec<u8> = rows().flat_map(|h| (h as i32).to_le_bytes()).collect();
    let singles: Vec<u8> = rows().flat_map(|h| (h as f32).to_le_bytes()).collect();
    let doubles: Vec<u8> = rows().flat_map(f64::to_le_bytes).collect();
    for (kind, z, data, unit) in [
        ("I", STEP, &shorts, 1e-9),
        ("L", STEP, &longs, 1e-9),
        ("F", "<Increment>1</Increment><Offset/>", &singles, 1.0),
        ("D", "", &doubles, 1.0),
    ] {
        let bytes =
            archive(&[("main.xml", xml(kind, z, LINK, [3, 2]).as_bytes()), ("bindata/data.bin", data)]);
        let (_, quantity, size, spacing, samples) = only(read(&bytes));
        assert_eq!((quantity, size, spacing), (Quantity::Height, [3, 2], [Some(1e-6), Some(2e-6)]));
        assert_rows(&samples, unit);
    }
    let bytes =
        archive(&[("main.xml", xml("I", STEP, LINK, [3, 2]).as_bytes()), ("bindata/data.bin", &shorts)]);
    assert_robust(&bytes, |b| whole(read(b)));
    let none = archive(&[("main.xml", xml("I", "", LINK, [3, 2]).as_bytes()), ("bindata/data.bin", &shorts)]);
    assert!(read(&none).err().unwrap().to_string().contains("Increment"));
}

#[test]
fn masks_nan_and_empty_entries_were_not_measured() {
    let link = "<DataLink><PointDataLink>/bindata\\data.bin</PointDataLink><ValidPointsLink>bindata/valid.bin\
                </ValidPointsLink></DataLink>";
    let singles: Vec<u8> =
        [1.0, f32::NAN, 3.0, f32::INFINITY, 5.0, 6.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let members: [(&str, &[u8]); 3] = [
        ("main.xml", &xml("F", "", link, [3, 2]).into_bytes()),
        ("bindata/data.bin", &singles),
        ("bindata/valid.bin", &[0b0011_1110]),
    ];
    let missing = |samples: Vec<f64>| samples.iter().map(|h| h.is_nan()).collect::<Vec<bool>>();
    let (.., samples) = only(read(&archive(&members)));
    assert_eq!(
        missing(samples),
        [true, true, false, true, false, false],
        "the mask's first bit is its lowest"
    );
    let list = "<DataList><Datum>1</Datum><Datum/><Datum>0;0;3</Datum><Datum></Datum><Datum>5</Datum><Datum>6</Datum></DataList>";
    let (.., samples) = only(read(&archive(&[("main.xml", xml("D", STEP, list, [3, 2]).as_bytes())])));
    assert_eq!(samples[2], 3.0 * 1e-9);
    assert_eq!(missing(samples), [false, true, false, true, false, false]);
}

#[test]
fn a_folder_in_the_zip_and_a_missing_namespace_do_no_harm() {
    let doubles: Vec<u8> = rows().flat_map(f64::to_le_bytes).collect();
    let plain =
        xml("D", "", LINK, [3, 2]).replace("p:ISO5436_2 xmlns:p", "ISO5436_2 xmlns:p").replace("</p:", "</");
    let bytes = archive(&[
        ("__MACOSX/main.xml", b"decoy"),
        ("scan/main.xml", plain.as_bytes()),
        ("scan/bindata/data.bin", &doubles),
    ]);
    assert_rows(&only(read(&bytes)).4, 1.0);
}

#[test]
fn lies_bombs_and_other_zips_are_refused() {
    let said = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
    assert!(said(&archive(&[("a.txt", b"a")])).contains("main.xml"));
    let huge = xml("D", "", LINK, [16_000, 16_000]);
    let bomb = vec![0; 1 << 22];
    assert!(
        said(&archive(&[("main.xml", huge.as_bytes()), ("bindata/data.bin", &bomb)])).contains("cut short")
    );
    assert!(said(&archive(&[("main.xml", xml("D", "", LINK, [3, 2]).as_bytes())])).contains("data.bin"));
    let nested = "<a>".repeat(100_000);
    assert!(read(&archive(&[("main.xml", nested.as_bytes())])).is_err());
    let points = xml("D", "", LINK, [3, 2]).replacen("<AxisType>I<", "<AxisType>A<", 1);
    assert!(said(&archive(&[("main.xml", points.as_bytes())])).contains("regular grid"));
}

#[test]
fn what_is_written_is_read_back_to_the_last_bit_with_its_gaps() {
    let heights = vec![1.0 / 3.0 * 1e-7, f64::NAN, 2e-7, 3e-7, -4e-7, 1e-20];
    let scan =
        Topography::new([3, 2], Spacing::Metres([7.843e-9, 1e-8]), heights.clone(), 1e6, None).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    write(&scan, &Notes::default(), &mut bytes).unwrap();
    let (_, _, size, spacing, samples) = only(read(bytes.get_ref()));
    assert_eq!((size, spacing), ([3, 2], [Some(7.843e-9), Some(1e-8)]));
    assert!(samples[1].is_nan());
    assert!(samples.iter().zip(&heights).all(|(a, b)| a == b || b.is_nan()));
}

#[test]
fn members_with_backslashes_are_read_like_any_other() {
    let data: Vec<u8> = rows().flat_map(f64::to_le_bytes).collect();
    let main = xml("D", "", LINK, [3, 2]);
    let bytes = archive(&[("a\\main.xml", main.as_bytes()), ("a\\bindata\\data.bin", &data)]);
    assert_rows(&only(read(&bytes)).4, 1.0);
}

#[test]
fn a_description_of_very_many_namespaces_or_attributes_is_refused_at_once() {
    for (attribute, named) in [(" xmlns:a", "namespaces"), (" a", "attributes")] {
        for quote in ["\"", "'", " '"] {
            let many: String =
                (0..100_000).map(|i| format!("{attribute}{i}={quote}>{}", quote.trim())).collect();
            let main = xml("D", "", LINK, [3, 2]).replacen("<Record1>", &format!("<Record1{many}>"), 1);
            let refused = read(&archive(&[("main.xml", main.as_bytes())])).err().unwrap().to_string();
            assert!(refused.contains(named), "{refused}");
        }
    }
}

#[test]
fn floats_with_an_increment_are_multiplied_by_it_where_that_makes_a_surface() {
    let of = |increment: &str, unit: f64| {
        let z = format!("<Increment>{increment}</Increment><Offset>0</Offset>");
        let data: Vec<u8> = rows().flat_map(|x| (x * unit).to_le_bytes()).collect();
        let main = xml("D", &z, LINK, [3, 2]);
        let bytes = archive(&[("main.xml", main.as_bytes()), ("bindata/data.bin", &data)]);
        let scan = read(&bytes).unwrap();
        (scan.notes.join(" "), only(Ok(scan)).4)
    };
    // Micrometres, and metres with an increment that is not for them.
    let (note, samples) = of("1e-6", 1.0);
    assert_rows(&samples, 1e-6);
    assert!(note.contains("multiplied"), "{note}");
    let (note, samples) = of("1e-9", 1e-6);
    assert_rows(&samples, 1e-6);
    assert!(note.contains("without"), "{note}");
    assert_eq!(of("1", 1e-6).0, "");
}

#[test]
fn one_of_several_layers_has_to_be_named() {
    let data: Vec<u8> = rows().chain(rows()).flat_map(f64::to_le_bytes).collect();
    let main = xml("D", "", LINK, [3, 2]).replace("<SizeZ>1</SizeZ>", "<SizeZ>2</SizeZ>");
    let bytes = archive(&[("main.xml", main.as_bytes()), ("bindata/data.bin", &data)]);
    let scan = read(&bytes).unwrap();
    let refused = super::super::choose::choose(&scan, None).unwrap_err().to_string();
    assert!(refused.contains("2 surfaces"), "{refused}");
    assert_eq!(super::super::choose::choose(&scan, Some("Height 2")).unwrap(), 1);
}
