//! How far one picture is from a more exact one of the same scene, both as EXR files:
//!
//!     diffract render --samples 16 -o picture.exr
//!     diffract render --samples 1024 -o exact.exr
//!     cargo run --example picture_error -- picture.exr exact.exr
//!
//! What the exact picture does not cover is left out, so it may be of a few pixels alone: `diffract render --method reference
//! --sample-pixels 200`.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::{PictureDifference, Result};

fn main() -> Result<()> {
    let [picture, exact] = [1, 2].map(|n| std::env::args().nth(n).unwrap_or_default());
    let difference = PictureDifference::from_files(picture, exact)?;
    println!(
        "{} pixels: relative L2 {:.4} ± {:.4}",
        difference.pixels, difference.relative_l2, difference.relative_l2_interval
    );
    Ok(())
}
