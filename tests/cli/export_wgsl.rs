//! The function that reads an export, in WGSL, run by the WebGPU of a browser.

use crate::export::{EXPORT, chromium};
use crate::sandbox::{Sandbox, TIMEOUT};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::io::{BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// Page that answers the conformance directions of an export.
const PAGE: &str = include_str!("export_wgsl.html");

/// End of the shader, with FRAME for the tangent frame.
const MAIN: &str = include_str!("../export_main.wgsl");

/// Columns of the standard frame, and of one that is turned by a right angle about its normal.
const STANDARD_FRAME: &str = "1, 0, 0, 0, 1, 0, 0, 0, 1";
const TURNED_FRAME: &str = "0, 1, 0, -1, 0, 0, 0, 0, 1";

/// Opens `page` in Chromium, and returns the text that it sends. `--dump-dom` does not wait for a device.
fn sent(sandbox: &Sandbox, page: &str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let port = listener.local_addr().unwrap().port();
    sandbox.write("wgsl.html", page.replace("{{PORT}}", &port.to_string()));
    let mut browser = chromium(sandbox);
    browser.args(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--remote-debugging-port=0"]);
    let browser = browser.arg(format!("file://{}", sandbox.path("wgsl.html").display()));
    let mut browser = Running(browser.stderr(Stdio::null()).spawn().unwrap());
    let deadline = Instant::now() + TIMEOUT;
    let stream = loop {
        match listener.accept() {
            Ok((stream, _)) => break stream,
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
        assert!(browser.0.try_wait().unwrap().is_none(), "the browser ended");
        assert!(Instant::now() < deadline, "the browser has sent nothing");
    };
    stream.set_nonblocking(false).unwrap();
    body(stream)
}

/// A process that ends with its value.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Reads the body of a request.
fn body(stream: TcpStream) -> String {
    let mut reader = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        match line.to_ascii_lowercase().trim_end().split_once(": ") {
            Some(("content-length", count)) => length = count.parse().unwrap(),
            Some(_) => {}
            None if line.trim_end().is_empty() => break,
            None => {}
        }
    }
    let mut bytes = vec![0; length];
    reader.read_exact(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// Writes the answers of the browser for the tangent frame `frame` to `mine.csv`.
fn answer(sandbox: &Sandbox, frame: &str) {
    let file = |name: &str| sandbox.read(&format!("material/{name}"));
    let text = |name: &str| String::from_utf8(file(name)).unwrap();
    let question = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [light, viewer] = [&cells[..3], &cells[3..6]].map(|three| three.join(","));
        format!("{light},0,{viewer},0,{}", cells[6..10].join(","))
    };
    let questions: Vec<String> = text("conformance.csv").lines().skip(1).map(question).collect();
    let page = PAGE
        .replace("{{WGSL}}", &text("material.wgsl"))
        .replace("{{MAIN}}", &MAIN.replace("FRAME", &format!("mat3x3<f32>({frame})")))
        .replace("{{QUESTIONS}}", &questions.join(","))
        .replace("{{TABLE}}", &STANDARD.encode(file("table.ktx2")))
        .replace("{{FUNCTIONS}}", &STANDARD.encode(file("functions.ktx2")));
    let answers = sent(sandbox, &page);
    let numbers: Vec<&str> = answers.split(',').collect();
    assert_eq!(numbers.len(), 4 * questions.len(), "{}", &answers[..answers.len().min(2000)]);
    let rows: String = numbers.chunks(4).map(|rgba| rgba[..3].join(",") + "\n").collect();
    sandbox.write("mine.csv", format!("r,g,b\n{rows}"));
}

#[test]
fn the_wgsl_of_an_export_gives_the_colours_of_the_table_in_the_webgpu_of_a_browser() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    sandbox.run(EXPORT).done();
    let check = ["export", "--check", "material", "--answers", "mine.csv"];
    answer(&sandbox, STANDARD_FRAME);
    let line = sandbox.run(check).done();
    eprintln!("{line}");
    assert!(line.starts_with("right: "), "{line}");
    answer(&sandbox, TURNED_FRAME);
    assert!(sandbox.run(check).refused(1).contains("not those of the table"));
}
