//! The function that reads an export in WGSL and HLSL, translated from its GLSL by naga. It takes textures and samplers as parameters, so that it stands in any program
//! as it is: no bindings, no registers.

use super::parameters::with_parameters;
use super::shader::{self, ShaderLanguage, TextureLayout};
use crate::error::{Error, Result};
use crate::table::TableHeader;
use naga::back::{hlsl, wgsl};
use naga::front::glsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};

/// Declarations of GLSL and those with textures and samplers apart, which both languages have.
const APART: [(&str, &str); 4] = [
    ("#ifndef DIFFRACT_LAYOUT\n#define DIFFRACT_LAYOUT(number)\n#endif\n", ""),
    (
        "DIFFRACT_LAYOUT(0) uniform sampler2DArray diffract_table;",
        "layout(set = 0, binding = 0) uniform texture2DArray diffract_table_texture;
layout(set = 0, binding = 1) uniform sampler diffract_table_sampler;
#define diffract_table sampler2DArray(diffract_table_texture, diffract_table_sampler)",
    ),
    (
        "DIFFRACT_LAYOUT(0) uniform sampler2D diffract_table;",
        "layout(set = 0, binding = 0) uniform texture2D diffract_table_texture;
layout(set = 0, binding = 1) uniform sampler diffract_table_sampler;
#define diffract_table sampler2D(diffract_table_texture, diffract_table_sampler)",
    ),
    (
        "DIFFRACT_LAYOUT(1) uniform sampler2D diffract_functions;",
        "layout(set = 0, binding = 2) uniform texture2D diffract_functions_texture;
#define diffract_functions sampler2D(diffract_functions_texture, diffract_table_sampler)",
    ),
];

/// Order of the lines of images in HLSL.
const LAST_ROW_FIRST: &str = "\
// Define it as true in front if your loader puts the last line of an image first, as that of Unity does.
#ifndef DIFFRACT_LAST_ROW_FIRST
#define DIFFRACT_LAST_ROW_FIRST false
#endif
";

/// End of the program, which the translator asks for.
const MAIN: &str = "void main() {}\n";

/// Returns the shader that reads the table of `header` in WGSL.
///
/// # Errors
/// Never, because all tables give the same program but for numbers.
pub fn write_wgsl(header: &TableHeader, layout: TextureLayout) -> Result<String> {
    let (module, info) = parsed(header, layout)?;
    let text = wgsl::write_string(&module, &info, wgsl::WriterFlags::empty()).map_err(failed)?;
    let about = concat!(
        "// Diffraction of a surface, translated from material.glsl of diffract ",
        env!("CARGO_PKG_VERSION"),
        ". Call diffract_rgb, the last function below.\n"
    );
    Ok(format!("{about}{}{}", textures(layout, "nearest"), without_main(&text)?))
}

/// Returns the same in HLSL, shader model 5.1.
///
/// # Errors
/// Same as [`write_wgsl`].
pub fn write_hlsl(header: &TableHeader, layout: TextureLayout) -> Result<String> {
    let (module, info) = parsed(header, layout)?;
    let options = hlsl::Options::default();
    let pipeline = hlsl::PipelineOptions::default();
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &pipeline).write(&module, &info, None).map_err(failed)?;
    let about = concat!(
        "// Diffraction of a surface, translated from material.glsl of diffract ",
        env!("CARGO_PKG_VERSION"),
        ". Call diffract_rgb, the last function below; frame is float3x3(T, B, N).\n"
    );
    Ok(format!("{about}{}{}", textures(layout, "point"), without_main(&in_plain_hlsl(&text))?))
}

/// Returns the comment on the textures of `layout`, where the texels of the `nearest` level are read.
fn textures(layout: TextureLayout, nearest: &str) -> String {
    match layout {
        TextureLayout::Array => format!(
            "// table_texture is table.ktx2 with table_sampler: linear, {nearest} between levels, clamped. functions_texture is functions.ktx2.\n\n"
        ),
        TextureLayout::Flat => {
            "// table_texture is table2d.exr, functions_texture is functions.exr; no sampler is needed.\n\n"
                .to_owned()
        }
    }
}

/// Parses and validates the GLSL of `header`.
fn parsed(header: &TableHeader, layout: TextureLayout) -> Result<(Module, ModuleInfo)> {
    let mut text = format!("#version 450\n{}{MAIN}", shader::write(header, ShaderLanguage::Glsl, layout));
    for (combined, apart) in APART {
        text = text.replace(combined, apart);
    }
    let options = glsl::Options::from(ShaderStage::Fragment);
    let mut module = glsl::Frontend::default().parse(&options, &text).map_err(failed)?;
    module.entry_points.clear();
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    let info = validator.validate(&module).map_err(|e| failed(e.into_inner()))?;
    let module = with_parameters(module, &info, |name| name.trim_start_matches("diffract_"));
    let info = validator.validate(&module).map_err(|e| failed(e.into_inner()))?;
    Ok((module, info))
}

/// Returns the error for a reading function that cannot be translated.
fn failed(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    not_translated(&cause).caused_by(cause)
}

fn not_translated(reason: &dyn std::fmt::Display) -> Error {
    Error::bug(format!("the reading function cannot be translated ({reason})"))
}

/// Cuts off the empty main function, which is the last one.
fn without_main(text: &str) -> Result<&str> {
    let end = ["\nfn main", "\nvoid main"].iter().find_map(|begin| text.rfind(begin));
    end.map(|end| &text[..end]).ok_or_else(|| not_translated(&"it has no end"))
}

/// Returns naga's HLSL `text` without what only a program of wgpu has, or only some compilers take, and with names that begin with `diffract`.
fn in_plain_hlsl(text: &str) -> String {
    let line = |line: &str| {
        if is_padding(line) {
            String::new()
        } else if line.starts_with("static const bool DIFFRACT_LAST_ROW_FIRST =") {
            LAST_ROW_FIRST.to_owned()
        } else if line.starts_with("static const ") {
            with_braces(line) + "\n"
        } else {
            format!("{line}\n")
        }
    };
    prefixed(&text.lines().map(line).collect::<String>())
}

/// Gives naga's helpers in `text` the prefix of all other names.
fn prefixed(text: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut written = String::with_capacity(text.len() * 11 / 10);
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        written.push_str(match word {
            word if word.starts_with("Construct") || word.starts_with("Naga") => "Diffract",
            word if word.starts_with("naga_") || word.starts_with("ret_Construct") => "diffract_",
            _ => "",
        });
        written.push_str(word);
        let next = after.find(is_word).unwrap_or(after.len());
        written.push_str(&after[..next]);
        rest = &after[next..];
    }
    written
}

/// Returns true for a member that pads a structure for buffers. These structures stand in none, and lists of their members leave it out.
fn is_padding(line: &str) -> bool {
    let name = line.trim().strip_prefix("int _").and_then(|name| name.strip_suffix(';'));
    name.is_some_and(|name| name.trim_start_matches("end_").starts_with("pad"))
}

/// Writes the constructors in a constant as lists in braces: glslang refuses some constants that call a function, and crashes on others.
fn with_braces(line: &str) -> String {
    const CONSTRUCTOR: &str = "Construct";
    let mut written = String::with_capacity(line.len());
    let mut ends = Vec::new();
    for c in line.chars() {
        let next = match c {
            '(' => {
                let name = written.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |at| at + 1);
                let is_list = written[name..].starts_with(CONSTRUCTOR);
                if is_list {
                    written.truncate(name);
                }
                ends.push(if is_list { '}' } else { ')' });
                if is_list { '{' } else { '(' }
            }
            ')' => ends.pop().unwrap_or(')'),
            c => c,
        };
        written.push(next);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;

    #[test]
    fn wgsl_is_valid_and_ends_with_the_function() {
        let (_, table) = small_table();
        for layout in [TextureLayout::Array, TextureLayout::Flat] {
            assert_is_valid_wgsl(&write_wgsl(&table.header, layout).unwrap());
        }
    }

    fn assert_is_valid_wgsl(text: &str) {
        let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text)).unwrap();
        Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
        let (_, last) = module.functions.iter().last().unwrap();
        assert_eq!(last.name.as_deref(), Some("diffract_rgb"));
        assert_eq!(module.global_variables.len(), 0);
        let broken = text.replace("fn diffract_uv", "fn diffract_xy(");
        assert!(naga::front::wgsl::parse_str(&broken).is_err());
    }

    #[test]
    fn hlsl_has_no_registers_and_no_heap() {
        let (_, table) = small_table();
        for layout in [TextureLayout::Array, TextureLayout::Flat] {
            assert_is_plain_hlsl(&write_hlsl(&table.header, layout).unwrap());
        }
    }

    fn assert_is_plain_hlsl(text: &str) {
        assert!(!text.contains("register(") && !text.contains("Heap"), "{text}");
        for line in text.lines().filter(|line| line.ends_with(") {") && !line.starts_with(' ')) {
            let name =
                line.split(['(']).next().and_then(|head| head.split(' ').next_back()).unwrap_or_default();
            assert!(name.to_lowercase().starts_with("diffract"), "{line}");
        }
        assert!(text.contains("float3 diffract_rgb(") && !text.contains("main("));
        assert!(!text.lines().any(|line| line.starts_with("static const") && line.contains("Construct")));
    }

    #[test]
    fn constructors_in_constants_are_lists() {
        let line = "static const A b = ConstructA(f(1.0), Constructarray2_x_((0.0).xx, g(2)), 3);";
        assert_eq!(with_braces(line), "static const A b = {f(1.0), {(0.0).xx, g(2)}, 3};");
        assert!(is_padding("    int _pad7_0;") && is_padding("    int _end_pad_0;"));
        assert!(!is_padding("    int padded;") && !is_padding("    int rows;"));
    }
}
