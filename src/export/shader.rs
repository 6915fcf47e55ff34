//! The function that reads an export, in GLSL: `material.glsl` for OpenGL and Vulkan, `material.es.glsl` for OpenGL ES 3.0 and WebGL 2; `material2d.glsl` and
//! `material2d.es.glsl` read plain images instead of an array with levels.
//!
//! All are put together from the shaders of this program, `shaders/table.glsl` and what it needs, with the numbers of the table as constants. Every name that they declare
//! begins with `diffract`.

use super::flat::FlatLayout;
use super::ktx2::function_rows;
use crate::optics::factor::IndexTriple;
use crate::optics::polarisation::Polarisation;
use crate::table::{SPECULAR_SAMPLES, TableHeader};
use std::collections::BTreeSet;

/// Language of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderLanguage {
    /// GLSL 4.5, for OpenGL and Vulkan.
    Glsl,
    /// GLSL ES 3.0, for OpenGL ES and WebGL 2.
    GlslEs,
}

/// Textures that a shader reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureLayout {
    /// A 2D array with levels, `table.ktx2` and `functions.ktx2`.
    Array,
    /// Plain images, `table2d.exr` and `functions.exr`.
    Flat,
}

/// Precision of the numbers of GLSL ES.
const GLSL_ES: &str = "\
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
";

/// Type of the numbers of an export.
const ACCESS: &str = include_str!("../../shaders/export/access.glsl");
/// Textures of both layouts, and their texels.
const ARRAY: &str = include_str!("../../shaders/export/array.glsl");
const FLAT: &str = include_str!("../../shaders/export/flat.glsl");
/// Shader with the equations of the refractive indices, which follow it.
const SMALL_SLOPE: &str = include_str!("../../shaders/small_slope.glsl");
/// Further shaders that the function consists of, each after those that it calls.
const PARTS: [&str; 6] = [
    include_str!("../../shaders/export/access_reads.glsl"),
    include_str!("../../shaders/pair.glsl"),
    include_str!("../../shaders/footprint.glsl"),
    include_str!("../../shaders/table.glsl"),
    include_str!("../../shaders/linear_srgb.glsl"),
    include_str!("../../shaders/export/entry.glsl"),
];

/// Line that tells where GLSL stands.
pub(super) const PLACE_OF_GLSL: &str =
    "// It stands behind #version 450, or what your program puts in front of shaders.\n";

/// Hint to unroll a loop, which needs an extension.
const UNROLL: &str = "UNROLL ";

/// Returns the shader that reads the table of `header`. Its last two functions are `diffract_uv` and `diffract_rgb`.
pub fn write(header: &TableHeader, language: ShaderLanguage, layout: TextureLayout) -> String {
    let (version, precision) = match language {
        ShaderLanguage::Glsl => ("#version 450", ""),
        ShaderLanguage::GlslEs => ("#version 300 es", GLSL_ES),
    };
    let (files, numbers_of_layout, textures) = match layout {
        TextureLayout::Array => ("table.ktx2, diffract_functions is functions.ktx2", String::new(), ARRAY),
        TextureLayout::Flat => {
            ("table2d.exr, diffract_functions is functions.exr", flat_numbers(header), FLAT)
        }
    };
    let before = [ACCESS, &numbers(header), &numbers_of_layout, "\n", SMALL_SLOPE, &medium(header)].concat();
    let text = [&before, textures].into_iter().chain(PARTS).collect::<Vec<_>>().join("\n");
    let text = prefixed(&text.replace(UNROLL, ""));
    let about = concat!(
        "// Diffraction of a surface, written by diffract ",
        env!("CARGO_PKG_VERSION"),
        ". Call diffract_rgb, the last function below.\n"
    );
    let place = PLACE_OF_GLSL.replace("#version 450", version);
    format!("{about}// Textures: diffract_table is {files}.\n{place}\n{precision}{text}")
}

/// Returns the definitions of the places of a table in plain images.
fn flat_numbers(header: &TableHeader) -> String {
    let FlatLayout { side, layers, columns, .. } = FlatLayout::new(header);
    format!(
        "
const int FLAT_SIDE = {side}; // texels along a side of a layer of the finest level
const int FLAT_LAYERS = {layers}; // of each level
const int FLAT_COLUMNS = {columns}; // layers in a row of the finest level
const int FLAT_HEIGHT = {height}; // lines of table2d.exr
const int FUNCTIONS_HEIGHT = {functions_height}; // lines of functions.exr
const bool LAST_ROW_FIRST = false; // set it to true if your loader puts the last line of an image first, as that of three.js does
",
        height = FlatLayout::new(header).height(),
        functions_height = function_rows(header).len() / SPECULAR_SAMPLES,
    )
}

/// Returns the definitions of the numbers of a table.
fn numbers(header: &TableHeader) -> String {
    let grid = &header.grid;
    let number = |x: f64| format!("{:?}", x as f32);
    let values = [
        number(0.5 / grid.extent),
        number(header.coherence_blur),
        number(header.unit),
        number(grid.finest.powi(2)),
        number(grid.growth.powi(-2)),
        number(header.basis.pieces as f64),
        number((grid.levels - 1) as f64),
    ];
    let bands = header.specular.variances.len();
    let (rows, law) =
        ((4 * bands - 1) / 3 + 1, if header.indices.is_some() { SMALL_SLOPE_INDICES } else { SPECTRAL });
    let polarisation = header.indices.map_or(Polarisation::None, |indices| indices.polarisation);
    let polarisation = polarisation.number();
    format!(
        "
const Table source = Table({values});

const int TEXELS = {texels}; // that a direction reads at each place, of four coordinates each
const int BANDS = {bands}; // of wavelengths of the specular order
const int FIRST_CUBIC = {rows}; // row of the cubics of the first piece
const int FIRST_ENERGY = {first_energy}; // row of the first points of the limit of energy
const int FACTOR_LAW = {law}; // see below
const int POLARISATION = {polarisation}; // of the light: 0 none, 1 TE, 2 TM
const bool LIMITED = {limited}; // whether the surface reflects no more than a flat one
",
        values = values.join(", "),
        texels = header.basis.texels(),
        first_energy = rows + header.basis.pieces,
        limited = header.energy.is_some(),
    )
}

/// Laws of the factor, as in `shaders/pair.glsl`.
const SPECTRAL: u32 = 0;
const SMALL_SLOPE_INDICES: u32 = 4;

/// Returns the refractive indices of the factor. Their name is that of no parameter, which Godot would refuse.
fn medium(header: &TableHeader) -> String {
    let triple = |of: fn(&IndexTriple) -> [f64; 3], other: f64| {
        let [x, y, z] = header.indices.as_ref().map_or([other; 3], of).map(|x| format!("{:?}", x as f32));
        format!("vec3({x}, {y}, {z})")
    };
    let (n, k) = (triple(|indices| indices.n, 1.0), triple(|indices| indices.k, 0.0));
    format!("\nconst Medium indices = Medium({n}, {k});\n")
}

/// A piece of GLSL.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Token<'a> {
    /// Identifier or keyword.
    Word(&'a str),
    /// Comment, line of the preprocessor, white space.
    Blank(&'a str),
    /// Anything else, such as a number or a sign.
    Other(&'a str),
}

/// Cuts GLSL into tokens, which joined together are the text again.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end_of = |stop: &dyn Fn(char) -> bool| rest.find(stop).unwrap_or(rest.len());
        let length = if rest.starts_with("//") || first == '#' {
            end_of(&|c| c == '\n')
        } else if first.is_whitespace() {
            end_of(&|c| !c.is_whitespace())
        } else if is_word(first) {
            end_of(&|c| !is_word(c))
        } else {
            first.len_utf8()
        };
        let (piece, after) = rest.split_at(length);
        found.push(if rest.starts_with("//") || first == '#' || first.is_whitespace() {
            Token::Blank(piece)
        } else if is_word(first) && !first.is_ascii_digit() {
            Token::Word(piece)
        } else {
            Token::Other(piece)
        });
        rest = after;
    }
    found
}

/// Returns the names that `tokens` without blanks declare outside of braces and parentheses.
fn declared<'a>(tokens: &[Token<'a>]) -> BTreeSet<&'a str> {
    let mut depth = 0;
    let mut names = BTreeSet::new();
    for (i, token) in tokens.iter().enumerate() {
        match *token {
            Token::Other("(" | "{" | "[") => depth += 1,
            Token::Other(")" | "}" | "]") => depth -= 1,
            Token::Word(name) if depth == 0 => {
                let follows_type = i > 0 && matches!(tokens[i - 1], Token::Word(_));
                let ends = matches!(tokens.get(i + 1), Some(Token::Other("(" | "=" | ";" | "{")));
                if follows_type && ends {
                    names.insert(name);
                }
            }
            _ => {}
        }
    }
    names
}

/// Gives every name that `text` declares a prefix, but for members of structures and for variables of functions.
fn prefixed(text: &str) -> String {
    let all = tokens(text);
    let dense: Vec<Token<'_>> = all.iter().copied().filter(|t| !matches!(t, Token::Blank(_))).collect();
    let names = declared(&dense);
    let mut result = String::with_capacity(text.len() * 5 / 4);
    let (mut place, mut in_struct) = (0, false);
    for token in all {
        match token {
            Token::Blank(piece) => {
                result.push_str(piece);
                continue;
            }
            Token::Word(name) if names.contains(name) => {
                let after_dot = place > 0 && dense[place - 1] == Token::Other(".");
                let member = in_struct && matches!(dense.get(place + 1), Some(Token::Other(";" | "[")));
                result.push_str(&if after_dot || member { name.to_owned() } else { renamed(name) });
            }
            Token::Word(piece) | Token::Other(piece) => result.push_str(piece),
        }
        in_struct = token == Token::Word("struct") || in_struct && token != Token::Other("}");
        place += 1;
    }
    result
}

/// Returns `name` with a prefix in its own style.
fn renamed(name: &str) -> String {
    if name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_') {
        format!("DIFFRACT_{name}")
    } else if name.starts_with(|c: char| c.is_ascii_uppercase()) {
        format!("Diffract{name}")
    } else {
        format!("diffract_{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;

    #[test]
    fn names_of_the_outermost_scope_get_a_prefix_and_no_others() {
        let text = "// f of Ab\nconst float PI = 3.0;\nstruct Ab { float f; Bc f2; };\nfloat f(Ab a) {\n    float g = a.f; // f\n    return PI * f(a) + mat3(g);\n}\n";
        let expected = "// f of Ab\nconst float DIFFRACT_PI = 3.0;\nstruct DiffractAb { float f; Bc f2; };\nfloat diffract_f(DiffractAb a) {\n    float g = a.f; // f\n    return DIFFRACT_PI * diffract_f(a) + mat3(g);\n}\n";
        assert_eq!(prefixed(text), expected);
    }

    #[test]
    fn shaders_of_both_languages_differ_in_their_precision_alone_and_declare_prefixed_names() {
        let (_, table) = small_table();
        for layout in [TextureLayout::Array, TextureLayout::Flat] {
            let glsl = write(&table.header, ShaderLanguage::Glsl, layout);
            let es = write(&table.header, ShaderLanguage::GlslEs, layout);
            assert_eq!(glsl.replace("#version 450", "#version 300 es"), es.replace(GLSL_ES, ""));
            assert!(!glsl.lines().chain(es.lines()).any(|line| line.starts_with("#version")));
            assert_declares_prefixed_names(&glsl);
        }
    }

    fn assert_declares_prefixed_names(glsl: &str) {
        let found = tokens(glsl);
        let dense: Vec<_> = found.into_iter().filter(|t| !matches!(t, Token::Blank(_))).collect();
        let names = declared(&dense);
        for name in ["diffract_rgb", "diffract_uv", "diffract_table", "diffract_functions", "DiffractPair"] {
            assert!(names.contains(name), "{name} in {names:?}");
        }
        assert!(names.iter().all(|name| name.to_lowercase().starts_with("diffract")), "{names:?}");
        assert!(!glsl.contains("UNROLL") && !glsl.contains("#include") && !glsl.contains("constant_id"));
    }

    #[test]
    fn the_place_of_the_cubics_is_that_of_the_functions() {
        let (_, table) = small_table();
        let rows = table.header.specular_rows().len() / SPECULAR_SAMPLES;
        assert!(numbers(&table.header).contains(&format!("const int FIRST_CUBIC = {rows};")));
        assert!(ACCESS.contains(&format!("const float COLUMNS = {}.0;", SPECULAR_SAMPLES)));
        let side = crate::optics::energy::DirectionGrid::SIDE;
        assert!(ACCESS.contains(&format!("const float SIDE = {side}.0;")));
    }
}
