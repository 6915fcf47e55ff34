//! A device with validation for one test.

use diffract::internals::vk::device::Device;
use diffract::internals::vk::instance::Instance;
use diffract::internals::vk::selection::DeviceChoice;
use std::sync::Arc;

/// Runs `test` on a device of its own and fails on any validation message, also on those of its clean-up.
pub fn with_device(test: impl FnOnce(&Arc<Device>)) {
    let instance =
        Arc::new(Instance::new(true).expect("tests need a Vulkan driver and the validation layer"));
    let device =
        Device::open(instance.clone(), &DeviceChoice::Any).expect("tests need a usable Vulkan device");
    test(&device);
    assert_eq!(Arc::strong_count(&device), 1, "something still holds the device");
    drop(device);
    let messages = instance.messages();
    assert!(messages.is_empty(), "{} validation messages, the first: {}", messages.len(), messages[0]);
}

#[test]
fn validation_speaks_up_when_a_rule_is_broken() {
    use ash::vk;
    use diffract::internals::vk::buffer::Buffer;
    use diffract::internals::vk::commands::Commands;
    use gpu_allocator::MemoryLocation;
    let instance = Arc::new(Instance::new(true).unwrap());
    let device = Device::open(instance.clone(), &DeviceChoice::Any).unwrap();
    let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
    let make = |name| Buffer::new(&device, name, 64, usage, MemoryLocation::CpuToGpu).unwrap();
    let (a, b) = (make("a"), make("b"));
    let mut commands = Commands::new(&device, "hazard").unwrap();
    // Written and read again with no barrier between: only the synchronization checks can see it.
    commands
        .run(|record| {
            record.copy_buffer(&a, &b, 64);
            record.copy_buffer(&b, &a, 64);
            Ok(())
        })
        .unwrap();
    let messages = instance.messages();
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD")), "{messages:?}");
}

#[test]
fn pipelines_of_a_device_serve_another() {
    use diffract::internals::vk::descriptors::{Binding, Descriptors};
    use diffract::internals::vk::pipeline::{Code, Pipeline};
    let make = |device: &Arc<Device>| {
        let code = include_bytes!(concat!(env!("OUT_DIR"), "/interface_probe.comp.spv")).as_slice();
        let block = |number, kind| Binding { number, kind, stages: ash::vk::ShaderStageFlags::COMPUTE };
        let (uniform, storage) =
            (ash::vk::DescriptorType::UNIFORM_BUFFER, ash::vk::DescriptorType::STORAGE_BUFFER);
        let first = Descriptors::new(device, "set 0", &[block(0, uniform), block(8, storage)]).unwrap();
        let second = Descriptors::new(device, "set 1", &[block(2, uniform)]).unwrap();
        let code = Code { name: "interface_probe.comp", spirv: code, constants: &[] };
        Pipeline::compute(device, code, &[&first, &second], 0).unwrap();
    };
    with_device(|device| {
        make(device);
        let data = device.pipeline_data().unwrap();
        with_device(|other| {
            other.add_pipelines(&data).unwrap();
            make(other);
            assert!(other.pipeline_data().unwrap().len() >= data.len());
        });
    });
}
