use super::super::scan::Quantity;
use super::super::testing::{
    assert_close, assert_robust, assert_rows, assert_seed, assert_survives, downwards, encoded, upwards,
    whole,
};
use super::*;

/// Returns a file of a height in both directions, each of the samples in `forward` and `backward`, and of a current.
fn file(direction: &str, kind: &str, forward: &[f64], backward: &[f64]) -> Vec<u8> {
    let text = format!(
        ":NANONIS_VERSION:\n2\n:SCANIT_TYPE:\n              {kind}\n:REC_DATE:\n 17.02.2013\n:SCAN_PIXELS:\n       3       2\n\
         :SCAN_RANGE:\n           3.000000E-6           4.000000E-6\n:SCAN_DIR:\n{direction}\n:COMMENT:\nAu(111)\n\n:Z (m):\n1\n:DATA_INFO:\n\
         \tChannel\tName\tUnit\tDirection\tCalibration\tOffset\n\t14\tZ\tm\tboth\t1.848E-8\t0.000E+0\n\
         \t0\tCurrent\tA\tbackward\t-3.333E-10\t-3.108E-13\n\n:SCANIT_END:\n\n\n"
    );
    let order = if kind.contains("LSB") { Order::Little } else { Order::Big };
    let [forward, backward] = [forward, backward].map(|rows| encoded(Number::F32, order, rows));
    [text.as_bytes(), MARK, &forward, &backward, &backward].concat()
}

/// Returns rows in which each begins at its right end.
fn mirrored(rows: Vec<f64>) -> Vec<f64> {
    rows.chunks(3).flat_map(|row| row.iter().rev().copied().collect::<Vec<f64>>()).collect()
}

#[test]
fn scans_up_and_down_forward_and_backward_show_the_same_surface() {
    for (direction, rows) in [("up", upwards()), ("down", downwards())] {
        for kind in ["FLOAT            MSBFIRST", "FLOAT LSBFIRST"] {
            let bytes = file(direction, kind, &rows, &mirrored(rows.clone()));
            let scan = super::super::recognise(&bytes, "sxm").unwrap();
            let names: Vec<&str> = scan.channels.iter().map(|c| c.name.as_str()).collect();
            assert_eq!(names, ["Z (Forward)", "Z (Backward)", "Current (Backward)"]);
            assert_eq!(scan.channels[2].quantity, Quantity::Other);
            for channel in scan.channels {
                assert_eq!(channel.size, [3, 2]);
                assert_close(channel.spacing.map(Option::unwrap), [1e-6, 2e-6]);
                assert_rows(&channel.samples().unwrap(), 1.0);
            }
            assert_survives(&bytes, |b| whole(read(b)));
        }
    }
}

#[test]
fn a_stopped_scan_has_gaps_and_damaged_files_are_refused() {
    let mut rows = downwards();
    rows[5] = f64::NAN;
    let bytes = file("down", "FLOAT MSBFIRST", &rows, &rows);
    let samples = read(&bytes).unwrap().channels.remove(0).samples().unwrap();
    assert!(samples[5].is_nan() && samples[4] == 5.0);
    assert_seed(&FORMAT, "both.sxm", &bytes);
    let first = &bytes[..bytes.len() - 2 * 24];
    assert_robust(first, |b| whole(read(b)));
    let scan = read(first).unwrap();
    assert!(scan.channels.len() == 1 && scan.notes.len() == 2, "{:?}", scan.notes);
    assert!(read(&file("up", "INT MSBFIRST", &rows, &rows)).err().unwrap().to_string().contains("INT"));
}
