//! Selection of one of the Vulkan devices of the machine.

use super::failure;
use super::instance::{API_VERSION, INSTALL, Instance};
use super::mask::Mask;
use crate::error::{Error, Remedy, Result};
use ash::{ext, vk};

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
    /// Number of the maker on the PCI bus.
    pub vendor: u32,
    /// Identity, 32 hexadecimal digits: on NVIDIA's devices that of CUDA and `nvidia-smi -L`.
    pub uuid: String,
    /// Domain, bus, device and function on the PCI bus, if the driver tells.
    pub bus: Option<[u32; 4]>,
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

    /// Returns the identity in groups of 8, 4, 4, 4 and 12 digits.
    pub fn hyphenated_uuid(&self) -> String {
        /// First digits of the groups behind the first.
        const GROUPS: [usize; 4] = [8, 12, 16, 20];
        let digit = |(i, digit): (usize, char)| GROUPS.contains(&i).then_some('-').into_iter().chain([digit]);
        self.uuid.chars().enumerate().flat_map(digit).collect()
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
    /// Device whose identity begins with these hexadecimal digits.
    Uuid(String),
    /// First device whose name contains this text.
    Name(String),
}

impl DeviceChoice {
    /// Parses `cpu`, a number, an identity as `nvidia-smi -L` prints it, or part of a name.
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
            name => Ok(digits_of_uuid(name).map_or_else(|| Self::Name(name.to_owned()), Self::Uuid)),
        }
    }
}

/// Returns the hexadecimal digits of an identity: a whole one, or the begin of one behind `GPU-`.
fn digits_of_uuid(text: &str) -> Option<String> {
    const WHOLE: usize = 32;
    let after = text.strip_prefix("GPU-");
    let digits: String = after.unwrap_or(text).chars().filter(|c| *c != '-').collect();
    let is_long_enough = if after.is_some() { !digits.is_empty() } else { digits.len() == WHOLE };
    let is_uuid = is_long_enough && digits.len() <= WHOLE && digits.bytes().all(|b| b.is_ascii_hexdigit());
    is_uuid.then(|| digits.to_lowercase())
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
    let mut identity = vk::PhysicalDeviceIDProperties::default();
    let mut properties =
        vk::PhysicalDeviceProperties2::default().push_next(&mut driver).push_next(&mut identity);
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
        vendor: p.vendor_id,
        uuid: identity.device_uuid.iter().map(|byte| format!("{byte:02x}")).collect(),
        bus: bus(instance, raw),
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

/// Returns domain, bus, device and function of `device` on the PCI bus, if its driver tells.
fn bus(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<[u32; 4]> {
    // SAFETY: as in `describe`.
    let extensions = unsafe { instance.enumerate_device_extension_properties(device) }.ok()?; // unknown without
    let has = |e: &vk::ExtensionProperties| e.extension_name_as_c_str() == Ok(ext::pci_bus_info::NAME);
    extensions.iter().any(has).then_some(())?;
    let mut bus = vk::PhysicalDevicePCIBusInfoPropertiesEXT::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut bus);
    // SAFETY: as in `describe`; the device has the extension of the chained structure.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    Some([bus.pci_domain, bus.pci_bus, bus.pci_device, bus.pci_function])
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

/// Environment variable by which schedulers of clusters give a process some of NVIDIA's devices.
const VISIBLE: &str = "CUDA_VISIBLE_DEVICES";

/// Returns the first device that `list`, the value of [`VISIBLE`], names: by number along the PCI bus or by identity. `None` if it names none that is here: in a container
/// the numbers may be those of the whole machine.
fn first_visible(candidates: &[Candidate], list: &str) -> Option<usize> {
    /// Number of NVIDIA.
    const NVIDIA: u32 = 0x10de;
    let mut of_nvidia: Vec<usize> =
        (0..candidates.len()).filter(|i| candidates[*i].vendor == NVIDIA).collect();
    of_nvidia.sort_by_key(|i| candidates[*i].bus);
    let first = list.split(',').next()?.trim();
    if let Ok(number) = first.parse::<usize>() {
        return of_nvidia.get(number).copied();
    }
    let digits = digits_of_uuid(first)?;
    of_nvidia.into_iter().find(|i| candidates[*i].uuid.starts_with(&digits))
}

/// Returns the index of the candidate chosen by `wish`, and the reason as text. Without a wish the devices count that `CUDA_VISIBLE_DEVICES` names.
///
/// # Errors
/// Fails if there is no device, no matching one, or none with the required capabilities.
pub fn choose(candidates: &[Candidate], wish: &DeviceChoice) -> Result<(usize, String)> {
    let visible = std::env::var(VISIBLE).ok(); // what is no text names no device
    choose_among(candidates, wish, visible.as_deref())
}

/// Returns what [`choose`] does, where `visible` is the value of [`VISIBLE`].
fn choose_among(
    candidates: &[Candidate],
    wish: &DeviceChoice,
    visible: Option<&str>,
) -> Result<(usize, String)> {
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
        DeviceChoice::Uuid(digits) => {
            let found = candidates.iter().position(|c| c.uuid.starts_with(digits));
            found.map_or_else(|| Err(no_such(digits)), named)
        }
        DeviceChoice::Cpu => {
            let mut software = (0..candidates.len()).filter(|&i| candidates[i].is_software());
            best(&mut software)
                .map(|i| (i, "a software device, as asked".to_owned()))
                .ok_or_else(|| Error::device("there is no usable software device", INSTALL))
        }
        DeviceChoice::Any
            if let Some(i) = visible.and_then(|list| first_visible(candidates, list)).filter(usable) =>
        {
            Ok((i, format!("the first that {VISIBLE} names")))
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
            vendor: 0,
            uuid: String::new(),
            bus: None,
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

    /// Returns three devices of NVIDIA, not in the order of the bus, and one of another maker.
    fn node() -> Vec<Candidate> {
        let nvidia = |bus: u32, uuid: &str| Candidate {
            vendor: 0x10de,
            bus: Some([0, bus, 0, 0]),
            uuid: uuid.to_owned(),
            ..candidate("NVIDIA H100", vk::PhysicalDeviceType::DISCRETE_GPU, vec![])
        };
        vec![
            candidate("Radeon", vk::PhysicalDeviceType::DISCRETE_GPU, vec![]),
            nvidia(0x3b, "b1b2b3b4000000000000000000000001"),
            nvidia(0x86, "c1c2c3c4000000000000000000000002"),
            nvidia(0x1a, "a1a2a3a4000000000000000000000003"),
        ]
    }

    #[test]
    fn the_first_device_that_a_scheduler_names_is_chosen_unless_the_user_names_another() {
        let list = node();
        let chosen = |visible| choose_among(&list, &DeviceChoice::Any, visible).unwrap().0;
        assert_eq!(["0", "1", "2", "1,0", " 2 , 1"].map(|visible| chosen(Some(visible))), [3, 1, 2, 1, 2]);
        assert_eq!(chosen(Some("GPU-c1c2c3c4-0000-0000-0000-000000000002")), 2);
        assert_eq!(chosen(Some("GPU-b1b2")), 1, "an identity may be cut short");
        for other in
            [None, Some(""), Some("3"), Some("-1"), Some("NoDevFiles"), Some("GPU-d1"), Some("MIG-c1c2")]
        {
            assert_eq!(chosen(other), 0, "{other:?} names none of them");
        }
        let wish = DeviceChoice::parse("radeon").unwrap();
        assert_eq!(choose_among(&list, &wish, Some("1")).unwrap().0, 0);
    }

    #[test]
    fn a_device_is_named_by_its_identity() {
        let list = node();
        let chosen = |text: &str| choose(&list, &DeviceChoice::parse(text).unwrap()).map(|found| found.0);
        assert_eq!(chosen("GPU-A1A2A3A4-0000-0000-0000-000000000003").unwrap(), 3);
        assert_eq!(chosen("c1c2c3c4-0000-0000-0000-000000000002").unwrap(), 2);
        assert!(chosen("GPU-d1").unwrap_err().to_string().contains("no device `d1`"));
        assert_eq!(list[3].hyphenated_uuid(), "a1a2a3a4-0000-0000-0000-000000000003");
        assert_eq!(DeviceChoice::parse("cafe").unwrap(), DeviceChoice::Name("cafe".to_owned()));
    }
}
