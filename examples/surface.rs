//! A surface of your own, as a function: where it sends red, green and blue light, and in which colours it shines.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::{HeightField, Optics, Result, SurfaceBrdf, Task, direction, display_srgb, linear_srgb};
use std::f64::consts::TAU;

/// Period along x and along y [µm].
const PERIOD: f64 = 1.5;

fn main() -> Result<()> {
    // An egg crate 0.2 µm high: 16 samples a period, 12 periods, so that copies of the patch join without a step.
    let spacing = PERIOD / 16.0;
    let wave = |x: f64| (TAU * x / PERIOD).cos();
    let field = HeightField::from_fn(192, 192, [spacing, spacing], |x, y| 0.1 * wave(x) * wave(y))?;
    let task = Task::silent();
    let surface = SurfaceBrdf::new(&field, &Optics::new().by_reference(), &task)?;

    // Light from the normal leaves along the diagonals. The brightest direction of each wavelength is its first order.
    let angles: Vec<f64> = (0..5000).map(|i| 10.0 + 0.01 * f64::from(i)).collect();
    let pair = |angle: &f64| [direction(0.0, 0.0), direction(*angle, 45.0)];
    let pairs: Vec<_> = angles.iter().map(pair).collect();
    for wavelength in [0.65, 0.55, 0.45] {
        let brdf = surface.spectral(&pairs, wavelength, &task)?;
        let brightest = (0..brdf.len()).max_by(|&a, &b| brdf[a].total_cmp(&brdf[b])).unwrap_or(0);
        println!("{:.0} nm: brightest at {:.2} degrees", wavelength * 1e3, angles[brightest]);
    }

    // The colour of the same surface from some angles, in white light, five stops darker than a mirror image would be shown.
    let angles = [25.0, 31.0, 37.0];
    for (angle, xyz) in angles.iter().zip(surface.xyz(&angles.map(|angle| pair(&angle)), &task)?) {
        let [r, g, b] = display_srgb(linear_srgb(xyz), -5.0);
        println!("{angle:.0} degrees: #{r:02x}{g:02x}{b:02x}");
    }
    Ok(())
}
