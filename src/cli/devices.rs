//! `diffract devices`: lists the Vulkan devices.

use super::console::Console;
use super::options::DeviceOptions;
use super::{check_validation, write};
use crate::error::Result;
use crate::vk::instance::Instance;
use crate::vk::selection::{Candidate, candidates, choose, kind_name};
use ash::vk;
use clap::Args;
use serde::Serialize;

/// Arguments of `devices`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract devices
  diffract devices --device cpu")]
pub struct Arguments {
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    device: DeviceOptions,
}

/// List of devices in the JSON.
#[derive(Serialize)]
struct DeviceList<'a> {
    devices: Vec<DeviceReport<'a>>,
    /// Number of the chosen one, from 0.
    chosen: Option<usize>,
    reason: Option<&'a str>,
}

/// Device in the JSON.
#[derive(Serialize)]
struct DeviceReport<'a> {
    name: &'a str,
    kind: &'static str,
    vulkan: String,
    driver: &'a str,
    /// Identity, 32 hexadecimal digits in five groups.
    uuid: String,
    memory_bytes: u64,
    largest_image: [u32; 3],
    /// Requirements that the device lacks; none if it can be used.
    missing: &'a [&'static str],
}

impl<'a> DeviceReport<'a> {
    fn new(device: &'a Candidate) -> Self {
        let (major, minor) = (vk::api_version_major(device.version), vk::api_version_minor(device.version));
        Self {
            name: &device.name,
            kind: kind_name(device.kind),
            vulkan: format!("{major}.{minor}.{}", vk::api_version_patch(device.version)),
            driver: &device.driver,
            uuid: device.hyphenated_uuid(),
            memory_bytes: device.memory,
            largest_image: [device.max_side, device.max_side, device.max_layers],
            missing: &device.missing,
        }
    }
}

/// Lists the devices, the chosen one marked, with the reason.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let context = arguments.device.chosen(console).context().clone();
    let instance = Instance::new(context.validates())?;
    let list = candidates(&instance)?;
    let choice = choose(&list, context.device_choice());
    if arguments.json {
        let devices = list.iter().map(DeviceReport::new).collect();
        let (chosen, reason) =
            choice.as_ref().map_or((None, None), |(index, reason)| (Some(*index), Some(reason.as_str())));
        console.write(&write::json_text(&DeviceList { devices, chosen, reason })?)?;
        choice?;
        return check_validation(&instance.messages());
    }
    let mut text = String::new();
    for (index, device) in list.iter().enumerate() {
        let mark = if choice.as_ref().is_ok_and(|c| c.0 == index) { '*' } else { ' ' };
        let (major, minor) = (vk::api_version_major(device.version), vk::api_version_minor(device.version));
        text += &format!(
            "{mark} {index}  {}\n     {}, Vulkan {major}.{minor}.{}, driver {}\n     UUID {}\n     {:.1} GiB, images up to {} x {} x {} layers\n",
            device.name,
            kind_name(device.kind),
            vk::api_version_patch(device.version),
            device.driver,
            device.hyphenated_uuid(),
            device.memory as f64 / f64::from(1 << 30),
            device.max_side,
            device.max_side,
            device.max_layers,
        );
        if !device.missing.is_empty() {
            text += &format!("     cannot be used: it lacks {}\n", device.missing.join(", "));
        }
    }
    console.write(&text)?;
    let (index, reason) = choice?;
    console.write(&format!("chosen: {index}, {reason}\n"))?;
    check_validation(&instance.messages())
}
