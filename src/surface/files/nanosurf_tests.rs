use super::super::scan::Quantity;
use super::super::testing::{
    assert_close, assert_rows, assert_seed, assert_survives, encoded, upwards, whole,
};
use super::*;

/// Returns a file with a spectrum, a forward and a backward scan of `bits`, whose samples span 2^`bits` nanometres from `low` \[nm\] on.
fn file(bits: u32, sign: &str, order: &str, data: &[u8]) -> Vec<u8> {
    let range = f64::from(bits).exp2() * 1e-9;
    let mut text = "[DataSet]\r\nVersion=2\r\nGroupCount=3\r\nGr0-Count=0\r\nGr1-Count=1\r\nGr1-Ch0=Curve\r\nGr2-Count=21\r\n\
                    Gr2-Ch1=Up\r\nGr2-Ch3=Down\r\n\r\n[DataSet-Info]\r\n-- Scan --=--------\r\nDate=01-03-2016\r\n\r\n[Curve]\r\n\
                    Points=2\r\nLines=1\r\nFrame=Spectrum FFT\r\nDim0Unit=Hz\r\nDim2Name=Amplitude\r\nDim2Unit=m\r\nDim2Range=1\r\n\
                    SaveBits=16\r\n"
        .to_owned();
    for (section, frame) in [("Up", "Scan forward"), ("Down", "Scan backward")] {
        text += &format!(
            "\r\n[{section}]\r\nPoints=3\r\nLines=2\r\nFrame={frame}\r\nDim0Name=X*\r\nDim0Unit=m\r\nDim0Range=3e-006\r\nDim0Min=0\r\n\
             Dim1Name=Y*\r\nDim1Unit=um\r\nDim1Range=4\r\nDim1Min=0\r\nDim2Name=Z-Axis\r\nDim2Unit=m\r\nDim2Range={range}\r\n\
             Dim2Min={}\r\nSaveMode=Binary\r\nSaveBits={bits}\r\nSaveSign={sign}\r\nSaveOrder={order}\r\n",
            -range / 2.0
        );
    }
    [format!("{text}\r\n\r\n#!").as_bytes(), &[0; 4], data, data].concat()
}

#[test]
fn the_codes_of_all_widths_span_the_range() {
    for (number, bits, sign, order) in [
        (Number::I8, 8, "Signed", "Intel"),
        (Number::I16, 16, "Signed", "Intel"),
        (Number::I32, 32, "Signed", "Motorola"),
        (Number::U16, 16, "Unsigned", "Intel"),
    ] {
        let shift = if sign == "Signed" { 0.0 } else { f64::from(bits - 1).exp2() };
        let stored: Vec<f64> = upwards().iter().map(|h| h + shift).collect();
        let endian = if order == "Intel" { Order::Little } else { Order::Big };
        let bytes = file(bits, sign, order, &encoded(number, endian, &stored));
        let scan = super::super::recognise(&bytes, "nid").unwrap();
        let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["Z-Axis forward", "Z-Axis backward"], "spectra are no images");
        for channel in scan.channels {
            assert_eq!((channel.quantity, channel.size), (Quantity::Height, [3, 2]));
            assert_close(channel.spacing.map(Option::unwrap), [1e-6, 2e-6]);
            let samples = channel.samples().unwrap();
            // A code is 1 nm of a range of up to 4 m.
            let rounded: Vec<f64> = samples.iter().map(|h| (h * 1e9 * 1e3).round() / 1e3).collect();
            assert_rows(&rounded, 1.0);
        }
    }
}

#[test]
fn damaged_files_are_refused_and_those_of_spectra_alone_are_told() {
    let bytes = file(16, "Signed", "Intel", &encoded(Number::I16, Order::Little, &upwards()));
    assert_seed(&FORMAT, "two.nid", &bytes);
    assert_survives(&bytes, |b| whole(read(b)));
    assert!(
        whole(read(&bytes[..bytes.len() - 12])).is_ok(),
        "the first scan is whole, the second is left out"
    );
    assert!(read(&bytes[..bytes.len() - 13]).is_err(), "neither scan is whole");
    let curves = String::from_utf8_lossy(&bytes).replace("Gr2-Count=21", "Gr2-Count=0");
    assert!(read(curves.as_bytes()).err().unwrap().to_string().contains("no image"));
    let bits = String::from_utf8_lossy(&bytes).replace("SaveBits=16", "SaveBits=12");
    assert!(read(bits.as_bytes()).err().unwrap().to_string().contains("12 bits"));
}
