//! The sweep of `peaks`, with progress bars.

use crate::cli::console::Console;
use crate::cli::progress::ProgressBar;
use crate::cli::{evaluation, prepare};
use crate::error::Result;
use crate::measure::sweep::{AngleSweep, SweepPlane, windows_of_spread};
use crate::optics::coherence::Windows;
use crate::settings::Optics;
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use crate::task::DIRECTIONS;

/// Returns the sweep averaged over the windows of `optics`, and the sweeps of single windows from which its spread follows: of the
/// same windows, or of some windows for the mean over all.
pub fn of(
    plane: &SweepPlane,
    optics: &Optics,
    field: &HeightField,
    console: &Console,
) -> Result<(AngleSweep, Vec<AngleSweep>)> {
    let through = || AngleSweep::through(plane, optics, field, &mut |p, o, f| answer(p, o, f, console));
    match optics.windows {
        Windows::ONE => Ok((through()?, Vec::new())),
        Windows::Grid(counts) => {
            let windows = of_windows(plane, optics, field, counts, console)?;
            Ok((AngleSweep::mean(&windows), windows))
        }
        Windows::All => {
            let mean = through()?;
            let counts = windows_of_spread(optics, field);
            let windows = counts
                .map_or(Ok(Vec::new()), |count| of_windows(plane, optics, field, [count; 2], console))?;
            Ok((mean, windows))
        }
    }
}

/// Returns the sweep of each of n × m windows.
fn of_windows(
    plane: &SweepPlane,
    optics: &Optics,
    field: &HeightField,
    [n, m]: [u32; 2],
    console: &Console,
) -> Result<Vec<AngleSweep>> {
    let bar = ProgressBar::hidden(console, "windows", "a smaller number of --windows", (n * m) as usize);
    bar.add(0);
    AngleSweep::of_windows(plane, optics, field, [n, m], &mut |plane, optics, field| {
        let responses = answer(plane, optics, field, console)?;
        bar.add(1);
        Ok(responses)
    })
}

/// Returns the responses of a plane, wavelength by wavelength.
fn answer(plane: &SweepPlane, optics: &Optics, field: &HeightField, console: &Console) -> Result<Vec<f64>> {
    let pairs = plane.pairs();
    let mut responses = Vec::with_capacity(plane.evaluations());
    let settings = SourceSettings { shortest: plane.wavelengths[0], ..SourceSettings::new(optics.clone()) };
    prepare::for_each_window(console, field, &settings, |brdf, _| {
        let bar = ProgressBar::over(console, DIRECTIONS, "a range with larger steps", plane.evaluations());
        for &wavelength in &plane.wavelengths {
            let found = evaluation::ask(brdf, &pairs, Some(wavelength), &bar)?;
            responses.extend(found.iter().map(|f| f.x));
        }
        Ok(())
    })?;
    Ok(responses)
}
