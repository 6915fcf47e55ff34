//! X3P of ISO 25178-72 (ISO 5436-2): a zip with `main.xml`, the heights and a mask.
//!
//! Lengths are metres, x runs fastest, the first row is shown at the top, as Gwyddion and the viewers of firearm examiners do.
//! Some writers put everything into a folder inside the zip or leave the namespace away; both are read.

use super::bytes::{Number, Order, damaged, decode_text};
use super::format::Format;
use super::scan::{Block, Channel, Decode, Quantity, Scan, size, spacing};
use super::topography::Topography;
use crate::error::{Error, Result};
use crate::input::MAX_TEXT;
use crate::memory;
use crate::notes::{self, Notes, PreparationRecord};
use roxmltree::{Document, Node};
use std::borrow::Cow;
use std::io::{Cursor, Read, Seek, Write};
use zip::ZipArchive;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;

/// First bytes of a zip.
pub const MAGIC: &[u8] = b"PK\x03\x04";

/// Largest number of declarations of namespaces in a description; real ones have two.
const MOST_NAMESPACES: usize = 100;

/// Largest number of attributes of an element of a description; real ones have up to four.
const MOST_ATTRIBUTES: usize = 200;

/// Name of the description.
const MAIN: &str = "main.xml";

/// The format.
pub const FORMAT: Format = Format {
    name: "x3p",
    title: "ISO 25178-72",
    extensions: &["x3p"],
    signature: |b| b.starts_with(MAGIC),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN, infinity, empty entry, mask", "written, too; 64-bit floats"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A zip of something else; a description without sizes; data of another size than the description says.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(unzip)?;
    let main = main_name(&archive)?;
    let folder = main[..main.len() - MAIN.len()].to_owned();
    let xml = decode_text(&member(&mut archive, &main, MAX_TEXT)?);
    // A description in memory takes many times its text.
    memory::ensure_room(xml.len() as u64 * 8, "the description of an X3P")?;
    check_complexity(&xml)?;
    let document = Document::parse(xml.trim_start_matches('\u{feff}')).map_err(damaged)?;
    let root = document.root_element();
    let mut header = X3pHeader::read(root)?;
    let mut linked = |name: &str, most: u64| {
        let name = name.trim().replace('\\', "/");
        let name = name.trim_start_matches("./").trim_start_matches('/');
        member(&mut archive, &format!("{folder}{name}"), most)
    };
    let [columns, rows] = header.size;
    let count = columns * rows * header.layers;
    let mut scaled = None;
    let samples: Vec<f64> = match at(root, &["Record3", "DataLink", "PointDataLink"]).and_then(|n| n.text()) {
        Some(link) => {
            let needed = (count * header.number.bytes()) as u64;
            memory::ensure_room(needed + count as u64 * 8, &format!("a scan of {columns} x {rows} samples"))?;
            let data = linked(link, needed)?;
            scaled = header.choose_scale(&data);
            let block = Block {
                bytes: Cow::Owned(data),
                scale: header.scale,
                ..Block::plain(&[], header.number, Order::Little)
            };
            block.decode([columns, rows * header.layers])?()?
        }
        None => listed(root, &header, count)?,
    };
    let mask = match at(root, &["Record3", "DataLink", "ValidPointsLink"]).and_then(|n| n.text()) {
        Some(link) if !link.trim().is_empty() => Some(linked(link, count.div_ceil(8) as u64)?),
        _ => None,
    };
    let comment = at(root, &["Record2", "Comment"]).and_then(|n| n.text()).unwrap_or_default();
    let prepared = notes::preparation(comment);
    let mut scan = Scan::new("X3P", layers(&header, samples, mask, &prepared)?);
    scan.asks = true;
    scan.notes.extend(scaled);
    Ok(scan)
}

/// Returns one channel for each layer, whose heights were `prepared`; samples that `mask` excludes were not measured.
fn layers(
    header: &X3pHeader,
    mut samples: Vec<f64>,
    mask: Option<Vec<u8>>,
    prepared: &PreparationRecord,
) -> Result<Vec<Channel<'static>>> {
    if let Some(mask) = mask {
        if mask.len() < samples.len().div_ceil(8) {
            return Err(damaged("its mask is shorter than its data"));
        }
        let out = |i: usize| mask[i / 8] >> (i % 8) & 1 == 0;
        samples.iter_mut().enumerate().filter(|(i, _)| out(*i)).for_each(|(_, x)| *x = f64::NAN);
    }
    let plane = header.size[0] * header.size[1];
    let mut channels = Vec::new();
    for i in 0..header.layers {
        let rest = samples.split_off(plane);
        let layer = std::mem::replace(&mut samples, rest);
        let decode: Decode = Box::new(move || Ok(layer));
        channels.push(Channel {
            name: if header.layers == 1 { "Height".to_owned() } else { format!("Height {}", i + 1) },
            unit: "m".to_owned(),
            size: header.size,
            spacing: header.spacing,
            quantity: Quantity::Height,
            prepared: prepared.clone(),
            decode,
        });
    }
    Ok(channels)
}

/// Fields of the description.
struct X3pHeader {
    size: [usize; 2],
    layers: usize,
    spacing: [Option<f64>; 2],
    number: Number,
    /// Increment and offset of heights \[m\].
    scale: [f64; 2],
}

impl X3pHeader {
    fn read(root: Node) -> Result<Self> {
        let axis = |axis: &str, entry: &str| {
            at(root, &["Record1", "Axes", axis, entry])
                .and_then(|n| n.text())
                .map(|text| text.trim().to_owned())
        };
        let number = |name: &str, entry: &str| axis(name, entry).and_then(|text| text.parse::<f64>().ok());
        for name in ["CX", "CY"] {
            if axis(name, "AxisType").is_some_and(|kind| kind != "I") {
                return Err(Error::input(
                    "holds points that are no regular grid",
                    "interpolate them to a grid first",
                ));
            }
        }
        let side = |entry: &str| {
            let text = at(root, &["Record3", "MatrixDimension", entry]).and_then(|n| n.text());
            let text = text.ok_or_else(|| damaged(format!("its description has no {entry}")))?;
            text.trim().parse::<u64>().map_err(|_| damaged(format!("`{}` is no {entry}", text.trim())))
        };
        let size = size(side("SizeX")?, side("SizeY")?)?;
        let layers = side("SizeZ").unwrap_or(1);
        /// Largest number of layers of one surface; the standard's examples have one.
        const MOST_LAYERS: u64 = 64;
        if !(1..=MOST_LAYERS).contains(&layers) {
            return Err(damaged(format!("it has {layers} layers")));
        }
        let kind = match axis("CZ", "DataType").as_deref() {
            Some("I") => Number::I16,
            Some("L") => Number::I32,
            Some("F") => Number::F32,
            Some("D") => Number::F64,
            other => {
                return Err(damaged(format!(
                    "its heights have the unknown type {}",
                    other.unwrap_or("(none)")
                )));
            }
        };
        let increment = number("CZ", "Increment").filter(|x| x.is_finite() && *x != 0.0);
        let offset = number("CZ", "Offset").filter(|x| x.is_finite()).unwrap_or(0.0);
        if !kind.is_float() && increment.is_none() {
            return Err(damaged("its heights are integers and have no Increment"));
        }
        Ok(Self {
            size,
            layers: layers as usize,
            spacing: ["CX", "CY"].map(|name| spacing(number(name, "Increment")?, 1)),
            number: kind,
            scale: [increment.unwrap_or(1.0), offset],
        })
    }
}

impl X3pHeader {
    /// Chooses the increment of heights that are floating-point numbers. The standard's reference program adds the offset alone, others
    /// multiply by the increment as well. The choice is the one whose range is that of a surface, and the increment if both are. A note
    /// tells the choice.
    fn choose_scale(&mut self, data: &[u8]) -> Option<String> {
        /// Smallest and largest range of a measured surface \[m\].
        const RANGES: [f64; 2] = [1e-10, 1e-2];
        let [increment, _] = self.scale;
        if !self.number.is_float() || increment == 1.0 {
            return None;
        }
        let values = self.number.decode(data, Order::Little);
        let (low, high) = values
            .into_iter()
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let is_surface = |factor: f64| (RANGES[0]..=RANGES[1]).contains(&((high - low) * factor.abs()));
        let multiplies = is_surface(increment) || !is_surface(1.0);
        if !multiplies {
            self.scale[0] = 1.0;
        }
        let how = if multiplies { "multiplied by it" } else { "taken without it" };
        Some(format!(
            "the heights are floating-point numbers with an increment of {increment:e}; they were {how}"
        ))
    }
}

/// Checks that the description `xml` does not keep the parser busy for long: it compares every declaration of a namespace with all others, and
/// every attribute of an element.
fn check_complexity(xml: &str) -> Result<()> {
    if xml.matches("xmlns").count() > MOST_NAMESPACES {
        return Err(damaged(format!("its description declares more than {MOST_NAMESPACES} namespaces")));
    }
    // A value has no `<`, so that a piece has all attributes of its element.
    let is_value = |text: &&str| text.trim_start().starts_with(['"', '\'']);
    let attributes = |piece: &str| piece.split('=').skip(1).filter(is_value).count();
    if xml.split('<').any(|piece| attributes(piece) > MOST_ATTRIBUTES) {
        return Err(damaged(format!(
            "an element of its description has more than {MOST_ATTRIBUTES} attributes"
        )));
    }
    Ok(())
}

/// Returns the element at `path` below `node`, whatever the namespaces.
fn at<'a>(node: Node<'a, 'a>, path: &[&str]) -> Option<Node<'a, 'a>> {
    let step = |node: Node<'a, 'a>, name: &&str| node.children().find(|c| c.tag_name().name() == *name);
    path.iter().try_fold(node, step)
}

/// Reads the heights in the description itself. An empty entry was not measured; of several numbers in one, the last is the height.
fn listed(root: Node, header: &X3pHeader, count: usize) -> Result<Vec<f64>> {
    let list = at(root, &["Record3", "DataList"]).ok_or_else(|| damaged("its description names no data"))?;
    let mut samples = Vec::new();
    for datum in list.children().filter(|c| c.tag_name().name() == "Datum") {
        let text = datum.text().unwrap_or_default().trim();
        let last = text.rsplit(';').next().unwrap_or_default().trim();
        samples.push(match last.parse::<f64>() {
            Ok(x) => x * header.scale[0] + header.scale[1],
            Err(_) if last.is_empty() => f64::NAN, // a sample that was not measured
            Err(e) => return Err(damaged(format!("`{last}` is no height")).caused_by(e)),
        });
    }
    if samples.len() != count {
        return Err(damaged(format!("it lists {} heights instead of {count}", samples.len())));
    }
    Ok(samples)
}

/// Returns the name of the description: in the root of the zip, or in the folder that lies highest.
fn main_name(archive: &ZipArchive<Cursor<&[u8]>>) -> Result<String> {
    let is_main =
        |name: &str| name == MAIN || (name.ends_with("/main.xml") && !name.starts_with("__MACOSX/"));
    let names = archive.file_names().filter_map(|name| name.ok()).map(|name| with_slashes(&name));
    let found = names.filter(|name| is_main(name)).min_by_key(|name| (name.matches('/').count(), name.len()));
    found.ok_or_else(|| {
        Error::input(
            "is a zip without main.xml, so no X3P",
            "unpack it, and choose the file with the heights",
        )
    })
}

/// Returns the name of a member with slashes; some programs write backslashes.
fn with_slashes(name: &str) -> String {
    name.replace('\\', "/")
}

/// Reads at most `most` bytes of `name`: the size in the header may be wrong.
fn member<R: Read + Seek>(archive: &mut ZipArchive<R>, name: &str, most: u64) -> Result<Vec<u8>> {
    let names = archive.file_names().filter_map(|name| name.ok());
    let stored = names.map(|stored| stored.into_owned()).find(|stored| with_slashes(stored) == name);
    let file = archive.by_name(stored.as_deref().unwrap_or(name)).map_err(|e| unzip(e).at(name))?;
    memory::ensure_room(file.size().min(most), &format!("the file {name} in it"))?;
    let mut content = Vec::new();
    file.take(most).read_to_end(&mut content).map_err(|e| damaged(&e).caused_by(e).at(name))?;
    Ok(content)
}

fn unzip(e: ZipError) -> Error {
    let error = match &e {
        ZipError::FileNotFound => Error::input("is not in the zip", "save or copy the file again"),
        ZipError::UnsupportedArchive(what) => {
            Error::input(format!("cannot be unpacked: {what}"), "pack it again, without a password")
        }
        other => damaged(other),
    };
    error.caused_by(e)
}

/// Writes `scan` as float64 in metres, NaN for samples that were not measured, and `notes` as a comment of its second record.
///
/// # Errors
/// The file cannot be written to.
pub fn write(scan: &Topography, notes: &Notes, file: &mut (impl Write + Seek)) -> std::io::Result<()> {
    /// Size from which a zip needs its 64-bit form \[bytes\].
    const LARGE: u64 = u32::MAX as u64;
    let count = (scan.size()[0] * scan.size()[1]) as u64;
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .large_file(count * 8 >= LARGE);
    let mut archive = zip::ZipWriter::new(file);
    archive.start_file("bindata/data.bin", options)?;
    let mut sum = md5::Context::new();
    scan.metres().try_for_each(|h| {
        let bytes = h.to_le_bytes();
        sum.consume(bytes);
        archive.write_all(&bytes)
    })?;
    let xml = description(scan, notes, &format!("{:x}", sum.finalize()));
    archive.start_file(MAIN, options)?;
    archive.write_all(xml.as_bytes())?;
    archive.start_file("md5checksum.hex", options)?;
    writeln!(archive, "{:x} *main.xml", md5::compute(&xml))?;
    archive.finish()?;
    Ok(())
}

/// Returns the description of `scan` with `notes`, whose data have the check sum `sum`.
fn description(scan: &Topography, notes: &Notes, sum: &str) -> String {
    let [columns, rows] = scan.size();
    let [dx, dy] = scan.spacing();
    let axis = |name: &str, kind: &str, step: f64| {
        format!(
            "      <{name}><AxisType>{kind}</AxisType><DataType>D</DataType><Increment>{step:e}</Increment><Offset>0</Offset></{name}>\n"
        )
    };
    let axes = [axis("CX", "I", dx), axis("CY", "I", dy), axis("CZ", "A", 1.0)].concat();
    let software = notes::software();
    let comment = notes::xml(&notes.text());
    format!(
        r#"<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
{axes}    </Axes>
  </Record1>
  <Record2>
    <Date>1970-01-01T00:00:00Z</Date>
    <Instrument>
      <Manufacturer>not available</Manufacturer>
      <Model>not available</Model>
      <Serial>not available</Serial>
      <Version>{software}</Version>
    </Instrument>
    <CalibrationDate>1970-01-01T00:00:00Z</CalibrationDate>
    <ProbingSystem>
      <Type>Software</Type>
      <Identification>{software}</Identification>
    </ProbingSystem>
    <Comment>{comment}</Comment>
  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{columns}</SizeX>
      <SizeY>{rows}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{sum}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#
    )
}

#[cfg(test)]
#[path = "x3p_tests.rs"]
mod tests;
