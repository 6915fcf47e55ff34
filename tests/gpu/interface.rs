//! The blocks that Rust writes are the blocks that shaders read.

use crate::device::with_device;
use ash::vk;
use bytemuck::Zeroable;
use diffract::expansion::Basis;
use diffract::precompute::near::{FINER, OCTAVES};
use diffract::precompute::{Aim, Budget, Settings, compute};
use diffract::render::interface::{FrameBlock, LinesBlock, OpticsBlock, SampleBlock, UV_BINS, binding};
use diffract::render::pigment::Pigment;
use diffract::render::resources::Resources;
use diffract::render::shading::Shading;
use diffract::scene::MAX_LIGHTS;
use diffract::surface::HeightField;
use diffract::vk::access::Access;
use diffract::vk::buffer::Buffer;
use diffract::vk::commands::Commands;
use diffract::vk::pipeline::{Code, Pipeline};
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
        frame.eye = vector();
        expected.push(frame.eye);
        for light in &mut frame.lights {
            *light = vector();
            expected.push(*light);
        }
        frame.base_color = vector();
        frame.counts = [3, 4, 5, 6];
        frame.sample = SampleBlock {
            jitter: [51.0, 52.0],
            footprint: 53.0,
            index: 54,
            count: 55,
            seed: 56,
            padding: [0; 2],
        };
        expected.extend([frame.base_color, frame.counts.map(|n| n as f32)]);
        expected.extend([[51.0, 52.0, 53.0, 54.0], [55.0, 56.0, 0.0, 0.0]]);
        let optics = OpticsBlock {
            texture_size: [101.0, 102.0],
            origin: [103.0, 104.0],
            texels_per_frequency: [105.0, 106.0],
            band: [107.0, 108.0],
            sigma: 109.0,
            normal_reflectance: 110.0,
            bands_per_z: 111.0,
            last_column: 112.0,
            pairs_per_z: 113.0,
            fewest_pairs: 114.0,
            padding: [0.0; 2],
        };
        expected.extend([
            [101.0, 102.0, 103.0, 104.0],
            [105.0, 106.0, 107.0, 108.0],
            [109.0, 110.0, 111.0, 112.0],
            [113.0, 114.0, MAX_LIGHTS as f32, UV_BINS as f32],
        ]);

        let lines = LinesBlock {
            across: [201.0, 202.0],
            along: [203.0, 204.0],
            origin: [205.0, 206.0],
            from: 207.0,
            unit: 208.0,
            first_column: 209.0,
            columns_per_wavenumber: 210.0,
            first_row: 211.0,
            rows_per_octave: 212.0,
            last_column: 213.0,
            nearest: 214.0,
            padding: [0.0; 2],
            near: std::array::from_fn(|i| [220.0 + i as f32, 240.0 + i as f32, 0.0, 0.0]),
        };
        expected.extend([
            [201.0, 202.0, 203.0, 204.0],
            [205.0, 206.0, 207.0, 208.0],
            [209.0, 210.0, 211.0, 212.0],
            [213.0, 214.0, OCTAVES as f32, FINER as f32],
        ]);
        expected.extend(lines.near);

        let field = HeightField::new(4, 4, [0.1, 0.1], vec![0.0; 16]).unwrap();
        let settings = Settings {
            sigma: 1.0,
            shortest_wavelength: 0.38,
            budget: Budget { interpolation: 0.07, expansion: 0.035 },
            basis: Basis::Taylor,
            terms: Some(1),
            aim: Aim::FewTransforms,
            lines: None,
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let layers = compute(&field, &settings, &|_, _| Ok(())).unwrap();
        let mut resources = Resources::new(device, &layers, &Shading::default(), &Pigment::white()).unwrap();
        resources.frame.write(bytemuck::bytes_of(&frame)).unwrap();
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let block = Buffer::with_data(device, "optics probe", uniform, bytemuck::bytes_of(&optics)).unwrap();
        resources.descriptors.buffer(binding::OPTICS, &block);
        let block = Buffer::with_data(device, "lines probe", uniform, bytemuck::bytes_of(&lines)).unwrap();
        resources.descriptors.buffer(binding::LINES_BLOCK, &block);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = (expected.len() * 16) as u64;
        let answers = Buffer::new(device, "probe answers", bytes, storage, MemoryLocation::GpuToCpu).unwrap();
        resources.descriptors.buffer(binding::ANSWERS, &answers);
        let code = include_bytes!(concat!(env!("OUT_DIR"), "/interface_probe.comp.spv")).as_slice();
        let pipeline = Pipeline::compute(
            device,
            Code { name: "interface_probe.comp", spirv: code, constants: &[] },
            &resources.descriptors,
            0,
        )
        .unwrap();
        let mut commands = Commands::new(device, "probe").unwrap();
        commands
            .run(|record| {
                record.bind(&pipeline, &resources.descriptors);
                record.dispatch(1);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })
            .unwrap();
        let read: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(answers.bytes().unwrap());
        assert_eq!(read, expected);
    });
}
