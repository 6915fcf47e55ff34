//! Wavefront OBJ files.
//!
//! All objects and groups of a file become one mesh; materials, lines, points and colours are left out. Polygons are
//! cut into fans, which suits convex ones. If a single face has no texture coordinates, those of the whole file are
//! projected as [`Corner::uv`] says, so that one rule holds for all of it; normals likewise become smooth ones.
//!
//! A file is read twice. The first pass counts, so that limits and memory are checked before anything is taken; the second
//! reads into what the first found.

use super::corner::Corner;
use super::mesh::{MAX_TRIANGLES, Mesh, Progress};
use crate::error::{Error, Result};
use crate::memory;
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// The largest file that is read, in bytes.
pub const MAX_BYTES: u64 = 512 << 20;

/// What some programs put in front of text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Most corners of one face: a second of work. Fans suit convex faces, and nobody models convex ones of so many corners.
const MAX_CORNERS: usize = 1 << 17;

/// What a triangle takes at the peak, while its mesh is built: 420 bytes were measured of a fan of 130 000, 640 of a million
/// that share no vertex.
const BYTES_PER_TRIANGLE: u64 = 700;

/// Bytes of text between two reports of progress: some milliseconds.
const REPORT_EVERY: usize = 1 << 20;

/// The most characters of a word that an error shows.
const SHOWN: usize = 40;

/// Reads the mesh in the OBJ file at `path`, and tells `progress`.
///
/// # Errors
/// A file that cannot be read, is not a plain file or is larger than [`MAX_BYTES`]; otherwise as [`from_bytes`]. The
/// error names the file. Also what `progress` returns.
pub fn load(path: &Path, progress: &Progress<'_>) -> Result<Mesh> {
    read(path).and_then(|bytes| parse(&bytes, progress)).map_err(|e| e.at(path.display()))
}

/// The mesh in the text of an OBJ file.
///
/// # Errors
/// Text that is empty or not an OBJ, a line that is cut short or malformed (named by its number), an index that points
/// at nothing, no faces, more than [`MAX_TRIANGLES`], more than the memory holds; and as [`Mesh::from_triangles`].
pub fn from_bytes(bytes: &[u8]) -> Result<Mesh> {
    parse(bytes, &|_, _, _| Ok(()))
}

/// As [`from_bytes`], which fails with what `progress` returns.
fn parse(bytes: &[u8], progress: &Progress<'_>) -> Result<Mesh> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Error::failed("the file is empty", "export the mesh as Wavefront OBJ again"));
    }
    if bytes.contains(&0) {
        return Err(not_an_obj());
    }
    let mut sizes = Sizes::default();
    each_line(bytes, "counting faces", progress, |line| sizes.line(line))?;
    if sizes.counts == [0; 3] && sizes.faces == 0 {
        return Err(not_an_obj());
    }
    memory::ensure_room(sizes.triangles as u64 * BYTES_PER_TRIANGLE + sizes.bytes(), "the mesh")?;
    let mut geometry = Geometry::of(&sizes);
    each_line(bytes, "reading faces", progress, |line| geometry.line(line))?;
    if sizes.faces == 0 {
        let remedy = "export it with faces; a point cloud has no surface";
        return Err(Error::failed("the OBJ has no faces", remedy));
    }
    Mesh::build(geometry.into_triangles(), progress)
}

/// The bytes of the file, if it is one and not too large.
fn read(path: &Path) -> Result<Vec<u8>> {
    let failed = |e: std::io::Error| Error::failed(format!("cannot read the mesh ({e})"), "check the path");
    let about = fs::metadata(path).map_err(failed)?;
    if !about.is_file() {
        let what = if about.is_dir() { "this is a directory" } else { "this is not a plain file" };
        return Err(Error::failed(what, "name a Wavefront OBJ file"));
    }
    let too_large = |size: u64| {
        Error::failed(
            format!("the file of {size} bytes is larger than {MAX_BYTES}"),
            "simplify the mesh first",
        )
    };
    if about.len() > MAX_BYTES {
        return Err(too_large(about.len()));
    }
    memory::ensure_room(about.len(), "the text of the mesh")?;
    let mut bytes = Vec::with_capacity(about.len() as usize + 1);
    // The file may grow while it is read.
    File::open(path).and_then(|f| f.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

fn not_an_obj() -> Error {
    Error::failed("this is not a Wavefront OBJ", "export the mesh as OBJ; other formats are not read")
}

/// Calls `act` with every line of `text`; errors name the line. Lines end in \n, \r\n or \r; one that ends in a backslash goes
/// on. Names and comments may be in any encoding; what matters is ASCII.
fn each_line(
    text: &[u8],
    what: &'static str,
    progress: &Progress<'_>,
    mut act: impl FnMut(&[u8]) -> Result<()>,
) -> Result<()> {
    let (mut start, mut number, mut reported) = (0, 1, 0);
    progress(what, 0, text.len())?;
    while start < text.len() {
        let (line, length, ends) = next_line(&text[start..]);
        act(&line).map_err(|e| e.at(format!("line {number}")))?;
        (start, number) = (start + length, number + ends);
        if start - reported >= REPORT_EVERY {
            progress(what, start, text.len())?;
            reported = start;
        }
    }
    Ok(())
}

/// The first line of `text`, what it goes on with included, the bytes that it takes with its end, and the number of ends.
fn next_line(text: &[u8]) -> (Cow<'_, [u8]>, usize, usize) {
    let mut joined: Option<Vec<u8>> = None;
    let (mut start, mut ends) = (0, 0);
    loop {
        let rest = &text[start..];
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let (part, end) = rest.split_at(length);
        let end = if end.starts_with(b"\r\n") { 2 } else { end.len().min(1) };
        ends += end.min(1);
        let next = start + length + end;
        if let Some(part) = part.strip_suffix(b"\\").filter(|_| end > 0) {
            let joined = joined.get_or_insert_default();
            joined.extend_from_slice(part);
            joined.push(b' ');
            start = next;
            continue;
        }
        let line = match joined {
            Some(mut joined) => {
                joined.extend_from_slice(part);
                Cow::Owned(joined)
            }
            None => Cow::Borrowed(part),
        };
        return (line, next, ends);
    }
}

/// The words of a line.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The beginning of a word, quoted.
fn quoted(word: &[u8]) -> String {
    format!("{:?}", String::from_utf8_lossy(&word[..word.len().min(SHOWN)]))
}

const TAGS: [&str; 3] = ["v", "vt", "vn"];

/// The kind of data in a line that starts with `tag`: an index of [`TAGS`].
fn kind(tag: &[u8]) -> Option<usize> {
    TAGS.iter().position(|known| known.as_bytes() == tag)
}

/// How much there is in a file.
#[derive(Default)]
struct Sizes {
    /// Numbers of v, vt and vn lines.
    counts: [usize; 3],
    faces: usize,
    triangles: usize,
}

impl Sizes {
    fn line(&mut self, line: &[u8]) -> Result<()> {
        let mut words = words(line);
        match words.next() {
            Some(b"f") => self.face(words.count()),
            Some(tag) => {
                if let Some(kind) = kind(tag) {
                    self.counts[kind] += 1;
                }
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn face(&mut self, corners: usize) -> Result<()> {
        if corners > MAX_CORNERS {
            return Err(Error::failed(
                format!("a face has {corners} corners, more than {MAX_CORNERS}"),
                "cut large faces into triangles before exporting",
            ));
        }
        self.faces += 1;
        self.triangles += corners.saturating_sub(2);
        if self.triangles > MAX_TRIANGLES {
            let what = format!("more than {MAX_TRIANGLES} triangles");
            return Err(Error::failed(what, "simplify the mesh first"));
        }
        Ok(())
    }

    /// What positions, texture coordinates and normals take.
    fn bytes(&self) -> u64 {
        let [v, vt, vn] = self.counts.map(|count| count as u64);
        size_of::<f32>() as u64 * (3 * v + 2 * vt + 3 * vn)
    }
}

/// Indices of position, texture coordinate and normal, from 0; [`NONE`] where a corner has none.
type Indices = [u32; 3];
const NONE: u32 = u32::MAX;

/// What the lines of a file hold.
struct Geometry {
    /// Numbers of v, vt and vn lines in the whole file, and in the lines so far.
    totals: [usize; 3],
    counts: [usize; 3],
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[Indices; 3]>,
    /// Whether a face has no v, no vt, no vn.
    lacks: [bool; 3],
}

impl Geometry {
    /// Room for `sizes`.
    fn of(sizes: &Sizes) -> Self {
        Self {
            totals: sizes.counts,
            counts: [0; 3],
            positions: Vec::with_capacity(sizes.counts[0]),
            uvs: Vec::with_capacity(sizes.counts[1]),
            normals: Vec::with_capacity(sizes.counts[2]),
            triangles: Vec::with_capacity(sizes.triangles),
            lacks: [false; 3],
        }
    }

    fn line(&mut self, line: &[u8]) -> Result<()> {
        let mut words = words(line);
        let Some(tag) = words.next() else { return Ok(()) };
        if tag == b"f" {
            return self.face(words);
        }
        let Some(kind) = kind(tag) else { return Ok(()) };
        match kind {
            0 => self.positions.push(position(words)?),
            1 => self.uvs.push(numbers(kind, &mut words)?),
            _ => self.normals.push(numbers(kind, &mut words)?),
        }
        self.counts[kind] += 1;
        Ok(())
    }

    /// A face as a fan.
    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<()> {
        let (mut first, mut last) = ([NONE; 3], [NONE; 3]);
        let mut corners = 0;
        for word in words {
            let corner = self.corner(word)?;
            match corners {
                0 => first = corner,
                1 => {}
                _ => self.triangles.push([first, last, corner]),
            }
            last = corner;
            corners += 1;
        }
        if corners < 3 {
            let what = format!("a face needs 3 corners and has {corners}");
            return Err(Error::failed(what, "the file may be cut short; export it again"));
        }
        Ok(())
    }

    /// One of `v`, `v/vt`, `v//vn`, `v/vt/vn`, counted from 1, or back from the latest with −1.
    fn corner(&mut self, word: &[u8]) -> Result<Indices> {
        let malformed = || {
            let what = format!("{} is not a corner of a face", quoted(word));
            Error::failed(what, "write it as v, v/vt, v//vn or v/vt/vn")
        };
        let mut indices = [NONE; 3];
        for (kind, part) in word.split(|&b| b == b'/').enumerate() {
            if kind > 2 || (kind == 0 && part.is_empty()) {
                return Err(malformed());
            }
            if part.is_empty() {
                continue;
            }
            let index: i64 = number(part).ok_or_else(malformed)?;
            let (count, total) = (self.counts[kind] as i64, self.totals[kind] as i64);
            let from_zero = if index < 0 { count.saturating_add(index) } else { index - 1 };
            if !(0..total).contains(&from_zero) {
                return Err(no_such(index, kind, if index > 0 { total } else { count }));
            }
            indices[kind] = from_zero as u32; // a file of MAX_BYTES has fewer lines
        }
        for (lacks, index) in self.lacks.iter_mut().zip(indices) {
            *lacks |= index == NONE;
        }
        Ok(indices)
    }

    /// The triangles, each attribute looked up by its own index.
    fn into_triangles(self) -> Vec<[Corner; 3]> {
        let [_, no_uv, no_normal] = self.lacks;
        let corner = |[v, vt, vn]: Indices| Corner {
            position: self.positions[v as usize],
            normal: (!no_normal).then(|| self.normals[vn as usize]),
            uv: (!no_uv).then(|| self.uvs[vt as usize]),
        };
        self.triangles.iter().map(|triangle| triangle.map(corner)).collect()
    }
}

/// Three numbers, divided by a weight where exactly one more follows. More are colours.
fn position<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f32; 3]> {
    let position = numbers(0, &mut words)?;
    match (words.next(), words.next()) {
        (Some(word), None) => match finite(word)? {
            0.0 => Err(Error::failed("the weight of a position is 0", "repair the line")),
            weight => Ok(position.map(|x| x / weight)),
        },
        _ => Ok(position),
    }
}

/// The first `N` numbers of a line of data of `kind`.
fn numbers<'a, const N: usize>(kind: usize, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<[f32; N]> {
    let mut values = [0.0; N];
    for (i, value) in values.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            let what = format!("\"{}\" needs {N} numbers and has {i}", TAGS[kind]);
            return Err(Error::failed(what, "the file may be cut short; export it again"));
        };
        *value = finite(word)?;
    }
    Ok(values)
}

fn finite(word: &[u8]) -> Result<f32> {
    number(word)
        .filter(|value: &f32| value.is_finite())
        .ok_or_else(|| Error::failed(format!("{} is not a finite number", quoted(word)), "repair the line"))
}

fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn no_such(index: i64, kind: usize, count: i64) -> Error {
    let what = format!("a face asks for \"{}\" number {index} of {count}", TAGS[kind]);
    Error::failed(what, "count from 1, or back from -1; the file may be cut short")
}

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
