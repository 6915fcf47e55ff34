//! Corners of triangles, before and after normals and texture coordinates are completed.

use glam::{Vec2, Vec3};

/// Corner of a triangle as in a file. Normal and texture coordinates may be missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Position in model space; projected texture coordinates take y as up.
    pub position: [f32; 3],
    /// Normal of any length; missing or zero: the smooth one is computed.
    pub normal: Option<[f32; 3]>,
    /// Texture coordinates; missing: projected from the box side that the triangle faces, one unit per unit of length.
    pub uv: Option<[f32; 2]>,
}

/// A corner with unit normal and texture coordinates; only the tangent is missing.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompleteCorner {
    /// Position in model space.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
}
