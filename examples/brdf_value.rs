//! The BRDF of a height image, for one pair of directions: `cargo run --example brdf_value -- scan.png`.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::{HeightField, Optics, ReadSettings, Result, SurfaceBrdf, Task, direction};

fn main() -> Result<()> {
    // A grey image: its samples are 100 nm apart, and white stands 200 nm above black. Lengths are micrometres.
    let file = std::env::args().nth(1).unwrap_or("scan.png".into());
    let scale = ReadSettings::new().with_pixel_size([0.1, 0.1]).with_height(0.2);
    let task = Task::silent();
    let field = HeightField::read(file, &scale, &task)?;
    // The mean that a pixel sees in sunlight, for a refractive index of 1.5.
    let surface = SurfaceBrdf::new(&field, &Optics::new().by_reference(), &task)?;
    // Light 30° from the normal; the viewer on the other side, 13° from it.
    let pair = [direction(30.0, 0.0), direction(13.0, 180.0)];
    let brdf = surface.spectral(&[pair], 0.55, &task)?;
    println!("{:.6e} per steradian at 550 nm", brdf[0]);
    Ok(())
}
