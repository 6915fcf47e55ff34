//! The function that reads plain images, in the words of game engines: `material.gdshader` is a shader of Godot 4, `material.unity.hlsl` a function for Unity's Shader Graph,
//! `material.ush` the code of a Custom node of Unreal. Godot's comes from the GLSL, the others from the HLSL of the same export.

use super::shader::{self, ShaderLanguage, TextureLayout};
use super::translation;
use crate::error::Result;
use crate::table::TableHeader;

/// Declarations of GLSL and those of Godot.
const IN_GODOT: [(&str, &str); 4] = [
    ("#ifndef DIFFRACT_LAYOUT\n#define DIFFRACT_LAYOUT(number)\n#endif\n\n", ""),
    (
        "DIFFRACT_LAYOUT(0) uniform sampler2D diffract_table;",
        "uniform sampler2D diffract_table : filter_nearest;",
    ),
    (
        "DIFFRACT_LAYOUT(1) uniform sampler2D diffract_functions;",
        "uniform sampler2D diffract_functions : filter_nearest;",
    ),
    (shader::PLACE_OF_GLSL, ""),
];

/// Begin of a shader of Godot. Ambient light and surroundings have no single direction that the table could be read for.
const GODOT_HEAD: &str = "\
shader_type spatial;
render_mode cull_disabled, ambient_light_disabled;

";
/// End of a shader of Godot.
const GODOT_LIGHTS: &str = include_str!("../../shaders/export/godot.gdshader");

/// Function for Unity, which includes `material2d.hlsl`.
pub const UNITY: &str = include_str!("../../shaders/export/unity.hlsl");

/// Begin of the code of a Custom node of Unreal.
const UNREAL_HEAD: &str = "\
// Code of a Custom node of Unreal, with the inputs Table and Functions (Texture Objects: table2d.exr, functions.exr) and Light (unit vector from the surface to
// the light in the space of the world). Output: CMOT Float 3, linear sRGB of f cos(theta_light) [1/sr], to be multiplied by the illuminance of the light.
";
/// End of the code of a Custom node.
const UNREAL_BODY: &str = include_str!("../../shaders/export/unreal.ush");

/// Returns the shader of Godot that reads the table of `header`.
pub fn write_godot(header: &TableHeader) -> String {
    let mut text = shader::write(header, ShaderLanguage::Glsl, TextureLayout::Flat);
    for (glsl, godot) in IN_GODOT {
        text = text.replace(glsl, godot);
    }
    format!("{GODOT_HEAD}{text}{GODOT_LIGHTS}")
}

/// Returns the code of a Custom node of Unreal that reads the table of `header`. A node is the body of a function, where structures may be declared but no functions, so that
/// functions are members of a structure.
///
/// # Errors
/// Same as [`translation::write_hlsl`].
pub fn write_unreal(header: &TableHeader) -> Result<String> {
    let hlsl = translation::write_hlsl(header, TextureLayout::Flat)?;
    let (mut others, mut functions) = (String::new(), String::new());
    for item in items(&hlsl) {
        let first = item.trim_start().lines().next().unwrap_or_default(); // nothing is no function
        let is_function = first.contains('(') && !first.starts_with("static") && !first.starts_with("//");
        if is_function { &mut functions } else { &mut others }.push_str(item);
    }
    Ok(format!("{UNREAL_HEAD}{others}\nstruct DiffractFunctions {{\n{functions}}};\n{UNREAL_BODY}"))
}

/// Cuts HLSL at the lines that end an item of the outermost scope: a declaration, a comment or a line of the preprocessor.
fn items(text: &str) -> Vec<&str> {
    let (mut items, mut begin, mut end) = (Vec::new(), 0, 0);
    for line in text.split_inclusive('\n') {
        end += line.len();
        let is_end = ["}", "//", "#"].iter().any(|start| line.starts_with(start))
            || !line.starts_with(' ') && line.trim_end().ends_with(';');
        if is_end {
            items.push(&text[begin..end]);
            begin = end;
        }
    }
    items.push(&text[begin..]);
    items
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;

    #[test]
    fn godot_reads_images_by_uniforms_and_has_no_other_lines_of_the_preprocessor() {
        let (_, table) = small_table();
        let text = write_godot(&table.header);
        assert_eq!(text.matches("uniform sampler2D diffract_").count(), 2);
        assert!(!text.contains("DIFFRACT_LAYOUT") && !text.lines().any(|line| line.starts_with('#')));
        assert!(!text.contains("precision ") && text.contains("void light()"));
    }

    #[test]
    fn a_custom_node_has_functions_in_a_structure_alone() {
        let (_, table) = small_table();
        let text = write_unreal(&table.header).unwrap();
        let (before, rest) = text.split_once("\nstruct DiffractFunctions {\n").unwrap();
        let (functions, _) = rest.split_once("\n};\n").unwrap();
        assert!(
            before.contains("static const float DIFFRACT_PI") && before.contains("struct DiffractPair {")
        );
        assert!(!before.contains("return ") && !before.contains("{\n    return"));
        assert!(functions.contains("float3 diffract_rgb(") && functions.contains("float2 diffract_uv("));
        assert!(
            !functions.contains("static ")
                && !functions.contains("typedef ")
                && !functions.contains("\nstruct ")
        );
    }

    #[test]
    fn items_joined_are_the_text() {
        let text = "struct A {\n    int b;\n};\n\nint c(int d)\n{\n    if (d) {\n    }\n    return d;\n}\n#define E\nstatic const int F = 1;\n";
        let found = items(text);
        assert_eq!(found.concat(), text);
        assert_eq!(found.len(), 5);
    }
}
