//! Windows and copies against sums over every sample that the light sees.

use crate::plain::{
    MIRROR, amplitude, mirrored, rough, scaled, swapped, tiled, toward, upside_down, view_at, with_heights,
};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::reference::Reference;
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};

/// (u, v, w) and wavelength \[µm\] of oblique pairs of directions, near the mirror direction and far from it, and of the
/// first orders of `field`, the only directions in which a patch much smaller than its window is bright.
fn queries(field: &HeightField) -> Vec<(DVec3, f64)> {
    let lights = [toward(0.0, 0.0), toward(30.0, 15.0), toward(65.0, 200.0)];
    let uvs = [[0.0, 0.0], [0.011, -0.023], [-0.31, 0.17], [0.4, 0.52], [-0.02, -0.6]];
    let pairs = lights.into_iter().flat_map(|light| {
        uvs.into_iter().filter_map(move |uv| view_at(light, DVec2::from_array(uv)).map(|view| -light - view))
    });
    let period = DVec2::from_array(field.patch_size());
    let orders = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, -1.0]];
    let first = orders.map(|order| ((0.38 * DVec2::from_array(order) / period).extend(-1.1), 0.38));
    pairs.zip([0.38, 0.5, 0.61, 0.78].into_iter().cycle()).chain(first).collect()
}

fn power(field: &HeightField, coherence: Coherence, windows: [u32; 2], uvw: DVec3, wavelength: f64) -> f64 {
    Reference::new(field, coherence, windows, MIRROR).power(uvw, 1.0 / wavelength, 0.0, 1)[0]
}

/// The largest relative error of |P|² of `repeats(copies)` over `field` against a plain sum over a patch that really
/// holds so many copies of `truth`; and of `repeats(1×1)` over that patch.
fn repeats_deviation(field: &HeightField, truth: &HeightField, copies: [usize; 2]) -> f64 {
    let big = tiled(truth, copies);
    let whole = [0..big.columns() as i64, 0..big.rows() as i64];
    let coherence = Coherence::Repeats(copies.map(|n| n as u32));
    let errors = queries(truth).into_iter().map(|(uvw, wavelength)| {
        let direct = amplitude(&big, uvw, wavelength, whole.clone(), |_, _| 1.0).norm_sqr();
        // The tiled surface as one patch has to agree too.
        let one = power(&big, Coherence::Repeats([1, 1]), [1, 1], uvw, wavelength);
        let folded = power(field, coherence, [1, 1], uvw, wavelength);
        (folded / direct - 1.0).abs().max((one / direct - 1.0).abs())
    });
    errors.fold(0.0, f64::max)
}

/// Odd and even sample counts and pixels that are not square.
fn patches() -> [HeightField; 3] {
    [rough([6, 5], [0.1, 0.13], 0.3), rough([5, 8], [0.12, 0.09], 0.5), rough([9, 3], [0.095, 0.095], 0.2)]
}

/// Makes another surface of one.
type Spoil = fn(&HeightField) -> HeightField;

/// The ways to spoil a surface that every comparison has to notice.
const SPOILT: [(&str, Spoil); 5] = [
    ("one percent higher", |field| scaled(field, 1.01)),
    ("the wrong sign of w", |field| scaled(field, -1.0)),
    ("x and y exchanged", swapped),
    ("x mirrored", mirrored),
    ("y upside down", upside_down),
];

#[test]
fn repeats_are_the_plain_sum_over_a_surface_of_so_many_copies() {
    for patch in patches() {
        for copies in [[1, 1], [2, 3], [3, 2], [5, 4], [8, 7]] {
            let deviation = repeats_deviation(&patch, &patch, copies);
            // Rounding, amplified in the directions where the copies nearly cancel.
            assert!(deviation < 1e-9, "{copies:?}: {deviation}");
        }
    }
}

#[test]
fn the_repeats_check_fails_for_every_spoilt_surface() {
    for patch in patches() {
        for (how, spoil) in SPOILT {
            let deviation = repeats_deviation(&patch, &spoil(&patch), [3, 2]);
            assert!(deviation > 1e-3, "{how}: {deviation}");
        }
        // One copy too many.
        assert!(repeats_deviation(&tiled(&patch, [2, 1]), &patch, [3, 2]) > 0.1);
    }
}

/// The largest error of `repeats(copies)` around the peak φ_x = 2πj, φ_y = 2πl (and ± `offset` from it in both),
/// relative to n² m² times the patch's own |P|², against copies² × patch (exactly there) or the plain sum (beside it).
fn peak_deviation(copies: [usize; 2], offset: f64) -> f64 {
    let patch = rough([16, 14], [0.1, 0.12], 0.3);
    let [tx, ty] = patch.patch_size();
    let big = tiled(&patch, copies);
    let whole = [0..big.columns() as i64, 0..big.rows() as i64];
    let wavelength = 0.5;
    let gain = (copies[0] * copies[1]).pow(2) as f64;
    let mut worst = 0.0f64;
    for (j, l) in [(0, 0), (1, 0), (-2, 1), (3, -2), (-1, -3)] {
        // φ = k u T, so u = λ(j + offset/2π)/T.
        let place = |order: i32, period: f64| {
            wavelength * (f64::from(order) + offset / (2.0 * std::f64::consts::PI)) / period
        };
        let uvw = DVec3::new(place(j, tx), place(l, ty), -1.3);
        let fast = power(&patch, Coherence::Repeats(copies.map(|n| n as u32)), [1, 1], uvw, wavelength);
        assert!(fast.is_finite());
        let single = amplitude(&patch, uvw, wavelength, [0..16, 0..14], |_, _| 1.0).norm_sqr();
        let expected = if offset == 0.0 {
            gain * single
        } else {
            amplitude(&big, uvw, wavelength, whole.clone(), |_, _| 1.0).norm_sqr()
        };
        worst = worst.max((fast - expected).abs() / (gain * single));
    }
    worst
}

#[test]
fn repeats_peak_at_the_square_of_their_count_exactly_at_an_order_and_beside_it() {
    for copies in [[1, 1], [2, 2], [4, 3], [7, 10]] {
        for offset in [0.0, 1e-10, -1e-10, 1e-7, 1e-4, -1e-4, 0.01] {
            let deviation = peak_deviation(copies, offset);
            assert!(deviation < 1e-9, "{copies:?} at {offset}: {deviation}");
        }
    }
}

#[test]
fn a_thousand_copies_peak_at_their_square() {
    let patch = rough([16, 14], [0.1, 0.12], 0.3);
    let uvw = DVec3::new(0.5 * 2.0 / patch.patch_size()[0], 0.0, -1.3);
    let single = amplitude(&patch, uvw, 0.5, [0..16, 0..14], |_, _| 1.0).norm_sqr();
    let fast = power(&patch, Coherence::Repeats([1000, 1000]), [1, 1], uvw, 0.5);
    // φ is known to 1e-15 of itself, 4π; the kernel loses (nδφ)²/12 of its peak.
    assert!((fast / (1e12 * single) - 1.0).abs() < 1e-9);
}

/// The average over `windows` window centres of |P|² through a Gaussian of standard deviation `sigma`, by a sum over all
/// copies within 8σ.
fn brute_gaussian(field: &HeightField, sigma: f64, windows: [u32; 2], uvw: DVec3, wavelength: f64) -> f64 {
    let [dx, dy] = field.pixel_size();
    let [tx, ty] = field.patch_size();
    let mut sum = 0.0;
    for (i, j) in (0..windows[0]).flat_map(|i| (0..windows[1]).map(move |j| (i, j))) {
        let centre = [tx * f64::from(i) / f64::from(windows[0]), ty * f64::from(j) / f64::from(windows[1])];
        let samples = |axis: usize, step: f64, count: usize| {
            let middle = centre[axis] / step + count as f64 / 2.0;
            (middle - 8.0 * sigma / step) as i64 - 1..(middle + 8.0 * sigma / step) as i64 + 2
        };
        let seen = [samples(0, dx, field.columns()), samples(1, dy, field.rows())];
        let g = |x: f64, y: f64| {
            (-((x - centre[0]).powi(2) + (y - centre[1]).powi(2)) / (2.0 * sigma * sigma)).exp()
        };
        sum += amplitude(field, uvw, wavelength, seen, g).norm_sqr();
    }
    sum / f64::from(windows[0] * windows[1])
}

/// The largest error of the folded sum over `field` against the sum over all copies of `truth`, relative to each
/// direction's own value with a floor of 1e-8 of the mirror's peak.
fn gaussian_deviation(field: &HeightField, truth: &HeightField, sigma: f64, windows: [u32; 2]) -> f64 {
    let floor = 1e-8 * (2.0 * std::f64::consts::PI * sigma * sigma).powi(2);
    let errors = queries(truth).into_iter().map(|(uvw, wavelength)| {
        let direct = brute_gaussian(truth, sigma, windows, uvw, wavelength);
        let folded = power(field, Coherence::Gaussian { length: 4.0 * sigma }, windows, uvw, wavelength);
        (folded - direct).abs() / direct.max(floor)
    });
    errors.fold(0.0, f64::max)
}

/// Patches from a third of σ to eight times σ, the copies between none and hundreds.
fn gaussian_cases() -> [(HeightField, f64); 3] {
    [
        (rough([5, 4], [0.1, 0.13], 0.3), 1.5),
        (rough([16, 17], [0.1, 0.09], 0.4), 0.6),
        (rough([40, 44], [0.1, 0.09], 0.3), 0.5),
    ]
}

#[test]
fn the_folded_gaussian_is_the_sum_over_all_copies_in_sight() {
    for (patch, sigma) in gaussian_cases() {
        let deviation = gaussian_deviation(&patch, &patch, sigma, [1, 1]);
        // Cut at 7σ per axis, where g = 2e-11, in directions down to the floor, 1e-4 of the amplitude (seen: 1e-9).
        assert!(deviation < 1e-8, "{sigma}: {deviation}");
    }
}

#[test]
fn windows_average_the_power_over_shifted_centres() {
    for (patch, sigma) in gaussian_cases() {
        for windows in [[2, 1], [1, 3], [3, 2]] {
            let deviation = gaussian_deviation(&patch, &patch, sigma, windows);
            assert!(deviation < 1e-8, "{sigma} {windows:?}: {deviation}");
        }
    }
    // It does make a difference: one window is not the average.
    let (patch, sigma) = &gaussian_cases()[2];
    let (uvw, wavelength) = queries(patch)[3];
    let (one, six) = (
        brute_gaussian(patch, *sigma, [1, 1], uvw, wavelength),
        brute_gaussian(patch, *sigma, [3, 2], uvw, wavelength),
    );
    assert!((one / six - 1.0).abs() > 0.01);
}

#[test]
fn the_gaussian_check_fails_for_every_spoilt_surface() {
    for (patch, sigma) in gaussian_cases() {
        for (how, spoil) in SPOILT {
            let deviation = gaussian_deviation(&patch, &spoil(&patch), sigma, [2, 1]);
            assert!(deviation > 1e-3, "{how}, sigma {sigma}: {deviation}");
        }
    }
}

/// The largest relative error of 2 × 3 repeats of `field`, averaged over 3 × 2 windows, against plain sums over `truth`
/// cut out anew at each of the six places.
fn shifted_repeats_deviation(field: &HeightField, truth: &HeightField) -> f64 {
    let (columns, rows) = (truth.columns(), truth.rows());
    let places = (0..3).flat_map(|i| (0..2).map(move |j| (i, j)));
    let cut_out: Vec<HeightField> = places
        .map(|(i, j)| {
            // Thirds of the columns to the right, halves of the rows up.
            let (right, up) = (i * columns / 3, j * rows / 2);
            let moved = with_heights(truth, |c, r| truth.row((r + rows - up) % rows)[(c + right) % columns]);
            tiled(&moved, [2, 3])
        })
        .collect();
    let errors = queries(truth).into_iter().map(|(uvw, wavelength)| {
        let powers = cut_out.iter().map(|big| {
            let whole = [0..big.columns() as i64, 0..big.rows() as i64];
            amplitude(big, uvw, wavelength, whole, |_, _| 1.0).norm_sqr()
        });
        let direct = powers.sum::<f64>() / 6.0;
        (power(field, Coherence::Repeats([2, 3]), [3, 2], uvw, wavelength) / direct - 1.0).abs()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn windows_of_repeats_begin_at_shifted_samples() {
    let patch = rough([6, 8], [0.1, 0.12], 0.3);
    let deviation = shifted_repeats_deviation(&patch, &patch);
    assert!(deviation < 1e-9, "{deviation}");
    // Exchanged, its 8 columns could not be cut in thirds.
    for (how, spoil) in SPOILT.into_iter().filter(|(how, _)| *how != "x and y exchanged") {
        let deviation = shifted_repeats_deviation(&patch, &spoil(&patch));
        assert!(deviation > 1e-3, "{how}: {deviation}");
    }
}
