//! The function that reads an export, as GLSL on the device, against the table.

use crate::device::with_device;
use ash::vk;
use diffract::export::{
    Conformance, ExportReader, ExportSettings, ExportedMaterial, MaterialDescription, PortErrors, write,
};
use diffract::optics::spectrum::Illuminant;
use diffract::render::upload;
use diffract::spectra::power::Beyond;
use diffract::surface::HeightField;
use diffract::vk::access::Access;
use diffract::vk::buffer::Buffer;
use diffract::vk::commands::Commands;
use diffract::vk::descriptors::{Binding, Descriptors};
use diffract::vk::device::Device;
use diffract::vk::image::{Description, Image};
use diffract::vk::pipeline::{Code, Pipeline};
use diffract::vk::sampler::Sampler;
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use std::path::Path;
use std::sync::Arc;

/// Answers a question a thread: the end of a program whose begin is the exported shader.
const MAIN: &str = "
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

/// Standard frame, and one that is turned by a right angle about its normal.
const STANDARD: &str = "mat3(1.0)";
const TURNED: &str = "mat3(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0)";

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
    let material = ExportedMaterial::new(&field, &settings, &|_, _, _| Ok(())).unwrap();
    let mut description = MaterialDescription::new(&field, &settings, &material, String::new());
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

/// Compiles the exported shader with [`MAIN`], where `frame` is the tangent frame.
fn compiled(reader: &ExportReader, frame: &str) -> Vec<u8> {
    let text = String::from_utf8(reader.file("material.glsl").unwrap()).unwrap() + MAIN;
    let mut options = shaderc::CompileOptions::new().unwrap();
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_warnings_as_errors();
    options.add_macro_definition("DIFFRACT_LAYOUT(number)", Some("layout(set = 0, binding = number)"));
    options.add_macro_definition("FRAME", Some(frame));
    let kind = shaderc::ShaderKind::Compute;
    let compiler = shaderc::Compiler::new().unwrap();
    let spirv = compiler.compile_into_spirv(&text, kind, "material.glsl", "main", Some(&options));
    spirv.unwrap().as_binary_u8().to_vec()
}

/// Colours of `shader` in the directions of `conformance`.
fn answers(
    device: &Arc<Device>,
    reader: &ExportReader,
    conformance: &Conformance,
    spirv: &[u8],
) -> Vec<DVec3> {
    let question = |row: &diffract::export::ConformanceRow| {
        let (light, view, [dx, dy]) = (row.pair.light, row.pair.view, row.footprint);
        [light.extend(0.0), view.extend(0.0), dx.extend(dy.x).extend(dy.y)]
            .map(|four| four.as_vec4().to_array())
    };
    let questions: Vec<[[f32; 4]; 3]> = conformance.rows.iter().map(question).collect();
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let asked = Buffer::with_data(device, "questions", storage, bytemuck::cast_slice(&questions)).unwrap();
    let bytes = (questions.len() * 16) as u64;
    let answered = Buffer::new(device, "answers", bytes, storage, MemoryLocation::GpuToCpu).unwrap();
    let (texels, functions) =
        (texture(device, reader, "table.ktx2"), texture(device, reader, "functions.ktx2"));
    let (by_level, nearest) = (
        Sampler::levels(device, "table sampler").unwrap(),
        Sampler::nearest(device, "functions sampler").unwrap(),
    );
    let stages = vk::ShaderStageFlags::COMPUTE;
    let (image, list) = (vk::DescriptorType::COMBINED_IMAGE_SAMPLER, vk::DescriptorType::STORAGE_BUFFER);
    let bindings = [image, image, list, list];
    let bindings: Vec<_> =
        (0..).zip(bindings).map(|(number, kind)| Binding { number, kind, stages }).collect();
    let set = Descriptors::new(device, "material set", &bindings).unwrap();
    set.image(0, &texels, &by_level);
    set.image(1, &functions, &nearest);
    set.buffer(2, &asked);
    set.written_buffer(3, &answered);
    let code = Code { name: "material.glsl", spirv, constants: &[] };
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

#[test]
fn the_exported_glsl_gives_the_colours_of_the_table_and_a_turned_frame_does_not() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("material");
    exported(&folder);
    let reader = ExportReader::open(&folder).unwrap();
    let conformance = reader.check().unwrap();
    with_device(|device| {
        let errors = |frame: &str| {
            conformance.errors_of(&answers(device, &reader, &conformance, &compiled(&reader, frame)))
        };
        let right = errors(STANDARD);
        eprintln!("{right:?}");
        assert!(right.within(&PortErrors::RIGHT), "{right:?}");
        let turned = errors(TURNED);
        assert!(turned.relative_l2 > 10.0 * PortErrors::RIGHT.relative_l2, "{turned:?}");
    });
}
