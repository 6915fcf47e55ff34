//! Automatic exposure of a picture.

use crate::optics::color::LUMINANCE;
use glam::DVec3;

/// Least and largest exposure \[stops\].
pub const EXPOSURES: (f64, f64) = (-40.0, 40.0);
/// Displayed value of the log-average luminance: middle grey, linear.
const MIDDLE_GREY: f64 = 0.18;
/// Pixels darker than this fraction of the brightest one are ignored: black would pull the log-average down without
/// bound.
const DARKEST: f64 = 1e-6;
/// Steps per stop to which exposures are rounded.
const PARTS: f64 = 10.0;

/// Returns the exposure \[stops\] that displays the log-average luminance of `radiance` as middle grey (Reinhard et
/// al., *Photographic Tone Reproduction for Digital Images*, 2002), averaged over the covered pixels that are not
/// black. The result lies within [`EXPOSURES`], in tenths of a stop. `radiance` is premultiplied as in
/// [`super::renderer::Picture::radiance`]. `None` if no pixel is lit.
pub fn automatic(radiance: &[[f32; 4]]) -> Option<f64> {
    let luminances: Vec<f64> = radiance.iter().filter_map(luminance).collect();
    let brightest = luminances.iter().copied().fold(0.0, f64::max);
    let logarithms = luminances.iter().filter(|&&y| y > DARKEST * brightest).map(|y| y.log2());
    let (sum, count) = logarithms.fold((0.0, 0.0), |(sum, count), y| (sum + y, count + 1.0));
    let stops = MIDDLE_GREY.log2() - sum / count;
    // Without a pixel the mean is 0/0. Adding 0 turns −0 into 0.
    let rounded = (stops.clamp(EXPOSURES.0, EXPOSURES.1) * PARTS).round() / PARTS + 0.0;
    rounded.is_finite().then_some(rounded)
}

/// Returns the luminance of a pixel without its uncovered part; `None` if it is not lit.
fn luminance(pixel: &[f32; 4]) -> Option<f64> {
    let [r, g, b, coverage] = pixel.map(f64::from);
    let luminance = LUMINANCE.dot(DVec3::new(r, g, b)) / coverage;
    (coverage > 0.0 && luminance > 0.0 && luminance.is_finite()).then_some(luminance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: f32) -> [f32; 4] {
        [level, level, level, 1.0]
    }

    #[test]
    fn the_log_average_becomes_middle_grey() {
        assert_eq!(automatic(&[grey(0.18)]), Some(0.0));
        assert_eq!(automatic(&[grey(0.09), grey(0.36)]), Some(0.0));
        assert_eq!(automatic(&[grey(0.09)]), Some(1.0));
        assert_eq!(automatic(&[grey(0.72), grey(1.44)]), Some(-2.5));
        // log2(0.18) = −2.474.
        assert_eq!(automatic(&[grey(1.0)]), Some(-2.5));
        assert_eq!(automatic(&[grey(0.5)]), Some(-1.5));
        // A half-covered pixel, premultiplied, is as bright as a whole one.
        assert_eq!(automatic(&[[0.045, 0.045, 0.045, 0.5]]), Some(1.0));
        assert_eq!(automatic(&[grey(0.18 * 1.001)]).map(f64::is_sign_positive), Some(true));
    }

    #[test]
    fn neither_black_nor_uncovered_nor_impossible_pixels_count() {
        let lit = [grey(0.36), grey(0.09), grey(0.045)];
        let alone = automatic(&lit);
        let others =
            [grey(0.0), grey(1e-9), grey(-1.0), grey(f32::NAN), grey(f32::INFINITY), [9.0, 9.0, 9.0, 0.0]];
        assert_eq!(automatic(&[&lit[..], &others].concat()), alone);
        for nothing in [&[][..], &[grey(0.0)], &[grey(-1.0)], &[[1.0, 1.0, 1.0, 0.0]]] {
            assert_eq!(automatic(nothing), None, "{nothing:?}");
        }
    }

    #[test]
    fn exposures_stay_within_their_range() {
        assert_eq!(automatic(&[grey(1e-30)]), Some(40.0));
        assert_eq!(automatic(&[grey(1e30)]), Some(-40.0));
    }
}
