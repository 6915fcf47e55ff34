//! Wavefront OBJ files.
//!
//! All objects and groups of a file become one mesh; lines, points and colours of vertices are left out, and of materials the colour is read (`mtl.rs`). Polygons are cut into triangles,
//! concave ones too. If a single face has no texture coordinates, those of the whole file are projected as [`Corner::uv`] says, so that one
//! rule holds for all of it; normals likewise become smooth ones.
//!
//! A file is read twice. The first pass checks and counts every line, so that limits and memory are checked before a mesh is made. The
//! second pass is tobj's, over the lines that make the mesh.

use super::corner::Corner;
use super::loaded_mesh::LoadedMesh;
use super::mesh::{MAX_TRIANGLES, Mesh};
use super::mesh_colors::MeshColors;
use super::mtl;
use super::parts::Parts;
use super::polygon::PolygonCutter;
use crate::error::{Error, Result};
use crate::memory;
use crate::task::Task;
use glam::Vec3;
use std::borrow::Cow;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Byte order mark that some programs put in front of text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The byte that begins a comment.
const COMMENT: u8 = b'#';

/// Largest number of corners of one face: a second of work. Real faces have far fewer; the limit of concave ones is lower.
const MAX_CORNERS: usize = 1 << 17;

/// Peak memory per triangle while a mesh is built: measured 420 bytes for a fan of 130 000, 640 for a million that share no vertex.
const BYTES_PER_TRIANGLE: u64 = 700;

/// Text between two reports of progress \[bytes\]: some milliseconds.
const REPORT_EVERY: usize = 1 << 20;

/// Largest number of files of materials that are read.
const MAX_LIBRARIES: usize = 16;

/// Largest length of a word in an error \[characters\].
const SHOWN: usize = 40;

/// Reads the mesh in the `bytes` of the OBJ file at `path`, or only the `part` that is an object, a group or a material of this name, with the
/// colours of its `.mtl` files, which lie beside it; reports to the task.
///
/// # Errors
/// A part that the file does not have; otherwise those of [`from_bytes`]. Also a cancelled task.
pub(super) fn load(bytes: &[u8], path: &Path, part: Option<&str>, task: &Task) -> Result<LoadedMesh> {
    let (mesh, survey) = surveyed(bytes, part, task)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut loaded = LoadedMesh::new(mesh);
    let (colors, notes) = mtl::read(&survey.libraries, folder);
    loaded.notes.extend(notes);
    loaded.color(survey.colors.mean(|name| colors.get(name).copied()));
    Ok(loaded)
}

/// Reads the mesh in the text of an OBJ file.
///
/// # Errors
/// Text that is empty or not an OBJ, a line that is cut short or malformed (named by its number), an index that points at nothing, no
/// faces, more than [`MAX_TRIANGLES`], more than the memory holds; and those of [`Mesh::from_triangles`].
pub fn from_bytes(bytes: &[u8]) -> Result<Mesh> {
    parse(bytes, None, &Task::silent())
}

/// Reads the mesh of the whole of the text or of a `part`.
fn parse(bytes: &[u8], part: Option<&str>, task: &Task) -> Result<Mesh> {
    surveyed(bytes, part, task).map(|(mesh, _)| mesh)
}

/// Reads the whole of the text or a `part`, and returns the mesh with what the first pass found; fails with an error if the task is cancelled.
fn surveyed(bytes: &[u8], part: Option<&str>, task: &Task) -> Result<(Mesh, Survey)> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Error::input("the file is empty", "export the mesh as Wavefront OBJ again"));
    }
    if bytes.contains(&0) {
        return Err(not_an_obj());
    }
    // The lines that make the mesh.
    memory::ensure_room(2 * bytes.len() as u64, "the text of the mesh")?;
    let mut survey = Survey::of(bytes, part, task)?;
    memory::ensure_room(survey.triangles as u64 * BYTES_PER_TRIANGLE, "the triangles of the mesh")?;
    let models = models(&survey.geometry, task)?;
    let mut cutter = PolygonCutter::default();
    let mut triangles = Vec::new();
    for model in &models {
        cut_faces(&model.mesh, &survey, &mut cutter, task, &mut triangles)?;
    }
    drop(models);
    survey.geometry = String::new();
    Ok((Mesh::build(triangles, task)?, survey))
}

/// Reads `geometry` with tobj; fails with an error if the task is cancelled.
fn models(geometry: &str, task: &Task) -> Result<Vec<tobj::Model>> {
    let text = ToldText { text: geometry.as_bytes(), done: 0, told: 0, task };
    task.report(READING, 0, geometry.len())?;
    let options = tobj::LoadOptions::default();
    let no_materials = |_: &Path| Err(tobj::LoadError::GenericFailure);
    let read = tobj::load_obj_buf(&mut BufReader::new(text), &options, no_materials);
    task.check()?;
    let (models, _) =
        read.map_err(|e| Error::input(e.to_string(), "export the mesh as Wavefront OBJ again").caused_by(e))?;
    Ok(models)
}

/// Name of the second pass in progress reports.
const READING: &str = "reading faces";

/// Reader that reports progress and stops when cancelled.
struct ToldText<'a> {
    text: &'a [u8],
    done: usize,
    told: usize,
    task: &'a Task,
}

impl Read for ToldText<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = (&self.text[self.done..]).read(buffer)?;
        self.done += count;
        if self.done - self.told >= REPORT_EVERY {
            self.told = self.done;
            self.task.report(READING, self.done, self.text.len()).map_err(io::Error::other)?;
        }
        Ok(count)
    }
}

fn not_an_obj() -> Error {
    Error::input("this is not a Wavefront OBJ", "export the mesh as OBJ again")
}

/// Calls `act` with every line of `text`; errors name the line. Lines end in \n, \r\n or \r. A backslash at the end joins the next line, except
/// in a comment. Names and comments may be in any encoding; all other words are ASCII.
fn each_line(
    text: &[u8],
    what: &'static str,
    task: &Task,
    mut act: impl FnMut(usize, &[u8]) -> Result<()>,
) -> Result<()> {
    let (mut start, mut number, mut reported) = (0, 1, 0);
    task.report(what, 0, text.len())?;
    while start < text.len() {
        let (line, length, ends) = next_line(&text[start..]);
        act(number, &line).map_err(|e| e.at(format!("line {number}")))?;
        (start, number) = (start + length, number + ends);
        if start - reported >= REPORT_EVERY {
            task.report(what, start, text.len())?;
            reported = start;
        }
    }
    Ok(())
}

/// Returns the first line of `text` with its continuations, its length with its end \[bytes\], and the number of line ends.
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
        let continued = part.strip_suffix(b"\\").filter(|part| end > 0 && !part.contains(&COMMENT));
        if let Some(part) = continued {
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

/// Returns the beginning of a word, quoted.
fn quoted(word: &str) -> String {
    format!("{:?}", word.chars().take(SHOWN).collect::<String>())
}

/// Result of the first pass. tobj trusts indices and invents missing attributes, so each line is checked before tobj sees it.
#[derive(Default)]
struct Survey {
    /// Lines that make the mesh, unchanged; lines on which tobj would act otherwise are left out.
    geometry: String,
    /// Numbers of v, vt and vn lines so far.
    counts: [usize; 3],
    /// The largest index of each kind, and its line.
    largest: [(usize, usize); 3],
    /// First index that counts back from the latest normal before any normal, and its line.
    early_normal: Option<(i64, usize)>,
    /// True if a face has no vt, no vn.
    lacks: [bool; 3],
    triangles: usize,
    parts: Parts,
    /// Material of the current faces.
    material: Option<String>,
    /// Numbers of triangles of each material, of the selected part.
    colors: MeshColors,
    /// Names of the files of materials.
    libraries: Vec<String>,
}

const TAGS: [&str; 3] = ["v", "vt", "vn"];

/// Index of normals in [`TAGS`].
const NORMAL: usize = 2;

/// Returns the line up to its comment. Names may contain the comment sign: exporters write materials such as `Material #25`.
fn without_comment(line: &str) -> &str {
    match line.split_whitespace().next() {
        Some("v" | "vt" | "vn" | "f") => line.split(char::from(COMMENT)).next().unwrap_or(line),
        _ => line,
    }
}

impl Survey {
    fn of(text: &[u8], part: Option<&str>, task: &Task) -> Result<Self> {
        let mut survey = Self { parts: Parts::new(part), ..Self::default() };
        each_line(text, "counting faces", task, |number, line| {
            survey.line(number, &String::from_utf8_lossy(line))
        })?;
        if survey.counts == [0; 3] && survey.triangles == 0 {
            return Err(not_an_obj());
        }
        if survey.triangles == 0 {
            return Err(Error::input(
                "the OBJ has no faces",
                "export it with faces; a point cloud has no surface",
            ));
        }
        if survey.counts[NORMAL] == 0 {
            survey.drop_normals()?;
        }
        survey.check_indices()?;
        survey.parts.check()?;
        Ok(survey)
    }

    /// Fails if a face asks for a position, texture coordinate or normal beyond the last.
    fn check_indices(&self) -> Result<()> {
        if let Some((index, line)) = self.early_normal {
            return Err(no_such(index, NORMAL, 0).at(format!("line {line}")));
        }
        for (kind, &(index, line)) in self.largest.iter().enumerate() {
            if index > self.counts[kind] {
                return Err(no_such(index as i64, kind, self.counts[kind]).at(format!("line {line}")));
            }
        }
        Ok(())
    }

    /// Removes the indices of normals from the faces: other programs ignore them too in a file without normals.
    fn drop_normals(&mut self) -> Result<()> {
        if self.largest[NORMAL].0 == 0 && self.early_normal.is_none() {
            return Ok(());
        }
        memory::ensure_room(self.geometry.len() as u64, "the text of the mesh")?;
        let mut geometry = String::with_capacity(self.geometry.len());
        for line in self.geometry.lines() {
            for word in line.split(' ') {
                // v//vn becomes v, and v/vt/vn becomes v/vt.
                let kept = word.match_indices('/').nth(1).map_or(word, |(at, _)| &word[..at]);
                geometry.push_str(kept.trim_end_matches('/'));
                geometry.push(' ');
            }
            geometry.push('\n');
        }
        self.geometry = geometry;
        self.largest[NORMAL] = (0, 0);
        self.early_normal = None;
        self.lacks[NORMAL] = true;
        Ok(())
    }

    fn line(&mut self, number: usize, line: &str) -> Result<()> {
        let line = without_comment(line);
        // The corners of a face are counted before they are listed: a list takes eight times the text.
        let corners = line.split_whitespace().skip(1).count();
        if corners > MAX_CORNERS && line.split_whitespace().next() == Some("f") {
            return Err(Error::input(
                format!("a face has {corners} corners, more than {MAX_CORNERS}"),
                "cut large faces into triangles before exporting",
            ));
        }
        // No other line has as many relevant words.
        let words: Vec<&str> = line.split_whitespace().take(MAX_CORNERS + 1).collect();
        let kept = match words.first() {
            // A fourth number is a weight; more are colours, which would only be refused for odd counts.
            Some(&"v") => self.numbers(0, 3, &words[1..]).map(|()| if words.len() == 5 { 5 } else { 4 })?,
            Some(&"vt") => self.numbers(1, 2, &words[1..]).map(|()| 3)?,
            Some(&"vn") => self.numbers(2, 3, &words[1..]).map(|()| 4)?,
            Some(&"f") => {
                self.face(number, &words[1..])?;
                if !self.parts.keeps() {
                    return Ok(());
                }
                // A face of n corners is n − 2 triangles.
                self.colors.add(self.material.as_deref(), words.len() - 3);
                words.len()
            }
            _ => {
                self.name(&words);
                return Ok(());
            }
        };
        for word in &words[..kept] {
            self.geometry.push_str(word);
            self.geometry.push(' ');
        }
        self.geometry.push('\n');
        Ok(())
    }

    /// Reads a line that names the object, group or material of the faces behind it, or the files of materials.
    fn name(&mut self, words: &[&str]) {
        let Some((keyword, names)) = words.split_first() else { return };
        let kind = match *keyword {
            "o" => 0,
            "g" => 1,
            "usemtl" => {
                self.material = Some(names.join(" "));
                2
            }
            "mtllib" => {
                if self.libraries.len() < MAX_LIBRARIES {
                    self.libraries.push(names.join(" "));
                }
                return;
            }
            _ => return,
        };
        self.parts.set(kind, names.iter().map(|&name| name.to_owned()).collect());
    }

    /// Reads a line of at least `least` numbers.
    fn numbers(&mut self, kind: usize, least: usize, words: &[&str]) -> Result<()> {
        // A position may have a weight, which is a number as well.
        let checked = if kind == 0 && words.len() == 4 { 4 } else { least };
        for word in words.iter().take(checked) {
            if !word.parse::<f32>().is_ok_and(f32::is_finite) {
                return Err(Error::input(
                    format!("{} is not a finite number", quoted(word)),
                    "repair the line",
                ));
            }
        }
        if checked == 4 && words[3].parse() == Ok(0f32) {
            return Err(Error::input("the weight of a position is 0", "repair the line"));
        }
        if words.len() < least {
            let what = format!("\"{}\" needs {least} numbers and has {}", TAGS[kind], words.len());
            return Err(Error::input(what, "the file may be cut short; export it again"));
        }
        self.counts[kind] += 1;
        Ok(())
    }

    fn face(&mut self, number: usize, words: &[&str]) -> Result<()> {
        let corners = words.len();
        for word in words {
            self.corner(number, word)?;
        }
        if corners < 3 {
            let what = format!("a face needs 3 corners and has {corners}");
            return Err(Error::input(what, "the file may be cut short; export it again"));
        }
        self.triangles += corners - 2;
        if self.triangles > MAX_TRIANGLES {
            return Err(Error::input(
                format!("more than {MAX_TRIANGLES} triangles"),
                "simplify the mesh first",
            ));
        }
        Ok(())
    }

    /// Reads one of `v`, `v/vt`, `v//vn`, `v/vt/vn`, counted from 1, or back from the latest with −1.
    fn corner(&mut self, number: usize, word: &str) -> Result<()> {
        let malformed = || {
            Error::input(
                format!("{} is not a corner of a face", quoted(word)),
                "write it as v, v/vt, v//vn or v/vt/vn",
            )
        };
        let mut given = [false; 3];
        for (kind, part) in word.split('/').enumerate() {
            if kind > 2 || (kind == 0 && part.is_empty()) {
                return Err(malformed());
            }
            if part.is_empty() {
                continue;
            }
            let index: i64 = part.parse().map_err(|_| malformed())?;
            let count = self.counts[kind];
            let is_early = kind == NORMAL && count == 0 && index < 0;
            if index == 0 || (index < 0 && index.unsigned_abs() > count as u64 && !is_early) {
                return Err(no_such(index, kind, count));
            }
            if is_early {
                self.early_normal.get_or_insert((index, number));
            }
            if index > self.largest[kind].0 as i64 {
                self.largest[kind] = (index as usize, number);
            }
            given[kind] = true;
        }
        for (lacks, given) in self.lacks.iter_mut().zip(given) {
            *lacks |= !given;
        }
        Ok(())
    }
}

fn no_such(index: i64, kind: usize, count: usize) -> Error {
    let what = format!("a face asks for \"{}\" number {index} of {count}", TAGS[kind]);
    Error::input(what, "count from 1, or back from -1; the file may be cut short")
}

/// Corners between two reports of progress: some milliseconds.
const CORNERS_A_REPORT: usize = 1 << 16;

/// Adds the faces of one tobj mesh to `triangles`; positions, texture coordinates and normals have separate indices.
fn cut_faces(
    mesh: &tobj::Mesh,
    survey: &Survey,
    cutter: &mut PolygonCutter,
    task: &Task,
    triangles: &mut Vec<[Corner; 3]>,
) -> Result<()> {
    let [_, no_uv, no_normal] = survey.lacks;
    let three = |values: &[f32], i: u32| [0, 1, 2].map(|c| values[3 * i as usize + c]);
    let corner = |k: usize| Corner {
        position: three(&mesh.positions, mesh.indices[k]),
        normal: (!no_normal).then(|| three(&mesh.normals, mesh.normal_indices[k])),
        uv: (!no_uv).then(|| [0, 1].map(|c| mesh.texcoords[2 * mesh.texcoord_indices[k] as usize + c])),
    };
    let mut positions = Vec::new();
    let (mut first, mut reported) = (0, 0);
    for count in face_sizes(mesh) {
        positions.clear();
        let corners = first..first + count;
        positions.extend(corners.map(|k| Vec3::from(three(&mesh.positions, mesh.indices[k])).as_dvec3()));
        let numbers = cutter.cut(&positions)?;
        triangles.extend(numbers.chunks_exact(3).map(|t| [0, 1, 2].map(|k| corner(first + t[k] as usize))));
        first += count;
        if first - reported >= CORNERS_A_REPORT {
            task.report("cutting faces into triangles", first, mesh.indices.len())?;
            reported = first;
        }
    }
    Ok(())
}

/// Returns the number of corners of each face. tobj lists none if all faces are triangles.
fn face_sizes(mesh: &tobj::Mesh) -> impl Iterator<Item = usize> {
    let listed = mesh.face_arities.iter().map(|&count| count as usize);
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    listed.chain((0..triangles).map(|_| 3))
}

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
