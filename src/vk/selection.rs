//! Selection of one of the Vulkan devices of the machine.

use super::failure;
use super::instance::{API_VERSION, INSTALL, Instance};
use super::mask::Mask;
use crate::error::{Error, Remedy, Result};
use ash::vk;

/// Properties of a Vulkan device that the selection needs.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Handle.
    pub raw: vk::PhysicalDevice,
    /// Name given by the driver.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Discrete, integrated, virtual, CPU.
    pub kind: vk::PhysicalDeviceType,
    /// Vulkan version.
    pub version: u32,
    /// Queue family with graphics and compute.
    pub queue_family: Option<u32>,
    /// Size of the largest device-local heap \[bytes\].
    pub memory: u64,
    /// Largest side of a 2D image \[texels\].
    pub max_side: u32,
    /// Largest number of array layers.
    pub max_layers: u32,
    /// Duration of a tick of its clock \[ns\].
    pub timestamp_period: f64,
    /// Required capabilities that are missing.
    pub missing: Vec<&'static str>,
}

impl Candidate {
    /// Returns true if it draws on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == vk::PhysicalDeviceType::CPU
    }
}

/// Choice of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// Fastest usable device.
    #[default]
    Any,
    /// Software device.
    Cpu,
    /// Device with this number in the list.
    Index(usize),
    /// First device whose name contains this text.
    Name(String),
}

impl DeviceChoice {
    /// Parses `cpu`, a number, or part of a name.
    pub fn parse(text: &str) -> Result<Self> {
        match text.trim() {
            "" => Err(Error::usage(
                "the device has no name",
                "give a name, a number of the list of devices, or cpu",
            )),
            "cpu" => Ok(Self::Cpu),
            number if number.bytes().all(|b| b.is_ascii_digit()) => {
                number.parse().map(Self::Index).map_err(|_| no_such(number))
            }
            name => Ok(Self::Name(name.to_owned())),
        }
    }
}

fn no_such(wish: &str) -> Error {
    Error::usage(format!("there is no device `{wish}`"), Remedy::OtherDevice)
}

/// Lists all Vulkan devices in the loader's order.
///
/// # Errors
/// Fails if Vulkan cannot list the devices.
pub fn candidates(instance: &Instance) -> Result<Vec<Candidate>> {
    // SAFETY: the instance is live.
    let devices =
        unsafe { instance.raw().enumerate_physical_devices() }.map_err(|c| failure("list devices", c))?;
    Ok(devices.into_iter().map(|device| describe(instance, device)).collect())
}

fn describe(instance: &Instance, raw: vk::PhysicalDevice) -> Candidate {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    let (mask, instance) = (instance.mask(), instance.raw());
    // SAFETY: the device belongs to the live instance; the chained structures live through the calls.
    let (memory, families) = unsafe {
        instance.get_physical_device_properties2(raw, &mut properties);
        (
            instance.get_physical_device_memory_properties(raw),
            instance.get_physical_device_queue_family_properties(raw),
        )
    };
    let p = properties.properties;
    let text = |name: &[std::ffi::c_char]| {
        let bytes: Vec<u8> = name.iter().take_while(|&&c| c != 0).map(|&c| c as u8).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let queue_family = families.iter().position(|f| f.queue_flags.contains(wanted)).map(|i| i as u32);
    let heaps = &memory.memory_heaps[..memory.memory_heap_count as usize];
    let local = heaps.iter().filter(|h| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
    Candidate {
        raw,
        name: text(&p.device_name),
        kind: p.device_type,
        version: p.api_version,
        queue_family,
        memory: local.map(|h| h.size).max().unwrap_or(0).min(mask.memory.unwrap_or(u64::MAX)),
        max_side: p.limits.max_image_dimension2_d.min(mask.side.unwrap_or(u32::MAX)),
        max_layers: p.limits.max_image_array_layers.min(mask.layers.unwrap_or(u32::MAX)),
        timestamp_period: f64::from(p.limits.timestamp_period),
        missing: missing(
            instance,
            mask,
            raw,
            p.api_version,
            queue_family.filter(|&i| families[i as usize].timestamp_valid_bits > 0),
        ),
        driver: format!("{} {}", text(&driver.driver_name), text(&driver.driver_info)),
    }
}

/// Returns the required capabilities that `device` lacks.
fn missing(
    instance: &ash::Instance,
    mask: &Mask,
    device: vk::PhysicalDevice,
    version: u32,
    queue_family: Option<u32>,
) -> Vec<&'static str> {
    let mut missing = Vec::new();
    const VERSION: &str = "Vulkan 1.3";
    if version < API_VERSION || mask.hides(VERSION) {
        missing.push(VERSION);
        return missing; // the queries below need Vulkan 1.3
    }
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v13);
    // SAFETY: as in `describe`.
    let float = unsafe {
        instance.get_physical_device_features2(device, &mut features);
        instance.get_physical_device_format_properties(device, vk::Format::R32G32B32A32_SFLOAT)
    };
    // Blending is used to sum the samples of a picture.
    let wanted = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR
        | vk::FormatFeatureFlags::COLOR_ATTACHMENT
        | vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND;
    for (there, name) in [
        (queue_family.is_some(), "a queue with graphics, compute and timestamps"),
        (v13.dynamic_rendering == vk::TRUE, "dynamic rendering"),
        (v13.synchronization2 == vk::TRUE, "synchronization2"),
        (v13.maintenance4 == vk::TRUE, "maintenance4"),
        (
            float.optimal_tiling_features.contains(wanted),
            "linear filtering, drawing and blending of 32-bit float images",
        ),
    ] {
        if !there || mask.hides(name) {
            missing.push(name);
        }
    }
    missing
}

/// Returns the preference of a kind of device, lowest first, and its name.
fn rank(kind: vk::PhysicalDeviceType) -> (u8, &'static str) {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => (0, "a discrete GPU"),
        vk::PhysicalDeviceType::INTEGRATED_GPU => (1, "an integrated GPU"),
        vk::PhysicalDeviceType::VIRTUAL_GPU => (2, "a virtual GPU"),
        vk::PhysicalDeviceType::CPU => (3, "a software device"),
        _ => (4, "a device of unknown kind"),
    }
}

/// Returns the name of a kind of device.
pub fn kind_name(kind: vk::PhysicalDeviceType) -> &'static str {
    rank(kind).1
}

/// Returns the index of the candidate chosen by `wish`, and the reason as text.
///
/// # Errors
/// Fails if there is no device, no matching one, or none with the required capabilities.
pub fn choose(candidates: &[Candidate], wish: &DeviceChoice) -> Result<(usize, String)> {
    if candidates.is_empty() {
        return Err(Error::device("Vulkan finds no device on this machine", INSTALL));
    }
    let usable = |i: &usize| candidates[*i].missing.is_empty();
    let best =
        |of: &mut dyn Iterator<Item = usize>| of.filter(usable).min_by_key(|&i| rank(candidates[i].kind).0);
    let named = |i: usize| {
        let c = &candidates[i];
        if c.missing.is_empty() {
            return Ok((i, "named by the user".to_owned()));
        }
        Err(Error::device(
            format!("`{}` lacks {}", c.name, c.missing.join(", ")),
            [Remedy::Words("update its driver".into()), Remedy::OtherDevice],
        ))
    };
    match wish {
        DeviceChoice::Index(i) if *i < candidates.len() => named(*i),
        DeviceChoice::Index(i) => Err(no_such(&i.to_string())),
        DeviceChoice::Name(name) => {
            let wanted = name.to_lowercase();
            let found = candidates.iter().position(|c| c.name.to_lowercase().contains(&wanted));
            found.map_or_else(|| Err(no_such(name)), named)
        }
        DeviceChoice::Cpu => {
            let mut software = (0..candidates.len()).filter(|&i| candidates[i].is_software());
            best(&mut software)
                .map(|i| (i, "a software device, as asked".to_owned()))
                .ok_or_else(|| Error::device("there is no usable software device", INSTALL))
        }
        DeviceChoice::Any => best(&mut (0..candidates.len()))
            .map(|i| {
                let usable = (0..candidates.len()).filter(|i| usable(i)).count();
                let kind = kind_name(candidates[i].kind);
                let reason = if usable == 1 {
                    format!("{kind}, the only usable one here")
                } else {
                    format!("{kind}, the fastest kind of the {usable} usable ones here")
                };
                (i, reason)
            })
            .ok_or_else(|| {
                let all = candidates.iter().map(|c| format!("{} lacks {}", c.name, c.missing.join(", ")));
                Error::device(
                    format!("no Vulkan device here can be used: {}", all.collect::<Vec<_>>().join("; ")),
                    INSTALL,
                )
            }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(name: &str, kind: vk::PhysicalDeviceType, missing: Vec<&'static str>) -> Candidate {
        Candidate {
            raw: vk::PhysicalDevice::null(),
            name: name.to_owned(),
            driver: String::new(),
            kind,
            version: API_VERSION,
            queue_family: Some(0),
            memory: 1 << 30,
            max_side: 16_384,
            max_layers: 256,
            timestamp_period: 1.0,
            missing,
        }
    }

    #[test]
    fn the_fastest_usable_kind_is_chosen_and_wishes_are_honoured() {
        let list = [
            candidate("soft", vk::PhysicalDeviceType::CPU, vec![]),
            candidate("Big One", vk::PhysicalDeviceType::DISCRETE_GPU, vec![]),
            candidate("old", vk::PhysicalDeviceType::DISCRETE_GPU, vec!["Vulkan 1.3"]),
        ];
        let chosen =
            |text: &str| DeviceChoice::parse(text).and_then(|wish| choose(&list, &wish)).map(|c| c.0);
        assert_eq!(choose(&list, &DeviceChoice::Any).unwrap().0, 1);
        assert_eq!(chosen("cpu").unwrap(), 0);
        assert_eq!(chosen("1").unwrap(), 1);
        assert_eq!(chosen("big").unwrap(), 1);
        assert!(chosen("2").unwrap_err().to_string().contains("Vulkan 1.3"));
        assert!(
            chosen("7").is_err() && chosen("nothing").is_err() && chosen("99999999999999999999999").is_err()
        );
        assert!(choose(&[], &DeviceChoice::Any).is_err());
        assert!(choose(&list[2..], &DeviceChoice::Any).is_err());
    }
}
