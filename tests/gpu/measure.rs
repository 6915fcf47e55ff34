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
