//! A picture without a window: `cargo run --example picture -- snake.png` draws a snake.

use diffract::{Context, HeightField, Optics, PictureSettings, Result, Scene, Spec, SurfaceKind, Task, draw};

fn main() -> Result<()> {
    let file = std::env::args().nth(1).unwrap_or("snake.png".into());
    // The user's cache, all threads, any Vulkan 1.3 device.
    let context = Context::new();
    let scene = Scene::open("snake")?;
    // Scales of a snake of the genus Elaphe.
    let field = HeightField::generate(&Spec::new(SurfaceKind::Elaphe).with_seed(1))?;
    // The relative error that is accepted. A fifth of it takes five times as long, once: what is computed stays in the cache.
    let optics = Optics::new().with_tolerance(5e-2);
    let settings = PictureSettings::new([320, 240]).with_optics(&optics);
    let picture = draw(&scene, &field, &settings, &context, &Task::silent())?;
    // .png is what a display shows, .exr linear radiance.
    picture.save(file)
}
