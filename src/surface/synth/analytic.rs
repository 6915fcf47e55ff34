//! The surfaces with a formula. Their diffraction is known in closed form or close to it.

use super::grid::SampleGrid;
use crate::error::Result;
use crate::surface::HeightField;
use std::f64::consts::TAU;

/// Returns h = 0.
pub(super) fn flat(grid: &SampleGrid) -> Result<HeightField> {
    grid.sample(|_, _| 0.0)
}

/// Returns h = a sin(2πx/d), `height` = 2a. It sends J_m²(k w_m a) of the power factor into order m [Goodman, section 4.4.4, thin
/// sinusoidal phase grating].
pub(super) fn sinusoid(grid: &SampleGrid, height: f64) -> Result<HeightField> {
    let periods = grid.periods[0] as f64;
    grid.sample(|x, _| 0.5 * height * (TAU * periods * x).sin())
}

/// Returns h = s·x in each period, s = `height`/d, then at once back to 0 (an echelette grating): on it light leaves toward u = −w s. The
/// samples sit at cell centres, so their range is less than `height` by one sample's rise.
pub(super) fn blaze(grid: &SampleGrid, height: f64) -> Result<HeightField> {
    let periods = grid.periods[0] as f64;
    grid.sample(|x, _| height * (periods * x).fract())
}

/// Returns ridges of the full `height`, `duty` of the period wide at half of it, with straight flanks that are `flank` of the period wide; the first begins at the patch's border. For upright flanks, order m ≠ 0 takes
/// sin²(kwH/2) sin²(πmD)/(πm/2)² of the power, with the duty D: e^{ikwh} is 1 and e^{ikwH}, and the Fourier series of a rectangle is sin(πmD)/(πm).
pub(super) fn lamellar(grid: &SampleGrid, height: f64, duty: f64, flank: f64) -> Result<HeightField> {
    let periods = grid.periods[0] as f64;
    grid.sample(|x, _| {
        let from_middle = (periods * x - 0.5 * duty + 0.5).rem_euclid(1.0) - 0.5;
        let inside = 0.5 * duty - from_middle.abs();
        let share = if flank > 0.0 { inside / flank + 0.5 } else { f64::from(u8::from(inside > 0.0)) };
        height * share.clamp(0.0, 1.0)
    })
}

/// Returns h = H cos²(πx/p_x) cos²(πy/p_y): smooth round bumps on a rectangular lattice, flat between them.
pub(super) fn bumps(grid: &SampleGrid, height: f64) -> Result<HeightField> {
    let [across, along] = grid.periods.map(|n| n as f64);
    // sin² of the same is the lattice with a bump in the middle of each cell.
    let bump = |share: f64| 0.5 - 0.5 * (TAU * share).cos();
    grid.sample(|x, y| height * bump(across * x) * bump(along * y))
}
