//! Compiles every shader in `shaders/` from GLSL to SPIR-V with glslang (through shaderc), optimised, for Vulkan 1.3.
//! Does nothing without the feature `vulkan`.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=shaders");
    #[cfg(feature = "vulkan")]
    shaders::compile_all()?;
    Ok(())
}

#[cfg(feature = "vulkan")]
mod shaders {
    use std::path::Path;
    use std::{env, fs};

    /// Extensions of shader stages; they include `.glsl` files.
    const STAGES: [(&str, shaderc::ShaderKind); 3] = [
        ("vert", shaderc::ShaderKind::Vertex),
        ("frag", shaderc::ShaderKind::Fragment),
        ("comp", shaderc::ShaderKind::Compute),
    ];

    /// Include name of the source, in stages that are compiled once for every `source_NAME.glsl`.
    const SOURCE: &str = "source.glsl";

    /// Compiles everything in `shaders/` into the output folder of build scripts.
    pub fn compile_all() -> Result<(), Box<dyn std::error::Error>> {
        let out = env::var("OUT_DIR")?;
        let compiler = shaderc::Compiler::new()?;
        let mut stages = Vec::new();
        let mut sources = Vec::new();
        for entry in fs::read_dir("shaders")? {
            let path = entry?.path();
            let name =
                path.file_name().and_then(|n| n.to_str()).ok_or("a shader's name is not UTF-8")?.to_owned();
            if let Some(source) = name.strip_prefix("source_").and_then(|n| n.strip_suffix(".glsl")) {
                sources.push(source.to_owned());
            }
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            if let Some((_, kind)) = STAGES.iter().find(|(name, _)| *name == extension) {
                stages.push((name, fs::read_to_string(&path)?, *kind));
            }
        }
        for (name, text, kind) in &stages {
            let compile = |source: &str, out_name: &str| -> Result<(), Box<dyn std::error::Error>> {
                let options = options(source)?;
                let spirv = compiler.compile_into_spirv(text, *kind, out_name, "main", Some(&options))?;
                Ok(fs::write(Path::new(&out).join(format!("{out_name}.spv")), spirv.as_binary_u8())?)
            };
            if !text.contains(&format!("#include \"{SOURCE}\"")) {
                compile("", name)?;
                continue;
            }
            let (stem, extension) = name.split_once('.').ok_or("a stage has no extension")?;
            for source in &sources {
                compile(source, &format!("{stem}.{source}.{extension}"))?;
            }
        }
        Ok(())
    }

    /// Returns the settings of the compiler; `source` replaces [`SOURCE`].
    fn options(source: &str) -> Result<shaderc::CompileOptions<'static>, Box<dyn std::error::Error>> {
        let mut options = shaderc::CompileOptions::new()?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
        options.set_target_spirv(shaderc::SpirvVersion::V1_6);
        options.set_optimization_level(shaderc::OptimizationLevel::Performance);
        options.set_warnings_as_errors();
        let source = format!("source_{source}.glsl");
        options.set_include_callback(move |name, _, _, _| {
            let file = if name == SOURCE { source.as_str() } else { name };
            let content =
                fs::read_to_string(Path::new("shaders").join(file)).map_err(|e| format!("{file}: {e}"))?;
            Ok(shaderc::ResolvedInclude { resolved_name: file.to_owned(), content })
        });
        Ok(options)
    }
}
