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
    let mut answer = |p: &SweepPlane, o: &Optics, f: &HeightField| answer(p, o, f, console);
    match optics.windows {
        Windows::Grid(counts) => {
            let windows = AngleSweep::of_windows(plane, optics, field, counts, &mut answer)?;
            // A single window has no spread.
            Ok((AngleSweep::mean(&windows), if windows.len() > 1 { windows } else { Vec::new() }))
        }
        Windows::All => {
            let mean = AngleSweep::through(plane, optics, field, &mut answer)?;
            let of_windows = |n| AngleSweep::of_windows(plane, optics, field, [n, n], &mut answer);
            Ok((mean, windows_of_spread(optics, field).map_or(Ok(Vec::new()), of_windows)?))
        }
    }
}

/// Returns the responses of a plane, window by window and wavelength by wavelength.
fn answer(plane: &SweepPlane, optics: &Optics, field: &HeightField, console: &Console) -> Result<Vec<f64>> {
    let pairs = plane.pairs();
    let mut responses = Vec::with_capacity(plane.evaluations());
    let settings = SourceSettings {
        shortest: plane.wavelengths[0],
        windows_apart: true,
        ..SourceSettings::new(optics.clone())
    };
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
