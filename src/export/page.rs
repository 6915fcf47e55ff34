//! A page that shows an exported material in any browser with WebGL 2. It holds everything that it shows and loads nothing.
//!
//! Its parts are in `assets/export`: the document, its style, its script and the shaders that call the exported function.

use super::page_light::PageLight;
use super::page_mesh::PageMesh;
use super::page_text::{definitions, escaped, filled, items, source_of};
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
/// Style where scripts do not run.
const STILL_STYLE: &str = include_str!("../../assets/export/still.css");
/// Parts of the script, in the order in which they run.
const SCRIPT: &str = concat!(
    include_str!("../../assets/export/device.js"),
    include_str!("../../assets/export/drawing.js"),
    include_str!("../../assets/export/hands.js"),
    include_str!("../../assets/export/page.js"),
);
const VERTEX: &str = include_str!("../../assets/export/vertex.glsl");
/// Parts of the fragment shader behind the material and the display of colours.
const SCENE: &str = concat!(
    include_str!("../../assets/export/scene.glsl"),
    include_str!("../../assets/export/mesh.glsl"),
    include_str!("../../assets/export/surroundings.glsl"),
    include_str!("../../assets/export/main.glsl"),
);
/// Source of the display of colours. The function that it includes is not used.
const DISPLAY: &str = include_str!("../../shaders/color.glsl");

/// Texts of a page.
#[derive(Clone, Debug, PartialEq)]
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
}

/// Scale bar.
#[derive(Clone, Debug, PartialEq)]
pub struct PageBar {
    /// Its length, in words.
    pub text: String,
    /// Its length over the width of the picture.
    pub share: f64,
}

/// Pictures of a page, PNGs in base64.
#[derive(Clone, Debug, PartialEq)]
pub struct PagePictures {
    /// Heights.
    pub relief: String,
    /// Sphere for browsers that cannot draw it, and until they have.
    pub still: String,
}

/// Numbers and names that the script reads.
#[derive(Serialize)]
struct About<'a> {
    name: &'a str,
    bar: f64,
    directions: usize,
    /// Number of vertices and of triangles of the mesh, if there is one.
    mesh: Option<[usize; 2]>,
    /// Number of parts of the surroundings, and width of their picture.
    surroundings: [usize; 2],
}

fn no_words(e: serde_json::Error) -> Error {
    Error::bug(format!("the words of the page are no JSON ({e})")).caused_by(e)
}

/// Returns the page of `material` in the surroundings `light`, which shows it on `mesh`, too, if there is one.
///
/// # Errors
/// More bytes than [`MOST_PAGE_BYTES`].
pub fn write(
    material: &ExportedMaterial,
    words: &PageWords,
    pictures: &PagePictures,
    light: &PageLight,
    mesh: Option<&PageMesh>,
) -> Result<String> {
    let header = &material.table.header;
    let about = About {
        name: &words.name,
        bar: words.bar.share,
        directions: words.directions,
        mesh: mesh.map(|mesh| [mesh.vertices, mesh.triangles]),
        surroundings: [light.parts.len(), light.width],
    };
    // Inside of a script element, a tag would end it.
    let about = serde_json::to_string(&about).map_err(no_words)?.replace('<', "\\u003c");
    let shader = shader::write(header, ShaderLanguage::GlslEs, TextureLayout::Array);
    let display: String =
        DISPLAY.lines().filter(|line| !line.starts_with("#include")).flat_map(|line| [line, "\n"]).collect();
    let picture = |png: &str| format!("data:image/png;base64,{png}");
    let packed = |bytes: &[u8]| BASE64_STANDARD.encode(bytes);
    let parts = [
        ("policy", policy()),
        ("style", STYLE.to_owned()),
        ("still style", STILL_STYLE.to_owned()),
        ("relief", picture(&pictures.relief)),
        ("still", picture(&pictures.still)),
        ("about", about),
        ("texels", packed(&ktx2::write(&material.table))),
        ("functions", packed(&ktx2::write_functions(header))),
        ("directions", packed(&directions(&material.conformance))),
        ("surroundings", packed(&light.bytes())),
        ("mesh", mesh.map_or_else(String::new, |mesh| packed(&mesh.bytes))),
        ("vertex", VERTEX.to_owned()),
        ("material", format!("#version 300 es\n{shader}")),
        ("color", display),
        ("scene", SCENE.to_owned()),
        ("script", SCRIPT.to_owned()),
    ];
    let texts = in_html(words);
    let values: Vec<_> = parts.iter().chain(&texts).map(|(name, text)| (*name, text.as_str())).collect();
    let page = filled(DOCUMENT, &values);
    if page.len() > MOST_PAGE_BYTES {
        return Err(Error::limit(
            format!("the page takes {:.1} MB, and 10 MB is the most", page.len() as f64 / 1e6),
            "allow fewer bytes of texels",
        ));
    }
    Ok(page)
}

/// Returns the Content-Security-Policy of a page: its script, its styles and its pictures, and nothing from elsewhere.
fn policy() -> String {
    // The document has a line break on both sides of each.
    let [script, style, still] = [SCRIPT, STYLE, STILL_STYLE].map(|text| source_of(&format!("\n{text}\n")));
    format!(
        "default-src 'none'; script-src {script}; style-src {style} {still}; img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
}

/// Returns `words` as HTML, by the names that the document has for them.
fn in_html(words: &PageWords) -> Vec<(&'static str, String)> {
    vec![
        ("title", escaped(&words.name)),
        ("lead", escaped(&words.lead)),
        ("facts", definitions(&words.facts)),
        ("more", definitions(&words.more)),
        ("trust", items(&words.trust)),
        ("citations", items(&words.citations)),
        ("command", escaped(&words.command)),
        ("made", escaped(&words.made)),
        ("low", escaped(&words.heights[0])),
        ("high", escaped(&words.heights[1])),
        ("bar", escaped(&words.bar.text)),
    ]
}

/// Returns the directions as little-endian 32-bit floats: light, viewer, footprint and the colour of the table.
fn directions(conformance: &Conformance) -> Vec<u8> {
    let row = |row: &super::ConformanceRow| {
        let (light, view, [dx, dy], rgb) = (row.pair.light, row.pair.view, row.footprint, row.of_table);
        [light.x, light.y, light.z, view.x, view.y, view.z, dx.x, dx.y, dy.x, dy.y, rgb.x, rgb.y, rgb.z]
    };
    conformance.rows.iter().flat_map(row).flat_map(|number| (number as f32).to_le_bytes()).collect()
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
        }
    }

    fn page(relief: &str) -> Result<String> {
        let (conformance, table) = small_table();
        let pictures = PagePictures { relief: relief.to_owned(), still: "STILL".to_owned() };
        let light = PageLight::new("studio").unwrap();
        write(&ExportedMaterial { table, conformance }, &words(), &pictures, &light, None)
    }

    #[test]
    fn a_page_has_all_its_parts_and_names_cannot_become_parts_of_it() {
        let page = page("PNG").unwrap();
        let (conformance, table) = small_table();
        assert!(page.contains("<h1 id=\"name\">a &lt;b&gt; &amp; {{texels}}</h1>"));
        assert_eq!(page.matches("</script>").count(), page.matches("<script").count());
        assert!(
            page.contains("&lt;/script&gt;&lt;b&gt;") && page.contains("\\u003cb>") && !page.contains("<b>")
        );
        let texels = BASE64_STANDARD.encode(ktx2::write(&table));
        assert_eq!(page.matches(&texels).count(), 1);
        assert_eq!(page.matches("{{").count(), 3, "the name, in the title, the heading and the words");
        let row = &conformance.rows[7];
        let numbers = directions(&conformance);
        let at = |i: usize| f32::from_le_bytes(numbers[4 * i..4 * i + 4].try_into().unwrap());
        assert_eq!([at(7 * 13), at(7 * 13 + 12)], [row.pair.light.x as f32, row.of_table.z as f32]);
    }

    #[test]
    fn the_policy_names_every_script_and_style_of_the_page() {
        let page = page("PNG").unwrap();
        let policy = page.split_once("Security-Policy\" content=\"").unwrap().1.split_once('"').unwrap().0;
        let mut named = 0;
        for (open, close) in [("<style>", "</style>"), ("<script>", "</script>")] {
            for (at, _) in page.match_indices(open) {
                let content = page[at + open.len()..].split_once(close).unwrap().0;
                assert!(policy.contains(&source_of(content)), "{open} at {at}");
                named += 1;
            }
        }
        assert_eq!(named, 3);
        assert!(!policy.contains("unsafe"));
    }

    #[test]
    fn a_page_of_too_many_bytes_is_refused() {
        let e = page(&"A".repeat(MOST_PAGE_BYTES)).unwrap_err().to_string();
        assert!(e.contains("fewer bytes"), "{e}");
    }
}
