//! How far one picture is from a more exact one of the same scene, both as EXR files:
//!
//!     diffract render --samples 16 -o picture.exr
//!     diffract render --samples 1024 -o exact.exr
//!     cargo run --example picture_error -- picture.exr exact.exr
//!
//! What the exact picture does not cover is left out, so it may be of a few pixels alone: `diffract render --method reference
//! --sample-pixels 200`.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::measure::error::PixelErrors;
use glam::DVec3;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [picture, exact] = &files[..] else {
        return Err("name two EXR files: a picture and an exact one".into());
    };
    // Linear sRGB; alpha is how much of a pixel the mesh covers.
    let open = |file: &String| Ok::<_, image::ImageError>(image::open(file)?.into_rgba32f());
    let (picture, exact) = (open(picture)?, open(exact)?);
    if picture.dimensions() != exact.dimensions() {
        return Err("the pictures differ in size".into());
    }
    let colour = |pixel: &image::Rgba<f32>| DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
    let covered = picture.pixels().zip(exact.pixels()).filter(|(_, exact)| exact[3] > 0.0);
    let (picture, exact): (Vec<_>, Vec<_>) = covered.map(|(a, b)| (colour(a), colour(b))).unzip();
    let errors = PixelErrors::of(&picture, &exact, 0.0);
    println!(
        "{} pixels: relative L2 {:.4} ± {:.4}",
        errors.pixels, errors.relative_l2, errors.relative_l2_interval
    );
    Ok(())
}
