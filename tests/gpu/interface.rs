//! The blocks that Rust writes are the blocks that shaders read.

use crate::device::with_device;
use ash::vk;
use bytemuck::Zeroable;
use diffract::internals::render::frame_set::{FrameBlock, SampleBlock};
use diffract::internals::render::source::spectra::SpectraBlock;
use diffract::internals::render::tables::UV_BINS;
use diffract::internals::vk::access::Access;
use diffract::internals::vk::buffer::Buffer;
use diffract::internals::vk::commands::Commands;
use diffract::internals::vk::descriptors::{Binding, Descriptors};
use diffract::internals::vk::pipeline::{Code, Pipeline};
use gpu_allocator::MemoryLocation;

#[test]
fn blocks_mean_the_same_to_rust_and_to_shaders() {
    with_device(|device| {
        let mut value = 0.0;
        let mut next = || {
            value += 1.0;
            value
        };
        let mut frame = FrameBlock::zeroed();
        let mut expected: Vec<[f32; 4]> = Vec::new();
        for column in &mut frame.clip_from_world {
            *column = std::array::from_fn(|_| next());
            expected.push(*column);
        }
        let mut vector = || std::array::from_fn(|_| next());
        frame.viewer = vector();
        expected.push(frame.viewer);
        frame.base_color = vector();
        frame.grooves = vector();
        frame.sample = SampleBlock {
            jitter: [51.0, 52.0],
            footprint: 53.0,
            index: 54,
            count: 55,
            seed: 56,
            turn: 57,
            parts: 58,
        };
        expected.extend([frame.base_color, frame.grooves]);
        frame.surroundings = vector();
        expected.push(frame.surroundings);
        expected.extend([[51.0, 52.0, 53.0, 54.0], [55.0, 56.0, 57.0, 58.0]]);
        for light in &mut frame.lights {
            (light.toward, light.emitter, light.irradiance) = (vector(), vector(), vector());
            expected.extend([light.toward, light.emitter, light.irradiance]);
            for column in &mut light.shadow_from_world {
                *column = vector();
                expected.push(*column);
            }
        }
        let optics = SpectraBlock {
            texture_size: [101.0, 102.0],
            origin: [103.0, 104.0],
            texels_per_frequency: [105.0, 106.0],
            band: [107.0, 108.0],
            sigma: 109.0,
            half_range: 110.0,
            column: [111.0, 112.0],
            pairs_per_z: 113.0,
            fewest_pairs: 114.0,
            padding: [0.0; 2],
            ..SpectraBlock::default()
        };
        expected.extend([
            [101.0, 102.0, 103.0, 104.0],
            [105.0, 106.0, 107.0, 108.0],
            [109.0, 110.0, 111.0, 112.0],
            [113.0, 114.0, 0.0, 0.0],
            [UV_BINS as f32, 0.0, 0.0, 0.0],
        ]);

        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let block = |name, bytes: &[u8]| Buffer::with_data(device, name, uniform, bytes).unwrap();
        let frame = block("frame probe", bytemuck::bytes_of(&frame));
        let spectra = block("spectra probe", bytemuck::bytes_of(&optics));
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = (expected.len() * 16) as u64;
        let answers = Buffer::new(device, "probe answers", bytes, storage, MemoryLocation::GpuToCpu).unwrap();
        let set = |name, kinds: &[(u32, vk::DescriptorType)]| {
            let stages = vk::ShaderStageFlags::COMPUTE;
            let bindings: Vec<_> =
                kinds.iter().map(|&(number, kind)| Binding { number, kind, stages }).collect();
            Descriptors::new(device, name, &bindings).unwrap()
        };
        let (block, list) = (vk::DescriptorType::UNIFORM_BUFFER, vk::DescriptorType::STORAGE_BUFFER);
        let first = set("probe set 0", &[(0, block), (8, list)]);
        first.buffer(0, &frame);
        first.buffer(8, &answers);
        let second = set("probe set 1", &[(2, block)]);
        second.buffer(2, &spectra);
        let code = include_bytes!(concat!(env!("OUT_DIR"), "/interface_probe.comp.spv")).as_slice();
        let code = Code { name: "interface_probe.comp", spirv: code, constants: &[] };
        let pipeline = Pipeline::compute(device, code, &[&first, &second], 0).unwrap();
        let mut commands = Commands::new(device, "probe").unwrap();
        commands
            .run(|record| {
                record.bind(&pipeline, &[&first, &second]);
                record.dispatch(1);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })
            .unwrap();
        let read: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(answers.bytes().unwrap());
        assert_eq!(read, expected);
    });
}
