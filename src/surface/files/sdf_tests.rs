use super::super::testing::{assert_robust, assert_rows, only, whole};
use super::*;

fn text_file(kind: &str, rows: &str) -> String {
    format!(
        "{kind}\nManufacID = Hand\nCreateDate = 0\nModDate = 0\nNumPoints = 3\nNumProfiles = 2 ; two\nXscale = 1e-6\n\
         Yscale = 2e-6\nZscale = 1e-9\nZresolution = -1\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n{rows}\n*"
    )
}

fn binary_file(data_type: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"bISO-1.0Hand      010120260000010120260000".to_vec();
    bytes.extend([3, 0, 2, 0]);
    for scale in [1e-6, 2e-6, 1e-9, -1.0_f64] {
        bytes.extend(scale.to_le_bytes());
    }
    bytes.extend([0, data_type, 0]);
    [&bytes, data].concat()
}

#[test]
fn text_and_binary_have_their_heights() {
    for kind in ["aISO-1.0", "aBCR-1.0"] {
        let text = text_file(kind, "1 2 3\n4.0 5.0E0 6");
        let (_, _, size, spacing, samples) = only(read_text(text.as_bytes()));
        assert_eq!((size, spacing), ([3, 2], [Some(1e-6), Some(2e-6)]));
        assert_rows(&samples, 1e-9);
        assert_robust(text.as_bytes(), |b| whole(read_text(b)));
    }
    let doubles: Vec<u8> = (1..=6).flat_map(|h| f64::from(h).to_le_bytes()).collect();
    let shorts: Vec<u8> = (1..=6_i16).flat_map(i16::to_le_bytes).collect();
    for bytes in [binary_file(7, &doubles), binary_file(5, &shorts), binary_file(0, &[1, 2, 3, 4, 5, 6])] {
        let (_, _, size, spacing, samples) = only(read_binary(&bytes));
        assert_eq!((size, spacing), ([3, 2], [Some(1e-6), Some(2e-6)]));
        assert_rows(&samples, 1e-9);
        assert_robust(&bytes, |b| whole(read_binary(b)));
    }
}

#[test]
fn bad_samples_are_not_measured() {
    let (.., samples) = only(read_text(text_file("aISO-1.0", "1 BAD 3 4 5 6").as_bytes()));
    assert!(samples[1].is_nan() && samples[2] == 3.0 * 1e-9);
    let shorts: Vec<u8> = [1, i16::MIN, 3, 4, 5, 6].into_iter().flat_map(i16::to_le_bytes).collect();
    let (.., samples) = only(read_binary(&binary_file(5, &shorts)));
    assert!(samples[1].is_nan() && samples[0] == 1e-9);
}

#[test]
fn more_and_fewer_samples_and_unknown_types_are_refused() {
    let said = |text: String| read_text(text.as_bytes()).err().unwrap().to_string();
    assert!(said(text_file("aISO-1.0", "1 2 3 4 5 6 7")).contains("more than"));
    assert!(said(text_file("aISO-1.0", "1 2 3 4 5")).contains("cut short"));
    assert!(said(text_file("aISO-1.0", "1 2 3 4 5 x")).contains("`x`"));
    assert!(
        said(text_file("aISO-1.0", "1 2 3 4 5 6").replace("Points = 3", "Points = 16000"))
            .contains("cut short")
    );
    assert!(
        said(text_file("aISO-1.0", "1 2 3 4 5 6").replace("Compression = 0", "Compression = 1"))
            .contains("compressed")
    );
    assert!(read_binary(&binary_file(9, &[0; 48])).is_err());
}
