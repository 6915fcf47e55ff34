//! A picture without a window: `cargo run --example picture -- disc.png` draws a disc like a CD.

use diffract::prelude::*;
use std::sync::Arc;

fn main() -> Result<()> {
    let file = std::env::args().nth(1).unwrap_or("disc.png".into());
    // Any Vulkan 1.3 device, without validation.
    let device = Device::open(Arc::new(Instance::new(false)?), &DeviceChoice::Any)?;
    let scene = Scene::open("disc")?;
    // A blazed grating, which stands for the tracks.
    let field = synth::generate(&Spec::new(Kind::Blaze))?;
    let picture = setup::picture(&device, &scene, &field, &PictureSettings::new([320, 240]))?;
    // .png is what a display shows, .exr linear radiance.
    picture_file::save(file, &picture)
}
