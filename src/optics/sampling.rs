//! Directions within the band limit of a surface's samples.
//!
//! Samples dx apart hold frequencies up to 1/(2 dx), and a pair of directions needs |u|/λ and |v|/λ, each at most 2/λ. Beyond the band
//! limit the surface is taken as dark, never as the periodic copy that a discrete transform has there.

/// Tolerance for a spacing that was rounded to a few digits.
const ROUNDED: f64 = 1.001;

/// Limit of samples that are too far apart for some directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// `u` or `v`: the axis with the coarser sampling.
    pub axis: char,
    /// Distance between the samples of that axis \[µm\].
    pub spacing: f64,
    /// Largest |u| or |v| within the band limit at the shortest wavelength, less than 2.
    pub largest: f64,
    /// Distance between samples that would suffice for all directions \[µm\].
    pub needed: f64,
}

/// Returns the limit of samples `pixel_size` \[µm\] apart along x and y at wavelengths from `shortest` \[µm\]; `None` if every pair of
/// directions is within it.
pub fn limit(pixel_size: [f64; 2], shortest: f64) -> Option<Limit> {
    let [dx, dy] = pixel_size;
    let (axis, spacing) = if dy > dx { ('v', dy) } else { ('u', dx) };
    let needed = shortest / 4.0;
    (spacing > needed * ROUNDED).then_some(Limit {
        axis,
        spacing,
        largest: shortest / (2.0 * spacing),
        needed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_the_shortest_wavelength_holds_everything_and_more_does_not() {
        assert_eq!(limit([0.095, 0.08], 0.38), None);
        assert_eq!(limit([0.0951 * 0.9999, 0.095], 0.38), None, "95.09 nm are 95.1 nm rounded");
        assert!(limit([0.0952, 0.0952], 0.38).is_some());
        assert_eq!(limit([0.1375, 0.1375], 0.55), None);
    }

    #[test]
    fn the_coarser_axis_limits() {
        let along_x = limit([0.19, 0.1], 0.38).unwrap();
        assert_eq!((along_x.axis, along_x.spacing), ('u', 0.19));
        assert!((along_x.largest - 1.0).abs() < 1e-12 && (along_x.needed - 0.095).abs() < 1e-12);
        let along_y = limit([0.1, 0.38], 0.38).unwrap();
        assert_eq!((along_y.axis, along_y.largest), ('v', 0.5));
    }
}
