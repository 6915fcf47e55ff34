//! How far apart two results are. Each measure has a test that shows it sees a difference.

/// RMS over directions of |a − b| / max(|b|, floor): each direction relative to its own value.
pub fn per_direction(a: &[f64], b: &[f64], floor: f64) -> f64 {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().chain(b).all(|x| x.is_finite()), "a value is not finite");
    let squares = a.iter().zip(b).map(|(a, b)| ((a - b) / b.abs().max(floor)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// ‖a − b‖/‖b‖ of one channel of RGBA pixels, over the pixels that `b` covers. Coverage must agree, but for rounding.
pub fn channel(a: &[[f32; 4]], b: &[[f32; 4]], channel: usize) -> f64 {
    assert_eq!(a.len(), b.len());
    let (mut difference, mut size) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        assert!((a[3] - b[3]).abs() < 1e-6, "coverage differs: {} and {}", a[3], b[3]);
        assert!(a.iter().chain(b).all(|x| x.is_finite()), "a pixel is not finite");
        let (x, y) = (f64::from(a[channel]), f64::from(b[channel]));
        difference += (x - y).powi(2);
        size += y * y;
    }
    assert!(size > 0.0, "the picture is black");
    (difference / size).sqrt()
}

/// ‖a − b‖/‖b‖ of the colours of RGBA pixels, all channels together.
pub fn colours(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let square = |x: f32| f64::from(x).powi(2);
    let difference: f64 = a.iter().zip(b).flat_map(|(a, b)| (0..3).map(|c| square(a[c] - b[c]))).sum();
    (difference / b.iter().flat_map(|b| (0..3).map(|c| square(b[c]))).sum::<f64>()).sqrt()
}

/// Returns true for a quarter of the pixels of a picture of `size`, for comparisons of sums over neighbouring pixels: diagonal bands 8 pixels wide and 24
/// apart, the middle of one of which runs through the centre.
pub fn is_compared(pixel: usize, [width, height]: [u32; 2]) -> bool {
    const WIDTH: i64 = 8;
    const PERIOD: i64 = 32;
    let [width, height, pixel] = [width.into(), height.into(), pixel as i64];
    let from_centre = pixel % width + pixel / width - (width + height) / 2;
    (from_centre + WIDTH / 2).rem_euclid(PERIOD) < WIDTH
}

/// Returns those of `pixels` of a picture.
pub fn at(pixels: &[usize], picture: &[[f32; 4]]) -> Vec<[f32; 4]> {
    pixels.iter().map(|&pixel| picture[pixel]).collect()
}

/// Returns the picture with the colours of `pixels` alone: all others are black, and covered as they were.
pub fn only(pixels: &[usize], picture: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let mut rest: Vec<[f32; 4]> = picture.iter().map(|pixel| [0.0, 0.0, 0.0, pixel[3]]).collect();
    pixels.iter().for_each(|&pixel| rest[pixel] = picture[pixel]);
    rest
}

#[test]
fn a_quarter_of_a_picture_is_compared_in_each_of_its_parts() {
    for size in [[48, 36], [64, 48], [60, 45]] {
        let [width, height] = size.map(|n: u32| n as usize);
        let compared: Vec<usize> = (0..width * height).filter(|pixel| is_compared(*pixel, size)).collect();
        let share = compared.len() as f64 / (width * height) as f64;
        assert!(
            (0.22..0.34).contains(&share) && is_compared(height / 2 * width + width / 2, size),
            "{share}"
        );
        // Each row and each column has some.
        assert!((0..height).all(|y| compared.iter().any(|pixel| pixel / width == y)));
        assert!((0..width).all(|x| compared.iter().any(|pixel| pixel % width == x)));
    }
}

#[test]
fn the_measures_see_a_change_of_one_direction_and_of_one_channel() {
    let b = vec![1.0, 0.5, 1e-3, 2.0];
    assert_eq!(per_direction(&b, &b, 1e-6), 0.0);
    let mut a = b.clone();
    a[2] *= 1.1; // a faint one: no norm over all would see it
    assert!((per_direction(&a, &b, 1e-6) - 0.05).abs() < 1e-12);

    let picture = vec![[0.2, -0.1, 0.3, 1.0], [0.0, 0.0, 0.0, 0.0], [0.5, 0.4, 0.1, 1.0]];
    let mut red = picture.clone();
    red[0][0] += 0.02;
    assert!(channel(&red, &picture, 0) > 0.03);
    assert_eq!(channel(&red, &picture, 1), 0.0);
    assert!((colours(&red, &picture) - 0.02 / 0.56f64.sqrt()).abs() < 1e-6);
    // Swapped channels keep the luminance's order of size and must not pass.
    let swapped: Vec<_> = picture.iter().map(|p| [p[2], p[1], p[0], p[3]]).collect();
    assert!(channel(&swapped, &picture, 0) > 0.1 && colours(&swapped, &picture) > 0.1);
}

#[test]
#[should_panic(expected = "not finite")]
fn a_nan_is_never_close() {
    per_direction(&[f64::NAN], &[1.0], 1e-6);
}
