//! Turning a surface about its normal, so that its grooves are parallel to an axis.

use super::interpolate::Spline;
use crate::error::{Error, Result};
use crate::surface::transpose::transposed;
use crate::surface::{HeightField, statistics};
use crate::units;
use rayon::prelude::*;
use std::fmt;

/// Rotation of a surface about its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// Counter-clockwise by this angle, −360 … 360 \[degrees\].
    By(f64),
    /// By the smallest angle that makes the strongest grooves parallel to an axis.
    Auto,
}

/// Largest deviation from a quarter turn that counts as one \[degrees\]: samples change their places without interpolation.
const EXACT: f64 = 1e-9;

impl Rotation {
    /// Parses an angle, or `auto`.
    pub(super) fn parse(text: &str) -> Result<Self> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let angle = units::angle(text).map_err(|e| e.or("auto"))?;
        if angle.abs() <= 360.0 {
            return Ok(Self::By(angle));
        }
        Err(Error::usage(
            format!("the angle `{text}` is more than a turn"),
            "give -360deg to 360deg, or auto",
        ))
    }

    /// Returns the angle by which `field` is turned \[degrees\].
    ///
    /// # Errors
    /// No period that stands out of the spectrum, for [`Rotation::Auto`].
    pub fn angle(self, field: &HeightField) -> Result<f64> {
        match self {
            Self::By(angle) => Ok(angle),
            Self::Auto => {
                let across = statistics::wave_vector(field)?.ok_or_else(|| {
                    Error::input("no grooves stand out of the spectrum", "give the angle, as in 30deg")
                })?;
                let direction = across[1].atan2(across[0]).to_degrees();
                // To the nearest axis: at most an eighth of a turn.
                Ok((direction / 90.0).round() * 90.0 - direction)
            }
        }
    }

    /// Rotates `field`, and returns the largest upright rectangle in it, with the same distances between samples. A quarter turn keeps
    /// every sample; other angles interpolate by cubic splines.
    pub(super) fn apply(self, field: &HeightField) -> Result<HeightField> {
        let angle = self.angle(field)?;
        let quarters = (angle / 90.0).round();
        if (angle - 90.0 * quarters).abs() < EXACT {
            return quarter_turns(field, quarters.rem_euclid(4.0) as usize);
        }
        turned(field, angle.to_radians())
    }
}

impl fmt::Display for Rotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::By(angle) => write!(f, "{angle}deg"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

fn quarter_turns(field: &HeightField, quarters: usize) -> Result<HeightField> {
    let (columns, rows) = (field.columns(), field.rows());
    let [dx, dy] = field.pixel_size();
    let backwards = |heights: Vec<f64>| heights.into_iter().rev().collect::<Vec<_>>();
    // Columns as rows is a mirror image about a diagonal; upside down, it is a quarter turn counter-clockwise.
    let upside_down = |lines: Vec<f64>| lines.chunks(rows).rev().flatten().copied().collect::<Vec<_>>();
    match quarters {
        1 => HeightField::new(rows, columns, [dy, dx], upside_down(transposed(columns, field.heights()))),
        2 => HeightField::new(columns, rows, [dx, dy], backwards(field.heights().to_vec())),
        3 => {
            let turned = upside_down(transposed(columns, field.heights()));
            HeightField::new(rows, columns, [dy, dx], backwards(turned))
        }
        _ => Ok(field.clone()),
    }
}

/// Returns `field` turned counter-clockwise by `angle` \[radians\].
fn turned(field: &HeightField, angle: f64) -> Result<HeightField> {
    let [dx, dy] = field.pixel_size();
    let last = [field.columns() - 1, field.rows() - 1].map(|n| n as f64);
    // Between the outermost samples heights are known, beyond them they are not.
    let [width, height] = inscribed([last[0] * dx, last[1] * dy], angle);
    let samples = |length: f64, spacing: f64| (length / spacing * (1.0 + 1e-12)) as usize + 1;
    let (columns, rows) = (samples(width, dx), samples(height, dy));
    let (sin, cos) = angle.sin_cos();
    let spline = Spline::new(field);
    let mut heights = vec![0.0; columns * rows];
    heights.par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
        let y = ((rows - 1) as f64 / 2.0 - row as f64) * dy;
        for (column, h) in out.iter_mut().enumerate() {
            let x = (column as f64 - (columns - 1) as f64 / 2.0) * dx;
            // Position in the field before the rotation.
            let (u, v) = (cos * x + sin * y, cos * y - sin * x);
            *h = spline.at(
                (u / dx + last[0] / 2.0).clamp(0.0, last[0]),
                (last[1] / 2.0 - v / dy).clamp(0.0, last[1]),
            );
        }
    });
    HeightField::new(columns, rows, field.pixel_size(), heights)
}

/// Returns the width and height of the largest upright rectangle in one of `size` that is turned by `angle` \[radians\].
///
/// Its corners touch the turned sides: all four of them, w|cos| + h|sin| = W and w|sin| + h|cos| = H, or, where that rectangle would leave
/// the turned one, two opposite corners the middle of the long sides.
fn inscribed(size: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = (angle.sin().abs(), angle.cos().abs());
    let [width, height] = size;
    let (long, short) = (width.max(height), width.min(height));
    if short <= 2.0 * sin * cos * long || (sin - cos).abs() < 1e-9 {
        let half = short / 2.0;
        return if width >= height { [half / sin, half / cos] } else { [half / cos, half / sin] };
    }
    let determinant = cos * cos - sin * sin;
    [(width * cos - height * sin) / determinant, (height * cos - width * sin) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::PreparationStep;
    use crate::surface::prepare::tests::{difference, field};
    use std::f64::consts::TAU;

    fn rotate(text: &str, field: &HeightField) -> HeightField {
        PreparationStep::parse(&format!("rotate {text}")).unwrap().apply(field).unwrap()
    }

    #[test]
    fn quarter_turns_move_samples_counter_clockwise_and_four_are_none() {
        let surface = field(3, 2, |x, y| 10.0 * x + y);
        let quarter = rotate("90deg", &surface);
        assert_eq!((quarter.columns(), quarter.rows(), quarter.pixel_size()), (2, 3, [0.07, 0.1]));
        // The right column becomes the top row, and the top row the left column.
        assert_eq!(quarter.row(0), [surface.row(0)[2], surface.row(1)[2]]);
        let same = |a: &HeightField, b: &HeightField| {
            assert_eq!(
                (a.columns(), a.pixel_size(), a.heights()),
                (b.columns(), b.pixel_size(), b.heights())
            );
        };
        same(&rotate("90deg", &quarter), &rotate("180deg", &surface));
        same(&rotate("90deg", &rotate("180deg", &surface)), &rotate("-90deg", &surface));
        same(&rotate("90deg", &rotate("270deg", &surface)), &surface);
        same(&rotate("360deg", &surface), &surface);
    }

    #[test]
    fn a_turned_surface_is_the_surface_seen_from_a_turned_frame() {
        let surface = |x: f64, y: f64| 0.2 * (2.0 * x).sin() + 0.1 * (3.0 * y).cos() + 0.05 * x;
        let flat = field(80, 90, surface);
        for degrees in [20.0, -37.0, 45.0, 110.0] {
            let turned = rotate(&format!("{degrees}deg"), &flat);
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let expected = HeightField::new(
                turned.columns(),
                turned.rows(),
                turned.pixel_size(),
                (0..turned.heights().len())
                    .map(|i| (turned.x(i % turned.columns()), turned.y(i / turned.columns())))
                    .map(|(x, y)| surface(cos * x + sin * y, cos * y - sin * x))
                    .collect(),
            );
            // Cubic splines, and at the edges their reflection, which bends the slope there.
            assert!(difference(&turned, &expected.unwrap()) < 3e-3, "{degrees}");
        }
    }

    #[test]
    fn the_inscribed_rectangle_is_the_largest_that_fits() {
        for size in [[4.0, 3.0], [3.0, 4.0], [10.0, 1.0], [2.0, 2.0]] {
            for degrees in [1.0, 20.0, 45.0, 60.0, 89.0] {
                let angle = f64::to_radians(degrees);
                let (sin, cos) = angle.sin_cos();
                let fits = |w: f64, h: f64| {
                    w * cos + h * sin <= size[0] * (1.0 + 1e-9) && w * sin + h * cos <= size[1] * (1.0 + 1e-9)
                };
                let [w, h] = inscribed(size, angle);
                assert!(fits(w, h), "{size:?} {degrees}");
                // No rectangle of a fine grid of shapes that fits is larger.
                for n in 1..400 {
                    let w2 = size[0].hypot(size[1]) * f64::from(n) / 400.0;
                    let h2 = ((size[0] - w2 * cos) / sin).min((size[1] - w2 * sin) / cos);
                    assert!(h2 <= 0.0 || w2 * h2 <= w * h * (1.0 + 1e-9), "{size:?} {degrees}: {w2} x {h2}");
                }
            }
        }
    }

    #[test]
    fn grooves_are_found_within_a_tenth_of_a_degree_and_turned_to_the_nearest_axis() {
        for degrees in [3.3, -17.8, 44.0, 46.0, 80.5, 121.7] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let grooves = field(200, 260, |x, y| 0.1 * (TAU * (x * cos + y * sin) / 0.9).sin() + 0.02 * x);
            let angle = Rotation::Auto.angle(&grooves).unwrap();
            let expected = (degrees / 90.0).round() * 90.0 - degrees;
            let off = (angle - expected + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() < 0.1, "{degrees}: {angle} and not {expected}");
            let straight = rotate("auto", &grooves);
            let again = Rotation::Auto.angle(&straight).unwrap();
            assert!(again.abs() < 0.1, "{degrees}: {again}");
        }
    }

    #[test]
    fn a_surface_without_grooves_asks_for_the_angle() {
        let e = PreparationStep::parse("rotate auto").unwrap().apply(&field(60, 60, |x, y| x * x + y)).err();
        assert!(e.as_ref().is_some_and(|e| e.to_string().contains("rotate auto: no grooves")), "{e:?}");
    }
}
