//! Scans: other formats, what is said about a file, and other programs that open what is written.

use crate::sandbox::Sandbox;
use std::process::Command;

/// A text of three by two heights as Gwyddion exports it, one of them missing.
const TEXT: &str =
    "# Channel: Topo\n# Width: 30 nm\n# Height: 40 nm\n# Value units: nm\n1\t2\t3\n4\tnan\t6\n";

/// The JSON of `surface info`.
fn info(sandbox: &Sandbox, arguments: &[&str]) -> serde_json::Value {
    let outcome = sandbox.run2(&["surface", "info", "--json"], arguments);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    serde_json::from_str(&outcome.stdout).unwrap()
}

#[test]
fn json_has_the_numbers_of_what_was_measured() {
    let sandbox = Sandbox::new();
    sandbox.write("scan.txt", TEXT);
    let info = info(&sandbox, &["scan.txt"]);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    assert_eq!(info["samples"], serde_json::json!([3, 2]));
    assert!(close(number(&info["spacing_m"][0]), 10e-9) && close(number(&info["spacing_m"][1]), 20e-9));
    assert!(
        close(number(&info["height_range_m"][0]), 1e-9) && close(number(&info["height_range_m"][1]), 6e-9)
    );
    // 1, 2, 3, 4 and 6 nm.
    assert!(close(number(&info["mean_m"]), 3.2e-9));
    assert!(close(number(&info["rms_m"]), (14.8_f64 / 5.0).sqrt() * 1e-9));
    assert_eq!(info["invalid"], 1);
    assert_eq!(info["channels"][0]["name"], "Topo");
    assert_eq!(info["channels"][0]["chosen"], true);
}

#[test]
fn gaps_and_doubtful_scales_are_told_on_stderr() {
    let sandbox = Sandbox::new();
    sandbox.write("scan.txt", TEXT);
    let outcome = sandbox.run(["surface", "info", "scan.txt"]);
    assert!(
        outcome.stdout.contains("1 Topo (nm) *") && outcome.stdout.contains("not measured"),
        "{}",
        outcome.stdout
    );
    assert!(outcome.stderr.contains("scan.txt: 1 of 6 samples were not measured"), "{}", outcome.stderr);
    sandbox.write("metres.txt", TEXT.replace("units: nm", "units: m"));
    let outcome = sandbox.run(["surface", "info", "metres.txt"]);
    assert!(outcome.code == Some(0) && outcome.stderr.contains("is their unit right?"), "{}", outcome.stderr);
}

#[test]
fn files_without_a_scale_are_refused_until_it_is_given() {
    let sandbox = Sandbox::new();
    sandbox.write("grey.png", crate::sandbox::grey_png(3, 2, |x, y| (x * 50 + y * 5) as u8));
    let refused = |more: &[&str]| sandbox.run2(&["surface", "info", "grey.png"], more).refused(2);
    assert!(refused(&[]).contains("--pixel-size"));
    assert!(refused(&["--pixel-size", "10nm"]).contains("--height"));
    assert!(refused(&["--pixel-size", "10nm", "--height", "1nm", "--channel", "phase"]).contains("1 (grey"));
    let scales = ["grey.png", "--pixel-size", "10nm", "--height", "51nm"];
    let said = sandbox.run2(&["surface", "info"], &scales).done();
    assert!(said.contains("steps of 0.200 nm"), "{said}");
    sandbox.write("grey.toml", "pixel_size = \"10nm\"\nheight = \"51nm\"\n");
    assert_eq!(info(&sandbox, &["grey.png"])["samples"], serde_json::json!([3, 2]));
}

#[test]
fn a_round_trip_through_every_format_changes_no_height() {
    let sandbox = Sandbox::new();
    let convert = |from: &[&str], to: &str| {
        sandbox.run2(&["surface", "convert", "-o", to], from).done();
    };
    convert(&["blaze", "--seed", "1"], "a.npy");
    let spacing = info(&sandbox, &["blaze"])["spacing_m"][0].as_f64().unwrap() * 1e9;
    let read = ["a.npy".to_owned(), "--pixel-size".to_owned(), format!("{spacing}nm")];
    let read: Vec<&str> = read.iter().map(String::as_str).collect();
    for exact in ["a.gwy", "a.x3p", "a.txt"] {
        convert(&read, exact);
        convert(&[exact], "back.npy");
        assert_eq!(sandbox.read("a.npy"), sandbox.read("back.npy"), "{exact}");
    }
    for single in ["a.gsf", "a.tif"] {
        convert(&read, single);
        convert(&[single], "single.npy");
        let doubles = |name: &str| -> Vec<f64> {
            sandbox.read(name)[128..]
                .chunks_exact(8)
                .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
                .collect()
        };
        let pairs = doubles("a.npy").into_iter().zip(doubles("single.npy"));
        pairs.for_each(|(a, b)| assert_eq!(f64::from(a as f32), b, "{single}"));
        let [before, after] = [&read[..], &[single]].map(|file| info(&sandbox, file));
        assert_eq!(before["samples"], after["samples"]);
        let distance = |info: &serde_json::Value| info["spacing_m"][1].as_f64().unwrap();
        assert!((distance(&before) / distance(&after) - 1.0).abs() < 1e-14, "{single}");
    }
    assert!(sandbox.run(["surface", "convert", "blaze", "-o", "a.jpg"]).refused(2).contains(".gsf"));
}

#[test]
fn a_gap_stays_a_gap() {
    let sandbox = Sandbox::new();
    sandbox.write("scan.txt", TEXT);
    for name in ["a.gsf", "a.tif", "a.x3p", "b.txt"] {
        assert_eq!(sandbox.run(["surface", "convert", "scan.txt", "-o", name]).code, Some(0));
        assert_eq!(info(&sandbox, &[name])["invalid"], 1, "{name}");
    }
    let refused = sandbox.run(["surface", "convert", "scan.txt", "-o", "a.gwy"]);
    let why = "1 of 6 samples were not measured, for which .gwy has no mark; write .gsf";
    assert!(refused.code == Some(1) && refused.stderr.contains(why), "{}", refused.stderr);
    assert!(!sandbox.path("a.gwy").exists());
}

#[cfg(unix)]
#[test]
fn a_path_that_is_not_utf_8_is_opened() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let sandbox = Sandbox::new();
    let name = OsStr::from_bytes(b"sc\xffan.txt");
    std::fs::write(sandbox.path(name), TEXT).unwrap();
    for option in [None, Some(OsStr::new("--surface"))] {
        let words = [OsStr::new("surface"), OsStr::new("info")].into_iter().chain(option).chain([name]);
        assert_eq!(sandbox.run(words).code, Some(0));
    }
}

/// Runs `script` by Python in the sandbox if `modules` are there.
fn python(sandbox: &Sandbox, modules: &str, script: &str) {
    let interpreter = std::env::var_os("DIFFRACT_PYTHON").unwrap_or_else(|| "python3".into());
    let run =
        |code: &str| Command::new(&interpreter).args(["-c", code]).current_dir(sandbox.path("")).output();
    if !run(&format!("import {modules}")).is_ok_and(|o| o.status.success()) {
        eprintln!("left out: Python with {modules} is not here (DIFFRACT_PYTHON names one)");
        return;
    }
    let output = run(script).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn other_programs_open_what_is_written() {
    let sandbox = Sandbox::new();
    sandbox.write("scan.txt", TEXT.replace("nan", "5"));
    for name in ["a.npy", "a.tif", "a.gsf", "a.gwy", "a.x3p"] {
        sandbox.run(["surface", "convert", "scan.txt", "-o", name]).done();
    }
    let expected = "import numpy\nwant = numpy.array([[1, 2, 3], [4, 5, 6]]) * 1e-9\n";
    let check = "assert got.shape == (2, 3) and numpy.allclose(got, want, rtol=1e-6, atol=0), got\n";
    python(&sandbox, "numpy", &format!("{expected}got = numpy.load('a.npy')\n{check}"));
    let tif = "import tifffile\npage = tifffile.TiffFile('a.tif').pages[0]\ngot = page.asarray()\n\
               n, d = page.tags['XResolution'].value\nassert page.tags['ResolutionUnit'].value == 3\n\
               assert abs(d / n * 0.01 / 10e-9 - 1) < 1e-9\nassert got.dtype == numpy.float32\n";
    python(&sandbox, "tifffile, numpy", &format!("{expected}{tif}{check}"));
    let gwy = "import gwyfile\nfields = gwyfile.util.get_datafields(gwyfile.load('a.gwy'))\nfield = fields['Height']\n\
               got = field.data\nassert abs(field.xreal - 30e-9) < 1e-20 and field.si_unit_z.unitstr == 'm'\n";
    python(&sandbox, "gwyfile, numpy", &format!("{expected}{gwy}{check}"));
    // The header of a Gwyddion simple field, by its specification.
    let gsf = "b = open('a.gsf', 'rb').read()\nend = b.index(0)\nh = dict(l.split(' = ') for l in b[:end].decode().splitlines()[1:])\n\
               start = (end // 4 + 1) * 4\ngot = numpy.frombuffer(b[start:], '<f4').reshape(int(h['YRes']), int(h['XRes']))\n\
               assert abs(float(h['XReal']) - 30e-9) < 1e-20 and h['ZUnits'] == 'm'\n";
    python(&sandbox, "numpy", &format!("{expected}{gsf}{check}"));
    let x3p = "import zipfile, hashlib\nimport xml.etree.ElementTree as E\nz = zipfile.ZipFile('a.x3p')\nx = z.read('main.xml')\n\
               assert z.read('md5checksum.hex').split()[0].decode() == hashlib.md5(x).hexdigest()\nr = E.fromstring(x)\n\
               d = r.find('Record3/DataLink')\nb = z.read(d.find('PointDataLink').text)\n\
               assert hashlib.md5(b).hexdigest() == d.find('MD5ChecksumPointData').text\n\
               n = [int(r.find('Record3/MatrixDimension/Size' + a).text) for a in 'YX']\n\
               got = numpy.frombuffer(b, '<f8').reshape(n)\nassert abs(float(r.find('Record1/Axes/CX/Increment').text) - 10e-9) < 1e-20\n";
    python(&sandbox, "numpy", &format!("{expected}{x3p}{check}"));
}
