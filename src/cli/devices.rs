//! `diffract devices`: lists the Vulkan devices.

use super::check_validation;
use super::console::Console;
use super::options::DeviceOptions;
use crate::error::Result;
use crate::vk::instance::Instance;
use crate::vk::selection::{candidates, choose, kind_name};
use ash::vk;
use clap::Args;

/// Arguments of `devices`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract devices
  diffract devices --device cpu")]
pub struct Arguments {
    #[command(flatten)]
    device: DeviceOptions,
}

/// Lists the devices, the chosen one marked, with the reason.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let context = arguments.device.chosen(console).context().clone();
    let instance = Instance::new(context.validates())?;
    let list = candidates(&instance)?;
    let choice = choose(&list, context.device_choice());
    let mut text = String::new();
    for (index, device) in list.iter().enumerate() {
        let mark = if choice.as_ref().is_ok_and(|c| c.0 == index) { '*' } else { ' ' };
        let (major, minor) = (vk::api_version_major(device.version), vk::api_version_minor(device.version));
        text += &format!(
            "{mark} {index}  {}\n     {}, Vulkan {major}.{minor}.{}, driver {}\n     {:.1} GiB, images up to {} x {} x {} layers\n",
            device.name,
            kind_name(device.kind),
            vk::api_version_patch(device.version),
            device.driver,
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
