//! A colour table: the spectrum is summed once for all directions, and a colour is read in no time. Without Vulkan.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::prelude::*;
use std::sync::Arc;

/// Relative error of the colours.
const TOLERANCE: f64 = 1e-2;

fn main() -> Result<()> {
    // A sinusoidal grating, 2 µm from crest to crest and 0.2 µm high.
    let field = synth::generate(&Spec::new(SurfaceKind::Sinusoid))?;
    // Light of a coherence length of 20 µm; the window's standard deviation is a quarter of it.
    // Series and table both err: half of the tolerance for the series leaves most of it to the table.
    let settings = PowerSettings::new(20.0 / 4.0, Beyond::Copies, 0.5 * TOLERANCE);
    // A task may report both steps, and cancel them.
    let task = Task::silent();
    let series = OrderSeries::new(&field, &settings, &task)?;
    let table = Arc::new(bake(&series, &TableSettings::new(Illuminant::D65, TOLERANCE), &task)?);
    println!("a table of {:.1} MiB", table.bytes() as f64 / f64::from(1 << 20));

    // X, Y, Z of BRDF times cosine, for light 30° from the normal and viewers on the other side.
    let reader = TableReader::new(Arc::clone(&table));
    for angle in [5.0, 10.0, 15.0, 50.0, 60.0] {
        let pair = Pair::new(direction(30.0, 0.0), direction(angle, 180.0));
        // One direction; a pixel would average over the covariance of (u, v) in its footprint.
        let xyz = reader.xyz(&pair, &1.5.into(), &Covariance::default());
        println!("{angle} degrees: {:.5} {:.5} {:.5}", xyz.x, xyz.y, xyz.z);
    }
    Ok(())
}
