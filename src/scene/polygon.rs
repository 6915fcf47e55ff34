//! Polygons cut into triangles.

use crate::error::{Error, Result};
use earcut::Earcut;
use glam::DVec3;

/// Largest number of corners of a face that no fan covers. Cutting a tangled face of this size takes about a second.
const MAX_CORNERS: usize = 1 << 14;

/// Number of corners from which on the time of a concave face counts.
const MANY_CORNERS: usize = 1 << 10;

/// Largest sum of the squares of the corners of such faces, which their time grows with: that of eight faces of the largest size.
const MOST_WORK: usize = 8 * MAX_CORNERS * MAX_CORNERS;

/// Sine of the smallest angle for which a triangle counts as turned over; thinner ones have no direction in `f32` and make no triangle of a
/// mesh.
const THINNEST: f64 = 1e-6;

/// Height of a triangle relative to the largest coordinate, below which its direction is the rounding of coordinates to `f32`: four times half a bit.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// Cutter of polygons, whose buffers are reused from one polygon to the next.
#[derive(Default)]
pub(super) struct PolygonCutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
    /// Sum of the squares of the corners of all large concave faces so far.
    work: usize,
}

impl PolygonCutter {
    /// Cuts the polygon `corners`, at least 3, into triangles. Returns corner indices, three a triangle, with the winding of the polygon.
    ///
    /// The triangles are a fan from the first corner if none of them is turned over, as in convex polygons. Otherwise they are ears, which
    /// every polygon has (Meisters 1975, "Polygons have ears"), seen along the axis that is nearest to the normal. Polygons without an area
    /// or that cross themselves have no inside, and some triangles cover them.
    ///
    /// # Errors
    /// A polygon that no fan covers, of more than [`MAX_CORNERS`] corners; too many large ones.
    pub fn cut(&mut self, corners: &[DVec3]) -> Result<&[u32]> {
        let normal: DVec3 = fan(corners.len()).map(|t| cross(corners, t)).sum();
        let rounding = ROUNDING * corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        if fan(corners.len()).all(|t| !is_turned_over(corners, t, normal, rounding)) {
            self.triangles.clear();
            self.triangles.extend(fan(corners.len()).flatten());
            return Ok(&self.triangles);
        }
        if corners.len() > MAX_CORNERS {
            return Err(Error::input(
                format!("a concave face has {} corners, more than {MAX_CORNERS}", corners.len()),
                "cut large faces into triangles before exporting",
            ));
        }
        if corners.len() >= MANY_CORNERS {
            self.work += corners.len() * corners.len();
        }
        if self.work > MOST_WORK {
            return Err(Error::input(
                format!(
                    "many concave faces of up to {} corners take too long",
                    corners.len().max(MANY_CORNERS)
                ),
                "cut large faces into triangles before exporting",
            ));
        }
        self.cut_ears(corners, normal);
        if self.triangles.is_empty() {
            self.triangles.extend(fan(corners.len()).flatten());
        }
        Ok(&self.triangles)
    }

    fn cut_ears(&mut self, corners: &[DVec3], normal: DVec3) {
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&corner| seen_along(normal, corner)));
        let no_holes: [u32; 0] = [];
        self.earcut.earcut(self.flat.iter().copied(), &no_holes, &mut self.triangles);
        for triangle in self.triangles.chunks_exact_mut(3) {
            let [a, b, c] = [0, 1, 2].map(|k| self.flat[triangle[k] as usize]);
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                triangle.swap(1, 2);
            }
        }
    }
}

/// Returns the corner indices of a fan from the first of `count` corners.
fn fan(count: usize) -> impl Iterator<Item = [u32; 3]> {
    (2..count as u32).map(|k| [0, k - 1, k])
}

/// Returns twice the area of a triangle, along its normal. Over a fan the sum is that of the polygon (Newell's normal).
fn cross(corners: &[DVec3], triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|k| corners[k as usize]);
    (b - a).cross(c - a)
}

/// Returns true if the triangle faces away from `normal` and is higher than `rounding`.
fn is_turned_over(corners: &[DVec3], triangle: [u32; 3], normal: DVec3, rounding: f64) -> bool {
    let [a, b, c] = triangle.map(|k| corners[k as usize]);
    let longest = [b - a, c - b, a - c].map(DVec3::length).into_iter().fold(0.0, f64::max);
    let least = longest * (THINNEST * longest).max(rounding);
    cross(corners, triangle).dot(normal) < -least * normal.length()
}

/// Projects onto the two coordinates across the axis that is nearest to `normal`, in the order in which the polygon is counter-clockwise.
/// The coordinates keep their values, so that corners in a line along an axis remain in a line.
fn seen_along(normal: DVec3, p: DVec3) -> [f64; 2] {
    let [x, y, z] = normal.abs().to_array();
    let (seen, is_along) = match () {
        () if z >= x && z >= y => ([p.x, p.y], normal.z > 0.0),
        () if y >= x => ([p.z, p.x], normal.y > 0.0),
        () => ([p.y, p.z], normal.x > 0.0),
    };
    if is_along { seen } else { [seen[1], seen[0]] }
}

#[cfg(test)]
#[path = "polygon_tests.rs"]
mod tests;
