//! Surfaces, directions and sums, written from the definitions and nothing else.

use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;
use std::ops::Range;

/// A refractive index whose Schlick reflectance is 1 to 4e-15 in every direction, with Stam's factor.
pub const MIRROR: Reflectance = Reflectance::Schlick(1e15);

/// The surface z = `height`(x, y) \[µm\] about the patch centre, sampled at cell centres, the largest y in the first row.
pub fn surface(samples: [usize; 2], pixel: [f64; 2], height: impl Fn(f64, f64) -> f64) -> HeightField {
    let [columns, rows] = samples;
    let x = |c: usize| (c as f64 + 0.5 - columns as f64 / 2.0) * pixel[0];
    let y = |r: usize| (rows as f64 / 2.0 - r as f64 - 0.5) * pixel[1];
    let heights = (0..rows * columns).map(|i| height(x(i % columns), y(i / columns))).collect();
    HeightField::new(columns, rows, pixel, heights).unwrap()
}

/// The flat mirror.
pub fn flat(samples: [usize; 2], pixel: [f64; 2]) -> HeightField {
    surface(samples, pixel, |_, _| 0.0)
}

/// Independent heights in 0 … `height` \[µm\], without any symmetry that could hide a flip.
pub fn rough(samples: [usize; 2], pixel: [f64; 2], height: f64) -> HeightField {
    let mut state = 0x1234_5678_9abc_def0u64;
    let heights = (0..samples[0] * samples[1])
        .map(|_| {
            // xorshift64
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            height * (state >> 11) as f64 / (1u64 << 53) as f64
        })
        .collect();
    HeightField::new(samples[0], samples[1], pixel, heights).unwrap()
}

/// The same grid with another height at each (column, row).
pub fn with_heights(field: &HeightField, height: impl Fn(usize, usize) -> f64) -> HeightField {
    let (columns, rows) = (field.columns(), field.rows());
    let heights = (0..columns * rows).map(|i| height(i % columns, i / columns)).collect();
    HeightField::new(columns, rows, field.pixel_size(), heights).unwrap()
}

/// Every height times `factor`. A factor of −1 is the wrong sign of w.
pub fn scaled(field: &HeightField, factor: f64) -> HeightField {
    with_heights(field, |c, r| factor * field.row(r)[c])
}

/// The rows in the opposite order: y upside down.
pub fn upside_down(field: &HeightField) -> HeightField {
    with_heights(field, |c, r| field.row(field.rows() - 1 - r)[c])
}

/// The columns in the opposite order: x from right to left.
pub fn mirrored(field: &HeightField) -> HeightField {
    with_heights(field, |c, r| field.row(r)[field.columns() - 1 - c])
}

/// x and y exchanged: what lay along +x lies along +y.
pub fn swapped(field: &HeightField) -> HeightField {
    let (columns, rows) = (field.columns(), field.rows());
    let [dx, dy] = field.pixel_size();
    // New column c counts up the old y, new row r counts down the old x.
    let heights =
        (0..rows * columns).map(|i| field.row(rows - 1 - i % rows)[columns - 1 - i / rows]).collect();
    HeightField::new(rows, columns, [dy, dx], heights).unwrap()
}

/// `copies` of the patch side by side as one patch.
pub fn tiled(field: &HeightField, copies: [usize; 2]) -> HeightField {
    let (columns, rows) = (field.columns(), field.rows());
    let wide = columns * copies[0];
    let heights =
        (0..wide * rows * copies[1]).map(|i| field.row(i / wide % rows)[i % wide % columns]).collect();
    HeightField::new(wide, rows * copies[1], field.pixel_size(), heights).unwrap()
}

/// The view direction that makes (u, v) with `light`, where there is one above the horizon.
pub fn view_at(light: DVec3, uv: DVec2) -> Option<DVec3> {
    let across = -light.truncate() - uv;
    let rest = 1.0 - across.length_squared();
    (rest > 0.0).then(|| across.extend(rest.sqrt()))
}

/// The unit vector at polar angle `theta` and azimuth `phi` \[degrees\].
pub fn toward(theta: f64, phi: f64) -> DVec3 {
    let (theta, phi) = (theta.to_radians(), phi.to_radians());
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// P = dx dy Σ g e^{ik(ux + vy + wh)} over the samples `across` × `up` of the endlessly repeated patch, counted to the
/// right and UP from the patch's lower left one; `window` is g by the position from the patch centre \[µm\].
pub fn amplitude(
    field: &HeightField,
    uvw: DVec3,
    wavelength: f64,
    [across, up]: [Range<i64>; 2],
    window: impl Fn(f64, f64) -> f64,
) -> Complex64 {
    let (columns, rows) = (field.columns() as i64, field.rows() as i64);
    let [dx, dy] = field.pixel_size();
    let k = 2.0 * PI / wavelength;
    let mut sum = Complex64::ZERO;
    for j in up {
        let y = (j as f64 + 0.5 - rows as f64 / 2.0) * dy;
        let row = field.row((rows - 1 - j.rem_euclid(rows)) as usize);
        for i in across.clone() {
            let x = (i as f64 + 0.5 - columns as f64 / 2.0) * dx;
            let h = row[i.rem_euclid(columns) as usize];
            sum += Complex64::from_polar(window(x, y), k * (uvw.x * x + uvw.y * y + uvw.z * h));
        }
    }
    sum * (dx * dy)
}

/// J_m(x) by its power series, for |x| ≤ 6 good to 1e-13 (the largest term is below e⁶).
pub fn bessel(order: i32, x: f64) -> f64 {
    assert!(x.abs() <= 6.0, "the series cancels at {x}");
    let m = order.unsigned_abs();
    let first = (1..=m).fold(1.0, |term, j| term * x / 2.0 / f64::from(j));
    let (sum, _) = (1..60).fold((first, first), |(sum, term), k| {
        let next = -term * x * x / 4.0 / (f64::from(k) * f64::from(k + m));
        (sum + next, next)
    });
    if order < 0 && m % 2 == 1 { -sum } else { sum }
}

#[test]
fn the_bessel_functions_have_their_tabulated_values() {
    // Abramowitz & Stegun, table 9.1.
    for (order, x, value) in [
        (0, 1.0, 0.765_197_686_557_966_6),
        (1, 1.0, 0.440_050_585_744_933_5),
        (2, 2.0, 0.352_834_028_615_637_7),
        (0, 5.0, -0.177_596_771_314_338_3),
        (-1, 1.0, -0.440_050_585_744_933_5),
        (-2, -2.0, 0.352_834_028_615_637_7),
    ] {
        assert!((bessel(order, x) - value).abs() < 1e-13, "J_{order}({x}) = {}", bessel(order, x));
    }
}

#[test]
fn a_swapped_surface_has_its_x_slope_along_y() {
    let tilted = surface([4, 3], [0.1, 0.2], |x, y| x + 10.0 * y);
    let back = surface([3, 4], [0.2, 0.1], |x, y| y + 10.0 * x);
    let ours = swapped(&tilted);
    let apart = ours.heights().iter().zip(back.heights()).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-15);
}
