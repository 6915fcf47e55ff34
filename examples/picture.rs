//! A picture without a window: `cargo run --example picture -- snake.png` draws a snake.

use diffract::prelude::*;

fn main() -> Result<()> {
    let file = std::env::args().nth(1).unwrap_or("snake.png".into());
    // The user's cache, all threads, any Vulkan 1.3 device.
    let context = Context::new();
    let scene = Scene::open("snake")?;
    // Scales of a snake of the genus Elaphe.
    let field = synth::generate(&Spec { seed: 1, ..Spec::new(SurfaceKind::Elaphe) })?;
    let mut settings = PictureSettings::new([320, 240]);
    // The relative error that is accepted. A fifth of it takes five times as long, once: what is computed stays in the cache.
    settings.source.optics.tolerance = 5e-2;
    let picture = setup::picture(&scene, &field, &settings, &context, &Task::silent())?;
    // .png is what a display shows, .exr linear radiance.
    picture_file::save(file, &picture)
}
