//! Colours of the materials of a mesh file, as one pigment: that of an object has one colour.

use glam::Vec3;
use std::collections::BTreeMap;

/// Largest number of materials whose triangles are counted; real files have far fewer.
const MAX_MATERIALS: usize = 1 << 12;

/// Numbers of triangles of each material, by name.
#[derive(Debug, Default)]
pub(super) struct MeshColors {
    triangles: BTreeMap<String, usize>,
}

/// Mean colour of the materials of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeanColor {
    /// Linear sRGB.
    pub color: Vec3,
    /// Number of different colours.
    pub colors: usize,
}

impl MeshColors {
    /// Counts `triangles` more triangles of the material of this name.
    pub fn add(&mut self, material: Option<&str>, triangles: usize) {
        let Some(name) = material else { return };
        if let Some(count) = self.triangles.get_mut(name) {
            *count += triangles;
        } else if self.triangles.len() < MAX_MATERIALS {
            self.triangles.insert(name.to_owned(), triangles);
        }
    }

    /// Returns the mean of the colours that `color_of` gives by name, weighted by triangles; `None` if it gives none.
    pub fn mean(&self, color_of: impl Fn(&str) -> Option<Vec3>) -> Option<MeanColor> {
        let given = self.triangles.iter().filter_map(|(name, count)| Some((color_of(name)?, *count)));
        let given: Vec<(Vec3, usize)> = given.filter(|(_, count)| *count > 0).collect();
        let total: usize = given.iter().map(|(_, count)| count).sum();
        let sum: Vec3 = given.iter().map(|(color, count)| *color * *count as f32).sum();
        let mut colors: Vec<[u32; 3]> =
            given.iter().map(|(color, _)| color.to_array().map(f32::to_bits)).collect();
        colors.sort_unstable();
        colors.dedup();
        (total > 0).then(|| MeanColor {
            // The mean of equal colours is that colour, without rounding.
            color: if colors.len() == 1 { given[0].0 } else { sum / total as f32 },
            colors: colors.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_count_by_their_triangles() {
        let mut colors = MeshColors::default();
        let of = |name: &str| match name {
            "red" => Some(Vec3::X),
            "blue" => Some(Vec3::Z),
            _ => None,
        };
        assert_eq!(colors.mean(of), None);
        colors.add(None, 5);
        colors.add(Some("without a colour"), 5);
        assert_eq!(colors.mean(of), None);
        colors.add(Some("red"), 3);
        assert_eq!(colors.mean(of), Some(MeanColor { color: Vec3::X, colors: 1 }));
        colors.add(Some("blue"), 1);
        assert_eq!(colors.mean(of), Some(MeanColor { color: Vec3::new(0.75, 0.0, 0.25), colors: 2 }));
    }
}
