//! Test for periodic height fields that knows their period: edges may meet where copies jump in phase.

use super::height_spectrum::{SurfaceSpectrum, analysed_part};
use super::periods::exact_lines;
use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::tiling::{Tiling, Verdict, tiles};

/// Returns [`tiles`] of `field`, with a seam along each axis over which a line of the spectrum has no whole number of periods.
///
/// A grating whose edges happen to meet, at another phase or with another slope, has copies without a step. Their period is another one: the
/// orders of the copies lie at whole periods over the patch.
///
/// # Errors
/// Too little memory for the spectrum.
pub fn joining(field: &HeightField) -> Result<Tiling> {
    let tiling = tiles(field);
    if tiling.verdict == Verdict::SeamAlongBoth { Ok(tiling) } else { with_periods(field, tiling) }
}

/// Returns `tiling`, the seams of `field`, with the periods over the patch.
///
/// # Errors
/// Too little memory for the spectrum.
pub fn with_periods(field: &HeightField, mut tiling: Tiling) -> Result<Tiling> {
    let part = analysed_part(field);
    let spectrum = SurfaceSpectrum::windowed(&part)?;
    let patch = field.patch_size();
    for frequency in exact_lines(&part, &spectrum)? {
        for axis in [0, 1] {
            if tiling.broken_periods(axis).is_none() {
                let strongest = tiling.periods[axis];
                tiling.periods[axis] = Some((frequency[axis] * patch[axis]).abs());
                if tiling.broken_periods(axis).is_none() && strongest.is_some() {
                    tiling.periods[axis] = strongest;
                }
            }
        }
    }
    let joins = [0, 1].map(|axis| tiling.joins(axis) && tiling.broken_periods(axis).is_none());
    tiling.verdict = Verdict::of(joins);
    Ok(tiling)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use std::f64::consts::TAU;

    /// Returns grooves of this period \[µm\] and 5 nm of noise, 20.48 µm across.
    fn grooves(period: f64, phase: f64, degrees: f64) -> HeightField {
        const SIDE: usize = 256;
        const PIXEL: f64 = 0.08;
        let mut random = Random::new(4);
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let heights = (0..SIDE * SIDE).map(|i| {
            let [x, y] = [i % SIDE, i / SIDE].map(|n| n as f64 * PIXEL);
            let noise = 5e-3 * 3f64.sqrt() * random.signed();
            0.1 * (TAU * (x * cos - y * sin) / period + phase).sin() + noise
        });
        HeightField::new(SIDE, SIDE, [PIXEL; 2], heights.collect()).unwrap()
    }

    #[test]
    fn gratings_join_after_whole_periods_and_at_no_other_phase() {
        let side: f64 = 20.48;
        for periods in [12.0, 17.0, 23.0] {
            assert_eq!(joining(&grooves(side / periods, 0.7, 0.0)).unwrap().verdict, Verdict::Tiles);
        }
        for periods in [12.5, 16.65, 17.2, 22.88] {
            // A quarter of these phases has edges of the same height.
            for phase in 0..8 {
                let tiling = joining(&grooves(side / periods, f64::from(phase), 0.0)).unwrap();
                assert_eq!(tiling.verdict, Verdict::SeamAlongX, "{periods} periods, {phase}: {tiling:?}");
                if let Some(found) = tiling.broken_periods(0) {
                    assert!((found - periods).abs() < 0.02, "{periods} periods, {phase}: {tiling:?}");
                }
            }
        }
        // Whole periods along neither axis.
        assert_eq!(joining(&grooves(1.3, 0.2, 31.0)).unwrap().verdict, Verdict::SeamAlongBoth);
    }

    #[test]
    fn every_generated_surface_joins() {
        for kind in SurfaceKind::ALL {
            for patch in [20.0, 65.0] {
                let surface =
                    generate(&Spec { patch: Some([patch; 2]), seed: 3, ..Spec::new(kind) }).unwrap();
                let tiling = joining(&surface).unwrap();
                assert_eq!(tiling.verdict, Verdict::Tiles, "{kind:?}, {patch} um: {tiling:?}");
            }
        }
    }
}
