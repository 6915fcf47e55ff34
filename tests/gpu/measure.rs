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

/// Pixels of a picture that are compared for all, each with the root of the number of pixels that it stands for.
pub type Compared = Vec<(usize, f32)>;

/// Returns the pixels of `picture`, of this `size`, that are compared with a reference: the brightest, which hold nine tenths of all squared light, and of
/// the others a quarter, in bands that cross all rows and columns. The others count for all that are not bright, so that sums of squares over the compared
/// pixels are those over the picture.
pub fn compared(picture: &[[f32; 4]], size: [u32; 2]) -> Compared {
    const BRIGHT: f64 = 0.9;
    let light = |pixel: usize| picture[pixel][..3].iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
    let mut order: Vec<usize> = (0..picture.len()).collect();
    order.sort_by(|a, b| light(*b).total_cmp(&light(*a)));
    let whole: f64 = order.iter().map(|pixel| light(*pixel)).sum();
    let mut held = 0.0;
    let is_needed = |pixel: &&usize| {
        let is_needed = held < BRIGHT * whole;
        held += light(**pixel);
        is_needed
    };
    let count = order.iter().take_while(is_needed).count();
    let (bright, others) = order.split_at(count);
    let some: Vec<usize> = others.iter().copied().filter(|pixel| is_in_band(*pixel, size)).collect();
    let root = (others.len() as f32 / some.len().max(1) as f32).sqrt();
    let mut all: Compared = bright.iter().map(|&pixel| (pixel, 1.0)).collect();
    all.extend(some.into_iter().map(|pixel| (pixel, root)));
    all.sort_by_key(|(pixel, _)| *pixel);
    all
}

/// Returns true for a quarter of the pixels of a picture of `size`: diagonal bands 8 pixels wide and 24 apart, the middle of one of which runs through the
/// centre. Wide, so that few pixels beside them are shaded where samples count for their neighbours.
fn is_in_band(pixel: usize, [width, height]: [u32; 2]) -> bool {
    const WIDTH: i64 = 8;
    const PERIOD: i64 = 32;
    let [width, height, pixel] = [width.into(), height.into(), pixel as i64];
    let from_centre = pixel % width + pixel / width - (width + height) / 2;
    (from_centre + WIDTH / 2).rem_euclid(PERIOD) < WIDTH
}

/// Returns the `compared` pixels of a picture, the colours of each as bright as the norm over all takes them.
pub fn at(compared: &Compared, picture: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let scaled = |&(pixel, root): &(usize, f32)| {
        let [r, g, b, alpha] = picture[pixel];
        [r * root, g * root, b * root, alpha]
    };
    compared.iter().map(scaled).collect()
}

#[test]
fn compared_pixels_stand_for_all_and_see_what_is_missing_wherever_it_is() {
    let size = [64, 48];
    // A faint gradient with a bright spot that the bands miss.
    let spot = [40, 8];
    let picture: Vec<[f32; 4]> = (0..64 * 48)
        .map(|i| {
            let from = [i % 64 - spot[0], i / 64 - spot[1]].map(|x: i32| x.pow(2)).iter().sum::<i32>();
            [0.1 + 0.001 * (i % 64) as f32, 0.1, if from < 9 { 9.0 } else { 0.05 }, 1.0]
        })
        .collect();
    let all = compared(&picture, size);
    let share = all.len() as f64 / picture.len() as f64;
    assert!((0.2..0.4).contains(&share), "{share}");
    let stand: f32 = all.iter().map(|(_, root)| root * root).sum();
    assert!((stand / picture.len() as f32 - 1.0).abs() < 1e-3, "{stand}");
    let norm = |picture: &[[f32; 4]]| picture.iter().map(|p| p[0] * p[0] + p[2] * p[2]).sum::<f32>();
    // The pixels that are not the brightest hold a tenth.
    assert!((norm(&at(&all, &picture)) / norm(&picture) - 1.0).abs() < 0.1);
    // An error of every pixel is as large, and one of the spot or of a bright place of the reference alone is seen.
    let dim: Vec<_> = picture.iter().map(|p| [p[0] * 1.02, p[1], p[2], p[3]]).collect();
    let error = |a: &[[f32; 4]], b: &[[f32; 4]]| channel(&at(&all, a), &at(&all, b), 0);
    assert!((error(&dim, &picture) - 0.02).abs() < 1e-5);
    let without: Vec<_> = picture.iter().map(|p| [p[0], p[1], p[2].min(0.05), p[3]]).collect();
    let blue = |a: &[[f32; 4]], b: &[[f32; 4]]| channel(&at(&all, a), &at(&all, b), 2);
    assert!(blue(&without, &picture) > 0.9 && blue(&picture, &without) > 0.9);
    let of_dark = compared(&without, size);
    assert!(channel(&at(&of_dark, &without), &at(&of_dark, &picture), 0) < 1e-6);
    // Each row and each column has some.
    assert!((0..48).all(|y| all.iter().any(|(pixel, _)| pixel / 64 == y)));
    assert!((0..64).all(|x| all.iter().any(|(pixel, _)| pixel % 64 == x)));
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
