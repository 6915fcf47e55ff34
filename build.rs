//! Compiles every shader in `shaders/` from GLSL to SPIR-V with glslang (through shaderc), optimised, for Vulkan 1.3.

use std::path::Path;
use std::{env, fs};

/// Extensions of files that are shader stages; `.glsl` files are included by them.
const STAGES: [(&str, shaderc::ShaderKind); 3] = [
    ("vert", shaderc::ShaderKind::Vertex),
    ("frag", shaderc::ShaderKind::Fragment),
    ("comp", shaderc::ShaderKind::Compute),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=shaders");
    let out = env::var("OUT_DIR")?;
    let compiler = shaderc::Compiler::new()?;
    let mut options = shaderc::CompileOptions::new()?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_6);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, _| {
        let content =
            fs::read_to_string(Path::new("shaders").join(name)).map_err(|e| format!("{name}: {e}"))?;
        Ok(shaderc::ResolvedInclude { resolved_name: name.to_owned(), content })
    });
    for entry in fs::read_dir("shaders")? {
        let path = entry?.path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let Some((_, kind)) = STAGES.iter().find(|(name, _)| *name == extension) else { continue };
        let name = path.file_name().and_then(|n| n.to_str()).ok_or("a shader's name is not UTF-8")?;
        let source = fs::read_to_string(&path)?;
        let spirv = compiler.compile_into_spirv(&source, *kind, name, "main", Some(&options))?;
        fs::write(Path::new(&out).join(format!("{name}.spv")), spirv.as_binary_u8())?;
    }
    Ok(())
}
