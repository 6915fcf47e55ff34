//! The BRDF of a height image, for one pair of directions: `cargo run --example brdf_value -- scan.png`.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::prelude::*;

fn main() -> Result<()> {
    // A grey image: its samples are 100 nm apart, and white stands 200 nm above black. Lengths are micrometres.
    let file = std::env::args().nth(1).unwrap_or("scan.png".into());
    let scale = ReadSettings { pixel_size: Some([0.1, 0.1]), height: Some(0.2), ..ReadSettings::default() };
    let field = HeightField::read(file, &scale)?;
    // The mean that a pixel sees in sunlight, for refractive index 1.5 and wavelengths from 380 nm.
    let surface = MeanReference::new(MeanBrdf::in_sunlight(&field, 1.5), Illuminant::D65, 0.38);
    // Light 30° from the normal; the viewer on the other side, 13° from it.
    let pair = Pair::new(direction(30.0, 0.0), direction(13.0, 180.0));
    let brdf = surface.spectral(&[pair], 0.55, &Task::silent())?;
    println!("{:.6e} per steradian at 550 nm", brdf[0]);
    Ok(())
}
