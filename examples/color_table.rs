//! A colour table: the spectrum is summed once for all directions, and a colour is read in no time. Without Vulkan.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::{Context, HeightField, Optics, Result, Spec, SurfaceColours, SurfaceKind, Task, direction};

fn main() -> Result<()> {
    // A sinusoidal grating, 2 µm from crest to crest and 0.2 µm high.
    let field = HeightField::generate(&Spec::new(SurfaceKind::Sinusoid))?;
    // Light of a coherence length of 20 µm; colours may err by a hundredth.
    let optics = Optics::new().with_coherence_length(20.0).with_tolerance(1e-2);
    // The context has the user's cache: the second run reads what the first one made. A task may report each step, and cancel it.
    let colours = SurfaceColours::new(&field, &optics, 0.0, &Context::new(), &Task::silent())?;
    println!("a table of {:.1} MiB", colours.bytes() as f64 / f64::from(1 << 20));

    // X, Y, Z of the BRDF, for light 30° from the normal and viewers on the other side. A pixel would average over its footprint, here 0.
    let angles = [5.0, 10.0, 15.0, 50.0, 60.0];
    let pairs = angles.map(|angle| [direction(30.0, 0.0), direction(angle, 180.0)]);
    for (angle, [x, y, z]) in angles.iter().zip(colours.xyz(&pairs, 0.0)) {
        println!("{angle} degrees: {x:.5} {y:.5} {z:.5}");
    }
    Ok(())
}
