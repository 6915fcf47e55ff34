//! A page that shows an exported material in any browser with WebGL 2. It holds everything that it shows and loads nothing.
//!
//! Its parts are in `assets/export`: the document, its style, its script and the shaders that call the exported function.

use super::page_mesh::PageMesh;
use super::shader::{self, ShaderLanguage, TextureLayout};
use super::{Conformance, ExportedMaterial, ktx2};
use crate::error::{Error, Result};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;

/// Most bytes of a page: what mail servers pass on.
pub const MOST_PAGE_BYTES: usize = 10_000_000;
/// Most bytes of texels and mesh for which the page is within [`MOST_PAGE_BYTES`]: base64 has four characters for three bytes, and the rest takes up to 1 MB.
pub const MOST_PAGE_TEXELS: u64 = 6_700_000;

const DOCUMENT: &str = include_str!("../../assets/export/page.html");
const STYLE: &str = include_str!("../../assets/export/page.css");
const SCRIPT: &str = include_str!("../../assets/export/page.js");
const VERTEX: &str = include_str!("../../assets/export/vertex.glsl");
const SCENE: &str = include_str!("../../assets/export/scene.glsl");
const MESH: &str = include_str!("../../assets/export/mesh.glsl");
const MAIN: &str = include_str!("../../assets/export/main.glsl");
/// Source of the display of colours. The function that it includes is not used.
const DISPLAY: &str = include_str!("../../shaders/color.glsl");

/// Texts of a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageWords {
    /// Name of the surface.
    pub name: String,
    /// A sentence below the name.
    pub lead: String,
    /// Names and values of the most important facts.
    pub facts: Vec<(String, String)>,
    /// All other facts.
    pub more: Vec<(String, String)>,
    /// Sentences about errors.
    pub trust: Vec<String>,
    /// Publications to cite.
    pub citations: Vec<String>,
    /// Command that writes the page.
    pub command: String,
    /// Sentence at the end of the page.
    pub made: String,
    /// Lower and upper end of the colours of the heights.
    pub heights: [String; 2],
    /// Scale bar of the picture of the heights.
    pub bar: PageBar,
    /// Number of directions that the page checks itself by.
    pub directions: usize,
    /// Number of vertices and of triangles of the mesh, if there is one.
    pub mesh: Option<[usize; 2]>,
}

/// Scale bar.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageBar {
    /// Its length, in words.
    pub text: String,
    /// Its length over the width of the picture.
    pub share: f64,
}

fn no_words(e: serde_json::Error) -> Error {
    Error::bug(format!("the words of the page are no JSON ({e})")).caused_by(e)
}

/// Returns the page of `material`, which shows it on `mesh`, too, if there is one. `relief` is a picture of the heights, a PNG in base64.
///
/// # Errors
/// More bytes than [`MOST_PAGE_BYTES`].
pub fn write(
    material: &ExportedMaterial,
    words: &PageWords,
    relief: &str,
    mesh: Option<&PageMesh>,
) -> Result<String> {
    let header = &material.table.header;
    // Inside of a script element, a tag would end it.
    let about = serde_json::to_string(words).map_err(no_words)?.replace('<', "\\u003c");
    let display: String =
        DISPLAY.lines().filter(|line| !line.starts_with("#include")).fold(String::new(), |mut text, line| {
            text.push_str(line);
            text.push('\n');
            text
        });
    let page = filled(
        DOCUMENT,
        &[
            ("title", &escaped(&words.name)),
            ("style", STYLE),
            ("heights", &format!("data:image/png;base64,{relief}")),
            ("about", &about),
            ("texels", &BASE64_STANDARD.encode(ktx2::write(&material.table))),
            ("functions", &BASE64_STANDARD.encode(ktx2::write_functions(header))),
            ("directions", &BASE64_STANDARD.encode(directions(&material.conformance))),
            ("mesh", &mesh.map_or_else(String::new, |mesh| BASE64_STANDARD.encode(&mesh.bytes))),
            ("vertex", VERTEX),
            (
                "material",
                &format!(
                    "#version 300 es\n{}",
                    shader::write(header, ShaderLanguage::GlslEs, TextureLayout::Array)
                ),
            ),
            ("color", &display),
            ("scene", SCENE),
            ("mesh shader", MESH),
            ("main", MAIN),
            ("script", SCRIPT),
        ],
    );
    if page.len() > MOST_PAGE_BYTES {
        return Err(Error::limit(
            format!("the page takes {:.1} MB, and 10 MB is the most", page.len() as f64 / 1e6),
            "allow fewer bytes of texels",
        ));
    }
    Ok(page)
}

/// Returns the directions as little-endian 32-bit floats: light, viewer, footprint and the colour of the table.
fn directions(conformance: &Conformance) -> Vec<u8> {
    let row = |row: &super::ConformanceRow| {
        let (light, view, [dx, dy], rgb) = (row.pair.light, row.pair.view, row.footprint, row.of_table);
        [light.x, light.y, light.z, view.x, view.y, view.z, dx.x, dx.y, dy.x, dy.y, rgb.x, rgb.y, rgb.z]
    };
    conformance.rows.iter().flat_map(row).flat_map(|number| (number as f32).to_le_bytes()).collect()
}

/// Puts `values` in the place of `{{their names}}` in `template`. What stands in a value stays as it is.
fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut pieces = template.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, after) = piece.split_once("}}").unwrap_or(("", piece));
        text.push_str(values.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value));
        text.push_str(after);
    }
    text
}

/// Returns `text` as HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;

    fn words() -> PageWords {
        PageWords {
            name: "a <b> & {{texels}}".to_owned(),
            lead: "</script><b>".to_owned(),
            facts: vec![("name".to_owned(), "value".to_owned())],
            more: Vec::new(),
            trust: Vec::new(),
            citations: Vec::new(),
            command: String::new(),
            made: String::new(),
            heights: [String::new(), String::new()],
            bar: PageBar { text: "1 µm".to_owned(), share: 0.1 },
            directions: 1000,
            mesh: None,
        }
    }

    #[test]
    fn a_page_has_all_its_parts_and_names_cannot_become_parts_of_it() {
        let (conformance, table) = small_table();
        let material = ExportedMaterial { table, conformance };
        let page = write(&material, &words(), "PNG", None).unwrap();
        assert!(page.contains("<h1 id=\"name\">a &lt;b&gt; &amp; {{texels}}</h1>"));
        assert_eq!(page.matches("</script>").count(), page.matches("<script").count());
        assert!(page.contains("\\u003c/script>\\u003cb>") && !page.contains("<b>"));
        let texels = BASE64_STANDARD.encode(ktx2::write(&material.table));
        assert_eq!(page.matches(&texels).count(), 1);
        assert_eq!(page.matches("{{").count(), 3, "the name, in the title, the heading and the words");
        let row = &material.conformance.rows[7];
        let numbers = directions(&material.conformance);
        let at = |i: usize| f32::from_le_bytes(numbers[4 * i..4 * i + 4].try_into().unwrap());
        assert_eq!([at(7 * 13), at(7 * 13 + 12)], [row.pair.light.x as f32, row.of_table.z as f32]);
    }

    #[test]
    fn a_page_of_too_many_bytes_is_refused() {
        let (conformance, table) = small_table();
        let material = ExportedMaterial { table, conformance };
        let relief = "A".repeat(MOST_PAGE_BYTES);
        let e = write(&material, &words(), &relief, None).unwrap_err().to_string();
        assert!(e.contains("fewer bytes"), "{e}");
    }
}
