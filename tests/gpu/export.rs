//! The function that reads an export, as GLSL, WGSL and HLSL on the device, against the table.

use crate::device::with_device;
use crate::export_engines::{godot_in_glsl, unity_in_hlsl, unreal_in_hlsl};
use ash::vk;
use diffract::internals::export::{
    Conformance, ExportReader, ExportSettings, ExportedMaterial, MaterialDescription, PortErrors, write,
};
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::render::upload;
use diffract::internals::spectra::power::Beyond;
use diffract::internals::surface::HeightField;
use diffract::internals::task::Task;
use diffract::internals::vk::access::Access;
use diffract::internals::vk::buffer::Buffer;
use diffract::internals::vk::commands::Commands;
use diffract::internals::vk::descriptors::{Binding, Descriptors};
use diffract::internals::vk::device::Device;
use diffract::internals::vk::image::{Description, Image};
use diffract::internals::vk::pipeline::{Code, Pipeline};
use diffract::internals::vk::sampler::Sampler;
use exr::prelude::FlatSamples;
use exr::prelude::ReadChannels;
use exr::prelude::ReadLayers;
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use half::f16;
use std::path::Path;
use std::sync::Arc;

/// Language of an exported shader.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Language {
    Glsl,
    Wgsl,
    Hlsl,
    Godot,
    Unity,
    Unreal,
}

/// Textures that a shader reads.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Layout {
    Array,
    Flat,
}

/// Function that reads an export, and the tangent frame that it is given.
#[derive(Clone, Copy, Debug)]
struct Reading {
    language: Language,
    layout: Layout,
    frame: [[f32; 3]; 3],
}

/// Answers a question a thread: the end of a program whose begin is the exported shader.
const GLSL_MAIN: &str = "
layout(local_size_x = 64) in;
struct Question { vec4 light; vec4 viewer; vec4 footprint; };
layout(set = 0, binding = 2, std430) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Answers { vec4 answers[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(questions.length())) {
        Question q = questions[i];
        answers[i] = vec4(diffract_rgb(q.light.xyz, q.viewer.xyz, FRAME, q.footprint.xy, q.footprint.zw), 1.0);
    }
}
";

const WGSL_MAIN: &str = include_str!("../export_main.wgsl");

const HLSL_MAIN: &str = "
struct Question { float4 light; float4 viewer; float4 footprint; };
[[vk::binding(0, 0)]] Texture2DArray<float4> table;
[[vk::binding(1, 0)]] SamplerState table_sampler;
[[vk::binding(2, 0)]] Texture2D<float4> functions;
[[vk::binding(3, 0)]] StructuredBuffer<Question> questions;
[[vk::binding(4, 0)]] RWStructuredBuffer<float4> answers;
[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    uint count, stride;
    questions.GetDimensions(count, stride);
    if (id.x < count) {
        Question q = questions[id.x];
        answers[id.x] = float4(diffract_rgb(q.light.xyz, q.viewer.xyz, FRAME, q.footprint.xy, q.footprint.zw, table, table_sampler, functions), 1.0);
    }
}
";

/// Columns of the standard frame, and of one that is turned by a right angle about its normal.
const STANDARD: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TURNED: [[f32; 3]; 3] = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

fn exported(folder: &Path) {
    let heights = (0..48 * 40).map(|i| 0.15 * (f64::from(i) * 0.618_034).fract()).collect();
    let field = HeightField::new(48, 40, [0.09, 0.09], heights).unwrap();
    let settings = ExportSettings {
        sigma: 2.0,
        beyond: Beyond::Copies,
        illuminant: Illuminant::D65,
        reflectance: 1.5.into(),
        tolerance: 2e-2,
        wavelengths: None,
        footprint: 0.04,
        most_bytes: None,
    };
    let material = ExportedMaterial::new(&field, &settings, &Task::silent()).unwrap();
    let mut description = MaterialDescription::new(&field, &settings, &material, String::new()).unwrap();
    write(folder, &material, &mut description).unwrap();
}

/// Puts a KTX2 file of `reader` on the device.
fn texture(device: &Arc<Device>, reader: &ExportReader, name: &str) -> Image {
    let bytes = reader.file(name).unwrap();
    let file = ktx2::Reader::new(&bytes[..]).unwrap();
    let header = file.header();
    let layers = header.layer_count.max(1);
    let description = Description {
        name,
        format: vk::Format::from_raw(header.format.unwrap().value() as i32),
        size: [header.pixel_width, header.pixel_height],
        layers,
        array: header.layer_count > 0,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
    };
    let image = Image::with_levels(device, &description, header.level_count).unwrap();
    let levels: Vec<&[u8]> = file.levels().map(|level| level.data).collect();
    upload::levels(device, &image, layers, &levels).unwrap();
    image
}

/// Puts a plain OpenEXR image of `reader` on the device, with its last line first where a language reads it so.
fn plain_texture(device: &Arc<Device>, reader: &ExportReader, name: &str, language: Language) -> Image {
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(reader.file(name).unwrap()))
        .unwrap();
    let layer = &image.layer_data;
    let mut texels = vec![[0f32; 4]; layer.size.area()];
    for channel in &layer.channel_data.list {
        let i = ["R", "G", "B", "A"].iter().position(|name| channel.name.eq(name)).unwrap();
        let values = channel.sample_data.values_as_f32();
        texels.iter_mut().zip(values).for_each(|(texel, value)| texel[i] = value);
    }
    if language == Language::Unity {
        let lines: Vec<_> = texels.chunks(layer.size.x()).rev().flatten().copied().collect();
        texels = lines;
    }
    let is_half = matches!(layer.channel_data.list[0].sample_data, FlatSamples::F16(_));
    let format = if is_half { vk::Format::R16G16B16A16_SFLOAT } else { vk::Format::R32G32B32A32_SFLOAT };
    let halves: Vec<[f16; 4]> = texels.iter().map(|texel| texel.map(f16::from_f32)).collect();
    let bytes: &[u8] = if is_half { bytemuck::cast_slice(&halves) } else { bytemuck::cast_slice(&texels) };
    let description = Description {
        name,
        format,
        size: [layer.size.x() as u32, layer.size.y() as u32],
        layers: 1,
        array: false,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
    };
    let image = Image::with_levels(device, &description, 1).unwrap();
    upload::levels(device, &image, 1, &[bytes]).unwrap();
    image
}

/// Returns the end of a program with the textures of `layout`: plain images are no arrays, and are read without a sampler.
fn with_textures(main: &str, layout: Layout) -> String {
    match layout {
        Layout::Array => main.to_owned(),
        Layout::Flat => ["Array", "_array", " table_sampler,"]
            .iter()
            .fold(main.to_owned(), |main, part| main.replace(part, "")),
    }
}

/// Compiles the exported shader with a main function.
fn compiled(reader: &ExportReader, Reading { language, layout, frame }: Reading) -> Vec<u8> {
    let file = |name: &str| String::from_utf8(reader.file(name).unwrap()).unwrap();
    let text = |name: &str| {
        let name =
            if layout == Layout::Flat { name.replace("material", "material2d") } else { name.to_owned() };
        file(&name)
    };
    let frame = |matrix: &str, vector: &str| {
        let columns = frame.map(|[x, y, z]| format!("{vector}({x:?}, {y:?}, {z:?})"));
        format!("{matrix}({})", columns.join(", "))
    };
    match language {
        Language::Glsl => {
            let main = GLSL_MAIN.replace("FRAME", &frame("mat3", "vec3"));
            by_glslang(
                &format!("#version 450\n{}{main}", text("material.glsl")),
                shaderc::SourceLanguage::GLSL,
            )
        }
        Language::Hlsl => {
            let main = with_textures(HLSL_MAIN, layout).replace("FRAME", &frame("float3x3", "float3"));
            by_glslang(&(text("material.hlsl") + &main), shaderc::SourceLanguage::HLSL)
        }
        Language::Wgsl => {
            let main = with_textures(WGSL_MAIN, layout).replace("FRAME", &frame("mat3x3<f32>", "vec3<f32>"));
            by_naga(&(text("material.wgsl") + &main))
        }
        Language::Godot => by_glslang(
            &godot_in_glsl(&file("material.gdshader"), &frame("mat3", "vec3")),
            shaderc::SourceLanguage::GLSL,
        ),
        Language::Unity => {
            let text = unity_in_hlsl(
                &file("material.unity.hlsl"),
                &file("material2d.hlsl"),
                &frame("float3x3", "float3"),
            );
            by_glslang(&text, shaderc::SourceLanguage::HLSL)
        }
        Language::Unreal => by_glslang(
            &unreal_in_hlsl(&file("material.ush"), &frame("float3x3", "float3")),
            shaderc::SourceLanguage::HLSL,
        ),
    }
}

fn by_glslang(text: &str, language: shaderc::SourceLanguage) -> Vec<u8> {
    let mut options = shaderc::CompileOptions::new().unwrap();
    // Glslang has storage buffers of HLSL that SPIR-V 1.3 of Vulkan 1.1 is the last to know.
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
    options.set_source_language(language);
    options.add_macro_definition("DIFFRACT_LAYOUT(number)", Some("layout(set = 0, binding = number)"));
    let compiler = shaderc::Compiler::new().unwrap();
    let kind = shaderc::ShaderKind::Compute;
    compiler
        .compile_into_spirv(text, kind, "material", "main", Some(&options))
        .unwrap()
        .as_binary_u8()
        .to_vec()
}

fn by_naga(text: &str) -> Vec<u8> {
    use naga::back::spv;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text)).unwrap();
    let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
    let options = spv::Options { lang_version: (1, 5), ..spv::Options::default() };
    let pipeline =
        spv::PipelineOptions { shader_stage: naga::ShaderStage::Compute, entry_point: "main".to_owned() };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).unwrap();
    bytemuck::cast_slice(&words).to_vec()
}

/// Colours by a function in the directions of `conformance`.
fn answers(
    device: &Arc<Device>,
    reader: &ExportReader,
    conformance: &Conformance,
    reading: Reading,
) -> Vec<DVec3> {
    let Reading { language, layout, .. } = reading;
    let spirv = &compiled(reader, reading);
    let question = |row: &diffract::internals::export::ConformanceRow| {
        let (light, view, [dx, dy]) = (row.pair.light, row.pair.view, row.footprint);
        [light.extend(0.0), view.extend(0.0), dx.extend(dy.x).extend(dy.y)]
            .map(|four| four.as_vec4().to_array())
    };
    let questions: Vec<[[f32; 4]; 3]> = conformance.rows.iter().map(question).collect();
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let asked = Buffer::with_data(device, "questions", storage, bytemuck::cast_slice(&questions)).unwrap();
    let bytes = (questions.len() * 16) as u64;
    let answered = Buffer::new(device, "answers", bytes, storage, MemoryLocation::GpuToCpu).unwrap();
    let [texels, functions] = match layout {
        Layout::Array => ["table.ktx2", "functions.ktx2"].map(|name| texture(device, reader, name)),
        Layout::Flat => {
            ["table2d.exr", "functions.exr"].map(|name| plain_texture(device, reader, name, language))
        }
    };
    let (by_level, nearest) = (
        Sampler::levels(device, "table sampler").unwrap(),
        Sampler::nearest(device, "functions sampler").unwrap(),
    );
    let stages = vk::ShaderStageFlags::COMPUTE;
    let list = vk::DescriptorType::STORAGE_BUFFER;
    // Samplers are apart from textures but in GLSL.
    let kinds = match language {
        Language::Glsl | Language::Godot => vec![
            vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            list,
            list,
        ],
        _ => vec![
            vk::DescriptorType::SAMPLED_IMAGE,
            vk::DescriptorType::SAMPLER,
            vk::DescriptorType::SAMPLED_IMAGE,
            list,
            list,
        ],
    };
    let lists = kinds.len() as u32 - 2;
    let bindings: Vec<_> = (0..).zip(kinds).map(|(number, kind)| Binding { number, kind, stages }).collect();
    let set = Descriptors::new(device, "material set", &bindings).unwrap();
    if matches!(language, Language::Glsl | Language::Godot) {
        set.image(0, &texels, &by_level);
        set.image(1, &functions, &nearest);
    } else {
        set.image(0, &texels, &by_level);
        set.image(1, &texels, &by_level);
        set.image(2, &functions, &nearest);
    }
    set.buffer(lists, &asked);
    set.written_buffer(lists + 1, &answered);
    let code = Code { name: "material", spirv, constants: &[] };
    let pipeline = Pipeline::compute(device, code, &[&set], 0).unwrap();
    let mut commands = Commands::new(device, "material").unwrap();
    commands
        .run(|record| {
            record.bind(&pipeline, &[&set]);
            record.dispatch(questions.len().div_ceil(64) as u32);
            record.memory(Access::ComputeWrite, Access::HostRead);
            Ok(())
        })
        .unwrap();
    let read: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(answered.bytes().unwrap());
    read.iter().map(|[r, g, b, _]| DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b))).collect()
}

/// Fails where the `colours` in the standard frame are not those of the table, or those in a turned frame are nearly.
fn assert_right(name: &str, conformance: &Conformance, colours: impl Fn([[f32; 3]; 3]) -> Vec<DVec3>) {
    let right = conformance.errors_of(&colours(STANDARD));
    eprintln!("{name}: {right:?}");
    assert!(right.within(&PortErrors::RIGHT), "{name}: {right:?}");
    let turned = conformance.errors_of(&colours(TURNED));
    assert!(turned.relative_l2 > 10.0 * PortErrors::RIGHT.relative_l2, "{name}: {turned:?}");
}

/// Compares the colours of `language` with the table, from both layouts of the textures, and those of a turned frame, which must not agree.
fn compare(language: Language) {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("material");
    exported(&folder);
    let reader = ExportReader::open(&folder).unwrap();
    let conformance = reader.check().unwrap();
    with_device(|device| {
        let colours =
            |layout, frame| answers(device, &reader, &conformance, Reading { language, layout, frame });
        for layout in [Layout::Array, Layout::Flat] {
            assert_right(&format!("{language:?}, {layout:?}"), &conformance, |frame| colours(layout, frame));
        }
        let pairs = colours(Layout::Flat, STANDARD).into_iter().zip(colours(Layout::Array, STANDARD));
        let (apart, all) = pairs.fold((0.0, 0.0), |(apart, all), (flat, array)| {
            (apart + (flat - array).length_squared(), all + array.length_squared())
        });
        let apart = (apart / all).sqrt();
        eprintln!("{language:?}: the layouts differ by {apart:.1e}");
        assert!(apart < 1e-5, "{apart}");
    });
}

#[test]
fn the_exported_glsl_gives_the_colours_of_the_table_and_a_turned_frame_does_not() {
    compare(Language::Glsl);
}

#[test]
fn the_exported_wgsl_gives_the_colours_of_the_table_and_a_turned_frame_does_not() {
    compare(Language::Wgsl);
}

#[test]
fn the_exported_hlsl_gives_the_colours_of_the_table_and_a_turned_frame_does_not() {
    compare(Language::Hlsl);
}

/// Compares the colours of the text for an engine, which reads plain images, with the table, and those of a turned frame, which must not agree.
fn compare_engine(language: Language) {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("material");
    exported(&folder);
    let reader = ExportReader::open(&folder).unwrap();
    let conformance = reader.check().unwrap();
    with_device(|device| {
        assert_right(&format!("{language:?}"), &conformance, |frame| {
            answers(device, &reader, &conformance, Reading { language, layout: Layout::Flat, frame })
        });
    });
}

#[test]
fn the_shader_for_godot_lights_both_sides_by_the_colours_of_the_table_and_a_turned_frame_does_not() {
    compare_engine(Language::Godot);
}

#[test]
fn the_function_for_unity_reads_images_from_their_last_line_and_gives_the_colours_of_the_table() {
    compare_engine(Language::Unity);
}

#[test]
fn the_node_for_unreal_gives_the_colours_of_the_table_with_a_bitangent_that_points_down() {
    compare_engine(Language::Unreal);
}
