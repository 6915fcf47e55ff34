//! A surface of your own, as a function: where it sends red, green and blue light, and in which colours it shines.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::prelude::*;
use std::f64::consts::TAU;

/// Period along x and along y [µm].
const PERIOD: f64 = 1.5;

fn main() -> Result<()> {
    // An egg crate 0.2 µm high: 16 samples a period, 12 periods, so that copies of the patch join without a step.
    let spacing = PERIOD / 16.0;
    let wave = |x: f64| (TAU * x / PERIOD).cos();
    let field = HeightField::from_fn(192, 192, [spacing, spacing], |x, y| 0.1 * wave(x) * wave(y))?;
    let surface = MeanReference::new(MeanBrdf::in_sunlight(&field, 1.5), Illuminant::D65, 0.38);

    // Light from the normal leaves along the diagonals. The brightest direction of each wavelength is its first order.
    let angles: Vec<f64> = (0..5000).map(|i| 10.0 + 0.01 * f64::from(i)).collect();
    let pair = |angle: &f64| Pair::new(direction(0.0, 0.0), direction(*angle, 45.0));
    let pairs: Vec<Pair> = angles.iter().map(pair).collect();
    for wavelength in [0.65, 0.55, 0.45] {
        let brdf = surface.spectral(&pairs, wavelength, &Task::silent())?;
        let brightest = (0..brdf.len()).max_by(|&a, &b| brdf[a].total_cmp(&brdf[b])).unwrap_or(0);
        println!("{:.0} nm: brightest at {:.2} degrees", wavelength * 1e3, angles[brightest]);
    }

    // The colour of the same surface from some angles, in white light, five stops darker than a mirror image would be shown.
    let pairs = [25.0, 31.0, 37.0].map(|angle| pair(&angle));
    for (pair, xyz) in pairs.iter().zip(surface.xyz(&pairs, &Task::silent())?) {
        let [r, g, b] = display(xyz_to_linear_srgb(xyz), -5.0);
        println!("{:.0} degrees: #{r:02x}{g:02x}{b:02x}", pair.view.z.acos().to_degrees());
    }
    Ok(())
}
