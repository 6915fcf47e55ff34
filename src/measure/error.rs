//! Errors of a picture relative to the reference picture of the same directions. A test of each measure shows that it
//! detects a difference.

use crate::optics::color::DISPLAY_BLACK;
use crate::random::Random;
use glam::DVec3;
use serde::Serialize;

/// Errors of a picture over the compared pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PixelErrors {
    /// Number of compared pixels.
    pub pixels: usize,
    /// ‖a − b‖/‖b‖ of linear RGB.
    pub relative_l2: f64,
    /// Half of the 95 % confidence interval of `relative_l2` for the whole picture, if the pixels are a random sample
    /// of it.
    pub relative_l2_interval: f64,
    /// RMS over pixels of the relative error |a − b|/max(|b|, floor) of each.
    pub relative_rms: f64,
    /// 99th percentile over pixels of this relative error.
    pub p99: f64,
}

impl PixelErrors {
    /// Returns true if the error is larger than `promised` by more than the sampling error.
    pub fn exceeds(&self, promised: f64) -> bool {
        self.relative_l2 - self.relative_l2_interval > promised
    }

    /// Returns the errors of `picture` relative to `exact`, linear sRGB pixel by pixel, displayed at `exposure` stops.
    /// The floor is the largest radiance displayed as black.
    pub fn of(picture: &[DVec3], exact: &[DVec3], exposure: f64) -> Self {
        let floor = DISPLAY_BLACK / exposure.exp2();
        let pairs = || picture.iter().zip(exact);
        let squares: Vec<(f64, f64)> =
            pairs().map(|(a, b)| ((*a - *b).length_squared(), b.length_squared())).collect();
        let (difference, size) = squares.iter().fold((0.0, 0.0), |(d, s), (x, y)| (d + x, s + y));
        let ratio = if size > 0.0 { difference / size } else { 0.0 };
        // Variance of a ratio of sums, from the residuals of its parts (Cochran, Sampling Techniques, 6.4).
        let residuals: f64 = squares.iter().map(|(d, s)| (d - ratio * s).powi(2)).sum();
        let deviation = if size > 0.0 { residuals.sqrt() / size } else { 0.0 };
        let mut relative: Vec<f64> =
            pairs().map(|(a, b)| (*a - *b).length() / b.length().max(floor)).collect();
        relative.sort_by(f64::total_cmp);
        let last = relative.len().saturating_sub(1);
        let rms = (relative.iter().map(|e| e * e).sum::<f64>() / relative.len().max(1) as f64).sqrt();
        Self {
            pixels: picture.len().min(exact.len()),
            relative_l2: ratio.sqrt(),
            relative_l2_interval: if ratio > 0.0 { 1.96 * deviation / (2.0 * ratio.sqrt()) } else { 0.0 },
            relative_rms: rms,
            p99: relative.get((0.99 * last as f64).ceil() as usize).copied().unwrap_or(0.0),
        }
    }
}

/// Returns the mean ꟻLIP error of two displayed pictures (Andersson et al. 2020): the difference seen by an observer
/// who flips between them, from 0 (none) to 1, at 67 pixels per degree.
pub fn flip(picture: &[[u8; 4]], exact: &[[u8; 4]], size: [u32; 2]) -> f64 {
    let errors = flip_map(picture, exact, size);
    errors.iter().map(|error| f64::from(*error)).sum::<f64>() / errors.len().max(1) as f64
}

/// Returns the ꟻLIP error of each pixel.
pub fn flip_map(picture: &[[u8; 4]], exact: &[[u8; 4]], [width, height]: [u32; 2]) -> Vec<f32> {
    let image = |pixels: &[[u8; 4]]| {
        let rgb: Vec<u8> = pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        nv_flip::FlipImageRgb8::with_data(width, height, &rgb)
    };
    nv_flip::flip(image(exact), image(picture), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec()
}

/// Returns `count` of `pixels`, or all if there are fewer, in their order: a random choice that is the same every time.
pub fn sample(pixels: &[usize], count: usize) -> Vec<usize> {
    /// Arbitrary, but fixed.
    const SEED: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut pixels = pixels.to_vec();
    let count = count.min(pixels.len());
    let mut random = Random::new(SEED);
    // First steps of a Fisher–Yates shuffle.
    for i in 0..count {
        let rest = (pixels.len() - i) as u64;
        pixels.swap(i, i + (random.bits() % rest) as usize);
    }
    pixels.truncate(count);
    pixels.sort_unstable();
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns pixels with the statistics of speckle, over a wide range of brightness.
    fn picture() -> Vec<DVec3> {
        (0..5000)
            .map(|i| {
                let u = (f64::from(i) * 0.618_034).fract();
                let light = -(1.0 - u).ln();
                DVec3::new(0.3, 0.5, 0.2 - 0.3 * u) * light
            })
            .collect()
    }

    #[test]
    fn equal_pictures_have_no_error_and_every_known_error_is_found() {
        let exact = picture();
        let none = PixelErrors::of(&exact, &exact, 0.0);
        assert_eq!((none.relative_l2, none.p99, none.relative_rms), (0.0, 0.0, 0.0));
        let brighter: Vec<DVec3> = exact.iter().map(|p| *p * 1.01).collect();
        let e = PixelErrors::of(&brighter, &exact, 0.0);
        assert!((e.relative_l2 - 0.01).abs() < 1e-9 && e.relative_l2_interval < 1e-9, "{e:?}");
        // A hue shift leaves the luminance about the same and is detected; one pixel in fifty moves p99 and no more.
        let swapped: Vec<DVec3> = exact.iter().map(|p| DVec3::new(p.z, p.y, p.x)).collect();
        assert!(PixelErrors::of(&swapped, &exact, 0.0).relative_l2 > 0.1);
        let mut spots = exact.clone();
        spots.iter_mut().step_by(50).for_each(|p| *p *= 1.5);
        assert!((PixelErrors::of(&spots, &exact, 0.0).p99 - 0.5).abs() < 1e-9);
        spots = exact.clone();
        spots.iter_mut().step_by(500).for_each(|p| *p *= 1.5);
        assert_eq!(PixelErrors::of(&spots, &exact, 0.0).p99, 0.0);
    }

    #[test]
    fn the_floor_is_what_the_display_shows_as_black() {
        let (dark, off) = ([DVec3::splat(1e-7)], [DVec3::splat(2e-7)]);
        assert!(PixelErrors::of(&off, &dark, 0.0).p99 < 2e-3);
        assert!((PixelErrors::of(&off, &dark, 20.0).p99 - 1.0).abs() < 1e-9, "at 20 stops it is seen");
    }

    #[test]
    fn the_interval_of_a_sample_holds_the_error_of_the_whole() {
        let exact = picture();
        let noisy: Vec<DVec3> = exact
            .iter()
            .enumerate()
            .map(|(i, p)| *p * (1.0 + 0.02 * ((i * 7919 % 1000) as f64 / 500.0 - 1.0)))
            .collect();
        let whole = PixelErrors::of(&noisy, &exact, 0.0).relative_l2;
        let chosen = sample(&(0..exact.len()).collect::<Vec<_>>(), 500);
        let pick = |all: &[DVec3]| chosen.iter().map(|&i| all[i]).collect::<Vec<_>>();
        let part = PixelErrors::of(&pick(&noisy), &pick(&exact), 0.0);
        assert!(part.relative_l2_interval < 0.3 * whole, "{part:?}");
        assert!((part.relative_l2 - whole).abs() < 2.0 * part.relative_l2_interval, "{part:?} of {whole}");
    }

    #[test]
    fn a_sample_has_the_size_asked_for_no_pixel_twice_and_is_spread() {
        let all: Vec<usize> = (100..1100).collect();
        let chosen = sample(&all, 200);
        assert!(chosen.len() == 200 && chosen.windows(2).all(|w| w[0] < w[1]));
        let low = chosen.iter().filter(|&&i| i < 600).count();
        assert!((70..130).contains(&low), "{low}");
        assert_eq!(sample(&all, 5000), all);
        assert_eq!(sample(&all, 200), chosen);
    }

    #[test]
    fn flip_sees_a_change_of_hue_and_nothing_where_nothing_changed() {
        let grey: Vec<[u8; 4]> = (0..64 * 64).map(|i| [(i % 64) as u8 * 3, 90, 120, 255]).collect();
        assert_eq!(flip(&grey, &grey, [64, 64]), 0.0);
        let shifted: Vec<[u8; 4]> = grey.iter().map(|p| [p[0], p[2], p[1], 255]).collect();
        let slightly: Vec<[u8; 4]> = grey.iter().map(|p| [p[0], p[1] + 2, p[2], 255]).collect();
        let (much, little) = (flip(&shifted, &grey, [64, 64]), flip(&slightly, &grey, [64, 64]));
        assert!(much > 0.1 && little > 0.0 && little < 0.3 * much, "{much} {little}");
    }
}
