//! A rectangular grid of skin points, and OBJ text made of such grids.

use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::fmt::Write;

/// One point of a grid.
#[derive(Clone, Copy)]
pub struct Point {
    pub position: DVec3,
    pub normal: DVec3,
    pub uv: DVec2,
}

/// Rows of points; quads between neighbours face to the left of a row when the next row lies ahead.
pub struct SkinGrid {
    columns: usize,
    points: Vec<Point>,
}

impl SkinGrid {
    /// Samples `surface(column, row)`, both from 0 to 1, on `columns` × `rows` points. Its columns run along u and its
    /// rows along v; u × v points out of the surface. Normals are those of the function, not of the facets.
    pub fn sample(
        [columns, rows]: [usize; 2],
        surface: impl Fn(f64, f64) -> DVec3,
        uv: impl Fn(f64, f64) -> DVec2,
    ) -> Self {
        let d = 0.02;
        let mut points = Vec::with_capacity(columns * rows);
        for j in 0..rows {
            for i in 0..columns {
                let (x, y) = (i as f64 / (columns - 1) as f64, j as f64 / (rows - 1) as f64);
                let across = surface(x + d, y) - surface(x - d, y);
                let along = surface(x, y + d) - surface(x, y - d);
                let normal = across.cross(along).normalize_or(DVec3::Y);
                points.push(Point { position: surface(x, y), normal, uv: uv(x, y) });
            }
        }
        Self { columns, points }
    }
}

/// Collects grids as OBJ text: short decimals, shared texture coordinates, faces with absolute indices.
#[derive(Default)]
pub struct ObjText {
    text: String,
    uvs: HashMap<String, usize>,
    /// Positions written so far; as many normals.
    count: usize,
}

impl ObjText {
    pub fn new(header: &str) -> Self {
        let text = header.lines().map(|line| format!("# {line}\n")).collect();
        Self { text, ..Self::default() }
    }

    /// Starts a named object.
    pub fn object(&mut self, name: &str) {
        self.text += &format!("o {name}\n");
    }

    /// Appends one grid.
    pub fn push(&mut self, grid: &SkinGrid) {
        let uvs: Vec<usize> = grid.points.iter().map(|p| self.uv(p.uv)).collect();
        for p in &grid.points {
            self.line("v", &[p.position.x, p.position.y, p.position.z], 4);
        }
        for p in &grid.points {
            self.line("vn", &[p.normal.x, p.normal.y, p.normal.z], 3);
        }
        let (n, c) = (grid.points.len(), grid.columns);
        for j in 0..n / c - 1 {
            for i in 0..c - 1 {
                let k = j * c + i;
                self.text.push('f');
                for at in [k, k + 1, k + c + 1, k + c] {
                    // Indices of OBJ files start at 1.
                    let index = self.count + at + 1;
                    // Writing to a String cannot fail.
                    let _ = write!(self.text, " {index}/{}/{index}", uvs[at]);
                }
                self.text.push('\n');
            }
        }
        self.count += n;
    }

    pub fn finish(self) -> String {
        self.text
    }

    /// The number of a texture coordinate, written when new.
    fn uv(&mut self, uv: DVec2) -> usize {
        let key = format!("{} {}", decimal(uv.x, 3), decimal(uv.y, 3));
        let next = self.uvs.len() + 1;
        if let Some(&known) = self.uvs.get(&key) {
            return known;
        }
        self.text += &format!("vt {key}\n");
        self.uvs.insert(key, next);
        next
    }

    fn line(&mut self, tag: &str, values: &[f64], digits: usize) {
        self.text += tag;
        for &v in values {
            self.text.push(' ');
            self.text += &decimal(v, digits);
        }
        self.text.push('\n');
    }
}

/// Shortest fixed-point form: no zero before the point, none at the end, no "-0".
fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    match text.strip_prefix('-') {
        Some("0") => "0".into(),
        Some(rest) => format!("-{}", bare(rest)),
        None => bare(text).into(),
    }
}

fn bare(text: &str) -> &str {
    text.strip_prefix('0').filter(|rest| rest.starts_with('.')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_as_short_as_they_can_be() {
        let cases = [
            (0.5, ".5"),
            (-0.25, "-.25"),
            (1.0, "1"),
            (-0.00001, "0"),
            (10.0, "10"),
            (-3.1, "-3.1"),
            (0.0, "0"),
        ];
        for (value, text) in cases {
            assert_eq!(decimal(value, 3), text);
        }
    }

    #[test]
    fn a_flat_grid_is_written_with_shared_texture_coordinates_and_absolute_indices() {
        let grid = SkinGrid::sample([2, 2], |x, y| DVec3::new(x, y, 0.0), |x, _| DVec2::new(x, 0.0));
        let mut text = ObjText::new("flat");
        text.push(&grid);
        text.push(&grid);
        let text = text.finish();
        assert!(text.starts_with("# flat\nvt 0 0\nvt 1 0\nv 0 0 0\nv 1 0 0\n"), "{text}");
        assert!(text.contains("vn 0 0 1\n"));
        assert!(text.contains("f 1/1/1 2/2/2 4/2/4 3/1/3\n"), "{text}");
        assert!(text.ends_with("f 5/1/5 6/2/6 8/2/8 7/1/7\n"), "{text}");
    }
}
