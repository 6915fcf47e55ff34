//! Points of a regular grid as text (.xyz): x, y and height in metres, a point a line, in any order. y grows upwards.

use super::bytes::damaged;
use super::format::{Format, no_signature};
use super::scan::{Channel, Quantity, Scan, size, spacing};
use super::table::{self, TextTable};
use crate::error::{Error, Result};
use crate::memory;
use crate::notes::PreparationRecord;

/// Difference of equal coordinates, relative to the length of the axis.
const SAME: f64 = 1e-7;
/// Largest distance of a coordinate from its grid place, in steps: coordinates are written with few digits.
const AWAY: f64 = 0.1;
/// Smallest number of measured points of a grid, as a share of its nodes.
const FEWEST: f64 = 0.25;

/// The format.
pub const FORMAT: Format = Format {
    name: "xyz",
    title: "points",
    extensions: &["xyz"],
    signature: no_signature,
    is_by_name: true,
    read,
    facts: [
        "its own coordinates, in metres",
        "metres",
        "nodes without a point",
        "a regular grid in any order",
    ],
};

/// Reads the file in `bytes`. Nodes without a point were not measured.
///
/// # Errors
/// Those of [`table::parse`]; other than three numbers a line; points that are no regular grid.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    grid(&table::parse(&table::decoded(bytes))?)
}

/// Returns the grid of the points in `table`.
///
/// # Errors
/// See [`read`].
pub fn grid(table: &TextTable) -> Result<Scan<'static>> {
    if table.columns != 3 {
        return Err(Error::input(
            format!("has {} numbers a line", table.columns),
            "write x, y and height a line",
        ));
    }
    let points = table.numbers.len() / 3;
    memory::ensure_room(points as u64 * 3 * 8, "the points of a grid")?;
    let axis = |i: usize| XyzAxis::of(table.numbers.iter().skip(i).step_by(3).copied().collect());
    let [x, y] = [axis(0)?, axis(1)?];
    let size = size(x.count as u64, y.count as u64)?;
    let nodes = size[0] * size[1];
    if (points as f64) < FEWEST * nodes as f64 {
        return Err(no_grid());
    }
    memory::ensure_room(nodes as u64 * 8, "a grid of points")?;
    let mut samples = vec![f64::NAN; nodes];
    let mut met = vec![false; nodes];
    for point in table.numbers.chunks_exact(3) {
        let (column, up) = (x.index(point[0])?, y.index(point[1])?);
        let i = (size[1] - 1 - up) * size[0] + column;
        if std::mem::replace(&mut met[i], true) {
            return Err(Error::input("has two points at one place", "write every point of the grid once"));
        }
        samples[i] = point[2];
    }
    Ok(Scan::single(
        "points",
        Channel {
            name: "points".to_owned(),
            unit: "m".to_owned(),
            size,
            spacing: [spacing(x.step, 1), spacing(y.step, 1)],
            quantity: Quantity::Height,
            prepared: PreparationRecord::default(),
            decode: Box::new(move || Ok(samples)),
        },
    ))
}

/// Places along one axis: `count` of them, `step` apart.
struct XyzAxis {
    low: f64,
    /// Distance of neighbouring places; 0 for a single place.
    step: f64,
    count: usize,
}

impl XyzAxis {
    fn of(mut coordinates: Vec<f64>) -> Result<Self> {
        if coordinates.iter().any(|x| !x.is_finite()) {
            return Err(damaged("a coordinate is no number"));
        }
        coordinates.sort_unstable_by(f64::total_cmp);
        let (low, high) = (coordinates[0], coordinates[coordinates.len() - 1]);
        let same = SAME * (high - low);
        coordinates.dedup_by(|a, b| *a - *b <= same);
        let count = coordinates.len();
        let step = if count > 1 { (high - low) / (count - 1) as f64 } else { 0.0 };
        if !step.is_finite() {
            return Err(no_grid());
        }
        Ok(Self { low, step, count })
    }

    fn index(&self, x: f64) -> Result<usize> {
        if self.count == 1 {
            return Ok(0);
        }
        let place = (x - self.low) / self.step;
        let nearest = place.round();
        if (place - nearest).abs() > AWAY {
            return Err(no_grid());
        }
        Ok((nearest as usize).min(self.count - 1))
    }
}

fn no_grid() -> Error {
    Error::input("holds points that are no regular grid", "interpolate them to a grid first")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the heights of a grid, row by row from the top.
    fn heights(text: &str) -> Vec<f64> {
        read(text.as_bytes()).unwrap().channels.remove(0).samples().unwrap()
    }

    #[test]
    fn points_in_any_order_fill_the_grid_with_y_upwards() {
        let text = "x y z\n0 0 1\n2e-8 1e-8 6\n1e-8 0 2\n0 1e-8 4\n2e-8 0 3\n1e-8 1.0000001e-8 5\n";
        assert_eq!(heights(text), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
        let scan = read(text.as_bytes()).unwrap();
        assert_eq!((scan.channels[0].size, scan.channels[0].spacing[0]), ([3, 2], Some(1e-8)));
        let holes = heights("0,0,1\n1,0,2\n1,1,4\n");
        assert!(holes[0].is_nan() && holes[1..] == [4.0, 1.0, 2.0]);
    }

    #[test]
    fn points_that_are_no_grid_are_refused() {
        for text in [
            "0 0 1\n1 0 2\n3 0 3\n",
            "0 0 1\n0 0 2\n",
            "0 0\n1 1\n",
            "nan 0 1\n",
            "0 0 1\n1 1 1\n2 2 1\n3 3 1\n4 4 1\n",
        ] {
            assert!(read(text.as_bytes()).is_err(), "{text:?}");
        }
        let line = read(b"0 0 1\n1 0 2\n").unwrap();
        assert_eq!(line.channels[0].spacing[1], None, "one line has no distance of lines");
    }
}
